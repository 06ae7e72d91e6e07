"""The same numbers everywhere: runs and live values, batches and simulations, saved folders and those of the command."""

from __future__ import annotations

import json
import pathlib
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_models import KINDS, random_model, random_state

import momentree as mt

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIOS = sorted(path.name for path in (ROOT / "scenarios").glob("*.toml"))
seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.integers(1, 6))
def test_columns_of_a_run_are_the_values_that_an_observer_sees(seed: int, bodies: int) -> None:
    sim = mt.Simulation(random_model(seed, bodies))
    random_state(sim, seed)
    names = list(sim.world.joints)
    sim.at(0.004).then(mt.break_joint(names[seed % bodies])).named("cut")
    seen: list[dict[str, np.ndarray]] = []

    def observe(world: mt.World) -> None:
        row: dict[str, np.ndarray] = {"time": np.array(world.time)}
        for name, joint in world.joints.items():
            row |= {f"{name}.v": joint.v, f"{name}.p": joint.p, f"{name}.a": joint.a, f"{name}.f": joint.reaction.force}
        for name, body in world.bodies.items():
            row |= {f"{name}.position": body.position, f"{name}.linear": body.linear, f"{name}.angular": body.angular}
        row["kinetic"] = np.array(world.energy.kinetic)
        if seen and seen[-1]["time"] == row["time"]:
            seen.pop()  # before the event of that instant
        seen.append(row)

    run = sim.run(0.01, record_every=0.002, reactions=True, observe=observe)
    if seen[-1]["time"] != run.time[-1]:
        observe(sim.world)
    assert len(run) == len(seen)
    for k, row in enumerate(seen):
        assert run.time[k] == row["time"]
        assert run.energy["kinetic"][k] == pytest.approx(row["kinetic"], rel=1e-12)
        for key, value in row.items():
            name, _, field = key.rpartition(".")
            if field in ("v", "p", "a"):
                column = getattr(run.joints[name], field)[k]
                assert np.allclose(column[: len(value)], value, rtol=1e-9, atol=1e-9), key
                assert np.isnan(column[len(value) :]).all()
            elif field == "f":
                assert np.allclose(run.joints[name].reaction.force[k], value, rtol=1e-9, atol=1e-9)
            elif field in ("position", "linear", "angular"):
                assert np.allclose(getattr(run.bodies[name], field)[k], value, rtol=1e-9, atol=1e-12), key


def test_rows_are_nan_where_a_joint_does_not_exist() -> None:
    sim = mt.Simulation(random_model(2, 3, kinds=["Revolute"]))
    parts = list(sim.world.bodies)
    joint = list(sim.world.joints)[-1]
    sim.at(0.005).then(mt.break_joint(joint)).named("cut")
    sim.at(0.008).then(mt.attach(parts[-1], "ground", mt.Revolute())).named("hook")
    run = sim.run(0.01)
    there = run.time < 0.005
    assert not np.isnan(run.joints[joint].q[there][:, 0]).any()
    made = run.joints["hook"].q
    assert np.isnan(made[run.time < 0.008]).all() and not np.isnan(made[run.time >= 0.008]).any()


both: st.SearchStrategy[Any] = st.sampled_from(["momenta", "velocities"])


@given(seeds, st.integers(1, 5), st.integers(1, 9), both, both)
def test_worlds_of_a_batch_are_scalar_simulations(seed: int, bodies: int, worlds: int, variables: Any, given_as: str) -> None:
    model = random_model(seed, bodies)
    batch = mt.Batch(model, worlds, threads=1 + seed % 2, variables=variables)
    assert batch.variables == variables
    sims = [mt.Simulation(model, method="rk4", step=0.01, variables=variables) for _ in range(worlds)]
    for k, sim in enumerate(sims):
        random_state(sim, seed + k, 0.5)
    q, v, p = (np.array([getattr(sim, name) for sim in sims]) for name in ("q", "v", "p"))
    batch.set_state(q=q, p=p) if given_as == "momenta" else batch.set_state(q=q, v=v)
    joint = list(sims[0].world.joints)[seed % bodies]
    for k in range(3):
        if k == 1:
            batch.apply(slice(0, None, 2), mt.break_joint(joint))
            for sim in sims[::2]:
                sim.apply(mt.break_joint(joint))
        batch.step(0.01)
        for sim in sims:
            sim.step(0.01)
    for group in batch.groups:
        for row, world in enumerate(group.worlds):
            sim = sims[world]
            scale = 1 + np.abs(sim.p).max(initial=0)
            assert np.allclose(group.q[row], sim.q, rtol=0, atol=1e-9 * scale)
            assert np.allclose(group.p[row], sim.p, rtol=0, atol=1e-9 * scale)
            assert np.allclose(group.v[row], sim.v, rtol=0, atol=1e-8 * (1 + np.abs(sim.v).max(initial=0)))
    assert np.allclose(batch.time, 0.03)
    name = next(iter(batch.bodies))
    for k, sim in enumerate(sims):
        assert np.allclose(batch.bodies[name].position[k], sim.world.bodies[name].position, atol=1e-8)


@given(seeds, both)
def test_no_world_depends_on_the_others(seed: int, variables: Any) -> None:
    model = random_model(seed, 4, kinds=KINDS[:6])
    rng = np.random.default_rng(seed)
    together, alone = mt.Batch(model, 7, threads=2, variables=variables), mt.Batch(model, 1, threads=1, variables=variables)
    v = rng.normal(size=together.v.shape)
    effort = rng.normal(size=v.shape)
    together.v, together.effort = v, effort
    alone.v, alone.effort = v[3:4], effort[3:4]
    for batch in (together, alone):
        batch.run(1e-3, 20)
    assert np.isfinite(together.p).all()
    assert together.q[3].tobytes() == alone.q[0].tobytes() and together.p[3].tobytes() == alone.p[0].tobytes()


@pytest.mark.parametrize("name", SCENARIOS)
def test_saved_folders_have_the_numbers_of_the_command(name: str, tmp_path: pathlib.Path) -> None:
    scenario = str(ROOT / "scenarios" / name)
    until = min(mt.load(scenario).until, 1.0)
    command = [sys.executable, "-m", "momentree", "run", scenario, "--until", str(until), "--out", str(tmp_path / "command")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    run = mt.load(scenario).run(until)
    assert run.status == "done"
    assert run.save(tmp_path / "python") == str(tmp_path / "python")
    for file in ("events.jsonl", "bodies.csv", "energy.csv", "joints.csv"):
        ours, theirs = ((tmp_path / who / file).read_text() for who in ("python", "command"))
        if file == "events.jsonl":
            assert [without_times(line) for line in ours.splitlines()] == [without_times(line) for line in theirs.splitlines()]
            continue
        header, wanted = ours.partition("\n")[0].split(","), theirs.partition("\n")[0].split(",")
        assert set(header) <= set(wanted)  # the command has columns for what may happen later, too
        a, b = (np.genfromtxt(text.splitlines(), delimiter=",", skip_header=1, ndmin=2) for text in (ours, theirs))
        assert np.array_equal(a, b[:, [wanted.index(key) for key in header]], equal_nan=True), file
        assert np.isnan(b[:, [k for k, key in enumerate(wanted) if key not in header]]).all(), file
    final = [json.loads((tmp_path / who / "final.json").read_text()) for who in ("python", "command")]
    assert final[0] == final[1]


def without_times(line: str) -> dict[str, object]:
    event: dict[str, object] = json.loads(line)
    return {key: value for key, value in event.items() if not key.startswith("duration")}


@given(seeds, st.integers(1, 6))
def test_velocities_and_momenta_describe_the_same_motion(seed: int, bodies: int) -> None:
    model = random_model(seed, bodies)
    sims = [mt.Simulation(model, method="dop853", variables=v, rtol=1e-10, atol=1e-12) for v in ("momenta", "velocities")]
    names = list(sims[0].world.joints)
    for sim in sims:
        random_state(sim, seed)
        sim.at(0.004).then(mt.lock(names[0]))
        sim.at(0.006).then(mt.break_joint(names[seed % bodies]))
        assert sim.run(0.01).status == "done"
    one, other = sims
    assert one.integration["variables"] == "momenta" and other.integration["variables"] == "velocities"
    for x, y in ((one.q, other.q), (one.v, other.v), (one.p, other.p)):
        np.testing.assert_allclose(x, y, rtol=1e-6, atol=1e-7 * (1 + np.abs(x).max(initial=0)))
    for event, same in zip(one.events, other.events, strict=True):
        assert event.lost == pytest.approx(same.lost, rel=1e-5, abs=1e-7 * (1 + abs(event.before.kinetic)))


def test_writing_velocities_and_momenta_of_a_simulation_in_velocities() -> None:
    sim = mt.Simulation(random_model(3, 4), variables="velocities")
    v = np.linspace(-1, 1, len(sim.v))
    sim.set_state(v=v)
    np.testing.assert_array_equal(sim.v, v)
    p = np.array(sim.p)
    sim.set_state(v=np.zeros(len(v)))
    sim.set_state(p=p)
    np.testing.assert_allclose(sim.v, v, atol=1e-12)
    with pytest.raises(mt.Error, match="integrates momenta"):
        mt.Simulation(random_model(3, 4), method="damped", variables="velocities")
    with pytest.raises(mt.Error, match="momentum|momenta"):
        mt.Simulation(random_model(3, 4), variables="momentum")
