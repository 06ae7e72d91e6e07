"""Random mechanisms for the tests of the bridges, as MJCF."""

from __future__ import annotations

from typing import Any

import mujoco  # type: ignore[import-untyped,import-not-found,unused-ignore]
import numpy as np

Rng = np.random.Generator


def _numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in np.atleast_1d(values))


def _unit(rng: Rng, size: int) -> Any:
    vector = rng.normal(size=size)
    return vector / np.linalg.norm(vector)


def _inertial(rng: Rng) -> str:
    """A box of random size, mass and placement."""
    mass = rng.uniform(0.3, 3.0)
    a, b, c = rng.uniform(0.05, 0.4, size=3) ** 2
    moments = mass / 12 * np.array([b + c, a + c, a + b])
    return (
        f'<inertial mass="{mass!r}" pos="{_numbers(rng.uniform(-0.2, 0.2, 3))}" quat="{_numbers(_unit(rng, 4))}" '
        f'diaginertia="{_numbers(moments)}"/>'
    )


def _joints(rng: Rng, body: str, root: bool) -> str:
    """None, one, or several joints of a body, never more than three rotations or three displacements."""
    kinds = [["hinge"], ["slide"], ["ball"], ["hinge", "slide"], ["hinge", "hinge"], ["slide", "ball"], ["hinge"], ["hinge"]]
    if not root:
        kinds.append([])
    lines = []
    for k, kind in enumerate(kinds[rng.integers(len(kinds))]):
        axis = "" if kind == "ball" else f' axis="{_numbers(_unit(rng, 3))}"'
        more = f' armature="{rng.uniform(0.01, 0.2)!r}"' if rng.random() < 0.3 else ""
        ref = f' ref="{rng.uniform(-1, 1)!r}"' if kind in ("hinge", "slide") and rng.random() < 0.3 else ""
        lines.append(f'<joint name="{body}.{k}" type="{kind}" pos="{_numbers(rng.uniform(-0.2, 0.2, 3))}"{axis}{more}{ref}/>')
    return "".join(lines)


def _body(rng: Rng, name: str, size: int, floating: bool, root: bool = True) -> str:
    """A random tree of ``size`` bodies, depth first."""
    place = f'pos="{_numbers(rng.uniform(-0.5, 0.5, 3))}" quat="{_numbers(_unit(rng, 4))}"'
    joints = f'<freejoint name="{name}.free"/>' if root and floating else _joints(rng, name, root)
    text = f'<body name="{name}" {place}>{_inertial(rng)}{joints}'
    left = size - 1
    child = 0
    while left > 0:
        take = int(rng.integers(1, left + 1))
        text += _body(rng, f"{name}{child}", take, floating, root=False)
        left -= take
        child += 1
    return text + "</body>"


def model_of(rng: Rng, sizes: tuple[tuple[int, bool], ...], equality: str = "") -> Any:
    """Trees ``a``, ``b``, … of random bodies: (number of bodies, whether the tree floats). Without gravity and contact."""
    trees = "".join(
        f'<body name="base{k}" pos="{_numbers(rng.uniform(-1, 1, 3))}" quat="{_numbers(_unit(rng, 4))}">'
        f"{_body(rng, chr(ord('a') + k), size, False)}</body>"
        if not floating
        else _body(rng, chr(ord("a") + k), size, True)
        for k, (size, floating) in enumerate(sizes)
    )
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0"/><worldbody>{trees}</worldbody><equality>{equality}</equality></mujoco>'
    )


def state_of(rng: Rng, model: Any) -> Any:
    """Random coordinates, quaternions that are not quite of unit length, and velocities."""
    data = mujoco.MjData(model)
    for joint in range(model.njnt):
        at, kind = model.jnt_qposadr[joint], int(model.jnt_type[joint])
        if kind in (int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)):
            free = kind == int(mujoco.mjtJoint.mjJNT_FREE)
            if free:
                data.qpos[at : at + 3] = rng.uniform(-1, 1, 3)
            start = at + 3 if free else at
            data.qpos[start : start + 4] = _unit(rng, 4)
        else:
            data.qpos[at] = rng.uniform(-1, 1)
    data.qvel[:] = rng.normal(size=model.nv)
    return data


def names(model: Any, tree: str) -> list[str]:
    """The bodies of a tree of ``model_of``."""
    found = [str(model.body(i).name) for i in range(1, model.nbody)]
    return [name for name in found if name.startswith(tree) and not name.startswith("base")]
