"""How MuJoCo goes on holding a change: equality constraints that are activated in the present pose, or added to the model."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

import momentree as mt
from momentree.bridge._mujoco_model import BALL, FREE, inverse, product
from momentree.bridge._mujoco_names import CONNECT, JOINT, WELD, between, body_of, holding, name_of, number_of
from momentree.bridge._mujoco_package import MjData, MjModel, MjSpec, mujoco
from momentree.bridge._mujoco_state import State
from momentree.bridge.certificate import FloatArray

JOINT_OBJECT = int(mujoco.mjtObj.mjOBJ_JOINT)


_SINCE = (3, 17)
"""The version of MuJoCo whose ``MjSpec.copy_back`` keeps all that was changed in a model, or refuses."""


@dataclass(frozen=True)
class Hold:
    """An equality constraint that holds from now on, in terms of the present pose."""

    kind: int
    one: int
    """A body or, if ``kind`` is a joint's, a joint."""
    two: int
    """The other body; -1 for a joint."""
    point: FloatArray = field(default_factory=lambda: np.zeros(3))
    """The anchor of a connect, world coordinates."""

    def data(self, state: State, flipped: bool, before: FloatArray) -> FloatArray:
        """The row of ``model.eq_data``; ``flipped`` if the constraint names the bodies in the opposite order."""
        row = np.array(before, dtype=np.float64)
        first, second = (self.two, self.one) if flipped else (self.one, self.two)
        if self.kind == JOINT:
            address = int(state.model.jnt_qposadr[self.one])
            row[:] = 0.0
            row[0] = state.data.qpos[address] - state.model.qpos0[address]
        elif self.kind == CONNECT:
            row[0:3] = state.rotation(first).T @ (self.point - state.position(first))
            row[3:6] = state.rotation(second).T @ (self.point - state.position(second))
        else:  # the anchor, in the second body, and the scale of torques stay as they are
            anchor = state.position(second) + state.rotation(second) @ row[0:3]
            row[3:6] = state.rotation(first).T @ (anchor - state.position(first))
            row[6:10] = product(inverse(state.quaternion(first)), state.quaternion(second))
            row[11:] = 0.0  # the pose is explicit: mj_setConst does not replace it by the one of qpos0
        return row


@dataclass(frozen=True)
class Stiffness:
    """Solver parameters that a constraint receives; None keeps those of the model."""

    solref: Sequence[float] | None = None
    solimp: Sequence[float] | None = None


def find(model: MjModel, data: MjData, holds: Sequence[Hold], given: str | int | Sequence[str | int] | None) -> list[int]:
    """The inactive equality constraints of the model that can take over these holds.

    Raises:
        mt.Error: if the model has none, with the line of MJCF that declares one.
    """
    check_enabled(model)
    names = [given] if isinstance(given, (str, int)) else list(given or [])
    found = [number_of(model, "equality", name) for name in names]
    if not found:
        for hold in holds:
            fitting = [i for i in _candidates(model, hold) if not data.eq_active[i] and i not in found]
            if not fitting:
                raise mt.Error(_missing(model, data, hold), "mujoco", _advice(model, hold))
            found.append(fitting[0])
    if len(found) != len(holds):
        raise mt.Error(f"this change needs {len(holds)} equality constraints, not {len(found)}", "mujoco")
    for i, hold in zip(found, holds):
        if i not in _candidates(model, hold):
            raise mt.Error(f"{name_of(model, 'equality', i)} cannot hold this change", "mujoco", _advice(model, hold))
        if data.eq_active[i]:
            raise mt.Error(f"{name_of(model, 'equality', i)} is active already", "mujoco", "deactivate it with break_ or unlock")
    return found


def activate(
    model: MjModel, data: MjData, state: State, holds: Sequence[Hold], found: Sequence[int], stiffness: Stiffness
) -> None:
    """Writes the present pose into the constraints and activates them. Does not fail."""
    for i, hold in zip(found, holds):
        flipped = hold.kind != JOINT and int(model.eq_obj1id[i]) != hold.one
        model.eq_data[i] = hold.data(state, flipped, np.array(model.eq_data[i]))
        if stiffness.solref is not None:
            model.eq_solref[i] = stiffness.solref
        if stiffness.solimp is not None:
            model.eq_solimp[i] = stiffness.solimp
        data.eq_active[i] = 1


def check_stiffness(stiffness: Stiffness) -> None:
    """Checks the lengths of the solver parameters.

    Raises:
        mt.Error: if a length is wrong.
    """
    for name, values, length in (("solref", stiffness.solref, 2), ("solimp", stiffness.solimp, 5)):
        if values is not None and (len(values) != length or not np.all(np.isfinite(values))):
            raise mt.Error(f"{name} has {length} finite numbers", "mujoco")


def check_enabled(model: MjModel) -> None:
    """Checks that the model has not switched equality constraints off.

    Raises:
        mt.Error: if it has.
    """
    off = int(mujoco.mjtDisableBit.mjDSBL_EQUALITY) | int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    if int(model.opt.disableflags) & off:
        raise mt.Error("model.opt.disableflags switches equality constraints off", "mujoco", "then MuJoCo cannot hold the change")


def declare(spec: MjSpec, model: MjModel, hold: Hold, name: str, active: bool) -> None:
    """Adds the equality constraint of a hold to a specification that matches the model."""
    joint = hold.kind == JOINT
    kinds = {CONNECT: mujoco.mjtEq.mjEQ_CONNECT, WELD: mujoco.mjtEq.mjEQ_WELD, JOINT: mujoco.mjtEq.mjEQ_JOINT}
    element = "joint" if joint else "body"
    names = [name_of(model, element, each, "") for each in ((hold.one,) if joint else (hold.one, hold.two))]
    if not all(names):
        raise mt.Error(f"a {element} has no name", "mujoco", "constraints refer to names: give it one in the specification")
    added = spec.add_equality(
        name=name,
        type=kinds[hold.kind],
        objtype=mujoco.mjtObj.mjOBJ_JOINT if joint else mujoco.mjtObj.mjOBJ_BODY,
        name1=names[0],
        name2="" if joint else names[1],
        active=active,
    )
    data = np.zeros(len(added.data))
    if not joint:
        data[6], data[10] = 1.0, 1.0
    added.data[:] = data


def reserve(
    spec: MjSpec,
    welds: Sequence[tuple[str, str | None]],
    balls: Sequence[tuple[str, str | None]],
    hinges: Sequence[tuple[str, str | None]],
    locks: Sequence[str],
) -> list[str]:
    """Adds inactive equality constraints to a specification; returns their names.

    Raises:
        mt.Error: if a body or joint does not exist or has no name. Nothing has changed then.
    """
    present = spec.copy().compile()
    holds = []
    for kind, pairs, number in ((WELD, welds, 1), (CONNECT, balls, 1), (CONNECT, hinges, 2)):
        for pair in pairs:
            one, two = (body_of(present, each) for each in pair)
            if one == two:
                raise mt.Error("a body cannot be joined to itself", name_of(present, "body", one))
            holds += [Hold(kind, one, two)] * number
    for joint in locks:
        number = number_of(present, "joint", joint)
        body = int(present.jnt_bodyid[number])
        rotating = int(present.jnt_type[number]) in (BALL, FREE)
        holds.append(Hold(WELD, body, int(present.body_parentid[body])) if rotating else Hold(JOINT, number, -1))
    for target in (spec.copy(), spec):  # the first one finds the mistakes
        names = []
        for hold in holds:
            names.append(free_name(target, label_of(present, hold)))
            declare(target, present, hold, names[-1], False)
    return names if holds else []


def label_of(model: MjModel, hold: Hold) -> str:
    """The name that a new constraint receives if it is free."""
    if hold.kind == JOINT:
        return f"lock {name_of(model, 'joint', hold.one)}"
    return f"{name_of(model, 'body', hold.two)}+{name_of(model, 'body', hold.one)}"


def free_name(spec: MjSpec, wanted: str) -> str:
    """A name that no equality constraint of the specification has."""
    taken = {str(each.name) for each in spec.equalities}
    return next(name for name in (wanted if k == 0 else f"{wanted}.{k}" for k in range(len(taken) + 1)) if name not in taken)


@dataclass(frozen=True)
class Equalities:
    """The numbers of equality constraints, which a specification cannot express completely."""

    rows: dict[str, FloatArray]

    def select(self, numbers: Sequence[int]) -> Equalities:
        """Some of the constraints."""
        return Equalities({name: rows[list(numbers)] for name, rows in self.rows.items()})


def recompiled(spec: MjSpec, model: MjModel) -> tuple[MjSpec, Equalities]:
    """A copy of the specification, with the numbers that were changed in the model since it was compiled.

    Raises:
        mt.Error: if the model was not compiled from this specification.
    """
    if tuple(int(part) for part in str(mujoco.__version__).split(".")[:2]) < _SINCE:
        raise mt.Error(f"spec= needs MuJoCo {_SINCE[0]}.{_SINCE[1]} or later", f"MuJoCo {mujoco.__version__}")
    edited = spec.copy()
    kept = {name: np.array(getattr(model, name)) for name in ("eq_data", "eq_solref", "eq_solimp")}
    try:
        plain = copy.copy(model)
        compiled = spec.copy().compile()
        if compiled.neq == model.neq:
            plain.eq_data[:] = compiled.eq_data
        edited.copy_back(plain)
    except (ValueError, mujoco.FatalError) as error:
        raise mt.Error(
            f"the model does not match the specification: {str(error).strip()}",
            "mujoco",
            "pass the specification from which this model was compiled, without later edits",
        ) from None
    return edited, Equalities(kept)


def compiled_with(edited: MjSpec, model: MjModel, data: MjData, kept: Equalities) -> tuple[MjModel, MjData]:
    """The model of an edited specification, in the state of ``data``; ``kept`` are its first equality constraints.

    Raises:
        mt.Error: if MuJoCo refuses the specification.
    """
    try:
        new_model, new_data = edited.recompile(model, data)
    except (ValueError, mujoco.FatalError) as error:
        raise mt.Error(f"MuJoCo refuses the edited specification: {str(error).strip()}", "mujoco") from None
    for name, rows in kept.rows.items():
        getattr(new_model, name)[: len(rows)] = rows
    return new_model, new_data


def _candidates(model: MjModel, hold: Hold) -> list[int]:
    if hold.kind == JOINT:
        return holding(model, hold.one)
    return between(model, hold.kind, hold.one, hold.two)


def _missing(model: MjModel, data: MjData, hold: Hold) -> str:
    kind = {CONNECT: "connect", WELD: "weld", JOINT: "joint"}[hold.kind]
    if hold.kind == JOINT:
        what = f"joint '{name_of(model, 'joint', hold.one)}'"
    else:
        what = f"'{name_of(model, 'body', hold.one)}' and '{name_of(model, 'body', hold.two)}'"
    if any(data.eq_active[i] for i in _candidates(model, hold)):
        return f"every {kind} constraint of {what} is active already"
    return f"the model has no inactive {kind} constraint of {what}"


def _advice(model: MjModel, hold: Hold) -> str:
    if hold.kind == JOINT:
        element = f'<joint joint1="{name_of(model, "joint", hold.one)}" active="false"/>'
    else:
        word = "weld" if hold.kind == WELD else "connect"
        anchor = "" if hold.kind == WELD else ' anchor="0 0 0"'
        one, two = name_of(model, "body", hold.one), name_of(model, "body", hold.two)
        element = f'<{word} body1="{one}" body2="{two}"{anchor} active="false"/>'
    return f"declare {element} in <equality>, or use reserve(), or pass spec= to have it added now"
