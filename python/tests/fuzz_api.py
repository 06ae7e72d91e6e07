"""A fuzzer of the Python API: random calls with valid and hostile arguments, in several simulations, batches and threads.

    python fuzz_api.py SEED OPERATIONS

It ends with exit code 0 if nothing but the documented exceptions was raised. Whatever happens, the process must not crash.
"""

from __future__ import annotations

import faulthandler
import gc
import inspect
import os
import pickle
import signal
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from fuzz_operations import Operations

import momentree as mt

EXPECTED = (mt.Error, TypeError, ValueError, LookupError, AttributeError, ZeroDivisionError, OverflowError, MemoryError,
TimeoutError,
            RecursionError, OSError, StopIteration, ImportError, AssertionError, BufferError, NotImplementedError,
            pickle.PicklingError)  # fmt: skip
SLOW = {"report", "_repr_html_", "plot", "to_pandas", "save"}
SKIPPED = {"ctypes", "tofile", "dump", "setflags"}  # of arrays: not ours


class Fuzzer(Operations):
    """One seeded sequence of operations."""

    def anything(self) -> None:
        """A random attribute of a random object, called with random arguments."""
        rng = self.rng
        owner: Any = mt if rng.random() < 0.15 else self.one(rng.choice([kind for kind in self.pools if self.pools[kind]]))
        names = [name for name in dir(owner) if name not in SKIPPED and not (name in SLOW and rng.random() < 0.95)]
        names = [name for name in names if not name.startswith("_") or name in ("__getitem__", "__len__", "__repr__", "__eq__",
        "__hash__")]
        if isinstance(owner, mt.Simulation):
            names = [name for name in names if name != "run"] + ["run_shortly"]
        name = rng.choice(names)
        if name == "run_shortly":
            self.keep("run", owner.run(owner.time + 0.01, record_every=self.values.any()))
            return
        self.note(type(owner).__name__, name)
        if name in ("q", "v", "p", "effort", "gravity") and rng.random() < 0.3:
            setattr(owner, name, self.values.any())
        value = getattr(owner, name)
        if callable(value):
            self.keep("other", value)
            value = value(*self.arguments(value))
        if isinstance(value, np.ndarray):
            self.keep("view", value)
        elif value is not None and type(value).__module__.startswith("momentree"):
            kind = {mt.Model: "model", mt.Simulation: "sim", mt.Batch: "batch", mt.Snapshot: "snapshot", mt.Run: "run",
            mt.Event: "event"}
            self.keep(kind.get(type(value), "handle"), value)

    def arguments(self, function: Callable[..., Any]) -> list[Any]:
        try:
            most = len(inspect.signature(function).parameters)
        except (TypeError, ValueError):
            most = 2
        return [self.values.any() for _ in range(min(most, self.rng.randrange(5)))]

    # Running

    def judge(self, error: BaseException) -> None:
        """Collects what must not be raised."""
        try:
            text = str(error)
        except Exception:  # of an object that was overwritten
            text = ""
        if not isinstance(error, EXPECTED) or "std::" in text or "bad_cast" in text:
            self.problems.append("".join(traceback.format_exception(error)))

    def run(self, operations: int) -> None:
        choices = [self.new_model, self.new_sim, self.new_batch, *[self.act] * 6, *[self.schedule] * 3, *[self.functions] * 2,
        *[self.observe] * 4,
                   *[self.handles] * 3, *[self.write] * 2, *[self.travel] * 5, *[self.bodies] * 2, self.pickled,
                   *[self.reenter] * 3,
                   *[self.batches] * 4, self.thread, *[self.anything] * 40]  # fmt: skip
        for k in range(operations):
            operation = self.rng.choice(choices)
            self.note(k, operation.__name__)
            try:
                signal.setitimer(signal.ITIMER_REAL, 1.0)
                try:
                    operation()
                finally:
                    signal.setitimer(signal.ITIMER_REAL, 0)
            except Exception as error:
                self.judge(error)
            if k % 100 == 0:
                gc.collect()


def main() -> int:
    faulthandler.enable()
    warnings.simplefilter("ignore")

    def too_long(*_: Any) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, too_long)
    seed, operations = int(sys.argv[1]), int(sys.argv[2])
    fuzzer = Fuzzer(seed)
    with tempfile.TemporaryDirectory(prefix="momentree_fuzz_", ignore_cleanup_errors=True) as folder:
        os.chdir(folder)
        fuzzer.run(operations)
        os.chdir("/")
    for problem in fuzzer.problems[:5]:
        print(f"seed {seed}: unexpected\n{problem}", file=sys.stderr)
    return 1 if fuzzer.problems else 0


if __name__ == "__main__":
    sys.exit(main())
