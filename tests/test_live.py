"""A run that is watched is the same run, and what it is doing can be seen while it goes on."""

from __future__ import annotations

import json
import socket
from dataclasses import fields
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import numpy as np
import pytest
from browser import MISSING, Browser
from case_texts import swing_case
from typer.testing import CliRunner

import directrix as dx
from directrix.cli import app
from directrix.telling import line, time_left
from directrix.viewer import live
from directrix.viewer.live import Live

CASE = 'title = "a swing"\n' + swing_case()


def swing() -> dx.Model:
    rubber = dx.Section.circle(radius=0.01, E=5e6, nu=0.5, rho=1100)
    model = dx.Model(name="swing").rod(
        dx.line((0, 0, 0), (1, 0, 0)), rubber, name="rod", ends=("pin", "tip"), elements=3
    )
    return model.pin("pin").gravity((0, 0, -9.81))


def arrays(result: dx.Result) -> dict[str, bytes]:
    found = {f.name: getattr(result, f.name) for f in fields(result)}
    found |= {f.name: getattr(result.energy, f.name) for f in fields(result.energy)}
    return {name: value.tobytes() for name, value in found.items() if isinstance(value, np.ndarray)}


def asked(url: str, **headers: str) -> Any:
    with urlopen(Request(url, headers=headers), timeout=20) as answer:
        return answer.read().decode("utf-8")


def test_watching_changes_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    alone = dx.simulate(swing(), t_end=0.2, dt=0.01)
    monkeypatch.setattr(live, "INSTANTS_AT_MOST", 8)
    seen: list[tuple[float, str]] = []
    states: list[dict[str, Any]] = []

    def look(done: float, text: str) -> None:
        seen.append((done, text))
        states.append(json.loads(asked(f"{page.url}state?after=0")))

    with Live(then=look) as page:
        assert "being prepared" in asked(page.url)
        result = dx.simulate(swing(), t_end=0.2, dt=0.01, progress=page)
        page.finish(result)
        last = json.loads(asked(f"{page.url}state?after=3"))
    assert arrays(result) == arrays(alone)
    assert len(seen) == 20 and seen[-1][0] == 1.0
    assert "step 20" in seen[-1][1] and "energy error" in seen[-1][1]
    runs = [state["page"]["runs"][0] for state in states]
    assert [run["instants"] for run in runs] == list(range(2, 22))
    assert max(run["frames"] for run in runs) == 8  # thinned as it grew
    assert runs[5]["verdict"] == "" and not states[5]["over"]
    assert last["over"] and last["page"]["runs"][0]["verdict"] == result.audit.verdict
    assert last["page"]["runs"][0]["frames"] == 21
    weights = 1.0 / 6.0  # three elements of two points
    assert np.allclose(weights * result.density.sum(axis=1), result.energy.stored, rtol=1e-12, atol=1e-18)


def test_the_server_answers_this_machine_alone() -> None:
    with Live() as page:
        for url, headers in ((page.url, {"Host": "elsewhere.example"}), (f"{page.url}../etc/passwd", {})):
            with pytest.raises(HTTPError, match=r"40[34]"):
                asked(url, **headers)
        assert asked(f"{page.url}favicon.ico") == ""
        assert json.loads(asked(f"{page.url}state?after=x"))["done"] == 0.0
        port = page.server.server_address[1]
        with pytest.raises(dx.ModelError, match=f"port {port} cannot be used"):
            Live(port)
        page.waiting.clear()
    with pytest.raises(OSError), socket.create_connection(("127.0.0.1", port), 1):
        pass


def test_run_watch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setenv("BROWSER", "none")
    monkeypatch.setattr("webbrowser.open", opened.append)
    (tmp_path / "swing.toml").write_text(CASE, "utf-8")
    outcomes = [
        CliRunner().invoke(
            app, ["run", str(tmp_path / "swing.toml"), "--no-view", "--out", str(tmp_path / name), *more]
        )
        for name, more in (("plain", []), ("watched", ["--watch"]))
    ]
    assert [o.exit_code for o in outcomes] == [0, 0], outcomes[1].output
    (url,) = opened
    assert f"watch it at {url}\n" in outcomes[1].output
    assert "100%  t = 0.2, step 20" in outcomes[1].output
    plain, watched = (dx.load(tmp_path / name / "result.vtkhdf") for name in ("plain", "watched"))
    assert arrays(plain) == arrays(watched)


@pytest.mark.skipif(bool(MISSING), reason=MISSING)
def test_an_open_page_follows_the_run(chromium: Browser, pictures: Path) -> None:
    with Live() as page:
        result = dx.simulate(swing(), t_end=0.2, dt=0.01, progress=page)
        with page.lock:
            late, page.instants = page.instants[5:], page.instants[:5]
        with chromium.open(page.url, width=640, height=480) as shown:
            assert "The run goes on" in shown.run("part('runs').textContent")
            assert shown.run("[runs[0].frames, clock.last]") == [5, 4]
            with page.lock:
                page.instants += late
                page.count += 1
            shown.wait("clock.last === 20 && seen.u === 20")
            shown.run("stop(3)")
            page.finish(result)
            page.over = True
            shown.wait("part('line').textContent.includes('has ended')")
            assert shown.run("seen.u") == 3  # whoever looks at something else is left alone
            assert result.audit.verdict in shown.run("part('runs').textContent")
            shown.picture(pictures / "live.png")
            assert shown.errors == []


def test_lines() -> None:
    assert line("t =", 0.5, [3, 7], energy=2.5, error=3e-16) == (
        "t = 0.5, step 2, 7 iterations, energy error 3e-16, H = 2.5"
    )
    assert line("load factor", 1.0, [4], cuts=2) == "load factor 1, step 1, 4 iterations, 2 cuts"
    assert [time_left(done, 10.0) for done in (0.0, 0.5, 0.01, 0.001, 1.0)] == [
        "", "10 s left", "16 min left", "2 h 46 min left", "",
    ]  # fmt: skip
