"""Kinematic trees of a MuJoCo model as a momentree model, and velocities in the conventions of both."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

import momentree as mt
from momentree.bridge._change import Request
from momentree.bridge._mujoco_package import MjModel, mujoco
from momentree.bridge._mujoco_state import State
from momentree.bridge.certificate import FloatArray

FREE = int(mujoco.mjtJoint.mjJNT_FREE)
BALL = int(mujoco.mjtJoint.mjJNT_BALL)
SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)
HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)
JOINT_DOFS = {FREE: 6, BALL: 3, SLIDE: 1, HINGE: 1}


def rotation(quaternion: FloatArray) -> FloatArray:
    """(3, 3) of a quaternion (w, x, y, z) of any length."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def product(a: FloatArray, b: FloatArray) -> FloatArray:
    """The quaternion of rotation ``b`` followed by ``a``."""
    result = np.zeros(4)
    mujoco.mju_mulQuat(result, np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64))
    return np.asarray(result / np.linalg.norm(result))


def inverse(quaternion: FloatArray) -> FloatArray:
    """The quaternion of the opposite rotation."""
    return np.asarray(quaternion * np.array([1.0, -1.0, -1.0, -1.0]))


def body_name(model: MjModel, body: int) -> str:
    """The name of a MuJoCo body in the converted model: of the body after its last joint; ``"ground"`` if it cannot move."""
    tree = int(model.body_treeid[body])
    return f"tree{tree}/body{body}" if tree >= 0 else "ground"


def joint_name(model: MjModel, joint: int) -> str:
    """The name of a MuJoCo joint in the converted model."""
    return f"tree{int(model.body_treeid[model.jnt_bodyid[joint]])}/joint{joint}"


def root_of(model: MjModel, body: int) -> int:
    """The first body with a joint on the way from the world to ``body``; the world if there is none."""
    root = 0
    while body:
        if model.body_jntnum[body]:
            root = body
        body = int(model.body_parentid[body])
    return root


def floats(model: MjModel, root: int) -> bool:
    """Whether this first body with a joint has a free joint."""
    return root != 0 and int(model.body_jntnum[root]) == 1 and int(model.jnt_type[model.body_jntadr[root]]) == FREE


class ConvertibleState(State):
    """A state whose mechanisms can be converted to momentree."""

    def floats(self, bodies: Sequence[int]) -> bool:
        """Whether these bodies conserve their momenta: nothing joins them to the world, and none is an armature's."""
        roots = [root_of(self.model, body) for body in bodies]
        return all(floats(self.model, root) and not self._armature(root) for root in roots)

    def _armature(self, root: int) -> bool:
        """Whether the free joint of this body has an armature."""
        first = int(self.model.body_dofadr[root])
        return bool(np.any(self.model.dof_armature[first : first + 6]))

    def unsuitable(self, request: Request) -> str:
        """Why momentree cannot make a change where no constraint is active; empty if it can."""
        model = self.model
        if any(np.any(getattr(model, name, 0.0)) for name in ("tendon_armature", "actuator_armature")):
            return "a tendon or an actuator has an armature"
        if not request.joins:
            return ""
        roots = {root_of(model, body) for body in request.bodies}
        floating = [root for root in roots if floats(model, root)]
        if len(roots) < len(request.bodies):
            return "it closes a loop"
        if not floating:
            return "it closes a loop through the world"
        if any(self._armature(root) for root in floating):
            return "a free joint has an armature, which would leave with the joint"
        return ""

    def by_momentree(self, request: Request, trees: set[int]) -> FloatArray:
        """(nv,) velocities after the change."""
        copy = simulation(self, trees)
        request.perform(copy)
        return velocities(copy, self, trees)


def simulation(state: State, trees: Iterable[int]) -> mt.Simulation:
    """The bodies and joints of these kinematic trees, in their state, without gravity, forces, limits and contacts.

    A body with several joints becomes a chain of massless bodies, and a body without joints is welded to its parent.

    Raises:
        mt.Error: if momentree refuses a body or a joint.
    """
    model = state.model
    wanted = set(trees)
    result = mt.Model(gravity=(0.0, 0.0, 0.0))
    for body in range(1, int(model.nbody)):
        if int(model.body_treeid[body]) in wanted:
            _add_body(result, state, body)
    return mt.Simulation(result)


def _add_body(result: mt.Model, state: State, body: int) -> None:
    model, qpos, v = state.model, state.data.qpos, state.v
    name, parent = body_name(model, body), int(model.body_parentid[body])
    offset = np.array(model.body_pos[body])
    turn = np.array(model.body_quat[body])
    held = int(model.body_treeid[parent]) < 0
    if held:  # the parent does not move: its pose is part of the placement
        offset = state.position(parent) + state.rotation(parent) @ offset
        turn = product(state.quaternion(parent), turn)
    before = None if held else body_name(model, parent)
    axes = rotation(np.array(model.body_iquat[body]))
    moments = axes @ np.diag(model.body_inertia[body]) @ axes.T
    inertia = (moments[0, 0], moments[1, 1], moments[2, 2], moments[0, 1], moments[0, 2], moments[1, 2])
    solid: dict[str, Any] = {"mass": float(model.body_mass[body]), "com": tuple(model.body_ipos[body]), "inertia": inertia}
    first, number = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    if number == 0:
        result.add(name, **solid, parent=before, at=_placement(offset, turn), joint=mt.Weld())
        return
    for joint in range(first, first + number):
        last = joint == first + number - 1
        link = name if last else f"{name}.{joint - first}"
        mass: dict[str, Any] = solid if last else {"mass": 0.0, "inertia": 0.0}
        kind, dof, at = int(model.jnt_type[joint]), int(model.jnt_dofadr[joint]), int(model.jnt_qposadr[joint])
        armature = tuple(float(each) for each in model.dof_armature[dof : dof + JOINT_DOFS[kind]])
        rates = v[dof : dof + JOINT_DOFS[kind]]
        if kind == FREE:
            q = np.concatenate([qpos[at : at + 3], _unit(qpos[at + 3 : at + 7])])
            local = np.concatenate([rotation(q[3:]).T @ rates[:3], rates[3:]])
            result.add(link, **mass, joint=mt.Free(armature=armature), q=q, v=local, joint_name=joint_name(model, joint))
            continue
        anchor = np.array(model.jnt_pos[joint])
        axis = tuple(model.jnt_axis[joint])
        where = _placement(offset + rotation(turn) @ anchor, turn)
        q = _unit(qpos[at : at + 4]) if kind == BALL else qpos[at : at + 1] - model.qpos0[at : at + 1]
        spec: mt.JointSpec
        if kind == BALL:
            spec = mt.Ball(armature=armature)
        elif kind == HINGE:
            spec = mt.Revolute(axis=axis, armature=armature[0])
        else:
            spec = mt.Prismatic(axis=axis, armature=armature[0])
        here = _placement(anchor, np.array([1.0, 0.0, 0.0, 0.0]))
        joined: dict[str, Any] = {"at": where, "child_at": here, "joint": spec, "joint_name": joint_name(model, joint)}
        result.add(link, **mass, **joined, parent=before, q=q, v=rates)
        before, offset, turn = link, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])


def _placement(xyz: FloatArray, quaternion: FloatArray) -> dict[str, tuple[float, ...]]:
    return {"xyz": tuple(float(x) for x in xyz), "quat": tuple(float(x) for x in _unit(quaternion))}


def _unit(quaternion: FloatArray) -> FloatArray:
    return np.asarray(quaternion / np.linalg.norm(quaternion))


def velocities(simulation: mt.Simulation, state: State, trees: Iterable[int]) -> FloatArray:
    """(nv,) the velocities of the simulation in MuJoCo's conventions; of other trees, those of ``state``."""
    model, v = state.model, state.v
    wanted = set(trees)
    world = simulation.world
    for joint in range(int(model.njnt)):
        body = int(model.jnt_bodyid[joint])
        if int(model.body_treeid[body]) not in wanted:
            continue
        kind, dof = int(model.jnt_type[joint]), int(model.jnt_dofadr[joint])
        if kind == FREE:  # from the body: a weld replaces this joint
            motion = world.bodies[body_name(model, body)]
            v[dof : dof + 3] = motion.linear
            v[dof + 3 : dof + 6] = state.rotation(body).T @ np.asarray(motion.angular)
        else:
            v[dof : dof + JOINT_DOFS[kind]] = world.joints[joint_name(model, joint)].v
    return v
