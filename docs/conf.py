"""How the pages are built: ``make docs`` does not run the examples, ``make docs-full`` does and draws pictures."""
# ruff: noqa: E402

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
os.environ.setdefault("MPLBACKEND", "Agg")

import _api
from _gallery import WrittenPictures, arguments

import directrix

project = "directrix"
author = "directrix developers"
copyright = author
version = release = directrix.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["_build", "gallery/*.ipynb", "gallery/*.py", "**/GALLERY_HEADER.rst"]
templates_path = ["_templates"]
suppress_warnings = ["config.cache", "myst.xref_missing"]  # pages link to files of the repository as well
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(?!directrix).*"),  # other libraries, words of docstrings
    ("py:.*", r"directrix\.(kernels|formulations)\..*"),  # named in docstrings, and on no page
]
smartquotes = False

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3

autodoc_typehints = "none"
autodoc_member_order = "bysource"
autosummary_generate = True
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

sphinx_gallery_conf = {
    "examples_dirs": str(HERE.parent / "examples"),
    "gallery_dirs": "gallery",
    "filename_pattern": r"/[a-z]\w*\.py$",
    "ignore_pattern": r"_command",
    "reset_argv": arguments,
    "image_scrapers": (WrittenPictures(),),
    "capture_repr": (),
    "within_subsection_order": "ExampleTitleSortKey",
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "remove_config_comments": True,
    "plot_gallery": "True",
    "reset_modules": (),
    "min_reported_time": 1e9,
    "write_computation_times": False,
}

html_theme = "pydata_sphinx_theme"
html_title = f"directrix {release}"
html_static_path = ["_static"]
html_css_files = ["directrix.css"]
html_sidebars = {"*": []}  # pages that are no folder have nothing to list
html_show_sourcelink = False
html_copy_source = False
html_context = {"default_mode": "light"}
html_theme_options = {
    "show_prev_next": True,
    "navbar_end": ["theme-switcher"],
    "header_links_before_dropdown": 4,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "navigation_with_keys": False,
    "show_toc_level": 2,
}


def bars(app: object, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """|x| is a size here, not a substitution of reStructuredText."""
    literal = False
    for k, line in enumerate(lines):
        if line.strip() and not line.startswith(" "):
            literal = False
        if not literal:
            lines[k] = line.replace("|", r"\|")
        literal = literal or line.endswith("::")


def setup(app: Any) -> None:
    """Write the list of public objects before anything is read."""
    _api.write(HERE / "api.rst")
    app.connect("autodoc-process-docstring", bars, priority=400)  # before numpydoc makes another text of it
