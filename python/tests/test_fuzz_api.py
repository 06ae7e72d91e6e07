"""Random calls with hostile arguments never crash the process, and raise only the documented exceptions."""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys

import pytest

FUZZER = pathlib.Path(__file__).with_name("fuzz_api.py")


@pytest.mark.parametrize("seed", range(4))
def test_random_programs(seed: int) -> None:
    environment = {**os.environ, "PYTHONHASHSEED": "0", "PYTHONMALLOC": "debug" if seed == 0 else "default", "MPLBACKEND": "agg"}
    done = subprocess.run([sys.executable, str(FUZZER), str(seed), "600"], capture_output=True, text=True, timeout=300,
    env=environment)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-6000:]
