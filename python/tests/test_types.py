"""The types that users see: what type checkers find in typing/right.py, and what they reject in typing/wrong.py."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
import typing
from pathlib import Path
from types import SimpleNamespace

import momentree
import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
RIGHT, WRONG = HERE / "typing" / "right.py", HERE / "typing" / "wrong.py"
MINE = ["test_types.py", "test_stubs.py", "test_docstrings.py", "test_docs.py"]


def python(*arguments: object, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=500, check=False)


def checked(tmp_path: Path, *files: object) -> None:
    """Strict, with the settings of the project; an unused `type: ignore` is an error, too."""
    pytest.importorskip("mypy")
    if sys.version_info < (3, 11):
        pytest.skip("typing.assert_type is in Python 3.11 and later")
    done = python("-m", "mypy", "--config-file", ROOT / "pyproject.toml", "--cache-dir", tmp_path / "mypy", *files)
    assert done.returncode == 0, done.stdout


def test_mypy_finds_these_types_and_rejects_wrong_uses(tmp_path: Path) -> None:
    assert WRONG.read_text().count("# type: ignore") > 40
    checked(tmp_path, RIGHT, WRONG)


def test_mypy_accepts_tests(tmp_path: Path) -> None:
    checked(tmp_path, *(HERE / name for name in MINE))


def test_what_types_accept_runs(tmp_path: Path) -> None:
    done = python(RIGHT, cwd=tmp_path)
    assert done.returncode == 0, done.stderr


def test_pyright_finds_these_types_and_rejects_wrong_uses() -> None:
    if importlib.util.find_spec("pyright") is None or python("-m", "pyright", "--version").returncode != 0:
        pytest.skip("pyright does not start")
    done = python("-m", "pyright", "--pythonpath", sys.executable, "--outputjson", RIGHT, WRONG, *(HERE / name for name in MINE))
    found = [d for d in json.loads(done.stdout)["generalDiagnostics"] if d["severity"] == "error"]
    places = {(Path(d["file"]).name, d["range"]["start"]["line"] + 1): d["message"] for d in found}
    assert {place: message for place, message in places.items() if place[0] != WRONG.name} == {}
    marked = {(WRONG.name, number) for number, line in enumerate(WRONG.read_text().splitlines(), 1) if "# type: ignore" in line}
    assert {place for place in places if place[0] == WRONG.name} == marked


@pytest.mark.parametrize("name", sorted(momentree.__all__))
def test_annotations_can_be_evaluated(name: str) -> None:
    """Tools that read annotations, like documentation generators, find all names that they contain."""
    thing = getattr(momentree, name)
    if isinstance(thing, type) and thing.__module__ == "momentree._core" or isinstance(thing, str):
        return  # an extension has stubs instead
    optional: dict[str, typing.Any] = {"pd": SimpleNamespace(DataFrame=object), "Any": typing.Any, "StateView": momentree.StateView}
    optional |= {"Run": momentree.Run, "Simulation": momentree.Simulation} | dict.fromkeys(("Axes", "_StateArrays"), typing.Any)
    parts: list[typing.Any] = [thing, *(vars(thing).values() if isinstance(thing, type) else [])]
    for part in parts:
        function = part.fget if isinstance(part, property) else part
        if callable(function) and re.match("momentree", getattr(function, "__module__", None) or ""):
            typing.get_type_hints(function, localns=optional)
