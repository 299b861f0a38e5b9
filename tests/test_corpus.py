"""Files that released versions wrote are still read, and mean what they meant; ``make corpus`` writes these."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import directrix as dx
from directrix.schema import load_case

CORPUS = Path(__file__).parent / "corpus"
VERSIONS = sorted(p for p in CORPUS.iterdir() if p.is_dir() and p.name[0].isdigit())
FILES = [path for version in VERSIONS for path in sorted(version.iterdir())]


def files(*endings: str) -> list[Path]:
    return [p for p in FILES if p.name.endswith(endings) and not p.name.endswith((".run.json", "known.json"))]


def known(path: Path, result: dx.Result) -> None:
    """The number that is known of a result is in it."""
    numbers = json.loads((path.parent / "known.json").read_text("utf-8"))
    if path.name.split(".")[0] in numbers:
        node, quantity, expected = numbers[path.name.split(".")[0]]
        np.testing.assert_allclose(getattr(result.node(node), quantity)[-1], expected, atol=1e-7)


def test_this_version_has_its_files() -> None:
    assert dx.__version__ in {version.name for version in VERSIONS}, "run make corpus"
    assert sum(p.stat().st_size for p in FILES) <= 2 * 2**20
    looked_at = {*files(".vtkhdf"), *files(".toml", ".json"), *(p for p in FILES if "run.json" in p.name)}
    assert {p.name for p in set(FILES) - looked_at} <= {"known.json", *(p.name for p in FILES if p.suffix == ".csv")}


@pytest.mark.parametrize("path", files(".vtkhdf"), ids=lambda p: f"{p.parent.name}/{p.name}")
def test_a_result_is_read(path: Path) -> None:
    result = dx.load(path)
    assert result.r.shape == (len(result.t), len(result.mesh.r0), 3)
    assert result.rod("rod").force.shape[-1] == 6
    assert result.success == (path.stem != "failed")
    known(path, result)
    if path.stem == "mode":
        np.testing.assert_allclose(result.r[0], result.r[-1], atol=1e-12)  # one period
    if path.stem == "hinge":
        assert np.abs(result.energy.residual).max() < 1e-10 and result.joint("pivot").force.shape == (len(result.t), 3)
        assert result.link("stay").length[0] == pytest.approx(4.0)
    if path.stem == "floor":
        assert np.ptp(result.contact("floor").gap) == pytest.approx(0.02, abs=1e-9)
    if path.stem == "path":
        assert 1.0 in result.load_factor


@pytest.mark.parametrize("path", files(".toml", ".json"), ids=lambda p: f"{p.parent.name}/{p.name}")
def test_a_case_is_read_and_runs(path: Path) -> None:
    result = load_case(path).run()
    assert result.success
    known(path, result)


@pytest.mark.parametrize("path", [p for p in FILES if "run.json" in p.name], ids=lambda p: f"{p.parent.name}/{p.name}")
def test_what_a_run_said_is_read(path: Path) -> None:
    said = json.loads(path.read_text("utf-8"))
    assert said["program"] == "directrix" and said["info"]["directrix"] == path.parent.name
    assert said["status"]["success"] and said["audit"]["passed"]
    rows = list(csv.reader(path.with_name(path.name.replace("run.json", "monitor.csv")).open(encoding="utf-8")))
    assert len(rows) > 1 and len({len(row) for row in rows}) == 1
