"""What can be read of a simulation and its run: quantities, bodies in the world, contacts, and events that can be undone."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_models import random_model, random_state

import momentree as mt

SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"
seeds = st.integers(0, 2**32 - 1)


def dropped_box(method: str = "rk4") -> mt.Simulation:
    model = mt.Model()
    model.add("box/box", mass=2, inertia=0.0133, joint=mt.Free(), q=[0, 0, 0.3, 1, 0, 0, 0], shape={"box": [0.2, 0.2, 0.2]},
              collision="shape")  # fmt: skip
    model.add_floor(friction=0.5)
    return mt.Simulation(model, method=method)


def test_a_path_in_place_of_a_model_is_loaded() -> None:
    one, two = mt.Simulation(SCENARIOS / "pendulum.toml"), mt.load(SCENARIOS / "pendulum.toml")
    one.run(0.1)
    two.run(0.1)
    assert np.array_equal(one.q, two.q)
    assert mt.Simulation(str(SCENARIOS / "pendulum.toml"), step="2 ms").integration["step"] == 2e-3
    adaptive = SCENARIOS / "bicycle.toml"
    assert mt.Simulation(adaptive).integration["method"] == "dop853"
    assert mt.Simulation(adaptive, method="rk4", step=1e-3).integration["method"] == "rk4"
    with pytest.raises(mt.Error, match="no such file"):
        mt.Simulation("nothing.toml")


@given(seeds)
def test_quantities_have_the_values_of_what_they_are_of(seed: int) -> None:
    sim = mt.Simulation(random_model(seed, 5))
    random_state(sim, seed)
    for name, body in sim.world.bodies.items():
        up = -np.asarray(sim.model.gravity) / max(np.linalg.norm(sim.model.gravity), 1e-300)
        if np.any(sim.model.gravity):
            assert sim.value(mt.height(name)) == pytest.approx(up @ body.position, abs=1e-12)
        assert sim.value(mt.distance(name, "ground")) == pytest.approx(np.linalg.norm(body.position), abs=1e-12)
    for name, joint in sim.world.joints.items():
        assert sim.value(mt.reaction(name).force) == pytest.approx(np.linalg.norm(joint.reaction.force), rel=1e-12)
        if len(joint.v) == 1:
            assert sim.value(mt.speed(name)) == joint.v[0] and sim.value(mt.position(name)) == joint.q[0]
    assert sim.value(mt.measured(lambda world: world.time)) == sim.time


def test_values_of_nothing() -> None:
    sim = mt.load(SCENARIOS / "crane.toml")
    sim.apply(mt.break_joint("crane/rope3"))
    assert np.isnan(sim.value(mt.reaction("crane/rope3").force))
    with pytest.raises(mt.Error, match="there is no body 'nobody'"):
        sim.value(mt.height("nobody"))
    with pytest.raises(mt.Error, match="expected a quantity, found int"):
        sim.value(3)  # type: ignore[arg-type]


@given(seeds)
def test_bodies_in_the_world_explain_momenta_and_energy(seed: int) -> None:
    sim = mt.Simulation(random_model(seed, 5))
    random_state(sim, seed)
    linear, angular, kinetic = np.zeros(3), np.zeros(3), 0.0
    for body in sim.world.bodies.values():
        assert np.allclose(body.rotation @ body.rotation.T, np.eye(3)) and np.linalg.det(body.rotation) > 0
        spin = body.inertia @ body.angular
        linear += body.mass * body.com_velocity
        angular += np.cross(body.com_position, body.mass * body.com_velocity) + spin
        kinetic += 0.5 * (body.mass * body.com_velocity @ body.com_velocity + body.angular @ spin)
    size = max(np.linalg.norm(sim.momentum.linear), np.linalg.norm(sim.momentum.angular), 1)
    assert np.allclose(linear, sim.momentum.linear, atol=1e-9 * size)
    assert np.allclose(angular, sim.momentum.angular, atol=1e-9 * size)
    armature = sum(0.5 * joint.v @ joint.v for joint in sim.world.joints.values())  # at most, of unit armatures
    assert kinetic <= sim.energy.kinetic * (1 + 1e-9) + 1e-9 and sim.energy.kinetic <= kinetic + 100 * armature + 1e-9


@pytest.mark.parametrize("method", ["rk4", "stepping"])
def test_contacts_of_a_run_carry_the_weight(method: str) -> None:
    run = dropped_box(method).run(1.0, reactions=True)
    contacts = run.contacts
    end = contacts[contacts["time"] == run.time[-1]]
    assert set(end["one"]) == {"box/box"} and set(end["other"]) == {"ground"}
    assert np.allclose(end["force"].sum(axis=0), (0, 0, 2 * 9.81), atol=1e-6)
    assert np.all(end["normal"] == (0, 0, 1)) and np.allclose(end["point"][:, 2], 0, atol=1e-4)
    assert np.array_equal(pickle.loads(pickle.dumps(run)).contacts["force"], contacts["force"])
    with pytest.raises(mt.Error, match="with reactions only"):
        _ = dropped_box().run(0.1).contacts


def test_the_last_events_can_be_undone_without_notice() -> None:
    sim = mt.load(SCENARIOS / "crane.toml")
    sim.run(1.0)
    before = sim.q.copy()
    sim.apply(mt.break_joint("crane/rope3"))
    sim.run(1.2)
    sim.undo()
    assert sim.time == 1.0 and np.array_equal(sim.q, before)
    for _ in range(150):
        sim.apply(mt.set_parameters("crane/rail", damping=1))
        sim.step()
    with pytest.raises(mt.Error, match="was not kept"):
        sim.undo(0)
    sim.undo(-100)
    for most, count in ((10, 6), (3, 1)):
        sim.keep_history(most)
        for _ in range(count):
            sim.apply(mt.set_parameters("crane/rail", damping=2))
    with pytest.raises(mt.Error, match="was not kept"):
        sim.undo(-4)
    sim.undo(-3)


def test_pickles_have_events_and_the_energy_ledger() -> None:
    sim = mt.load(SCENARIOS / "crane.toml")
    sim.run(3.6)
    assert len(sim.events) > 0
    copied = pickle.loads(pickle.dumps(sim))
    assert [(event.time, event.name, event.lost) for event in copied.events] == [(e.time, e.name, e.lost) for e in sim.events]
    assert copied.energy_balance == sim.energy_balance
    for each in (sim, copied):
        each.run(4.0)
    assert np.array_equal(copied.q, sim.q) and copied.energy_balance == sim.energy_balance
    state = sim.__getstate__()
    state["state"] = state["state"][:-9] + b"x" + state["state"][-8:]
    with pytest.raises(mt.Error, match="this pickle is damaged"):
        mt.Simulation.__new__(mt.Simulation).__setstate__(state)


def test_plots_of_reactions_have_their_unit() -> None:
    pytest.importorskip("matplotlib").use("Agg")
    run = mt.load(SCENARIOS / "crane.toml").run(0.1, reactions=True)
    assert run.plot("crane/rope3.reaction").get_ylabel() == "force (N)"
    assert run.plot("crane/load.position").get_ylabel() == "position (m)"


def test_methods_have_the_names_of_the_literature() -> None:
    model = random_model(3, 3)
    for name, meant in (("imex", "damped"), ("moreau", "stepping")):
        assert mt.Simulation(model, method=name).integration["method"] == meant
