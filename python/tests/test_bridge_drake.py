"""The Drake bridge: velocities against Drake's mass matrix and Jacobians in 50 digits, locks, constraints, new plants."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("pydrake")
pytest.importorskip("mpmath")

from pydrake.math import RigidTransform  # noqa: E402
from pydrake.multibody import tree  # noqa: E402
from pydrake.multibody.plant import MultibodyPlant  # noqa: E402
from pydrake.systems.analysis import Simulator  # noqa: E402

import bridge_oracle as oracle  # noqa: E402
import momentree as mt  # noqa: E402
from bridge_plants import OTHERS, SIMPLE, jacobian, plant_of, state_of  # noqa: E402
from momentree.bridge import drake as bridge  # noqa: E402

EXACT = 1e-12


class Case:
    """Two random mechanisms in a random state; ``one`` and ``two`` are a body of each."""

    def __init__(self, seed: int, kinds: tuple[str, ...], step: float = 1e-3) -> None:
        self.rng = rng = np.random.default_rng(seed)
        self.sizes = ((int(rng.integers(2, 7)), True), (int(rng.integers(2, 7)), bool(rng.random() < 0.5)))
        self.plant = plant_of(rng, self.sizes, kinds, step)
        self.context = state_of(rng, self.plant)
        self.one, self.two = f"a{rng.integers(self.sizes[0][0])}", f"b{rng.integers(self.sizes[1][0])}"
        self.v = np.array(self.plant.GetVelocities(self.context))
        self.q = np.array(self.plant.GetPositions(self.context))
        self.mass = np.array(self.plant.CalcMassMatrix(self.context))

    def pose(self, body: str) -> Any:
        return self.plant.EvalBodyPoseInWorld(self.context, self.plant.GetBodyByName(body))

    def rows(self, point: Any) -> Any:
        return jacobian(self.plant, self.context, self.one, point) - jacobian(self.plant, self.context, self.two, point)

    def check(self, certificate: bridge.Certificate, expected: Any) -> None:
        assert oracle.error(np.array(self.plant.GetVelocities(self.context)), expected, self.v) < EXACT
        np.testing.assert_array_equal(self.plant.GetPositions(self.context), self.q)
        assert certificate.ok


def weld(case: Case) -> tuple[bridge.Certificate, Any]:
    expected = oracle.plastic(case.mass, case.rows(case.pose(case.one).translation()), case.v)
    return bridge.weld(case.plant, case.context, case.one, case.two), expected


def ball(case: Case) -> tuple[bridge.Certificate, Any]:
    at = case.rng.uniform(-0.3, 0.3, 3)
    expected = oracle.plastic(case.mass, case.rows(case.pose(case.two) @ at)[:3], case.v)
    return bridge.attach(case.plant, case.context, case.one, case.two, at=at), expected


def hinge(case: Case) -> tuple[bridge.Certificate, Any]:
    axis = case.rng.normal(size=3)
    along = case.pose(case.two).rotation().matrix() @ axis
    rows = case.rows(case.pose(case.one).translation())
    expected = oracle.plastic(case.mass, np.vstack([rows[:3], np.cross(along, rows[3:].T).T]), case.v)
    return bridge.attach(case.plant, case.context, case.one, case.two, axis=axis), expected


def lock(case: Case) -> tuple[bridge.Certificate, Any]:
    joints = [case.plant.get_joint(index) for index in case.plant.GetJointIndices()]
    movable = [joint for joint in joints if joint.num_velocities()]
    joint = movable[case.rng.integers(len(movable))]
    rows = np.eye(len(case.v))[joint.velocity_start() : joint.velocity_start() + joint.num_velocities()]
    expected = oracle.plastic(case.mass, rows, case.v)
    certificate = bridge.lock(case.plant, case.context, joint)
    assert joint.is_locked(case.context)
    return certificate, expected


def impulse(case: Case) -> tuple[bridge.Certificate, Any]:
    force, torque, point = case.rng.normal(size=(3, 3))
    push = jacobian(case.plant, case.context, case.one, case.pose(case.one) @ point).T @ np.concatenate([force, torque])
    expected = oracle.pushed(case.mass, push, case.v)
    return bridge.impulse(case.plant, case.context, case.one, force, torque, point), expected


@pytest.mark.parametrize("change", [weld, ball, hinge, lock, impulse], ids=lambda each: str(each.__name__))
@pytest.mark.parametrize("kinds", [SIMPLE, OTHERS], ids=["simple", "others"])
@pytest.mark.parametrize("seed", range(15))
def test_velocities(seed: int, kinds: tuple[str, ...], change: Any) -> None:
    case = Case(seed, kinds, 1e-3 if seed % 2 else 0.0)
    certificate, expected = change(case)
    case.check(certificate, expected)
    if kinds is SIMPLE:
        assert certificate.method == "momentree" and certificate.agreement is not None
    elif certificate.method == "projection":
        assert "a joint is of the kind" in certificate.reason


def test_velocities_of_loops() -> None:
    plant = plant_of(np.random.default_rng(0), ((3, False), (4, False)))
    context = state_of(np.random.default_rng(1), plant)
    v, mass = np.array(plant.GetVelocities(context)), np.array(plant.CalcMassMatrix(context))
    point = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName("a2")).translation()
    rows = jacobian(plant, context, "a2", point) - jacobian(plant, context, "b3", point)
    certificate = bridge.weld(plant, context, "a2", "b3")
    assert "loop" in certificate.reason
    assert oracle.error(np.array(plant.GetVelocities(context)), oracle.plastic(mass, rows, v), v) < EXACT
    with pytest.raises(mt.Error, match="momentree cannot make this change"):
        bridge.weld(plant, context, "a2", "b3", method="momentree")


def test_a_lock_keeps_the_momentum_and_holds() -> None:
    """``Joint.Lock`` alone takes the momentum of the locked joint away."""
    plant = plant_of(np.random.default_rng(5), ((4, True),), ("revolute",))
    by_hand, bridged = (state_of(np.random.default_rng(2), plant) for _ in range(2))

    def momentum(context: Any) -> Any:
        found = plant.CalcSpatialMomentumInWorldAboutPoint(context, np.zeros(3))
        return np.concatenate([found.translational(), found.rotational()])

    before = momentum(by_hand)
    joint = plant.GetJointByName("ja1")
    joint.Lock(by_hand)
    certificate = bridge.lock(plant, bridged, "ja1")
    assert np.linalg.norm(momentum(by_hand) - before) > 0.1
    assert np.linalg.norm(momentum(bridged) - before) < 1e-12
    assert certificate.drift < 1e-12 and certificate.lost > 0
    simulator = Simulator(plant, bridged)
    position = joint.GetOnePosition(bridged)
    simulator.AdvanceTo(0.2)
    assert joint.GetOnePosition(bridged) == position
    rows = np.eye(plant.num_velocities())[joint.velocity_start()][None, :]
    v, mass = np.array(plant.GetVelocities(bridged)), np.array(plant.CalcMassMatrix(bridged))
    push = jacobian(plant, bridged, "a3", plant.EvalBodyPoseInWorld(bridged, plant.GetBodyByName("a3")).translation()).T
    free = oracle.pushed(mass, push @ [1.0, 2, 3, 0, 0, 0], v)
    bridge.impulse(plant, bridged, "a3", force=(1, 2, 3))  # the lock transmits it
    assert oracle.error(np.array(plant.GetVelocities(bridged)), oracle.plastic(mass, rows, free), v) < EXACT
    released = bridge.unlock(plant, bridged, "ja1")
    assert released.method == "none" and not joint.is_locked(bridged)
    with pytest.raises(mt.Error, match="is not locked"):
        bridge.unlock(plant, bridged, "ja1")


def docking(gap: float) -> tuple[Any, Any, bridge.Reserved]:
    """Two free bodies, ``gap`` away from the pose that a reserved weld holds."""
    reserved: list[bridge.Reserved] = []
    pose, other = RigidTransform([0.5, 0.1, 0]), RigidTransform([-0.4, 0, 0.2])

    def add(plant: Any) -> None:
        reserved.append(bridge.reserve(plant, "a0", "b0", pose, other))

    plant = plant_of(np.random.default_rng(3), ((2, True), (2, True)), before=add)
    context = state_of(np.random.default_rng(4), plant)
    one = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName("a0"))
    shifted = one @ pose @ RigidTransform([gap, 0, 0]) @ other.inverse()
    plant.SetFloatingBaseBodyPoseInWorldFrame(context, plant.GetBodyByName("b0"), shifted)
    plant.SetConstraintActiveStatus(context, reserved[0].constraint, False)
    return plant, context, reserved[0]


def test_a_reserved_weld_holds_and_breaks() -> None:
    plant, context, dock = docking(0.0)
    certificate = bridge.weld(plant, context, "a0", "b0", constraint=dock)
    assert certificate.ok and plant.GetConstraintActiveStatus(context, dock.constraint)
    between = [plant.GetBodyByName(name) for name in ("a0", "b0")]
    held = between[1].body_frame().CalcPose(context, between[0].body_frame())
    Simulator(plant, context).AdvanceTo(0.3)
    after = between[1].body_frame().CalcPose(context, between[0].body_frame())
    assert np.linalg.norm(after.translation() - held.translation()) < 1e-3
    with pytest.raises(mt.Error, match="Drake does not tell which bodies it joins"):
        bridge.impulse(plant, context, "a0", force=(1, 0, 0))
    before = np.array(plant.GetVelocities(context))
    certificate = bridge.impulse(plant, context, "a0", force=(1, 0, 0), reserved=[dock])
    assert "active constraint" in certificate.reason and np.linalg.norm(plant.GetVelocities(context) - before) > 0.1
    released = bridge.break_(plant, context, dock)
    assert released.method == "none" and not plant.GetConstraintActiveStatus(context, dock.constraint)
    with pytest.raises(mt.Error, match="is not active"):
        bridge.break_(plant, context, dock)


def test_a_reserved_weld_of_another_pose_is_refused() -> None:
    plant, context, dock = docking(0.05)
    before = np.array(plant.GetPositionsAndVelocities(context))
    with pytest.raises(mt.Error, match="0.05 m .* Drake would pull them together"):
        bridge.weld(plant, context, "a0", "b0", constraint=dock)
    with pytest.raises(mt.Error, match="between other bodies"):
        bridge.weld(plant, context, "a1", "b0", constraint=dock)
    np.testing.assert_array_equal(plant.GetPositionsAndVelocities(context), before)
    assert not plant.GetConstraintActiveStatus(context, dock.constraint)


def arm(broken: bool, welded: RigidTransform | None = None, step: float = 0.0) -> Any:
    """A double pendulum with a free crate; without the elbow, or with the crate welded to the forearm."""
    plant = MultibodyPlant(step)
    inertia = tree.SpatialInertia.SolidBoxWithMass(1.0, 0.4, 0.05, 0.05).Shift([-0.2, 0, 0])
    upper, fore = plant.AddRigidBody("upper", inertia), plant.AddRigidBody("fore", inertia)
    crate = plant.AddRigidBody("crate", tree.SpatialInertia.SolidBoxWithMass(2.0, 0.2, 0.3, 0.1))
    plant.AddJoint(tree.RevoluteJoint("shoulder", plant.world_frame(), upper.body_frame(), [0, 1, 0]))
    if not broken:
        outer = plant.AddFrame(tree.FixedOffsetFrame("outer", upper.body_frame(), RigidTransform([0.4, 0, 0])))
        plant.AddJoint(tree.RevoluteJoint("elbow", outer, fore.body_frame(), [0, 1, 0]))
    if welded is not None:
        plant.AddJoint(tree.WeldJoint("grasp", fore.body_frame(), crate.body_frame(), welded))
    plant.Finalize()
    return plant


def moving_arm() -> tuple[Any, Any]:
    plant = arm(broken=False)
    context = plant.CreateDefaultContext()
    plant.SetFloatingBaseBodyPoseInWorldFrame(context, plant.GetBodyByName("crate"), RigidTransform([0.8, 0.2, 0.1]))
    for name, angle in (("shoulder", 0.3), ("elbow", -0.7)):
        plant.GetJointByName(name).set_angle(context, angle)
    plant.SetVelocities(context, np.linspace(-1, 2, plant.num_velocities()))
    context.SetTime(0.7)
    return plant, context


def motions(plant: Any, context: Any) -> Any:
    """Positions and velocities of the bodies."""
    found = []
    for name in ("upper", "fore", "crate"):
        body = plant.GetBodyByName(name)
        motion = plant.EvalBodySpatialVelocityInWorld(context, body)
        pose = plant.EvalBodyPoseInWorld(context, body)
        parts = pose.translation(), pose.rotation().matrix().ravel(), motion.translational(), motion.rotational()
        found.append(np.concatenate(parts))
    return np.array(found)


def test_a_joint_breaks_by_a_new_plant() -> None:
    plant, context = moving_arm()
    new_plant = arm(broken=True)
    new_context = new_plant.CreateDefaultContext()
    certificate = bridge.transfer(plant, context, new_plant, new_context)
    assert certificate.ok and new_context.get_time() == 0.7
    np.testing.assert_allclose(motions(new_plant, new_context), motions(plant, context), atol=1e-14)
    Simulator(new_plant, new_context).AdvanceTo(1.0)
    assert np.linalg.norm(motions(new_plant, new_context)[1, :3] - motions(plant, context)[1, :3]) > 0.1


def test_a_weld_continues_in_a_new_plant() -> None:
    plant, context = moving_arm()
    fore, crate = plant.GetBodyByName("fore"), plant.GetBodyByName("crate")
    pose = crate.body_frame().CalcPose(context, fore.body_frame())
    new_plant = arm(broken=False, welded=pose)
    new_context = new_plant.CreateDefaultContext()
    untouched = np.array(new_plant.GetPositionsAndVelocities(new_context))
    with pytest.raises(mt.Error, match="do not allow the present velocities"):
        bridge.transfer(plant, context, new_plant, new_context)  # before the impact
    np.testing.assert_array_equal(new_plant.GetPositionsAndVelocities(new_context), untouched)
    bridge.weld(plant, context, "crate", "fore")
    bridge.transfer(plant, context, new_plant, new_context)
    np.testing.assert_allclose(motions(new_plant, new_context), motions(plant, context), atol=1e-13)
    other = arm(broken=False, welded=pose @ RigidTransform([0.01, 0, 0]))
    with pytest.raises(mt.Error, match="would be displaced by 0.01"):
        bridge.transfer(plant, context, other, other.CreateDefaultContext())


@pytest.mark.parametrize(
    ("text", "attempt"),
    [
        ("named 'hand'", lambda p, c: bridge.weld(p, c, "hand", "fore")),
        ("joined to itself", lambda p, c: bridge.weld(p, c, "fore", "fore")),
        ("named 'knee'", lambda p, c: bridge.lock(p, c, "knee")),
        ("not exact enough", lambda p, c: bridge.weld(p, c, "crate", "fore", tolerance=1e-30)),
        ("at has three finite numbers", lambda p, c: bridge.attach(p, c, "crate", "fore", at=(0, 0))),
        ("axis of a hinge is not zero", lambda p, c: bridge.attach(p, c, "crate", "fore", axis=(0, 0, 0))),
        ("is not locked", lambda p, c: bridge.unlock(p, c, "elbow")),
    ],
)
def test_nothing_changes_on_failure(text: str, attempt: Any) -> None:
    plant, context = moving_arm()
    before = np.array(plant.GetPositionsAndVelocities(context))
    with pytest.raises(mt.Error, match=text):
        attempt(plant, context)
    np.testing.assert_array_equal(plant.GetPositionsAndVelocities(context), before)
    assert not plant.GetJointByName("elbow").is_locked(context)
