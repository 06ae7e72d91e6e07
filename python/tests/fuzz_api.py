"""A fuzzer of the Python API: random calls with valid and hostile arguments, in several simulations, batches and threads.

    python fuzz_api.py SEED OPERATIONS

It ends with exit code 0 if nothing but the documented exceptions was raised. Whatever happens, the process must not crash.
"""

from __future__ import annotations

import copy
import faulthandler
import gc
import inspect
import os
import pickle
import random
import signal
import sys
import tempfile
import threading
import traceback
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from fuzz_values import Busy, Values
from random_models import joint, random_model, some_action, vector

import momentree as mt

EXPECTED = (mt.Error, TypeError, ValueError, LookupError, AttributeError, ZeroDivisionError, OverflowError, MemoryError, TimeoutError,
            RecursionError, OSError, StopIteration, ImportError, AssertionError, BufferError, NotImplementedError, pickle.PicklingError)  # fmt: skip
SLOW = {"report", "_repr_html_", "plot", "to_pandas", "save"}
LOGGED = "MOMENTREE_FUZZ_LOG" in os.environ
SKIPPED = {"ctypes", "tofile", "dump", "setflags"}  # of arrays: not ours


class Fuzzer:
    """One seeded sequence of operations."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.pools: dict[str, list[Any]] = {
            kind: [] for kind in ("model", "sim", "batch", "view", "handle", "snapshot", "run", "scheduled", "event", "other")
        }
        self.values = Values(self.rng, self.pools)
        self.problems: list[str] = []
        self.threads: list[threading.Thread] = []

    def keep(self, kind: str, value: Any) -> None:
        """Into a pool; an old one may go."""
        pool = self.pools[kind]
        pool.append(value)
        if len(pool) > (4 if kind in ("sim", "batch", "model") else 8):
            pool.pop(self.rng.randrange(len(pool)))

    def note(self, *what: Any) -> None:
        """For finding what a crash needs."""
        if LOGGED:
            print(*what, file=sys.stderr, flush=True)

    def one(self, kind: str) -> Any:
        """Of a pool; what it is made of is made first."""
        if not self.pools[kind]:
            {"model": self.new_model, "sim": self.new_sim, "batch": self.new_batch}[kind]()
        return self.rng.choice(self.pools[kind])

    # Operations

    def new_model(self) -> None:
        self.keep("model", random_model(self.rng.randrange(1000), self.rng.choice([0, 1, 2, 3, 4, 5, 6, 7])))

    def new_sim(self) -> None:
        method = self.rng.choice(["rk4", "rk4", "midpoint", "damped", "dopri5", "dop853"])
        self.keep("sim", mt.Simulation(self.one("model"), method=method))

    def new_batch(self) -> None:
        self.keep("batch", mt.Batch(random_model(self.rng.randrange(1000), self.rng.randint(1, 4)), self.rng.randint(1, 9), threads=2))

    def act(self) -> None:
        sim = self.one("sim")
        actions = [some_action(sim, self.rng) for _ in range(self.rng.choice([1, 1, 2]))]
        self.note(id(sim), actions)
        sim.apply(*actions)

    def schedule(self) -> None:
        sim, rng = self.one("sim"), self.rng
        names = list(sim.world.joints) or ["none"]
        event = rng.choice(
            [
                lambda: sim.at(sim.time + rng.uniform(0, 0.02)),
                lambda: sim.when(mt.speed(rng.choice(names)) > rng.uniform(0, 1)),
                lambda: sim.when(lambda world: world.time - 0.01 - self.chance_of_use(sim)),
                lambda: sim.when((mt.measured(lambda world: np.sin(300 * world.time)) > 0).repeated()),
                lambda: sim.every(0.005, sim.time),
            ]
        )()
        self.keep("scheduled", event)
        event.then(some_action(sim, rng)).named(self.values.name(["a", "b"]))

    def functions(self) -> None:
        sim, rng = self.one("sim"), self.rng
        if rng.random() < 0.5:
            name = rng.choice(list(sim.world.joints))
            sim.drive(name, lambda context: np.full(len(context.v(name)), 0.1 + self.chance_of_use(sim, context)))
        else:
            sim.force(rng.choice(list(sim.world.bodies)), lambda context: (vector(rng), vector(rng, self.chance_of_use(sim, context))))

    def chance_of_use(self, sim: mt.Simulation, passed: Any = None) -> float:
        """What callbacks do that they must not."""
        choice = self.rng.random()
        if choice < 0.005:
            self.keep("other", passed)
            self.rng.choice([sim.step, lambda: sim.apply(mt.break_joint("m0/body")), sim.snapshot, lambda: sim.q])()
        elif choice < 0.008:
            raise ZeroDivisionError("of a callback")
        return 0.0

    def observe(self) -> None:
        sim, rng = self.one("sim"), self.rng

        def observer(world: mt.World) -> Any:
            self.keep("handle", world)
            if rng.random() < 0.2:
                rng.choice([sim.step, lambda: sim.energy, lambda: sim.at(sim.time).then(some_action(sim, rng)), sim.branch])()
            return rng.random() < 0.97

        end = sim.time + rng.uniform(0, 0.03)
        self.keep("run", sim.run(end, record_every=rng.choice([0, 0.004]), reactions=rng.random() < 0.5, observe=observer))

    def handles(self) -> None:
        sim = self.one("sim")
        world = sim.world
        names = [*world.joints, *world.bodies]
        self.keep("handle", self.rng.choice([world, sim[self.values.name(names)]]))
        self.keep("view", self.rng.choice([lambda: sim.q, lambda: sim.v[1:], lambda: sim.p, lambda: sim.effort, lambda: sim.evaluate()[0]])())

    def write(self) -> None:
        view = self.one("view") if self.pools["view"] else self.one("sim").q
        if isinstance(view, np.ndarray) and view.size:
            view[self.rng.randrange(view.size)] = self.rng.choice([0.1, 0.2, -0.3, np.nan, 1e300])

    def travel(self) -> None:
        sim, rng = self.one("sim"), self.rng
        choice = rng.randrange(6)
        self.note(id(sim), choice)
        if choice == 0:
            self.keep("snapshot", sim.snapshot())
        elif choice == 1 and self.pools["snapshot"]:
            sim.restore(self.one("snapshot"))
        elif choice == 2:
            sim.keep_history()
        elif choice == 3:
            sim.undo(rng.choice([-1, 0, -2]), rng.random() < 0.5)
        elif choice == 4:
            self.keep("sim", sim.branch())
        elif self.pools["run"]:
            run = self.one("run")
            if isinstance(run, mt.Run):
                sim.restore(run.state(rng.randrange(len(run))))

    def bodies(self) -> None:
        sim, rng = self.one("sim"), self.rng
        if rng.random() < 0.3:
            body = rng.choice(list(sim.world.bodies))
            self.note(id(sim), "remove", body)
            sim.remove(body)
        else:
            kind = rng.choice(["Revolute", "Ball", "Free", "Weld"])
            parent = rng.choice([None, *sim.world.bodies])
            sim.add(f"new/b{rng.randrange(99)}", mass=1, inertia=0.1, parent=parent, joint=joint(rng, kind), at=vector(rng))

    def pickled(self) -> None:
        kind = self.rng.choice(list(self.pools))
        if self.pools[kind]:
            value = self.one(kind)
            self.keep(kind, self.rng.choice([copy.copy, copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])(value))

    def reenter(self) -> None:
        """Arguments whose conversion changes the simulation that they are given to."""
        sim, rng = self.one("sim"), self.rng
        busy = Busy(lambda: rng.choice([self.act, self.bodies, self.travel, sim.step, lambda: sim.q])(), rng.choice([3, len(sim.q), len(sim.v)]))
        body = rng.choice([*sim.world.bodies, busy])
        rng.choice(
            [
                lambda: sim.set_state(q=busy, v=busy), lambda: sim.inverse_dynamics(busy), lambda: sim.jacobian(body, busy),
                lambda: setattr(sim, "q", busy), lambda: setattr(sim, "effort", busy), lambda: sim.set_gravity(busy), lambda: sim.step(busy),
                lambda: sim.apply(mt.impulse(body, force=busy)), lambda: sim.add("new/x", mass=1, inertia=busy, parent=body),
                lambda: sim.when(mt.speed(body) > busy), lambda: self.one("batch").set_state(q=busy), lambda: sim.at(busy).then(busy),
            ]
        )()  # fmt: skip

    def batches(self) -> None:
        batch, rng = self.one("batch"), self.rng
        worlds = rng.choice([None, 0, [0, 0], slice(1, None), np.arange(len(batch)) % 2 == 0])
        names = list(batch.joints)
        rng.choice(
            [
                lambda: batch.step(1e-3), lambda: batch.run(1e-3, 5), lambda: batch.apply(worlds, mt.break_joint(rng.choice(names))),
                lambda: batch.apply(worlds, mt.lock(rng.choice(names))), lambda: batch.groups, lambda: batch.joints[rng.choice(names)],
                lambda: batch.set_state(worlds, v=batch.groups[0].v[0]), lambda: batch.set_effort(batch.groups[-1].v[0], worlds),
                lambda: setattr(batch, "q", batch.q), lambda: batch.bodies[rng.choice(list(batch.bodies))], lambda: batch.step(1e300),
            ]
        )()  # fmt: skip

    def thread(self) -> None:
        """Two threads on one simulation, and one on a branch."""
        sim = self.one("sim")
        branch = sim.branch()

        def work(it: mt.Simulation) -> None:
            for call in (lambda: it.run(it.time + 0.02), lambda: it.q.sum(), it.step, it.snapshot, lambda: it.energy):
                try:
                    call()
                except Exception as error:
                    self.judge(error)

        self.threads = [threading.Thread(target=work, args=(each,)) for each in (sim, branch, sim)]
        for each in self.threads:
            each.start()
        for each in self.threads:
            each.join()

    def anything(self) -> None:
        """A random attribute of a random object, called with random arguments."""
        rng = self.rng
        owner: Any = mt if rng.random() < 0.15 else self.one(rng.choice([kind for kind in self.pools if self.pools[kind]]))
        names = [name for name in dir(owner) if name not in SKIPPED and not (name in SLOW and rng.random() < 0.95)]
        names = [name for name in names if not name.startswith("_") or name in ("__getitem__", "__len__", "__repr__", "__eq__", "__hash__")]
        if isinstance(owner, mt.Simulation):
            names = [name for name in names if name != "run"] + ["run_shortly"]
        name = rng.choice(names)
        if name == "run_shortly":
            self.keep("run", owner.run(owner.time + 0.01, record_every=self.values.any()))
            return
        self.note(type(owner).__name__, name)
        if name in ("q", "v", "p", "effort", "gravity") and rng.random() < 0.3:
            setattr(owner, name, self.values.any())
        value = getattr(owner, name)
        if callable(value):
            self.keep("other", value)
            value = value(*self.arguments(value))
        if isinstance(value, np.ndarray):
            self.keep("view", value)
        elif value is not None and type(value).__module__.startswith("momentree"):
            kind = {mt.Model: "model", mt.Simulation: "sim", mt.Batch: "batch", mt.Snapshot: "snapshot", mt.Run: "run", mt.Event: "event"}
            self.keep(kind.get(type(value), "handle"), value)

    def arguments(self, function: Callable[..., Any]) -> list[Any]:
        try:
            most = len(inspect.signature(function).parameters)
        except (TypeError, ValueError):
            most = 2
        return [self.values.any() for _ in range(min(most, self.rng.randrange(5)))]

    # Running

    def judge(self, error: BaseException) -> None:
        """Collects what must not be raised."""
        try:
            text = str(error)
        except Exception:  # of an object that was overwritten
            text = ""
        if not isinstance(error, EXPECTED) or "std::" in text or "bad_cast" in text:
            self.problems.append("".join(traceback.format_exception(error)))

    def run(self, operations: int) -> None:
        choices = [self.new_model, self.new_sim, self.new_batch, *[self.act] * 6, *[self.schedule] * 3, *[self.functions] * 2, *[self.observe] * 4,
                   *[self.handles] * 3, *[self.write] * 2, *[self.travel] * 5, *[self.bodies] * 2, self.pickled, *[self.reenter] * 3,
                   *[self.batches] * 4, self.thread, *[self.anything] * 40]  # fmt: skip
        for k in range(operations):
            operation = self.rng.choice(choices)
            self.note(k, operation.__name__)
            try:
                signal.setitimer(signal.ITIMER_REAL, 1.0)
                try:
                    operation()
                finally:
                    signal.setitimer(signal.ITIMER_REAL, 0)
            except Exception as error:
                self.judge(error)
            if k % 100 == 0:
                gc.collect()


def main() -> int:
    faulthandler.enable()
    warnings.simplefilter("ignore")
    os.chdir(tempfile.mkdtemp(prefix="momentree_fuzz_"))

    def too_long(*_: Any) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, too_long)
    seed, operations = int(sys.argv[1]), int(sys.argv[2])
    fuzzer = Fuzzer(seed)
    fuzzer.run(operations)
    for problem in fuzzer.problems[:5]:
        print(f"seed {seed}: unexpected\n{problem}", file=sys.stderr)
    return 1 if fuzzer.problems else 0


if __name__ == "__main__":
    sys.exit(main())
