"""Extra efforts that are written between steps."""

import momentree as mt
import numpy as np


def flywheel() -> mt.Model:
    model = mt.Model(gravity=(0, 0, 0))
    model.add("wheel", mass=1, inertia=1, joint=mt.Revolute())
    return model


def test_an_effort_acts_from_the_next_step_on() -> None:
    sim = mt.Simulation(flywheel(), step=0.01)
    for effort, steps in ((1.0, 10), (-2.0, 10), (0.0, 5)):
        sim.effort[0] = effort
        for _ in range(steps):
            sim.step()
    assert abs(sim.v[0] - (0.1 - 0.2)) < 1e-14


def test_a_batch_agrees() -> None:
    sim, batch = mt.Simulation(flywheel(), step=0.01), mt.Batch(flywheel(), 3)
    for k in range(20):
        effort = np.sin(k)
        sim.effort = [effort]
        batch.effort = np.full((3, 1), effort)
        sim.step()
        batch.step(0.01)
    assert np.abs(batch.q[:, 0] - sim.q[0]).max() < 1e-14


def test_efforts_do_work() -> None:
    sim = mt.Simulation(flywheel(), step=0.01)
    sim.effort[:] = 1.0
    sim.run(1.0)
    balance = sim.energy_balance
    assert abs(balance["work"] - 0.5) < 1e-12
    assert abs(balance["error"]) < 1e-12
