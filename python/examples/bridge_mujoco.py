"""Three topology changes in MuJoCo, by hand and by ``momentree.bridge.mujoco``, next to the same changes in momentree.

    python bridge_mujoco.py [FOLDER]

1. A weld is activated between two moving bodies.
2. A limb breaks off when the force in its joint exceeds a threshold.
3. A swinging joint is locked.

Writes ``bridge_mujoco.png`` into the folder, and prints the numbers of the picture.
"""

# pyright: reportAttributeAccessIssue=false
# (the module mujoco has no types)
from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco  # type: ignore[import-untyped,import-not-found,unused-ignore]
import numpy as np

import momentree as mt
from momentree.bridge import mujoco as bridge


@dataclass
class Curve:
    """Something that changes with time."""

    name: str
    time: list[float] = field(default_factory=list)
    value: list[float] = field(default_factory=list)

    def record(self, model: Any, data: Any, until: float, measure: Callable[[Any, Any], float]) -> Curve:
        """Steps a simulation, and measures after each step."""
        while True:
            mujoco.mj_forward(model, data)
            self.time.append(float(data.time))
            self.value.append(measure(model, data))
            if data.time >= until - 1e-9:
                return self
            mujoco.mj_step(model, data)


# 1. A weld that throws bodies

CAPTURE = """<mujoco><option timestep="0.002" gravity="0 0 0" integrator="RK4"><flag contact="disable"/></option><worldbody>
  <body name="tug"><freejoint/><geom type="box" size=".4 .2 .2" mass="4"/></body>
  <body name="crate" pos="1 0 0"><freejoint/><geom type="box" size=".2 .2 .3" mass="1"/></body></worldbody>
  <equality><weld name="grasp" body1="tug" body2="crate" active="false"/></equality></mujoco>"""


def capture() -> tuple[Any, Any]:
    """A crate that flies past a tug, elsewhere than where the model was compiled."""
    model = mujoco.MjModel.from_xml_string(CAPTURE)
    data = mujoco.MjData(model)
    data.qpos[7:14] = [0.7, 0.5, 0.2, np.cos(0.4), 0.0, np.sin(0.4), 0.0]
    data.qvel[:6] = [0.2, 0.0, 0.0, 0.0, 0.0, 0.3]
    data.qvel[6:12] = [-0.5, -0.6, 0.1, 1.0, 0.5, 0.0]
    return model, data


def kinetic(model: Any, data: Any) -> float:
    """J."""
    moved = np.zeros(model.nv)
    mujoco.mj_mulM(model, data, moved, data.qvel)
    return 0.5 * float(data.qvel @ moved)


def crate_in_tug(data: Any) -> Any:
    """Where the crate is in the tug's frame."""
    return data.body("tug").xmat.reshape(3, 3).T @ (data.body("crate").xpos - data.body("tug").xpos)


def weld_curves(until: float = 0.5) -> dict[str, tuple[Curve, Curve]]:
    """Kinetic energy, and how far the crate is from where it was grasped: by hand, bridged, and in momentree."""
    curves = {}
    for name in ("activated", "posed by hand", "bridged"):
        model, data = capture()
        mujoco.mj_forward(model, data)
        grasped = crate_in_tug(data)
        if name == "bridged":
            bridge.weld(model, data, "crate", "tug", equality="grasp")
        else:
            data.eq_active[0] = 1
        if name == "posed by hand":  # the pose of the weld becomes the present one, but the velocities stay
            tug, crate = data.body("tug"), data.body("crate")
            model.eq_data[0][:3] = 0.0
            model.eq_data[0][3:6] = grasped
            mujoco.mju_mulQuat(model.eq_data[0][6:10], tug.xquat * [1, -1, -1, -1], crate.xquat)
            model.eq_data[0][11:] = 0.0
        mujoco.mj_forward(model, data)
        energy, gap = Curve(name), Curve(name)

        def both(model: Any, data: Any, gap: Curve = gap, grasped: Any = grasped) -> float:
            gap.time.append(float(data.time))
            gap.value.append(float(np.linalg.norm(crate_in_tug(data) - grasped)))
            return kinetic(model, data)

        curves[name] = energy.record(model, data, until, both), gap
    sim = bridge.simulation(*capture())
    sim.apply(mt.weld("tree1/body2", "tree0/body1"))
    run = sim.run(until=until)
    energy, gap = Curve("momentree"), Curve("momentree")
    energy.time = gap.time = [float(t) for t in run.time]
    energy.value = [float(each) for each in run.energy["kinetic"]]
    gap.value = [0.0 for _ in run.time]
    curves["momentree"] = energy, gap
    return curves


# 2. A limb that breaks on force

LIMB = '<geom type="capsule" fromto="0 0 0 .5 0 0" size=".03" mass="1"/>'
TREE = f"""<mujoco><option timestep="STEP" integrator="RK4"><flag contact="disable"/></option><worldbody>
  <body name="arm" pos="0 0 2"><joint name="shoulder" axis="0 1 0"/>{LIMB}
    <body name="limb" pos=".5 0 0"><joint name="elbow" axis="0 1 0"/>{LIMB}</body></body></worldbody></mujoco>"""
# The usual advice: two bodies at the place of the break, held together by a weld that is deactivated.
SPLIT = f"""<mujoco><option timestep="STEP" integrator="RK4"><flag contact="disable"/></option><worldbody>
  <body name="arm" pos="0 0 2"><joint name="shoulder" axis="0 1 0"/>{LIMB}
    <body name="stump" pos=".5 0 0"><joint name="elbow" axis="0 1 0"/><geom size=".02" mass=".01"/></body></body>
  <body name="limb" pos=".5 0 2"><freejoint/>{LIMB}</body></worldbody>
  <equality><weld name="bond" body1="limb" body2="stump"/></equality></mujoco>"""
THRESHOLD = 45.0
END = 1.0


def break_in_momentree() -> tuple[float, Any]:
    """When the limb breaks off, and where it is at the end."""
    model = mujoco.MjModel.from_xml_string(TREE.replace("STEP", "0.001"))
    sim = bridge.simulation(model, mujoco.MjData(model))
    sim.set_gravity((0.0, 0.0, -9.81))
    sim.when(mt.reaction("tree0/joint1").force > THRESHOLD).then(mt.break_joint("tree0/joint1"))
    sim.run(until=END)
    return float(sim.events[0].time), np.array(sim.world.bodies["tree0/body2"].position)


def break_by_hand(step: float) -> tuple[float, Any]:
    """A weld that is deactivated after the first step in which it bears more than the threshold."""
    model = mujoco.MjModel.from_xml_string(SPLIT.replace("STEP", repr(step)))
    data = mujoco.MjData(model)
    broken = np.inf
    while data.time < END - 1e-9:
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        if np.isinf(broken) and np.linalg.norm(bridge.load(model, data, "bond").force) > THRESHOLD:
            broken, data.eq_active[0] = float(data.time), 0
    return broken, np.array(data.body("limb").xpos)


def break_bridged(step: float) -> tuple[float, Any]:
    """A joint of the tree that breaks inside of the step in which its reaction crosses the threshold."""
    spec = mujoco.MjSpec.from_string(TREE.replace("STEP", repr(step)))
    model = spec.compile()
    data = mujoco.MjData(model)
    crossing = bridge.step_until(
        model, data, lambda m, d: float(np.linalg.norm(bridge.reaction(m, d, "limb").force)), THRESHOLD, tolerance=1e-12
    )
    change = bridge.break_(model, data, joint="elbow", spec=spec)
    model, data = change.model, change.data
    while data.time < END - 1e-12:
        model.opt.timestep = min(step, END - data.time)
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    return crossing.time, np.array(data.body("limb").xpos)


# 3. A joint that snaps back

SWING = """<mujoco><option timestep="0.002" integrator="RK4"/><worldbody>
  <body name="upper" pos="0 0 2"><joint name="shoulder" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 .5 0 0" size=".03" mass="1"/>
    <body name="lower" pos=".5 0 0"><joint name="elbow" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03" mass=".7"/></body></body></worldbody>
  <equality><joint name="brake" joint1="elbow" active="false"/></equality></mujoco>"""


def swing() -> tuple[Any, Any]:
    """An arm in full swing."""
    model = mujoco.MjModel.from_xml_string(SWING)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = [0.3, 0.8], [2.0, 5.0]
    return model, data


def lock_curves(until: float = 0.4) -> dict[str, Curve]:
    """The angle of the elbow from the instant at which it is locked."""
    curves = {}
    for name in ("activated", "posed by hand", "bridged"):
        model, data = swing()
        if name == "bridged":
            bridge.lock(model, data, "elbow")
        else:
            data.eq_active[0] = 1
            if name == "posed by hand":
                model.eq_data[0][0] = data.qpos[1] - model.qpos0[1]
        curves[name] = Curve(name).record(model, data, until, lambda m, d: float(d.qpos[1]))
    sim = bridge.simulation(*swing())
    sim.set_gravity((0.0, 0.0, -9.81))
    sim.apply(mt.lock("tree0/joint1"))
    run = sim.run(until=until)
    elbow = Curve("momentree")
    elbow.time, elbow.value = [float(t) for t in run.time], [float(q[0]) for q in run["tree0/joint1"].q]
    curves["momentree"] = elbow
    return curves


def draw(folder: Path) -> None:
    """The picture and the numbers."""
    import matplotlib  # type: ignore[import-not-found,unused-ignore]

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt  # type: ignore[import-not-found,unused-ignore]

    styles = {"activated": "C3-", "posed by hand": "C1-", "bridged": "C0-", "momentree": "k:"}
    figure, axes = plt.subplots(2, 2, figsize=(11, 7), constrained_layout=True)
    (energy_axes, gap_axes), (break_axes, lock_axes) = axes
    for name, (energy, gap) in weld_curves().items():
        energy_axes.plot(energy.time, energy.value, styles[name], label=name)
        gap_axes.plot(gap.time, np.array(gap.value) * 1e3, styles[name], label=name)
        print(f"weld, {name}: {energy.value[0]:.6f} J, largest {max(energy.value):.6f} J, off by {max(gap.value) * 1e3:.4f} mm")
    energy_axes.set(title="A weld between moving bodies", xlabel="time (s)", ylabel="kinetic energy (J)", yscale="log")
    gap_axes.set(title="… and what it holds", xlabel="time (s)", ylabel="off the grasped place (mm)", yscale="symlog")
    gap_axes.set_ylim(bottom=0)
    instant, place = break_in_momentree()
    steps = [0.008, 0.004, 0.002, 0.001]
    for name, attempt, style in (("by hand", break_by_hand, "C1o-"), ("bridged", break_bridged, "C0o-")):
        results = [attempt(step) for step in steps]
        late = [abs(time - instant) for time, _ in results]
        away = [float(np.linalg.norm(where - place)) for _, where in results]
        break_axes.loglog(steps, late, style, label=f"{name}: instant (s)")
        break_axes.loglog(steps, away, style.replace("o-", "s--"), label=f"{name}: limb after 1 s (m)")
        print(f"break, {name}: " + ", ".join(f"{s * 1e3:g} ms: {t:.1e} s, {a:.1e} m" for s, t, a in zip(steps, late, away)))
    break_axes.set(title="A limb that breaks on force: errors", xlabel="time step (s)")
    for name, curve in lock_curves().items():
        lock_axes.plot(curve.time, np.degrees(curve.value), styles[name], label=name)
        print(f"lock, {name}: off by {np.degrees(max(abs(v - curve.value[0]) for v in curve.value)):.4f} degrees")
    lock_axes.set(title="A joint that is locked while it moves", xlabel="time (s)", ylabel="elbow (degrees)")
    for each in axes.flat:
        each.legend(fontsize=8)
        each.grid(alpha=0.3)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "bridge_mujoco.png", dpi=110)


if __name__ == "__main__":
    draw(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
