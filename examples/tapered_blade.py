"""Tapered and twisted blade
=========================

A tapered blade, straight and twisted by 90°: frequencies and deflection against published and independent numbers.

A cantilever of constant width whose height falls linearly to half has the first frequencies
ω = λ √(EI0/ρA0)/L², λ = 3.8238, 18.3173, 47.2648 (Euler–Bernoulli, as Downs tabulates them, J. Appl. Mech. 44 (1977)
737–742; here Ritz's method with polynomials finds them again). Such a
blade, slender, is made with ``dx.taper``: stiffness is taken at the stress points and mass within the elements, so the
convergence is that of the uniform rod. Then it is twisted by 90° from root to tip. Its tip under a force is compared
with the linear equations of a rod, integrated along the blade by quadrature: what the section forces do to the tip.

    python examples/tapered_blade.py [--elements 16] [--out FOLDER]
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.linalg import eigh

import directrix as dx

E, NU, RHO, LENGTH, WIDTH, HEIGHT, TWIST = 70e9, 0.3, 2700.0, 4.0, 0.06, 0.03, np.pi / 2
DOWNS = (3.8238, 18.3173, 47.2648)
FORCE = np.array([20.0, 15.0, 0.0])


def section(fraction: float) -> dx.Section:
    """Height along d2 falls to half."""
    return dx.Section.rectangle(WIDTH, HEIGHT * (1.0 - 0.5 * fraction), E=E, nu=NU, rho=RHO)


def blade(elements: int, twist: float) -> dx.Model:
    """Along z, clamped at the root."""
    axis = dx.line((0, 0, 0), (0, 0, LENGTH), d1=(1, 0, 0))
    return (
        dx.Model(name="tapered blade")
        .rod(axis, dx.taper(section), name="blade", ends=("root", "tip"), elements=elements, twist=twist)
        .clamp("root")
    )


def ritz(count: int = 3, degree: int = 14) -> np.ndarray:
    """λ of the straight taper: w = ξ² Σ c_k P_k(2ξ − 1), ∫h³ w″² dξ over ∫h w² dξ stationary, h = 1 − ξ/2."""
    Plain, Legendre = np.polynomial.Polynomial, np.polynomial.Legendre
    shapes = [Plain([0, 0, 1]) * Legendre.basis(k, domain=[0, 1]).convert(kind=Plain) for k in range(degree)]
    xi, w = np.polynomial.legendre.leggauss(40)
    x, w = 0.5 * (1.0 + xi), 0.5 * w
    h = 1.0 - 0.5 * x
    bent, moved = np.array([p.deriv(2)(x) for p in shapes]), np.array([p(x) for p in shapes])
    return np.sqrt(eigh((bent * w * h**3) @ bent.T, (moved * w * h) @ moved.T, eigvals_only=True)[:count])


def linear_tip(twist: float) -> np.ndarray:
    """Displacement of the tip under FORCE: ∫ Jᵀ C⁻¹ J dz F, J F the section forces at z, by Gauss points."""
    xi, w = np.polynomial.legendre.leggauss(60)
    tip = np.zeros(3)
    for z, weight in zip(0.5 * LENGTH * (1.0 + xi), 0.5 * LENGTH * w, strict=True):
        c, s = np.cos(twist * z / LENGTH), np.sin(twist * z / LENGTH)
        frame = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        arm = LENGTH - z
        J = np.concatenate([frame, frame @ np.array([[0.0, -arm, 0.0], [arm, 0.0, 0.0], [0.0, 0.0, 0.0]])])
        tip += weight * J.T @ np.linalg.solve(section(z / LENGTH).stiffness, J @ FORCE)
    return tip


def main(*, elements: int = 16, out: str | None = None) -> dict[str, float]:
    """λ of the straight blade beside Downs's, the twisted one's tip beside the linear equations."""
    straight, twisted = blade(elements, 0.0), blade(elements, TWIST)
    frequencies = np.sort(dx.modes(straight, count=8).frequencies)
    scale = 2.0 * np.pi * LENGTH**2 / np.sqrt(E * HEIGHT**2 / 12.0 / RHO)
    flap = [frequencies[np.argmin(np.abs(frequencies * scale - known))] * scale for known in DOWNS]
    small = 1e-4
    run = dx.solve_static(twisted.force("tip", small * FORCE), steps=1, raise_on_failure=True)
    tip, known = run.node("tip").displacement[-1] / small, linear_tip(TWIST)
    far = dx.solve_static(twisted.force("tip", 20.0 * FORCE), steps=5, raise_on_failure=True)
    found = {f"λ{k + 1}, of Downs's": float(value / DOWNS[k]) for k, value in enumerate(flap)}
    found |= {f"tip {c}": float(v) for c, v in zip("xy", tip, strict=False)}
    found |= {f"linear {c}": float(v) for c, v in zip("xy", known, strict=False)}
    found["tip, relative error"] = float(np.linalg.norm(tip - known) / np.linalg.norm(known))
    for name, value in found.items():
        print(f"{name:<22} {value:.9g}")
    if out is not None:
        path = Path(out) / "tapered_blade.png"
        draw(far, path)
        print(path)
    return found


def draw(far: dx.Result, path: Path) -> None:
    """The twisted blade under a large force, its sections to scale, over the undeformed one."""
    from matplotlib import pyplot as plt
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    figure = plt.figure(figsize=(7, 6), layout="constrained")
    space = figure.add_subplot(projection="3d")
    rod = far.mesh.rods[0]
    for at, color in ((0, "#c3cad1"), (-1, "#1f5fa8")):
        r, D = far.r[at, rod.nodes], far.directors("blade")[at]
        rings = []
        for k, s in enumerate(rod.s / LENGTH):
            outline = 3.0 * section(float(s)).outline
            rings.append(r[k] + outline @ D[k][:, :2].T)
        faces = [[a[i], a[(i + 1) % 4], b[(i + 1) % 4], b[i]] for a, b in pairwise(rings) for i in range(4)]
        space.add_collection3d(Poly3DCollection(faces, facecolor=color, edgecolor="#1b2733", lw=0.3, alpha=0.9))
    every = far.r[[0, -1]].reshape(-1, 3)
    low, high = every.min(axis=0) - 0.2, every.max(axis=0) + 0.2
    space.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(0, LENGTH), xlabel="x", ylabel="y", zlabel="z")
    space.set(xticks=(0.0, 0.4), yticks=(0.0, 0.5))
    space.set_title("twisted by 90°, sections three times their size")
    space.set_aspect("equal")
    figure.savefig(path, dpi=130)


def test_a_tapered_blade_vibrates_as_downs_says_and_bends_as_the_linear_equations_say() -> None:
    assert np.allclose(ritz(), DOWNS, atol=6e-5)
    found = main(elements=12)
    for k in (1, 2, 3):
        assert abs(found[f"λ{k}, of Downs's"] - 1.0) <= 2e-3
    assert found["tip, relative error"] <= 2e-4


if __name__ == "__main__":
    from _command import run

    run(main)
