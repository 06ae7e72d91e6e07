"""Models: bodies and joints, declared one by one."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from momentree import _core
from momentree._attributes import assign
from momentree._errors import Error
from momentree._vocabulary import JointSpec, Number, Numbers, Pose, Signal, Vector, given, pose
from momentree.elements import Elements

Parent = Union[str, _core.ModelBody, None]
"""The parent of a body: a name, what ``add`` returned for it, or None for the ground."""
Shape = Union[Mapping[str, Any], Sequence[Mapping[str, Any]]]
"""As in scenario files: ``{"box": [x, y, z]}``, ``{"sphere": r}`` …, or a list of them."""
Collision = Union[Literal["shape", "none"], Shape]
"""What a body touches others with: shapes, or ``"shape"`` for those drawn."""
Belt = Mapping[str, Any]
"""A surface that runs: ``{"axis": [0, 1, 0], "speed": 0.5}``."""
Friction = Union[Number, Mapping[str, Number]]
"""A coefficient, or ``{"kinetic": …}`` with any of ``"static"``, ``"torsional"`` (m) and ``"rolling"`` (m)."""
Axes = Literal["world", "body"]
"""The axes in which a force is given."""


def _inertia(value: Any) -> Any:
    """A symmetric matrix as its six numbers; anything else as it is."""
    if np.shape(value) != (3, 3):
        return value
    matrix = np.asarray(value)
    if not (matrix == matrix.T).all():
        raise Error("inertia: the matrix is not symmetric", hint="for example (J + J.T) / 2")
    return [matrix[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]


def body_fields(
    mass: Number | None,
    com: Vector | None,
    inertia: Numbers | None,
    density: Number | None,
    at: Pose | None,
    child_at: Pose | None,
    joint: JointSpec | None,
    q: Numbers | None,
    v: Numbers | None,
    joint_name: str | None,
    shape: Shape | None,
    collision: Collision | None = None,
    belt: Belt | None = None,
) -> dict[str, Any]:
    """The arguments of ``add`` as a body's table of a scenario file."""
    if joint is not None and not isinstance(joint, JointSpec):
        raise Error(f"joint: expected a joint, found {type(joint).__name__}", hint="for example momentree.Revolute(axis=(0, 1, 0))")
    spec = joint.scenario_value() if joint is not None else {"kind": "weld"}
    bare = joint_name.rsplit("/", 1)[-1] if joint_name is not None else None
    table = {**spec, **given(at=pose(at), child_at=pose(child_at), q=q, v=v, name=bare)}
    of_mass = given(mass=mass, com=com, inertia=_inertia(inertia), density=density)
    return {**of_mass, **given(shape=shape, collision=collision, belt=belt, joint=table)}


def checked(model: Any) -> Any:
    """The model, if it is one."""
    if isinstance(model, _core.ModelBase):
        return model
    found = type(model).__name__
    hint = "a file is read by momentree.load(…)" if isinstance(model, (str, os.PathLike)) else "make a momentree.Model"
    raise Error(f"model: expected a model, found {found}", hint=hint)


class Model(Elements):
    """The mechanisms of one world, built body by body. Nothing in it moves: make a :class:`Simulation` of it.

    ``len(model)`` is the number of bodies. A model can be copied (``copy.copy``, ``copy.deepcopy``) and pickled.

    Args:
        gravity: m/s², world axes, shape (3,).
    """

    if not TYPE_CHECKING:
        __setattr__ = assign

    def __init__(self, gravity: ArrayLike = (0.0, 0.0, -9.81)) -> None:
        super().__init__(gravity)

    def add(
        self,
        name: str,
        *,
        mass: Number | None = None,
        com: Vector | None = None,
        inertia: Numbers | None = None,
        density: Number | None = None,
        parent: Parent = None,
        at: Pose | None = None,
        child_at: Pose | None = None,
        joint: JointSpec | None = None,
        q: Numbers | None = None,
        v: Numbers | None = None,
        joint_name: str | None = None,
        shape: Shape | None = None,
        collision: Collision | None = None,
        belt: Belt | None = None,
    ) -> _core.ModelBody:
        """Add a body with its inboard joint.

        Args:
            name: ``"mechanism/body"``.
            mass: kg.
            com: Centre of mass in the body's frame (m), shape (3,); default: its origin.
            inertia: About the centre of mass, body axes (kg m²): one number, three principal moments, xx, yy, zz, xy, xz, yz, or
                the symmetric matrix; default: 0, a point mass.
            density: kg/m³, in place of ``mass``, ``com`` and ``inertia``, which are then those of ``shape``, or else ``collision``.
            parent: ``None`` or ``"ground"``, the name of a body that was added before, or what ``add`` returned for it.
            at: Placement of the joint's frame in the parent's frame: a position (m), or ``{"xyz": …, "quat": …}``; default: the
                same frame.
            child_at: Placement of the joint's frame in the body's own frame, in the same way.
            joint: :func:`Revolute`, :func:`Ball` …; default: a weld.
            q: Start coordinates (rad, m, quaternion); default: zero, or the values nearest to it within hard limits.
            v: Start velocities (rad/s, m/s); default: zero.
            joint_name: ``"mechanism/joint"``; default: the body's name.
            shape: For pictures and reports: ``{"box": [x, y, z]}``, ``{"sphere": r}`` … (m).
            collision: What it touches other bodies and the floor with: shapes in the same way, or ``"shape"`` for those drawn;
                default: nothing.
            belt: Its surface runs, as that of a conveyor belt, a roller or a track: ``{"axis": …, "speed": …}``. Where the outward
                normal is n, it moves with speed · axis × n (m/s; body axes).

        Returns:
            The body, to be the parent of others.

        Raises:
            Error: A value is impossible or a name unknown or used twice; the model is unchanged.
        """
        fields = body_fields(mass, com, inertia, density, at, child_at, joint, q, v, joint_name, shape, collision, belt)
        return self._add(name, parent, fields)

    def add_floor(
        self,
        *,
        height: Number | None = None,
        normal: Vector | None = None,
        friction: Friction | None = None,
        restitution: Number | None = None,
        belt: Belt | None = None,
    ) -> None:
        """Add a plane with the ground below it.

        Args:
            height: Along its normal (m); default 0.
            normal: Of any length but zero; default: against gravity.
            friction: Of bodies on it: a coefficient, or a table as in scenarios; default 0.5.
            restitution: Of bodies on it, from 0 (default) to 1.
            belt: It runs, as in :meth:`add`; world axes.

        Raises:
            Error: A value is impossible; the model is unchanged.
        """
        self._add_floor(given(height=height, normal=normal, friction=friction, restitution=restitution, belt=belt) or True)

    def add_ground(self, collision: Shape) -> None:
        """Add planes and solids that are fixed in the world, besides the floor.

        Args:
            collision: As ``collision`` of ``[world]`` in scenarios, one or a list: ``{"box": [x, y, z], "at": {...}}``,
                ``{"plane": normal, "at": {"xyz": point}}``, ``{"heightmap": rows, "size": [x, y, z]}``.

        Raises:
            Error: A value is impossible; the model is unchanged.
        """
        self._add_ground(collision)

    def add_contact(
        self,
        between: tuple[str | _core.ModelBody, str | _core.ModelBody] | None = None,
        *,
        friction: Friction | None = None,
        restitution: Number | None = None,
        off: bool | None = None,
        name: str | None = None,
    ) -> None:
        """Set the law of contacts between bodies. The last one that names a pair applies.

        Args:
            between: Two bodies, or names of bodies or mechanisms with ``*``, or ``"ground"``; default: all with all but
                neighbours in the tree. Each name must be that of a body, but also stands for those that are added later.
            friction: A coefficient, or ``{"static": …, "kinetic": …, "torsional": …, "rolling": …}``; default 0.5.
            restitution: From 0 (default) to 1.
            off: True: they pass through each other.
            name: Of its events: ``"impact NAME"``.

        Raises:
            Error: A value is impossible or a name unknown; the model is unchanged.
        """
        pair = None if between is None else [getattr(end, "name", end) for end in between]
        self._add_contact(given(between=pair, friction=friction, restitution=restitution, off=off, name=name))

    def add_force(
        self,
        body: str | _core.ModelBody,
        *,
        force: Sequence[Signal] | NDArray[Any] | None = None,
        torque: Sequence[Signal] | NDArray[Any] | None = None,
        point: Vector | None = None,
        axes: Axes | None = None,
        drag: Mapping[str, Any] | None = None,
    ) -> None:
        """Add an external force, a torque and drag on a body.

        Args:
            body: Name of the body; with a ``*`` one force on each body that matches.
            force: Three components (N), each a number or a function of time such as ``{"sine": …}``.
            torque: Three components (N m), likewise.
            point: Where force and drag act, in the body's frame (m).
            axes: ``"world"`` (default) or ``"body"``: the axes of force and torque.
            drag: ``{"linear": N s/m, "quadratic": N s²/m², …}``, as in scenario files.

        Raises:
            Error: A value is impossible or the name unknown; the model is unchanged.
        """
        name: Any = getattr(body, "name", body)
        self._add_force(name, given(body=name, force=force, torque=torque, point=point, axes=axes, drag=drag))

    def add_loop(
        self,
        name: str,
        *,
        body: str | _core.ModelBody,
        to: Parent = None,
        joint: JointSpec,
        at: Pose | None = None,
        child_at: Pose | None = None,
        assemble: bool = True,
    ) -> None:
        """Close a loop: join a body to another, or to the ground, by a joint in addition to their inboard joints.

        Args:
            name: Name of the joint, by which events and ``world.joints`` refer to it.
            body: The joint's child: its name, or what ``add`` returned for it.
            to: The joint's parent, in the same way; ``None`` or ``"ground"``: the ground.
            joint: :func:`Ball`, :func:`Revolute` …: any kind but ``free``.
            at: Placement of the joint's frame in the frame of ``to``: a position (m), or ``{"xyz": …, "quat": …}``; default: the
                same frame.
            child_at: Placement of the joint's frame in the frame of ``body``, in the same way.
            assemble: Whether a simulation closes the loop at the start by changing the start coordinates as little as possible;
                otherwise a loop that is open at the start is an Error.

        Raises:
            Error: A value is impossible or a name unknown or used twice; the model is unchanged.
        """
        if not isinstance(joint, JointSpec):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise Error(f"joint: expected a joint, found {type(joint).__name__}", hint="for example momentree.Ball()")
        fields = {**joint.scenario_value(), **given(at=pose(at), child_at=pose(child_at), assemble=assemble)}
        self._add_loop(name, body, to, fields)

    def copy(self) -> Model:
        """An independent copy: what is added to one is not in the other."""
        copy = Model.__new__(Model)
        _core.ModelBase.__init__(copy, self)
        return copy

    def __copy__(self) -> Model:
        return self.copy()

    def __deepcopy__(self, memo: object) -> Model:
        return self.copy()

    def __reduce__(self) -> Any:
        names = list(zip(self.body_names, self.joint_names))
        return _model_from_toml, (self._to_toml_without_contact(), self._scenario_names(), names, self._contact_state())

    def __repr__(self) -> str:
        return f"<momentree.Model: {len(self)} bodies>"


def _model_from_toml(text: str, order: list[str], names: list[tuple[str, str]], contact: bytes) -> Model:
    from momentree.loading import loads

    model = Model.__new__(Model)
    _core.ModelBase.__init__(model, loads(text, name="pickle.toml").model._in_order(order, names))
    model._set_contact_state(contact)
    return model
