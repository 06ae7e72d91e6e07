"""Meshes that CoACD splits into convex parts: what rests in them, and how close the parts are to the mesh."""

from __future__ import annotations

import copy
import json
import pathlib
import pickle
from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

import momentree as mt

pytestmark = pytest.mark.skipif(find_spec("coacd") is None, reason="coacd is not installed")
Mesh = tuple[Any, list[tuple[int, int, int]]]
BRACKET = [(0, 0), (1, 0), (1, 1), (0.8, 1), (0.8, 0.2), (0.2, 0.2), (0.2, 1), (0, 1)]  # a U, 0.2 m thick
TRIANGLES = [(0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4), (0, 5, 6), (0, 6, 7)]


def bracket(turned: float = 0) -> Mesh:
    """From y = −0.25 to 0.25, open upwards, turned about z."""
    n = len(BRACKET)
    points = np.array([(x, y, z) for y in (-0.25, 0.25) for x, z in BRACKET])
    faces = [t for a, b, c in TRIANGLES for t in ((a, b, c), (n + a, n + c, n + b))]
    for i in range(n):
        k = (i + 1) % n
        faces += [(i, n + k, k), (i, n + i, n + k)]
    c, s = np.cos(turned), np.sin(turned)
    return points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), faces


def lathe(profile: Sequence[tuple[float, float]], sides: int, closed: bool) -> Mesh:
    """The profile (radius, z) turned about z; not `closed`: its ends are on the axis."""
    angles = 2 * np.pi * np.arange(sides) / sides
    points = [(r * np.cos(a), r * np.sin(a), z) for a in angles for r, z in profile]
    m = len(profile)
    faces = []
    for i in range(sides):
        j = (i + 1) % sides
        for p in range(m if closed else m - 1):
            q = (p + 1) % m
            quad = (i * m + p, j * m + p, j * m + q, i * m + q)
            faces += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
    known, corner = np.unique(np.round(points, 15), axis=0, return_inverse=True)
    number = corner.ravel().tolist()
    welded = [(number[a], number[b], number[c]) for a, b, c in faces]
    return known, [face for face in welded if len(set(face)) == 3]


CUP = lathe([(0, 0), (0.5, 0), (0.5, 1), (0.4, 1), (0.4, 0.1), (0, 0.1)], 16, closed=False)
RING = lathe([(1 + 0.25 * np.cos(a), 0.25 * np.sin(a)) for a in 2 * np.pi * np.arange(12) / 12], 24, closed=True)


def write(folder: pathlib.Path, mesh: Mesh, body: str) -> pathlib.Path:
    points, faces = mesh
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(points).tolist()] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    (folder / "mesh.obj").write_text("\n".join(lines) + "\n")
    (folder / "s.toml").write_text("format = 1\n[integrate]\nmethod = 'dop853'\nuntil = 2\n" + body)
    return folder / "s.toml"


def falling(name: str, at: str, collision: str) -> str:
    return f"""
[[mechanism]]
name = "{name}"
root = "free"
pose = {at}
body = [{{ name = "{name}", mass = 1, inertia = 0.01, collision = {collision} }}]
"""


def parts(scenario: pathlib.Path, folder: pathlib.Path) -> list[tuple[Any, Any]]:
    """Points and triangles of what the ground is made of."""
    scenario.write_text(scenario.read_text() + falling("ball", "{ xyz = [0, 0, 9] }", "{ sphere = 0.1 }"))
    mt.load(scenario).run(0.001).save(folder / "run")
    ground = json.loads((folder / "run/model.json").read_text())["ground"]
    return [(np.array(each["points"]), np.array(each["triangles"])) for each in ground]


def volume(points: Any, triangles: Any) -> float:
    a, b, c = (points[np.array(triangles)[:, k]] for k in range(3))
    return float(np.sum(a * np.cross(b, c))) / 6


def surface(points: Any, triangles: Any) -> Any:
    """Points on all triangles."""
    steps = [(i / 8, j / 8, 1 - (i + j) / 8) for i in range(9) for j in range(9 - i)]
    return np.concatenate([np.array(steps) @ points[list(face)] for face in triangles])


GROUND = "[world]\ncollision = { mesh = 'mesh.obj', split = SPLIT }\n"


@pytest.mark.parametrize("collision", ["{ sphere = 0.1 }", "{ capsule = { radius = 0.1, length = 0.2 }, at = { rpy = [1.5707963, 0, 0] } }"])
def test_what_falls_into_a_bracket_rests_on_its_floor(tmp_path: pathlib.Path, collision: str) -> None:
    ball = falling("ball", "{ xyz = [0.5, 0, 1.5] }", collision)
    run = mt.load(write(tmp_path, bracket(), GROUND.replace("SPLIT", "0.05") + ball)).run()
    assert run.events[0].time == pytest.approx(np.sqrt(2 * 1.2 / 9.81), abs=1e-9)
    assert run.bodies["ball/ball"].position[-1] == pytest.approx([0.5, 0, 0.3], abs=1e-8)
    hull = mt.load(write(tmp_path, bracket(), GROUND.replace(", split = SPLIT", "") + ball))
    assert "split = 0.05 divides it into convex parts" in str(hull.warnings[0])
    assert hull.run().bodies["ball/ball"].position[-1][2] == pytest.approx(1.1, abs=1e-9)


def test_parts_of_a_bracket_are_the_bracket(tmp_path: pathlib.Path) -> None:
    found = parts(write(tmp_path, bracket(), GROUND.replace("SPLIT", "0.05")), tmp_path)
    assert 3 <= len(found) <= 5
    assert sum(volume(*part) for part in found) == pytest.approx(volume(*bracket()), rel=1e-3)  # they may overlap a little
    for points, triangles in found:
        x, y, z = np.abs(surface(points, triangles)).T
        inside = (z < 0.2 + 1e-9) | (x < 0.2 + 1e-9) | (x > 0.8 - 1e-9)
        assert inside.all() and (x < 1 + 1e-9).all() and (z < 1 + 1e-9).all() and (y < 0.25 + 1e-9).all()


@pytest.mark.parametrize("split", [0.02, 0.05, 0.1])
def test_parts_of_round_and_turned_meshes_are_as_close_as_is_said(tmp_path: pathlib.Path, split: float) -> None:
    allowed = split / 2 * 2.5
    for points, triangles in parts(write(tmp_path, RING, GROUND.replace("SPLIT", str(split))), tmp_path):
        x, y, z = surface(points, triangles).T
        assert np.hypot(np.hypot(x, y) - 1, z).max() < 0.25 + allowed
    turned = bracket(0.5)
    (tmp_path / "turned").mkdir()
    c, s = np.cos(0.5), np.sin(0.5)
    for points, triangles in parts(write(tmp_path / "turned", turned, GROUND.replace("SPLIT", str(split))), tmp_path / "turned"):
        x, y, z = surface(points, triangles).T
        x = c * x + s * y
        assert np.minimum(np.minimum(z - 0.2, x - 0.2), 0.8 - x).max() < split / 2


def test_a_cup_that_moves_catches_a_ball(tmp_path: pathlib.Path) -> None:
    mesh = "{ mesh = 'mesh.obj', split = 0.05 }"
    bodies = falling("cup", "{ xyz = [0, 0, 0.2] }", mesh) + falling("ball", "{ xyz = [0.1, 0.05, 2] }", "{ sphere = 0.1 }")
    sim = mt.load(write(tmp_path, CUP, "[world]\nfloor = { friction = 0.4 }\n" + bodies))
    text = sim.model.to_toml()
    assert text.count("split = 0.05") == 1
    (tmp_path / "again.toml").write_text(text)
    run = sim.run()
    assert run.bodies["cup/cup"].position[-1] == pytest.approx([0, 0, 0], abs=1e-9)
    assert run.bodies["ball/ball"].position[-1] == pytest.approx([0.1, 0.05, 0.2], abs=1e-6)
    models = [mt.load(tmp_path / "again.toml").model, pickle.loads(pickle.dumps(sim.model)), copy.copy(sim.model)]
    for model in models:
        assert model.to_toml() == text
        again = mt.Simulation(model, method="dop853").run(0.5)
        assert [e.name for e in again.events] == [e.name for e in run.events if e.time <= 0.5]


def test_a_ring_hangs_on_a_bar(tmp_path: pathlib.Path) -> None:
    ring = falling("ring", "{ xyz = [0, 0, -0.7], rpy = [1.5707963267948966, 0, 0] }", "{ mesh = 'mesh.obj', split = 0.05 }")
    bar = "[world]\ncollision = { box = [0.2, 1, 0.2], at = { xyz = [0, 0, -0.2] } }\n"
    sim = mt.load(write(tmp_path, RING, bar + ring))
    sim.run(1)
    assert len(sim.world.contacts) > 0
    exact = -0.1 - np.sqrt(0.75**2 - 0.1**2)
    sides = 0.75 * (1 - np.cos(np.pi / 24))
    assert exact - 1e-9 < sim.world.bodies["ring/ring"].position[2] < exact + sides + 0.05 / 2 * 2.5


def test_coacd_may_be_used_beside_it(tmp_path: pathlib.Path) -> None:
    coacd = __import__("coacd")
    points, faces = bracket(0.3)
    coacd.set_log_level("error")
    assert len(coacd.run_coacd(coacd.Mesh(points, np.array(faces, np.int32)))) >= 3
    assert len(parts(write(tmp_path, (points * 0.5, faces), GROUND.replace("SPLIT", "0.05")), tmp_path)) >= 3
