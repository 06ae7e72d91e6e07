"""Masses and inertias from the density of shapes: closed forms, and the same as MuJoCo computes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import momentree as mt

size = st.integers(50, 2000).map(lambda mm: mm / 1000)
coordinate = st.integers(-1000, 1000).map(lambda mm: mm / 1000)
angle = coordinate
place = st.tuples(coordinate, coordinate, coordinate)


def body_of(**fields: Any) -> mt.Body:
    model = mt.Model()
    model.add("body", joint=mt.Free(), **fields)
    return mt.Simulation(model).world.bodies["body"]


def test_a_box() -> None:
    body = body_of(density="2700 kg/m^3", shape={"box": [0.1, 0.2, 0.3], "at": {"xyz": [1, 0, 0]}})
    assert body.mass == pytest.approx(2700 * 0.006) and np.allclose(body.com, (1, 0, 0))
    assert np.allclose(np.diag(body.inertia), body.mass / 12 * np.array([0.13, 0.10, 0.05]))


@given(size, size, size, place, place, angle, angle, angle)
def test_random_shapes_agree_with_mujoco(a: float, b: float, c: float, one: Any, two: Any, x: float, y: float, z: float) -> None:
    mujoco = pytest.importorskip("mujoco")

    def text(numbers: Any) -> str:
        return " ".join(repr(float(each)) for each in numbers)

    xml = f"""<mujoco><compiler angle="radian" eulerseq="XYZ"/><worldbody><body><freejoint/>
      <geom type="box" size="{text((a, b, c))}" pos="{text(one)}" euler="{text((x, y, z))}" density="1200"/>
      <geom type="capsule" size="{text((a, b))}" pos="{text(two)}" euler="{text((z, x, y))}" density="1200"/>
      <geom type="ellipsoid" size="{text((a, c, b))}" density="1200"/>
      <geom type="cylinder" size="{text((c, b))}" euler="{text((y, 0, 0))}" density="1200"/>
      <geom type="sphere" size="{text((c,))}" pos="{text(two)}" density="1200"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[1])
    turn = turn.reshape(3, 3)
    body = body_of(
        density=1200,
        shape=[
            {"box": [2 * a, 2 * b, 2 * c], "at": {"xyz": one, "rpy": [x, y, z]}},
            {"capsule": {"radius": a, "length": 2 * b}, "at": {"xyz": two, "rpy": [z, x, y]}},
            {"ellipsoid": [a, c, b]},
            {"cylinder": {"radius": c, "length": 2 * b}, "at": {"rpy": [y, 0, 0]}},
            {"sphere": c, "at": {"xyz": two}},
        ],
    )
    assert body.mass == pytest.approx(model.body_mass[1], rel=1e-12)
    assert np.allclose(body.com, model.body_ipos[1], atol=1e-12)
    inertia = turn @ np.diag(model.body_inertia[1]) @ turn.T
    assert np.allclose(body.inertia, inertia, atol=1e-9 * np.trace(inertia))


def test_a_mesh_has_the_mass_of_its_volume(tmp_path: Path) -> None:
    corners = [(x, y, z) for x in (0, 0.2) for y in (0, 0.3) for z in (0, 0.5)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["f " + " ".join(map(str, face)) for face in faces]
    (tmp_path / "box.obj").write_text("\n".join(lines) + "\n")
    (tmp_path / "open.obj").write_text("\n".join(lines[:-1]) + "\n")
    text = 'format = 1\n[[mechanism]]\nname = "m"\nroot = "free"\n[[mechanism.body]]\nname = "b"\ndensity = 1000\nshape = { mesh = "%s" }\n'
    (tmp_path / "closed.toml").write_text(text % "box.obj")
    (tmp_path / "gap.toml").write_text(text % "open.obj")
    body = mt.load(tmp_path / "closed.toml").world.bodies["m/b"]
    assert body.mass == pytest.approx(30) and np.allclose(body.com, (0.1, 0.15, 0.25))
    assert np.allclose(np.diag(body.inertia), 30 / 12 * np.array([0.34, 0.29, 0.13]))
    with pytest.raises(mt.Error, match="is not closed"):
        mt.load(tmp_path / "gap.toml")


@given(st.lists(coordinate, min_size=12, max_size=12), place, angle, angle, angle, st.booleans())
def test_meshes_of_mjcf_have_the_mass_that_mujoco_computes(
    numbers: list[float], at: Any, x: float, y: float, z: float, by_mass: bool
) -> None:
    mujoco = pytest.importorskip("mujoco")
    corners = np.array(numbers).reshape(4, 3) + np.vstack([np.zeros(3), 3 * np.eye(3)])

    def text(numbers: Any) -> str:
        return " ".join(repr(float(each)) for each in numbers)

    own = 'mass="3"' if by_mass else 'density="700"'
    xml = f"""<mujoco><compiler angle="radian" eulerseq="XYZ"/>
      <asset><mesh name="m" vertex="{text(corners.ravel())}" face="0 2 1 0 1 3 0 3 2 1 2 3" scale="0.5 1 2"/></asset>
      <worldbody><body name="b"><freejoint/>
      <geom type="mesh" mesh="m" pos="{text(at)}" euler="{text((x, y, z))}" {own}/>
      <geom size="0.3" density="1200"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[1])
    turn = turn.reshape(3, 3)
    body = mt.loads(xml, name="m.xml").world.bodies["m.xml/b"]
    assert body.mass == pytest.approx(model.body_mass[1], rel=1e-6)
    assert np.allclose(body.com, model.body_ipos[1], atol=1e-6)
    inertia = turn @ np.diag(model.body_inertia[1]) @ turn.T
    assert np.allclose(body.inertia, inertia, atol=1e-6 * np.trace(inertia))


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"density": 1000}, "no shape"),
        ({"density": 1000, "mass": 2, "shape": {"sphere": 1}}, "mass: the density determines it"),
        ({"density": 1000, "inertia": 2, "shape": {"sphere": 1}}, "inertia: the density determines it"),
        ({"density": 0, "shape": {"sphere": 1}}, "density"),
        ({"density": "3 kg", "shape": {"sphere": 1}}, "is a mass"),
        ({"shape": {"sphere": 1}}, "has no 'mass'"),
    ],
)
def test_mistakes(fields: dict[str, Any], problem: str) -> None:
    with pytest.raises(mt.Error, match=problem):
        body_of(**fields)


def test_what_touches_counts_without_a_shape() -> None:
    body = body_of(density=500, collision={"sphere": 0.1})
    assert body.mass == pytest.approx(500 * 4 / 3 * np.pi * 1e-3)
