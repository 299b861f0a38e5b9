"""2.3 Cantilever under a follower force normal to its tip section (Argyris 1981; Simo & Vu-Quoc 1986)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import directrix as dx
from directrix.result import NodeHistory
from directrix.verification.models import cantilever, plane_section
from directrix.verification.record import Case, Check, Values
from directrix.verification.references import follower

SOURCE = "Argyris 1981, data"
LENGTH, EI, EA, GA = 100.0, 3.5e7, 3.23076e8, 1.61538e8
LAST, STEPS = 134e3, 67
# force: displacement of the tip (axial, transverse) and its rotation, with EA and GA
TIP: dict[float, Values] = {
    10e3: (-41.692934, 71.109313, 1.34023447),
    20e3: (-92.029211, 75.385749, 2.29448627),
    40e3: (-106.994662, 50.374572, 3.08797619),
    60e3: (-85.767947, 40.063339, 3.04816813),
    80e3: (-60.370351, 21.633623, 2.57230599),
    100e3: (-50.754194, -11.626070, 1.87503909),
    120e3: (-64.968263, -40.405889, 1.16169105),
    134e3: (-80.163576, -49.525101, 0.74059916),
}
RIGID: dict[float, Values] = {
    10e3: (-41.687449, 71.107005, 1.34022708),
    20e3: (-92.020049, 75.391928, 2.29446096),
    40e3: (-106.994184, 50.396027, 3.08795908),
    60e3: (-85.768203, 40.096669, 3.04820238),
    80e3: (-60.352085, 21.676294, 2.57242774),
    100e3: (-50.702998, -11.595577, 1.87528792),
    120e3: (-64.898736, -40.417119, 1.16204660),
    134e3: (-80.101310, -49.569312, 0.74097186),
}


def _tip(EA: float, GA: float) -> NodeHistory:
    model = cantilever(plane_section(EI, EA, GA), LENGTH, 80).force("tip", (0, LAST, 0), follower=True)
    return dx.solve_static(model, steps=STEPS, raise_on_failure=True).node("tip")


def _run() -> Iterator[Check]:
    for table, EA_, GA_, name in ((TIP, EA, GA, "EA, GA"), (RIGID, 1e7 * EI, 1e7 * EI, "inextensible")):
        tip = _tip(EA_, GA_)
        for force, known in table.items():
            form = np.array(follower(force, EI, EA_, GA_, LENGTH))
            what = f"P = {force:g}, {name}"
            yield Check.of(f"{what}: integration from the tip", SOURCE, "C", known, form, 1e-8)
            k = round(force / LAST * STEPS)
            got = tip.displacement[k]
            yield Check.of(f"{what}, 80 quadratic: u, v, w", SOURCE, "C", (*form[:2], 0.0), got, 1e-5, scale=LENGTH)
            turn = (np.cos(form[2]), np.sin(form[2]))
            yield Check.of(f"{what}, 80 quadratic: cos θ, sin θ", SOURCE, "C", turn, tip.R[k, :2, 0], 1e-5, scale=1.0)


CASES = (Case("follower", "2.3", "Cantilever under a follower force", _run),)
