"""The generalised-α family on a Lie group (Brüls, Cardona & Arnold 2012): one scheme, three constructors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from directrix.checks import number
from directrix.errors import ModelError
from directrix.formulations.director_acceleration import DirectorAcceleration
from directrix.formulations.directors import Directors
from directrix.integrators.protocol import Formulation
from directrix.scheme import Rates, Scheme

__all__ = ["Alpha", "GeneralizedAlpha", "HilberHughesTaylor", "Newmark"]


@dataclass(frozen=True)
class Alpha:
    """Balance at t1 with the acceleration v̇1; r1 = r0 + Δr, R1 = R0 exp(Θ), q = (Δr, Θ)::

        q = Δt v0 + Δt² ((½ − β) a0 + β a1),   v1 = v0 + Δt ((1 − γ) a0 + γ a1)
        (1 − α_m) a1 + α_m a0 = (1 − α_f) v̇1 + α_f v̇0

    Angular velocities in the frame of the node. Order 2 when γ = ½ + α_f − α_m, else 1; energy and angular momentum
    are not conserved, linear momentum only while nothing acts. Loads act with their values at t1. Built by
    :func:`GeneralizedAlpha`, :func:`HilberHughesTaylor`, :func:`Newmark`.
    """

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    formulation: ClassVar[Formulation] = Directors()
    why: ClassVar[str] = "it is written for interpolated directors"
    conserves_energy: ClassVar[bool] = False
    conserves_momenta: ClassVar[bool] = False
    damping: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for name in ("alpha_m", "alpha_f"):
            if not number(getattr(self, name), name) < 1.0:
                raise ModelError(f"{name} = {getattr(self, name):g} is not less than 1", "give less than 1")
        number(self.beta, "beta", above=0.0)
        number(self.gamma, "gamma", above=0.0)

    @property
    def order(self) -> int:
        """In Δt."""
        return 2 if abs(self.gamma - 0.5 - self.alpha_f + self.alpha_m) < 1e-12 else 1

    def scheme(self, dt: float) -> Scheme:
        """One step of length ``dt``."""
        am, af, beta, gamma = self.alpha_m, self.alpha_f, self.beta, self.gamma
        cv, ca = gamma / (beta * dt), (1.0 - am) / ((1.0 - af) * beta * dt * dt)
        return Scheme(DirectorAcceleration(), Rates.ALPHA, (cv, ca, dt, beta, gamma, am, af))


def GeneralizedAlpha(rho_inf: float = 0.8) -> Alpha:
    """The generalised-α scheme of spectral radius ``rho_inf`` at infinity (Chung & Hulbert 1993), 0 … 1."""
    if not 0.0 <= number(rho_inf, "rho_inf") <= 1.0:
        raise ModelError(f"rho_inf = {rho_inf:g} is not between 0 and 1", "1 damps nothing, 0 all that is fast")
    am, af = (2.0 * rho_inf - 1.0) / (rho_inf + 1.0), rho_inf / (rho_inf + 1.0)
    gamma = 0.5 + af - am
    return Alpha(am, af, 0.25 * (gamma + 0.5) ** 2, gamma)


def HilberHughesTaylor(alpha: float = 0.1) -> Alpha:
    """The HHT scheme (1977) with α_f = ``alpha``, 0 … ⅓, which damps the more the larger it is."""
    if not 0.0 <= number(alpha, "alpha") <= 1.0 / 3.0:
        raise ModelError(f"alpha = {alpha:g} is not between 0 and 1/3", "0 is the trapezoidal rule")
    return Alpha(0.0, alpha, 0.25 * (1.0 + alpha) ** 2, 0.5 + alpha)


def Newmark(beta: float = 0.25, gamma: float = 0.5) -> Alpha:
    """Newmark's scheme (1959); (¼, ½) is the trapezoidal rule."""
    return Alpha(0.0, 0.0, beta, gamma)
