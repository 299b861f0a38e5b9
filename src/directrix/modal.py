"""Vibrations about an equilibrium as values, and as an animation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from directrix.audit import Audit
from directrix.checks import number, whole
from directrix.result import Energy, Mesh, Momentum, Result, Status
from directrix.rotations import exp

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

__all__ = ["Modes"]

FRAMES = 48  # of one period
SWING = 0.1  # of the model's size, or radians: the largest movement of an animation


@dataclass(frozen=True)
class Modes:
    """Natural vibrations about an equilibrium or a steady spin, by rising ω².

    Attributes
    ----------
    frequencies : (count,) in cycles per unit of time, of damped vibrations those they have; 0 where nothing swings
    squares : (count,) ω² of undamped vibrations, negative where the equilibrium is unstable; −Re λ² of others
    shapes : (count, n, 6) displacement and spin of the nodes, with unit modal mass; complex with damping or a spin,
        where the motion is Re(shape e^{λt})
    mesh : names and places
    eigenvalues : (count,) λ of a motion like e^{λt}: iω of undamped vibrations, or the rate at which one departs
    damping_ratios : (count,) −Re λ / |λ|; 0 without damping
    participation : (count, 3) part of the mass that goes along in x, y, z: (φ·M e)² over the whole mass
    strains, forces : (count, stations, 6) strains and section forces that go with the shapes
    state : what it is about: positions (n, 3), rotations (n, 3, 3), strains and section forces (stations, 6)
    """

    frequencies: Array
    squares: Array
    shapes: NDArray[Any]
    mesh: Mesh
    eigenvalues: Complex
    damping_ratios: Array
    participation: Array
    strains: NDArray[Any]
    forces: NDArray[Any]
    state: tuple[Array, Array, Array, Array] = field(repr=False)

    @property
    def stable(self) -> bool:
        """True when no motion grows beyond round-off."""
        if np.iscomplexobj(self.shapes):
            return bool(self.eigenvalues.real.max() <= 1e-7 * np.abs(self.eigenvalues).max())
        return bool(self.squares[0] > -1e-9 * np.abs(self.squares).max())

    def motion(self, mode: int = 1, amplitude: float | None = None, frames: int = FRAMES) -> Result:
        """One period of a mode as a result, to be viewed or plotted: kinematics and strains of the linear motion.

        Parameters
        ----------
        mode
            Which, from 1 up.
        amplitude
            Of the largest displacement; a tenth of the model unless given, or 0.1 rad where a turn is larger.
        frames
            Instants of the period.

        Raises
        ------
        ModelError
            There is no such mode, or an amplitude that is no positive number.
        """
        k = whole(mode, "mode", 1, len(self.frequencies)) - 1
        frames = whole(frames, "frames", 2)
        r, R, strain, force = self.state
        shape = self.shapes[k]
        size = float(np.linalg.norm(np.ptp(self.mesh.r0, axis=0)))
        moved, turned = (float(np.linalg.norm(part, axis=1).max()) for part in (shape[:, :3], shape[:, 3:]))
        if amplitude is None:
            scale = min(SWING * size / max(moved, 1e-300), 2.0 * SWING / max(turned, 1e-300))
        else:
            scale = number(amplitude, "amplitude", above=0.0) / max(moved, 1e-300)
        # phase 0 where it moves most; a mode that does not swing is shown as if it did
        phase = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, frames))
        step, more, pull = (
            scale * np.real(phase[:, None, None] * part) for part in (shape, self.strains[k], self.forces[k])
        )
        n, zero = len(r), np.zeros(frames)
        f = float(self.frequencies[k])
        t = np.linspace(0.0, 1.0 / f if f > 0.0 else 1.0, frames)
        said = f"{f:.6g} per unit of time" if f > 0.0 else "does not swing"
        return Result(
            kind="dynamic",
            name=f"mode {k + 1}: {said}",
            mesh=self.mesh,
            t=t,
            load_factor=np.ones(frames),
            r=r + step[:, :, :3],
            R=exp(step[:, :, 3:]) @ R,
            v=np.zeros((frames, n, 3)),
            Rdot=np.zeros((frames, n, 3, 3)),
            reaction=np.zeros((frames, n, 6)),
            strain=strain + more,
            force=force + pull,
            energy=Energy(zero, zero, zero, zero, zero),
            momentum=Momentum(np.zeros((frames, 3)), np.zeros((frames, 3))),
            iterations=np.zeros(0, np.int64),
            status=Status("done", f"one period of mode {k + 1}, {said}; its size is free."),
            audit=Audit(()),
            info={"integrator": "linear vibration", "size": scale},
        )

    def plot(
        self, count: int = 4, amplitude: float | None = None, axes: Sequence[Axes] | None = None
    ) -> tuple[Axes, ...]:
        """Draw the first modes, one axes each, with their frequencies: both ends of the swing and the state between.

        ``axes`` are used in their order, else a figure is made. Raises ModelError for fewer axes than modes, and
        without matplotlib.
        """
        from directrix.pictures.vibration import shapes

        return shapes(self, count, amplitude, axes)

    def view(self, path: str | PathLike[str], mode: int = 1, amplitude: float | None = None) -> str:
        """Write one mode as a self-contained HTML animation; returns its path. See :meth:`motion`."""
        from directrix.viewer import write_html

        r, R, *_ = self.state
        return write_html(self.motion(mode, amplitude), path, base=(r, R))
