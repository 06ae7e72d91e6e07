"""Assignments to attributes that a class does not have."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Any

_INSTEAD = {
    "Joint": "assign the simulation's q, v or effort; parameters are the model's",
    "Body": "the state of bodies follows from the joints: assign the simulation's q or v; parameters are the model's",
}


def assign(self: object, name: str, value: Any) -> None:
    """The ``__setattr__`` of a class whose public attributes are those that it declares. Subclasses may have others of their own.

    Raises:
        AttributeError: There is no such attribute, or it can't be assigned; with the one that was meant.
    """
    cls = type(self)
    declared = getattr(cls, name, None)
    known = hasattr(cls, name)
    settable = known and not callable(declared) and getattr(declared, "fset", True) is not None
    if settable or name.startswith("_") or not (known or cls.__module__.startswith("momentree.")):
        return object.__setattr__(self, name, value)
    others = [each for each in dir(cls) if each != name and not each.startswith("_")]
    meant = [each for each in others if each.startswith("set_") or getattr(getattr(cls, each), "fset", None) is not None]
    problem = f"'{cls.__name__}.{name}' can't be assigned" if known else f"'{cls.__name__}' has no attribute '{name}'"
    nearest = get_close_matches(name, meant if known else meant + others, 1)
    hint = f"did you mean '{nearest[0]}'?" if nearest else _INSTEAD.get(cls.__name__, "") if known else ""
    raise AttributeError(problem + (f"; {hint}" if hint else ""))


def assign_once(self: object, name: str, value: Any) -> None:
    """The ``__setattr__`` of a class whose public attributes are set when an object is made.

    Raises:
        AttributeError: The attribute has a value.
    """
    if not name.startswith("_") and (name in vars(self) or hasattr(type(self), name)):
        raise AttributeError(f"'{type(self).__name__}.{name}' can't be assigned: it is a result")
    object.__setattr__(self, name, value)
