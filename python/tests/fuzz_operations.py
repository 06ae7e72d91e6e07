"""Operations of the fuzzer of the API: each is valid most of the time."""

from __future__ import annotations

import copy
import os
import pickle
import random
import sys
import threading
from typing import Any

import numpy as np
from fuzz_values import Busy, Values
from random_models import joint, random_model, some_action, vector

import momentree as mt

LOGGED = "MOMENTREE_FUZZ_LOG" in os.environ


class Operations:
    """What there is at present, and what may be done with it."""

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
        self.keep("batch", mt.Batch(random_model(self.rng.randrange(1000), self.rng.randint(1, 4)), self.rng.randint(1, 9),
        threads=2, variables=self.rng.choice(["momenta", "velocities"])))

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
            sim.force(rng.choice(list(sim.world.bodies)), lambda context: (vector(rng), vector(rng, self.chance_of_use(sim,
            context))))

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
        self.keep("view", self.rng.choice([lambda: sim.q, lambda: sim.v[1:], lambda: sim.p, lambda: sim.effort,
        lambda: sim.evaluate()[0]])())

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
            touches = rng.choice([None, None, {"sphere": 0.1}, [{"box": [0.1, 0.2, 0.3]}, {"sphere": 0.15}]])
            sim.add(f"new/b{rng.randrange(99)}", mass=1, inertia=0.1, parent=parent, joint=joint(rng, kind), at=vector(rng),
                    collision=touches)  # fmt: skip

    def pickled(self) -> None:
        kind = self.rng.choice(list(self.pools))
        if self.pools[kind]:
            value = self.one(kind)
            self.keep(kind, self.rng.choice([copy.copy, copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])(value))

    def reenter(self) -> None:
        """Arguments whose conversion changes the simulation that they are given to."""
        sim, rng = self.one("sim"), self.rng
        busy = Busy(lambda: rng.choice([self.act, self.bodies, self.travel, sim.step, lambda: sim.q])(), rng.choice([3,
        len(sim.q), len(sim.v)]))
        body = rng.choice([*sim.world.bodies, busy])
        rng.choice(
            [
                lambda: sim.set_state(q=busy, v=busy), lambda: sim.inverse_dynamics(busy), lambda: sim.jacobian(body, busy),
                lambda: setattr(sim, "q", busy), lambda: setattr(sim, "effort", busy), lambda: sim.set_gravity(busy),
                lambda: sim.step(busy),
                lambda: sim.apply(mt.impulse(body, force=busy)), lambda: sim.add("new/x", mass=1, inertia=busy, parent=body),
                lambda: sim.when(mt.speed(body) > busy), lambda: self.one("batch").set_state(q=busy),
                lambda: sim.at(busy).then(busy),
            ]
        )()  # fmt: skip

    def batches(self) -> None:
        batch, rng = self.one("batch"), self.rng
        worlds = rng.choice([None, 0, [0, 0], slice(1, None), np.arange(len(batch)) % 2 == 0])
        names = list(batch.joints)
        rng.choice(
            [
                lambda: batch.step(1e-3), lambda: batch.run(1e-3, 5), lambda: batch.apply(worlds,
                mt.break_joint(rng.choice(names))),
                lambda: batch.apply(worlds, mt.lock(rng.choice(names))), lambda: batch.groups,
                lambda: batch.joints[rng.choice(names)],
                lambda: batch.set_state(worlds, v=batch.groups[0].v[0]), lambda: batch.set_effort(batch.groups[-1].v[0], worlds),
                lambda: setattr(batch, "q", batch.q), lambda: batch.bodies[rng.choice(list(batch.bodies))],
                lambda: batch.step(1e300),
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

    def judge(self, error: BaseException) -> None:
        """Collects what must not be raised."""
        raise NotImplementedError
