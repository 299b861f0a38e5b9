"""2.7 A cantilever rolled up ten times and pulled out of its plane (Ibrahimbegović 1997).

End moment 200πλ about z and force 50λ along z, both dead. Linear director elements turn too far between their nodes
here (100 of them carry at most 8 turns): quadratic ones are used.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import directrix as dx
from directrix.verification.models import cantilever, equilibrium, plane_section
from directrix.verification.record import Case, Check, Values
from directrix.verification.references import shoot

SOURCE = "Ibrahimbegović 1997, data"
SECTION = plane_section(100.0, 1e4, 1e4)
# λ: position of the tip
TIP: dict[float, Values] = {
    0.05: (0.711481, 6.285664, 2.750736),
    0.1: (0.410203, 0.053771, -1.091729),
    0.2: (0.115061, 0.008362, -0.598497),
    0.25: (0.025765, 1.272718, 0.520651),
    0.3: (0.052396, 0.002594, -0.399593),
    0.4: (0.029732, 0.001112, -0.293394),
    0.5: (0.019107, 0.000574, -0.226637),
    0.6: (0.013299, 0.000334, -0.180119),
    0.7: (0.009784, 0.000211, -0.145321),
    0.75: (0.002853, 0.424394, 0.206426),
    0.8: (0.007497, 0.000141, -0.117905),
    0.9: (0.005927, 0.000099, -0.095436),
    1.0: (0.004803, 0.000072, -0.076442),
}
GENTLE: Values = (-0.99850836, 3.72756107, 0.19575136)  # an eighth of a turn and F = 1/16: displacement


def _gentle() -> Iterator[Check]:
    force, moment = (0.0, 0.0, 1.0 / 16.0), (0.0, 0.0, 2.5 * np.pi)
    form = shoot(np.diag(SECTION.stiffness), 10.0, force=force, moment=moment).r - (10.0, 0.0, 0.0)
    yield Check.printed("λ_M = 1/8, F = 1/16: shooting", SOURCE, "C", GENTLE, form, 8)
    model = cantilever(SECTION, 10.0, 32).force("tip", force).moment("tip", moment)
    got = equilibrium(model).node("tip").displacement[-1]
    yield Check.of("λ_M = 1/8, F = 1/16, 32 quadratic: displacement", SOURCE, "C", form, got, 1e-5)


def _rolled() -> Iterator[Check]:
    model = cantilever(SECTION, 10.0, 100).force("tip", (0, 0, 50)).moment("tip", (0, 0, 200 * np.pi))
    result = dx.solve_static(model, steps=400, raise_on_failure=True)
    for factor, known in TIP.items():
        got = result.node("tip").r[round(400 * factor)]
        judged = 1e-3 if factor <= 0.5 else None
        yield Check.of(f"λ = {factor:g}, 100 quadratic: tip", SOURCE, "C", known, got, judged, scale=10.0)


def _geodesic() -> Iterator[Check]:
    model = cantilever(SECTION, 10.0, 100, 1).force("tip", (0, 0, 25)).moment("tip", (0, 0, 100 * np.pi))
    result = dx.solve_static(model, steps=200, formulation=dx.CrisfieldJelenic(), raise_on_failure=True)
    for factor, known in TIP.items():
        if factor <= 0.5:
            got = result.node("tip").r[round(400 * factor)]
            yield Check.of(f"λ = {factor:g}, 100 linear: tip", SOURCE, "C", known, got, 1e-3, scale=10.0)


CASES = (
    Case("helix-gentle", "2.7", "A cantilever bent and pulled out of its plane", _gentle),
    Case("helix", "2.7", "A cantilever rolled up ten times and pulled out of its plane", _rolled),
    Case("helix-linear", "2.7", "The same by linear elements of Crisfield and Jelenić", _geodesic),
)
