"""_core.pyi, which is kept by hand, has the names and signatures of the extension."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import momentree
import pytest
from momentree import _core

STUBS = Path(momentree.__file__).parent / "_core.pyi"
Signature = tuple[Any, ...]


def signature(function: ast.FunctionDef) -> Signature:
    """Names and defaults; arguments that can only be given by position have no name."""
    a = function.args
    positional = ["" for _ in a.posonlyargs] + [each.arg for each in a.args if each.arg != "self"]
    positional = positional[1:] if a.posonlyargs and a.posonlyargs[0].arg == "self" else positional
    defaults = [ast.literal_eval(each) for each in a.defaults]
    keywords = [(each.arg, default is not None) for each, default in zip(a.kwonlyargs, a.kw_defaults, strict=True)]
    return tuple(positional), tuple(defaults), tuple(keywords)


def decorators(function: ast.FunctionDef) -> list[str]:
    return [ast.unparse(each) for each in function.decorator_list]


def contents(body: list[ast.stmt], inside: str = "") -> dict[str, list[Signature]]:
    """By name: signatures of the overloads; of a property, whether it has a getter and a setter."""
    found: dict[str, list[Signature]] = {}
    for each in body:
        if isinstance(each, ast.ClassDef):
            found[each.name] = []
            found |= contents(each.body, each.name + ".")
        elif isinstance(each, ast.FunctionDef):
            special = [text for text in decorators(each) if text == "property" or text.endswith(".setter")]
            value: Signature = ("get" if special[0] == "property" else "set",) if special else signature(each)
            found.setdefault(inside + each.name, []).append(value)
    return found


def without_implied(found: dict[str, list[Signature]]) -> dict[str, list[Signature]]:
    """Stubs leave out what every class has."""
    return {name: value for name, value in found.items() if not name.endswith((".__repr__", ".__eq__", ".__hash__"))}


def test_names_and_signatures(monkeypatch: pytest.MonkeyPatch) -> None:
    generator = pytest.importorskip("nanobind.stubgen").StubGen(_core, include_private=True)
    for each in vars(_core).values():
        for name, method in list(vars(each).items()) if isinstance(each, type) else ():
            if hasattr(method, "__wrapped__"):
                monkeypatch.setattr(each, name, method.__wrapped__)
    generator.put(_core)
    extension = without_implied(contents(ast.parse(generator.get()).body))
    stubs = without_implied(contents(ast.parse(STUBS.read_text(encoding="utf-8")).body))
    assert len(extension) > 150
    assert sorted(extension) == sorted(stubs)
    for name, value in extension.items():
        assert stubs[name] == value, name
