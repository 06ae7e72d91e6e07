"""Breaking a joint of MuJoCo's kinematic tree: the body moves, with all that it carries, to a free joint in the world."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import momentree as mt
from momentree.bridge._change import unchanged
from momentree.bridge._mujoco_apply import Change
from momentree.bridge._mujoco_hold import compiled_with, recompiled
from momentree.bridge._mujoco_model import FREE, JOINT_DOFS, ConvertibleState
from momentree.bridge._mujoco_names import name_of
from momentree.bridge._mujoco_package import MjData, MjModel, MjSpec, mujoco

# What the children of a body are called in a body, and the function that adds one.
_PARTS = {"geoms": "add_geom", "joints": "add_joint", "sites": "add_site", "cameras": "add_camera", "lights": "add_light"}
_STRUCTURAL = {"bodies", "frames", "id", "parent", "frame", "signature", "compiler", "name", "plugin", *_PARTS}
# Rows of the model that must not change, and those that do because elements are numbered anew.
_ROWS = {"geoms": "geom_", "joints": "jnt_", "sites": "site_", "cameras": "cam_", "lights": "light_"}
_RENUMBERED = {"bodyid", "dofadr", "qposadr", "plasticadr", "actuatorid", "matid", "dataid", "plugin", "sameframe", "aabb"}
_REFERRING = ("actuators", "sensors", "tendons", "equalities", "excludes", "pairs", "keys", "tuples")
_UNNAMED = "~unnamed"


@dataclass
class _Move:
    """The elements of a subtree, in the order of a walk: their numbers in the old model, and what replaces them."""

    numbers: dict[str, list[int]] = field(default_factory=lambda: {name: [] for name in ("bodies", *_PARTS)})
    elements: dict[str, list[Any]] = field(default_factory=lambda: {name: [] for name in ("bodies", *_PARTS)})

    def pairs(self, kind: str) -> list[tuple[int, int]]:
        """(old, new) numbers, once the specification is compiled."""
        return [(old, int(new.id)) for old, new in zip(self.numbers[kind], self.elements[kind])]


def cut(model: MjModel, data: MjData, joint: int, spec: MjSpec, tolerance: float) -> Change:
    """Breaks a joint; see ``break_``."""
    body = int(model.jnt_bodyid[joint])
    label = f"break {name_of(model, 'joint', joint)}"
    if int(model.jnt_type[joint]) == FREE:
        raise mt.Error("a free joint cannot break", label)
    if not name_of(model, "body", body, ""):
        raise mt.Error("its body has no name", label, "give the body a name in the specification")
    state = ConvertibleState(model, data)
    edited, kept = recompiled(spec, model)
    try:
        edited.compile()  # the elements receive their numbers
        references = _References(edited)
        for key in list(edited.keys):  # their qpos will not fit
            edited.delete(key)
        move, stay, free = _edit(edited, state, body)
        left = references.left(edited)
        kept = kept.select(left["equalities"])
        new_model, new_data = compiled_with(edited, model, data, kept)
    except mt.Error:
        raise
    except (AttributeError, TypeError, ValueError, mujoco.FatalError) as error:
        raise mt.Error(f"MuJoCo cannot move the body: {str(error).strip()}", label) from None
    numbers = {old: int(each.id) for old, each in stay} | dict(move.pairs("bodies"))
    _carry_state(state, data, new_model, new_data, move, numbers, int(free.id))
    _compare(model, new_model, move, label)
    after = ConvertibleState(new_model, new_data)
    first = int(model.body_dofadr[body])
    broken = slice(first, first + int(model.body_dofnum[body]))
    released = 0.5 * float(np.sum(model.dof_armature[broken] * state.v[broken] ** 2))
    certificate = unchanged(state, label, tolerance, after.totals(after.v), _difference(state, after, numbers), released)
    if not certificate.ok:
        raise mt.Error(f"the state could not be carried over exactly: {certificate}", label)
    mujoco.mj_forward(new_model, new_data)
    return Change(certificate, new_model, new_data, edited, (), references.removed(left))


class _References:
    """Elements outside of the tree of bodies, some of which refer to it. Those without names are given one until ``left``."""

    def __init__(self, spec: MjSpec) -> None:
        self._numbers: dict[str, dict[str, int]] = {}
        for kind in _REFERRING:
            for i, each in enumerate(getattr(spec, kind)):
                each.name = each.name or f"{_singular(kind)} {i}{_UNNAMED}"
            self._numbers[kind] = {str(each.name): i for i, each in enumerate(getattr(spec, kind))}

    def left(self, spec: MjSpec) -> dict[str, list[int]]:
        """The former numbers of the elements that are left."""
        found = {}
        for kind in _REFERRING:
            found[kind] = [self._numbers[kind][str(each.name)] for each in getattr(spec, kind)]
            for each in getattr(spec, kind):
                each.name = "" if str(each.name).endswith(_UNNAMED) else each.name
        return found

    def removed(self, left: dict[str, list[int]]) -> tuple[str, ...]:
        """What is not left: ``actuator elbow``, ``sensor 3``."""
        names = []
        for kind, numbers in self._numbers.items():
            for name in (name for name, number in numbers.items() if number not in left[kind]):
                names.append(name.removesuffix(_UNNAMED) if name.endswith(_UNNAMED) else f"{_singular(kind)} {name}")
        return tuple(names)


def _singular(kind: str) -> str:
    return "equality" if kind == "equalities" else kind[:-1]


def _edit(edited: MjSpec, state: ConvertibleState, body: int) -> tuple[_Move, list[tuple[int, Any]], Any]:
    """Moves the body; returns the moved elements, the other bodies with their numbers, and the new joint."""
    old = next(each for each in edited.bodies if int(each.id) == body)
    move = _Move()
    for each in _subtree(old):
        move.numbers["bodies"].append(int(each.id))
        for kind in _PARTS:
            move.numbers[kind] += [int(part.id) for part in getattr(each, kind) if each is not old or kind != "joints"]
    inside = set(move.numbers["bodies"])
    stay = [(int(each.id), each) for each in edited.bodies if int(each.id) not in inside]
    new = _copy_body(edited, edited.worldbody, old, move, joints=False)
    new.pos, new.quat = state.position(body), state.quaternion(body)
    new.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    taken = {str(each.name) for each in edited.joints}
    names = (f"{new.name}~free{'' if k == 0 else k}" for k in range(len(taken) + 1))
    free = new.add_freejoint(name=next(each for each in names if each not in taken))
    free.align = mujoco.mjtAlignFree.mjALIGNFREE_FALSE
    edited.delete(old)  # with it goes what refers to its joints; everything else finds the copies by name
    return move, stay, free


def _subtree(body: Any) -> Iterator[Any]:
    yield body
    for child in body.bodies:
        yield from _subtree(child)


def _copy_body(spec: MjSpec, parent: Any, old: Any, move: _Move, joints: bool = True) -> Any:
    """Copies a body with all that it carries. The copy takes over the names, so that what refers to them refers to the copy."""
    new = parent.add_body(name=_take_name(old))
    _copy_attributes(old, new)
    move.elements["bodies"].append(new)
    for kind, add in _PARTS.items():
        for part in getattr(old, kind) if joints or kind != "joints" else ():
            copy = getattr(new, add)()
            copy.name = _take_name(part)
            _copy_attributes(part, copy)
            _copy_frame(new, part, copy)
            move.elements[kind].append(copy)
    for child in old.bodies:
        copy = _copy_body(spec, new, child, move)
        _copy_frame(new, child, copy)
    return new


def _take_name(element: Any) -> str:
    name = str(element.name)
    if name:
        element.name = f"{name}~broken"
    return name


def _copy_frame(body: Any, old: Any, new: Any) -> None:
    """Puts the copy into a copy of the frame that the element is in. Each element receives its own; they are placements only."""
    if old.frame is None:
        return
    frame = body.add_frame()
    _copy_attributes(old.frame, frame)
    _copy_frame(body, old.frame, frame)
    new.set_frame(frame)


def _copy_attributes(old: Any, new: Any) -> None:
    plugin = getattr(old, "plugin", None)
    if plugin is not None and plugin.active:
        raise mt.Error("a part of the body has a plugin", str(new.name), "parts with plugins cannot be moved")
    for name in dir(old):
        value = None if name.startswith("_") or name in _STRUCTURAL else getattr(old, name)
        if value is None or callable(value):
            continue
        if name in ("alt", "ialt"):
            target = getattr(new, name)
            for part in ("type", "axisangle", "xyaxes", "zaxis", "euler"):
                setattr(target, part, getattr(value, part))
        elif name == "userdata":
            setattr(new, name, list(value))
        else:
            setattr(new, name, value)


def _carry_state(
    state: ConvertibleState, data: MjData, new_model: MjModel, new_data: MjData, move: _Move, numbers: dict[int, int], free: int
) -> None:
    """Coordinates and velocities of the joints that moved, and forces on the bodies."""
    model = state.model
    for joint, new in move.pairs("joints"):
        width = JOINT_DOFS[int(model.jnt_type[joint])]
        coordinates = 4 if width == 3 else 1
        source, target = int(model.jnt_qposadr[joint]), int(new_model.jnt_qposadr[new])
        new_data.qpos[target : target + coordinates] = data.qpos[source : source + coordinates]
        source, target = int(model.jnt_dofadr[joint]), int(new_model.jnt_dofadr[new])
        for name in ("qvel", "qfrc_applied", "qacc_warmstart"):
            getattr(new_data, name)[target : target + width] = getattr(data, name)[source : source + width]
    for old, new in numbers.items():
        new_data.xfrc_applied[new] = data.xfrc_applied[old]
    root = next(old for old, new in numbers.items() if new == int(new_model.jnt_bodyid[free]))
    at, dof = int(new_model.jnt_qposadr[free]), int(new_model.jnt_dofadr[free])
    motion = state.jacobian(root, state.position(root)) @ state.v
    new_data.qpos[at : at + 3] = state.position(root)
    new_data.qpos[at + 3 : at + 7] = state.quaternion(root)
    new_data.qvel[dof : dof + 3] = motion[:3]
    new_data.qvel[dof + 3 : dof + 6] = state.rotation(root).T @ motion[3:]


def _compare(model: MjModel, new_model: MjModel, move: _Move, label: str) -> None:
    """Checks that no number of a moved element changed, except for its place in the model and what MuJoCo derives."""
    for kind, prefix in _ROWS.items():
        for name in (each for each in dir(model) if each.startswith(prefix)):
            if name.endswith("0") or name.removeprefix(prefix) in _RENUMBERED:  # a zero: derived for the pose qpos0
                continue
            old_rows, new_rows = getattr(model, name), getattr(new_model, name)
            for old, new in move.pairs(kind) if isinstance(old_rows, np.ndarray) else ():
                if not np.allclose(old_rows[old], new_rows[new], rtol=1e-12, atol=1e-14):
                    raise mt.Error(f"{name}[{old}] would change", label, "momentree cannot move this element")
    for name in ("body_mass", "body_inertia", "body_ipos", "body_iquat", "body_gravcomp"):
        for old, new in move.pairs("bodies"):
            if not np.allclose(getattr(model, name)[old], getattr(new_model, name)[new], rtol=1e-12, atol=1e-14):
                raise mt.Error(f"{name}[{old}] would change", label, "momentree cannot move this body")


def _difference(state: ConvertibleState, after: ConvertibleState, numbers: dict[int, int]) -> float:
    """The largest change of a pose or a velocity of a body, relative to the largest velocity and distance."""
    most = 0.0
    before_v, after_v = state.v, after.v
    speeds = {old: state.jacobian(old, state.position(old)) @ before_v for old in numbers}
    fastest = max((float(np.linalg.norm(speed)) for speed in speeds.values()), default=0.0)
    farthest = max((float(np.linalg.norm(state.position(old))) for old in numbers), default=0.0)
    for old, new in numbers.items():
        speed = after.jacobian(new, after.position(new)) @ after_v
        if fastest > 0:
            most = max(most, float(np.linalg.norm(speed - speeds[old])) / fastest)
        most = max(most, float(np.linalg.norm(after.position(new) - state.position(old))) / max(farthest, 1.0))
        most = max(most, float(np.linalg.norm(after.rotation(new) - state.rotation(old))))
    return most
