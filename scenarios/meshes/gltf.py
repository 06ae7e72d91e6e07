"""Writes meshes as binary glTF."""

import json
import struct
from pathlib import Path

from solids import indexed


def linear(colour: str) -> list[float]:
    """Of a colour #rrggbb."""
    levels = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    return [round(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4, 4) for c in levels]


def write_glb(path: Path, parts: dict) -> None:
    """`parts`: by colour, "#rrggbb" or "" for that of the shape, the triangles. y points up in the format."""
    buffer, views, accessors, primitives, materials = b"", [], [], [], []
    for colour, triangles in parts.items():
        points, corners = indexed(triangles)
        points = [(x, z, -y) for x, y, z in points]
        flat = [c for t in corners for c in t]
        for data, kind, target, entry in (
            (
                struct.pack(f"<{3 * len(points)}f", *(c for p in points for c in p)),
                5126,
                34962,
                {"type": "VEC3", "count": len(points)},
            ),
            (struct.pack(f"<{len(flat)}H", *flat), 5123, 34963, {"type": "SCALAR", "count": len(flat)}),
        ):
            views.append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(data), "target": target})
            accessors.append({"bufferView": len(views) - 1, "componentType": kind, **entry})
            buffer += data + bytes(-len(data) % 4)
        accessors[-2]["min"] = [min(p[k] for p in points) for k in range(3)]
        accessors[-2]["max"] = [max(p[k] for p in points) for k in range(3)]
        primitives.append({"attributes": {"POSITION": len(accessors) - 2}, "indices": len(accessors) - 1})
        if colour:
            materials.append({"name": colour[1:], "pbrMetallicRoughness": {"baseColorFactor": [*linear(colour), 1]}})
            primitives[-1]["material"] = len(materials) - 1
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}],
        **({"materials": materials} if materials else {}),
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(buffer)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I", len(text)) + b"JSON" + text + struct.pack("<I", len(buffer)) + b"BIN\0" + buffer
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
