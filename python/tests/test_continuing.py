"""Documents, branches, copies and rows of runs continue as the simulation itself does, whatever has happened before."""

from __future__ import annotations

import copy
import json
import os
import pathlib
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import momentree as mt

WHEELS = """
format = 1
[[mechanism]]
name = "gear"
roots = 2
[[mechanism.body]]
name = "small"
mass = 1
inertia = 0.01
[mechanism.body.joint]
kind = "revolute"
v = 2
[[mechanism.body]]
name = "large"
mass = 4
inertia = 0.08
[mechanism.body.joint]
kind = "revolute"
[[coupling]]
joint = "gear/large"
follows = "gear/small"
multiplier = -0.5
stiffness = 3
damping = 0.01
[integrate]
method = "dopri5"
until = 1
"""
PENDULUM = """
format = 1
[[mechanism]]
name = "a"
[[mechanism.body]]
name = "b"
mass = 1
inertia = 1
com = [0.5, 0, 0]
[mechanism.body.joint]
kind = "revolute"
axis = [0, 1, 0]
"""
KICK = 'impulse = { body = "a/b", force = [0, 0, 1], point = [0.5, 0, 0] }\n'
EVENTS = (
    '[[event]]\nname = "kick"\nwhen = { position = "a/b", exceeds = 0.2 }\n'
    + KICK
    + '[[event]]\nname = "second"\nat = 0.5\n'
    + KICK
    + '[[event]]\nname = "later"\nafter = { event = "kick", delay = 0.4 }\n'
    + KICK
    + '[[event]]\nname = "fail"\nwhen = { position = "a/b", exceeds = 1.2 }\nbreak = "a/b"\n[integrate]\nuntil = 2\n'
)


def happened(sim: mt.Simulation) -> list[tuple[str, float]]:
    return [(event.name, event.time) for event in sim.events]


def pickled(sim: mt.Simulation) -> mt.Simulation:
    other: mt.Simulation = pickle.loads(pickle.dumps(sim))
    return other


COPIES: list[Callable[[mt.Simulation], mt.Simulation]] = [mt.Simulation.branch, copy.copy, copy.deepcopy, pickled]


@pytest.mark.parametrize("make", COPIES)
def test_documents_of_copies_know_which_events_happened(make: Callable[[mt.Simulation], mt.Simulation], tmp_path: pathlib.Path) -> None:
    (tmp_path / "a.toml").write_text(PENDULUM + EVENTS)
    sim = mt.load(tmp_path / "a.toml")
    sim.run(0.5)
    other = make(make(sim))
    assert json.loads(other.state_json())["armed"] == json.loads(sim.state_json())["armed"]
    (tmp_path / "state.json").write_text(other.state_json())
    resumed = mt.load(tmp_path / "a.toml", state=tmp_path / "state.json")
    for each in (sim, other, resumed):
        each.run(2)
    assert [name for name, _ in happened(sim)] == ["kick", "second", "later", "fail"]
    assert happened(resumed) == happened(sim)[2:]
    assert happened(other)[-2:] == happened(sim)[2:]
    np.testing.assert_array_equal(resumed.q, sim.q)
    np.testing.assert_array_equal(other.q, sim.q)
    assert json.loads(other.state_json())["armed"] == json.loads(sim.state_json())["armed"]


@pytest.mark.parametrize("method", ["rk4", "dopri5"])
def test_rows_of_runs_are_snapshots(method: str) -> None:
    sim = mt.loads(PENDULUM + EVENTS, set={"integrate.method": method})
    run = sim.run(2, record_every=0.05)
    events, end, energy = happened(sim), np.array(sim.q), sim.energy_balance
    times = np.array(run.time)
    assert len(events) == 4
    for row in range(0, len(times), 3):
        sim.restore(run.state(row))
        assert sim.time == times[row]
        assert [name for name, _ in happened(sim)] == [name for name, time in events if time <= sim.time]
        sim.run(2)
        assert [name for name, _ in happened(sim)] == [name for name, _ in events], row
        np.testing.assert_allclose([time for _, time in happened(sim)], [time for _, time in events], atol=1e-7)
        np.testing.assert_allclose(sim.q, end, atol=1e-5)
        assert sim.energy_balance["initial"] == energy["initial"]
        assert sim.energy_balance["work"] == pytest.approx(energy["work"], abs=1e-5)


def test_springs_of_couplings_stay_with_drives_and_efforts() -> None:
    def end(change: Callable[[mt.Simulation], Any]) -> tuple[Any, float]:
        sim = mt.loads(WHEELS)
        change(sim)
        sim.run(1)
        return np.array(sim.q), float(sim.p[0] - 0.5 * sim.p[1])  # the spring keeps this momentum

    expected, momentum = end(lambda sim: None)
    assert momentum == pytest.approx(0.02, abs=1e-12)

    def drive_and_release(sim: mt.Simulation) -> None:
        sim.drive("gear/small", lambda _: 5.0)
        sim.drive("gear/small", None)

    def effort(sim: mt.Simulation) -> None:
        sim.effort = [1e-300, 0]

    for change in (lambda sim: sim.drive("gear/small", lambda _: 0.0), lambda sim: sim.drive("gear/large", lambda _: 0.0)):
        np.testing.assert_allclose(end(change)[0], expected, atol=1e-9)
    np.testing.assert_array_equal(end(drive_and_release)[0], expected)
    np.testing.assert_allclose(end(effort)[0], expected, atol=1e-9)
    driven, given = end(lambda sim: sim.drive("gear/small", lambda _: 0.3))
    assert given == pytest.approx(0.02 + 0.3, abs=1e-9)  # the drive's impulse in 1 s, and nothing else
    assert abs(driven[0] - expected[0]) > 0.1


def test_springs_of_couplings_end_with_a_joint_also_if_the_next_one_is_driven_and_return_with_documents() -> None:
    sim = mt.loads(WHEELS)
    sim.run(0.1)
    document = sim.state_json()
    sim.run(0.2)
    sim.apply(mt.break_joint("gear/large"))
    momentum = float(sim.world.joints["gear/small"].p[0])
    sim.drive("gear/large", lambda _: np.zeros(6))
    sim.run(0.5)
    assert float(sim.world.joints["gear/small"].p[0]) == momentum
    sim.restore_state(document)
    other = mt.loads(WHEELS)
    for each in (sim, other):
        each.run(1)
    np.testing.assert_allclose(sim.q, other.q, atol=1e-9)


def test_springs_of_couplings_are_in_texts_and_pickles() -> None:
    sim = mt.loads(WHEELS)
    model = sim.model
    others = [mt.Simulation(each, method="dopri5") for each in (model, mt.loads(model.to_toml()).model, pickle.loads(pickle.dumps(model)))]
    others += [pickled(sim), copy.deepcopy(sim)]
    sim.run(1)
    for other in others:
        other.run(1)
        np.testing.assert_array_equal(other.q, sim.q)
    with pytest.raises(mt.Error, match="couplings by springs"):
        mt.Batch(model, 2)


def test_efforts_are_pickled() -> None:
    model = mt.Model()
    model.add("a/a", mass=1, inertia=0.1, com=(0.3, 0, 0), joint=mt.Revolute(axis=(0, 1, 0)))
    model.add("a/b", mass=1, inertia=0.1, com=(0.3, 0, 0), at=(0.3, 0, 0), parent="a/a", joint=mt.Revolute(axis=(0, 1, 0)))
    for method in ("rk4", "dopri5"):
        sim = mt.Simulation(model, method=method)
        sim.effort = [3.0, 0.5]
        sim.run(0.1)
        other = pickled(sim)
        np.testing.assert_array_equal(other.effort, [3.0, 0.5])
        sim.run(0.5)
        other.run(0.5)
        np.testing.assert_array_equal(other.q, sim.q)


def test_pickles_of_files_do_not_depend_on_the_folder_and_see_that_a_file_changed(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a.toml").write_text(PENDULUM)
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path)
    sim = mt.load("a.toml")
    sim.run(0.3)
    os.chdir(tmp_path / "other")
    data = pickle.dumps(sim)
    other = pickle.loads(data)
    (tmp_path / "a.toml").write_text(PENDULUM.replace("[0.5, 0, 0]", "[0.4, 0, 0]"))
    copied = copy.deepcopy(sim)
    with pytest.raises(mt.Error, match="has changed since the simulation was pickled"):
        pickle.loads(data)
    for each in (sim, other, copied):
        each.run(1)
        np.testing.assert_array_equal(each.q, sim.q)


def test_names_of_other_mechanisms() -> None:
    model = mt.Model()
    model.add("arm/flange", mass=1, inertia=0.1, joint=mt.Revolute(axis=(0, 1, 0)), v=1)
    model.add("gripper/base", mass=1, inertia=0.1, at=(0.4, 0, 0), parent="arm/flange", joint=mt.Revolute(axis=(0, 1, 0)))
    model.add("gripper/tip", mass=1, inertia=0.1, at=(0.4, 0, 0), parent="gripper/base", joint=mt.Revolute(axis=(0, 1, 0)))
    other = pickle.loads(pickle.dumps(model))
    assert other.body_names == model.body_names
    loaded = mt.loads(model.to_toml()).model
    assert loaded.body_names == ["arm/flange", "arm/gripper.base", "arm/gripper.tip"]
    ends = []
    for each in (model, other, loaded):
        sim = mt.Simulation(each)
        sim.run(0.5)
        ends.append(np.array(sim.q))
    np.testing.assert_array_equal(ends[1], ends[0])
    np.testing.assert_array_equal(ends[2], ends[0])


def test_runs_after_bodies_were_removed_can_be_written(tmp_path: pathlib.Path) -> None:
    model = mt.Model()
    for name in ("c/0", "d/0", "e/0"):
        model.add(name, mass=2, inertia=0.05, joint=mt.Free(), q=[ord(name[0]), 0, 0, 1, 0, 0, 0])
    sim = mt.Simulation(model)
    sim.run(0.1)
    sim.remove("d/0")
    sim.at(0.15).then(mt.weld("c/0", "e/0"))
    run = sim.run(0.2)
    folder = run.save(tmp_path / "results")
    header = (pathlib.Path(folder) / "bodies.csv").read_text().splitlines()[0]
    assert "c/0.x" in header and "e/0.x" in header and "d/0" not in header
    lines = [json.loads(line) for line in (pathlib.Path(folder) / "events.jsonl").read_text().splitlines()]
    moved = [numbers for line in lines for numbers in line["topology"].get("moved", {}).values()]
    assert moved and all(first + count <= 2 for numbers in moved for first, count in numbers)
    for ending in ("glb", "usda", "mcap"):
        run.export(tmp_path / f"run.{ending}")
    run.report(tmp_path / "run.html")
    assert np.isnan(run.bodies["d/0"].position).all()
    assert np.isfinite(run.bodies["e/0"].position).all()
