"""What the gallery needs: an example draws when it is given --out, and what it writes there is its picture."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

FOLDER = Path(tempfile.gettempdir()) / "directrix-gallery"


def arguments(gallery_conf: Any, script_vars: Any) -> list[str]:
    """The command line of an example."""
    source = Path(script_vars["src_file"])
    if "out: str | None" not in source.read_text("utf-8"):
        return []
    folder = FOLDER / source.stem
    shutil.rmtree(folder, ignore_errors=True)
    return ["--out", str(folder)]


class WrittenPictures:
    """A scraper: the PNG files that an example has written."""

    def __repr__(self) -> str:
        return "WrittenPictures"

    def __call__(self, block: Any, block_vars: Any, gallery_conf: Any) -> str:
        from sphinx_gallery.scrapers import figure_rst

        places = []
        for picture in sorted((FOLDER / Path(block_vars["src_file"]).stem).glob("*.png")):
            place = next(block_vars["image_path_iterator"])
            shutil.move(picture, place)
            places.append(place)
        return figure_rst(places, gallery_conf["src_dir"])
