"""Arguments of wrong types, and results that can't be assigned: errors in the words of the package."""

from __future__ import annotations

import inspect
from typing import Any

import pytest

import momentree as mt
from momentree import _core


def model() -> mt.Model:
    model = mt.Model()
    model.add("a/a", mass=1, inertia=0.1, joint=mt.Revolute(), collision={"sphere": 0.1})
    return model


class Other:
    def __repr__(self) -> str:
        return "<other>"


def test_no_call_with_wrong_arguments_has_a_message_of_the_binding_library() -> None:
    sim = mt.Simulation(model())
    batch = mt.Batch(model(), 2)
    run = sim.run(0.01)
    count = 0
    for thing in (sim, sim.model, batch, run, sim.world, sim.world.joints["a/a"], sim.world.bodies["a/a"]):
        for name in dir(type(thing)):
            method = inspect.getattr_static(type(thing), name)
            if name.startswith("_") or isinstance(method, property) or not callable(getattr(type(thing), name)):
                continue
            if name in ("show", "serve", "report", "save", "export", "to_parquet", "plot", "animate", "step", "run"):
                continue
            for arguments in ((Other(),), (1j,), (None, None, None, None), ([], Other()), ("x",) * 9):
                try:
                    getattr(thing, name)(*arguments)
                except Exception as error:  # noqa: BLE001
                    assert "incompatible function" not in str(error) and "arg0" not in str(error), (name, error)
                    count += 1
    assert count > 200


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        (lambda sim: sim.at(None), "at: expected a value, found None"),
        (lambda sim: sim.undo("last"), "number: expected an integer, found 'last'"),
        (lambda sim: sim.after(5), "after: expected a text, found 5"),
        (lambda sim: sim.model.add(5, mass=1), "name: expected a text, found 5"),
        (lambda sim: sim.model.add_spring(5, start="a/a", end="ground"), "add_element: expected a text, found 5"),
        (lambda sim: sim.model.add_force(Other()), "add_force: expected a text, found <other>"),
        (lambda sim: mt.Batch(sim.model, 2).run(0.1, 1.5), "steps: expected an integer, found 1.5"),
        (lambda sim: mt.Batch(sim.model, 2).contacts("first"), "world: expected an integer, found 'first'"),
    ],
)
def test_arguments_of_wrong_types_are_named(call: Any, problem: str) -> None:
    with pytest.raises(mt.Error) as caught:
        call(mt.Simulation(model()))
    assert str(caught.value).startswith(problem)


def test_wrong_numbers_of_arguments() -> None:
    with pytest.raises(TypeError, match=r"step\(dt\) can't be called with \(1, 2\)"):
        mt.Simulation(model()).step(1, 2)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"message\(world\) can't be called with \(number=1\)"):
        mt.Batch(model(), 2).message(number=1)  # type: ignore[call-arg]


def test_type_errors_of_functions_are_their_own() -> None:
    sim = mt.Simulation(model())
    sim.force("a/a", lambda context: 1 + None)  # type: ignore[operator, return-value]
    with pytest.raises(TypeError, match="unsupported operand"):
        sim.run(0.01)


def test_results_are_not_assigned() -> None:
    run = mt.Simulation(model()).run(0.01, reactions=True)
    results = mt.sweep(lambda seed: 1.0, 3)
    for thing, name in ((run, "time"), (run, "events"), (run, "contacts"), (run.joints["a/a"], "q"), (results, "status")):
        with pytest.raises(AttributeError, match=f"{name}' can't be assigned: it is a result"):
            setattr(thing, name, 0)


def test_the_extension_is_wrapped_once() -> None:
    assert inspect.isfunction(vars(_core.SimulationBase)["step"])
    assert "Length" in (mt.Simulation.step.__doc__ or "")
