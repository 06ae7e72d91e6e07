"""Couplings of joints, exact and by springs."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import momentree as mt


def gears() -> mt.Model:
    model = mt.Model()
    model.add("gear/motor", mass=1, inertia=0.01, joint=mt.Revolute(axis=(0, 0, 1), effort=0.5))
    model.add("gear/load", mass=1, inertia=2.0, joint=mt.Revolute(axis=(0, 0, 1)))
    model.add_coupling("gear/load", "gear/motor", multiplier=-0.1, offset=0.3)
    return model


def test_a_gear_pair_turns_as_one_inertia() -> None:
    for model in (gears(), copy.copy(gears()), pickle.loads(pickle.dumps(gears())), mt.loads(gears().to_toml()).model):
        sim = mt.Simulation(model, method="rk4", step=0.01)
        acceleration = 0.5 / (0.01 + 0.01 * 2)
        (pair,) = sim.world.couplings
        assert (pair.joint, pair.follows, pair.ended, pair.determined) == ("gear/load", "gear/motor", False, True)
        assert pair.effort == pytest.approx(-0.1 * 2 * acceleration, rel=1e-12)
        sim.run(1)
        assert sim.world.joints["gear/motor"].q[0] == pytest.approx(acceleration / 2, rel=1e-12)
        assert sim.world.joints["gear/load"].q[0] == pytest.approx(0.3 - 0.05 * acceleration, rel=1e-12)


def test_a_coupling_ends_with_its_joint() -> None:
    sim = mt.Simulation(gears())
    sim.apply(mt.break_joint("gear/load"))
    (pair,) = sim.world.couplings
    assert pair.ended and pair.effort == 0
    assert np.isclose(sim.accelerations()[0], 50)


def test_start_values_that_it_does_not_allow_are_a_warning() -> None:
    assert mt.Simulation(gears()).warnings == []
    model = mt.Model()
    model.add("gear/motor", mass=1, inertia=0.01, joint=mt.Revolute(axis=(0, 0, 1)), q=1)
    model.add("gear/load", mass=1, inertia=2.0, joint=mt.Revolute(axis=(0, 0, 1)), q=0.3)
    model.add_coupling("gear/load", "gear/motor", multiplier=-0.1, offset=0.3)
    (warning,) = mt.Simulation(model).warnings
    assert "'gear/load' starts at 0.2 rad, not at 0.3 rad" in warning
    sim = mt.Simulation(gears())
    sim.restore_state('{"joints": {"gear/motor": {"q": [1]}, "gear/load": {"q": [0.3]}}}')
    (warning,) = sim.warnings
    assert "'gear/load' starts at 0.2 rad, not at 0.3 rad" in warning


def test_mistakes() -> None:
    model = gears()
    with pytest.raises(mt.Error, match="did you mean"):
        model.add_coupling("gear/lod", "gear/motor")
    with pytest.raises(mt.Error, match="follow itself"):
        model.add_coupling("gear/load", "gear/load")
    with pytest.raises(mt.Error, match="either these"):
        model.add_coupling("gear/load", "gear/motor", multiplier=1, polynomial=[0, 1])
    for method, variables in {"dop853": "momenta", "damped": None}.items():
        sim = mt.Simulation(gears(), method=method, variables=variables)
        sim.run(0.1)
        assert sim.world.loop_status.residual < 1e-12


def test_a_joint_follows_by_a_spring() -> None:
    model = mt.Model()
    for name in ("a", "b"):
        model.add(f"gear/{name}", mass=1, inertia=0.1, joint=mt.Revolute(axis=(0, 0, 1)))
    model.add_coupling("gear/b", "gear/a", offset="0.3 rad", stiffness=40, damping="0.5 N m s")
    with pytest.raises(mt.Error, match="there is no joint 'gear/c'"):
        model.add_coupling("gear/c", "gear/a", stiffness=1)
    for each in (model, copy.copy(model), pickle.loads(pickle.dumps(model)), mt.loads(model.to_toml()).model):
        sim = mt.Simulation(each, method="rk4", step=1e-3)
        assert sim.accelerations() == pytest.approx([-120, 120], rel=1e-12)
        sim.run(5)
        assert sim.q == pytest.approx([-0.15, 0.15], abs=1e-6)
