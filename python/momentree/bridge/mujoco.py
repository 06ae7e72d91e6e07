"""Topology changes of MuJoCo simulations: welds, locks, hinges and breaks with exact velocities and a certificate.

    import mujoco
    from momentree.bridge import mujoco as bridge

    change = bridge.weld(model, data, "hand", "crate")
    print(change.certificate)

MuJoCo goes on simulating, contact included. A change happens at one instant: poses stay as they are, velocities jump as in a
perfectly plastic impact, and an equality constraint of the model, set to the present pose, holds the change from then on.

Functions either do all of this or raise ``mt.Error`` and change nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np

import momentree as mt
from momentree.bridge import _mujoco_hold as hold_
from momentree.bridge._change import Request, solve
from momentree.bridge._mujoco_apply import Change, join, release
from momentree.bridge._mujoco_cut import cut
from momentree.bridge._mujoco_hold import Hold, Stiffness
from momentree.bridge._mujoco_load import Crossing, load, reaction, step_until
from momentree.bridge._mujoco_model import BALL, FREE, HINGE, JOINT_DOFS, SLIDE, ConvertibleState, body_name, joint_name
from momentree.bridge._mujoco_model import simulation as _simulation
from momentree.bridge._mujoco_names import CONNECT, JOINT, WELD, between, body_of, holding, name_of, number_of
from momentree.bridge._mujoco_package import MjData, MjModel, MjSpec, mujoco
from momentree.bridge.certificate import Certificate, FloatArray, Method, Totals, Wrench
from momentree.bridge.projection import Rows

__all__ = [
    "Certificate",
    "Change",
    "Crossing",
    "Totals",
    "Wrench",
    "attach",
    "break_",
    "impulse",
    "load",
    "lock",
    "reaction",
    "reserve",
    "simulation",
    "step_until",
    "unlock",
    "weld",
]

Element = str | int
"""A name, or a number of MuJoCo."""


def weld(
    model: MjModel,
    data: MjData,
    body: Element,
    to: Element | None = None,
    *,
    equality: Element | None = None,
    spec: MjSpec | None = None,
    solref: Sequence[float] | None = None,
    solimp: Sequence[float] | None = None,
    method: Method = "auto",
    tolerance: float = 1e-12,
) -> Change:
    """Joins two bodies rigidly in their present pose, by a perfectly plastic impact.

    Args:
        model: the MuJoCo model.
        data: its state; ``qvel`` and ``eq_active`` change, and ``mj_forward`` evaluates it.
        body: a body.
        to: another one; None is the world.
        equality: the inactive ``weld`` constraint that holds the bodies from now on. By default one of these bodies is searched.
            Its relative pose in ``model.eq_data`` becomes the present one.
        spec: adds the constraint to a copy of this specification instead, and compiles it; ``model`` and ``data`` stay.
        solref: 2 solver parameters that the constraint receives, instead of those of the model.
        solimp: 5 more.
        method: how to compute the velocities.
        tolerance: the largest relative error in the certificate.

    Raises:
        mt.Error: nothing has changed then.
    """
    state, one, two = _pair(model, data, body, to)
    label = f"weld {name_of(model, 'body', one)} to {name_of(model, 'body', two)}"
    point = state.position(one)
    request = Request(
        label,
        (one, two),
        state.relative(one, two, point),
        point,
        np.eye(6),
        lambda sim: sim.apply(mt.weld(*_names(model, one, two))),
    )
    return join(state, data, request, [Hold(WELD, one, two)], equality, spec, Stiffness(solref, solimp), method, tolerance)


def attach(
    model: MjModel,
    data: MjData,
    body: Element,
    to: Element | None = None,
    *,
    at: Sequence[float] | None = None,
    axis: Sequence[float] | None = None,
    length: float = 0.1,
    equality: Element | Sequence[Element] | None = None,
    spec: MjSpec | None = None,
    solref: Sequence[float] | None = None,
    solimp: Sequence[float] | None = None,
    method: Method = "auto",
    tolerance: float = 1e-12,
) -> Change:
    """Joins two bodies by a ball joint or, if there is an axis, by a hinge, by a perfectly plastic impact.

    MuJoCo holds a ball joint by one ``connect`` constraint, and a hinge by two of them at points of its axis. Other arguments are
    those of ``weld``.

    Args:
        model: the MuJoCo model.
        data: its state.
        body: a body.
        to: another one; None is the world.
        at: (3,) m, the joint in the frame of ``to``; default: the origin of ``body``.
        axis: (3,) the axis of a hinge, in the frame of ``to``.
        length: m, the distance of the two points on the axis of a hinge.
        equality: one inactive ``connect`` constraint, or two for a hinge.
        spec: adds the constraints to a copy of this specification.
        solref: 2 solver parameters for the constraints.
        solimp: 5 more.
        method: how to compute the velocities.
        tolerance: the largest relative error in the certificate.

    Raises:
        mt.Error: nothing has changed then.
    """
    first, second = body_of(model, body), body_of(model, to)
    state, one, two = _pair(model, data, body, to)
    turn, origin = state.rotation(second), state.position(second)
    point = state.position(first) if at is None else origin + turn @ _three(at, "at")
    relative = state.relative(one, two, point)
    still = int(model.body_treeid[two]) < 0
    frame = np.eye(3) if still else state.rotation(two)
    local = frame.T @ (point - (np.zeros(3) if still else state.position(two)))
    points, selection = [point], np.eye(6)[:3]
    joint: mt.JointSpec = mt.Ball()
    if axis is not None:
        given = _three(axis, "axis")
        if not np.linalg.norm(given) > 0 or not length > 0:
            raise mt.Error("the axis and the length of a hinge are not zero", "attach")
        along = turn @ (given / np.linalg.norm(given))
        points = [point - along * length / 2, point + along * length / 2]
        across = np.linalg.svd(along[None, :])[2][1:]  # two directions about which a hinge does not turn
        selection = np.vstack([selection, np.hstack([np.zeros((2, 3)), across])])
        joint = mt.Revolute(axis=tuple(frame.T @ along))
    rows = Rows(selection @ relative.matrix, np.abs(selection) @ relative.scale)
    label = f"attach {name_of(model, 'body', first)} to {name_of(model, 'body', second)}"
    request = Request(
        label,
        (one, two),
        rows,
        point,
        selection.T,
        lambda sim: sim.apply(mt.attach(*_names(model, one, two), joint, at=tuple(local))),
    )
    holds = [Hold(CONNECT, one, two, each) for each in points]
    return join(state, data, request, holds, equality, spec, Stiffness(solref, solimp), method, tolerance)


def lock(
    model: MjModel,
    data: MjData,
    joint: Element,
    *,
    equality: Element | None = None,
    spec: MjSpec | None = None,
    solref: Sequence[float] | None = None,
    solimp: Sequence[float] | None = None,
    method: Method = "auto",
    tolerance: float = 1e-12,
) -> Change:
    """Stops a joint in its present position, with the impulse that this takes.

    A hinge or slide is then held by a ``joint`` constraint without a second joint. A ball or free joint is held by a ``weld``
    constraint of the body and its parent. Other arguments are those of ``weld``.

    Args:
        model: the MuJoCo model.
        data: its state.
        joint: the joint.
        equality: the inactive constraint that holds the joint from now on.
        spec: adds the constraint to a copy of this specification.
        solref: 2 solver parameters for the constraint.
        solimp: 5 more.
        method: how to compute the velocities.
        tolerance: the largest relative error in the certificate.

    Raises:
        mt.Error: nothing has changed then.
    """
    number = number_of(model, "joint", joint)
    state = ConvertibleState(model, data)
    kind, dof, body = int(model.jnt_type[number]), int(model.jnt_dofadr[number]), int(model.jnt_bodyid[number])
    label = f"lock {name_of(model, 'joint', number)}"
    if kind in (BALL, FREE):
        if int(model.body_jntnum[body]) > 1:
            raise mt.Error("a constraint cannot hold one ball joint of a body with several joints", label)
        hold = Hold(WELD, body, int(model.body_parentid[body]))
    else:
        hold = Hold(JOINT, number, -1)
    rows = np.eye(int(model.nv))[dof : dof + JOINT_DOFS[kind]]
    point = state.position(body) if kind == FREE else np.array(state.data.xanchor[number])
    request = Request(
        label,
        (body, 0) if kind == FREE else (body,),
        Rows(rows, np.abs(rows)),
        point,
        _directions(state, number, kind, body),
        lambda sim: sim.apply(mt.lock(joint_name(model, number))),
        joins=False,
    )
    return join(state, data, request, [hold], equality, spec, Stiffness(solref, solimp), method, tolerance)


def unlock(model: MjModel, data: MjData, joint: Element, *, tolerance: float = 1e-12) -> Change:
    """Releases a joint that ``lock`` holds. No velocity changes.

    Raises:
        mt.Error: if no active equality constraint holds the joint.
    """
    number = number_of(model, "joint", joint)
    body = int(model.jnt_bodyid[number])
    rotating = int(model.jnt_type[number]) in (BALL, FREE)
    found = between(model, WELD, body, int(model.body_parentid[body])) if rotating else holding(model, number)
    return release(model, data, [i for i in found if data.eq_active[i]], f"unlock {name_of(model, 'joint', number)}", tolerance)


def break_(
    model: MjModel,
    data: MjData,
    equality: Element | tuple[Element, Element | None] | None = None,
    *,
    joint: Element | None = None,
    spec: MjSpec | None = None,
    tolerance: float = 1e-12,
) -> Change:
    """Removes a connection. No velocity changes.

    Args:
        model: the MuJoCo model.
        data: its state.
        equality: an active equality constraint, or two bodies: all active welds and connects between them.
        joint: instead, a joint of the kinematic tree. Its body, with all that it carries, becomes a separate tree of a new model.
            If the body has several joints, all of them break.
        spec: with ``joint``, the specification of the model; an edited copy is compiled. ``model`` and ``data`` stay as they are.
        tolerance: of the certificate: energy and momenta do not change.

    Raises:
        mt.Error: nothing has changed then.
    """
    if (equality is None) == (joint is None):
        raise mt.Error("break_ needs an equality constraint, or a joint", "mujoco")
    if joint is not None:
        if spec is None:
            raise mt.Error(
                "MuJoCo cannot remove a joint from a model", "break_", "pass spec=, the specification from which it was compiled"
            )
        return cut(model, data, number_of(model, "joint", joint), spec, tolerance)
    if isinstance(equality, tuple):
        one, two = body_of(model, equality[0]), body_of(model, equality[1])
        found = [i for kind in (WELD, CONNECT) for i in between(model, kind, one, two)]
        label = f"break {name_of(model, 'body', one)} from {name_of(model, 'body', two)}"
    else:
        found = [number_of(model, "equality", cast(Element, equality))]
        label = f"break {name_of(model, 'equality', found[0])}"
    return release(model, data, [i for i in found if data.eq_active[i]], label, tolerance)


def impulse(
    model: MjModel,
    data: MjData,
    body: Element,
    force: Sequence[float] = (0.0, 0.0, 0.0),
    torque: Sequence[float] = (0.0, 0.0, 0.0),
    point: Sequence[float] = (0.0, 0.0, 0.0),
    *,
    method: Method = "auto",
    tolerance: float = 1e-12,
) -> Change:
    """Applies an impulsive wrench. Joints and active equality constraints transmit it; contacts do not.

    Args:
        model: the MuJoCo model.
        data: its state; ``qvel`` changes, and ``mj_forward`` evaluates it.
        body: a body.
        force: (3,) N s, world axes.
        torque: (3,) N m s, world axes.
        point: (3,) m, where the force acts, in the body's frame.
        method: how to compute the velocities.
        tolerance: the largest relative error in the certificate.

    Raises:
        mt.Error: nothing has changed then.
    """
    number = body_of(model, body)
    state = ConvertibleState(model, data)
    where = state.position(number) + state.rotation(number) @ _three(point, "point")
    wrench = np.concatenate([_three(force, "force"), _three(torque, "torque")])
    request = Request(
        f"impulse on {name_of(model, 'body', number)}",
        (number,),
        Rows.none(int(model.nv)),
        where,
        np.zeros((6, 0)),
        lambda sim: sim.apply(mt.impulse(body_name(model, number), force=tuple(force), torque=tuple(torque), point=tuple(point))),
        joins=False,
        push=state.jacobian(number, where).T @ wrench,
        pushed=Wrench(wrench[:3], wrench[3:] + np.cross(where, wrench[:3]), np.zeros(3)),
    )
    after, certificate = solve(state, request, method, tolerance)
    data.qvel[:] = after
    mujoco.mj_forward(model, data)
    return Change(certificate, model, data, None, ())


def reserve(
    spec: MjSpec,
    *,
    welds: Sequence[tuple[str, str | None]] = (),
    balls: Sequence[tuple[str, str | None]] = (),
    hinges: Sequence[tuple[str, str | None]] = (),
    locks: Sequence[str] = (),
) -> list[str]:
    """Adds inactive equality constraints to a specification, for later changes of the models that are compiled from it.

    Args:
        spec: an ``MjSpec``; copies of it are compiled to check it.
        welds: pairs of bodies for ``weld``; None is the world.
        balls: pairs of bodies for ``attach``.
        hinges: pairs of bodies for ``attach`` with an axis.
        locks: joints for ``lock``.

    Returns:
        The names of the constraints.

    Raises:
        mt.Error: if a body or joint does not exist or has no name. Nothing has changed then.
    """
    return hold_.reserve(spec, welds, balls, hinges, locks)


def simulation(model: MjModel, data: MjData, bodies: Sequence[Element] | None = None) -> mt.Simulation:
    """The same mechanisms in momentree, in their present state.

    Bodies and joints have MuJoCo's numbers: ``tree0/body3``, ``tree0/joint2``. Masses, inertias, joints and armatures are
    converted; gravity, forces, limits, contacts and constraints are not.

    Args:
        model: the MuJoCo model.
        data: its state, which is not changed.
        bodies: only the kinematic trees of these bodies.

    Raises:
        mt.Error: if momentree refuses a body or joint.
    """
    state = ConvertibleState(model, data)
    if bodies is None:
        return _simulation(state, range(int(model.ntree)))
    return _simulation(state, {int(model.body_treeid[body_of(model, body)]) for body in bodies} - {-1})


def _pair(model: MjModel, data: MjData, body: Element, to: Element | None) -> tuple[ConvertibleState, int, int]:
    """The state and the two bodies, the first of which can move."""
    one, two = body_of(model, body), body_of(model, to)
    if one == two:
        raise mt.Error("a body cannot be joined to itself", name_of(model, "body", one))
    state = ConvertibleState(model, data)
    if int(model.body_weldid[one]) == int(model.body_weldid[two]):
        raise mt.Error("the bodies are rigidly joined already", name_of(model, "body", one))
    return (state, two, one) if int(model.body_treeid[one]) < 0 else (state, one, two)


def _names(model: MjModel, one: int, two: int) -> tuple[str, str]:
    return body_name(model, one), body_name(model, two)


def _directions(state: ConvertibleState, joint: int, kind: int, body: int) -> FloatArray:
    """(6, n) the wrenches of unit efforts along the DoFs of a joint."""
    axis = np.array(state.data.xaxis[joint])
    if kind == SLIDE:
        return np.concatenate([axis, np.zeros(3)])[:, None]
    if kind == HINGE:
        return np.concatenate([np.zeros(3), axis])[:, None]
    turning = np.vstack([np.zeros((3, 3)), state.rotation(body)])
    return turning if kind == BALL else np.hstack([np.eye(6)[:, :3], turning])


def _three(values: Sequence[float], name: str) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (3,) or not np.all(np.isfinite(array)):
        raise mt.Error(f"{name} has three finite numbers", "mujoco")
    return array
