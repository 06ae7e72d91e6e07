"""Carrying the state of a Drake plant over to a plant of another topology."""

from __future__ import annotations

from typing import Any

import numpy as np

import momentree as mt
from momentree.bridge._change import unchanged
from momentree.bridge._drake_package import Context, MultibodyPlant, math, tree
from momentree.bridge._drake_state import WORLD, DrakeState, Reserved
from momentree.bridge.certificate import Certificate, FloatArray


def transfer(
    plant: MultibodyPlant,
    context: Context,
    new_plant: MultibodyPlant,
    new_context: Context,
    *,
    tolerance: float = 1e-9,
    exact: float = 1e-12,
) -> Certificate:
    """Puts a new plant into the state of an old one: every body has the pose and velocity that it has in the old plant.

    Bodies are matched by their names, with their model instances. Joints of all kinds are set from the poses and velocities of
    their bodies, so their numbers and conventions may differ. Locks are not carried over.

    Args:
        plant: the old plant.
        context: its context, which is not changed.
        new_plant: a plant whose bodies are in the old one, too.
        new_context: its context; its time, positions and velocities are set.
        tolerance: by how much poses (m, rad) may differ that the new joints do not allow exactly: a plant that was built for the
            present pose differs by rounding.
        exact: the bound of the errors in the certificate.

    Returns:
        The certificate that energy and momenta are those of the old plant, and that the velocities of all bodies are.

    Raises:
        mt.Error: if a body is missing, or if the new topology does not allow the present state. Nothing has changed then.
    """
    old, scratch = _blind(plant, context), new_plant.CreateDefaultContext()
    pairs = {}
    for index in range(1, new_plant.num_bodies()):
        body = _body(new_plant, index)
        pairs[index] = _same(plant, new_plant, body)
    scratch.SetTime(context.get_time())
    for joint in _downwards(new_plant):
        _place(old, new_plant, scratch, joint, pairs)
    moved = max((_apart(old, new_plant, scratch, new, was) for new, was in pairs.items()), default=0.0)
    if not moved <= tolerance:
        raise mt.Error(
            f"a body would be displaced by {moved:.3g} (m, rad): the joints of the new plant do not allow the present pose",
            "transfer",
            "build the new joints with the pose that the bodies have now",
        )
    v, left = _velocities(old, new_plant, scratch, pairs)
    new_plant.SetVelocities(scratch, v)
    after = _blind(new_plant, scratch)
    certificate = unchanged(old, "transfer", exact, after.totals(v), left)
    if not certificate.ok:
        raise mt.Error(
            f"the joints of the new plant do not allow the present velocities: {certificate}",
            "transfer",
            "compute the velocities of the change first: weld(), attach() or lock()",
        )
    new_context.SetTime(context.get_time())
    new_plant.SetPositionsAndVelocities(new_context, new_plant.GetPositionsAndVelocities(scratch))
    return certificate


def _blind(plant: MultibodyPlant, context: Context) -> DrakeState:
    return DrakeState(plant, context, [Reserved(number, None, None, None, None, False) for number in plant.GetConstraintIds()])


def _body(plant: MultibodyPlant, index: int) -> Any:
    return plant.get_body(tree.BodyIndex(index))


def _same(plant: MultibodyPlant, new_plant: MultibodyPlant, body: Any) -> int:
    instance = new_plant.GetModelInstanceName(body.model_instance())
    try:
        return int(plant.GetBodyByName(body.name(), plant.GetModelInstanceByName(instance)).index())
    except RuntimeError:
        raise mt.Error(f"the old plant has no body '{body.name()}' in '{instance}'", "transfer") from None


def _downwards(plant: MultibodyPlant) -> list[Any]:
    """The joints, those of parents first."""
    inboard = {int(joint.child_body().index()): joint for joint in (plant.get_joint(i) for i in plant.GetJointIndices())}
    order: list[int] = []

    def visit(body: int) -> None:
        if body == WORLD or body in order:
            return
        visit(int(inboard[body].parent_body().index()))
        order.append(body)

    for body in inboard:
        visit(body)
    return [inboard[body] for body in order]


def _pose(state: DrakeState, body: int) -> Any:
    return math.RigidTransform(math.RotationMatrix(state.rotation(body)), state.position(body))


def _place(old: DrakeState, plant: MultibodyPlant, context: Context, joint: Any, pairs: dict[int, int]) -> None:
    """Sets the coordinates of a joint from the old poses of its two bodies."""
    if joint.num_positions() == 0:
        return
    child, parent = int(joint.child_body().index()), int(joint.parent_body().index())
    frame = _pose(old, pairs[parent]) if parent else math.RigidTransform()
    frame = frame @ joint.frame_on_parent().GetFixedPoseInBodyFrame()
    across = frame.inverse() @ _pose(old, pairs[child]) @ joint.frame_on_child().GetFixedPoseInBodyFrame()
    kind = joint.type_name()
    if kind == "revolute":
        joint.set_angle(context, _angle(across.rotation().matrix(), np.array(joint.revolute_axis())))
    elif kind == "prismatic":
        joint.set_translation(context, float(np.array(joint.translation_axis()) @ across.translation()))
    else:
        try:
            joint.SetPose(context, across)
        except RuntimeError as error:
            raise mt.Error(f"a joint of the kind {kind} cannot be set from a pose: {error}", joint.name()) from None


def _angle(turn: FloatArray, axis: FloatArray) -> float:
    """The angle of a rotation about an axis."""
    sine = float(axis @ np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])) / 2
    cosine = (float(np.trace(turn)) - 1) / 2
    return float(np.arctan2(sine, cosine))


def _apart(old: DrakeState, plant: MultibodyPlant, context: Context, new: int, was: int) -> float:
    pose = plant.EvalBodyPoseInWorld(context, _body(plant, new))
    turned = float(np.linalg.norm(pose.rotation().matrix() - old.rotation(was)))
    return max(float(np.linalg.norm(pose.translation() - old.position(was))), turned)


def _velocities(old: DrakeState, plant: MultibodyPlant, context: Context, pairs: dict[int, int]) -> tuple[FloatArray, float]:
    """The velocities that give all bodies their old motion, and the largest difference that is left, relative to the fastest."""
    new = _blind(plant, context)
    wanted, rows = [], []
    for index, was in pairs.items():
        wanted.append(old.jacobian(was, old.position(was)) @ old.v)
        rows.append(new.jacobian(index, new.position(index)))
    if not wanted:
        return np.zeros(plant.num_velocities()), 0.0
    matrix, motion = np.vstack(rows), np.concatenate(wanted)
    v = np.linalg.lstsq(matrix, motion, rcond=None)[0]
    fastest = float(np.max(np.abs(motion)))
    left = float(np.max(np.abs(matrix @ v - motion))) / fastest if fastest > 0 else 0.0
    return np.asarray(v), left
