"""Views, handles, contexts and functions outlive what they belong to, and are errors when they no longer mean anything."""

from __future__ import annotations

import copy
import gc
import pathlib
import pickle
import resource
import weakref
from typing import Any

import numpy as np
import pytest
from random_models import random_model

import momentree as mt


def chain(count: int = 3) -> mt.Simulation:
    model = mt.Model()
    parent = None
    for k in range(count):
        model.add(f"c/{k}", mass=1, inertia=0.1, com=(0.5, 0, 0), parent=parent, at=(float(k > 0), 0, 0), q=0.1 * (k + 1),
                  joint=mt.Revolute(axis=(0, 1, 0)))  # fmt: skip
        parent = f"c/{k}"
    return mt.Simulation(model)


def test_views_keep_their_memory() -> None:
    sim = chain()
    view, part, rates, world, handle = sim.q, sim.q[1:], sim.evaluate(), sim.world, sim.world.bodies["c/1"]
    joints = sim.world.joints
    del sim
    gc.collect()
    assert view.tolist() == [0.1, 0.2, 0.30000000000000004] and part.tolist() == view.tolist()[1:]
    assert rates.qdot.shape == (3,) and np.isfinite(rates.pdot).all()
    assert world.time == 0 and handle.position.shape == (3,) and joints["c/0"].q[0] == 0.1


def test_models_and_their_bodies_outlive_each_other() -> None:
    model = mt.Model()
    body = model.add("a/b", mass=1, inertia=1, joint=mt.Revolute())
    sim = mt.Simulation(model)
    del model
    gc.collect()
    assert body.name == "a/b"
    sim.step()


def stale_view() -> tuple[mt.Simulation, Any]:
    sim = chain()
    view = sim.q
    sim.apply(mt.break_joint("c/1"))
    return sim, view


USES = {
    "item": lambda v: v[0], "slice": lambda v: v[1:], "write": lambda v: v.__setitem__(0, 1.0), "iterate": lambda v: list(v),
    "add": lambda v: v + 1, "radd": lambda v: 1 + v, "negate": lambda v: -v, "inplace": lambda v: v.__iadd__(1),
    "compare": lambda v: v == v,
    "sin": lambda v: np.sin(v), "out": lambda v: np.add([1, 2, 3], 1, out=v), "matmul": lambda v: np.eye(3) @ v,
    "reduce": lambda v: np.add.reduce(v),
    "accumulate": lambda v: np.add.accumulate(v), "outer": lambda v: np.multiply.outer(v, v), "at": lambda v: np.add.at(v, 0, 1),
    "where": lambda v: np.where(v > 0, v, 0), "concatenate": lambda v: np.concatenate([v, v]), "sum": lambda v: np.sum(v),
    "dot": lambda v: np.dot(v, v),
    "norm": lambda v: np.linalg.norm(v), "copyto": lambda v: np.copyto(v, 0), "stack": lambda v: np.stack((v, v)),
    "clip": lambda v: np.clip(v, 0, 1),
    "einsum": lambda v: np.einsum("i,i", v, v), "allclose": lambda v: np.allclose(v, v), "method sum": lambda v: v.sum(),
    "method max": lambda v: v.max(),
    "method mean": lambda v: v.mean(), "method dot": lambda v: v.dot(v), "method copy": lambda v: v.copy(),
    "tolist": lambda v: v.tolist(),
    "tobytes": lambda v: v.tobytes(), "fill": lambda v: v.fill(0), "sort": lambda v: v.sort(), "argmax": lambda v: v.argmax(),
    "item()": lambda v: v.item(0),
    "astype": lambda v: v.astype(int), "reshape": lambda v: v.reshape(3, 1), "ravel": lambda v: v.ravel(),
    "take": lambda v: v.take([0]),
    "put": lambda v: v.put(0, 1), "all": lambda v: v.all(), "cumsum": lambda v: v.cumsum(), "round": lambda v: v.round(),
    "nonzero": lambda v: v.nonzero(),
    "str": lambda v: str(v), "format": lambda v: f"{v}", "float": lambda v: float(v[:1]), "in": lambda v: 0.1 in v,
    "pickle": lambda v: pickle.dumps(v),
    "copy": lambda v: copy.copy(v), "deepcopy": lambda v: copy.deepcopy(v), "len": lambda v: len(v),
    "transposed": lambda v: v.T[0],
}  # fmt: skip


@pytest.mark.parametrize("use", USES)
def test_a_stale_view_is_an_error_in_every_use(use: str) -> None:
    _, view = stale_view()
    with pytest.raises(mt.Error, match="stale.*sim.q"):
        USES[use](view)


@pytest.mark.parametrize("use", sorted(set(USES) - {"write", "inplace", "out", "at", "copyto", "fill", "sort", "put", "float"}))
def test_the_same_uses_of_a_live_view_are_those_of_an_array(use: str) -> None:
    live, plain = chain().q, np.array(chain().q)
    one, other = USES[use](live), USES[use](plain)
    if use in ("pickle", "copy", "deepcopy", "str", "format"):
        return
    np.testing.assert_array_equal(one, other)


def test_what_bypasses_the_check_sees_nan_and_never_other_joints() -> None:
    sim = chain()
    view, v, p, part = sim.q, sim.v, sim.p, sim.q[1:]
    memory, plain, flat = memoryview(view), np.asarray(view), view.flat  # type: ignore[arg-type]
    sim.step(0.1)
    assert memory[0] == plain[0] == sim.q[0]
    sim.apply(mt.break_joint("c/1"))
    sim.step(0.1)
    assert np.isnan(plain).all() and all(np.isnan(memory)) and all(np.isnan(x) for x in flat)
    for each in (view, v, p, part):
        assert each.stale and "stale" in repr(each)
        with pytest.raises(mt.Error, match="stale"):
            each[0]
    plain[0] = 7.0  # writing there changes nothing
    before = sim.q.copy()
    sim.step(0.0)
    assert np.array_equal(sim.q, before) and len(sim.q) == 9


def test_views_follow_snapshots_of_the_same_joints() -> None:
    sim = chain()
    view, start = sim.q, sim.snapshot()
    sim.run(0.1)
    assert view[0] != 0.1
    sim.restore(start)
    assert view[0] == 0.1 and not view.stale
    sim.apply(mt.lock("c/1"))  # the same joints
    assert not view.stale


def test_worlds_and_contexts_are_valid_during_the_call_only() -> None:
    sim = chain()
    kept: list[Any] = []
    sim.drive("c/0", lambda context: kept.append(context) or 0.0)
    sim.force("c/1", lambda context: kept.append(context) or ((0, 0, 0), (0, 0, 0)))
    sim.when(lambda world: kept.extend([world, world.joints["c/0"], world.bodies["c/0"]]) or -1.0).then(mt.break_joint("c/0"))
    sim.step()
    assert len(kept) > 9
    for each in kept:
        uses = {
            mt.Context: [lambda c: c.time, lambda c: c.q("c/0"), lambda c: c.position("c/1")],
            mt.World: [lambda w: w.time, lambda w: w.energy, lambda w: w.joints["c/0"]],
            mt.Joint: [lambda j: j.q, lambda j: j.reaction], mt.Body: [lambda b: b.position],
        }[type(each)]  # fmt: skip
        for use in uses:
            with pytest.raises(mt.Error, match="no longer valid"):
                use(each)


def test_handles_of_others_and_of_removed_bodies() -> None:
    sim, other = chain(), chain()
    for use in (lambda: sim.jacobian(other.world.bodies["c/1"]), lambda: sim.apply(mt.break_joint(other.world.joints["c/1"])),
                lambda: sim.drive(other.world.joints["c/1"], None), lambda: sim.remove(other.world.bodies["c/1"]),
                lambda: sim.when(mt.speed(other.world.joints["c/1"]) > 1), lambda: sim.add("d/1", mass=1,
                parent=other.world.bodies["c/1"])):  # fmt: skip
        with pytest.raises(mt.Error, match="another simulation"):
            use()
    body, joint = sim.world.bodies["c/2"], sim.world.joints["c/2"]
    sim.remove("c/2")
    assert not body.alive and body.name == "c/2"
    for read in (lambda: body.position, lambda: body.linear_acceleration, lambda: joint.q, lambda: joint.kind,
    lambda: sim.jacobian(body)):
        with pytest.raises(mt.Error, match="removed"):
            read()
    assert "c/2" not in sim.world.bodies and list(sim.world.bodies) == ["c/0", "c/1"]


def test_handles_of_bodies_that_a_restored_state_does_not_have() -> None:
    sim = chain()
    start = sim.snapshot()
    body = sim.add("d/1", mass=1, inertia=1, joint=mt.Revolute())
    joint = sim.world.joints["d/1"]
    sim.restore(start)
    for number in range(2):
        for use in (lambda: body.position, lambda: body.mass, lambda: joint.q, lambda: sim.apply(mt.break_joint(joint)),
        lambda: sim.jacobian(body)):
            with pytest.raises(mt.Error, match="d/1"):
                use()
        assert not body.alive
        sim.add(f"e/{number}", mass=2, inertia=1, joint=mt.Prismatic())  # takes the same number


def test_a_run_of_a_world_without_one_of_its_bodies(tmp_path: pathlib.Path) -> None:
    sim = chain()
    sim.remove("c/2")
    run = sim.run(0.01, reactions=True)
    assert np.isnan(run.bodies["c/2"].position).all() and np.isfinite(run.bodies["c/1"].position).all()
    run.save(tmp_path / "run")
    sim.apply(mt.reroot("c/1") if not sim.world.mechanisms[0].grounded else mt.break_joint("c/1"))
    sim.apply(mt.lock("c/0"))
    sim.step()


def test_functions_live_as_long_as_what_calls_them() -> None:
    class Controller:
        def __init__(self) -> None:
            self.calls = 0

        def __eq__(self, other: object) -> bool:
            return isinstance(other, Controller)

        __hash__ = object.__hash__

        def effort(self, context: mt.Context) -> float:
            self.calls += 1
            return 0.1

    sim = chain()
    branch = sim.branch()
    sim.drive("c/0", Controller().effort)
    branch.drive("c/0", Controller().effort)  # equal to the other, but another
    snapshot = sim.snapshot()
    del sim
    gc.collect()
    branch.restore(snapshot)
    del snapshot
    gc.collect()
    junk = [Controller().effort for _ in range(100)]  # takes the memory of what was freed
    branch.run(0.01)
    assert len(junk) == 100 and branch.time == 0.01


def test_simulations_with_functions_are_collected() -> None:
    def make() -> weakref.ref[mt.Simulation]:
        sim = chain()
        sim.when(lambda world: sim.until - world.time).then(mt.break_joint("c/2"))
        sim.drive("c/0", lambda context: 0.0 * sim.until)
        sim.force("c/1", lambda context: ((0, 0, sim.until), (0, 0, 0)))
        sim.run(0.005)
        return weakref.ref(sim)

    references = [make() for _ in range(20)]
    gc.collect()
    assert [each() for each in references] == [None] * 20


def test_nothing_leaks() -> None:
    model = random_model(5, 3)

    def cycle() -> None:
        sim = mt.Simulation(model)
        sim.drive(next(iter(sim.world.joints)), lambda context: 0.0)
        view, world, snapshot = sim.q, sim.world, sim.snapshot()
        sim.at(0.001).then(mt.break_joint(next(iter(world.joints))))
        sim.run(0.002)
        sim.restore(snapshot)
        sim.effort = np.zeros(len(sim.v))
        with pytest.raises(mt.Error):
            sim.jacobian("none")
        assert len(view.shape) == 1

    def batches() -> None:
        batch = mt.Batch(model, 3, threads=1)
        batch.apply(0, mt.break_joint(next(iter(batch.joints))))
        batch.step(1e-3)

    for _ in range(200):
        cycle(), batches()
    gc.collect()
    before = resident()
    for _ in range(2000):
        cycle()
    for _ in range(500):
        batches()
    gc.collect()
    assert resident() - before < 12e6


def resident() -> float:
    """Memory of this process (bytes)."""
    statm = pathlib.Path("/proc/self/statm")
    if not statm.exists():
        return float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    return int(statm.read_text().split()[1]) * resource.getpagesize()
