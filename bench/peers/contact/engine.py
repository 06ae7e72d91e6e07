"""What a program for one engine does: it builds a scene, runs it once to be timed, and once to write the motion.

    on_ENGINE.py SCENE.json STEP VARIANT UNTIL ROUNDS MOTION.npz    (no motion: "-"; 0 rounds: its start and end)

It prints one line of JSON to file descriptor 3; engines write messages to the standard output.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import scenes
from scenes import Array, Scene

Row = tuple[Array, Array, Array, Array]
"""Rotations (n, 3, 3), positions, velocities of the centres of mass and angular velocities (n, 3) of all bodies."""


class Engine(Protocol):
    """A scene at its start. `advance` takes steps up to about an instant; `release` lets go of what holds the first body.

    An engine whose steps depend on where a call ends has `watch(until, look)`, too, which calls `look` after each step."""

    time: float

    def advance(self, until: float) -> None: ...
    def release(self) -> None: ...
    def state(self) -> Row: ...
    def note(self) -> str: ...


def links(scene: Scene, i: int) -> list[dict[str, Any]]:
    """A link for each hinge of a body, the last of which is the body; frames as the body's in its zero position, at the anchors."""
    body = scene.bodies[i]
    found = []
    at = np.array(body.p)
    R = np.reshape(body.R, (3, 3))
    before = np.zeros(3)
    for k, hinge in enumerate(body.hinges):
        anchor = np.array(hinge.anchor)
        place = at + R @ anchor if k == 0 else anchor - before
        found.append({"R": R if k == 0 else np.eye(3), "p": place, "hinge": hinge, "anchor": anchor})
        before = anchor
    return found


def ends(scene: Scene, until: float, step: float) -> list[tuple[float, bool]]:
    """The instants to run to, and whether the first body is released there."""
    if 0 < scene.release < until:
        return [(scene.release, True), (until, False)]
    return [(until, False)]


def write_motion(engine: Engine, scene: Scene, until: float, step: float, every_step: bool) -> Array:
    """The motion after every step, or at the end alone. Returns the positions at the end."""
    times, rows = [0.0], [engine.state()]

    def look() -> None:
        if engine.time > times[-1]:
            times.append(engine.time), rows.append(engine.state())

    for end, release in ends(scene, until, step):
        watch = getattr(engine, "watch", None)
        if every_step and watch:
            watch(end, look)
        while engine.time < end - 0.5 * step:
            engine.advance(min(engine.time + step, end) if every_step else end)
            look()
        look()
        if release:
            engine.release()
    np.savez(sys.argv[6], t=times, **{key: [row[k] for row in rows] for k, key in enumerate("Rpvw")})
    return rows[-1][1]


def main(make: Callable[[Scene, float, str], Engine]) -> None:
    scene = scenes.read(sys.argv[1])
    step, variant, until, rounds = float(sys.argv[2]), sys.argv[3], float(sys.argv[4]), int(sys.argv[5])
    best = float("inf")
    watched = write_motion(make(scene, step, variant), scene, until, step, rounds > 0) if sys.argv[6] != "-" else None
    for _ in range(rounds):
        engine = make(scene, step, variant)
        taken = 0.0
        for end, release in ends(scene, until, step):
            begin = time.perf_counter()
            engine.advance(end)
            taken += time.perf_counter() - begin
            if release:
                engine.release()
        best = min(best, taken)
    # The run that is judged must be the run that is timed.
    differs = float(np.max(np.abs(engine.state()[1] - watched))) if watched is not None and rounds else 0.0
    result = {"differs": differs, "seconds": best / until if rounds else None, "note": engine.note() if rounds else ""}
    os.write(3, (json.dumps(result, ensure_ascii=False) + "\n").encode())
