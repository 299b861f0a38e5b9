"""Kratos: CrBeamElement3D2N (corotational, lumped shear), Newmark (Bossak with α = 0), Newton until residual and
increment are below 1e-6 relative (28 iterations a step for 1e-8, 20 for 1e-6), sparse LU of Eigen, one thread.
"""
# ruff: noqa: N817

from __future__ import annotations

import itertools
import os
import re

os.environ["OMP_NUM_THREADS"] = "1"

import common
import KratosMultiphysics as KM
import KratosMultiphysics.LinearSolversApplication as LSA  # noqa: F401
import KratosMultiphysics.StructuralMechanicsApplication as SMA
import numpy as np
from common import Clock, Rod, Run
from KratosMultiphysics.python_linear_solver_factory import ConstructSolver

KINDS = (
    KM.DISPLACEMENT, KM.ROTATION, KM.REACTION, KM.REACTION_MOMENT, KM.VELOCITY, KM.ACCELERATION, KM.ANGULAR_VELOCITY,
    KM.ANGULAR_ACCELERATION, KM.VOLUME_ACCELERATION, SMA.POINT_LOAD, SMA.POINT_MOMENT,
)  # fmt: skip


class Model:
    def __init__(self, rod: Rod) -> None:
        self.model = KM.Model()
        self.part = part = self.model.CreateModelPart("rods", 2)
        part.ProcessInfo[KM.DOMAIN_SIZE] = 3
        for kind in KINDS:
            part.AddNodalSolutionStepVariable(kind)
        p = self.properties = part.CreateNewProperties(1)
        area = self._area(rod)
        young = rod.EA / area
        shear = rod.GJ * young / (2 * rod.EI)  # a round section: J = 2 I
        p.SetValue(KM.YOUNG_MODULUS, young)
        p.SetValue(KM.POISSON_RATIO, young / (2 * shear) - 1)
        p.SetValue(KM.DENSITY, rod.mass / area)
        p.SetValue(SMA.CROSS_AREA, area)
        p.SetValue(SMA.I22, rod.EI / young)
        p.SetValue(SMA.I33, rod.EI / young)
        p.SetValue(SMA.TORSIONAL_INERTIA, rod.GJ / shear)
        p.SetValue(SMA.AREA_EFFECTIVE_Y, rod.GA / shear)
        p.SetValue(SMA.AREA_EFFECTIVE_Z, rod.GA / shear)
        p.SetValue(KM.CONSTITUTIVE_LAW, SMA.BeamConstitutiveLaw())
        p.SetValue(KM.COMPUTE_LUMPED_MASS_MATRIX, False)
        self.rod, self.count = rod, 0

    @staticmethod
    def _area(rod: Rod) -> float:
        """The rubber rod's own; any will do for what E A, E I and ρ A are."""
        return common.math.pi * common.RADIUS**2 if rod is common.SWING else 1.0

    def chain(self, a, b, n: int, first=None) -> list:
        nodes = []
        for k, x in enumerate(np.linspace(a, b, n + 1)):
            if k == 0 and first is not None:
                nodes.append(first)
                continue
            self.count += 1
            nodes.append(self.part.CreateNewNode(self.count, *x.tolist()))
        for i, j in itertools.pairwise(nodes):
            tag = self.part.NumberOfElements() + 1
            self.part.CreateNewElement("CrBeamElement3D2N", tag, [i.Id, j.Id], self.properties)
        return nodes

    def prepare(self) -> None:
        part = self.part
        util = KM.VariableUtils()
        for name in "XYZ":
            get = KM.KratosGlobals.GetVariable
            util.AddDof(get(f"DISPLACEMENT_{name}"), get(f"REACTION_{name}"), part)
            util.AddDof(get(f"ROTATION_{name}"), get(f"REACTION_MOMENT_{name}"), part)
        part.SetBufferSize(2)
        scheme = SMA.StructuralMechanicsBossakScheme(KM.Parameters('{"damp_factor_m": 0.0, "newmark_beta": 0.25}'))
        solver = ConstructSolver(KM.Parameters('{"solver_type": "LinearSolversApplication.sparse_lu"}'))
        builder = KM.ResidualBasedBlockBuilderAndSolver(solver)
        moved = KM.MixedGenericCriteria([(KM.DISPLACEMENT, 1e-6, 1e-8), (KM.ROTATION, 1e-6, 1e-8)])
        criterion = KM.AndCriteria(SMA.ResidualDisplacementAndOtherDoFCriteria(1e-6, 1e-8), moved)
        self.strategy = KM.ResidualBasedNewtonRaphsonStrategy(part, scheme, criterion, builder, 100, False, False, True)
        self.strategy.SetEchoLevel(int(os.environ.get("ECHO", "0")))
        self.strategy.Initialize()
        self.time, self.step = 0.0, 0

    def march(self, end: float, dt: float, before=None) -> float:
        for _ in range(round((end - self.time) / dt)):
            self.step += 1
            self.part.CloneTimeStep(self.time + dt)
            self.part.ProcessInfo[KM.STEP] = self.step
            if before:
                before(self.time + dt)
            self.strategy.InitializeSolutionStep()
            self.strategy.Predict()
            if not self.strategy.SolveSolutionStep():
                return self.time
            self.strategy.FinalizeSolutionStep()
            self.time += dt
        return end


def at(node) -> np.ndarray:
    return np.array([node.X, node.Y, node.Z])


def solve(case: str, n: int, dt: float, variant: str, clock: Clock) -> Run:
    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    if case == "swing":
        m = Model(common.SWING)
        nodes = m.chain((0, 0, 0), (1, 0, 0), n)
        m.prepare()
        for d in (KM.DISPLACEMENT_X, KM.DISPLACEMENT_Y, KM.DISPLACEMENT_Z):
            nodes[0].Fix(d)
        weight = KM.Array3([0, 0, -common.GRAVITY])
        for node in nodes:
            for back in range(2):
                node.SetSolutionStepValue(KM.VOLUME_ACCELERATION, back, weight)
        with clock.running():
            reached = m.march(1.0, dt)
        return Run(reached >= 1.0, at(nodes[-1]).tolist(), None, None, reached)
    return Run(note="not set up")


if __name__ == "__main__":
    common.main("Kratos", ".".join(re.findall(r"\d+", KM.Kernel.Version())[:3]), solve)
