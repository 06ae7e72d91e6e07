"""Topology changes of Drake simulations: exact velocities with a certificate.

    from momentree.bridge import drake as bridge

    certificate = bridge.lock(plant, context, "elbow")

A Drake plant cannot be edited after ``Finalize``. So there are two ways to go on after a change:

- What Drake can hold by itself: locked joints (``lock``), and constraints that were declared in advance for the pose in which
  they will be used (``reserve``, ``weld`` with ``constraint``).
- A new plant that has the new topology. ``weld`` and ``attach`` give the velocities, and ``transfer`` carries the state over to
  the new plant and checks that every body moves as before.

Functions either do all of this or raise ``mt.Error`` and change nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

import momentree as mt
from momentree.bridge._change import Request, solve, unchanged
from momentree.bridge._drake_package import Context, MultibodyPlant, tree
from momentree.bridge._drake_state import WORLD, DrakeState, Reserved
from momentree.bridge._drake_transfer import transfer
from momentree.bridge.certificate import Certificate, FloatArray, Method, Totals, Wrench
from momentree.bridge.projection import Rows

__all__ = [
    "Certificate",
    "Reserved",
    "Totals",
    "Wrench",
    "attach",
    "break_",
    "impulse",
    "lock",
    "reserve",
    "transfer",
    "unlock",
    "weld",
]


def reserve(plant: MultibodyPlant, body: Any, to: Any, pose: Any, other: Any, *, ball: bool = False) -> Reserved:
    """Adds a constraint to a plant before ``Finalize``, for a later ``weld`` or ``attach`` in the pose that it holds.

    The plant must be discrete, with the SAP solver. The constraint is active in new contexts: ``break_`` deactivates it.

    Args:
        plant: a plant that is not finalised.
        body: a body (or its name).
        to: another one.
        pose: a frame in ``body``, a RigidTransform.
        other: the frame in ``to`` that coincides with it while the constraint is active.
        ball: only the origins of the frames coincide.

    Raises:
        mt.Error: if Drake refuses.
    """
    one, two = _element(plant, body), _element(plant, to)
    try:
        if ball:
            number = plant.AddBallConstraint(one, pose.translation(), two, other.translation())
        else:
            number = plant.AddWeldConstraint(one, pose, two, other)
    except RuntimeError as error:
        raise mt.Error(f"Drake refuses the constraint: {error}", "reserve") from None
    return Reserved(number, one, two, pose, other, ball)


def weld(
    plant: MultibodyPlant,
    context: Context,
    body: Any,
    to: Any = None,
    *,
    constraint: Reserved | None = None,
    reserved: Sequence[Reserved] = (),
    method: Method = "auto",
    tolerance: float = 1e-12,
) -> Certificate:
    """The velocities after two bodies are joined rigidly in their present pose, by a perfectly plastic impact.

    Args:
        plant: a finalised plant.
        context: its context; the velocities change.
        body: a body (or its name).
        to: another one; None is the world.
        constraint: a constraint from ``reserve`` that holds the bodies from now on; its frames must coincide, to 1e-9 m and rad.
        reserved: all constraints from ``reserve`` that are active in the context.
        method: how to compute the velocities.
        tolerance: the largest relative error in the certificate.

    Raises:
        mt.Error: nothing has changed then.
    """
    state, one, two = _pair(plant, context, body, to, reserved)
    point = state.position(one)
    request = Request(
        f"weld {_name(plant, one)} to {_name(plant, two)}",
        (one, two),
        state.relative(one, two, point),
        point,
        np.eye(6),
        lambda sim: sim.apply(mt.weld(state.body_name(one), state.body_name(two))),
    )
    return _finish(state, request, constraint, method, tolerance)


def attach(
    plant: MultibodyPlant,
    context: Context,
    body: Any,
    to: Any = None,
    *,
    at: Sequence[float] | None = None,
    axis: Sequence[float] | None = None,
    constraint: Reserved | None = None,
    reserved: Sequence[Reserved] = (),
    method: Method = "auto",
    tolerance: float = 1e-12,
) -> Certificate:
    """The velocities after two bodies are joined by a ball joint or, if there is an axis, by a hinge.

    Args:
        plant: a finalised plant.
        context: its context; the velocities change.
        body: a body (or its name).
        to: another one; None is the world.
        at: (3,) m, the joint in the frame of ``to``; default: the origin of ``body``.
        axis: (3,) the axis of a hinge, in the frame of ``to``.
        constraint: a ball constraint from ``reserve`` that holds the bodies from now on.
        reserved: all constraints from ``reserve`` that are active in the context.
        method: how to compute the velocities.
        tolerance: the largest relative error in the certificate.

    Raises:
        mt.Error: nothing has changed then.
    """
    first, second = (WORLD if each is None else int(_element(plant, each).index()) for each in (body, to))
    state, one, two = _pair(plant, context, body, to, reserved)
    turn = state.rotation(second)
    point = state.position(first) if at is None else state.position(second) + turn @ _three(at, "at")
    still = state.root(two) == WORLD
    frame = np.eye(3) if still else state.rotation(two)
    local = frame.T @ (point - (np.zeros(3) if still else state.position(two)))
    relative, selection = state.relative(one, two, point), np.eye(6)[:3]
    joint: mt.JointSpec = mt.Ball()
    if axis is not None:
        given = _three(axis, "axis")
        if not np.linalg.norm(given) > 0:
            raise mt.Error("the axis of a hinge is not zero", "attach")
        along = turn @ (given / np.linalg.norm(given))
        across = np.linalg.svd(along[None, :])[2][1:]
        selection = np.vstack([selection, np.hstack([np.zeros((2, 3)), across])])
        joint = mt.Revolute(axis=tuple(frame.T @ along))
    request = Request(
        f"attach {_name(plant, first)} to {_name(plant, second)}",
        (one, two),
        Rows(selection @ relative.matrix, np.abs(selection) @ relative.scale),
        point,
        selection.T,
        lambda sim: sim.apply(mt.attach(state.body_name(one), state.body_name(two), joint, at=tuple(local))),
    )
    return _finish(state, request, constraint, method, tolerance)


def lock(
    plant: MultibodyPlant,
    context: Context,
    joint: Any,
    *,
    reserved: Sequence[Reserved] = (),
    method: Method = "auto",
    tolerance: float = 1e-12,
) -> Certificate:
    """Stops a joint in its present position with the impulse that this takes, and locks it (``Joint.Lock``).

    ``Joint.Lock`` alone only sets the velocities of this joint to zero: the others keep theirs, and momentum is lost.

    Args:
        plant: a finalised plant.
        context: its context.
        joint: a joint (or its name).
        reserved: all constraints from ``reserve`` that are active in the context.
        method: how to compute the velocities.
        tolerance: the largest relative error in the certificate.

    Raises:
        mt.Error: nothing has changed then.
    """
    element = _joint(plant, joint)
    label = f"lock {element.name()}"
    if element.num_velocities() == 0 or element.is_locked(context):
        raise mt.Error("the joint cannot move already", label)
    state = DrakeState(plant, context, reserved)
    child, parent = int(element.child_body().index()), int(element.parent_body().index())
    moving = slice(element.velocity_start(), element.velocity_start() + element.num_velocities())
    rows = np.eye(len(state.v))[moving]
    point = np.array(element.frame_on_child().CalcPoseInWorld(context).translation())
    # The impulse along the DoFs as a wrench: the one that does the same work on every relative velocity that the joint allows.
    relative = state.relative(child, parent, point).matrix[:, moving]
    request = Request(
        label,
        (child, parent),
        Rows(rows, np.abs(rows)),
        point,
        np.asarray(np.linalg.pinv(relative).T, dtype=np.float64),
        lambda sim: sim.apply(mt.lock(state.joint_name(child))),
        joins=False,
    )
    after, certificate = solve(state, request, method, tolerance)
    after[moving] = 0.0
    plant.SetVelocities(context, after)
    element.Lock(context)
    return certificate


def unlock(plant: MultibodyPlant, context: Context, joint: Any, *, tolerance: float = 1e-12) -> Certificate:
    """Releases a locked joint (``Joint.Unlock``). No velocity changes.

    Raises:
        mt.Error: if the joint is not locked.
    """
    element = _joint(plant, joint)
    if not element.is_locked(context):
        raise mt.Error("the joint is not locked", element.name())
    certificate = unchanged(_blind(plant, context), f"unlock {element.name()}", tolerance)
    element.Unlock(context)
    return certificate


def break_(plant: MultibodyPlant, context: Context, constraint: Reserved, *, tolerance: float = 1e-12) -> Certificate:
    """Deactivates a constraint. No velocity changes. To break a joint, build a plant without it and use ``transfer``.

    Raises:
        mt.Error: if the constraint is not active.
    """
    if not plant.GetConstraintActiveStatus(context, constraint.constraint):
        raise mt.Error("the constraint is not active", "break_")
    label = f"break {constraint.body.name()} from {constraint.to.name()}"
    certificate = unchanged(_blind(plant, context), label, tolerance)
    plant.SetConstraintActiveStatus(context, constraint.constraint, False)
    return certificate


def impulse(
    plant: MultibodyPlant,
    context: Context,
    body: Any,
    force: Sequence[float] = (0.0, 0.0, 0.0),
    torque: Sequence[float] = (0.0, 0.0, 0.0),
    point: Sequence[float] = (0.0, 0.0, 0.0),
    *,
    reserved: Sequence[Reserved] = (),
    method: Method = "auto",
    tolerance: float = 1e-12,
) -> Certificate:
    """Applies an impulsive wrench. Joints, locks and active constraints transmit it; contacts do not.

    Args:
        plant: a finalised plant.
        context: its context; the velocities change.
        body: a body (or its name).
        force: (3,) N s, world axes.
        torque: (3,) N m s, world axes.
        point: (3,) m, where the force acts, in the body's frame.
        reserved: all constraints from ``reserve`` that are active in the context.
        method: how to compute the velocities.
        tolerance: the largest relative error in the certificate.

    Raises:
        mt.Error: nothing has changed then.
    """
    state = DrakeState(plant, context, reserved)
    number = int(_element(plant, body).index())
    where = state.position(number) + state.rotation(number) @ _three(point, "point")
    wrench = np.concatenate([_three(force, "force"), _three(torque, "torque")])
    request = Request(
        f"impulse on {_name(plant, number)}",
        (number,),
        Rows.none(len(state.v)),
        where,
        np.zeros((6, 0)),
        lambda sim: sim.apply(mt.impulse(state.body_name(number), force=tuple(force), torque=tuple(torque), point=tuple(point))),
        joins=False,
        push=state.jacobian(number, where).T @ wrench,
        pushed=Wrench(wrench[:3], wrench[3:] + np.cross(where, wrench[:3]), np.zeros(3)),
    )
    return _finish(state, request, None, method, tolerance)


def _finish(state: DrakeState, request: Request, constraint: Reserved | None, method: Method, tolerance: float) -> Certificate:
    if constraint is not None:
        _check_pose(state, request, constraint)
    after, certificate = solve(state, request, method, tolerance)
    state.plant.SetVelocities(state.context, after)
    if constraint is not None:
        state.plant.SetConstraintActiveStatus(state.context, constraint.constraint, True)
    return certificate


def _check_pose(state: DrakeState, request: Request, constraint: Reserved) -> None:
    pair = int(constraint.body.index()), int(constraint.to.index())
    if set(pair) != set(request.bodies):
        raise mt.Error("the constraint is between other bodies", request.action)
    if state.plant.GetConstraintActiveStatus(state.context, constraint.constraint):
        raise mt.Error("the constraint is active already", request.action, "break_ deactivates it")
    (first, pose), (second, other) = zip(pair, (constraint.pose, constraint.other))
    gap = state.position(first) + state.rotation(first) @ pose.translation()
    gap = gap - state.position(second) - state.rotation(second) @ other.translation()
    turn = (state.rotation(first) @ pose.rotation().matrix()).T @ state.rotation(second) @ other.rotation().matrix()
    angle = 0.0 if constraint.ball else float(np.linalg.norm(turn - np.eye(3)))
    if not np.linalg.norm(gap) < 1e-9 or not angle < 1e-9:
        raise mt.Error(
            f"the frames are {np.linalg.norm(gap):.3g} m and {angle:.3g} rad apart: Drake would pull them together",
            request.action,
            "build a plant with the new joint in the present pose, and use transfer()",
        )


def _pair(
    plant: MultibodyPlant, context: Context, body: Any, to: Any, reserved: Sequence[Reserved]
) -> tuple[DrakeState, int, int]:
    """The state and the two bodies, the first of which can move."""
    one, two = (WORLD if each is None else int(_element(plant, each).index()) for each in (body, to))
    if one == two:
        raise mt.Error("a body cannot be joined to itself", _name(plant, one))
    state = DrakeState(plant, context, reserved)
    return (state, two, one) if state.root(one) == WORLD else (state, one, two)


def _blind(plant: MultibodyPlant, context: Context) -> DrakeState:
    """A state for a change of no velocity, which need not know what active constraints join."""
    every = [Reserved(number, None, None, None, None, False) for number in plant.GetConstraintIds()]
    return DrakeState(plant, context, every)


def _element(plant: MultibodyPlant, body: Any) -> Any:
    if not isinstance(body, str):
        return body
    if body in ("world", "ground"):
        return plant.world_body()
    try:
        return plant.GetBodyByName(body)
    except RuntimeError as error:
        raise mt.Error(str(error), "drake", "pass the RigidBody itself if its name is not unique") from None


def _joint(plant: MultibodyPlant, joint: Any) -> Any:
    if not isinstance(joint, str):
        return joint
    try:
        return plant.GetJointByName(joint)
    except RuntimeError as error:
        raise mt.Error(str(error), "drake", "pass the Joint itself if its name is not unique") from None


def _name(plant: MultibodyPlant, body: int) -> str:
    return str(plant.get_body(tree.BodyIndex(body)).name())


def _three(values: Sequence[float], name: str) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (3,) or not np.all(np.isfinite(array)):
        raise mt.Error(f"{name} has three finite numbers", "drake")
    return array
