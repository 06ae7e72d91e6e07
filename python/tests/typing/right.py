"""What type checkers accept, and the types that they find. Checked by test_types.py; it also runs."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import momentree as mt
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING or sys.version_info >= (3, 11):
    from typing import assert_type
else:

    def assert_type(value: Any, kind: object) -> Any:
        return value


Array = NDArray[np.float64]


def arm(length: mt.typing.Number = 1.0, shape: mt.typing.Shape | None = None, wind: bool = True) -> mt.Model:
    model = mt.Model(gravity=np.array([0, 0, -9.81]))
    elbow = mt.Revolute((0, 1, 0), damping="0.1 N m s", limits={"lower": -2, "upper": 2, "stiffness": 100}, effort={"sine": {"amplitude": 0.1, "frequency": 1}})
    upper = model.add("arm/upper", mass=2, com=[0.5, 0, 0], inertia=(0.01, 0.1, 0.1), joint=elbow, q=0.3, shape=shape)
    model.add("arm/lower", mass="1 kg", com=np.zeros(3), inertia=0.1, parent=upper, at=(length, 0, 0), joint=elbow)
    model.add("arm/hand", mass=0.1, inertia=1e-3, parent="arm/lower", at={"xyz": [1, 0, 0], "rpy": [0, 0, 0]})
    if wind:
        model.add_force(upper, force=(0, 0, {"sine": {"amplitude": 1, "frequency": 0.5}}), axes="body", drag={"linear": 0.1})
        model.add_spring("rope", start=(upper, np.zeros(3)), end=("ground", (0, 0, 2)), stiffness="2 kN/m", tension_only=True)
        model.add_spring("rod", start="arm/hand", end="ground", stiffness=10, rest=1, strength="5 N")
    assert_type(model.spring_names, list[str])
    assert_type(upper, mt.ModelBody)
    assert_type(upper.name, str)
    assert_type(model.gravity, Array)
    assert_type(model.body_names, list[str])
    assert_type(model.copy(), mt.Model)
    return model


def read(sim: mt.Simulation) -> None:
    assert_type(sim.q, mt.StateView)
    assert_type(sim.q[0], np.float64)
    assert_type(sim.q[:1], mt.StateView)
    assert_type(sim.q.copy(), Array)
    rates = sim.evaluate()
    assert_type(rates, mt.Rates)
    assert_type(rates.pdot, mt.StateView)
    assert_type(sim.mass_matrix(), Array)
    assert_type(sim.accelerations(), Array)
    assert_type(sim.jacobian(sim.world.bodies["arm/hand"], point=[0, 0, 0.1]), Array)
    assert_type(sim.inverse_dynamics(np.zeros(2)), Array)
    assert_type(sim.energy.total, float)
    assert_type(sim.momentum.linear, Array)
    print(sim["arm/upper"].q + sim["arm/hand"].v.size)
    joint, body = sim.world.joints["arm/upper"], sim.world.bodies["arm/hand"]
    assert_type(joint, mt.Joint)
    assert_type(body, mt.Body)
    assert_type(sim.world.bodies.get("arm/foot"), mt.Body | None)
    assert_type(joint.reaction.force, Array)
    assert_type(joint.locked, tuple[int, ...])
    spring = sim.world.springs["rope"]
    assert_type(spring, mt.Spring)
    assert_type(spring.tension, float)
    assert_type(spring.end, tuple[str, Array])
    assert_type(body.position, Array)
    assert_type([mechanism.bodies for mechanism in sim.world.mechanisms], list[list[str]])
    assert_type(sim.snapshot(), mt.Snapshot)


def write(sim: mt.Simulation) -> None:
    sim.q = [0.1, 0.2]
    sim.v = np.zeros(2, dtype=np.float32)
    sim.q[0] = 0.3
    sim.effort[:] = 0.0
    sim.set_state(q=(0.1, 0.2), time=0.0)
    sim.drive("arm/lower", lambda context: -0.1 * context.v("arm/lower")[0])
    sim.drive("arm/upper", lambda context: -0.1 * context.v("arm/upper"))
    sim.drive(sim.world.joints["arm/upper"], None)
    sim.force(sim.world.bodies["arm/hand"], lambda context: ((0, 0, context.time), np.zeros(3)))


def events(sim: mt.Simulation) -> None:
    cut = mt.break_joint(sim.world.joints["arm/lower"])
    assert_type(cut, mt.Action)
    assert_type(sim.at(0.01).then(cut, mt.set_parameters("arm/upper", damping=0.2)).named("cut"), mt.Scheduled)
    assert_type(sim.every("0.5 s", "10 ms"), mt.Scheduled)
    assert_type(mt.reaction("arm/upper").force > 40, mt.Condition)
    assert_type(mt.slip("arm", "floor").begins(), mt.Condition)
    assert_type(mt.slip("arm", "floor") > 0.1, mt.Condition)
    sim.when((mt.reaction("arm/upper").component("fx") > "40 N").lasting(0.1)).then(mt.lock("arm/upper", [0]))
    sim.when(mt.distance("arm/hand", "ground") < 0.1).then(mt.weld("arm/hand"))
    sim.when(lambda world: float(world.joints["arm/upper"].q[0]) - 2).then(mt.impulse("arm/hand", force=(1, 0, 0)))
    sim.when((mt.measured(lambda world: world.energy.kinetic) > 1e3).repeated()).then(mt.free_joint("arm/upper"))
    sim.after("cut", delay=0.01).then(mt.change_joint("arm/upper", mt.Ball(damping=[0.1, 0.1, 0.1])))
    sim.every(0.5).then(mt.impulse("arm/upper", torque=[0, 0.1, 0]))
    assert_type(sim.apply(mt.lock("arm/upper")), mt.Event)
    assert_type(sim.events[0].impulse, dict[str, mt.Wrench])
    assert_type(sim.events[0].ground_impulse.torque, Array)
    assert_type(sim.events[0].linear_error, float)


def run(sim: mt.Simulation) -> None:
    def stop(world: mt.World) -> bool:
        return world.time < 10

    def watch(world: mt.World) -> None:
        assert_type(world.time, float)

    result = sim.run(0.05, record_every=0.01, reactions=True, observe=stop)
    assert_type(result, mt.Run)
    assert_type(sim.run("60 ms", observe=watch).status, str)
    assert_type(result.time, Array)
    print(result["arm/upper"].q.shape)
    assert_type(result.joints["arm/upper"].q, Array)
    assert_type(result.joints["arm/upper"].reaction, mt.Wrench)
    assert_type(result.bodies["arm/hand"].position, Array)
    assert_type(result.energy, NDArray[np.void])
    assert_type(result.events, list[mt.Event])
    assert_type(sim.last_run, mt.Run | None)
    try:
        sim.run(0.07)
    except mt.RunError as error:
        assert_type(error.run, mt.Run | None)
        assert_type(error.line, int | None)


def batch(model: mt.Model) -> None:
    worlds = mt.Batch(model, 4, precision="float32", variables="velocities")
    worlds.step(1e-3)
    worlds.step(np.full(4, 1e-3))
    worlds.q = np.zeros((4, 2))
    worlds.set_state([True, False, False, True], v=[0.1, 0.2])
    worlds.set_effort([0.1, 0.0], slice(0, 2))
    assert_type(worlds.q, Array)
    assert_type(worlds.effort, Array)
    assert_type(worlds.diverged, NDArray[np.bool_])
    assert_type(worlds.apply(np.array([0, 1]), mt.lock("arm/lower")), list[mt.Event])
    assert_type(worlds.groups, list[mt.Group])
    assert_type(worlds.joints["arm/upper"], mt.JointColumns)
    assert_type(worlds.bodies["arm/hand"].position, Array)


def ring() -> mt.Model:
    model = mt.Model()
    crank = model.add("ring/crank", mass=1, com=(0.5, 0, 0), inertia=0.1, joint=mt.Revolute((0, 1, 0)), q=0.5)
    model.add("ring/rod", mass=1, com=(0.5, 0, 0), inertia=0.1, parent=crank, at=(1, 0, 0), joint=mt.Revolute((0, 1, 0)), q=-1)
    model.add_loop("guide", body="ring/rod", joint=mt.Ball(damping=0.1), child_at=(1, 0, 0), at={"xyz": [1.5, 0, 0]}, assemble=True)
    assert_type(model.loop_names, list[str])
    return model


def loops(sim: mt.Simulation) -> None:
    assert_type(sim.world.loops["guide"], mt.Joint)
    assert_type(sim.world.loop_status, mt.LoopStatus)
    assert_type(sim.world.loop_status.residual, float)
    assert_type(sim.world.joints["guide"].loop, bool)
    assert_type(sim.world.joints["guide"].determined, bool)
    sim.when(mt.reaction("guide", undetermined="least_norm").force > 1e6).then(mt.break_joint("guide"))
    sim.run(0.01)
    assert_type(sim.energy_balance, dict[str, float])


def spring(stiffness: float, joint: str) -> Callable[[mt.Context], float]:
    def effort(context: mt.Context) -> float:
        return -stiffness * float(context.q(joint)[0])

    return effort


def load(text: str) -> mt.Simulation:
    return mt.loads(text, "arm.toml", set={"integrate.step": 1e-4})


if __name__ == "__main__":
    batch(arm(wind=False))
    for use in (read, write, events, run):
        use(mt.Simulation(arm(), method="dopri5", step=1e-3, rtol=1e-9))
    loops(mt.Simulation(ring()))
    driven = load(arm().to_toml())
    driven.drive("arm/upper", spring(2.0, "arm/upper"))
    run(driven)
