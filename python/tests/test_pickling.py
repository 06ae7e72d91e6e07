"""Pickles go on bit for bit, and other round trips keep everything."""

from __future__ import annotations

import copy
import pathlib
import pickle
import random
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_models import fingerprint, random_model, random_state, some_action

import momentree as mt

SCENARIO = pathlib.Path(__file__).resolve().parents[2] / "scenarios/breaking_chain.toml"
seeds = st.integers(0, 2**32 - 1)


def again(value: Any) -> Any:
    return pickle.loads(pickle.dumps(value))


def start(seed: int, bodies: int = 4, **options: Any) -> mt.Simulation:
    sim = mt.Simulation(random_model(seed, bodies), **options)
    random_state(sim, seed)
    return sim


@given(seeds, st.integers(0, 8))
def test_models_keep_everything(seed: int, bodies: int) -> None:
    model = random_model(seed, bodies)
    for other in (again(model), model.copy(), copy.deepcopy(model)):
        assert other.to_toml() == model.to_toml()
        assert other.body_names == model.body_names and other.joint_names == model.joint_names
        assert np.array_equal(other.gravity, model.gravity)


@given(seeds, st.integers(1, 6))
def test_scenarios_of_models_move_alike(seed: int, bodies: int) -> None:
    model = random_model(seed, bodies)
    other_model = mt.loads(model.to_toml()).model
    assert other_model.to_toml() == model.to_toml()
    one, two = mt.Simulation(model), mt.Simulation(other_model)  # the text lists mechanism by mechanism: another order
    for sim in (one, two):
        sim.run(0.02)
    for name, joint in one.world.joints.items():
        for key in ("q", "v", "p"):
            assert np.array_equal(getattr(joint, key), getattr(two.world.joints[name], key)), name


@given(seeds, st.sampled_from(["rk4", "midpoint", "damped", "dopri5", "dop853"]))
def test_simulations_go_on_bit_for_bit(seed: int, method: str) -> None:
    sim = start(seed, method=method)
    names = list(sim.world.joints)
    sim.at(0.013).then(mt.break_joint(names[0])).named("cut")
    sim.after("cut", 0.004).then(mt.lock(names[-1]))
    sim.every(0.006).then(mt.impulse(next(iter(sim.world.bodies)), force=(0.1, 0, 0)))
    sim.run(0.01)
    copied = again(sim)
    assert fingerprint(copied) == fingerprint(sim)
    for each in (sim, copied):
        each.run(0.03)
    assert fingerprint(copied) == fingerprint(sim)
    mine = [(event.time, event.name, str(event)) for event in sim.events]
    assert [(event.time, event.name, str(event)) for event in copied.events] == mine and len(mine) >= 5


@given(seeds)
def test_conditions_and_repetitions_are_armed_as_they_were(seed: int) -> None:
    sim = start(seed)
    single = [joint.name for joint in sim.world.joints.values() if len(joint.v) == 1]
    for name in single:
        sim.when((mt.speed(name) > 0.3).repeated()).then(mt.set_parameters(name, damping=0.5)).named("fast")
    sim.when((mt.kinetic_energy(sim.world.mechanisms[0].name) > 0.1).lasting(0.004)).then(mt.lock(next(iter(sim.world.joints))))
    sim.run(0.015)
    copied = again(sim)
    for each in (sim, copied):
        each.run(0.04)
    assert fingerprint(copied) == fingerprint(sim)


@given(seeds, st.sampled_from(["momenta", "velocities"]))
def test_changes_before_the_pickle_are_kept(seed: int, variables: str) -> None:
    sim = start(seed, 6, variables=variables)  # a loop is closed in velocities only
    rng = random.Random(seed)
    for _ in range(5):
        try:
            sim.apply(some_action(sim, rng))
            sim.step()
        except mt.Error:
            pass
    copied = again(sim)
    assert fingerprint(copied) == fingerprint(sim)
    end = sim.time + 0.01
    assert [m for m in copied.world.mechanisms] == [m for m in sim.world.mechanisms]
    for each in (sim, copied):
        each.run(end)
    assert fingerprint(copied) == fingerprint(sim)


def test_loaded_and_branched_simulations_can_be_pickled() -> None:
    sim = mt.load(SCENARIO)
    sim.run(0.2)
    branch = sim.branch()
    for each in (again(sim), again(branch), branch):
        each.run(0.3)
        sim_there = mt.load(SCENARIO)
        sim_there.run(0.2)
        sim_there.run(0.3)
        assert fingerprint(each) == fingerprint(sim_there)


@given(seeds)
def test_gravity_that_was_changed_is_kept(seed: int) -> None:
    sim = start(seed)
    sim.run(0.01)
    sim.set_gravity((0.3, -1.0, 2.0))
    sim.run(0.02)
    restored = start(seed)
    restored.restore_state(sim.state_json())
    copies = [again(sim), again(again(sim)), again(sim.branch()), copy.copy(sim), restored]
    for each in copies:
        assert np.array_equal(each.world.gravity, (0.3, -1.0, 2.0))
        assert each.state_json() == sim.state_json()
    for each in (sim, *copies):
        each.run(0.03)
        assert each.state_json() == sim.state_json()


def test_documents_and_snapshots_of_before_bring_their_gravity_back() -> None:
    sim = start(3)
    sim.run(0.01)
    document, snapshot = sim.state_json(), sim.snapshot()
    for back in (lambda: sim.restore_state(document), lambda: sim.restore(snapshot)):
        sim.set_gravity((0, 0, 5))
        sim.run(0.02)
        back()
        assert sim.state_json() == document
    sim.restore(snapshot)
    before = sim.energy_balance["error"]
    sim.set_gravity((0, 0, 5))
    sim.restore(snapshot)
    assert sim.energy_balance["error"] == before


@pytest.mark.parametrize("method", ["rk4", "dopri5"])
def test_velocities_that_do_not_fit_the_momenta_are_refused_in_any_variables(method: str) -> None:
    model = mt.Model()
    model.add("arm", mass=1, inertia=0.1, joint=mt.Revolute(axis=(0, 1, 0)), q=0.3)
    sim = mt.Simulation(model, method=method)
    before = sim.state_json()
    with pytest.raises(mt.Error, match="does not fit its `p`"):
        sim.restore_state('{"joints": {"arm": {"q": [0.1], "v": [1], "p": [99]}}}')
    assert sim.state_json() == before
    sim.restore_state('{"joints": {"arm": {"q": [0.1], "v": [1], "p": [0.1]}}}')
    assert sim.world.joints["arm"].v[0] == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize("partial", ["{}", '{"time": 0.05}', '{"gravity": [0, 0, -1]}', '{"joints": {"new/one": {"q": [1]}}}'])
def test_partial_documents_after_bodies_were_added(partial: str) -> None:
    sim, other = start(1), start(1)
    document, snapshot = sim.state_json(), sim.snapshot()
    sim.add("new/one", mass=1, inertia=0.1, joint=mt.Revolute())
    with_body = sim.snapshot()
    try:
        sim.restore_state(partial)
        assert list(sim.world.bodies) == list(other.world.bodies)
    except mt.Error as error:
        assert "unknown joint" in str(error) and "new/one" in sim.world.bodies
    sim.restore(with_body)
    assert "new/one" in sim.world.bodies
    sim.restore(snapshot)
    assert sim.state_json() == document


def test_a_document_of_before_bodies_were_added_removes_them() -> None:
    sim, other = start(1), start(1)
    document = sim.state_json()
    for _ in range(2):
        sim.add("new/one", mass=1, inertia=0.1, joint=mt.Revolute(), parent=list(sim.world.bodies)[-1], collision={"sphere": 0.1})
        sim.when(mt.speed("new/one") > 1e-3).then(mt.lock("new/one"))
        sim.run(sim.time + 0.01)
        sim.restore_state(document)
        assert sim.state_json() == document and list(sim.world.bodies) == list(other.world.bodies)
    for each in (sim, other):
        each.run(0.02)
    assert fingerprint(sim) == fingerprint(other)


def record(sim: mt.Simulation) -> tuple[Any, ...]:
    """What happened in a simulation, and what is still to come."""
    return [(event.time, event.lost, event.work, str(event)) for event in sim.events], sim.energy_balance, str(sim.missed)


@given(seeds, st.sampled_from(["rk4", "dopri5", "stepping"]))
def test_bodies_that_were_added_and_removed_are_kept(seed: int, method: str) -> None:
    model = random_model(seed, 4)
    model.gravity = (0, 0, -9.81)
    model.add_floor(friction=0.5, height=-3)
    sim = mt.Simulation(model, method=method)
    for k in range(2):
        sim.add(f"new/{k}", mass=1, inertia=0.1, joint=mt.Revolute(damping=0.1), parent=list(sim.world.bodies)[-1], v=0.3)
        sim.when(mt.speed(f"new/{k}") > 0.35).then(mt.lock(f"new/{k}")).named(f"fast{k}")
        sim.run(sim.time + 0.01)
    sim.add("ball/ball", mass=1, inertia=0.01, joint=mt.Free(), q=[9, 9, -2.85, 1, 0, 0, 0], v=[1, 0, -2, 0, 0, 0],
            collision={"sphere": 0.1})  # fmt: skip
    sim.remove("new/1")
    sim.at(sim.time + 0.015).then(mt.weld("ball/ball", "new/0")).named("joined")
    for _ in range(3):
        copied = again(again(sim))
        assert list(copied.world.bodies) == list(sim.world.bodies) and "new/1" not in copied.world.bodies
        end = sim.time + 0.01
        for each in (sim, copied):
            each.run(end)
        assert fingerprint(copied) == fingerprint(sim) and record(copied) == record(sim)


def test_events_refer_to_what_a_run_made() -> None:
    model = mt.Model()
    for name in ("a", "b"):
        model.add(f"m/{name}", mass=1, inertia=0.1, joint=mt.Free(), q=[ord(name), 0, 0, 1, 0, 0, 0], v=[0, 0, 0, 1, 0, 0])
    sim = mt.Simulation(model)
    sim.apply(mt.attach("m/a", "m/b", mt.Revolute()), name="made")
    sim.when((mt.position("made") > 0.01).lasting(0.001)).then(mt.break_joint("made"), mt.impulse("m/a", force=(1, 2, 3)))
    sim.every(0.01, 0.005).then(mt.impulse("m/b", force=(0, 0, 0.1)))
    sim.run(0.02)
    copied = again(sim)
    for each in (sim, copied):
        each.run(0.3)
    assert fingerprint(copied) == fingerprint(sim) and record(copied) == record(sim)


def test_damaged_pickles_and_those_of_others_are_refused() -> None:
    sim = start(8)
    sim.at(0.01).then(mt.lock(next(iter(sim.world.joints))))
    state = sim.__getstate__()

    def refusal(**changed: Any) -> str:
        with pytest.raises(mt.Error) as caught:
            mt.Simulation.__new__(mt.Simulation).__setstate__({**state, **changed})
        return str(caught.value)

    run = state["state"]
    assert "this pickle is damaged" in refusal(state=run[:99] + bytes([run[99] ^ 1]) + run[100:])
    assert "incomplete" in refusal(state=run[:-1]) and "not a checkpoint" in refusal(state=b"")
    assert "of another model" in refusal(source=("model", random_model(9, 4), {"method": "rk4"}))


def test_free_roots_without_start_coordinates_are_written() -> None:
    model = mt.Model()
    model.add("m/a", mass=1, inertia=1, joint=mt.Free(), v=[1, 2, 3, 4, 5, 6])
    assert again(model).to_toml() == model.to_toml()


def test_runs_keep_their_columns_and_events() -> None:
    sim = start(3)
    sim.at(0.01).then(mt.break_joint(next(iter(sim.world.joints)))).named("cut")
    run = sim.run(0.02, reactions=True)
    copied = again(run)
    assert copied.status == run.status == "done"
    assert np.array_equal(copied.time, run.time)
    assert np.array_equal(copied.energy, run.energy)
    for name in run.joints:
        for key in ("q", "v", "p", "a"):
            assert np.array_equal(getattr(copied.joints[name], key), getattr(run.joints[name], key), equal_nan=True)
    assert copied.summary == run.summary and copied.final_state == run.final_state
    assert [str(event) for event in copied.events] == [str(event) for event in run.events]
    assert copied.event_table["lost"].tolist() == run.event_table["lost"].tolist()
    with pytest.raises(mt.Error, match="pickled"):
        copied.save("nowhere")


def test_events_and_errors_keep_everything() -> None:
    sim = start(4)
    event = sim.apply(mt.break_joint(next(iter(sim.world.joints))), name="cut")
    copied = again(event)
    assert str(copied) == str(event) and copied.lost == event.lost
    assert all(np.array_equal(copied.impulse[name].force, event.impulse[name].force) for name in event.impulse)
    with pytest.raises(mt.Error) as caught:
        mt.loads("format = 1\n[[mechanism]]\nname = 3\n")
    error = again(caught.value)
    assert type(error) is mt.Error
    assert str(error) == str(caught.value)
    for key in ("problem", "where", "hint", "file", "line", "column", "diagnostics"):
        assert getattr(error, key) == getattr(caught.value, key)


def test_an_error_of_a_run_keeps_its_rows() -> None:
    sim = start(4)
    body = next(iter(sim.world.bodies))
    sim.at(0.005).then(mt.weld(body, body)).named("impossible")
    with pytest.raises(mt.RunError, match="impossible") as caught:
        sim.run(0.01)
    error = again(caught.value)
    assert type(error) is mt.RunError and str(error) == str(caught.value)
    assert error.run is not None and np.array_equal(error.run.time, caught.value.run.time)


def test_what_python_functions_drive_cannot_be_pickled_and_says_so() -> None:
    sim = start(5)
    sim.drive(next(iter(sim.world.joints)), lambda context: 0.0)
    with pytest.raises(TypeError, match="functions"):
        pickle.dumps(sim)
    other = start(5)
    other.when(lambda world: world.time - 1).then(mt.break_joint(next(iter(other.world.joints))))
    with pytest.raises(TypeError, match="functions"):
        pickle.dumps(other)


@pytest.mark.parametrize("method", ["rk4", "dopri5", "stepping"])
def test_an_observer_can_pickle_what_it_sees(method: str) -> None:
    model = mt.Model()
    model.add("box/box", mass=2, inertia=0.02, joint=mt.Free(), q=[0, 0, 0.3, 1, 0, 0, 0], collision={"box": [0.4, 0.4, 0.2]})
    model.add_floor(friction=0.2)
    sim = mt.Simulation(model, method=method)
    pickles: list[bytes] = []
    branches: list[mt.Simulation] = []

    def observe(world: mt.World) -> None:
        pickles.append(pickle.dumps(sim))
        branches.append(sim.branch())

    sim.run(0.5, record_every=0.1, observe=observe)
    assert len(pickles) >= 5
    for bytes_then, branch in zip(pickles, branches):
        other = pickle.loads(bytes_then)
        assert other.time == branch.time and np.array_equal(other.q, branch.q)
        other.run(0.6)
        branch.run(0.6)
        np.testing.assert_array_equal(other.q, branch.q)


def test_a_free_root_with_velocities_and_no_coordinates() -> None:
    model = mt.Model()
    model.add("a/a", mass=1, inertia=0.1, joint=mt.Free(), v=[1, 2, 3, 4, 5, 6])
    for other in (mt.loads(model.to_toml()).model, again(model)):
        np.testing.assert_allclose(mt.Simulation(other).v, [1, 2, 3, 4, 5, 6], rtol=1e-15)
        np.testing.assert_array_equal(mt.Simulation(other).q, [0, 0, 0, 1, 0, 0, 0])


def test_views_and_records_are_plain_when_pickled() -> None:
    sim = start(6)
    view = again(sim.q)
    assert type(view) is np.ndarray and np.array_equal(view, sim.q)
    sim.step()
    assert not np.array_equal(view, sim.q)
    assert again(sim.energy) == sim.energy


def test_names_without_a_mechanism():
    """Scenarios put the mechanism in front of such names; pickles keep them."""
    model = mt.Model()
    model.add("arm", mass=2, inertia=0.02, at=(0, 0, 3), joint=mt.Revolute(axis=(0, 1, 0)), q=0.3, collision={"sphere": 0.1})
    model.add("hand", mass=1, inertia=0.01, parent="arm", at=(1, 0, 0), joint=mt.Revolute(axis=(0, 1, 0)), joint_name="wrist")
    model.add("ball", mass=1, inertia=0.01, joint=mt.Free(), q=[0, 3, 1, 1, 0, 0, 0], collision={"sphere": 0.1})
    model.add_force("hand", force=(0, 0, 1))
    model.add_spring("tie", start="hand", end="ball", stiffness=2, rest=1)
    model.add_floor(friction=0.5)
    model.add_contact(("ball", "ground"), restitution=0.5)
    again = pickle.loads(pickle.dumps(model))
    assert again.body_names == ["arm", "hand", "ball"]
    assert again.joint_names == ["arm", "wrist", "ball"]
    one, other = mt.Simulation(model), mt.Simulation(again)
    third = pickle.loads(pickle.dumps(one))
    written = mt.loads(model.to_toml()).model
    assert written.body_names == ["arm/arm", "arm/hand", "ball/ball"]
    for sim in (one, other, third, mt.Simulation(written)):
        sim.run(1)
        np.testing.assert_array_equal(sim.q, one.q)
    assert len(one.events) == len(other.events) > 0


def test_snapshots_are_restored_in_other_processes() -> None:
    sim = start(12)
    sim.at(0.015).then(mt.break_joint(next(iter(sim.world.joints))))
    sim.effort = [0.1] * len(sim.effort)
    snapshot = sim.snapshot()
    run = sim.run(0.02, record_every=0.005)
    later = run.state(2)
    for state, end in ((snapshot, 0.02), (later, 0.02)):
        other = again(start(12))
        other.at(0.015).then(mt.break_joint(next(iter(other.world.joints))))
        other.restore(again(state))
        sim.restore(state)
        assert other.time == sim.time
        for each in (sim, other):
            each.run(end)
        assert fingerprint(other) == fingerprint(sim)
    with pytest.raises(mt.Error, match="another model"):
        start(3).restore(again(snapshot))
    sim.force(next(iter(sim.world.bodies)), lambda context: ((0, 0, 0), (0, 0, 0)))
    with pytest.raises(TypeError, match="functions"):
        pickle.dumps(sim.snapshot())


def test_a_snapshot_with_bodies_that_touch_needs_a_method_for_contact() -> None:
    def simulation(method: str) -> mt.Simulation:
        model = mt.Model()
        model.add("a", mass=1, inertia=0.1, joint=mt.Ball())
        return mt.Simulation(model, method=method)

    sim, damped = simulation("rk4"), simulation("damped")
    sim.add("b", mass=1, inertia=0.1, joint=mt.Free(), collision={"sphere": 0.1}, at=(3, 0, 0))
    with pytest.raises(mt.Error, match="'damped' does not support contact"):
        damped.restore(sim.snapshot())
    damped.run(0.01)


@pytest.mark.parametrize("given", ["rk4", "midpoint", "dopri5", "dop853", "damped"])
@pytest.mark.parametrize("taken", ["rk4", "midpoint", "dopri5", "dop853", "damped"])
def test_a_snapshot_continues_with_any_method(given: str, taken: str) -> None:
    def simulation(method: str) -> mt.Simulation:
        model = mt.Model()
        a = model.add("a", mass=1, inertia=0.1, joint=mt.Revolute(axis=(0, 1, 0)), v=0.3)
        model.add("b", mass=1, com=(0, 0, -0.5), inertia=0.1, parent=a, at=(0, 0, -1), joint=mt.Revolute(axis=(0, 1, 0)))
        return mt.Simulation(model, method=method)

    sim, other = simulation(given), simulation(taken)
    sim.run(0.01)
    other.restore(sim.snapshot())
    assert np.allclose(other.q, sim.q, atol=1e-14) and np.allclose(other.v, sim.v, atol=1e-14)
    other.run(0.02)
