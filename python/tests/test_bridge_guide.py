"""Runs the examples of docs/python-bridges.md."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

GUIDE = Path(__file__).parents[2] / "docs" / "python-bridges.md"
EXAMPLES = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(encoding="utf-8") if GUIDE.exists() else "", re.M | re.S)


@pytest.mark.parametrize("number", range(4))
def test_example(number: int, tmp_path: Path) -> None:
    if not GUIDE.exists():
        pytest.skip("the documentation is not here")
    assert len(EXAMPLES) == 4
    pytest.importorskip("pydrake" if "pydrake" in EXAMPLES[number] else "mujoco")
    file = tmp_path / "example.py"
    file.write_text(EXAMPLES[number], encoding="utf-8")
    done = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "NOT OK" not in done.stdout
