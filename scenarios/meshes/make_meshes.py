#!/usr/bin/env python3
"""Makes the meshes of the scenarios in the folder above. Needs only Python.

python3 make_meshes.py [FOLDER]
"""

import sys
from pathlib import Path

from bodies import climbing_robot, knee, trapeze
from gltf import write_glb
from machines import chain_to_ring, crane, excavator, motion_platform, tower, wind_turbine
from spacecraft import debris_capture, satellite

MADE = [
    chain_to_ring,
    climbing_robot,
    crane,
    debris_capture,
    excavator,
    knee,
    motion_platform,
    satellite,
    tower,
    trapeze,
    wind_turbine,
]


def main(folder: Path) -> None:
    for make in MADE:
        into = folder / make.__name__
        into.mkdir(parents=True, exist_ok=True)
        for name, parts in make().items():
            write_glb(into / f"{name}.glb", parts)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
