"""Every public name has a docstring; those of arrays say their shape, and those of numbers their unit."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import momentree
import pytest

STUBS = ast.parse((Path(momentree.__file__).parent / "_core.pyi").read_text(encoding="utf-8"))
UNIT = re.compile(r"\b(m|s|ns|N|J|kg|rad|1/s|unit)\b|m/s²|kg m²|N m|\(w, x, y, z\)|quaternion|topolog|number", re.I)
SHAPE = re.compile(r"\bshapes?\b", re.I)
PLAIN = re.compile(r"bool_|intp|void")  # arrays without units
ARRAYS = {"Array", "StateView", "NDArray", "Wrench", "Rates"}


def attributes(cls: type) -> dict[str, tuple[str, str]]:
    """Attributes that are assigned in a class or its constructor: annotation and the string below it."""
    if cls.__module__ == "momentree._core":
        return {}
    found: dict[str, tuple[str, str]] = {}
    bodies: list[list[ast.stmt]] = []
    definition = ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0]
    assert isinstance(definition, ast.ClassDef)
    bodies.append(definition.body)
    bodies += [each.body for each in definition.body if isinstance(each, ast.FunctionDef) and each.name == "__init__"]
    for body in bodies:
        for statement, following in zip(body, [*body[1:], ast.Pass()], strict=True):
            if not isinstance(statement, ast.AnnAssign):
                continue
            target = statement.target
            name = target.attr if isinstance(target, ast.Attribute) else target.id if isinstance(target, ast.Name) else ""
            text = ""
            if isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant):
                text = str(following.value.value)
            found[name] = ast.unparse(statement.annotation), text
    return {name: value for name, value in found.items() if not name.startswith("_")}


def stub_of(cls: type, name: str) -> str:
    for definition in STUBS.body:
        if isinstance(definition, ast.ClassDef) and definition.name == cls.__name__:
            for each in definition.body:
                if isinstance(each, ast.FunctionDef) and each.name == name and each.returns is not None:
                    return ast.unparse(each.returns)
    return ""


def members(cls: type) -> Iterator[tuple[str, str, str]]:
    """Name, annotation of the value, docstring: of each public member, those of a base in the extension included."""
    for base in [each for each in cls.__mro__ if each.__module__.startswith("momentree")]:
        documented = attributes(base)
        for name, (annotation, text) in documented.items():
            yield name, annotation, text
        for name, member in vars(base).items():
            if name.startswith("_") or name in documented:
                continue
            if base.__module__ == "momentree._core":
                annotation = stub_of(base, name)
                text = member.__doc__ or ""
                if not isinstance(member, property) and "getset" not in type(member).__name__:
                    text = text.partition("\n")[2]  # after the signature
            else:
                function = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
                if not callable(function):
                    continue
                annotation, text = str(function.__annotations__.get("return", "")), function.__doc__ or ""
            yield name, annotation, text


CLASSES = [name for name in sorted(momentree.__all__) if isinstance(getattr(momentree, name), type)]


@pytest.mark.parametrize("name", sorted(momentree.__all__))
def test_it_has_a_docstring(name: str) -> None:
    thing = getattr(momentree, name)
    if name != "__version__":
        assert len((thing.__doc__ or "").strip()) > 15
        assert "(self" not in thing.__doc__.splitlines()[0]


@pytest.mark.parametrize("name", CLASSES)
def test_members_have_docstrings(name: str) -> None:
    missing = [member for member, _, text in members(getattr(momentree, name)) if len(text.strip()) < 5]
    assert missing == []


@pytest.mark.parametrize("name", CLASSES)
def test_arrays_have_shapes_and_units(name: str) -> None:
    wrong: list[tuple[str, str]] = []
    for member, annotation, text in members(getattr(momentree, name)):
        if set(re.findall(r"\w+", annotation)) & ARRAYS and "dict" not in annotation:
            wrong += [(member, "shape")] if not SHAPE.search(text) else []
            wrong += [(member, "unit")] if not UNIT.search(text) and not PLAIN.search(annotation) else []
        elif annotation == "float":
            wrong += [(member, "unit")] if not UNIT.search(text) else []
    assert wrong == []


def parameters(thing: Any) -> list[str]:
    return [name for name in inspect.signature(thing).parameters if name != "self" and not name.startswith("_")]


@pytest.mark.parametrize("name", [n for n in sorted(momentree.__all__) if inspect.isfunction(getattr(momentree, n))])
def test_functions_describe_their_arguments(name: str) -> None:
    function = getattr(momentree, name)
    arguments = (function.__doc__ or "").partition("Returns:")[0].partition("Raises:")[0]
    described = re.findall(r"^ {8}(\w+):", arguments, re.M)
    assert sorted(described) == sorted(parameters(function))
