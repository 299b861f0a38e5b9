"""Steady spin: what inertia does in a frame that turns at a constant rate about an axis.

Positions and directors are x = Q(t) y, and the mass M is constant in these coordinates, so the kinetic energy is
½ (ẏ + Ω×y)·M (ẏ + Ω×y): a potential −½ (Ω×y)·M (Ω×y), whose force is centrifugal, and a gyroscopic term 2 M Ω×ẏ. A
steady spin is an equilibrium under the centrifugal force.
"""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from directrix.errors import ModelError
from directrix.formulations.attached import BodyElement
from directrix.groups import Group
from directrix.hessian import Hessian
from directrix.kernels import step as kernel
from directrix.newton import Newton
from directrix.rotations import hat

Array = NDArray[np.float64]

__all__ = ["Spin"]

TRIES = 40


class _Inertia(NamedTuple):
    """Mass of the elements of a group: ``shape`` (ne, nn, nn), ``mass`` (ne,), Euler tensor ``euler`` (ne, q, q) on the
    first q directors, whose reference is ``directors`` (ne, nn, q, 3)."""

    shape: Array
    mass: Array
    euler: Array
    directors: Array


def _inertia(group: Group) -> _Inertia | None:
    """What of a group has mass."""
    if isinstance(group.element, BodyElement):
        p = group.parameters
        euler = np.zeros((len(p), 3, 3))
        euler[:, *np.triu_indices(3)] = p[:, 1:7]
        euler += np.triu(euler, 1).transpose(0, 2, 1)
        return _Inertia(np.ones((len(p), 1, 1)), p[:, 0], euler, np.broadcast_to(np.eye(3), (len(p), 1, 3, 3)))
    if group.names:
        return None
    if group.layout.eccentric:
        raise ModelError(
            f"the mass of rod {group.owners[0]!r} is off its axis, and a steady spin has no form for that",
            "put the axis through the centres of mass, or spin it up with dx.simulate",
        )
    nn = group.layout.nn
    parts: list[Any] = [np.asarray(p).T for p in group.layout.split(group.parameters.T)]  # type: ignore[arg-type]
    ne = len(parts[4])
    shape = np.zeros((ne, nn, nn))
    shape[:, *np.triu_indices(nn)] = parts[4]
    shape += np.triu(shape, 1).transpose(0, 2, 1)
    euler = np.zeros((ne, 2, 2))
    euler[:, 0, 0], euler[:, 1, 1] = parts[5][:, 1], parts[5][:, 2]
    if parts[5].shape[1] > 3:
        euler[:, 0, 1] = euler[:, 1, 0] = parts[5][:, 3]
    return _Inertia(shape, parts[5][:, 0], euler, parts[0].reshape(ne, nn, 3, 3)[:, :, :2])


@dataclass(frozen=True)
class Spin:
    """A frame that turns at ``rate`` (3,) about the axis through ``centre`` (3,)."""

    rate: Array
    centre: Array

    @property
    def _outward(self) -> Array:
        return -hat(self.rate) @ hat(self.rate)

    def force(self, newton: Newton, x: Array) -> Array:
        """Centrifugal force and moment (n, 6) on the nodes of a state."""
        out = np.zeros((newton.disc.nodes, 6))
        for group in newton.disc.groups:
            of = _inertia(group)
            if of is None:
                continue
            d, f, g = self._pulled(group, of, x)
            np.add.at(out[:, :3], group.conn, f)
            np.add.at(out[:, 3:], group.conn, np.cross(d, g).sum(axis=2))
        return out

    def _pulled(self, group: Group, of: _Inertia, x: Array) -> tuple[Array, Array, Array]:
        """Directors (ne, nn, q, 3), what pulls at positions (ne, nn, 3) and at directors."""
        rotation = x[: x.shape[0], 3:12].reshape(-1, 3, 3)[group.conn]  # columns of R, one a row
        d = np.einsum("eaqi,eaij->eaqj", of.directors, rotation)
        r = x[group.conn, :3] - self.centre
        f = np.einsum("eab,e,ij,ebj->eai", of.shape, of.mass, self._outward, r)
        g = np.einsum("eab,epq,ij,ebqj->eapi", of.shape, of.euler, self._outward, d)
        return d, f, g

    def stiffness(self, hessian: Hessian, x: Array) -> csc_matrix:
        """Second derivative of the centrifugal potential, to be added to the stiffness."""
        return self._assembled(hessian, x, self._outward, -1.0, geometric=True)

    def gyroscopic(self, hessian: Hessian, x: Array) -> csc_matrix:
        """G of M q̈ + G q̇ + K q = 0, skew-symmetric."""
        return self._assembled(hessian, x, hat(self.rate), 2.0, geometric=False)

    def _assembled(self, hessian: Hessian, x: Array, between: Array, times: float, geometric: bool) -> csc_matrix:
        blocks: list[Array] = []
        for group in hessian.newton.disc.groups:
            ne, nn = group.conn.shape
            block = np.zeros((ne, nn, 6, nn, 6))
            of = _inertia(group)
            if of is not None:
                d, _, g = self._pulled(group, of, x)
                block[:, :, :3, :, :3] = np.einsum("eab,e,ij->eaibj", of.shape, of.mass, between)
                turned = hat(d)  # δd = θ × d
                block[:, :, 3:, :, 3:] = np.einsum(
                    "eab,epq,eapki,kl,ebqlj->eaibj", of.shape, of.euler, turned, between, turned
                )
                if geometric:
                    outer = np.einsum("eapi,eapj->eaij", g, d)
                    along = np.einsum("eapi,eapi->ea", g, d)
                    for a in range(nn):
                        both = 0.5 * (outer[:, a] + outer[:, a].transpose(0, 2, 1))
                        block[:, a, 3:, a, 3:] += both - along[:, a, None, None] * np.eye(3)
            blocks.append(times * block.reshape(ne, 6 * nn, 6 * nn))
        return hessian.gathered(blocks)

    def settle(self, newton: Newton, hessian: Hessian, x: Array, external: Array) -> None:
        """Move ``x`` to the steady state under this spin and dead loads. Raises ModelError when it is not found."""
        before = x.copy()
        for parts in (1, 4, 16):
            x[:] = before
            if all(
                Spin(self.rate * np.sqrt(k / parts), self.centre)._balance(newton, hessian, x, external)
                for k in range(1, parts + 1)
            ):
                return
        raise ModelError(
            f"no steady state was found at the spin {np.linalg.norm(self.rate):g}",
            "spin more slowly, or give a nearer state with about=",
        )

    def _balance(self, newton: Newton, hessian: Hessian, x: Array, external: Array) -> bool:
        free, size, n = hessian.free, newton.disc.length, newton.disc.nodes
        for _ in range(TRIES):
            applied = newton.applied(x, external)
            off = (applied + self.force(newton, x) - newton.work.internal).ravel()[free]
            matrix = hessian.matrix(x) + self.stiffness(hessian, x)
            try:
                found = splu(csc_matrix(matrix)).solve(off / hessian.weights[free])
            except RuntimeError:  # singular
                return False
            moved, turned, bad = kernel.move(hessian.increment(found), n, x, False, False, 0.3)
            if bad >= 0:
                return False
            if moved <= 1e-10 * size and turned <= 1e-10:
                x[:n, 12:15], x[:n, 15:24] = 0.0, x[:n, 3:12]
                return True
        return False
