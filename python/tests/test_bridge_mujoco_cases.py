"""What users have reported: welds that throw bodies, limbs that break on force, joints that snap back.

Each test compares MuJoCo by hand, MuJoCo with the bridge, and momentree. The functions are those of the example.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")

import momentree as mt  # noqa: E402
from momentree.bridge import mujoco as bridge  # noqa: E402

EXAMPLE = Path(__file__).parents[1] / "examples" / "bridge_mujoco.py"


@pytest.fixture(scope="module")
def example() -> Any:
    spec = importlib.util.spec_from_file_location("bridge_mujoco_example", EXAMPLE)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_a_weld_throws_bodies(example: Any) -> None:
    """google-deepmind/mujoco#350: the bodies "suddenly" move "to another and even farther"."""
    curves = example.weld_curves()
    energy = {name: np.array(curve.value) for name, (curve, _) in curves.items()}
    gap = {name: max(curve.value) for name, (_, curve) in curves.items()}
    start = energy["activated"][0]
    assert max(energy["activated"]) > 20 * start and gap["activated"] > 0.3  # it pulls the bodies to the pose of the model file
    assert gap["posed by hand"] > 5e-3  # the velocities differ: the crate overshoots
    assert energy["bridged"][0] == pytest.approx(energy["momentree"][0], rel=1e-12)
    assert gap["bridged"] < 1e-5
    assert energy["bridged"][-1] == pytest.approx(energy["momentree"][-1], rel=1e-5)


def test_a_limb_breaks_on_force(example: Any) -> None:
    """google-deepmind/mujoco#525, with the advice of #197 as the solution by hand."""
    instant, place = example.break_in_momentree()
    by_hand = [abs(example.break_by_hand(step)[0] - instant) for step in (0.008, 0.002)]
    assert min(by_hand) > 1e-3  # the weld is soft, and it is looked at after each step
    for step, late, away in ((0.008, 1e-7, 1e-6), (0.002, 1e-9, 1e-7)):
        time, where = example.break_bridged(step)
        assert abs(time - instant) < late
        assert np.linalg.norm(where - place) < away


def test_a_joint_snaps_back(example: Any) -> None:
    """google-deepmind/mujoco#1404: joints "would try to spring back to where they were at the start of the simulation"."""
    curves = example.lock_curves()
    off = {name: np.degrees(max(abs(value - curve.value[0]) for value in curve.value)) for name, curve in curves.items()}
    assert off["activated"] > 40
    assert off["posed by hand"] > 2
    assert off["bridged"] < 0.3  # the constraint is compliant: this is how far the arm's weight bends it
    assert off["momentree"] < 1e-12


def test_the_example_draws_a_picture(example: Any, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    example.draw(tmp_path / "pictures")
    assert (tmp_path / "pictures" / "bridge_mujoco.png").stat().st_size > 10_000


def arm(seed: int, equality: str = "") -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="0.001" integrator="RK4"><flag contact="disable"/></option><worldbody>
      <body name="a" pos="1 2 3" euler="20 30 10"><joint axis="0 1 0"/><geom type="box" size=".2 .05 .04" pos=".2 0 0"/>
        <body name="b" pos=".4 0 0"><joint axis="1 2 0"/><geom type="box" size=".2 .03 .04" pos=".2 0 0"/>
          <body name="c" pos=".4 0 0" euler="5 0 0"><joint type="ball"/><geom type="box" size=".1 .03 .02" pos=".1 0 0"/></body>
        </body></body>
      <body name="d" pos="1 2 2"><freejoint/><geom type="box" size=".1 .2 .04" pos=".1 .1 0"/></body>
      </worldbody><equality>{equality}</equality></mujoco>"""
    )
    data = mujoco.MjData(model)
    rng = np.random.default_rng(seed)
    data.qpos[:2], data.qvel[:] = rng.normal(size=2), rng.normal(size=model.nv)
    mujoco.mj_forward(model, data)
    return model, data


@pytest.mark.parametrize("seed", range(3))
def test_reactions_are_those_of_momentree(seed: int) -> None:
    model, data = arm(seed)
    sim = bridge.simulation(model, data)
    sim.set_gravity((0.0, 0.0, -9.81))
    for number, name in ((1, "a"), (2, "b"), (3, "c")):
        wrench = bridge.reaction(model, data, name)
        turn = data.body(name).xmat.reshape(3, 3)
        expected = sim.world.joints[f"tree0/joint{number - 1}"].reaction  # in the axes of the child
        np.testing.assert_allclose(wrench.force, turn @ expected.force, atol=1e-10)
        np.testing.assert_allclose(wrench.torque, turn @ expected.torque, atol=1e-10)
        np.testing.assert_array_equal(wrench.point, data.body(name).xpos)
    with pytest.raises(mt.Error, match="the world has no parent"):
        bridge.reaction(model, data, 0)


@pytest.mark.parametrize("kind", ["weld", "connect"])
@pytest.mark.parametrize("order", ["dc", "cd"])
def test_the_load_of_a_constraint_is_what_accelerates_the_body(kind: str, order: str) -> None:
    """Newton and Euler for a free body that only the constraint holds."""
    anchor = 'anchor=".1 .2 .3"'
    model, data = arm(1, f'<{kind} name="bond" body1="{order[0]}" body2="{order[1]}" {anchor}/>')
    for _ in range(20):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    wrench = bridge.load(model, data, "bond")
    sign = 1.0 if order[0] == "d" else -1.0
    body = model.body("d").id
    mass = float(model.body_mass[body])
    push = data.qfrc_constraint[-6:]  # of the free joint: force in world axes, torque in the body's
    np.testing.assert_allclose(sign * wrench.force, push[:3], atol=1e-9)
    if order[0] == "d":
        about_origin = wrench.torque + np.cross(wrench.point - data.xpos[body], wrench.force)
        np.testing.assert_allclose(about_origin, data.xmat[body].reshape(3, 3) @ push[3:], atol=1e-8)
    acceleration = np.zeros(6)
    mujoco.mj_rnePostConstraint(model, data)
    mujoco.mj_objectAcceleration(model, data, int(mujoco.mjtObj.mjOBJ_BODY), body, acceleration, 0)
    np.testing.assert_allclose(sign * wrench.force, mass * acceleration[3:], atol=1e-8)  # its own gravity is in the acceleration


def test_step_until_stops_inside_of_a_step() -> None:
    """A falling body: the instant is known."""
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><option timestep="0.01" integrator="RK4"/><worldbody><body name="b" pos="0 0 2"><freejoint/>
        <geom size=".1"/></body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    crossing = bridge.step_until(model, data, lambda m, d: -float(d.body("b").xpos[2]), -1.0, tolerance=1e-12)
    assert crossing.happened and crossing.time == data.time == pytest.approx(np.sqrt(2 / 9.81), abs=2e-12)
    assert crossing.value >= -1.0 and data.body("b").xpos[2] == -crossing.value
    assert model.opt.timestep == 0.01
    past = bridge.step_until(model, data, lambda m, d: 1.0, 0.0)
    assert past.happened and past.time == crossing.time
    never = bridge.step_until(model, data, lambda m, d: 0.0, 1.0, until=0.5)
    assert not never.happened and never.time == data.time == pytest.approx(0.5, abs=1e-12)
    with pytest.raises(mt.Error, match="the tolerance is positive"):
        bridge.step_until(model, data, lambda m, d: 0.0, 1.0, tolerance=0.0)


def test_step_until_restores_the_step_if_the_measure_fails() -> None:
    model, data = arm(0)
    calls = 0

    def measure(model: Any, data: Any) -> float:
        nonlocal calls
        calls += 1
        if calls > 6:
            raise RuntimeError("measure")
        return float(data.time)

    with pytest.raises(RuntimeError, match="measure"):
        bridge.step_until(model, data, measure, 0.0015, tolerance=1e-9)
    assert model.opt.timestep == 0.001
