"""Linearisation, equilibria and inverse kinematics."""

from __future__ import annotations

from pathlib import Path

import momentree as mt
import numpy as np
import pytest
from test_docs import ROOT

GRAVITY = 9.81
UR5 = str(ROOT / "scenarios/models/ur5/ur5_robot.urdf")


def rod(model: mt.Model, name: str, *, length: float = 1.0, mass: float = 1.0, parent: object = None, at: float = 0.0, **more: float) -> mt.ModelBody:
    """Hangs along -z for q = 0."""
    inertia = (mass * length**2 / 12, mass * length**2 / 12, 1e-4)
    where = {} if parent is None else {"parent": parent}
    q = more.pop("q", 0.0)
    joint = mt.Revolute(axis=(0, 1, 0), **more)
    return model.add(name, mass=mass, com=(0, 0, -length / 2), inertia=inertia, at=(0, 0, -at), joint=joint, q=q, **where)


def test_a_damped_pendulum() -> None:
    model = mt.Model(gravity=(0, 0, -GRAVITY))
    rod(model, "rod", damping=0.2)
    linear = mt.linearize(mt.Simulation(model))
    assert linear.names == ("rod.v0",)
    assert np.allclose(linear.A, [[0, 1], [-1.5 * GRAVITY, -0.6]], rtol=1e-13)
    assert np.allclose(linear.B, [[0], [3]])
    (mode,) = linear.modes()
    assert mode.frequency == pytest.approx(np.sqrt(1.5 * GRAVITY - 0.09) / (2 * np.pi))
    assert mode.damping_ratio == pytest.approx(0.3 / np.sqrt(1.5 * GRAVITY)) and mode.stable


def test_the_linear_equations_predict_a_small_motion() -> None:
    """Of a robot that moves: an initial change and a constant effort, over 20 ms."""
    sim, still = mt.load(UR5), mt.load(UR5)
    rng = np.random.default_rng(1)
    q, v = rng.uniform(-1, 1, len(sim.q)), rng.uniform(-1, 1, len(sim.v))
    still.set_state(q=q, v=v)
    linear = mt.linearize(still)
    size = 1e-6
    change, effort = rng.uniform(-1, 1, 2 * len(v)) * size, rng.uniform(-1, 1, len(v)) * size
    sim.set_state(q=q + change[: len(q)], v=v + change[len(q) :])
    a, b = sim.accelerations() + sim.solve_mass(effort), still.accelerations()
    predicted = linear.A @ change + linear.B @ effort
    assert np.allclose(a - b, predicted[len(v) :], atol=2e-4 * size * abs(linear.A).max())
    assert np.allclose(predicted[: len(v)], change[len(q) :])


def test_modes_with_a_closed_loop_are_those_of_the_same_mechanism_without_one() -> None:
    """A parallelogram swings as a pendulum of its bars and of the coupler's mass at their ends."""
    model = mt.Model(gravity=(0, 0, -GRAVITY))
    one = rod(model, "one", damping=0.1)
    model.add("coupler", mass=2, com=(0.25, 0, 0), inertia=(0.01, 0.05, 0.05), parent=one, at=(0, 0, -1), joint=mt.Revolute(axis=(0, 1, 0)))
    inertia = (1 / 12, 1 / 12, 1e-4)
    model.add("two", mass=1, com=(0, 0, -0.5), inertia=inertia, at=(0.5, 0, 0), joint=mt.Revolute(axis=(0, 1, 0)))
    model.add_loop("pin", body="two", to="coupler", at=(0.5, 0, 0), child_at=(0, 0, -1), joint=mt.Revolute(axis=(0, 1, 0)))
    sim = mt.Simulation(model)
    inertia_all, moment = 2 / 3 + 2, (2 * 0.5 + 2) * GRAVITY
    rest = mt.equilibrium(sim)
    assert rest.stable and len(rest.modes) == 1
    assert rest.modes[0].square == pytest.approx(moment / inertia_all, rel=1e-10)
    (mode,) = mt.linearize(sim).modes()
    assert abs(mode.eigenvalue) ** 2 == pytest.approx(moment / inertia_all, rel=1e-10)
    assert mode.eigenvalue.real == pytest.approx(-0.1 / (2 * inertia_all), rel=1e-9)


def test_equilibrium_and_what_the_simulation_does_there() -> None:
    model = mt.Model(gravity=(0, 0, -GRAVITY))
    first = rod(model, "one", stiffness=4.0, q=0.3)
    rod(model, "two", parent=first, at=1.0, stiffness=2.0, q=2.0)
    sim = mt.Simulation(model)
    before = sim.q.copy()
    rest = mt.equilibrium(sim)
    assert np.array_equal(sim.q, before)
    assert rest.stable and rest.residual < 1e-9 and rest.names == ("one.v0", "two.v0") and rest.resting == ()
    sim.set_state(q=rest.q, v=0 * sim.v)
    assert np.allclose(sim.accelerations(), 0, atol=1e-9)
    damped = mt.linearize(sim).modes()
    assert [mode.frequency for mode in damped] == pytest.approx([mode.frequency for mode in rest.modes])
    mass = sim.mass_matrix()
    for mode in rest.modes:
        assert mode.shape @ mass @ mode.shape == pytest.approx(1)


def test_an_equilibrium_that_is_unstable() -> None:
    model = mt.Model(gravity=(0, 0, -GRAVITY))
    rod(model, "rod", q=np.pi)
    sim = mt.Simulation(model)
    rest = mt.equilibrium(sim)
    assert not rest.stable and rest.modes[0].square == pytest.approx(-1.5 * GRAVITY) and rest.modes[0].frequency == 0
    assert not all(mode.stable for mode in mt.linearize(sim).modes())


def test_no_equilibrium() -> None:
    model = mt.Model(gravity=(0, 0, -GRAVITY))
    model.add("stone", mass=1, inertia=(1, 1, 1), joint=mt.Free())
    with pytest.raises(mt.Error, match="joint 'stone' still accelerates"):
        mt.equilibrium(mt.Simulation(model))


def test_functions_have_no_derivatives() -> None:
    model = mt.Model(gravity=(0, 0, -GRAVITY))
    rod(model, "rod")
    sim = mt.Simulation(model)
    sim.drive("rod", lambda world: 1.0)
    with pytest.raises(mt.Error, match="joint 'rod' is driven by a function, an elastic coupling or efforts"):
        mt.linearize(sim)
    assert mt.equilibrium(sim).q[0] == pytest.approx(np.arcsin(1 / (0.5 * GRAVITY)))


@pytest.mark.parametrize("method", ["rk4", "stepping"])
def test_bodies_that_touch_are_refused(method: str) -> None:
    model = mt.Model()
    model.add_floor(friction=0.5)
    size = {"box": [0.2, 0.2, 0.2]}
    model.add("box", density=500, shape=size, collision="shape", joint=mt.Free(), q=(0, 0, 0.11, 1, 0, 0, 0))
    sim = mt.Simulation(model, method=method, step=1e-3)
    assert np.array_equal(mt.linearize(sim).A[8, :8], np.zeros(8))  # it falls
    sim.run(1.0)
    with pytest.raises(mt.Error, match="closed contacts or taut cables"):
        mt.linearize(sim)
    with pytest.raises(mt.Error, match="bodies that can touch"):
        mt.equilibrium(sim)


def test_a_robot_reaches_poses() -> None:
    sim = mt.load(UR5)
    hand, rng = "ur5_robot/wrist_3_link", np.random.default_rng(3)
    for _ in range(20):
        there = mt.load(UR5)
        there.set_state(q=rng.uniform(-2, 2, len(sim.q)))
        body = there.world.bodies[hand]
        found = mt.inverse_kinematics(sim, mt.Target(hand, position=body.position, orientation=body.quaternion))
        assert found.reached and found.position_error <= 1e-9 and found.angle_error <= 1e-9
        sim.set_state(q=found.q)
        assert np.allclose(sim.world.bodies[hand].position, body.position, atol=1e-8)
        assert abs(sim.world.bodies[hand].quaternion @ body.quaternion) == pytest.approx(1, abs=1e-12)


def test_several_targets_and_one_that_is_too_far() -> None:
    sim = mt.load(UR5)
    elbow, hand = "ur5_robot/forearm_link", "ur5_robot/wrist_3_link"
    there = mt.load(UR5)
    there.set_state(q=[0.3, -1.2, 0.8, 0.1, 0.4, 0.0])
    bodies = there.world.bodies
    targets = [mt.Target(elbow, position=bodies[elbow].position), mt.Target(hand, position=bodies[hand].position)]
    assert mt.inverse_kinematics(sim, targets).reached
    far = mt.inverse_kinematics(sim, mt.Target(hand, position=(3, 0, 0)), attempts=3)
    assert not far.reached and 1 < far.position_error < 2.5 and far.attempts == 3


def test_a_free_body_reaches_a_place_that_is_far_away() -> None:
    model = mt.Model()
    model.add("drone", mass=1, inertia=(1, 1, 1), joint=mt.Free())
    found = mt.inverse_kinematics(mt.Simulation(model), mt.Target("drone", position=(30, -20, 1000), orientation=(0, 0, 0, 1)))
    assert found.reached and found.iterations < 30 and np.allclose(found.q[:3], (30, -20, 1000))
    with pytest.raises(mt.Error, match="expected a simulation, not Model"):
        mt.linearize(model)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("target", "message"),
    [
        (lambda: mt.Target("ur5_robot/hand", position=(0, 0, 1)), "hand"),
        (lambda: mt.Target("ur5_robot/wrist_3_link"), "no position and no orientation"),
        (lambda: mt.Target("ur5_robot/wrist_3_link", position=(0, 1)), "position"),
        (lambda: mt.Target("ur5_robot/wrist_3_link", orientation=(1, 1, 0, 0)), "unit quaternion"),
        (lambda: "ur5_robot/wrist_3_link", "must be an mt.Target"),
        (lambda: mt.Target("ur5_robot/wrist_3_link", position=(0, 0, 1), weight="much"), "weight of a target"),  # type: ignore[arg-type]
    ],
)
def test_wrong_targets(target: object, message: str) -> None:
    with pytest.raises(mt.Error, match=message):
        mt.inverse_kinematics(mt.load(UR5), target())  # type: ignore[operator]
