"""Closed loops: models, joints, changes, and round trips of worlds with loops."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import momentree as mt

AXIS = (0, 1, 0)


def four_bar(to: mt.typing.Parent = None, **loop: Any) -> mt.Model:
    """A crank, a coupler and a rocker in the plane of x and z; the rocker ends on the ground at x = 0.8 m."""
    model = mt.Model()

    def bar(name: str, length: float, parent: mt.typing.Parent, at: mt.typing.Vector, q: float, v: float = 0.0) -> mt.ModelBody:
        inertia = (1e-4, length**2 / 12, length**2 / 12)
        return model.add(
            name, mass=1, com=(length / 2, 0, 0), inertia=inertia, parent=parent, at=at, joint=mt.Revolute(AXIS), q=q, v=v
        )

    crank = bar("bar/crank", 0.3, None, (0, 0, 0), -1.2, 3.0)
    coupler = bar("bar/coupler", 0.7, crank, (0.3, 0, 0), 0.9)
    rocker = bar("bar/rocker", 0.5, coupler, (0.7, 0, 0), 1.6)
    model.add_loop("pin", body=rocker, to=to, joint=mt.Revolute(AXIS), child_at=(0.5, 0, 0), at=(0.8, 0, 0), **loop)
    return model


def test_a_model_with_a_loop_is_assembled_and_stays_closed() -> None:
    sim = mt.Simulation(four_bar())
    assert sim.integration["variables"] == "velocities"
    assert list(sim.world.joints) == ["bar/crank", "bar/coupler", "bar/rocker", "pin"]
    assert list(sim.world.loops) == ["pin"] and len(sim.world.loops) == 1
    status = sim.world.loop_status
    assert (status.rows, status.rank) == (5, 2) and status.residual < 1e-12
    sim.run(0.3)
    pin = sim.world.loops["pin"]
    assert pin.loop and pin.kind == "revolute" and pin.parent == "ground" and pin.child == "bar/rocker"
    assert pin.q.shape == pin.v.shape == (1,) and pin.p.shape == pin.pdot.shape == pin.a.shape == (0,)
    rocker = sim.world.bodies["bar/rocker"]
    w, x, y, z = rocker.quaternion
    end = rocker.position + 0.5 * np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    assert np.allclose(end, [0.8, 0, 0], atol=1e-12)
    assert np.linalg.norm(pin.reaction.force) > 0.1
    assert not pin.determined, "a planar linkage of revolute joints leaves forces out of its plane open"
    balance = sim.energy_balance
    assert set(balance) >= {"projection", "error"} and abs(balance["error"]) < 1e-6 and abs(balance["projection"]) < 1e-6
    with pytest.raises(mt.Error, match="closes no loop"):
        sim.world.loops["bar/crank"]
    with pytest.raises(mt.Error, match="pin"):
        sim.world.loops["pim"]


def test_momenta_and_velocities_describe_the_same_motion() -> None:
    runs = [mt.Simulation(four_bar(), method="dop853", rtol=1e-11, atol=1e-13, variables=v) for v in ("velocities", "momenta")]
    for sim in runs:
        sim.run(0.5)
    assert np.allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-8)
    assert np.allclose(runs[0].p, runs[1].p, rtol=0, atol=1e-7)


def test_limits_that_exclude_zero_choose_where_a_loop_closes() -> None:
    def rocker(lower: float, upper: float) -> float:
        model = mt.Model()
        crank = model.add("bar/crank", mass=1, inertia=0.01, joint=mt.Revolute(AXIS), q=-1.2)
        coupler = model.add("bar/coupler", mass=1, inertia=0.01, parent=crank, at=(0.3, 0, 0), joint=mt.Revolute(AXIS))
        joint = mt.Revolute(AXIS, limits={"lower": lower, "upper": upper})
        end = model.add("bar/rocker", mass=1, inertia=0.01, at=(0.8, 0, 0), joint=joint)
        model.add_loop("pin", body=coupler, to=end, joint=mt.Revolute(AXIS), child_at=(0.7, 0, 0), at=(0.5, 0, 0))
        assert mt.Simulation(model).world.joints["bar/crank"].q[0] == -1.2
        return float(mt.Simulation(model).world.joints["bar/rocker"].q[0])

    crank_end = 0.3 * np.array([np.cos(1.2), np.sin(1.2)]) - np.array([0.8, 0])
    apart, towards = np.hypot(*crank_end), np.arctan2(*crank_end[::-1])
    fold = np.arccos((0.5**2 + apart**2 - 0.7**2) / (2 * 0.5 * apart))
    assert rocker(-2, -1) == pytest.approx(fold - towards, rel=1e-12)
    with pytest.raises(mt.Error, match="bar/rocker.*beyond its limits"):
        rocker(-1, -0.5)


def test_what_loops_do_not_support_is_an_error() -> None:
    with pytest.raises(mt.Error, match="open at the start"):
        mt.Simulation(four_bar(assemble=False))
    with pytest.raises(mt.Error, match="can't be closed"):
        model = four_bar()
        model.add_loop("far", body="bar/crank", joint=mt.Ball(), at=(9, 0, 0))
        mt.Simulation(model)
    with pytest.raises(mt.Error, match="hard stops"):
        mt.Batch(four_bar(), 2).apply(0, mt.set_parameters("pin", limits={"lower": -3, "upper": 3}))
    with pytest.raises(mt.Error, match="can't be the child of a joint"):
        four_bar().add_loop("clasp", body="ground", to="bar/crank", joint=mt.Ball())


@pytest.mark.parametrize("variables", ["velocities", "momenta"])
def test_functions_drive_loop_joints_and_read_their_coordinates(variables: mt.typing.Variables) -> None:
    def run(model: mt.Model) -> mt.Simulation:
        return mt.Simulation(model, method="dop853", rtol=1e-11, atol=1e-13, variables=variables)

    by_law, by_function = run(four_bar()), run(four_bar())
    by_law.apply(mt.set_parameters("pin", stiffness=3.0, damping=0.2))
    by_function.drive("pin", lambda c: -3.0 * c.q("pin")[0] - 0.2 * c.v("pin")[0])
    snapshot = by_function.snapshot()
    for sim in (by_law, by_function):
        sim.run(0.3)
    assert np.allclose(by_law.q, by_function.q, rtol=0, atol=1e-8)
    effort = by_function.world.loops["pin"].effort
    assert np.allclose(effort, by_law.world.loops["pin"].effort, rtol=0, atol=1e-7)
    branch = by_function.branch()
    for sim in (branch, by_function):
        sim.run(0.4)
    assert np.array_equal(branch.q, by_function.q)
    by_function.restore(snapshot)
    by_function.run(0.3)
    by_function.run(0.4)
    assert np.array_equal(branch.q, by_function.q)

    # The function stays when the pin takes the place of a joint that breaks, also beside an extra effort.
    for sim in (by_law, by_function):
        sim.run(0.45)
    by_law.apply(mt.break_joint("bar/coupler"))
    by_function.apply(mt.break_joint("bar/coupler"))
    for sim in (by_law, by_function):
        pin = sim.world.joints["pin"]
        assert not pin.loop
        sim.effort[:] = 0
        sim.effort[pin.index] = 0.1  # every joint has one DoF
        sim.run(0.6)
    assert np.allclose(by_law.q, by_function.q, rtol=0, atol=1e-7)
    by_function.drive("pin", None)
    by_law.apply(mt.set_parameters("pin", stiffness=0.0, damping=0.0))
    for sim in (by_law, by_function):
        sim.run(0.7)
    assert np.allclose(by_law.q, by_function.q, rtol=0, atol=1e-7)


def test_an_exception_in_the_function_of_a_loop_joint_ends_the_run() -> None:
    sim = mt.Simulation(four_bar())

    def fails(context: mt.Context) -> float:
        if context.time > 0.05:
            raise ValueError("no pressure")
        return 0.0

    sim.drive("pin", fails)
    with pytest.raises(ValueError, match="no pressure"):
        sim.run(0.1)
    assert sim.world.time <= 0.05 + 1e-9


def test_mistakes_in_add_loop_leave_the_model_unchanged() -> None:
    model = four_bar()
    for error, arguments in {
        "there is no body 'bar/rod'": {"body": "bar/rod", "joint": mt.Ball()},
        "free joint constrains nothing": {"body": "bar/rocker", "joint": mt.Free()},
        "can't join a body to itself": {"body": "bar/rocker", "to": "bar/rocker", "joint": mt.Ball()},
        "armature": {"body": "bar/rocker", "joint": mt.Revolute(AXIS, armature=-1)},
        "expected a joint": {"body": "bar/rocker", "joint": "ball"},
        "damping": {"body": "bar/rocker", "joint": mt.Ball(damping=-1)},
    }.items():
        with pytest.raises(mt.Error, match=error):
            model.add_loop("other", **arguments)
    with pytest.raises(mt.Error, match="pin"):
        model.add_loop("pin", body="bar/rocker", joint=mt.Ball())
    assert model.loop_names == ["pin"]


def test_models_with_loops_survive_copies_pickles_and_texts() -> None:
    model = four_bar("bar/crank", assemble=True)
    model.add_loop("clasp", body="bar/coupler", to="bar/crank", joint=mt.Ball(stiffness=2, damping=0.1), at=(0.3, 0, 0), assemble=False)
    for other in (copy.copy(model), pickle.loads(pickle.dumps(model)), copy.deepcopy(model)):
        assert other.to_toml() == model.to_toml() and other.loop_names == ["pin", "clasp"]
    with pytest.raises(mt.Error, match="URDF has no closed loops"):
        model.to_urdf()


def test_breaks_put_the_loop_joint_into_the_tree() -> None:
    sim = mt.Simulation(four_bar())
    sim.keep_history()
    pin = sim.world.joints["pin"]
    sim.run(0.1)
    before = {name: body.linear for name, body in sim.world.bodies.items()}
    event = sim.apply(mt.break_joint("bar/coupler"))
    assert event.lost == pytest.approx(0, abs=1e-12)
    for name, body in sim.world.bodies.items():
        assert np.allclose(body.linear, before[name], atol=1e-9)
    assert len(sim.world.loops) == 0 and sim.world.loop_status.rows == 0
    assert not pin.loop and pin.name == "pin" and pin.determined, "the handle follows the joint"
    sim.run(0.2)
    sim.apply(mt.break_joint(pin))
    with pytest.raises(mt.Error, match="no longer exists"):
        print(pin.q)
    sim.undo(0)
    assert pin.loop and list(sim.world.loops) == ["pin"]
    sim.apply(mt.break_joint("pin"))
    assert "pin" not in sim.world.joints and len(sim.world.loops) == 0


def test_welds_and_attachments_make_loops() -> None:
    model = mt.Model()
    for side in (-1, 1):
        model.add(f"arm{side}/bar", mass=1, com=(0, 0, -0.5), inertia=0.1, at=(side, 0, 0), joint=mt.Ball(), v=(0.3, side, 0.1))
    sim = mt.Simulation(model, method="dop853", variables="velocities")
    event = sim.apply(mt.attach("arm1/bar", to="arm-1/bar", joint=mt.Ball(), at=(1, 0, -1)), name="clasp")
    assert list(sim.world.loops) == ["clasp"] and event.lost > 0
    assert sim.world.joints["clasp"].determined and sim.world.loop_status.rank == 3
    assert event.after.loops.rows == 3 and event.before.loops.rows == 0
    before = sim.world.bodies["arm1/bar"].angular
    assert sim.apply(mt.break_joint("clasp")).lost == pytest.approx(0, abs=1e-12)
    assert np.allclose(sim.world.bodies["arm1/bar"].angular, before, atol=1e-12)


def test_conditions_on_reactions_that_loops_leave_open() -> None:
    sim = mt.Simulation(four_bar())
    with pytest.raises(mt.Error, match="do not determine"):
        sim.when(mt.reaction("pin").force > 5)
    sim.when(mt.reaction("pin", undetermined="least_norm").force > 5).then(mt.break_joint("pin")).named("tears")
    sim.run(1)
    assert [event.name for event in sim.events] == ["tears"]
    assert "pin" not in sim.world.joints


@pytest.mark.parametrize("method", ["rk4", "midpoint", "dopri5", "dop853"])
@pytest.mark.parametrize("cut", ["pin", "bar/coupler", "bar/crank"])
def test_worlds_with_loops_go_on_bit_for_bit(method: str, cut: str) -> None:
    sim = mt.Simulation(four_bar(), method=method)
    sim.when(mt.reaction("pin", undetermined="least_norm").force > 1e6).then(mt.break_joint("pin"))
    sim.at(0.05).then(mt.break_joint(cut))
    sim.at(0.09).then(mt.weld("bar/rocker", to="bar/crank")).named("clasp")
    for until in (0.03, 0.07, 0.12):
        sim.run(until)
        others = [pickle.loads(pickle.dumps(sim)), sim.branch()]
        again = sim.branch()
        again.restore(sim.snapshot())
        others.append(again)
        reference = sim.branch()
        reference.run(0.2)
        for other in others:
            other.run(0.2)
            assert other.state_json() == reference.state_json()


def test_runs_have_columns_of_loop_joints() -> None:
    sim = mt.Simulation(four_bar())
    run = sim.run(0.1, record_every=0.01, reactions=True)
    pin = run.joints["pin"]
    assert pin.q.shape[1] == 1 and np.isfinite(pin.q).all() and np.isfinite(pin.reaction.force).all()
    assert np.isnan(pin.p).all() or pin.p.shape[1] == 0


@pytest.mark.parametrize("variables", [None, "velocities", "momenta"])
def test_worlds_of_batches_with_loops_equal_simulations(variables: Any) -> None:
    generator = np.random.default_rng(5)
    h, worlds, steps = 2.0**-10, 12, 60
    changes = [
        [mt.break_joint("pin")],
        [mt.break_joint("bar/coupler")],
        [mt.lock("bar/crank")],
        [mt.weld("bar/rocker", "bar/crank")],
        [mt.attach("bar/coupler", "ground", mt.Ball())],
        [mt.set_parameters("pin", damping=0.5), mt.lock("bar/rocker")],
    ]
    batch = mt.Batch(four_bar(), worlds, threads=2, variables=variables)
    sims = [mt.Simulation(four_bar(), method="rk4", step=h, variables=variables) for _ in range(worlds)]
    assert batch.joints["pin"].q.shape == (worlds, 1) and np.isnan(batch.joints["pin"].p).all()
    speeds = generator.uniform(-3, 3, (worlds, 3))
    batch.v = speeds
    for sim, v in zip(sims, speeds):
        sim.set_state(v=v)
    assert np.allclose(batch.v, [sim.v for sim in sims], rtol=0, atol=1e-12)
    for step in range(steps):
        batch.step(h)
        for world, sim in enumerate(sims):
            sim.run((step + 1) * h)
            q, p, v = (batch._read([world], which)[0] for which in ("q", "p", "v"))
            assert np.allclose(q, sim.q, rtol=0, atol=1e-10) and np.allclose(v, sim.v, rtol=0, atol=1e-9)
            assert np.allclose(p, sim.p, rtol=0, atol=1e-9)
            if step == 5 + 4 * world:
                one, other = batch.apply(world, *changes[world % 6], name="change")[0], sim.apply(*changes[world % 6], name="change")
                assert np.isclose(one.lost, other.lost, rtol=0, atol=1e-9) and one.mechanisms_after == other.mechanisms_after
        pin = batch.joints["pin"]
        for world, sim in enumerate(sims):  # in the tree or not
            if "pin" in sim.world.joints:
                joint = sim.world.joints["pin"]
                assert np.allclose(pin.q[world], joint.q, rtol=0, atol=1e-10) and np.allclose(pin.v[world], joint.v, rtol=0, atol=1e-8)
            else:
                assert np.isnan(pin.q[world]).all()
    assert not batch.diverged.any() and len(batch.groups) >= 6


def test_states_of_batches_are_closed_or_refused() -> None:
    batch = mt.Batch(four_bar(), 3)
    sim = mt.Simulation(four_bar())
    open_q = sim.q + [0.02, -0.01, 0.015]
    sim.set_state(q=open_q)
    batch.set_state([0, 2], q=open_q)
    assert np.array_equal(batch._read([0], "q")[0], sim.q) and not np.allclose(sim.q, open_q, rtol=0, atol=1e-4)
    model = four_bar()
    model.add_coupling("bar/crank", multiplier=0, offset=0.1)
    coupled = mt.Batch(model, 2)
    assert coupled.variables == "velocities" and np.allclose(coupled.joints["bar/crank"].q, 0.1)
    momenta = mt.Batch(model, 2, variables="momenta")
    assert momenta.variables == "momenta" and np.allclose(momenta.joints["bar/crank"].q, 0.1)
