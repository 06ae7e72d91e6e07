#!/usr/bin/env python3
"""Makes simple meshes for ur5_robot.urdf, with the lengths of its joints: the manufacturer's are not free. Needs only Python.

python3 make_meshes.py [FOLDER]
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "meshes"))
from collada import write_collada
from solids import Triangles, lathe, along_z, moved, rounded, turned

GREY, BLUE, DARK = (0.78, 0.8, 0.82), (0.35, 0.55, 0.72), (0.3, 0.32, 0.35)


def drum(radius: float, low: float, high: float, axis: str, corner: float = 0.008) -> Triangles:
    """A cylinder with rounded edges along y or z."""
    solid = lathe(rounded([(0, low, 0), (radius, low, corner), (radius, high, corner), (0, high, 0)]))
    return solid if axis == "z" else turned(solid, "x", -90)


def lid(radius: float, at: float, outwards: int, axis: str) -> Triangles:
    low, high = sorted((at, at + 0.009 * outwards))
    return drum(0.86 * radius, low, high, axis, 0.003)


def arm(length: float, r0: float, r1: float, w0: float, w1: float, tube: float) -> dict:
    """Two motors about y, at the origin and at z = length, and a tube between them."""
    motors = drum(r0, -w0, w0, "y") + moved(drum(r1, -w1, w1, "y"), z=length)
    lids = lid(r0, w0, 1, "y") + moved(lid(r1, w1, 1, "y"), z=length)
    middle = along_z(
        [
            (0.8 * r0, 1.12 * tube, 1.12 * tube),
            (0.25 * length, tube, tube),
            (0.8 * length, tube, tube),
            (length - 0.8 * r1, 1.1 * tube, 1.1 * tube),
        ],
        20,
    )
    return {"body": (GREY, motors + middle), "lids": (BLUE, lids)}


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    base = lathe(
        rounded([(0, 0, 0), (0.075, 0, 0.004), (0.075, 0.02, 0.006), (0.06, 0.035, 0.01), (0.06, 0.03, 0), (0, 0.03, 0)])
    )
    links = {
        "base": {"body": (GREY, base), "ring": (DARK, moved(lathe([(0, 0.03), (0.056, 0.03), (0.056, 0.032), (0, 0.032)])))},
        "shoulder": {
            "body": (GREY, drum(0.06, -0.055, 0.058, "z") + moved(drum(0.056, 0, 0.07, "y"))),
            "lids": (BLUE, lid(0.06, 0.058, 1, "z")),
        },
        "upperarm": arm(0.425, 0.058, 0.052, 0.064, 0.06, 0.044),
        "forearm": arm(0.39225, 0.05, 0.041, 0.058, 0.045, 0.036),
        "wrist1": {
            "body": (GREY, drum(0.041, 0.046, 0.062, "y") + moved(drum(0.041, -0.045, 0.045, "z"), y=0.093)),
            "lids": (BLUE, moved(lid(0.041, -0.045, -1, "z"), y=0.093)),
        },
        "wrist2": {
            "body": (GREY, drum(0.041, 0.046, 0.06, "z") + moved(drum(0.041, -0.045, 0.045, "y"), z=0.09465)),
            "lids": (BLUE, moved(lid(0.041, -0.045, -1, "y"), z=0.09465)),
        },
        "wrist3": {"flange": (DARK, drum(0.037, 0.046, 0.0823, "y", 0.004))},
    }
    for name, parts in links.items():
        write_collada(folder / f"{name}.dae", parts)


if __name__ == "__main__":
    here = Path(__file__).parent / "robots/ur_description/meshes/ur5/visual"
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else here)
