#!/usr/bin/env python3
"""Makes the meshes of grinder_arm.urdf, one in each format that momentree reads. Needs only Python.

python3 make_meshes.py [FOLDER]
"""

import struct
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "meshes"))
from collada import write_collada
from gltf import write_glb
from solids import Triangles, indexed, lathe, link, moved, rounded, turned


def about_y(triangles: Triangles) -> Triangles:
    """Turns z to y."""
    return turned(triangles, "x", -90)


def disc(radius: float, width: float) -> Triangles:
    edge = 0.004
    return lathe(rounded([(0, -width / 2, 0), (radius, -width / 2, edge), (radius, width / 2, edge), (0, width / 2, 0)]))


def write_stl(path: Path, triangles: Triangles) -> None:
    with open(path, "wb") as file:
        file.write(b"a base".ljust(80, b"\0") + struct.pack("<I", len(triangles)))
        for t in triangles:
            file.write(struct.pack("<12f", 0, 0, 0, *(c for p in t for c in p)) + b"\0\0")


def write_obj(path: Path, parts: dict) -> None:
    text, first = f"mtllib {path.stem}.mtl\n", 1
    for name, triangles in parts.items():
        points, corners = indexed(triangles)
        text += f"o {name}\nusemtl {name}\n" + "".join("v {:g} {:g} {:g}\n".format(*p) for p in points)
        text += "".join("f {} {} {}\n".format(*(first + c for c in t)) for t in corners)
        first += len(points)
    path.write_text(text)


def main(folder: Path) -> None:
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
    upper = {"upper": ((0.93, 0.55, 0.13), link(0.4, 0.062, 0.05, 0.07)), "bolts": ((0.35, 0.37, 0.4), eyes)}
    write_collada(folder / "upper_arm.dae", upper)

    fore = link(0.32, 0.048, 0.034, 0.055, 0.006)
    fore += moved(lathe(rounded([(0, 0, 0), (0.03, 0, 0.004), (0.03, 0.06, 0.006), (0, 0.06, 0)])), z=0.32)
    write_obj(folder / "forearm.obj", {"paint": fore})
    (folder / "forearm.mtl").write_text("newmtl paint\nKd 0.93 0.55 0.13\n")

    body = lathe(
        rounded([(0, 0, 0), (0.028, 0, 0.004), (0.034, 0.05, 0.01), (0.034, 0.15, 0.012), (0.02, 0.17, 0.005), (0, 0.17, 0)])
    )
    wheel = moved(lathe(rounded([(0, -0.006, 0), (0.075, -0.006, 0.002), (0.075, 0.006, 0.002), (0, 0.006, 0)])), z=0.185)
    hub = moved(lathe(rounded([(0, -0.012, 0), (0.018, -0.012, 0.002), (0.018, 0.012, 0.002), (0, 0.012, 0)])), z=0.19)
    write_glb(
        folder / "grinder.glb",
        {"#276092": body, "#514747": wheel, "#bcbcbf": hub},
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "meshes")
