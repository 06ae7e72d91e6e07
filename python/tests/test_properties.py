"""Properties of random models and states: equations of motion, certificates, snapshots and branches."""

from __future__ import annotations

import copy
import random
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_models import fingerprint, random_model, random_state, some_action, vector

import momentree as mt

seeds = st.integers(0, 2**32 - 1)
sizes = st.integers(1, 8)


def simulation(seed: int, bodies: int, **options: Any) -> mt.Simulation:
    sim = mt.Simulation(random_model(seed, bodies, **options))
    random_state(sim, seed)
    return sim


def close(a: Any, b: Any, tolerance: float = 1e-9) -> bool:
    """Equal relative to the largest number of both."""
    a, b = np.asarray(a), np.asarray(b)
    scale = max(1.0, np.abs(a).max(initial=0), np.abs(b).max(initial=0))
    return bool(np.abs(a - b).max(initial=0) <= tolerance * scale)


@given(seeds, sizes)
def test_momenta_are_the_mass_matrix_times_velocities(seed: int, bodies: int) -> None:
    sim = simulation(seed, bodies)
    mass = sim.mass_matrix()
    assert mass.shape == (len(sim.v), len(sim.v))
    assert close(mass, mass.T)
    assert np.all(np.linalg.eigvalsh(mass) > 0) if len(mass) else True
    assert close(sim.p, mass @ sim.v)
    assert sim.energy.kinetic == pytest.approx(0.5 * sim.v @ sim.p, rel=1e-9, abs=1e-12)


@given(seeds, sizes)
def test_accelerations_solve_the_equations_of_motion(seed: int, bodies: int) -> None:
    sim = simulation(seed, bodies)
    a = sim.accelerations()
    assert close(sim.mass_matrix() @ a + sim.bias(), sim.efforts(), 1e-8)
    assert close(sim.inverse_dynamics(a), sim.efforts(), 1e-8)
    other = np.random.default_rng(seed).normal(size=len(sim.v))
    assert close(sim.inverse_dynamics(other), sim.mass_matrix() @ other + sim.bias())
    inverse = sim.inverse_mass_matrix()
    assert close(inverse @ other, sim.solve_mass(other))
    free = inverse.diagonal() > 0  # the others are locked, or their motion is prescribed
    assert close(sim.mass_matrix()[np.ix_(free, free)] @ inverse[np.ix_(free, free)], np.eye(int(free.sum())), 1e-8)


@given(seeds, sizes)
def test_jacobians_map_velocities_to_motions_of_points(seed: int, bodies: int) -> None:
    sim = simulation(seed, bodies)
    rng = random.Random(seed)
    for body in sim.world.bodies.values():
        point = np.array(vector(rng))
        w, x, y, z = body.quaternion
        turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        motion = sim.jacobian(body, point) @ sim.v
        assert close(motion[:3], body.linear + np.cross(body.angular, turn @ point))
        assert close(motion[3:], body.angular)


@given(seeds, sizes)
def test_efforts_and_rates_are_consistent(seed: int, bodies: int) -> None:
    sim = simulation(seed, bodies)
    before = sim.efforts()
    extra = np.random.default_rng(seed).normal(size=len(sim.v))
    sim.effort = extra
    assert close(sim.efforts(), before + extra)
    rates = sim.evaluate()
    assert rates.qdot.shape == sim.q.shape and rates.pdot.shape == sim.p.shape
    h = 1e-6
    later = sim.branch()
    later.step(h)
    assert close((later.p - sim.p) / h, rates.pdot, 1e-3)


@given(seeds, sizes)
def test_every_change_has_a_certificate_that_holds(seed: int, bodies: int) -> None:
    sim = simulation(seed, bodies)
    rng = random.Random(seed)
    for _ in range(6):
        action = some_action(sim, rng)
        before, momentum, energy = fingerprint(sim), sim.momentum, sim.energy
        try:
            event = sim.apply(action)
        except mt.Error:
            assert fingerprint(sim) == before  # nothing has happened
            continue
        size = 1 + abs(energy.kinetic) + abs(energy.potential)
        assert close(event.before.linear, momentum.linear) and close(event.before.angular, momentum.angular)
        now = sim.energy
        balance = energy.total - now.total - event.lost - event.released + event.work
        assert abs(balance) < 1e-8 * size, (action, balance)
        if event.actions[0].kind in ("break", "lock", "weld", "attach", "reroot", "unlock", "free"):
            assert event.lost >= -1e-9 * size, action
        if event.actions[0].kind != "impulse":
            assert event.linear_error < 1e-8 * size and event.angular_error < 1e-8 * size, action
        assert sim.events[-1].time == event.time and sim.events[-1].actions == event.actions


@given(seeds, sizes)
def test_the_energy_of_a_passive_model_is_conserved(seed: int, bodies: int) -> None:
    sim = mt.Simulation(random_model(seed, bodies, passive=True), method="dop853", rtol=1e-11, atol=1e-11)
    random_state(sim, seed, 0.5)
    start = sim.energy
    run = sim.run(0.05)
    error = sim.energy.total - start.total
    assert abs(error) < 1e-7 * (1 + abs(start.kinetic) + abs(start.potential))
    assert run.energy["error"][-1] == pytest.approx(sim.energy_balance["error"], abs=1e-12)


def step_through(sim: mt.Simulation, seed: int, changes: int) -> None:
    """Steps and actions that follow from the seed alone."""
    rng = random.Random(seed)
    for _ in range(changes):
        try:
            sim.apply(some_action(sim, rng))
            sim.step(rng.uniform(0, 0.01))
        except mt.Error:
            pass


@given(seeds, sizes)
def test_snapshots_are_exact_across_changes(seed: int, bodies: int) -> None:
    sim = simulation(seed, bodies)
    step_through(sim, seed + 1, 2)
    at_snapshot, snapshot = fingerprint(sim), sim.snapshot()
    step_through(sim, seed + 2, 4)
    end, events = fingerprint(sim), len(sim.events)
    sim.restore(snapshot)
    assert fingerprint(sim) == at_snapshot
    step_through(sim, seed + 2, 4)
    assert fingerprint(sim) == end
    assert len(sim.events) == events


@given(seeds, sizes)
def test_branches_are_independent_and_go_on_alike(seed: int, bodies: int) -> None:
    sim = simulation(seed, bodies)
    step_through(sim, seed + 1, 2)
    before = fingerprint(sim)
    branch = copy.copy(sim)
    step_through(branch, seed + 2, 4)
    assert fingerprint(sim) == before
    step_through(sim, seed + 2, 4)
    assert fingerprint(sim) == fingerprint(branch)


@given(seeds, sizes)
def test_undo_returns_to_the_bit_before_an_event(seed: int, bodies: int) -> None:
    sim = simulation(seed, bodies)
    sim.keep_history()
    rng = random.Random(seed)
    states = []
    for _ in range(4):
        before = fingerprint(sim)
        try:
            sim.apply(some_action(sim, rng))
        except mt.Error:
            continue
        states.append(before)
    assert len(sim.events) == len(states)
    while states:
        sim.undo()
        assert fingerprint(sim) == states.pop()
        assert len(sim.events) == len(states)


def test_the_list_of_events_follows_undo_and_restore() -> None:
    sim = mt.Simulation(random_model(1, 4, kinds=["Revolute"]))
    sim.keep_history()
    joints = list(sim.world.joints)
    start = sim.snapshot()
    sim.apply(mt.lock(joints[0]), name="first")
    assert [event.name for event in sim.events] == ["first"]
    sim.undo()
    sim.apply(mt.lock(joints[1]), name="second")
    assert [event.name for event in sim.events] == ["second"]
    sim.restore(start)
    sim.apply(mt.lock(joints[2]), name="third")
    assert [event.name for event in sim.events] == ["third"]
