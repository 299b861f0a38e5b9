"""Exudyn (Gerstmayr): variant "beam" is its geometrically exact beam (two nodes, Euler parameters), "cable" its
ANCF cable (no torsion, no shear), "beam 0.9" the beam with spectral radius 0.9, "beam J=10" the spaghetti with
10 instead of 20 about its axis. Generalised α with spectral radius 1 otherwise, so nothing is damped on
purpose; full Newton tolerances 1e-8 relative, 1e-10 absolute; sparse factors (Eigen), which is its advice for
chains.
"""

from __future__ import annotations

import itertools

import common
import exudyn as exu
import exudyn.utilities as ex
import numpy as np
from common import Clock, Rod, Run

OUT = exu.OutputVariableType


def section(rod: Rod, sphere: bool) -> exu.BeamSection:
    s = exu.BeamSection()
    s.stiffnessMatrix = np.diag([rod.EA, rod.GA, rod.GA, rod.GJ, rod.EI, rod.EI])
    s.inertia = rod.inertia * np.diag([1.0 if sphere else 2.0, 1.0, 1.0])
    s.massPerLength = rod.mass
    return s


class Model:
    """Chains of beams or cables, and the energy in them."""

    def __init__(self, rod: Rod, variant: str, gravity: float = 0.0) -> None:
        cable = variant == "cable"
        self.radius = 0.9 if variant == "beam 0.9" else 1.0
        self.sphere = variant == "beam J=10"
        self.system = exu.SystemContainer()
        self.mbs, self.rod, self.cable, self.gravity = self.system.AddSystem(), rod, cable, gravity
        self.elements: list[tuple[int, int, int, float]] = []
        self.time = 0.0
        self.soft = 1 / np.array([rod.EA, rod.GA, rod.GA, rod.GJ, rod.EI, rod.EI])

    def chain(self, a, b, n: int, velocity=None) -> list[int]:
        a, b = np.array(a, float), np.array(b, float)
        length, axis = np.linalg.norm(b - a) / n, (b - a) / np.linalg.norm(b - a)
        side = np.eye(3)[np.argmin(abs(axis))]
        d2 = np.cross(axis, side) / np.linalg.norm(np.cross(axis, side))
        frame, nodes = np.array([axis, d2, np.cross(axis, d2)]).T, []
        for x in np.linspace(a, b, n + 1):
            v = list((velocity or {}).get(tuple(np.round(x, 9)), (0, 0, 0)))
            if self.cable:
                node = ex.NodePointSlope1(referenceCoordinates=[*x, *axis], initialVelocities=[*v, 0, 0, 0])
            else:
                turned = ex.RotationMatrix2EulerParameters(frame)
                node = ex.NodeRigidBodyEP(referenceCoordinates=[*x, *turned], initialVelocities=[*v, 0, 0, 0, 0])
            nodes.append(self.mbs.AddNode(node))
        for i, j in itertools.pairwise(nodes):
            r = self.rod
            if self.cable:
                e = ex.ObjectANCFCable(
                    nodeNumbers=[i, j], length=length, massPerLength=r.mass, bendingStiffness=r.EI, axialStiffness=r.EA
                )
            else:
                e = ex.ObjectBeamGeometricallyExact(
                    nodeNumbers=[i, j], length=length, sectionData=section(r, self.sphere)
                )
            e = self.mbs.AddObject(e)
            self.elements.append((e, i, j, length))
            if self.gravity:
                m = self.mbs.AddMarker(ex.MarkerBodyMass(bodyNumber=e))
                self.mbs.AddLoad(ex.LoadMassProportional(markerNumber=m, loadVector=[0, 0, -self.gravity]))
        return nodes

    def pin(self, node: int) -> None:
        ground = self.mbs.AddMarker(
            ex.MarkerNodeCoordinate(nodeNumber=self.mbs.AddNode(ex.NodePointGround()), coordinate=0)
        )
        for i in range(3):
            m = self.mbs.AddMarker(ex.MarkerNodeCoordinate(nodeNumber=node, coordinate=i))
            self.mbs.AddObject(ex.ObjectConnectorCoordinate(markerNumbers=[ground, m]))

    def weld(self, one: int, other: int) -> None:
        """Rigid joint of two nodes in the same place, whatever their frames."""
        frames = []
        for n in (one, other):
            frames.append(ex.EulerParameters2RotationMatrix(np.array(self.mbs.GetNode(n)["referenceCoordinates"][3:])))
        markers = [
            self.mbs.AddMarker(ex.MarkerNodeRigid(nodeNumber=n, localHT=exu.HT(rotation=f.T)))
            for n, f in zip((one, other), frames, strict=True)
        ]
        self.mbs.AddObject(ex.GenericJoint(markerNumbers=markers))

    def run(self, end: float, dt: float, clock: Clock) -> bool:
        if self.time == 0:
            self.mbs.Assemble()
        s = exu.SimulationSettings()
        t = s.timeIntegration
        t.startTime, t.endTime, t.numberOfSteps, t.verboseMode = self.time, end, round((end - self.time) / dt), 0
        t.generalizedAlpha.spectralRadius = self.radius
        t.newton.relativeTolerance, t.newton.absoluteTolerance = 1e-8, 1e-10
        t.newton.useModifiedNewton = False
        s.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        s.solution.file.write = False
        s.solution.sensors.writePeriod = 1e9
        s.parallel.numberOfThreads = 1
        with clock.running():
            done = self.mbs.SolveDynamic(s, updateInitialValues=True)
        self.time = end
        return bool(done)

    def energy(self) -> float:
        """Kinetic (its mass matrix), stored (its strains) and potential."""
        mbs = self.mbs
        solver = exu.MainSolverImplicitSecondOrder()
        solver.InitializeSolver(mbs, exu.SimulationSettings())
        solver.ComputeMassMatrix(mbs)
        v = mbs.systemData.GetODE2Coordinates_t()
        total = 0.5 * v @ solver.GetSystemMassMatrix() @ v
        for e, i, j, length in self.elements:
            if self.cable:
                total += self._cable(i, j, length)
                continue
            force = np.r_[mbs.GetObjectOutputBody(e, OUT.ForceLocal), mbs.GetObjectOutputBody(e, OUT.TorqueLocal)]
            z = 0.5 * (self.at(i)[2] + self.at(j)[2])
            total += 0.5 * length * float(force**2 @ self.soft) + self.rod.mass * self.gravity * length * z
        return float(total)

    def _cable(self, i: int, j: int, h: float) -> float:
        """Stored and potential energy of a cubic between two nodes."""
        q = [
            np.array(self.mbs.GetNodeOutput(k, OUT.Coordinates)) + self.mbs.GetNode(k)["referenceCoordinates"]
            for k in (i, j)
        ]
        p, w = np.polynomial.legendre.leggauss(5)
        x = 0.5 * (p + 1)
        c = np.array([q[0][:3], q[0][3:] * h, q[1][:3], q[1][3:] * h])
        r = np.array([1 - 3 * x**2 + 2 * x**3, x - 2 * x**2 + x**3, 3 * x**2 - 2 * x**3, x**3 - x**2]).T @ c
        d = np.array([-6 * x + 6 * x**2, 1 - 4 * x + 3 * x**2, 6 * x - 6 * x**2, 3 * x**2 - 2 * x]).T @ c / h
        dd = np.array([-6 + 12 * x, -4 + 6 * x, 6 - 12 * x, 6 * x - 2]).T @ c / h**2
        stretch = np.linalg.norm(d, axis=1)
        bend = np.linalg.norm(np.cross(d, dd), axis=1) / stretch**2
        density = 0.5 * self.rod.EA * (stretch - 1) ** 2 + 0.5 * self.rod.EI * bend**2
        return float(0.5 * h * w @ (density + self.rod.mass * self.gravity * r[:, 2]))

    def at(self, node: int):
        return np.array(self.mbs.GetNodeOutput(node, OUT.Position))


def solve(case: str, n: int, dt: float, variant: str, clock: Clock) -> Run:
    cable = variant == "cable"
    if cable and case != "swing":
        return Run(note="the cable knows no torsion, no moment and no frame at its ends")
    if case == "swing":
        m = Model(common.SWING, variant, common.GRAVITY)
        nodes = m.chain((0, 0, 0), (1, 0, 0), n)
        m.pin(nodes[0])
        done = m.run(1.0, dt, clock)
        height = np.mean([0.5 * (m.at(i)[2] + m.at(j)[2]) for _, i, j, _ in m.elements])
        energy = m.energy()
        drift = energy / abs(m.rod.mass * m.gravity * height)
    elif case == "flight":
        m = Model(common.FLIGHT, variant)
        chains = [m.chain(a, b, n, common.FLIGHT_VELOCITY) for a, b in common.FLIGHT_LEGS]
        m.weld(chains[0][-1], chains[1][0])
        m.weld(chains[1][-1], chains[2][0])
        nodes = chains[2]
        done = m.run(common.FLIGHT_END, dt, clock)
        energy = m.energy()
        drift = energy / common.FLIGHT_ENERGY - 1
    else:
        m = Model(common.SPAGHETTI, variant)
        nodes = m.chain(common.LOADED, common.OTHER, n)[::-1]
        grip = m.mbs.AddMarker(ex.MarkerNodeRigid(nodeNumber=nodes[-1]))
        m.mbs.AddLoad(ex.LoadForceVector(markerNumber=grip, loadVectorUserFunction=_force))
        m.mbs.AddLoad(ex.LoadTorqueVector(markerNumber=grip, loadVectorUserFunction=_moment))
        done = m.run(common.RELEASE, dt, clock)
        before = m.energy()
        done = done and m.run(common.SPAGHETTI_END, dt, clock)
        energy = m.energy()
        drift = energy / before - 1
    reached = m.time if done else None
    return Run(done, m.at(nodes[-1]).tolist(), energy, drift if done else None, reached)


def _force(mbs, t, load):
    return [common.hat(t) / 10, 0.0, 0.0]


def _moment(mbs, t, load):
    return [0.0, common.hat(t), common.hat(t) / 2]


if __name__ == "__main__":
    common.main("Exudyn", exu.__version__, solve)
