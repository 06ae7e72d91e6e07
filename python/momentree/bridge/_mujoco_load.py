"""What a connection of a MuJoCo simulation bears, and the instant at which it bears too much."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import momentree as mt
from momentree.bridge._mujoco_names import CONNECT, WELD, body_of, name_of, number_of
from momentree.bridge._mujoco_package import MjData, MjModel, mujoco
from momentree.bridge.certificate import Wrench

_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)


@dataclass(frozen=True)
class Crossing:
    """How ``step_until`` ended."""

    happened: bool
    """Whether the measure exceeded the threshold."""
    time: float
    """s: then, the instant at which it did; otherwise the end."""
    value: float
    """The measure at this instant."""


def reaction(model: MjModel, data: MjData, body: str | int) -> Wrench:
    """What a body receives from its parent in the kinematic tree: through joints, actuators, springs and dampers.

    ``data`` must be evaluated (``mj_forward``).

    Returns:
        The wrench, N and N m, about the origin of the body, in world axes.
    """
    number = body_of(model, body)
    if number == 0:
        raise mt.Error("the world has no parent", "reaction")
    mujoco.mj_rnePostConstraint(model, data)
    torque, force = np.array(data.cfrc_int[number][:3]), np.array(data.cfrc_int[number][3:])
    origin = np.array(data.xpos[number])
    arm = np.array(data.subtree_com[model.body_rootid[number]]) - origin
    return Wrench(force, torque + np.cross(arm, force), origin)


def load(model: MjModel, data: MjData, equality: str | int) -> Wrench:
    """What an active ``weld`` or ``connect`` constraint exerts on its first body.

    ``data`` must be evaluated (``mj_forward``).

    Returns:
        The wrench, N and N m, about the anchor of the constraint in the first body, in world axes. The second body receives the
        opposite wrench, about its own anchor.

    Raises:
        mt.Error: if the constraint is of another kind.
    """
    number = number_of(model, "equality", equality)
    kind = int(model.eq_type[number])
    if kind not in (WELD, CONNECT) or int(model.eq_objtype[number]) != int(mujoco.mjtObj.mjOBJ_BODY):
        raise mt.Error("only welds and connects of bodies have a load", name_of(model, "equality", number))
    first, second = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
    anchor = np.array(model.eq_data[number][3:6] if kind == WELD else model.eq_data[number][:3])
    point = np.array(data.xpos[first]) + np.array(data.xmat[first]).reshape(3, 3) @ anchor
    rows = _rows(data, number)
    efforts = np.array(data.efc_force)[rows]
    if len(rows) == 0:
        return Wrench(np.zeros(3), np.zeros(3), point)
    torque = np.zeros(3)
    if kind == WELD:
        # The rows of a weld are half the vector part of q2^-1 w q1 r, times the scale of torques: w is the relative velocity.
        scale = float(model.eq_data[number][10])
        one, two, relative = np.array(data.xquat[first]), np.array(data.xquat[second]), np.array(model.eq_data[number][6:10])
        for i, unit in enumerate(np.eye(3)):
            value, right = np.zeros(4), np.zeros(4)
            mujoco.mju_mulQuat(right, np.concatenate([[0.0], unit]), one)
            mujoco.mju_mulQuat(value, right, relative)
            mujoco.mju_mulQuat(right, two * np.array([1.0, -1.0, -1.0, -1.0]), value)
            torque[i] = 0.5 * scale * float(efforts[3:] @ right[1:])
    return Wrench(efforts[:3], torque, point)


def step_until(
    model: MjModel,
    data: MjData,
    measure: Callable[[MjModel, MjData], float],
    threshold: float,
    *,
    until: float = float("inf"),
    tolerance: float = 1e-9,
) -> Crossing:
    """Steps a simulation until a measure exceeds a threshold, and stops at that instant, inside of a step if need be.

    The instant is located by repeating the last step with shorter steps. ``mj_forward`` evaluates the state after each step, so
    ``measure`` sees values that belong to it.

    Args:
        model: the MuJoCo model; ``opt.timestep`` is changed for the shorter steps and restored.
        data: its state, which is left at the instant of the crossing, where the measure is above the threshold, or at ``until``.
        measure: a function of the model and the evaluated data.
        threshold: what it must exceed.
        until: s, the end if it never does.
        tolerance: s, of the instant.

    Returns:
        Whether it happened, and when.

    Raises:
        mt.Error: if the tolerance is not positive.
    """
    if not tolerance > 0:
        raise mt.Error("the tolerance is positive", "step_until")
    if until == float("inf") and model.opt.timestep <= 0:
        raise mt.Error("the time step is positive", "step_until")
    whole = float(model.opt.timestep)
    before = np.zeros(mujoco.mj_stateSize(model, _STATE))

    def advance(duration: float) -> float:
        mujoco.mj_setState(model, data, before, _STATE)
        model.opt.timestep = duration
        try:
            mujoco.mj_step(model, data)
        finally:
            model.opt.timestep = whole
        mujoco.mj_forward(model, data)
        return float(measure(model, data))

    mujoco.mj_forward(model, data)
    value = float(measure(model, data))
    while not value > threshold:
        left = until - float(data.time)
        if left <= tolerance:
            return Crossing(False, float(data.time), value)
        mujoco.mj_getState(model, data, before, _STATE)
        duration = min(whole, left)
        value = advance(duration)
        if not value > threshold:
            continue
        early, late = 0.0, duration
        while late - early > tolerance:
            middle = early + (late - early) / 2
            value = advance(middle)
            early, late = (early, middle) if value > threshold else (middle, late)
        value = advance(late)
        break
    return Crossing(True, float(data.time), value)


def _rows(data: MjData, equality: int) -> list[int]:
    kind = int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    return [i for i in range(int(data.nefc)) if int(data.efc_type[i]) == kind and int(data.efc_id[i]) == equality]
