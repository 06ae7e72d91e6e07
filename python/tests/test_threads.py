"""Threads, interrupts, and Python functions that fail or do what they must not."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from test_lifetimes import chain

import momentree as mt


def in_thread(function: Callable[[], Any]) -> Any:
    """What the function returns, or raises, in another thread."""
    found: list[Any] = []

    def work() -> None:
        try:
            found.append(function())
        except BaseException as error:
            found.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join(60)
    assert not thread.is_alive()
    return found[0]


def test_one_simulation_is_used_by_one_thread_at_a_time() -> None:
    sim = chain()
    world, handle, view, event = sim.world, sim.world.joints["c/1"], sim.q, sim.at(5)
    uses: dict[str, Callable[[], Any]] = {
        "step": sim.step, "run": lambda: sim.run(1), "q": lambda: sim.q, "set": lambda: setattr(sim, "v", [0, 0, 0]),
        "time": lambda: sim.time,
        "energy": lambda: sim.energy, "snapshot": sim.snapshot, "branch": sim.branch,
        "apply": lambda: sim.apply(mt.break_joint("c/1")),
        "at": lambda: sim.at(3), "then": lambda: event.then(mt.lock("c/1")), "events": lambda: sim.events,
        "world": lambda: world.energy,
        "handle": lambda: handle.q, "matrix": sim.mass_matrix, "repr": lambda: repr(sim), "drive": lambda: sim.drive("c/1", None),
        "undo": sim.undo, "pickle": sim.state_json, "remove": lambda: sim.remove("c/2"), "gravity": lambda: sim.set_gravity((0,
        0, 0)),
    }  # fmt: skip
    found: dict[str, Any] = {}

    def observe(_: mt.World) -> bool:
        for name, use in uses.items():
            found[name] = in_thread(use)
        found["view"] = in_thread(view.sum)  # only memory
        return False

    sim.run(1.0, observe=observe)
    assert found.pop("view") == pytest.approx(0.6)
    for name, error in found.items():
        assert isinstance(error, mt.Error) and "another thread" in str(error), name
        assert "branch" in error.hint
    sim.step()  # it may be used again


def test_the_same_for_batches() -> None:
    batch = mt.Batch(chain().model, 3)
    with_batch: list[Any] = []

    class Numbers:
        def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
            with_batch.append(in_thread(lambda: batch.q))
            with_batch.append(in_thread(lambda: batch.step(1e-3)))
            return np.full(3, 1e-3)

    batch.step(Numbers())  # type: ignore[arg-type]
    assert len(with_batch) == 2 and all(isinstance(each, mt.Error) and "another thread" in str(each) for each in with_batch)


def test_runs_overlap() -> None:
    barrier = threading.Barrier(4, timeout=60)  # every run waits inside a callback for all others: they all run at once
    results: dict[int, float] = {}

    def work(number: int) -> None:
        sim = chain()
        sim.run(0.02, record_every=0.005, observe=lambda world: barrier.wait() < 0)
        sim.run(0.04)
        results[number] = float(sim.q[0])

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120)
    assert not barrier.broken
    assert len(results) == 4 and len(set(results.values())) == 1


def test_a_run_releases_the_interpreter() -> None:
    sim, stop = chain(), threading.Event()
    counted = [0]

    def count() -> None:
        while not stop.is_set():
            counted[0] += 1
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=count)
    thread.start()
    threading.Timer(0.05, stop.set).start()
    with pytest.raises(KeyboardInterrupt):  # without time for the other thread this would run for ever
        sim.run(1e5, record_every=1e4)
    thread.join()
    assert counted[0] > 0


@pytest.mark.parametrize("send", [lambda: signal.raise_signal(signal.SIGINT), lambda: os.kill(os.getpid(), signal.SIGINT)])
def test_ctrl_c_keeps_rows_and_state(send: Callable[[], None]) -> None:
    sim = chain()
    running = threading.Event()
    threading.Thread(target=lambda: running.wait(60) and send()).start()
    with pytest.raises(KeyboardInterrupt):
        sim.run(1e5, record_every=0.5, observe=lambda world: running.set() if world.time > 1 else None)
    assert sim.last_run is not None and len(sim.last_run) > 1
    assert sim.last_run.time[-1] == sim.time > 0
    assert "interrupted" in sim.last_run.status
    assert np.isfinite(sim.last_run.joints["c/0"].q).all()
    now = sim.time
    sim.step()
    assert sim.time > now


def test_ctrl_c_ends_steps_of_batches() -> None:
    batch = mt.Batch(chain().model, 4, threads=2)
    threading.Timer(0.1, lambda: signal.raise_signal(signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        batch.run(1e-4, 10**12)
    assert batch.time[0] > 0 and not batch.diverged.any()


class Planned(Exception):
    """Raised by callbacks."""


def fail(*_: Any) -> Any:
    raise Planned("by a callback")


def install(kind: str, sim: mt.Simulation, function: Callable[[Any], Any]) -> Callable[[mt.World], Any] | None:
    """Makes the function a callback of that kind; returns what is to be the observer."""
    if kind == "condition":
        sim.when(function).then(mt.break_joint("c/2"))
    elif kind == "quantity":
        sim.when(mt.measured(function) < 3).then(mt.break_joint("c/2"))
    elif kind == "drive":
        sim.drive("c/1", function)
    elif kind == "force":
        sim.force("c/1", function)
    else:
        return function
    return None


KINDS = ["condition", "quantity", "drive", "force", "observer"]


def result(kind: str) -> Any:
    """What a callback of that kind may return."""
    return {"condition": -1.0, "quantity": 5.0, "drive": 0.0, "force": ((0, 0, 0), (0, 0, 0)), "observer": True}[kind]


@pytest.mark.parametrize("kind", KINDS)
def test_exceptions_of_callbacks_end_the_run_and_propagate(kind: str) -> None:
    sim = chain()
    calls = [0]

    def function(passed: Any) -> Any:
        calls[0] += 1
        return fail() if calls[0] == 30 else result(kind)

    observer = install(kind, sim, function)
    with pytest.raises(Planned, match="by a callback"):
        sim.run(0.1, observe=observer)
    assert sim.last_run is not None and "done" not in sim.last_run.status
    assert 0 < sim.time < 0.1 and np.isfinite(sim.q).all() and np.isfinite(sim.p).all()
    assert sim.last_run.time[-1] == sim.time
    sim.run(0.1, observe=observer)  # it goes on
    assert sim.time == 0.1


@pytest.mark.parametrize("kind", KINDS[:4])
def test_exceptions_in_single_steps_and_evaluations(kind: str) -> None:
    sim = chain()
    install(kind, sim, fail)
    with pytest.raises(Planned):
        sim.step()
    assert np.isfinite(sim.q).all()


@pytest.mark.parametrize(
    ("kind", "value"),
    [("condition", "x"), ("condition", None), ("drive", "x"), ("drive", [1, 2]), ("drive", None), ("drive", 1j), ("force", 1.0),
     ("force", ((1, 2), (1, 2, 3))), ("force", ((1, 2, "x"), (1, 2, 3))), ("force", None), ("force", ((np.nan, 0, 0), (0, 0,
     0)))],
)  # fmt: skip
def test_wrong_results_of_callbacks_are_explained(kind: str, value: Any) -> None:
    sim = chain()
    install(kind, sim, lambda passed: value)
    with pytest.raises(mt.Error, match="function"):
        sim.run(0.01)
    assert np.isfinite(sim.q).all()


@pytest.mark.parametrize("kind", KINDS)
def test_changes_from_inside_a_callback_are_refused(kind: str) -> None:
    sim = chain()
    view, snapshot = sim.q, sim.snapshot()
    handle = sim.world.joints["c/1"]
    changes: list[Callable[[], Any]] = [
        sim.step, lambda: sim.run(1), lambda: sim.apply(mt.break_joint("c/1")), lambda: sim.set_state(q=[0, 0, 0]),
        lambda: sim.restore(snapshot),
        lambda: setattr(sim, "q", [0, 0, 0]), lambda: sim.add("x/y", mass=1, inertia=1), lambda: sim.remove("c/2"),
        lambda: sim.drive("c/1", None),
        lambda: sim.force("c/1", None), lambda: sim.set_gravity((0, 0, 0)), sim.keep_history, sim.undo,
        lambda: sim.restore_state("{}"),
    ]  # fmt: skip
    reads: list[Callable[[], Any]] = [lambda: sim.time, lambda: sim.q, lambda: sim.energy, sim.snapshot, lambda: handle.q,
    sim.mass_matrix, sim.branch]
    errors: list[Exception] = []

    def function(passed: Any) -> Any:
        for act in changes + (reads if kind != "observer" else []):
            try:
                act()
            except mt.Error as error:
                errors.append(error)
            else:
                raise AssertionError("it was not refused")
        if kind == "observer":
            for read in reads:
                read()
        return result(kind)

    observer = install(kind, sim, function)
    sim.run(0.002, observe=observer)
    assert len(errors) >= len(changes) and all(error.hint for error in errors)
    assert sim.time == 0.002 and not view.stale and len(sim.events) == 0


def test_an_observer_cannot_write_but_may_schedule_and_stop() -> None:
    sim = chain()
    sim.run(0.01, observe=lambda world: sim.at(0.02).then(mt.break_joint("c/2")) is None)
    assert sim.time == 0.0
    sim.run(0.03)
    assert [event.time for event in sim.events] == [0.02]

    def write(world: mt.World) -> None:
        sim.q[0] = 3.0
        sim.energy  # noqa: B018  the first use after writing

    with pytest.raises(mt.Error, match="observer"):
        sim.run(0.05, observe=write)
    assert sim.q[0] != 3.0


def test_callbacks_may_use_other_simulations() -> None:
    sim, other = chain(), chain()
    other.drive("c/0", lambda context: 0.1 * context.time)

    def effort(context: mt.Context) -> float:
        other.step(1e-4)
        return float(other.q[0])

    sim.drive("c/0", effort)
    sim.run(0.003)
    assert other.time == pytest.approx(12 * 1e-4, abs=5e-4)


def test_arguments_that_change_the_simulation_that_they_are_given_to() -> None:
    sim = chain()

    class Busy:
        def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
            sim.apply(mt.break_joint("c/1"))
            return np.zeros(3)

    for use in (lambda: sim.set_state(q=Busy()), lambda: sim.inverse_dynamics(Busy()), lambda: sim.jacobian("c/2", Busy())):
        with pytest.raises(mt.Error, match="arguments"):
            use()
    assert len(sim.events) == 0 and len(sim.q) == 3
