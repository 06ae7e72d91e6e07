"""Velocities of the MuJoCo bridge, compared with MuJoCo's mass matrix and Jacobians in 50 digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("mpmath")

import bridge_oracle as oracle  # noqa: E402
import momentree as mt  # noqa: E402
from bridge_models import model_of, names, state_of  # noqa: E402
from momentree.bridge import mujoco as bridge  # noqa: E402

EXACT = 1e-12
METHODS = ("auto", "projection")


class Case:
    """Two random mechanisms in a random state, with inactive constraints between two of their bodies and on their joints."""

    def __init__(self, seed: int, sizes: tuple[tuple[int, bool], ...] | None = None, one: str = "a", two: str = "b") -> None:
        rng = np.random.default_rng(seed)
        if sizes is None:
            sizes = ((int(rng.integers(1, 8)), True), (int(rng.integers(1, 8)), bool(rng.random() < 0.6)))
        plain = model_of(np.random.default_rng(seed + 1), sizes)
        self.one, self.two = str(rng.choice(names(plain, one))), str(rng.choice(names(plain, two)))
        if self.one == self.two:
            pytest.skip("the same body twice")
        pair = f'body1="{self.one}" body2="{self.two}"'
        scalar = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
        self.locks = [plain.joint(i).name for i in range(plain.njnt) if int(plain.jnt_type[i]) in scalar]
        equality = f'<weld {pair} active="false"/>' + f'<connect {pair} anchor="0 0 0" active="false"/>' * 2
        equality += "".join(f'<joint joint1="{name}" active="false"/>' for name in self.locks)
        self.model = model_of(np.random.default_rng(seed + 1), sizes, equality)
        self.data = state_of(rng, self.model)
        self.before = oracle.evaluated(self.model, self.data)
        self.v = self.data.qvel.copy()
        self.mass = oracle.mass_matrix(self.model, self.before)
        self.rng = rng

    def frame(self, body: str) -> tuple[Any, Any]:
        """Position and rotation of a body."""
        number = self.model.body(body).id
        return self.before.xpos[number].copy(), self.before.xmat[number].reshape(3, 3).copy()

    def rows(self, point: Any) -> Any:
        """(6, nv) relative velocity of the two bodies at a point."""
        one, two = (oracle.jacobian(self.model, self.before, each, point) for each in (self.one, self.two))
        return one - two

    def check(self, change: bridge.Change, expected: Any) -> None:
        assert oracle.error(self.data.qvel, expected, self.v) < EXACT
        assert change.certificate.ok
        assert change.model is self.model and change.data is self.data
        np.testing.assert_array_equal(self.data.qpos, self.before.qpos)


def weld(case: Case, method: Any) -> tuple[bridge.Change, Any]:
    expected = oracle.plastic(case.mass, case.rows(case.frame(case.one)[0]), case.v)
    return bridge.weld(case.model, case.data, case.one, case.two, method=method), expected


def ball(case: Case, method: Any) -> tuple[bridge.Change, Any]:
    at = case.rng.uniform(-0.3, 0.3, 3)
    origin, turn = case.frame(case.two)
    expected = oracle.plastic(case.mass, case.rows(origin + turn @ at)[:3], case.v)
    return bridge.attach(case.model, case.data, case.one, case.two, at=at, method=method), expected


def hinge(case: Case, method: Any) -> tuple[bridge.Change, Any]:
    axis = case.rng.normal(size=3)
    along = case.frame(case.two)[1] @ axis
    rows = case.rows(case.frame(case.one)[0])
    across = np.cross(along, rows[3:].T).T
    expected = oracle.plastic(case.mass, np.vstack([rows[:3], across]), case.v)
    return bridge.attach(case.model, case.data, case.one, case.two, axis=axis, method=method), expected


def lock(case: Case, method: Any) -> tuple[bridge.Change, Any]:
    if not case.locks:
        pytest.skip("no joint to lock")
    name = str(case.rng.choice(case.locks))
    row = np.zeros((1, case.model.nv))
    row[0, case.model.jnt_dofadr[case.model.joint(name).id]] = 1.0
    expected = oracle.plastic(case.mass, row, case.v)
    return bridge.lock(case.model, case.data, name, method=method), expected


def impulse(case: Case, method: Any) -> tuple[bridge.Change, Any]:
    force, torque, point = case.rng.normal(size=(3, 3))
    origin, turn = case.frame(case.one)
    push = oracle.jacobian(case.model, case.before, case.one, origin + turn @ point).T @ np.concatenate([force, torque])
    expected = oracle.pushed(case.mass, push, case.v)
    return bridge.impulse(case.model, case.data, case.one, force, torque, point, method=method), expected


CHANGES: list[Callable[[Case, Any], tuple[bridge.Change, Any]]] = [weld, ball, hinge, lock, impulse]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("change", CHANGES, ids=lambda each: str(each.__name__))
@pytest.mark.parametrize("seed", range(40))
def test_velocities_of_trees(seed: int, change: Callable[[Case, Any], tuple[bridge.Change, Any]], method: Any) -> None:
    case = Case(seed)
    done, expected = change(case, method)
    case.check(done, expected)
    assert done.certificate.method == ("momentree" if method == "auto" else "projection")
    if method == "auto":
        assert done.certificate.agreement is not None and done.certificate.agreement < EXACT


@pytest.mark.parametrize("change", [weld, ball, hinge], ids=lambda each: str(each.__name__))
@pytest.mark.parametrize("seed", range(20))
def test_velocities_of_loops(seed: int, change: Callable[[Case, Any], tuple[bridge.Change, Any]]) -> None:
    """Two bodies of one mechanism, or of two that are on the ground: some of these constraints are redundant."""
    sizes, two = (((6, bool(seed % 2)),), "a") if seed % 4 < 2 else (((3, False), (3, False)), "b")
    case = Case(seed, sizes, two=two)
    if case.model.body_weldid[case.model.body(case.one).id] == case.model.body_weldid[case.model.body(case.two).id]:
        pytest.skip("rigidly joined")
    done, expected = change(case, "auto")
    case.check(done, expected)
    assert done.certificate.method == "projection" and "loop" in done.certificate.reason
    with pytest.raises(mt.Error, match="momentree cannot make this change"):
        fresh = Case(seed, sizes, two=two)
        change(fresh, "momentree")


def planar_arms() -> tuple[Any, Any]:
    """Two planar double pendulums whose tips meet, with an inactive weld: three of its six directions are redundant."""
    arm = '<joint axis="0 1 0"/><inertial mass="1" pos=".5 0 0" diaginertia=".01 .1 .1"/>'
    text = f"""<mujoco><option gravity="0 0 0"/><worldbody>
      <body name="l1"> {arm}<body name="l2" pos="1 0 0">{arm}</body></body>
      <body name="r1" pos="4 0 0" euler="0 0 180">{arm}<body name="r2" pos="1 0 0">{arm}</body></body>
      </worldbody><equality><weld body1="l2" body2="r2" active="false"/></equality></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = [0.4, -0.9, 0.3, -0.2]
    data.qvel[:] = [1.0, -2.0, 0.5, 3.0]
    return model, data


def test_redundant_loop() -> None:
    model, data = planar_arms()
    before = oracle.evaluated(model, data)
    point = before.xpos[model.body("l2").id].copy()
    rows = oracle.jacobian(model, before, "l2", point) - oracle.jacobian(model, before, "r2", point)
    expected = oracle.plastic(oracle.mass_matrix(model, before), rows, before.qvel)
    certificate = bridge.weld(model, data, "l2", "r2").certificate
    assert oracle.error(data.qvel, expected, before.qvel) < EXACT
    assert not certificate.determined  # three of the six components of the impulse have no effect
    assert abs(certificate.impulse.force[1]) < 1e-12 and np.linalg.norm(certificate.impulse.torque[[0, 2]]) < 1e-12


@pytest.mark.parametrize("seed", range(20))
def test_active_constraints_transmit_impulses(seed: int) -> None:
    """A weld while another pair is welded: both constraints hold afterwards."""
    case = Case(seed, ((3, True), (3, True), (3, False)))
    rng = case.rng
    other = str(rng.choice(names(case.model, "c")))
    pairs = ((case.one, case.two), (case.two, other))
    pair = "".join(f'<weld body1="{one}" body2="{two}" active="false"/>' for one, two in pairs)
    model = model_of(np.random.default_rng(seed + 1), ((3, True), (3, True), (3, False)), pair)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = case.data.qpos, case.data.qvel
    bridge.weld(model, data, case.one, case.two)
    before = oracle.evaluated(model, data)
    rows = []
    for one, two in pairs:
        point = before.xpos[model.body(one).id].copy()
        rows.append(oracle.jacobian(model, before, one, point) - oracle.jacobian(model, before, two, point))
    expected = oracle.plastic(oracle.mass_matrix(model, before), np.vstack(rows), before.qvel)
    certificate = bridge.weld(model, data, case.two, other).certificate
    assert certificate.method == "projection" and "active constraint" in certificate.reason
    assert oracle.error(data.qvel, expected, before.qvel) < EXACT


def test_free_joint_with_armature_keeps_it() -> None:
    text = """<mujoco><option gravity="0 0 0"/><worldbody>
      <body name="a"><joint type="free" armature=".5"/><geom size=".1" mass="1"/></body>
      <body name="b" pos="1 0 0"><joint type="free" armature=".2"/><geom size=".1" mass="2"/></body></worldbody>
      <equality><weld body1="a" body2="b" active="false"/></equality></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[:] = np.random.default_rng(0).normal(size=12)
    before = oracle.evaluated(model, data)
    rows = oracle.jacobian(model, before, "a", before.xpos[1]) - oracle.jacobian(model, before, "b", before.xpos[1])
    expected = oracle.plastic(oracle.mass_matrix(model, before), rows, before.qvel)
    certificate = bridge.weld(model, data, "a", "b").certificate
    assert "armature" in certificate.reason
    assert oracle.error(data.qvel, expected, before.qvel) < EXACT


def test_bodies_that_cannot_move() -> None:
    """Static bodies, mocap bodies and the world are all the ground."""
    text = """<mujoco><option gravity="0 0 0"/><worldbody>
      <body name="shelf" pos="1 2 3" euler="10 20 30"><geom size=".1"/><body name="hook" pos=".1 0 0"/></body>
      <body name="hand" mocap="true" pos="0 0 1"/>
      <body name="a" pos="0 1 0"><freejoint/><geom size=".1" mass="1"/>
        <body name="tip" pos=".3 0 0"><joint axis="0 1 0"/><geom size=".1" mass="1" pos=".1 0 0"/></body></body></worldbody>
      <equality><weld body1="tip" body2="hook" active="false"/><connect body1="hand" body2="tip" anchor="0 0 0" active="false"/>
        <weld body1="world" body2="tip" active="false"/></equality></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    for change, three in (
        (lambda data: bridge.weld(model, data, "tip", "hook"), False),
        (lambda data: bridge.weld(model, data, "hook", "tip"), False),
        (lambda data: bridge.weld(model, data, "tip"), False),
        (lambda data: bridge.attach(model, data, "hand", "tip"), True),
        (lambda data: bridge.attach(model, data, "tip", "hand"), True),
    ):
        data = mujoco.MjData(model)
        data.qvel[:] = np.random.default_rng(0).normal(size=model.nv)
        before = oracle.evaluated(model, data)
        certificate = change(data).certificate
        point = certificate.impulse.point
        rows = oracle.jacobian(model, before, "tip", point)[: 3 if three else 6]
        expected = oracle.plastic(oracle.mass_matrix(model, before), rows, before.qvel)
        assert oracle.error(data.qvel, expected, before.qvel) < EXACT
        assert certificate.method == "momentree"


COUPLED = """<mujoco><option gravity="0 0 0" jacobian="JACOBIAN"/><worldbody>
  <body name="arm"><joint name="j0" axis="0 1 0"/><inertial mass="1" pos=".3 0 0" diaginertia=".01 .1 .1"/>
    <body name="fore" pos=".6 0 0"><joint name="j1" axis="0 1 0"/><inertial mass="1" pos=".3 0 0" diaginertia=".01 .1 .1"/>
      <body name="tip" pos=".6 0 0"><joint name="j2" axis="1 1 0"/>
        <inertial mass="1" pos=".3 0 0" diaginertia=".01 .1 .1"/></body>
    </body></body>
  <body name="wheel" pos="0 2 0"><joint name="j3" axis="0 0 1"/><inertial mass="1" pos="0 0 0" diaginertia=".1 .1 .1"/></body>
  <body name="crate" pos="1 0 1"><freejoint/><inertial mass="2" pos=".1 0 0" diaginertia=".2 .1 .1"/></body></worldbody>
  <tendon><fixed name="belt"><joint joint="j2" coef="1"/><joint joint="j3" coef="-2"/></fixed></tendon>
  <equality><joint joint1="j1" joint2="j0" polycoef="0 .5 .3 0 0"/><tendon tendon1="belt"/>
    <weld name="grasp" body1="tip" body2="crate" active="false"/></equality></mujoco>"""


@pytest.mark.parametrize("jacobian", ["dense", "sparse"])
def test_couplings_hold(jacobian: str) -> None:
    """Joints coupled by a polynomial and by a tendon: what holds is the rate that they have, even if it is not zero."""
    model = mujoco.MjModel.from_xml_string(COUPLED.replace("JACOBIAN", jacobian))
    data = mujoco.MjData(model)
    rng = np.random.default_rng(5)
    data.qpos[:4], data.qvel[:] = rng.normal(size=4), rng.normal(size=model.nv)
    before = oracle.evaluated(model, data)
    point = before.xpos[model.body("tip").id].copy()
    weld_rows = oracle.jacobian(model, before, "tip", point) - oracle.jacobian(model, before, "crate", point)
    held = np.zeros((2, model.nv))
    held[0, :2] = -(0.5 + 2 * 0.3 * data.qpos[0]), 1.0
    held[1, 2:4] = 1.0, -2.0
    certificate = bridge.weld(model, data, "tip", "crate").certificate
    assert "active constraint" in certificate.reason and certificate.ok and abs(certificate.work) > 1e-3
    np.testing.assert_allclose(weld_rows @ data.qvel, 0, atol=1e-13)
    np.testing.assert_allclose(held @ data.qvel, held @ before.qvel, atol=1e-13)
    # The change of momentum is that of impulses along these rows.
    momentum = oracle.mass_matrix(model, before) @ (data.qvel - before.qvel)
    rows = np.vstack([weld_rows, held])
    impulses = np.linalg.lstsq(rows.T, momentum, rcond=None)[0]
    np.testing.assert_allclose(rows.T @ impulses, momentum, atol=1e-12)


def test_a_body_that_a_mocap_body_drags_is_not_stopped() -> None:
    """MuJoCo moves mocap bodies without a velocity: a body that follows one has a velocity relative to it."""
    text = """<mujoco><option gravity="0 0 0"/><worldbody><body name="hand" mocap="true"/>
      <body name="a"><freejoint/><geom size=".1" mass="1"/><body name="flap" pos=".2 0 0"><joint name="flap" axis="0 1 0"/>
        <geom size=".1" mass=".5" pos=".1 0 0"/></body></body></worldbody>
      <equality><weld body1="hand" body2="a"/><joint joint1="flap" active="false"/></equality></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[:] = [0.5, 0, 0, 0, 0, 0, 3.0]
    bridge.lock(model, data, "flap")
    np.testing.assert_allclose(data.qvel, [0.5, 0, 0, 0, 0, 0, 0], atol=1e-14)


def test_two_constraints_that_contradict_each_other() -> None:
    """A joint that follows another one is locked: what is new holds, and the old constraint transmits what it can."""
    text = """<mujoco><option gravity="0 0 0"/><worldbody>
      <body><joint name="a" axis="0 0 1"/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/></body></worldbody>
      <equality><joint name="old" joint1="a"/><joint name="new" joint1="a" active="false"/></equality></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[0] = 0.25
    certificate = bridge.lock(model, data, "a", equality="new").certificate
    assert data.qvel[0] == 0.0 and certificate.ok and not certificate.determined
