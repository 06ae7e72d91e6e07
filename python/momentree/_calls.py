"""Calls of the extension with arguments of wrong types are errors in the words of this package."""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral, Real
from types import ModuleType
from typing import Any

from momentree._errors import Error

_EXPECTED: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "str": ("a text", lambda x: isinstance(x, str)),
    "int": ("an integer", lambda x: isinstance(x, Integral) and not isinstance(x, bool)),
    "float": ("a number", lambda x: isinstance(x, Real) and not isinstance(x, bool)),
    "bool": ("True or False", lambda x: isinstance(x, bool)),
    "object": ("a value", lambda x: x is not None),
    "Sequence": ("a list", lambda x: isinstance(x, Sequence) and not isinstance(x, str)),
}


def explain_calls(extension: ModuleType) -> None:
    """Wraps the methods of its classes."""
    for cls in vars(extension).values():
        for name, method in list(vars(cls).items()) if isinstance(cls, type) else ():
            if type(method).__name__ == "nb_method" and (name == "__init__" or not name.endswith("__")):
                setattr(cls, name, _explained(method))


def _explained(method: Any) -> Callable[..., Any]:
    @functools.wraps(method)
    def call(*args: Any, **named: Any) -> Any:
        try:
            return method(*args, **named)
        except TypeError as error:
            if "incompatible function arguments" not in str(error):
                raise
            raise _mistake(method, args[1:], named) from None

    return call


def _mistake(method: Any, args: Sequence[Any], named: Mapping[str, Any]) -> Exception:
    name = method.__name__.lstrip("_")
    known: list[ast.arg] = []
    for text, *_ in method.__nb_signature__:
        parsed: Any = ast.parse(re.sub(r"\\\d+", "None", text) + ": ...").body[0]
        given, found = parsed.args, dict(named)
        positional = (given.posonlyargs + given.args)[1:]
        required = len(positional) - len(given.defaults)
        if len(args) <= len(positional):
            found |= {each.arg: value for each, value in zip(positional, args)}
        known = positional + given.kwonlyargs
        if len(args) > len(positional) or not {each.arg for each in positional[:required]} <= {*found} <= {each.arg for each in known}:
            continue
        for each in known:
            kinds = ast.unparse(each.annotation or ast.Name("object")).split(" | ")
            expected, fits = _EXPECTED.get(re.sub(r"\[.*|^collections\.abc\.", "", kinds[0]), ("", lambda x: True))
            if each.arg not in found or ("None" in kinds and found[each.arg] is None) or fits(found[each.arg]):
                continue
            what = name if each.arg.startswith("arg") else each.arg
            return Error(f"{what}: expected {expected}, found {found[each.arg]!r:.40}")
    shown = ", ".join([f"{each!r:.20}" for each in args] + [f"{key}={value!r:.20}" for key, value in named.items()])
    return TypeError(f"{name}({', '.join(each.arg for each in known)}) can't be called with ({shown})")
