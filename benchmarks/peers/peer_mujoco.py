"""MuJoCo: its cable plugin (mujoco.elasticity.cable), a chain of rigid segments with ball joints between them;
variant = its integrator. No stretch and no shear. The plugin's stiffness is explicit: where Δt is refused it is
halved, and the step that went through counts. MuJoCo 4 has no such plugin any more, so it is the last 3.x.
"""

from __future__ import annotations

import common
import mujoco
import numpy as np
from common import Clock, Run
from scipy.spatial.transform import Rotation


def build(n: int, dt: float, integrator: str) -> mujoco.MjModel:
    shear = common.YOUNG / (2 * (1 + common.POISSON))
    mass = common.SWING.mass / n
    # the third vertex is moved by 1e-7 of a segment: a straight cable has no first frame otherwise
    points = np.array([[i / n, 0.0, 1e-7 / n if i == 2 else 0.0] for i in range(n + 1)])
    return mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <extension><plugin plugin="mujoco.elasticity.cable"/></extension>
  <option timestep="{dt!r}" gravity="0 0 {-common.GRAVITY}" integrator="{integrator}">
    <flag energy="enable" contact="disable"/>
  </option>
  <worldbody>
    <composite type="cable" prefix="r" initial="ball" vertex="{" ".join(map(repr, points.ravel().tolist()))}">
      <plugin plugin="mujoco.elasticity.cable">
        <config key="twist" value="{shear}"/>
        <config key="bend" value="{common.YOUNG}"/>
        <config key="flat" value="true"/>
      </plugin>
      <joint kind="main" damping="0" armature="0"/>
      <geom type="capsule" size="{common.RADIUS}" mass="{mass!r}"/>
    </composite>
  </worldbody>
</mujoco>""")


def energy(model: mujoco.MjModel, data: mujoco.MjData, n: int) -> tuple[float, float]:
    """Total, and what gravity holds; the plugin's own is added here."""
    mujoco.mj_forward(model, data)
    turns = Rotation.from_matrix(data.xmat[-n:].reshape(-1, 3, 3))
    between = (turns[:-1].inv() * turns[1:]).as_rotvec() if n > 1 else np.zeros((0, 3))
    stiffness = np.array([common.SWING.GJ, common.SWING.EI, common.SWING.EI]) * n
    potential, kinetic = data.energy
    return float(potential + kinetic + 0.5 * (between**2 @ stiffness).sum()), float(potential)


def solve(case: str, n: int, dt: float, variant: str, clock: Clock) -> Run:
    if case != "swing":
        return Run(note="neither stretch, shear nor inertia of the section; a frame only through soft welds")
    for _ in range(14):
        model = build(n, dt, variant)
        data = mujoco.MjData(model)
        start, height = energy(model, data, n)
        clock.cpu = 0.0
        steps = round(1.0 / dt)
        with clock.running():
            for _ in range(steps // 10):
                mujoco.mj_step(model, data, 10)
                if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
                    break
        end, low = energy(model, data, n)
        work = height - low
        if abs(data.time - 1.0) < 1e-9 and abs(end - start) < 0.1 * abs(work):
            break
        dt /= 2
    else:
        return Run(note="blew up at every step tried", dt=dt)
    tip = data.site("rS_last").xpos.tolist()
    return Run(True, tip, end, (end - start) / work, 1.0, dt)


if __name__ == "__main__":
    common.main("MuJoCo", mujoco.__version__, solve)
