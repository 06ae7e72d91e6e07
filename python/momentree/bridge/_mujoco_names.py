"""Elements of a MuJoCo model by name or number."""

from __future__ import annotations

import difflib

import numpy as np

import momentree as mt
from momentree.bridge._mujoco_package import MjModel, mujoco
from momentree.bridge._mujoco_state import WORLD

EQ_BODY = int(mujoco.mjtObj.mjOBJ_BODY)
CONNECT = int(mujoco.mjtEq.mjEQ_CONNECT)
WELD = int(mujoco.mjtEq.mjEQ_WELD)
JOINT = int(mujoco.mjtEq.mjEQ_JOINT)

_KINDS = {
    "body": (mujoco.mjtObj.mjOBJ_BODY, "nbody"),
    "joint": (mujoco.mjtObj.mjOBJ_JOINT, "njnt"),
    "equality": (mujoco.mjtObj.mjOBJ_EQUALITY, "neq"),
}


def number_of(model: MjModel, kind: str, element: str | int) -> int:
    """The number of a body, a joint or an equality constraint.

    Raises:
        mt.Error: if there is none of that name or number.
    """
    code, size = _KINDS[kind]
    count = int(getattr(model, size))
    if isinstance(element, (int, np.integer)) and not isinstance(element, bool):
        if not 0 <= element < count:
            raise mt.Error(f"there is no {kind} {element}", "mujoco", f"the model has {count}, numbered from 0")
        return int(element)
    if not isinstance(element, str):
        raise mt.Error(f"a {kind} is given by its name or its number, not by {type(element).__name__}", "mujoco")
    found = int(mujoco.mj_name2id(model, int(code), element))
    if found < 0:
        known = [name for name in (name_of(model, kind, i, "") for i in range(count)) if name]
        near = difflib.get_close_matches(element, known, 1)
        raise mt.Error(f"there is no {kind} '{element}'", "mujoco", f"did you mean '{near[0]}'?" if near else "")
    return found


def body_of(model: MjModel, element: str | int | None) -> int:
    """The number of a body; 0 for None, ``"ground"`` and ``"world"``."""
    if element is None or element == "ground" and mujoco.mj_name2id(model, int(mujoco.mjtObj.mjOBJ_BODY), "ground") < 0:
        return WORLD
    return number_of(model, "body", element)


def name_of(model: MjModel, kind: str, number: int, otherwise: str | None = None) -> str:
    """The name of an element; ``otherwise`` (or the kind and the number) if it has none."""
    found = mujoco.mj_id2name(model, int(_KINDS[kind][0]), number)
    return str(found) if found else otherwise if otherwise is not None else f"{kind} {number}"


def between(model: MjModel, kind: int, body: int, to: int) -> list[int]:
    """The equality constraints of this kind that connect the frames of two bodies, in either order."""
    return [
        i
        for i in range(int(model.neq))
        if int(model.eq_type[i]) == kind
        and int(model.eq_objtype[i]) == EQ_BODY
        and {int(model.eq_obj1id[i]), int(model.eq_obj2id[i])} == {body, to}
    ]


def holding(model: MjModel, joint: int) -> list[int]:
    """The equality constraints that hold a hinge or slide joint in one position."""
    return [
        i
        for i in range(int(model.neq))
        if int(model.eq_type[i]) == JOINT and int(model.eq_obj1id[i]) == joint and int(model.eq_obj2id[i]) < 0
    ]
