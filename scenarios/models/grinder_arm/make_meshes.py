#!/usr/bin/env python3
"""Makes the meshes of grinder_arm.urdf, one in each format that momentree reads. Needs only Python.

    python3 make_meshes.py [FOLDER]
"""

import json
import struct
import sys
from math import acos, cos, pi, sin, sqrt
from pathlib import Path


def lathe(profile, around=32):
    """Triangles of a surface of revolution about z; profile: (radius, z) from the bottom up, each end on the axis."""
    rings = [[(r * cos(2 * pi * i / around), r * sin(2 * pi * i / around), z) for i in range(around)] for r, z in profile]
    triangles = []
    for low, high in zip(rings, rings[1:]):
        for i in range(around):
            j = (i + 1) % around
            triangles += [(low[i], low[j], high[j]), (low[i], high[j], high[i])]
    return [t for t in triangles if len(set(t)) == 3]


def rounded(profile, step=0.5):
    """A profile whose corners are quarter circles: entries (radius, z, size of the corner)."""
    points = []
    for k, (r, z, size) in enumerate(profile):
        if size == 0:
            points.append((r, z))
            continue
        (r0, z0), (r1, z1) = profile[k - 1][:2], profile[k + 1][:2]
        before, after = sqrt((r0 - r) ** 2 + (z0 - z) ** 2), sqrt((r1 - r) ** 2 + (z1 - z) ** 2)
        a = (r + (r0 - r) * size / before, z + (z0 - z) * size / before)
        b = (r + (r1 - r) * size / after, z + (z1 - z) * size / after)
        n = max(2, round(pi / 2 / step))
        points += [
            tuple((1 - s) ** 2 * p + 2 * s * (1 - s) * q + s**2 * t for p, q, t in zip(a, (r, z), b))
            for s in (i / n for i in range(n + 1))
        ]
    return points


def link(length, r0, r1, width, bevel=0.008, steps=24):
    """Two eyes about y, at the origin and at z = length, and the web between them: an outline with bevelled edges."""
    lean = acos((r0 - r1) / length)
    angles0 = [lean + (2 * pi - 2 * lean) * i / steps for i in range(steps + 1)]
    angles1 = [-lean + 2 * lean * i / steps for i in range(steps + 1)]

    def outline(y, shrink):
        far = [(sin(a) * (r1 - shrink), y, length + cos(a) * (r1 - shrink)) for a in angles1]
        return far + [(sin(a) * (r0 - shrink), y, cos(a) * (r0 - shrink)) for a in angles0]

    half = width / 2
    rings = [outline(-half, bevel), outline(-half + bevel, 0), outline(half - bevel, 0), outline(half, bevel)]
    triangles = []
    for low, high in zip(rings, rings[1:]):
        for i in range(len(low)):
            j = (i + 1) % len(low)
            triangles += [(low[i], high[j], low[j]), (low[i], high[i], high[j])]
    for ring, outside in ((rings[0], -1), (rings[-1], 1)):
        middle = (0, ring[0][1], length / 2)
        for i in range(len(ring)):
            j = (i + 1) % len(ring)
            triangles.append((middle, ring[i], ring[j]) if outside > 0 else (middle, ring[j], ring[i]))
    return [t for t in triangles if len(set(t)) == 3]


def moved(triangles, x=0, y=0, z=0):
    return [tuple((p[0] + x, p[1] + y, p[2] + z) for p in t) for t in triangles]


def about_y(triangles):
    """Turns z to y."""
    return [tuple((p[0], p[2], -p[1]) for p in t) for t in triangles]


def indexed(triangles):
    points, number = [], {}
    for t in triangles:
        for p in t:
            key = tuple(round(c, 6) + 0.0 for c in p)
            if key not in number:
                number[key] = len(points)
                points.append(key)
    return points, [[number[tuple(round(c, 6) + 0.0 for c in p)] for p in t] for t in triangles]


def disc(radius, width):
    edge = 0.004
    return lathe(
        rounded([(0, -width / 2, 0), (radius, -width / 2, edge), (radius, width / 2, edge), (0, width / 2, 0)])
    )


def write_stl(path, triangles):
    with open(path, "wb") as file:
        file.write(b"a base".ljust(80, b"\0") + struct.pack("<I", len(triangles)))
        for t in triangles:
            file.write(struct.pack("<12f", 0, 0, 0, *(c for p in t for c in p)) + b"\0\0")


def write_obj(path, parts):
    text, first = f"mtllib {path.stem}.mtl\n", 1
    for name, triangles in parts.items():
        points, corners = indexed(triangles)
        text += f"o {name}\nusemtl {name}\n" + "".join("v {:g} {:g} {:g}\n".format(*p) for p in points)
        text += "".join("f {} {} {}\n".format(*(first + c for c in t)) for t in corners)
        first += len(points)
    path.write_text(text)


def write_collada(path, parts):
    """In millimetres. parts: name: (colour, triangles)."""
    effects = materials = geometries = nodes = ""
    for name, (colour, triangles) in parts.items():
        points, corners = indexed([tuple(tuple(1000 * c for c in p) for p in t) for t in triangles])
        rgba = " ".join(map(str, colour))
        effects += (
            f'<effect id="{name}-effect"><profile_COMMON><technique sid="common"><lambert><diffuse><color>{rgba} 1</color>'
            "</diffuse></lambert></technique></profile_COMMON></effect>\n"
        )
        materials += f'<material id="{name}-material"><instance_effect url="#{name}-effect"/></material>\n'
        numbers = " ".join("{:g} {:g} {:g}".format(*p) for p in points)
        geometries += (
            f'<geometry id="{name}" name="{name}"><mesh><source id="{name}-points"><float_array id="{name}-array" '
            f'count="{3 * len(points)}">{numbers}</float_array><technique_common><accessor source="#{name}-array" '
            f'count="{len(points)}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" '
            f'type="float"/></accessor></technique_common></source><vertices id="{name}-vertices"><input '
            f'semantic="POSITION" source="#{name}-points"/></vertices><triangles material="m" count="{len(corners)}"><input '
            f'semantic="VERTEX" source="#{name}-vertices" offset="0"/><p>{" ".join(str(c) for t in corners for c in t)}</p>'
            "</triangles></mesh></geometry>\n"
        )
        nodes += (
            f'<node id="{name}-node"><instance_geometry url="#{name}"><bind_material><technique_common><instance_material '
            f'symbol="m" target="#{name}-material"/></technique_common></bind_material></instance_geometry></node>\n'
        )
    path.write_text(
        '<?xml version="1.0" encoding="utf-8"?>\n<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">\n'
        '<asset><unit name="millimetre" meter="0.001"/><up_axis>Z_UP</up_axis></asset>\n'
        f"<library_effects>{effects}</library_effects>\n<library_materials>{materials}</library_materials>\n"
        f"<library_geometries>{geometries}</library_geometries>\n"
        f'<library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>\n'
        '<scene><instance_visual_scene url="#scene"/></scene>\n</COLLADA>\n'
    )


def write_glb(path, parts):
    """y points up in the format. parts: name: (linear colour, triangles)."""
    buffer, views, accessors, primitives, materials = b"", [], [], [], []
    for name, (colour, triangles) in parts.items():
        points, corners = indexed(triangles)
        points = [(x, z, -y) for x, y, z in points]
        flat = [c for t in corners for c in t]
        for data, kind, target, entry in (
            (struct.pack(f"<{3 * len(points)}f", *(c for p in points for c in p)), 5126, 34962, {"type": "VEC3", "count": len(points)}),
            (struct.pack(f"<{len(flat)}H", *flat), 5123, 34963, {"type": "SCALAR", "count": len(flat)}),
        ):
            views.append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(data), "target": target})
            accessors.append({"bufferView": len(views) - 1, "componentType": kind, **entry})
            buffer += data + bytes(-len(data) % 4)
        accessors[-2]["min"] = [min(p[k] for p in points) for k in range(3)]
        accessors[-2]["max"] = [max(p[k] for p in points) for k in range(3)]
        materials.append({"name": name, "pbrMetallicRoughness": {"baseColorFactor": [*colour, 1]}})
        primitives.append({"attributes": {"POSITION": len(accessors) - 2}, "indices": len(accessors) - 1, "material": len(materials) - 1})
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}],
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(buffer)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I", len(text)) + b"JSON" + text + struct.pack("<I", len(buffer)) + b"BIN\0" + buffer
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    base = [(0, 0, 0), (0.13, 0, 0.004), (0.13, 0.025, 0.008), (0.08, 0.04, 0.02), (0.075, 0.13, 0.01), (0, 0.135, 0)]
    write_stl(folder / "base.stl", lathe(rounded(base)))

    turret = lathe(rounded([(0, 0, 0), (0.072, 0, 0.006), (0.072, 0.05, 0.02), (0.045, 0.09, 0.01), (0, 0.09, 0)]))
    turret += moved(about_y(disc(0.06, 0.10)), z=0.09)
    shoulder_bolts = moved(about_y(disc(0.032, 0.012)), y=0.051, z=0.09) + moved(about_y(disc(0.032, 0.012)), y=-0.051, z=0.09)
    write_obj(folder / "turret.obj", {"paint": turret, "steel": shoulder_bolts})
    (folder / "turret.mtl").write_text("newmtl paint\nKd 0.93 0.55 0.13\nnewmtl steel\nKd 0.35 0.37 0.4\n")

    eyes = []
    for z, radius in ((0, 0.036), (0.4, 0.028)):
        for side in (-1, 1):
            eyes += moved(about_y(disc(radius, 0.012)), y=side * 0.036, z=z)
    upper = {"upper": ((0.93, 0.55, 0.13), moved(link(0.4, 0.062, 0.05, 0.07), y=0)), "bolts": ((0.35, 0.37, 0.4), eyes)}
    write_collada(folder / "upper_arm.dae", upper)

    fore = link(0.32, 0.048, 0.034, 0.055, 0.006)
    fore += moved(lathe(rounded([(0, 0, 0), (0.03, 0, 0.004), (0.03, 0.06, 0.006), (0, 0.06, 0)])), z=0.32)
    write_obj(folder / "forearm.obj", {"paint": fore})
    (folder / "forearm.mtl").write_text("newmtl paint\nKd 0.93 0.55 0.13\n")

    body = lathe(rounded([(0, 0, 0), (0.028, 0, 0.004), (0.034, 0.05, 0.01), (0.034, 0.15, 0.012), (0.02, 0.17, 0.005), (0, 0.17, 0)]))
    wheel = moved(lathe(rounded([(0, -0.006, 0), (0.075, -0.006, 0.002), (0.075, 0.006, 0.002), (0, 0.006, 0)])), z=0.185)
    hub = moved(lathe(rounded([(0, -0.012, 0), (0.018, -0.012, 0.002), (0.018, 0.012, 0.002), (0, 0.012, 0)])), z=0.19)
    write_glb(
        folder / "grinder.glb",
        {"body": ((0.02, 0.12, 0.35), body), "wheel": ((0.08, 0.06, 0.06), wheel), "hub": ((0.5, 0.5, 0.52), hub)},
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "meshes")
