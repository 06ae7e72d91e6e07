"""The kinds of joints, with the parameters of scenario files.

Numbers are in SI units; strings with units work everywhere: ``damping="0.01 N m s"``. One number for a parameter applies to every
degree of freedom, a list has one for each. Errors in values are raised where a joint is used, as by :meth:`Model.add`.
"""

# Written by tools/python_vocabulary from the library's lists.
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from momentree._vocabulary import JointSpec, Number, Numbers, Signals, Vector, drive_of, given

__all__ = [
    "Ball",
    "Cylindrical",
    "Free",
    "Helical",
    "Planar",
    "Prismatic",
    "Revolute",
    "Universal",
    "Weld",
]


def Ball(
    *,
    damping: Numbers | None = None,
    stiffness: Numbers | None = None,
    rest: Numbers | None = None,
    armature: Numbers | None = None,
    effort: Signals | None = None,
    limits: Mapping[str, Any] | None = None,
    friction: Mapping[str, Any] | None = None,
    strength: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
) -> JointSpec:
    """A ball joint. Coordinates q: unit quaternion w, x, y, z. Velocities v: rad/s, rad/s, rad/s.

    Args:
        damping: Torque or force −damping·v.
        stiffness: Spring about ``rest``.
        rest: Coordinates at which the spring is relaxed; default: the joint's zero.
        armature: Rotor inertia reflected to the joint, added to the joint-space mass.
        effort: Drive: a force or torque, constant or a function of time; the same as drive={'effort': …}.
        limits: Stops of the joint's coordinates: hard with ``restitution``, soft with ``stiffness``.
        friction: Dry friction, smoothed: −coulomb·tanh(v/speed).
        strength: The joint breaks when its reaction reaches one of these.
        drive: Drive: an effort, position control or a prescribed motion.
    """
    return JointSpec("ball", given(damping=damping, stiffness=stiffness, rest=rest, armature=armature, limits=limits, friction=friction, strength=strength, drive=drive_of(effort, drive)))


def Cylindrical(
    axis: Vector = (0, 0, 1),
    *,
    damping: Numbers | None = None,
    stiffness: Numbers | None = None,
    rest: Numbers | None = None,
    armature: Numbers | None = None,
    effort: Signals | None = None,
    limits: Mapping[str, Any] | None = None,
    friction: Mapping[str, Any] | None = None,
    strength: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
) -> JointSpec:
    """A cylindrical joint. Coordinates q: rad, m. Velocities v: rad/s, m/s.

    Args:
        axis: Axis in the joint's frame, of any length but zero.
        damping: Torque or force −damping·v.
        stiffness: Spring about ``rest``.
        rest: Coordinates at which the spring is relaxed; default: the joint's zero.
        armature: Rotor inertia reflected to the joint, added to the joint-space mass.
        effort: Drive: a force or torque, constant or a function of time; the same as drive={'effort': …}.
        limits: Stops of the joint's coordinates: hard with ``restitution``, soft with ``stiffness``.
        friction: Dry friction, smoothed: −coulomb·tanh(v/speed).
        strength: The joint breaks when its reaction reaches one of these.
        drive: Drive: an effort, position control or a prescribed motion.
    """
    return JointSpec("cylindrical", given(axis=axis, damping=damping, stiffness=stiffness, rest=rest, armature=armature, limits=limits, friction=friction, strength=strength, drive=drive_of(effort, drive)))


def Free(
    *,
    damping: Numbers | None = None,
    stiffness: Numbers | None = None,
    rest: Numbers | None = None,
    armature: Numbers | None = None,
    effort: Signals | None = None,
    limits: Mapping[str, Any] | None = None,
    friction: Mapping[str, Any] | None = None,
    strength: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
) -> JointSpec:
    """A free joint. Coordinates q: m, m, m, unit quaternion w, x, y, z. Velocities v: m/s, m/s, m/s, rad/s, rad/s, rad/s.

    Args:
        damping: Torque or force −damping·v.
        stiffness: Spring about ``rest``.
        rest: Coordinates at which the spring is relaxed; default: the joint's zero.
        armature: Rotor inertia reflected to the joint, added to the joint-space mass.
        effort: Drive: a force or torque, constant or a function of time; the same as drive={'effort': …}.
        limits: Stops of the joint's coordinates: hard with ``restitution``, soft with ``stiffness``.
        friction: Dry friction, smoothed: −coulomb·tanh(v/speed).
        strength: The joint breaks when its reaction reaches one of these.
        drive: Drive: an effort, position control or a prescribed motion.
    """
    return JointSpec("free", given(damping=damping, stiffness=stiffness, rest=rest, armature=armature, limits=limits, friction=friction, strength=strength, drive=drive_of(effort, drive)))


def Helical(
    axis: Vector = (0, 0, 1),
    pitch: Number | None = None,
    *,
    damping: Numbers | None = None,
    stiffness: Numbers | None = None,
    rest: Numbers | None = None,
    armature: Numbers | None = None,
    effort: Signals | None = None,
    limits: Mapping[str, Any] | None = None,
    friction: Mapping[str, Any] | None = None,
    strength: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
) -> JointSpec:
    """A helical joint. Coordinates q: rad. Velocities v: rad/s.

    Args:
        axis: Axis in the joint's frame, of any length but zero.
        pitch: Displacement per turn (m).
        damping: Torque or force −damping·v.
        stiffness: Spring about ``rest``.
        rest: Coordinates at which the spring is relaxed; default: the joint's zero.
        armature: Rotor inertia reflected to the joint, added to the joint-space mass.
        effort: Drive: a force or torque, constant or a function of time; the same as drive={'effort': …}.
        limits: Stops of the joint's coordinates: hard with ``restitution``, soft with ``stiffness``.
        friction: Dry friction, smoothed: −coulomb·tanh(v/speed).
        strength: The joint breaks when its reaction reaches one of these.
        drive: Drive: an effort, position control or a prescribed motion.
    """
    return JointSpec("helical", given(axis=axis, pitch=pitch, damping=damping, stiffness=stiffness, rest=rest, armature=armature, limits=limits, friction=friction, strength=strength, drive=drive_of(effort, drive)))


def Planar(
    *,
    damping: Numbers | None = None,
    stiffness: Numbers | None = None,
    rest: Numbers | None = None,
    armature: Numbers | None = None,
    effort: Signals | None = None,
    limits: Mapping[str, Any] | None = None,
    friction: Mapping[str, Any] | None = None,
    strength: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
) -> JointSpec:
    """A planar joint. Coordinates q: m, m, rad. Velocities v: m/s, m/s, rad/s.

    Args:
        damping: Torque or force −damping·v.
        stiffness: Spring about ``rest``.
        rest: Coordinates at which the spring is relaxed; default: the joint's zero.
        armature: Rotor inertia reflected to the joint, added to the joint-space mass.
        effort: Drive: a force or torque, constant or a function of time; the same as drive={'effort': …}.
        limits: Stops of the joint's coordinates: hard with ``restitution``, soft with ``stiffness``.
        friction: Dry friction, smoothed: −coulomb·tanh(v/speed).
        strength: The joint breaks when its reaction reaches one of these.
        drive: Drive: an effort, position control or a prescribed motion.
    """
    return JointSpec("planar", given(damping=damping, stiffness=stiffness, rest=rest, armature=armature, limits=limits, friction=friction, strength=strength, drive=drive_of(effort, drive)))


def Prismatic(
    axis: Vector = (0, 0, 1),
    *,
    damping: Numbers | None = None,
    stiffness: Numbers | None = None,
    rest: Numbers | None = None,
    armature: Numbers | None = None,
    effort: Signals | None = None,
    limits: Mapping[str, Any] | None = None,
    friction: Mapping[str, Any] | None = None,
    strength: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
) -> JointSpec:
    """A prismatic joint. Coordinates q: m. Velocities v: m/s.

    Args:
        axis: Axis in the joint's frame, of any length but zero.
        damping: Torque or force −damping·v.
        stiffness: Spring about ``rest``.
        rest: Coordinates at which the spring is relaxed; default: the joint's zero.
        armature: Rotor inertia reflected to the joint, added to the joint-space mass.
        effort: Drive: a force or torque, constant or a function of time; the same as drive={'effort': …}.
        limits: Stops of the joint's coordinates: hard with ``restitution``, soft with ``stiffness``.
        friction: Dry friction, smoothed: −coulomb·tanh(v/speed).
        strength: The joint breaks when its reaction reaches one of these.
        drive: Drive: an effort, position control or a prescribed motion.
    """
    return JointSpec("prismatic", given(axis=axis, damping=damping, stiffness=stiffness, rest=rest, armature=armature, limits=limits, friction=friction, strength=strength, drive=drive_of(effort, drive)))


def Revolute(
    axis: Vector = (0, 0, 1),
    *,
    damping: Numbers | None = None,
    stiffness: Numbers | None = None,
    rest: Numbers | None = None,
    armature: Numbers | None = None,
    effort: Signals | None = None,
    limits: Mapping[str, Any] | None = None,
    friction: Mapping[str, Any] | None = None,
    strength: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
) -> JointSpec:
    """A revolute joint. Coordinates q: rad. Velocities v: rad/s.

    Args:
        axis: Axis in the joint's frame, of any length but zero.
        damping: Torque or force −damping·v.
        stiffness: Spring about ``rest``.
        rest: Coordinates at which the spring is relaxed; default: the joint's zero.
        armature: Rotor inertia reflected to the joint, added to the joint-space mass.
        effort: Drive: a force or torque, constant or a function of time; the same as drive={'effort': …}.
        limits: Stops of the joint's coordinates: hard with ``restitution``, soft with ``stiffness``.
        friction: Dry friction, smoothed: −coulomb·tanh(v/speed).
        strength: The joint breaks when its reaction reaches one of these.
        drive: Drive: an effort, position control or a prescribed motion.
    """
    return JointSpec("revolute", given(axis=axis, damping=damping, stiffness=stiffness, rest=rest, armature=armature, limits=limits, friction=friction, strength=strength, drive=drive_of(effort, drive)))


def Universal(
    axis: Vector = (0, 0, 1),
    axis2: Vector | None = None,
    *,
    damping: Numbers | None = None,
    stiffness: Numbers | None = None,
    rest: Numbers | None = None,
    armature: Numbers | None = None,
    effort: Signals | None = None,
    limits: Mapping[str, Any] | None = None,
    friction: Mapping[str, Any] | None = None,
    strength: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
) -> JointSpec:
    """An universal joint. Coordinates q: rad, rad. Velocities v: rad/s, rad/s.

    Args:
        axis: Axis in the joint's frame, of any length but zero.
        axis2: Second axis, turned by the first rotation.
        damping: Torque or force −damping·v.
        stiffness: Spring about ``rest``.
        rest: Coordinates at which the spring is relaxed; default: the joint's zero.
        armature: Rotor inertia reflected to the joint, added to the joint-space mass.
        effort: Drive: a force or torque, constant or a function of time; the same as drive={'effort': …}.
        limits: Stops of the joint's coordinates: hard with ``restitution``, soft with ``stiffness``.
        friction: Dry friction, smoothed: −coulomb·tanh(v/speed).
        strength: The joint breaks when its reaction reaches one of these.
        drive: Drive: an effort, position control or a prescribed motion.
    """
    return JointSpec("universal", given(axis=axis, axis2=axis2, damping=damping, stiffness=stiffness, rest=rest, armature=armature, limits=limits, friction=friction, strength=strength, drive=drive_of(effort, drive)))


def Weld(
    *,
    damping: Numbers | None = None,
    stiffness: Numbers | None = None,
    rest: Numbers | None = None,
    armature: Numbers | None = None,
    effort: Signals | None = None,
    limits: Mapping[str, Any] | None = None,
    friction: Mapping[str, Any] | None = None,
    strength: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
) -> JointSpec:
    """A weld joint. Coordinates q: none. Velocities v: none.

    Args:
        damping: Torque or force −damping·v.
        stiffness: Spring about ``rest``.
        rest: Coordinates at which the spring is relaxed; default: the joint's zero.
        armature: Rotor inertia reflected to the joint, added to the joint-space mass.
        effort: Drive: a force or torque, constant or a function of time; the same as drive={'effort': …}.
        limits: Stops of the joint's coordinates: hard with ``restitution``, soft with ``stiffness``.
        friction: Dry friction, smoothed: −coulomb·tanh(v/speed).
        strength: The joint breaks when its reaction reaches one of these.
        drive: Drive: an effort, position control or a prescribed motion.
    """
    return JointSpec("weld", given(damping=damping, stiffness=stiffness, rest=rest, armature=armature, limits=limits, friction=friction, strength=strength, drive=drive_of(effort, drive)))
