"""Meshes of bodies in the files and reports of runs."""

from __future__ import annotations

import json
import pathlib
import shutil
import subprocess
import sys
import warnings

import momentree as mt
import pytest

SCENARIOS = pathlib.Path(__file__).resolve().parents[2] / "scenarios"


def test_runs_write_the_meshes_of_their_bodies(tmp_path: pathlib.Path) -> None:
    run = mt.load(SCENARIOS / "arm_loses_its_grinder.toml").run(until=0.01)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        folder = pathlib.Path(run.save(tmp_path / "run", report=True))
    meshes = json.loads((folder / "meshes.json").read_text())["meshes"]
    numbers = set()
    for body in json.loads((folder / "model.json").read_text())["bodies"].values():
        numbers |= {shape["mesh"] for shape in [body.get("shape", {}), *body.get("more_shapes", [])] if "mesh" in shape}
    assert numbers == set(range(len(meshes))) and len(meshes) > 3
    assert all(mesh["triangles"] > 0 and mesh["parts"] for mesh in meshes)
    assert (folder / "report.html").stat().st_size > (folder / "meshes.json").stat().st_size


def test_a_mesh_that_cannot_be_read_is_a_warning(tmp_path: pathlib.Path) -> None:
    shutil.copy(SCENARIOS / "arm_loses_its_grinder.toml", tmp_path)
    shutil.copytree(SCENARIOS / "models/grinder_arm", tmp_path / "models/grinder_arm")
    broken = tmp_path / "models/grinder_arm/meshes/turret.obj"
    broken.write_text("v 1 2 x\n")
    run = mt.load(tmp_path / "arm_loses_its_grinder.toml").run(until=0.01)
    with pytest.warns(UserWarning, match=r"grinder_arm\.urdf:\d+:\d+: warning: the mesh .* is not drawn: a coordinate"):
        folder = pathlib.Path(run.save(tmp_path / "run"))
    assert None in json.loads((folder / "meshes.json").read_text())["meshes"]


@pytest.mark.parametrize(
    ("script", "made"),
    [("meshes", "."), ("models/grinder_arm", "meshes"), ("models/ur5", "robots/ur_description/meshes/ur5/visual")],
)
def test_meshes_are_what_their_scripts_make(script: str, made: str, tmp_path: pathlib.Path) -> None:
    subprocess.run([sys.executable, "-B", SCENARIOS / script / "make_meshes.py", tmp_path], check=True)

    def files(folder: pathlib.Path) -> dict[str, bytes]:
        found = (path for path in folder.rglob("*") if path.is_file() and path.suffix not in (".py", ".pyc"))
        return {str(path.relative_to(folder)): path.read_bytes() for path in found}

    fresh, kept = files(tmp_path), files(SCENARIOS / script / made)
    assert fresh.keys() == kept.keys()
    assert [name for name in fresh if fresh[name] != kept[name]] == []
