"""joints.py and events.py are what the library's own lists make of them."""

import subprocess
import sys
from pathlib import Path

from momentree import _core

ROOT = Path(__file__).resolve().parents[2]


def test_the_functions_are_those_of_the_library() -> None:
    command = [sys.executable, str(ROOT / "tools/python_vocabulary"), "--check"]
    folder = str(Path(str(_core.__file__)).parents[1])
    done = subprocess.run(command, capture_output=True, text=True, env={"PYTHONPATH": folder, "PYTHONDONTWRITEBYTECODE": "1"})
    assert done.returncode == 0, done.stderr
