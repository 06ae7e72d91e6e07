"""Batches of worlds with contact, cables, stops and strengths, which are stepped one by one."""

import momentree as mt
import numpy as np
import pytest


def boxes_above_floor():
    model = mt.Model()
    for name, x in (("one/box", 0.0), ("two/box", 1.0)):
        model.add(name, mass=2, inertia=0.0133, joint=mt.Free(), q=[x, 0, 0.15, 1, 0, 0, 0], shape={"box": [0.2, 0.2, 0.2]},
                  collision="shape")
    model.add_floor(friction=0.5)
    return model


def arm_above_floor():
    model = mt.Model()
    model.add("arm", mass=2, com=[0.5, 0, 0], inertia=[0.01, 0.2, 0.2], at=[0, 0, 0.1], joint=mt.Revolute([0, 1, 0]),
              collision=[{"sphere": 0.1, "at": {"xyz": [1, 0, 0]}}])
    model.add_floor(friction=0)
    return model


@pytest.mark.parametrize("method", ["stepping", "rk4"])
def test_worlds_move_as_simulations(method):
    model = boxes_above_floor()
    batch = mt.Batch(model, worlds=3, threads=2, contact_method=method, step=2e-3)
    assert batch.lanes == 1
    assert batch.variables == "velocities"
    sim = mt.Simulation(model, method=method, step=2e-3)
    for _ in range(30):
        batch.step(0.01)
        sim.run(sim.time + 0.01)
    np.testing.assert_array_equal(batch.q[2], sim.q)
    np.testing.assert_array_equal(batch.v[2], sim.v)
    contacts = batch.contacts(1)
    assert len(contacts) == 8
    assert {(c.one, c.other) for c in contacts} == {("one/box", "ground"), ("two/box", "ground")}
    forces = batch.contact_forces("one/box")
    assert forces.shape == (3, 3)
    np.testing.assert_allclose(forces, [[0, 0, 2 * 9.81]] * 3, atol=1e-6)
    np.testing.assert_allclose(batch.contact_forces("ground", [0]), [[0, 0, -4 * 9.81]], atol=1e-6)
    with pytest.raises(ValueError, match="read-only"):
        forces[0, 0] = 1


def test_worlds_that_are_set_go_on_and_impossible_ones_stay():
    batch = mt.Batch(boxes_above_floor(), worlds=4, threads=1)
    start = batch.q[0].copy()
    batch.run(0.01, steps=30)
    high = start.copy()
    high[2] = 0.3
    batch.set_state([1, 2], q=high, v=np.zeros(12), time=0)
    assert not batch.contacts(1)
    np.testing.assert_array_equal(batch.contact_forces("one/box", [1])[0], 0)
    sunk = high.copy()
    sunk[2] = 0.05
    batch.set_state(3, q=sunk)
    batch.step(0.01)
    np.testing.assert_array_equal(batch.diverged, [False, False, False, True])
    assert "'one/box' and 'ground' overlap by 0.05 m" in batch.message(3)
    assert batch.message(0) == ""
    np.testing.assert_array_equal(batch.q[3], sunk)
    np.testing.assert_array_equal(batch.q[1], batch.q[2])
    assert batch.q[1, 2] == pytest.approx(0.3 - 0.5 * 9.81 * 0.01**2)
    batch.set_state(3, q=high)
    batch.step(0.01)
    assert not batch.diverged.any()


def test_efforts_and_contact_carry_the_weight():
    batch = mt.Batch(arm_above_floor(), worlds=3)
    batch.effort = [[0.0], [-4.0], [3.0]]
    batch.run(0.01, steps=20)
    np.testing.assert_allclose(batch.contact_forces("arm")[:, 2], [9.81, 5.81, 12.81], atol=1e-6)
    batch.set_effort([-20.0], [0])
    batch.step(0.05)
    assert batch.q[0, 0] < -0.001
    assert batch.contact_forces("arm")[0, 2] == 0


def test_actions_events_and_groups():
    batch = mt.Batch(boxes_above_floor(), worlds=3, contact_method="rk4")
    batch.step(0.2)
    assert any(event.contact is not None for event in batch.events(0))
    events = batch.apply([1], mt.weld("one/box", "ground"), name="held")
    assert [event.name for event in events] == ["held"]
    assert "held" in [event.name for event in batch.events(1)]
    np.testing.assert_array_equal(batch.group, [0, 1, 0])
    batch.run(0.01, steps=5)
    assert batch.events(1) == []
    assert not batch.diverged.any()
    np.testing.assert_array_equal(batch.contact_forces("one/box")[1], 0)  # bodies that are welded do not touch


def test_strengths_stops_and_springs_without_contact():
    model = mt.Model()
    model.add("upper", mass=1, com=[0, 0, -0.25], inertia=0.02, joint=mt.Revolute([0, 1, 0], limits={"lower": -0.2}), q=1.0)
    model.add("lower", mass=1, com=[0, 0, -0.25], inertia=0.02, parent="upper", at=[0, 0, -0.5],
              joint=mt.Revolute([0, 1, 0], strength={"force": 12}))
    batch = mt.Batch(model, worlds=2, variables="momenta")
    sim = mt.Simulation(model, method="rk4", variables="momenta")
    for _ in range(100):
        batch.step(0.01)
        sim.run(sim.time + 0.01)
    assert batch.lanes == 1
    assert any(event.name == "strength of lower" for event in sim.events)
    np.testing.assert_array_equal(batch.q[1], sim.q)
    np.testing.assert_array_equal(batch.p[1], sim.p)
    assert np.isnan(batch.joints["lower"].q).all()


def test_mistakes():
    model = boxes_above_floor()
    with pytest.raises(mt.Error, match="can't step contact by the method 'euler'; use one of.*\"stepping\""):
        mt.Batch(model, worlds=2, contact_method="euler")
    with pytest.raises(mt.Error, match="step"):
        mt.Batch(model, worlds=2, step=-1)
    model.add("three/box", mass=1, inertia=0.01, joint=mt.Free(), q=[0, 0, 0.1, 1, 0, 0, 0], collision={"sphere": 0.1})
    with pytest.raises(mt.Error, match="'one/box' and 'three/box' overlap by"):
        mt.Batch(model, worlds=2)
    batch = mt.Batch(boxes_above_floor(), worlds=2)
    for call in (lambda: batch.contacts(2), lambda: batch.events(-1), lambda: batch.contact_forces("one/box", [2])):
        with pytest.raises(mt.Error, match="there is no world"):
            call()
    with pytest.raises(mt.Error, match="did you mean 'one/box'"):
        batch.contact_forces("one/boxx")


def four_bar():
    model = mt.Model(gravity=(0, 0, -9.81))
    for name, parent, at, q in (("bar/a", None, (0, 0, 0), 0.4), ("bar/b", "bar/a", (1, 0, 0), 0.9), ("bar/c", "bar/b", (1, 0, 0), 0.8)):
        model.add(name, mass=1, com=(0.5, 0, 0), inertia=0.1, parent=parent, at=at, joint=mt.Revolute((0, 1, 0)), q=q)
    model.add_loop("bar/close", body="bar/c", joint=mt.Revolute((0, 1, 0)), at=(0.8, 0, -1), child_at=(1, 0, 0))
    return model


@pytest.mark.parametrize("make", [boxes_above_floor, arm_above_floor, four_bar])
@pytest.mark.parametrize("every", [True, False])
def test_worlds_that_are_reset_begin_again(make, every):
    model = make()
    fresh, batch = mt.Batch(model, worlds=5), mt.Batch(model, worlds=5)
    names = list(mt.Simulation(model).world.joints)
    batch.effort = np.full((5, batch.v.shape[1]), 0.3)
    batch.apply([1, 3], mt.break_joint(names[-1]) if len(names) > 1 else mt.free_joint(names[0]))
    batch.apply([2], mt.lock(names[0]))
    batch.run(0.01, steps=20)
    worlds = [0, 1, 2, 3, 4] if every else [3, 2, 0, 3]
    batch.reset(None if every else worlds)
    np.testing.assert_array_equal(batch.joints[names[0]].q[worlds], fresh.joints[names[0]].q[worlds])
    for each in (fresh, batch):
        each.apply([2], mt.lock(names[0]), name="again")
        each.run(0.01, steps=20)
    for name in names:
        for one, other in zip(fresh.joints[name], batch.joints[name]):
            np.testing.assert_array_equal(one[worlds], other[worlds])
    if every:
        np.testing.assert_array_equal(batch.group, fresh.group)
    with pytest.raises(mt.Error, match="no world 5"):
        batch.reset([5])


def test_efforts_by_the_names_of_joints():
    model = mt.Model()
    model.add("arm/a", mass=1, com=(0, 0, -0.5), inertia=0.1, joint=mt.Revolute((0, 1, 0)))
    model.add("arm/b", mass=1, com=(0, 0, -0.5), inertia=0.1, parent="arm/a", at=(0, 0, -1), joint=mt.Ball())
    one, other = mt.Batch(model, 3), mt.Batch(model, 3)
    one.set_effort({"arm/b": [[1, 2, 3]] * 3, "arm/a": [5, 6, 7]})
    other.effort = [[5, 1, 2, 3], [6, 1, 2, 3], [7, 1, 2, 3]]
    for each in (one, other):
        each.apply([1], mt.break_joint("arm/b"))
    one.set_effort({"arm/a": 2.5}, [1])
    other.set_effort([2.5, *[0] * 6], [1])
    for each in (one, other):
        each.run(0.01, 10)
    np.testing.assert_array_equal(one.joints["arm/a"].q, other.joints["arm/a"].q)
    with pytest.raises(mt.Error, match="no joint 'arm/c'"):
        one.set_effort({"arm/c": 1}, [0, 2])
    with pytest.raises(mt.Error, match=r"needs a number or an array of shape \(2,\) or \(2, 1\), found \(3,\)"):
        one.set_effort({"arm/a": [1, 2, 3]}, [0, 2])
    assert "one by one" not in repr(one) and "stepped one by one" in repr(mt.Batch(boxes_above_floor(), 2))
