"""Notebooks show valid HTML in which every name is text, and how far a run is."""

from __future__ import annotations

import sys
from dataclasses import replace
from html.parser import HTMLParser
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from fake_result import fake_result

import directrix as dx
from directrix import notebook

NASTY = "<script>alert('x')</script> & \"q\" é"


class Reader(HTMLParser):
    """Refuses what is not nested; keeps the texts of cells and the elements."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.words: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert len({name for name, _ in attrs}) == len(attrs)
        self.open.append(tag)
        self.tags.add(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag in ("polyline", "circle")
        self.tags.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def read(shown: str) -> Reader:
    ElementTree.fromstring(shown)  # well-formed as XML, which is stricter
    page = Reader(shown)
    assert page.tags <= {"div", "table", "caption", "b", "tbody", "tr", "th", "td", "svg", "polyline", "circle", "text"}
    return page


def frame(name: str) -> dx.Model:
    rod = dx.Section.circle(radius=0.1, E=1.0, nu=0.3, rho=1e-6)
    model = dx.Model(name=name).rod(dx.line((0, 0, 0), (1, 0, 0)), rod, name="a", ends=(name, "b"), elements=4)
    return (
        model.rod(dx.line((1, 0, 0), (1, 1, 0)), rod, name="c", ends=("b", "d"), elements=2)
        .clamp(name)
        .gravity((0, 0, -1))
    )


def test_a_model(monkeypatch: pytest.MonkeyPatch) -> None:
    page = read(frame(NASTY)._repr_html_())
    said = dict(zip(page.words[1::2], page.words[2::2], strict=False))
    assert page.words[0] == NASTY and NASTY in page.words[1:]
    assert (said["rods"], said["elements"], said["supports"], said["loads"]) == ("2", "6", "1", "1")
    assert "joints" not in said
    assert "polyline" in page.tags
    assert "svg" not in read(dx.Model()._repr_html_()).tags  # nothing to draw is no fault


@pytest.mark.parametrize("case", ["dynamic", "fails", "static", "broken"])
def test_a_result(case: str) -> None:
    result = fake_result(
        "static" if case == "static" else "dynamic", fails=case == "fails", title=NASTY, planar=case == "static"
    )
    mesh = replace(result.mesh, node_names={NASTY: 0, "C": 15})
    r = result.r.copy()
    r[-1] *= np.nan if case == "broken" else 1.0
    page = read(replace(result, mesh=mesh, r=r)._repr_html_())
    assert page.words[0] == NASTY
    assert page.words.count(NASTY) == (1 if case == "broken" else 2)
    assert ("svg" in page.tags) == (case != "broken")
    assert any(word.startswith("NOT DONE: Newton" if case == "fails" else "done: Reached") for word in page.words)
    assert result.audit.verdict in page.words


def test_the_sketch_is_in_its_frame() -> None:
    result = fake_result()
    svg = ElementTree.fromstring(
        notebook.sketch([result.r[k] for k in (0, 39)], [result.mesh.r0], {"n": result.r[39, 3]})
    )
    lines = [e for e in svg if e.tag.endswith("polyline")]
    points = np.array([[float(x) for x in spot.split(",")] for e in lines for spot in e.attrib["points"].split()])
    assert len(lines) == 3
    assert points.min() >= notebook.MARGIN - 0.1
    assert (points.max(axis=0) <= np.array([notebook.WIDTH, notebook.HEIGHT]) - notebook.MARGIN + 0.1).all()
    assert np.isclose(np.ptp(points, axis=0)[1], notebook.HEIGHT - 2 * notebook.MARGIN, atol=0.2)  # as large as can be


def test_progress_in_a_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stand-in for IPython: one display, written over."""
    shown: list[str] = []

    def display(value: Any, display_id: bool) -> Any:
        assert display_id
        shown.append(value)
        return SimpleNamespace(update=shown.append)

    ours = SimpleNamespace(
        get_ipython=lambda: SimpleNamespace(kernel=1), display=SimpleNamespace(HTML=str, display=display)
    )
    monkeypatch.setitem(sys.modules, "IPython", ours)
    monkeypatch.setitem(sys.modules, "IPython.display", ours.display)
    monkeypatch.setattr(notebook, "find_spec", lambda _: True)
    monkeypatch.setattr(notebook, "EVERY", 0.0)
    progress = notebook.shower()
    progress(0.25, "t = <1>")
    progress(1.0, "t = 4")
    assert len(shown) == 2
    assert shown[0].startswith('<progress max="1" value="0.2500"') and "25%" in shown[0] and "t = &lt;1&gt;" in shown[0]
    assert shown[1].endswith("100% t = 4")


def test_progress_true(capsys: pytest.CaptureFixture[str]) -> None:
    result = dx.solve_static(frame("a"), 2, progress=True)
    assert result.success
    said = capsys.readouterr().err.splitlines()
    assert said[-1].startswith("100%  load factor 1, step 2, ")
    with pytest.raises(dx.ModelError, match="cannot be called"):
        dx.solve_static(frame("a"), 2, progress="yes")  # type: ignore[arg-type]
