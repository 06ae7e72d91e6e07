"""Springs between points of bodies."""

from __future__ import annotations

import copy
import math
import pickle
from typing import Any

import momentree as mt
import numpy as np
import pytest


def hung(**keys: Any) -> mt.Model:
    """A mass on a spring below the ceiling, 1 m below it at the start."""
    model = mt.Model()
    load = model.add("m/load", mass=2, inertia=1, joint=mt.Prismatic(axis=(0, 0, 1)), q=-1)
    model.add_spring("rope", start="ground", end=(load, (0, 0, 0)), **{"stiffness": "50 N/m", **keys})
    return model


def test_a_mass_on_a_spring_swings_as_the_closed_form_says() -> None:
    sim = mt.Simulation(hung(), method="dop853", rtol=1e-12, atol=1e-13)
    run = sim.run(2.0, record_every=0.01)
    w, sag = math.sqrt(25), 2 * 9.81 / 50
    rope = run.springs["rope"]
    length = 1 + sag * (1 - np.cos(w * run.time))
    assert np.allclose(rope.length, length, atol=1e-9)
    assert np.allclose(rope.rate, sag * w * np.sin(w * run.time), atol=1e-8)
    assert np.allclose(rope.tension, 50 * (length - 1), atol=1e-8)
    spring = sim.world.springs["rope"]
    assert (spring.name, spring.stiffness, spring.rest, spring.damping) == ("rope", 50, 1, 0)
    assert (spring.tension_only, spring.strength, spring.broken) == (False, math.inf, False)
    assert spring.length == rope.length[-1] and spring.tension == rope.tension[-1]
    assert spring.start[0] == "ground" and spring.end[0] == "m/load"
    assert "rope" in repr(spring) and spring == sim.world.springs["rope"]
    assert np.array_equal(run.to_pandas("rope.tension")["rope.tension"], rope.tension)


def test_springs_break_by_events_conditions_and_their_strength() -> None:
    by_event = mt.Simulation(hung(), method="dopri5")
    by_event.at(0.3).then(mt.break_joint("rope"))
    run = by_event.run(0.5, record_every=0.1)
    assert by_event.world.springs["rope"].broken and by_event.world.springs["rope"].tension == 0
    assert np.isnan(run.springs["rope"].tension[-1]) and not np.isnan(run.springs["rope"].tension[0])
    event = run.events[0]
    assert event.released > 0 and event.linear_error == 0 and event.actions[0].spring == "rope" and event.actions[0].joint == ""
    by_strength = mt.Simulation(hung(strength="30 N"), method="dopri5")
    by_strength.run(1.0)
    # 50·sag·(1 − cos w t) = 30
    time = math.acos(1 - 30 / (2 * 9.81)) / 5
    assert by_strength.events[0].name == "strength of rope" and math.isclose(by_strength.events[0].time, time, abs_tol=1e-6)
    by_condition = mt.Simulation(hung(), method="dopri5")
    by_condition.when(mt.reaction("rope").force > "30 N").then(mt.set_parameters("rope", stiffness=0, damping=3))
    by_condition.run(1.0)
    assert math.isclose(by_condition.events[0].time, time, abs_tol=1e-6)
    assert by_condition.world.springs["rope"].stiffness == 0
    assert isinstance(by_condition.world.springs, mt._world.Springs) and list(by_condition.world.springs) == ["rope"]


def test_a_load_on_a_cable_is_caught_and_cut() -> None:
    model = mt.Model()
    model.add("m/load", mass=2, inertia=0.1, joint=mt.Free(), q=[0, 0, -0.5, 1, 0, 0, 0])
    model.add_cable("tether", start="ground", end="m/load", length=1.5, strength="1 kN")
    sim = mt.Simulation(model, method="dop853")
    run = sim.run(2.0)
    taut = next(e for e in run.events if e.name == "taut tether")
    assert math.isclose(taut.time, math.sqrt(2 / 9.81), abs_tol=1e-9)
    assert taut.contact is not None and taut.contact.cable == "tether" and taut.contact.other == "ground"
    tether = sim.world.springs["tether"]
    assert tether.inextensible and math.isclose(tether.tension, 2 * 9.81, rel_tol=1e-9) and tether.rest == 1.5
    assert np.isclose(run.springs["tether"].tension[-1], 2 * 9.81)
    for other in (model.copy(), pickle.loads(pickle.dumps(model)), mt.loads(model.to_toml()).model):
        assert mt.Simulation(other).world.springs["tether"].inextensible
    sim.apply(mt.break_joint("tether"))
    sim.run(3.0)
    assert tether.broken and sim.world.bodies["m/load"].position[2] < -5
    with pytest.raises(mt.Error, match="restitution"):
        model.add_cable("other", start="ground", end="m/load", restitution=3)


def test_models_with_springs_are_copied_written_and_pickled() -> None:
    model = hung(rest=0.5, tension_only=True, strength=100)
    assert model.spring_names == ["rope"]
    for other in (model.copy(), copy.deepcopy(model), pickle.loads(pickle.dumps(model)), mt.loads(model.to_toml()).model):
        spring = mt.Simulation(other).world.springs["rope"]
        assert (spring.rest, spring.tension_only, spring.strength) == (0.5, True, 100)
    run = pickle.loads(pickle.dumps(mt.Simulation(model).run(0.01)))
    assert run.springs["rope"].length.shape == run.time.shape


def test_states_and_snapshots_remember_broken_springs() -> None:
    sim = mt.Simulation(hung())
    whole = sim.snapshot()
    sim.apply(mt.break_joint("rope"))
    text = sim.state_json()
    sim.restore(whole)
    assert not sim.world.springs["rope"].broken
    sim.restore_state(text)
    assert sim.world.springs["rope"].broken


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"stiffness": -1}, ("stiffness", "negative")),
        ({"rest": "1 N"}, ("rest", "length")),
        ({"strength": 0}, ("strength",)),
        ({"tension_only": "yes"}, ("tension_only",)),
        ({"start": "m/lode"}, ("no body 'm/lode'", "did you mean 'm/load'")),
        ({"start": ("m/load", (0, 0, 1))}, ("same body",)),
        ({"start": ("ground", (0, 0))}, ("point",)),
        ({"stiffness": None}, ("stiffness",)),
        ({"start": 3}, ()),
        ({"start": ("ground", (0, 0, 0), 1)}, ()),
    ],
)
def test_mistakes_leave_the_model_unchanged(keys: dict[str, Any], words: tuple[str, ...]) -> None:
    model = hung()
    fields: dict[str, Any] = {"start": "ground", "end": "m/load", "stiffness": 1, **keys}
    with pytest.raises(mt.Error) as error:
        model.add_spring("s", **fields)
    assert all(word in str(error.value) for word in words), str(error.value)
    assert model.spring_names == ["rope"]


def test_names_of_springs() -> None:
    model = hung()
    for name in ("rope", "m/load", "", "a*b"):
        with pytest.raises(mt.Error):
            model.add_spring(name, start="ground", end="m/load", stiffness=1)
    sim = mt.Simulation(model)
    for act in (lambda: sim.world.springs["rop"], lambda: sim.apply(mt.break_joint("rop"))):
        with pytest.raises(mt.Error, match="did you mean 'rope'"):
            act()
    with pytest.raises(mt.Error, match="'rope' is a spring, not a joint"):
        sim.apply(mt.lock("rope"))
    assert mt.Batch(model, 2).lanes == 1  # worlds with springs are stepped one by one
