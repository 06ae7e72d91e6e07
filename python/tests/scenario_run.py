"""Runs scenarios of ``scenarios/`` as a user does, and reads their results from the files."""

from __future__ import annotations

import json
import pathlib
import subprocess
import sys
import tempfile
from typing import Any

import numpy as np
import numpy.typing as npt

ROOT = pathlib.Path(__file__).resolve().parents[2]
Array = npt.NDArray[np.float64]


class Run:
    """The results of a scenario: events, summary, model, final state, and tables by column."""

    def __init__(self, scenario: str, *options: str, **values: object) -> None:
        """``values``: what ``--set`` replaces, with ``__`` for a dot; ``options``: of the command."""
        with tempfile.TemporaryDirectory() as out:
            command = [sys.executable, "-m", "momentree", "run", f"scenarios/{scenario}.toml", "--quiet", "--out", out, *options]
            for key, value in values.items():
                command += ["--set", f"{key.replace('__', '.').replace('_', ' ')}={value}"]
            done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)
            assert done.returncode == 0, done.stderr
            folder = pathlib.Path(out)
            self.summary: dict[str, Any] = json.loads((folder / "summary.json").read_text())
            self.model: dict[str, Any] = json.loads((folder / "model.json").read_text())
            self.final: dict[str, Any] = json.loads((folder / "final.json").read_text())
            self.events: list[dict[str, Any]] = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]
            self.columns: dict[str, Array] = {}
            for name in ("energy", "bodies", "joints", "springs"):
                path = folder / f"{name}.csv"
                if path.exists():
                    head = path.read_text().split("\n", 1)[0].split(",")
                    table = np.atleast_2d(np.genfromtxt(path, delimiter=",", skip_header=1))
                    self.columns |= {column: table[:, k] for k, column in enumerate(head)}
        assert self.summary["status"] == "done"

    def __getitem__(self, column: str) -> Array:
        return self.columns[column]

    @property
    def time(self) -> Array:
        return self.columns["time"]

    @property
    def energy(self) -> dict[str, float]:
        return self.summary["energy"]  # type: ignore[no-any-return]

    def row(self, time: float) -> int:
        """The last row that is not after a time."""
        return int(np.searchsorted(self.time, time + 1e-9)) - 1

    def event(self, name: str) -> dict[str, Any]:
        return next(event for event in self.events if event["event"] == name)

    def names(self) -> list[str]:
        return [event["event"] for event in self.events]

    def mass(self, *bodies: str) -> float:
        return sum(self.model["bodies"][body]["mass"] for body in bodies)

    def point(self, body: str, point: Any = (0, 0, 0)) -> Array:
        """A point of a body in the world, at all rows: (rows, 3)."""
        w, x, y, z = (self[f"{body}.q{c}"] for c in "wxyz")
        rotation = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        place = np.stack([self[f"{body}.{c}"] for c in "xyz"], axis=1)
        return place + np.einsum("ijk,j->ki", rotation, np.asarray(point, float))

    def centre(self, *bodies: str) -> Array:
        """The centre of mass of bodies at all rows."""
        moments = [self.mass(body) * self.point(body, self.model["bodies"][body]["com"]) for body in bodies]
        return np.asarray(sum(moments) / self.mass(*bodies))

    def force(self, joint: str) -> Array:
        """The reaction force of a joint in the child's axes, of a run with ``--reactions``: (rows, 3)."""
        return np.stack([self[f"{joint}.f{c}"] for c in "xyz"], axis=1)

    def torque(self, joint: str) -> Array:
        return np.stack([self[f"{joint}.m{c}"] for c in "xyz"], axis=1)
