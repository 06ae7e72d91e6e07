"""Exported runs: .glb, .usda and .mcap files, compared with the result that they were made from."""

from __future__ import annotations

import io
import json
import pathlib
import shutil
from collections import defaultdict
from typing import Any

import numpy as np
import pytest

from export_files import COLOURS, Glb, Result, call

# Trees, parts that break off and are grasped, free bodies, loops that are made and broken, springs that part, meshes.
SCENARIOS = {
    "breaking_chain": [],
    "capture": [],
    "hand_over": [],
    "four_bar": [],
    "chain_to_ring": [],
    "line_cascade": [],
    "guyed_mast": [],
    "arm_loses_its_grinder": [],
    "tree_of_joints": [],
}


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, pathlib.Path]:
    """Result folders with their exports, run when they are first asked for."""
    place = tmp_path_factory.mktemp("exports")

    class Folders(dict[str, pathlib.Path]):
        def __missing__(self, name: str) -> pathlib.Path:
            folder = place / name
            call("run", f"scenarios/{name}.toml", "--out", folder, "--quiet", "--reactions", *SCENARIOS[name])
            for ending in ("glb", "usda", "mcap"):
                call("view", folder, "--export", place / f"{name}.{ending}")
            self[name] = folder
            return folder

    return Folders()


@pytest.mark.parametrize("name", SCENARIOS)
def test_nodes_have_the_poses_of_the_result_at_its_rows(results: dict[str, pathlib.Path], name: str) -> None:
    result, glb = Result(results[name]), Glb(results[name].with_suffix(".glb"))
    times = (result.time - result.time[0]).astype(np.float32)
    assert np.all(np.diff(times) > 0)
    moving = 0
    for body in result.bodies:
        position, quaternion = result.pose(body)
        node = glb.node(body)
        assert np.array_equal(glb.keys(node, "translation", times), position.astype(np.float32))
        turn = glb.keys(node, "rotation", times)[:, [3, 0, 1, 2]].astype(float)
        sign = np.sign(np.sum(turn * quaternion, axis=1, keepdims=True))
        assert np.max(np.abs(turn - sign * quaternion)) < 1e-7
        assert np.all(np.sum(turn[1:] * turn[:-1], axis=1) >= 0)  # the shorter way between two rows
        moving += (node, "rotation") in glb.channels or (node, "translation") in glb.channels
    assert moving > 0
    assert {path for _, path in glb.channels} >= {"rotation"}


@pytest.mark.parametrize("name", SCENARIOS)
def test_gravity_points_down_and_extras_list_the_events(results: dict[str, pathlib.Path], name: str) -> None:
    result, glb = Result(results[name]), Glb(results[name].with_suffix(".glb"))
    gravity = np.array(result.model["gravity"])
    up = -gravity / np.linalg.norm(gravity) if gravity.any() else np.array([0.0, 0, 1])
    *vector, w = glb.json["nodes"][glb.root]["rotation"]
    turned = up + 2 * np.cross(vector, np.cross(vector, up) + w * up)
    assert np.allclose(turned, [0, 1, 0], atol=1e-6)
    extras = glb.json["scenes"][0]["extras"]
    assert extras["status"] == "done"
    assert [(e["event"], e["actions"]) for e in extras["events"]] == [(e["event"], e["actions"]) for e in result.events]
    assert np.allclose([e["time"] for e in extras["events"]], [e["time"] - result.time[0] for e in result.events], atol=1e-12)


@pytest.mark.parametrize("name", SCENARIOS)
def test_bodies_have_the_colours_of_their_mechanisms_between_events(results: dict[str, pathlib.Path], name: str) -> None:
    result, glb = Result(results[name]), Glb(results[name].with_suffix(".glb"))
    changes = [time for time, _ in result.phases()]
    instants = [*((a + b) / 2 for a, b in zip(changes, changes[1:]) if b - a > 1e-4), (changes[-1] + result.time[-1]) / 2]
    meshed = any((body["shape"] or {}).get("kind") == "mesh" for body in result.model["bodies"].values())
    seen = 0
    for instant in instants[:12]:
        expected = result.colours_at(instant)
        for body in result.bodies:
            shapes = [result.model["bodies"][body]["shape"], *result.model["bodies"][body].get("more_shapes", [])]
            own = {shape["colour"] for shape in shapes if shape and "colour" in shape}
            shown = glb.shown_colours(body, instant - result.time[0])
            assert shown & set(COLOURS) <= own | {expected[body]}
            frame = meshed and not any(shapes) and result.model["bodies"][body]["mass"] == 0  # between bodies with meshes
            assert all(shapes) or frame or shown == {expected[body]}
            seen += len(shown)
    assert seen > 0


def test_a_part_that_breaks_off_changes_its_colour_at_that_instant(results: dict[str, pathlib.Path]) -> None:
    result, glb = Result(results["breaking_chain"]), Glb(results["breaking_chain"].with_suffix(".glb"))
    (event,) = result.events
    moved = [body for first, count in event["topology"]["moved"]["chain/41"] for body in result.bodies[first : first + count]]
    assert len(moved) == 60
    at = np.float32(event["time"])
    for body in result.bodies:
        before, after = (glb.shown_colours(body, float(t)) for t in (np.nextafter(at, np.float32(0)), at))
        assert before == {COLOURS[0]} and after == {COLOURS[1] if body in moved else COLOURS[0]}


def test_springs_end_at_their_points_and_vanish_when_they_break(results: dict[str, pathlib.Path]) -> None:
    result, glb = Result(results["guyed_mast"]), Glb(results["guyed_mast"].with_suffix(".glb"))
    times = (result.time - result.time[0]).astype(np.float32)
    parted = {name: event["time"] for event in result.events for name in event.get("topology", {}).get("broken_springs", [])}
    assert parted

    def place(end: dict[str, Any]) -> Any:
        point = np.array(end["point"], float)
        if end["body"] == "ground":
            return np.tile(point, (len(times), 1))
        position, q = result.pose(end["body"])
        v = np.tile(point, (len(times), 1))
        return position + v + 2 * np.cross(q[:, 1:], np.cross(q[:, 1:], v) + q[:, :1] * v)

    for name, spring in result.model["springs"].items():
        switch = glb.node(name)
        (bar,) = glb.json["nodes"][switch]["children"]
        shown = glb.keys(switch, "scale", times).any(axis=1)
        assert np.array_equal(shown, result.time < parted.get(name, np.inf))
        middle, turn, scale = (glb.keys(bar, path, times).astype(float) for path in ("translation", "rotation", "scale"))
        x, y, z, w = turn.T
        along = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
        for side, end in ((-0.5, spring["from"]), (0.5, spring["to"])):
            assert np.allclose(middle + side * scale[:, 2:] * along, place(end), atol=2e-6 * (1 + np.abs(place(end)).max()))


def test_meshes_are_those_of_the_result(results: dict[str, pathlib.Path]) -> None:
    folder = results["arm_loses_its_grinder"]
    glb, meshes = Glb(folder.with_suffix(".glb")), json.loads((folder / "meshes.json").read_text())["meshes"]
    parts = sum(len(mesh["parts"]) for mesh in meshes if mesh)
    flat = {p["indices"] for m in glb.json["meshes"] for p in m["primitives"] if "NORMAL" not in p["attributes"]}
    assert len(flat) == parts
    assert all(glb.json["materials"][p["material"]].get("doubleSided") for m in glb.json["meshes"] for p in m["primitives"]
               if p["indices"] in flat)  # fmt: skip


# USD


class Usd:
    """A .usda file, read and checked by Pixar's library."""

    def __init__(self, path: pathlib.Path) -> None:
        pxr = pytest.importorskip("pxr", reason="usd-core is not installed")
        from pxr import Usd, UsdGeom, UsdShade, UsdValidation

        self.pxr, self.UsdGeom, self.UsdShade = pxr, UsdGeom, UsdShade
        self.stage = Usd.Stage.Open(str(path))
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        assert len(validators) > 20
        assert [error.GetErrorAsString() for error in UsdValidation.ValidationContext(validators).Validate(self.stage)] == []
        self.root = self.stage.GetDefaultPrim()
        self.named = {prim.GetDisplayName() or prim.GetName(): prim for prim in self.root.GetChildren()}

    def codes(self, result: Result) -> Any:
        return (result.time - result.time[0]) * self.stage.GetTimeCodesPerSecond()

    def pose(self, prim: Any, code: float) -> tuple[Any, Any]:
        """In the frame of the world: the position, and the quaternion w, x, y, z."""
        matrix, _ = self.UsdGeom.XformCache(code).ComputeRelativeTransform(prim, self.root)
        matrix = matrix.RemoveScaleShear()
        quaternion = matrix.ExtractRotationQuat()
        return np.array(matrix.ExtractTranslation()), np.array([quaternion.GetReal(), *quaternion.GetImaginary()])

    def colours(self, body: str, code: float) -> set[str]:
        """Of a body's solids; those of their materials and those of their own are the same."""
        found = set()
        for solid in self.named[body].GetChildren():
            material = self.UsdShade.MaterialBindingAPI(solid).ComputeBoundMaterial()[0]
            shader = self.UsdShade.Shader(material.GetPrim().GetChildren()[0])
            shown = shader.GetInput("diffuseColor").Get(code)
            assert np.allclose(self.UsdGeom.Gprim(solid).GetDisplayColorAttr().Get(code)[0], shown)
            srgb = [12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055 for c in shown]
            found.add("#" + "".join(f"{round(255 * c):02x}" for c in srgb))
        return found


@pytest.mark.parametrize("name", SCENARIOS)
def test_usd_prims_have_the_poses_and_colours_of_the_result(results: dict[str, pathlib.Path], name: str) -> None:
    result, usd = Result(results[name]), Usd(results[name].with_suffix(".usda"))
    codes = usd.codes(result)
    assert usd.UsdGeom.GetStageMetersPerUnit(usd.stage) == 1 and usd.UsdGeom.GetStageUpAxis(usd.stage) == "Z"
    assert usd.stage.GetEndTimeCode() == pytest.approx(codes[-1])
    gravity = np.array(result.model["gravity"])
    if gravity.any():
        up = usd.pxr.Gf.Vec3d(*(-gravity / np.linalg.norm(gravity)))
        turned = usd.UsdGeom.XformCache().GetLocalToWorldTransform(usd.root).TransformDir(up)
        assert np.allclose(turned, [0, 0, 1], atol=1e-6)
    for body in result.bodies[:40]:
        position, quaternion = result.pose(body)
        for row in range(0, len(codes), 7):
            at, turn = usd.pose(usd.named[body], codes[row])
            assert np.allclose(at, position[row], rtol=1e-15, atol=1e-12)
            assert abs(abs(turn @ quaternion[row]) - 1) < 1e-6
    changes = [time for time, _ in result.phases()]
    instants = [(a + b) / 2 for a, b in zip(changes, changes[1:]) if b - a > 1e-4][:5] + [(changes[-1] + result.time[-1]) / 2]
    meshed = any((body["shape"] or {}).get("kind") == "mesh" for body in result.model["bodies"].values())
    seen = 0
    for instant in instants:
        expected = result.colours_at(instant)
        for body in result.bodies:
            shapes = [result.model["bodies"][body]["shape"], *result.model["bodies"][body].get("more_shapes", [])]
            own = {shape["colour"] for shape in shapes if shape and "colour" in shape}
            shown = usd.colours(body, (instant - result.time[0]) * usd.stage.GetTimeCodesPerSecond())
            assert shown & set(COLOURS) <= own | {expected[body]}
            frame = meshed and not any(shapes) and result.model["bodies"][body]["mass"] == 0  # between bodies with meshes
            assert all(shapes) or frame or shown == {expected[body]}
            seen += len(shown)
    assert seen > 0


def test_usd_colours_change_and_springs_vanish_at_events(results: dict[str, pathlib.Path]) -> None:
    result, usd = Result(results["breaking_chain"]), Usd(results["breaking_chain"].with_suffix(".usda"))
    (event,) = result.events
    at = (event["time"] - result.time[0]) * usd.stage.GetTimeCodesPerSecond()
    assert usd.colours("chain/100", at - 1e-6) == {COLOURS[0]} and usd.colours("chain/100", at + 1e-6) == {COLOURS[1]}
    assert usd.colours("chain/1", at + 1e-6) == {COLOURS[0]}

    result, usd = Result(results["guyed_mast"]), Usd(results["guyed_mast"].with_suffix(".usda"))
    parted = {name: event["time"] for event in result.events for name in event.get("topology", {}).get("broken_springs", [])}
    assert parted
    for name, spring in result.model["springs"].items():
        bar = usd.UsdGeom.Imageable(usd.named[name])
        assert spring["from"]["body"] == "ground" or spring["to"]["body"] == "ground"
        held = next(end["point"] for end in (spring["from"], spring["to"]) if end["body"] == "ground")
        for row, code in enumerate(usd.codes(result)):
            shown = bar.ComputeVisibility(code) == "inherited"
            assert shown == (result.time[row] < parted.get(name, np.inf))
            matrix, _ = usd.UsdGeom.XformCache(code).ComputeRelativeTransform(bar.GetPrim(), usd.root)
            ends = [np.array(matrix.Transform(usd.pxr.Gf.Vec3d(0, 0, side))) for side in (-0.5, 0.5)]
            assert min(np.linalg.norm(end - held) for end in ends) < 1e-5 * (1 + np.linalg.norm(held))


def test_usd_meshes_are_those_of_the_result(results: dict[str, pathlib.Path]) -> None:
    folder = results["arm_loses_its_grinder"]
    usd, meshes = Usd(folder.with_suffix(".usda")), json.loads((folder / "meshes.json").read_text())["meshes"]
    parts = [part for mesh in meshes if mesh for part in mesh["parts"]]
    found = [usd.UsdGeom.Mesh(prim) for prim in usd.stage.Traverse() if prim.IsA(usd.UsdGeom.Mesh)]
    assert len(found) == len(parts)
    boxes = sorted((*part["low"], *part["high"]) for part in parts)
    assert np.allclose(sorted((*low, *high) for low, high in (mesh.GetExtentAttr().Get() for mesh in found)), boxes, atol=1e-6)
    for mesh in found:
        assert usd.UsdGeom.Mesh.ValidateTopology(
            mesh.GetFaceVertexIndicesAttr().Get(), mesh.GetFaceVertexCountsAttr().Get(), len(mesh.GetPointsAttr().Get())
        )[0]


# MCAP


def messages_of(path: pathlib.Path) -> dict[str, list[Any]]:
    """Messages with their log times, by topic, in the order of time; all checksums are compared."""
    reader = pytest.importorskip("mcap.reader")
    found: dict[str, list[Any]] = defaultdict(list)
    with path.open("rb") as file:
        seeking = reader.SeekingReader(file, validate_crcs=True)
        summary = seeking.get_summary()
        for schema, channel, message in seeking.iter_messages():
            assert schema.encoding == "jsonschema" and channel.message_encoding == "json"
            data = json.loads(message.data)
            if message.sequence == 0:  # messages of one topic are alike
                conforms(data, json.loads(schema.data), channel.topic)
            found[channel.topic].append((message.log_time, data))
        counts = {summary.channels[c].topic: n for c, n in summary.statistics.channel_message_counts.items()}
        assert counts == {topic: len(messages) for topic, messages in found.items()}
        assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 0
        assert list(seeking.iter_metadata())[0].name == "momentree"
    streamed = reader.NonSeekingReader(io.BytesIO(path.read_bytes()), validate_crcs=True)
    assert sum(1 for _ in streamed.iter_messages()) == sum(counts.values())
    return found


def conforms(value: Any, schema: dict[str, Any], where: str) -> None:
    """A value conforms to the part of JSON Schema that is used, and has no member that the schema does not have."""
    if "oneOf" in schema:
        assert any(value == choice["const"] for choice in schema["oneOf"]), where
    kind = schema.get("type")
    if kind == "object":
        assert isinstance(value, dict) and set(value) <= set(schema["properties"]), where
        for name, member in value.items():
            conforms(member, schema["properties"][name], f"{where}.{name}")
    elif kind == "array":
        assert isinstance(value, list), where
        for item in value:
            conforms(item, schema["items"], where + "[]")
    elif kind == "integer":
        assert isinstance(value, int) and schema.get("minimum", value) <= value <= schema.get("maximum", value), where
    elif kind:
        assert isinstance(value, {"number": (int, float), "string": str, "boolean": bool}[kind]), where


def nanoseconds(times: Any) -> list[int]:
    return [round(t) for t in np.asarray(times, float) * 1e9]


@pytest.mark.parametrize("name", SCENARIOS)
def test_messages_have_the_numbers_of_the_tables(results: dict[str, pathlib.Path], name: str) -> None:
    result = Result(results[name])
    found = messages_of(results[name].with_suffix(".mcap"))
    assert [time for time, _ in found["/tf"]] == nanoseconds(result.time)
    for number, body in enumerate(result.bodies):
        position, quaternion = result.pose(body)
        transforms = [message["transforms"][number] for _, message in found["/tf"]]
        assert {(t["parent_frame_id"], t["child_frame_id"]) for t in transforms} == {("world", body)}
        assert np.array_equal([[t["translation"][k] for k in "xyz"] for t in transforms], position)  # to the last bit
        turn = np.array([[t["rotation"][k] for k in "wxyz"] for t in transforms])
        assert np.allclose(np.abs(np.sum(turn * quaternion, axis=1)), 1, rtol=0, atol=1e-14)
    joints = table_of(results[name] / "joints.csv")
    for row in (0, len(result.time) // 2, len(result.time) - 1):
        states = {state["name"]: state for state in found["/joints"][row][1]["joints"]}
        for column, values in joints.items():
            owner, _, field = column.rpartition(".")
            if column == "time" or np.isnan(values[row]):
                continue
            member, index = {"f": "force", "m": "torque"}.get(field[0], field[0]), field[1:]
            assert states[owner][member]["xyz".index(index) if index in "xyz" else int(index)] == values[row]
    energy = table_of(results[name] / "energy.csv")
    assert np.array_equal([message["kinetic"] for _, message in found["/energy"]], energy["kinetic"])
    assert np.array_equal([message["angular"]["z"] for _, message in found["/energy"]], energy["angular.z"])


def table_of(path: pathlib.Path) -> dict[str, Any]:
    from export_files import table

    return table(path)


@pytest.mark.parametrize("name", SCENARIOS)
def test_scenes_and_log_lines_follow_the_events(results: dict[str, pathlib.Path], name: str) -> None:
    result = Result(results[name])
    found = messages_of(results[name].with_suffix(".mcap"))
    assert [(time, m["name"], m["message"]) for time, m in found["/events"]] == [
        (nanoseconds([e["time"]])[0], e["event"], ", ".join(e["actions"])) for e in result.events
    ]
    for time, message in found["/scene"]:
        expected = result.colours_at(time * 1e-9 + 1e-9)
        for entity in message["entities"]:
            assert entity["frame_id"] == entity["id"] and entity["frame_locked"]
            colours = [p["color"] for kind in ("cubes", "spheres", "cylinders", "triangles") for p in entity[kind]]
            want = [int(expected[entity["id"]][k : k + 2], 16) / 255 for k in (1, 3, 5)]
            assert colours and all(np.allclose([c["r"], c["g"], c["b"]], want) for c in colours)
    if name == "guyed_mast":
        last = [len(message["entities"][0]["lines"]) for _, message in found["/scene/bars"]]
        parted = sum(len(event.get("topology", {}).get("broken_springs", [])) for event in result.events)
        assert last[0] == len(result.model["springs"]) and last[-1] == last[0] - parted


# Mistakes


def test_mistakes_are_named(results: dict[str, pathlib.Path], tmp_path: pathlib.Path) -> None:
    folder = results["four_bar"]
    assert ".mp4" in call("view", folder, "--export", tmp_path / "run.mp4", code=2)
    assert "no ending" in call("view", folder, "--export", tmp_path / "run", code=2)
    assert "no_such_folder" in call("view", folder, "--export", tmp_path / "no_such_folder/run.glb", code=2)
    assert "--svg" in call("view", folder, "--svg", "a.svg", "--export", tmp_path / "run.glb", code=2)
    assert "--every" in call("view", folder, "--every", "0.1", "--export", tmp_path / "run.glb", code=2)
    broken = tmp_path / "broken"
    shutil.copytree(folder, broken)
    rows = (broken / "bodies.csv").read_text().splitlines(keepends=True)
    (broken / "bodies.csv").write_text("".join([*rows[:5], rows[5].replace(",", ",x", 1), *rows[6:]]))
    assert "bodies.csv:6: error: column" in call("view", broken, "--export", tmp_path / "run.glb", code=2)
    (broken / "bodies.csv").unlink()
    assert "bodies.csv" in call("view", broken, "--export", tmp_path / "run.mcap", code=2)
    assert list(tmp_path.glob("*.glb")) == list(tmp_path.glob("*.mcap")) == []


def test_a_run_that_diverged_ends_before_its_first_row_that_is_not_finite(
    results: dict[str, pathlib.Path], tmp_path: pathlib.Path
) -> None:
    folder = tmp_path / "diverged"
    shutil.copytree(results["four_bar"], folder)
    rows = (folder / "bodies.csv").read_text().splitlines(keepends=True)
    count = len(rows[0].split(","))
    (folder / "bodies.csv").write_text("".join([*rows[:9], ",".join(["1e3", *["nan"] * (count - 1)]) + "\n"]))
    summary = json.loads((folder / "summary.json").read_text())
    (folder / "summary.json").write_text(json.dumps({**summary, "status": "diverged at t = 1"}))
    for ending in ("glb", "mcap"):
        call("view", folder, "--export", tmp_path / f"run.{ending}")
    times = (np.array([float(row.split(",")[0]) for row in rows[1:9]])).astype(np.float32)
    keys = {tuple(at) for (_, path), (at, _, _) in Glb(tmp_path / "run.glb").channels.items() if path != "scale"}
    held = np.nextafter(times[-1], np.float32(0))  # the motion between the last two rows is unknown
    assert keys == {(*times[:-1], held, times[-1])}
    log = messages_of(tmp_path / "run.mcap")["/events"][-1][1]
    assert log["level"] == 4 and log["message"] == "diverged at t = 1"


def test_a_scenario_is_run_for_its_export(results: dict[str, pathlib.Path], tmp_path: pathlib.Path) -> None:
    call("view", "scenarios/breaking_chain.toml", "--export", tmp_path / "RUN.GLB")
    assert (tmp_path / "RUN.GLB").read_bytes() == results["breaking_chain"].with_suffix(".glb").read_bytes()
    assert [path.name for path in tmp_path.iterdir()] == ["RUN.GLB"]


def test_runs_of_the_package_are_exported(tmp_path: pathlib.Path) -> None:
    mt = pytest.importorskip("momentree")
    model = mt.Model()
    model.add("arm/rod", mass=2, com=(1, 0, 0), inertia=2, joint=mt.Revolute(axis=(0, 1, 0)))
    run = mt.Simulation(model).run(0.5, record_every=0.01)
    for ending in ("glb", "mcap"):
        path = tmp_path / f"run.{ending}"
        assert run.export(path) == str(path)
    glb = Glb(tmp_path / "run.glb")
    turn = glb.keys(glb.node("arm/rod"), "rotation", run.time.astype(np.float32))[:, [3, 0, 1, 2]]
    assert np.max(np.abs(np.abs(np.sum(turn * run.bodies["arm/rod"].quaternion, axis=1)) - 1)) < 1e-6
    assert len(messages_of(tmp_path / "run.mcap")["/tf"]) == len(run)
    with pytest.raises(mt.Error, match=r"\.mp4"):
        run.export(tmp_path / "run.mp4")
    with pytest.raises(mt.Error, match="no_such_folder"):
        run.export(tmp_path / "no_such_folder/run.glb")
