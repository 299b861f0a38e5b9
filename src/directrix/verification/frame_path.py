"""The exact hinged frame in its plane, by shooting: equilibria at a load, at a displacement, limit points.

From the foot of the column the section force n = (n1, n2) and the turn θ0 are unknown, and so is the load P; the
moment there is zero. Integrated over column and beam, the far end must be at the hinge and free of moment. The fourth
condition says which point of the path is meant.
"""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from directrix.verification.references import solve

Array = NDArray[np.float64]

__all__ = ["ExactFrame", "State"]

SIDE, PLACE = 120.0, 24.0


@dataclass(frozen=True)
class State:
    """A point of the path: ``unknowns`` (4,) = n1, n2, θ0, P; ``u`` to the right and ``v`` down at the load."""

    unknowns: Array
    u: float
    v: float

    @property
    def load(self) -> float:
        """P."""
        return float(self.unknowns[3])


@dataclass(frozen=True)
class ExactFrame:
    """Column from (0, 0) up, beam to the right, both 120 long; P acts down on the beam, 24 from the corner."""

    EA: float
    GA: float
    EI: float

    def _march(self, unknowns: Array, tight: bool) -> tuple[Array, Array]:
        """For unknowns (k, 4), in units of ``_scale``: what should vanish (k, 3), displacements at the load (k, 2)."""
        z = unknowns * self._scale()
        k = len(z)
        y = np.zeros((k, 4))
        y[:, 2] = 0.5 * np.pi + z[:, 2]
        y = self._integrate(y, z[:, :2], SIDE, tight)
        y[:, 2] -= 0.5 * np.pi
        y = self._integrate(y, z[:, :2], PLACE, tight)
        at_load = np.stack([y[:, 0] - PLACE, SIDE - y[:, 1]], axis=1)
        beyond = z[:, :2] + np.stack([np.zeros(k), z[:, 3]], axis=1)
        y = self._integrate(y, beyond, SIDE - PLACE, tight)
        end = np.stack([y[:, 0] - SIDE, y[:, 1] - SIDE, y[:, 3] * SIDE / self.EI], axis=1)
        return end, at_load

    def _integrate(self, y: Array, n: Array, length: float, tight: bool) -> Array:
        """Rod equations for (x, y, θ, m) of k rods (k, 4) under the section forces ``n`` (k, 2)."""
        k = len(y)

        def slope(_: float, flat: Array) -> Array:
            theta, m = flat.reshape(4, k)[2:]
            c, s = np.cos(theta), np.sin(theta)
            axial = 1.0 + (c * n[:, 0] + s * n[:, 1]) / self.EA
            shear = (-s * n[:, 0] + c * n[:, 1]) / self.GA
            dx, dy = c * axial - s * shear, s * axial + c * shear
            return np.concatenate([dx, dy, m / self.EI, dy * n[:, 0] - dx * n[:, 1]])

        options: dict[str, Any] = {"rtol": 1e-12, "atol": 1e-12} if tight else {"rtol": 1e-8, "atol": 1e-8}
        found: Any = solve_ivp(slope, (0.0, length), y.T.ravel(), method="DOP853", **options)
        return found.y[:, -1].reshape(4, k).T

    def _scale(self) -> Array:
        force = self.EI / SIDE**2
        return np.array([force, force, 1.0, force])

    def _find(self, condition: Callable[[Array, Array], Array], guess: Array, tight: bool = True) -> State:
        """The state for which ``condition(unknowns, displacements)``, (k, 4), (k, 2) → (k,), vanishes as well."""
        scale = self._scale()

        def residual(rows: Array) -> Array:
            end, at_load = self._march(rows, tight)
            return np.concatenate([end / SIDE, condition(rows * scale, at_load)[:, None]], axis=1)

        unknowns = solve(residual, guess / scale, tolerance=1e-10 if tight else 1e-6)
        _, at_load = self._march(unknowns[None], tight)
        return State(unknowns * scale, float(at_load[0, 0]), float(at_load[0, 1]))

    def path(self, last_load: float, step: float = 4.0, most: int = 400) -> list[State]:
        """The primary path, roughly integrated, until the load passes ``last_load`` (above the maximum).

        Steps have a length in the space of u, v and the load (in units of EI/4 SIDE²); sharp bends are taken in halves.
        """
        unit = self._scale()[3] / 4.0
        start = self._find(lambda _, at: (at[:, 1] - 1.0) / SIDE, np.zeros(4), tight=False)
        states = [State(np.zeros(4), 0.0, 0.0), start]
        reach = step
        while len(states) < most and not (len(states) > 2 and states[-1].load > last_load):
            a, b = states[-2:]
            here = np.array([b.u, b.v, b.load / unit])
            way = here - np.array([a.u, a.v, a.load / unit])
            size = float(np.linalg.norm(way))

            def ahead(
                z: Array, at: Array, here: Array = here, direction: Array = way / size, reach: float = float(reach)
            ) -> Array:
                return ((np.column_stack([at, z[:, 3] / unit]) - here) @ direction - reach) / SIDE

            try:
                found = self._find(ahead, b.unknowns + (b.unknowns - a.unknowns) * reach / size, tight=False)
            except ArithmeticError:
                reach *= 0.5
                continue
            states.append(found)
            reach = min(step, 2.0 * reach)
        return states

    def at_load(self, load: float, near: State) -> State:
        """The equilibrium at a load, near a state."""
        scale = self._scale()[3]
        return self._find(lambda z, _: (z[:, 3] - load) / scale, near.unknowns)

    def limits(self, path: Sequence[State]) -> list[State]:
        """Where the load turns back along a path: maxima and minima over the displacement u."""
        loads = np.array([s.load for s in path])
        turns = np.flatnonzero(np.diff(np.sign(np.diff(loads))) != 0) + 1
        found: list[State] = []
        for k in map(int, turns):
            sign = -1.0 if loads[k] > loads[k - 1] else 1.0
            last = path[k]

            def load(u: float, start: State = path[k], sign: float = sign) -> float:
                return sign * self._at(u, start).load

            ends = sorted((path[k - 1].u, path[k + 1].u))
            best: Any = minimize_scalar(load, bounds=ends, method="bounded", options={"xatol": 1e-5})
            found.append(self._at(float(best.x), last))
        return found

    def _at(self, u: float, near: State) -> State:
        return self._find(lambda _, at: (at[:, 0] - u) / SIDE, near.unknowns)
