"""How MuJoCo holds a change: constraints of the model, constraints that are added, joints that break; and nothing on failure."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")

import momentree as mt  # noqa: E402
from momentree.bridge import mujoco as bridge  # noqa: E402

# An arm with a hand, and a crate that the hand carries later. The crate has a ball with a handle.
ARM = """<mujoco><option timestep="0.001"/>
  <default><geom contype="0" conaffinity="0"/><default class="link"><geom rgba=".8 .3 .2 1" friction=".7"/></default></default>
  <asset><mesh name="tip" vertex="0 0 0 .05 0 0 0 .05 0 0 0 .05"/></asset>
  <worldbody>
    <body name="upper"><joint name="shoulder" axis="0 1 0" damping=".1"/>
      <geom class="link" type="capsule" fromto="0 0 0 .4 0 0" size=".03"/>
      <body name="fore" pos=".4 0 0"><joint name="elbow" axis="0 1 0" ref="10" pos=".01 0 0" armature=".01"/>
        <geom class="link" type="capsule" fromto="0 0 0 .3 0 0" size=".02"/><site name="grip" pos=".3 0 0"/>
        <frame pos=".3 0 0" euler="0 20 0"><body name="hand" euler="30 0 0"><joint name="wrist" type="ball"/>
          <geom name="palm" type="mesh" mesh="tip" mass=".2"/><geom size=".03" pos=".02 0 0"/>
          <camera name="eye" pos="0 0 .1"/></body></frame>
      </body></body>
    <body name="crate" pos=".9 .1 -.2" euler="0 40 10"><freejoint name="crate"/><geom type="box" size=".1 .08 .06" mass="1.5"/>
      <body name="handle" pos="0 0 .1"><joint name="swivel" axis="0 0 1"/><geom size=".02" pos=".05 0 0" mass=".1"/></body></body>
  </worldbody>
  <actuator><motor name="lift" joint="shoulder"/><position name="bend" joint="elbow" kp="2"/>
    <motor name="turn" joint="swivel"/></actuator>
  <sensor><jointpos name="angle" joint="elbow"/><framepos name="where" objtype="site" objname="grip"/>
    <framepos name="gap" objtype="body" objname="hand" reftype="body" refname="upper"/></sensor>
  <contact><exclude body1="upper" body2="hand"/></contact>
  <equality>EQUALITY</equality>
</mujoco>"""


STIFF = (0.999, 0.9999, 0.001, 0.5, 2)


def spec_of(equality: str = "") -> Any:
    return mujoco.MjSpec.from_string(ARM.replace("EQUALITY", equality))


def moving(model: Any, seed: int = 0) -> Any:
    rng = np.random.default_rng(seed)
    data = mujoco.MjData(model)
    data.qvel[:] = rng.normal(size=model.nv)
    data.ctrl[:] = rng.uniform(-0.2, 0.2, size=model.nu)
    for _ in range(50):
        mujoco.mj_step(model, data)
    return data


def relative_pose(model: Any, data: Any, one: str, two: str) -> tuple[Any, Any]:
    """Position and rotation of ``two`` in the frame of ``one``."""
    a, b = data.body(one), data.body(two)
    turn = a.xmat.reshape(3, 3)
    return turn.T @ (b.xpos - a.xpos), turn.T @ b.xmat.reshape(3, 3)


@pytest.mark.parametrize("declared", ["ab", "ba", "spec"])
def test_a_weld_goes_on_holding(declared: str) -> None:
    pair = {"ab": 'body1="hand" body2="crate"', "ba": 'body1="crate" body2="hand"', "spec": ""}[declared]
    spec = spec_of(f'<weld name="grasp" {pair} active="false"/>' if pair else "")
    model = spec.compile()
    data = moving(model)
    change = bridge.weld(model, data, "hand", "crate", spec=None if pair else spec, solref=(0.002, 1), solimp=STIFF)
    assert (change.model is model) == bool(pair)
    model, data = change.model, change.data
    assert change.equalities == (("grasp",) if pair else ("crate+hand",))
    position, turn = relative_pose(model, data, "hand", "crate")
    after = data.qvel.copy()
    for _ in range(500):
        mujoco.mj_step(model, data)
    there, then = relative_pose(model, data, "hand", "crate")
    assert np.linalg.norm(there - position) < 1e-3 and np.linalg.norm(then - turn) < 1e-3
    assert np.linalg.norm(data.qvel - after) > 0.1  # it does move


def test_the_pose_of_a_weld_survives_a_change_of_masses() -> None:
    """``mj_setConst`` computes the poses of welds anew that were not given explicitly."""
    model = spec_of('<weld name="grasp" body1="hand" body2="crate" active="false"/>').compile()
    data = moving(model)
    bridge.weld(model, data, "hand", "crate")
    pose = model.eq_data[0].copy()
    model.body_mass[model.body("crate").id] *= 2
    mujoco.mj_setConst(model, mujoco.MjData(model))
    np.testing.assert_array_equal(model.eq_data[0], pose)


def test_a_hinge_turns_about_its_axis_only() -> None:
    spec = spec_of()
    names = bridge.reserve(spec, hinges=[("hand", "crate")], locks=["shoulder", "wrist", "crate"])
    assert names == ["crate+hand", "crate+hand.1", "lock shoulder", "fore+hand", "world+crate"]
    model = spec.compile()
    data = moving(model)
    axis = np.array([0.3, 1.0, 0.2])
    bridge.attach(model, data, "hand", "crate", axis=axis, solref=(0.002, 1))
    # Seen from the crate, the axis and the joint are fixed in the hand.
    position, turn = relative_pose(model, data, "crate", "hand")
    in_hand = turn.T @ axis / np.linalg.norm(axis)
    for _ in range(300):
        mujoco.mj_step(model, data)
    there, then = relative_pose(model, data, "crate", "hand")
    assert np.linalg.norm(there - position) < 1e-3
    assert np.linalg.norm(then @ in_hand - axis / np.linalg.norm(axis)) < 5e-3
    assert np.linalg.norm(then - turn) > 0.1


@pytest.mark.parametrize("joint", ["shoulder", "elbow", "wrist", "crate"])
@pytest.mark.parametrize("way", ["reserved", "spec"])
def test_a_lock_holds_and_releases(joint: str, way: str) -> None:
    spec = spec_of()
    if way == "reserved":
        bridge.reserve(spec, locks=["shoulder", "elbow", "wrist", "crate"])
    model = spec.compile()
    data = moving(model)
    change = bridge.lock(model, data, joint, spec=spec if way == "spec" else None, solref=(0.002, 1), solimp=STIFF)
    model, data = change.model, change.data
    element = data.joint(joint)
    np.testing.assert_allclose(element.qvel, 0.0, atol=1e-13)
    position = element.qpos.copy()
    for _ in range(500):
        mujoco.mj_step(model, data)
    assert np.max(np.abs(data.joint(joint).qpos - position)) < 2e-3
    before = data.qvel.copy()
    released = bridge.unlock(model, data, joint)
    np.testing.assert_array_equal(data.qvel, before)
    assert released.equalities == change.equalities and released.certificate.method == "none" and released.certificate.ok
    for _ in range(500):
        mujoco.mj_step(model, data)
    assert np.max(np.abs(data.joint(joint).qpos - position)) > 1e-2


def test_a_weld_breaks_again() -> None:
    spec = spec_of('<weld name="grasp" body1="hand" body2="crate" active="false"/>')
    model = spec.compile()
    data = moving(model)
    bridge.weld(model, data, "hand", "crate")
    mujoco.mj_step(model, data)
    before = data.qvel.copy()
    change = bridge.break_(model, data, ("crate", "hand"))
    assert change.equalities == ("grasp",) and not data.eq_active[0]
    np.testing.assert_array_equal(data.qvel, before)
    with pytest.raises(mt.Error, match="no active equality constraint"):
        bridge.break_(model, data, "grasp")


def test_changes_of_numbers_survive_a_recompilation() -> None:
    """What was changed in the model since it was compiled, and poses of earlier welds, are in the new model."""
    spec = spec_of('<weld name="grasp" body1="hand" body2="crate" active="false"/>')
    model = spec.compile()
    data = moving(model)
    model.opt.gravity[:] = 0, 0, -3
    model.body_mass[model.body("crate").id] = 7.0
    bridge.weld(model, data, "hand", "crate")
    bridge.attach(model, data, "upper", None, spec=spec)  # an unrelated constraint
    change = bridge.lock(model, data, "swivel", spec=spec)
    np.testing.assert_array_equal(change.model.opt.gravity, [0, 0, -3])
    assert change.model.body("crate").mass[0] == 7.0
    np.testing.assert_array_equal(change.model.eq_data[0], model.eq_data[0])
    np.testing.assert_array_equal(change.data.eq_active, [1, 1])
    np.testing.assert_array_equal(change.data.ctrl, data.ctrl)
    assert change.data.time == data.time
    again = bridge.lock(change.model, change.data, "shoulder", spec=change.spec)
    np.testing.assert_array_equal(again.model.eq_data[:2], change.model.eq_data)
    assert list(again.data.eq_active) == [1, 1, 1]


@pytest.mark.parametrize("joint", ["shoulder", "elbow", "wrist", "swivel"])
def test_a_joint_of_the_tree_breaks(joint: str) -> None:
    grasp = '<weld name="grasp" body1="hand" body2="crate" active="false"/>'
    spec = spec_of('<joint name="hold" joint1="elbow" active="false"/>' + grasp)
    model = spec.compile()
    data = moving(model)
    bridge.weld(model, data, "hand", "crate")
    data.xfrc_applied[model.body("hand").id] = 1, 2, 3, 4, 5, 6
    change = bridge.break_(model, data, joint=joint, spec=spec)
    new_model, new_data = change.model, change.data
    assert change.certificate.ok and change.certificate.residual < 1e-13
    assert change.certificate.released == pytest.approx(0.005 * data.joint(joint).qvel[0] ** 2 if joint == "elbow" else 0.0)
    body = {"shoulder": "upper", "elbow": "fore", "wrist": "hand", "swivel": "handle"}[joint]
    assert new_model.body(body).parentid[0] == 0 and new_model.nv == model.nv + 6 - len(data.joint(joint).qvel)
    for name in ("upper", "fore", "hand", "crate", "handle"):
        np.testing.assert_allclose(new_data.body(name).xpos, data.body(name).xpos, atol=1e-14)
        assert new_model.body(name).mass[0] == pytest.approx(model.body(name).mass[0], rel=1e-14)
    np.testing.assert_array_equal(new_data.body("hand").xfrc_applied, [1, 2, 3, 4, 5, 6])
    expected = {"shoulder": {"actuator lift"}, "elbow": {"actuator bend", "sensor angle", "equality hold"}, "wrist": set()}
    assert set(change.removed) == expected.get(joint, {"actuator turn"})
    for name in {"lift", "bend", "turn"} - {each.removeprefix("actuator ") for each in change.removed}:
        assert new_data.actuator(name).ctrl == data.actuator(name).ctrl
    weld = new_model.equality("grasp").id
    assert new_data.eq_active[weld] and np.array_equal(new_model.eq_data[weld], model.eq_data[model.equality("grasp").id])
    assert new_model.geom("palm").rgba == pytest.approx(model.geom("palm").rgba)
    for _ in range(200):
        mujoco.mj_step(new_model, new_data)
    assert np.all(np.isfinite(new_data.qvel))


def test_a_break_in_the_tree_moves_like_momentree() -> None:
    """Ballistic flight after the break, compared with the same break in momentree."""
    spec = mujoco.MjSpec.from_string(
        """<mujoco><option timestep="1e-3" integrator="RK4"><flag contact="disable"/></option><worldbody>
      <body name="a" pos="0 0 1"><joint name="ja" axis="0 1 0"/><geom type="box" size=".2 .05 .04" pos=".2 0 0"/>
        <body name="b" pos=".4 0 0"><joint name="jb" axis="1 2 0"/><geom type="box" size=".2 .03 .04" pos=".2 0 0"/>
          <body name="c" pos=".4 0 0"><joint name="jc" axis="0 0 1"/><geom type="box" size=".1 .03 .02" pos=".1 0 0"/></body>
        </body></body></worldbody></mujoco>"""
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qvel[:] = [1.0, -2.0, 3.0]
    data.qpos[:] = [0.1, 0.4, -0.3]
    simulation = bridge.simulation(model, data)
    simulation.set_gravity((0.0, 0.0, -9.81))
    simulation.apply(mt.break_joint("tree0/joint1"))
    simulation.run(until=0.5)
    change = bridge.break_(model, data, joint="jb", spec=spec)
    while change.data.time < 0.5 - 1e-9:
        mujoco.mj_step(change.model, change.data)
    mujoco.mj_forward(change.model, change.data)
    for number, name in ((1, "a"), (2, "b"), (3, "c")):
        expected = simulation.world.bodies[f"tree0/body{number}"].position
        np.testing.assert_allclose(change.data.body(name).xpos, expected, atol=2e-7)  # before 4.0, RK4 is of order 2 here


def whole(model: Any, data: Any) -> bytes:
    """All of the state and of the numbers that a change writes."""
    names = ("qpos", "qvel", "qacc", "eq_active", "efc_force", "xpos", "qfrc_constraint", "ctrl")
    parts = [getattr(data, name) for name in names]
    parts += [model.eq_data, model.eq_solref, model.eq_solimp, np.array([data.time, model.opt.timestep, model.neq])]
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


Failure = tuple[str, Callable[[Any, Any, Any], object]]

FAILURES: list[Failure] = [
    ("there is no body 'hend'; did you mean 'hand'", lambda m, d, s: bridge.weld(m, d, "hend", "crate")),
    ("no inactive weld constraint", lambda m, d, s: bridge.weld(m, d, "fore", "crate")),
    ("cannot hold this change", lambda m, d, s: bridge.weld(m, d, "fore", "crate", equality="grasp")),
    ("there is no equality 'grip'", lambda m, d, s: bridge.weld(m, d, "hand", "crate", equality="grip")),
    ("joined to itself", lambda m, d, s: bridge.weld(m, d, "hand", "hand", spec=s)),
    ("is active already", lambda m, d, s: bridge.lock(m, d, "elbow")),
    ("solref has 2 finite numbers", lambda m, d, s: bridge.weld(m, d, "hand", "crate", solref=(1, 2, 3))),
    ("solimp has 5 finite numbers", lambda m, d, s: bridge.weld(m, d, "hand", "crate", solimp=(1, float("nan"), 1, 1, 1))),
    ("not exact enough", lambda m, d, s: bridge.weld(m, d, "hand", "crate", tolerance=1e-30)),
    ("unknown method", lambda m, d, s: bridge.weld(m, d, "hand", "crate", method="best")),  # type: ignore[arg-type]
    ("active constraint acts", lambda m, d, s: bridge.weld(m, d, "hand", "crate", method="momentree")),
    ("not both", lambda m, d, s: bridge.weld(m, d, "hand", "crate", equality="grasp", spec=s)),
    ("does not match the specification", lambda m, d, s: bridge.weld(m, d, "fore", "crate", spec=mujoco.MjSpec())),
    ("needs 2 equality constraints", lambda m, d, s: bridge.attach(m, d, "hand", "crate", axis=(0, 0, 1), equality="grasp")),
    ("the axis and the length", lambda m, d, s: bridge.attach(m, d, "hand", "crate", axis=(0, 0, 0), spec=s)),
    ("at has three finite numbers", lambda m, d, s: bridge.attach(m, d, "hand", "crate", at=(0, 0), spec=s)),
    ("there is no joint 9", lambda m, d, s: bridge.lock(m, d, 9)),
    ("by its name or its number", lambda m, d, s: bridge.lock(m, d, None)),  # type: ignore[arg-type]
    ("pass spec=", lambda m, d, s: bridge.break_(m, d, joint="elbow")),
    ("a free joint cannot break", lambda m, d, s: bridge.break_(m, d, joint="crate", spec=s)),
    ("no active equality constraint", lambda m, d, s: bridge.break_(m, d, ("hand", "crate"))),
    ("needs an equality constraint, or a joint", lambda m, d, s: bridge.break_(m, d)),
    ("no active equality constraint", lambda m, d, s: bridge.unlock(m, d, "shoulder")),
    ("torque has three finite numbers", lambda m, d, s: bridge.impulse(m, d, "hand", torque=(0, float("inf"), 0))),
    ("neither body can move", lambda m, d, s: bridge.impulse(m, d, 0, force=(0, 0, 1))),
]


@pytest.mark.parametrize("failure", FAILURES, ids=lambda each: str(each[0])[:40])
def test_nothing_changes_on_failure(failure: Failure) -> None:
    text, attempt = failure
    spec = spec_of('<weld name="grasp" body1="hand" body2="crate" active="false"/><joint joint1="elbow" name="held"/>')
    model = spec.compile()
    data = moving(model)
    before, xml = whole(model, data), spec.to_xml()
    with pytest.raises(mt.Error, match=text):
        attempt(model, data, spec)
    assert whole(model, data) == before
    assert spec.to_xml() == xml


def test_constraints_that_are_switched_off() -> None:
    spec = spec_of('<weld body1="hand" body2="crate" active="false"/>')
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)
    model = spec.compile()
    with pytest.raises(mt.Error, match="switches equality constraints off"):
        bridge.weld(model, moving(model), "hand", "crate")


def test_a_state_that_is_not_finite() -> None:
    model = spec_of('<weld body1="hand" body2="crate" active="false"/>').compile()
    data = moving(model)
    data.qvel[0] = np.nan
    with pytest.raises(mt.Error, match="qvel is not finite"):
        bridge.weld(model, data, "hand", "crate")
    with pytest.raises(mt.Error, match="another model"):
        bridge.weld(model, mujoco.MjData(mujoco.MjModel.from_xml_string("<mujoco/>")), "hand", "crate")


def test_a_sleeping_body_wakes() -> None:
    text = """<mujoco><option timestep=".002"><flag sleep="enable"/></option><worldbody><geom type="plane" size="9 9 .1"/>
      <body name="box" pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
      <body name="ball" pos="0 0 3"><freejoint/><geom size=".1"/></body></worldbody>
      <equality><weld body1="ball" body2="box" active="false"/></equality></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    flying = model.joint(1).dofadr[0]
    for _ in range(1500):
        data.qpos[model.joint(1).qposadr[0] + 2] = 3.0
        data.qvel[flying : flying + 6] = 0, 0, 2, 0, 0, 0
        mujoco.mj_step(model, data)
    assert data.tree_asleep[0] >= 0, "the box is not asleep"
    certificate = bridge.weld(model, data, "ball", "box").certificate
    assert certificate.ok and certificate.method == "momentree"
    mass = float(model.body("ball").mass[0] + model.body("box").mass[0])
    assert data.qvel[2] > 0.5 * 2 * float(model.body("ball").mass[0]) / mass
    height = float(data.body("box").xpos[2])
    for _ in range(20):
        mujoco.mj_step(model, data)
    assert data.tree_asleep[0] < 0 and data.body("box").xpos[2] > height
