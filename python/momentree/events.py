"""Actions and conditions of events, with the names and meanings of scenario files.

Numbers are in SI units; strings with units work everywhere. Names of joints and bodies may have a wildcard: ``"chain/*"``. Errors
in values are raised where they are used: by :meth:`Simulation.apply`, ``when`` and ``then``.
"""

# Written by tools/python_vocabulary from the library's lists.
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from momentree._vocabulary import (
    Action,
    BodyName,
    Condition,
    JointName,
    JointSpec,
    Number,
    Numbers,
    Onset,
    Pose,
    Quantity,
    Reaction,
    Signals,
    Undetermined,
    Vector,
    break_spring,
    drive_of,
    given,
    measured,
    pose,
)

__all__ = [
    "attach",
    "break_joint",
    "break_spring",
    "change_joint",
    "contact_force",
    "contact_impulse",
    "distance",
    "free_joint",
    "gap",
    "height",
    "impulse",
    "kinetic_energy",
    "lock",
    "measured",
    "position",
    "reaction",
    "reaction_impulse",
    "reroot",
    "set_length",
    "set_parameters",
    "slip",
    "speed",
    "touch",
    "unlock",
    "weld",
]


def attach(
    body: BodyName,
    to: BodyName,
    joint: JointSpec,
    *,
    at: Pose | None = None,
    name: str | None = None,
) -> Action:
    """Joins a body to another, or to the ground, by a joint of any kind.

    Args:
        body: Name of the body, or its handle.
        to: Name or handle of the other body, or ``"ground"``.
        at: Placement of the joint's frame in the frame of ``to``; by default where the body is.
        joint: The joint: :func:`Revolute`, :func:`Ball` ….
        name: Name of the joint that this makes, for later actions; default: that of the event, or else ``to+body``.
    """
    return Action("attach", {**given(body=body, to=to, at=pose(at), name=name), **joint.scenario_value()}, [body, to])


def break_joint(
    joint: JointName,
) -> Action:
    """Removes a joint: the child's subtree becomes a separate mechanism; or a spring.

    Args:
        joint: Name of the joint, or its handle.
    """
    return Action("break", given(joint=joint), [joint])


def change_joint(
    joint: JointName,
    to: JointSpec,
) -> Action:
    """Changes a joint to another kind, or to other axes.

    Args:
        joint: Name of the joint, or its handle.
        to: The joint: :func:`Revolute`, :func:`Ball` ….
    """
    return Action("change", {**given(joint=joint), **to.scenario_value()}, [joint])


def free_joint(
    joint: JointName,
) -> Action:
    """Gives a joint six DoFs, relative to the same parent.

    Args:
        joint: Name of the joint, or its handle.
    """
    return Action("free", given(joint=joint), [joint])


def impulse(
    body: BodyName,
    *,
    force: Vector | None = None,
    torque: Vector | None = None,
    point: Vector | None = None,
) -> Action:
    """Applies an impulsive wrench to a body, in world axes.

    Args:
        body: Name of the body, or its handle.
        force: Impulse at ``point`` (N s).
        torque: Angular impulse (N m s).
        point: Point of application in the body's frame (m).
    """
    return Action("impulse", given(body=body, force=force, torque=torque, point=point), [body])


def lock(
    joint: JointName,
    freedoms: Sequence[int] | None = None,
) -> Action:
    """Locks a joint, or some of its DoFs, in its current position.

    Args:
        joint: Name of the joint, or its handle.
        freedoms: Indices of degrees of freedom in the order of v; all of them if left out.
    """
    return Action("lock", given(joint=joint, freedoms=freedoms), [joint])


def reroot(
    body: BodyName,
) -> Action:
    """Makes a body the root of its free mechanism.

    Args:
        body: Name of the body, or its handle.
    """
    return Action("reroot", given(body=body), [body])


def set_parameters(
    joint: JointName,
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
) -> Action:
    """Sets new parameters of a joint or a spring; those that are not given stay.

    Args:
        joint: Name of the joint, or its handle.
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
    return Action("set", given(joint=joint, damping=damping, stiffness=stiffness, rest=rest, armature=armature, limits=limits, friction=friction, strength=strength, drive=drive_of(effort, drive)), [joint])


def set_length(
    cable: JointName,
    length: Number,
) -> Action:
    """Sets the length of a cable, or the rest length of a spring.

    Args:
        cable: Its name, or its handle.
        length: Its new length (m).
    """
    return Action("set_length", given(cable=cable, length=length), [cable])


def unlock(
    joint: JointName,
    freedoms: Sequence[int] | None = None,
) -> Action:
    """Releases a locked joint, or some of its DoFs.

    Args:
        joint: Name of the joint, or its handle.
        freedoms: Indices of degrees of freedom in the order of v; all of them if left out.
    """
    return Action("unlock", given(joint=joint, freedoms=freedoms), [joint])


def weld(
    body: BodyName,
    to: BodyName = "ground",
    *,
    name: str | None = None,
) -> Action:
    """Joins a body rigidly to another, or to the ground.

    Args:
        body: Name of the body, or its handle.
        to: Name or handle of the other body, or ``"ground"``.
        name: Name of the joint that this makes, for later actions; default: that of the event, or else ``to+body``.
    """
    return Action("weld", given(body=body, to=to, name=name), [body, to])


def contact_force(one: BodyName, other: BodyName) -> Quantity:
    """Norm of the force between two bodies that touch; 0 if they do not (N).

    Args:
        one: Name or handle of a body with a collision; name of a mechanism, which stands for any of its bodies; or
            ``"ground"``.
        other: The other one.
    """
    return Quantity("contact_force", [one, other], [one, other])


def contact_impulse(one: BodyName, other: BodyName) -> Quantity:
    """Norm of the impulse of two bodies that hit each other (N s).

    Args:
        one: Name or handle of a body with a collision; name of a mechanism, which stands for any of its bodies; or
            ``"ground"``.
        other: The other one.
    """
    return Quantity("contact_impulse", [one, other], [one, other])


def distance(one: BodyName, other: BodyName, point_of_one: Vector = (0, 0, 0), point_of_other: Vector = (0, 0, 0)) -> Quantity:
    """Distance between two bodies: between the origins of their frames, or between points of them (m).

    Args:
        one: Name or handle of a body.
        other: Name or handle of the other, or ``"ground"``.
        point_of_one: Point in its frame (m).
        point_of_other: Point in its frame (m).
    """
    return Quantity("distance", [{"body": one, "point": point_of_one}, {"body": other, "point": point_of_other}], [one, other])


def gap(one: BodyName, other: BodyName) -> Quantity:
    """Least distance of two bodies, of what can touch (m).

    Args:
        one: Name or handle of a body with a collision; name of a mechanism, which stands for any of its bodies; or
            ``"ground"``.
        other: The other one.
    """
    return Quantity("gap", [one, other], [one, other])


def height(body: BodyName, point: Vector = (0, 0, 0)) -> Quantity:
    """Height of a body, or of a point of it, against gravity (m).

    Args:
        body: Name of the body, or its handle.
        point: Point in the body's frame (m).
    """
    return Quantity("height", {"body": body, "point": point}, [body])


def kinetic_energy(mechanism: str) -> Quantity:
    """Kinetic energy of a mechanism (J).

    Args:
        mechanism: Name of the mechanism.
    """
    return Quantity("kinetic_energy", mechanism, [])


def position(joint: JointName) -> Quantity:
    """Coordinate of a joint with one degree of freedom (rad or m).

    Args:
        joint: Name of the joint, or its handle.
    """
    return Quantity("position", joint, [joint])


def reaction_impulse(joint: JointName) -> Quantity:
    """Norm of the linear impulse through a joint at an instantaneous change (N s).

    Args:
        joint: Name of the joint, or its handle.
    """
    return Quantity("reaction_impulse", joint, [joint])


def slip(one: BodyName, other: BodyName) -> Onset:
    """Largest speed of slip of two bodies, 0 if they do not touch (m/s); without a threshold: they begin to slip.

    Args:
        one: Name or handle of a body with a collision; name of a mechanism, which stands for any of its bodies; or
            ``"ground"``.
        other: The other one.
    """
    return Onset("slip", [one, other], [one, other])


def speed(joint: JointName) -> Quantity:
    """Velocity of a joint with one degree of freedom (rad/s or m/s).

    Args:
        joint: Name of the joint, or its handle.
    """
    return Quantity("speed", joint, [joint])


def touch(one: BodyName, other: BodyName) -> Condition:
    """Two bodies touch; takes no threshold.

    Args:
        one: Name or handle of a body with a collision; name of a mechanism, which stands for any of its bodies; or
            ``"ground"``.
        other: The other one.
    """
    return Condition(Quantity("touch", [one, other], [one, other]), None, True)


def reaction(joint: JointName, *, undetermined: Undetermined | None = None) -> Reaction:
    """The wrench that a joint transmits: ``reaction("load").force > 40``.

    Args:
        joint: Name of the joint, or its handle.
        undetermined: ``"least_norm"``: of a reaction that closed loops leave open, take the one for which the sum of squares over
            all joints is least. Without it, a condition on such a reaction is an Error.
    """
    return Reaction(joint, undetermined)
