"""Reads exported files strictly: a .glb file by the rules of glTF 2.0, and a result folder to compare it with."""

from __future__ import annotations

import json
import os
import pathlib
import struct
import subprocess
import sys
from typing import Any

import numpy as np
import numpy.typing as npt

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("MOMENTREE_PROGRAM", "")
COMMAND = [PROGRAM] if PROGRAM else [sys.executable, "-m", "momentree"]
COLOURS = ["#1f6fb5", "#d5560a", "#12805c", "#a0408a", "#8a6d00", "#0f8fa8", "#b3263e", "#5b5fc7"]  # of the report
Numbers = npt.NDArray[Any]


def call(*words: object, code: int = 0, cwd: pathlib.Path = ROOT) -> str:
    done = subprocess.run([*COMMAND, *map(str, words)], cwd=cwd, capture_output=True, text=True, timeout=300)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def table(path: pathlib.Path) -> dict[str, Numbers]:
    head = path.read_text().split("\n", 1)[0].split(",")
    rows = np.genfromtxt(path, delimiter=",", skip_header=1, ndmin=2)
    return {name: rows[:, k] for k, name in enumerate(head)}


class Result:
    """A result folder: poses by body, the lines of events.jsonl, and the mechanism of each body from a time on."""

    def __init__(self, folder: pathlib.Path) -> None:
        self.folder = folder
        self.bodies_table = table(folder / "bodies.csv")
        self.time = self.bodies_table["time"]
        self.bodies = [name.removesuffix(".x") for name in self.bodies_table if name.endswith(".x")]
        self.model: dict[str, Any] = json.loads((folder / "model.json").read_text())
        self.events = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]

    def pose(self, body: str) -> tuple[Numbers, Numbers]:
        """Positions, and quaternions w, x, y, z."""
        columns = [[self.bodies_table[f"{body}.{part}"] for part in parts] for parts in (("x", "y", "z"), ("qw", "qx", "qy", "qz"))]
        return np.stack(columns[0], axis=1), np.stack(columns[1], axis=1)

    def phases(self) -> list[tuple[float, dict[str, str]]]:
        """Mechanisms by body, from times on."""
        now = {body: mechanism["name"] for mechanism in self.model["mechanisms"] for body in mechanism["bodies"]}
        all_phases = [(self.time[0], dict(now))]
        for event in self.events:
            for name, ranges in event.get("topology", {}).get("moved", {}).items():
                for first, count in ranges:
                    now.update({body: name for body in self.bodies[first : first + count]})
            all_phases.append((event["time"], dict(now)))
        return all_phases

    def colours_at(self, time: float) -> dict[str, str]:
        """By body: mechanisms have colours in the order of their appearance."""
        order: dict[str, int] = {}
        found: dict[str, str] = {}
        for begin, mechanism in self.phases():
            names = [mechanism[body] for body in self.bodies]
            for name in names:
                order.setdefault(name, len(order))
            if begin <= time:
                found = mechanism
        return {body: COLOURS[order[name] % 8] for body, name in found.items()}


class Glb:
    """A .glb file; construction fails an assertion if it is not valid."""

    widths = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
    types = {5123: np.dtype("<u2"), 5125: np.dtype("<u4"), 5126: np.dtype("<f4")}

    def __init__(self, path: pathlib.Path) -> None:
        data = path.read_bytes()
        magic, version, length = struct.unpack_from("<4sII", data)
        assert magic == b"glTF" and version == 2 and length == len(data)
        chunks = []
        at = 12
        while at < len(data):
            size, kind = struct.unpack_from("<I4s", data, at)
            assert size % 4 == 0 and at + 8 + size <= len(data)
            chunks.append((kind, data[at + 8 : at + 8 + size]))
            at += 8 + size
        assert [kind for kind, _ in chunks] in ([b"JSON", b"BIN\0"], [b"JSON"])
        self.json: dict[str, Any] = json.loads(chunks[0][1])
        self.binary = chunks[1][1] if len(chunks) > 1 else b""
        assert self.json["asset"]["version"] == "2.0"
        assert all(self.json[key] for key in self.json if key not in ("asset", "scene"))  # glTF has no empty lists
        (buffer,) = self.json.get("buffers", [{"byteLength": 0}])
        assert 0 <= len(self.binary) - buffer["byteLength"] < 4 and "uri" not in buffer
        self.accessors = [self._accessor(accessor) for accessor in self.json.get("accessors", [])]
        used = {accessor["bufferView"] for accessor in self.json.get("accessors", [])}
        assert used == set(range(len(self.json.get("bufferViews", []))))
        self._check_meshes()
        self._check_nodes()
        self._check_animation()

    def _accessor(self, accessor: dict[str, Any]) -> Numbers:
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind, width = self.types[accessor["componentType"]], self.widths[accessor["type"]]
        assert view["buffer"] == 0 and view["byteOffset"] % 4 == 0 and "byteStride" not in view
        assert 0 < view["byteLength"] and view["byteOffset"] + view["byteLength"] <= self.json["buffers"][0]["byteLength"]
        assert accessor["count"] > 0 and accessor["count"] * width * kind.itemsize == view["byteLength"]
        numbers = np.frombuffer(self.binary, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
        assert np.all(np.isfinite(numbers))
        if "min" in accessor:
            assert np.array_equal(numbers.min(axis=0), np.array(accessor["min"], kind))
            assert np.array_equal(numbers.max(axis=0), np.array(accessor["max"], kind))
        return numbers

    def _check_meshes(self) -> None:
        views = self.json.get("bufferViews", [])
        accessors = self.json.get("accessors", [])
        for mesh in self.json.get("meshes", []):
            for primitive in mesh["primitives"]:
                positions = accessors[primitive["attributes"]["POSITION"]]
                indices = accessors[primitive["indices"]]
                assert positions["type"] == "VEC3" and positions["componentType"] == 5126 and "min" in positions
                assert views[positions["bufferView"]]["target"] == 34962 and views[indices["bufferView"]]["target"] == 34963
                corners = self.accessors[primitive["indices"]]
                assert indices["type"] == "SCALAR" and indices["componentType"] in (5123, 5125) and len(corners) % 3 == 0
                assert corners.max() < positions["count"] and corners.max() < (65535 if indices["componentType"] == 5123 else 2**32 - 1)
                if "NORMAL" in primitive["attributes"]:
                    normals = self.accessors[primitive["attributes"]["NORMAL"]]
                    assert len(normals) == positions["count"]
                    assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6)
                material = self.json["materials"][primitive["material"]]["pbrMetallicRoughness"]
                assert all(0 <= x <= 1 for x in [*material["baseColorFactor"], material["metallicFactor"], material["roughnessFactor"]])

    def _check_nodes(self) -> None:
        nodes = self.json["nodes"]
        self.parent: dict[int, int] = {}
        for number, node in enumerate(nodes):
            for child in node.get("children", []):
                assert child not in self.parent
                self.parent[child] = number
            if "rotation" in node:
                assert abs(np.linalg.norm(node["rotation"]) - 1) < 1e-6
            assert "mesh" not in node or node["mesh"] < len(self.json["meshes"])
        (self.root,) = self.json["scenes"][self.json["scene"]]["nodes"]
        for number in range(len(nodes)):  # all are below the root
            for _ in range(len(nodes)):
                if number == self.root:
                    break
                number = self.parent[number]
            assert number == self.root

    def _check_animation(self) -> None:
        self.channels: dict[tuple[int, str], tuple[Numbers, Numbers, str]] = {}
        for animation in self.json.get("animations", []):
            assert len(animation["channels"]) == len(animation["samplers"])
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                times, values = self.accessors[sampler["input"]][:, 0], self.accessors[sampler["output"]]
                path = channel["target"]["path"]
                assert "min" in self.json["accessors"][sampler["input"]]
                assert times[0] >= 0 and np.all(np.diff(times) > 0) and len(values) == len(times)
                assert values.shape[1] == (4 if path == "rotation" else 3) and times.dtype == values.dtype == np.dtype("<f4")
                assert path != "rotation" or np.allclose(np.linalg.norm(values, axis=1), 1, atol=1e-6)
                assert sampler["interpolation"] in ("STEP", "LINEAR")
                key = (channel["target"]["node"], path)
                assert key not in self.channels
                self.channels[key] = (times, values, sampler["interpolation"])

    def node(self, name: str) -> int:
        (number,) = [n for n, node in enumerate(self.json["nodes"]) if node["name"] == name and self.parent.get(n) == self.root]
        return number

    def keys(self, number: int, path: str, times: Numbers) -> Numbers:
        """The values of a node at these times, which are keys or follow them by steps."""
        constant = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}[path]
        if (number, path) not in self.channels:
            return np.tile(np.array(self.json["nodes"][number].get(path, constant), np.float32), (len(times), 1))
        at, values, interpolation = self.channels[number, path]
        before = np.maximum(np.searchsorted(at, times, side="right") - 1, 0)
        assert interpolation == "STEP" or np.array_equal(at[before], times)
        return values[before]

    def colour_of(self, mesh: int) -> str:
        (primitive,) = self.json["meshes"][mesh]["primitives"]
        return str(self.json["materials"][primitive["material"]]["name"])

    def shown_colours(self, body: str, time: float) -> set[str]:
        """The colours of the meshes below a body whose scales are not zero at this time."""
        found = set()
        rest = [self.node(body)]
        while rest:
            number = rest.pop()
            node = self.json["nodes"][number]
            if not self.keys(number, "scale", np.array([time], np.float32)).any():
                continue
            rest += node.get("children", [])
            if "mesh" in node:
                found.add(self.colour_of(node["mesh"]))
        return found
