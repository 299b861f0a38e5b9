"""Form finding
============

Form finding: a cable drawn straight that hangs, and a flat slack net that is pulled into a saddle.

The cable is 1.2 long and its end is put at a distance of 1 all at once; it falls into the catenary. The net of 6 × 6
meshes lies flat; its rim is lifted to a saddle at once, which stretches it. Beside the net stands the same one
of pin-jointed bars, found by a general minimiser from the energy alone. Both shapes are starts of later runs: the
lowest frequencies of the tight net are printed.

    python examples/form_finding.py [--out FOLDER]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.optimize import brentq, minimize

import directrix as dx

EA, RIM, HEIGHT = 1e4, 1.0, 0.1


def cable(EI: float = 1e-4, elements: int = 40, length: float = 1.2) -> dx.Model:
    """Straight along x between A and B, which is then moved to x = 1; a unit load per length downwards."""
    section = dx.Section.from_moduli(EA=EA, GA1=EA, GA2=EA, EI1=EI, EI2=EI, GJ=EI)
    axis = dx.line((0, 0, 0), (length, 0, 0))
    model = dx.Model(name="cable").rod(
        axis, section, name="cable", ends=("A", "B"), elements=elements, nodes={"M": 0.5}
    )
    model = model.fix("A", "x", "y", "z", "rx", "ry").fix("B", "rx", "ry")
    return model.prescribe("B", displacement=(1.0 - length, 0, 0)).distributed("cable", (0, -1, 0))


def sag(length: float = 1.2) -> float:
    """Of the catenary without stretch."""
    a = brentq(lambda a: 2.0 * a * np.sinh(0.5 / a) - length, 0.05, 10.0)
    return float(a * (np.cosh(0.5 / a) - 1.0))


def saddle(meshes: int) -> dict[tuple[int, int], np.ndarray]:
    """Where the crossings on the rim go: a hyperbolic paraboloid over the square, pulled outwards by 2 %."""
    at = np.linspace(-0.5, 0.5, meshes + 1) * RIM
    rim: dict[tuple[int, int], np.ndarray] = {}
    for i, x in enumerate(at):
        for j, y in enumerate(at):
            if i in (0, meshes) or j in (0, meshes):
                rim[i, j] = np.array([0.02 * x, 0.02 * y, 4.0 * HEIGHT * (x * x - y * y)])
    return rim


def net(meshes: int = 6, EI: float = 0.15) -> dx.Model:
    """Cables that cross and are joined where they do, three quadratic elements from one crossing to the next.

    Elements of length h under tension T need T h² < 24 EI, else they fold in ways that a cable does not know.
    """
    section = dx.Section.from_moduli(EA=EA, GA1=EA, GA2=EA, EI1=EI, EI2=EI, GJ=EI, A_rho=1.0, I_rho1=1e-6, I_rho2=1e-6)
    at, model = np.linspace(-0.5, 0.5, meshes + 1) * RIM, dx.Model(name="net")
    for i in range(meshes + 1):
        for j in range(meshes + 1):
            for k, m in ((i + 1, j), (i, j + 1)):
                on_rim = (i == k and i in (0, meshes)) or (j == m and j in (0, meshes))
                if k <= meshes and m <= meshes and not on_rim:
                    axis = dx.line((at[i], at[j], 0), (at[k], at[m], 0))
                    model = model.rod(axis, section, ends=(f"{i},{j}", f"{k},{m}"), elements=3)
    corners = {(i, j) for i in (0, meshes) for j in (0, meshes)}
    for (i, j), to in saddle(meshes).items():
        if (i, j) not in corners:
            model = model.prescribe(f"{i},{j}", displacement=to)
    return model


def bars(meshes: int = 6) -> np.ndarray:
    """Crossings (meshes + 1, meshes + 1, 3) of the same net of pin-jointed bars, from its energy alone."""
    at = np.linspace(-0.5, 0.5, meshes + 1) * RIM
    r0 = np.stack([*np.meshgrid(at, at, indexing="ij"), np.zeros((meshes + 1,) * 2)], axis=-1)
    fixed, rest = r0.copy(), RIM / meshes
    for (i, j), to in saddle(meshes).items():
        fixed[i, j] += to

    def energy(inner: np.ndarray) -> tuple[float, np.ndarray]:
        r, slope, total = fixed.copy(), np.zeros_like(fixed), 0.0
        r[1:-1, 1:-1] = inner.reshape(meshes - 1, meshes - 1, 3)
        for a, b, to_a, to_b in (
            (r[:-1, 1:-1], r[1:, 1:-1], slope[:-1, 1:-1], slope[1:, 1:-1]),
            (r[1:-1, :-1], r[1:-1, 1:], slope[1:-1, :-1], slope[1:-1, 1:]),
        ):
            length = np.linalg.norm(b - a, axis=-1, keepdims=True)
            total += float(np.sum(0.5 * EA / rest * (length - rest) ** 2))
            pull = EA / rest * (length - rest) * (b - a) / length
            to_b += pull
            to_a -= pull
        return total, slope[1:-1, 1:-1].ravel()

    found = minimize(energy, r0[1:-1, 1:-1].ravel(), jac=True, method="BFGS", options={"gtol": 1e-7, "maxiter": 5000})
    out = fixed.copy()
    out[1:-1, 1:-1] = found.x.reshape(meshes - 1, meshes - 1, 3)
    return out


def apart(result: dx.Result, meshes: int) -> float:
    """Largest distance of a crossing of the net from that of the bars, over the height of the rim."""
    other = bars(meshes)
    inner = [(i, j) for i in range(1, meshes) for j in range(1, meshes)]
    return max(float(np.linalg.norm(result.node(f"{i},{j}").r[-1] - other[i, j])) for i, j in inner) / HEIGHT


def main(*, meshes: int = 6, out: str | None = None) -> dict[str, float]:
    """Sag over that of the catenary, and how far the net is from its bars."""
    hanging, tight = dx.form_find(cable()), dx.form_find(net(meshes))
    print(hanging.status)
    print(tight.status)
    found = {"sag": -float(hanging.node("M").r[-1, 1]) / sag(), "apart": apart(tight, meshes)}
    print(f"sag of the cable over that of the catenary {found['sag']:.6f}")
    print(f"the net is within {found['apart']:.1e} of its height of the net of bars")
    print(f"lowest frequencies of the net {np.round(dx.modes(net(meshes), about=tight, count=3).frequencies, 3)}")
    if out is not None:
        path = Path(out) / "form_finding.png"
        draw(hanging, tight, path)
        print(path)
    return found


def draw(hanging: dx.Result, tight: dx.Result, path: Path) -> None:
    """The cable beside the catenary, and the net before and after."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(12, 5), layout="constrained")
    left = figure.add_subplot(1, 2, 1)
    for k, colour, label in ((0, "#7d8791", "start"), (-1, "#1f6fb4", "found")):
        left.plot(*hanging.r[k, hanging.mesh.rod("cable").nodes, :2].T, color=colour, lw=2, label=label)
    a = brentq(lambda a: 2.0 * a * np.sinh(0.5 / a) - 1.2, 0.05, 10.0)
    x = np.linspace(0, 1, 21)
    left.plot(x, a * (np.cosh((x - 0.5) / a) - np.cosh(0.5 / a)), "k+", label="catenary")
    left.set(aspect="equal", title="a cable that was straight")
    left.legend(frameon=False)
    pen = figure.add_subplot(1, 2, 2, projection="3d")
    for rod in tight.mesh.rods:
        pen.plot(*tight.r[-1, rod.nodes].T, color="#1f6fb4", lw=1.6)
        pen.plot(*tight.mesh.r0[rod.nodes].T, color="#c9ced3", lw=0.8)
    pen.set_box_aspect((1, 1, 0.5), zoom=1.2)
    pen.view_init(elev=22, azim=-55)
    pen.set_axis_off()
    pen.set_title("a net that was flat")
    figure.savefig(path, dpi=150)
    plt.close(figure)


def test_the_net_is_that_of_bars() -> None:
    tight = dx.form_find(net(4))
    assert tight.success and tight.stability is not None and tight.stability.stable[-1]
    assert apart(tight, 4) < 5e-3
    assert dx.modes(net(4), about=tight, count=1).stable


if __name__ == "__main__":
    from _command import run

    run(main)
