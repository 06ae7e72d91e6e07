"""Checks and texts of arguments."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, cast

from momentree._errors import Error


def called(function: Any, what: str) -> Any:
    """The function, if it is one."""
    if not callable(function):
        raise Error(f"{what}: expected a function, found {type(function).__name__}")
    return function


def number(value: Any, what: str) -> float:
    """A number as float."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise Error(f"{what}: expected a number, found {value!r:.40}") from None


def overrides(set: Mapping[str, Any] | None) -> list[str]:
    """Changes of a scenario as the command has them: ``key=value``."""
    if set is not None and not isinstance(set, Mapping):
        raise Error(f"set: expected a dictionary, found {type(set).__name__}", hint='{"integrate.step": 1e-4}')
    texts: list[str] = []
    for key, value in (set or {}).items():
        if isinstance(value, str):
            texts.append(f"{key}={value}")
        else:
            texts.append(f"{key}={toml(value)}")
    return texts


def toml(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {toml(each)}" for key, each in cast("Mapping[str, Any]", value).items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(each) for each in cast("Sequence[Any]", value)) + "]"
    return repr(value)


def anywhere(source: tuple[Any, ...]) -> tuple[Any, ...]:
    """The same source for a process with another working folder."""
    if source[0] != "file" or source[4] is not None:
        return source
    kind, path, overrides_, state, text = source
    return kind, os.path.abspath(path), overrides_, os.path.abspath(state) if state else "", text
