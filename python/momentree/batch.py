"""Batches: many worlds of one model, stepped in the CPU's vectors or one by one, on several threads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from momentree import _core
from momentree._attributes import assign
from momentree._errors import Error
from momentree._records import Array, Event
from momentree._vocabulary import Action
from momentree._world import Columns
from momentree.model import Model, checked

Worlds = Union[None, int, slice, Sequence[int], NDArray[Any]]
"""All worlds (``None``), one, a slice, numbers, or a mask of booleans of shape (worlds,)."""
Precision = Literal["float64", "float32"]
"""Of the arithmetic of a batch."""
Variables = Literal["momenta", "velocities"]
"""What the states of a batch hold beside the coordinates."""
ContactMethod = Literal["stepping", "rk4", "dopri5", "dop853"]
"""How worlds of a batch with contact are integrated."""


def _fixed(array: Array) -> Array:
    # A copy of the worlds' numbers: writing into it would have no effect, and must not look as if it had.
    array.flags.writeable = False
    return array


class Group(NamedTuple):
    """The worlds that have the same topology at present, with their arrays (copies)."""

    worlds: NDArray[np.intp]
    """Their numbers, ascending, shape (len(worlds),)."""
    q: Array
    """Coordinates (rad, m, quaternions), shape (len(worlds), nq)."""
    v: Array
    """Velocities (rad/s, m/s), shape (len(worlds), nv)."""
    p: Array
    """Canonical momenta (N m s, N s), shape (len(worlds), nv)."""

    def __repr__(self) -> str:
        return f"<momentree.Group: {len(self.worlds)} worlds, {self.q.shape[1]} coordinates, {self.v.shape[1]} degrees of freedom>"


class JointColumns(NamedTuple):
    """A joint in all worlds; NaN where it is of another kind than in the model, or was removed. One that closes a loop has no p."""

    q: Array
    """Coordinates (rad, m, quaternion), shape (worlds, nq of its kind)."""
    v: Array
    """Velocities (rad/s, m/s), shape (worlds, nv of its kind)."""
    p: Array
    """Canonical momenta (N m s, N s), shape (worlds, nv of its kind)."""


class BodyColumns(NamedTuple):
    """A body's frame in all worlds, world axes; NaN where it was removed."""

    position: Array
    """Origin of the body's frame (m), shape (worlds, 3)."""
    quaternion: Array
    """Orientation, unit quaternion (w, x, y, z), shape (worlds, 4)."""
    linear: Array
    """Velocity of the frame's origin (m/s), shape (worlds, 3)."""
    angular: Array
    """Angular velocity (rad/s), shape (worlds, 3)."""


class Batch(_core.BatchBase):
    """Many worlds of one model. Every world may change its topology at any instant.

    ``len(batch)`` is the number of worlds. Arrays that are read are copies and can't be written; assign a whole array instead, or
    use ``set_state`` for some of the worlds. A batch may be used by one thread at a time; ``step`` and ``run`` release the GIL.

    A world's results do not depend on the other worlds or on the number of threads. Worlds are stepped by ``rk4`` in the CPU's
    vectors, with all forces in joints. If the model has contact, cables, forces on bodies, springs between points, hard stops or
    strengths, they are stepped one by one, as simulations: with contact and cables by ``contact_method``. Batches call no Python
    functions. Closed loops: states that are set are brought to the nearest ones that close them.

    Args:
        model: The model.
        worlds: How many worlds; all begin in the model's start state.
        threads: Number of threads; 0: as many as the machine has.
        precision: ``"float64"``, or ``"float32"``: faster, seven digits; changes are always made in double precision.
        variables: Of the states, ``"momenta"`` or ``"velocities"``, as for :class:`Simulation`; default: velocities with closed loops
            or couplings, else momenta. Both can be read and set in any case; the one that the states do not hold costs an evaluation.
            Worlds with contact hold velocities.
        contact_method: ``"stepping"`` steps through contacts; ``"rk4"``, ``"dopri5"`` and ``"dop853"`` locate every instant at
            which they change.
        step: Of worlds that are stepped one by one: their longest step (s), of adaptive methods the first. A longer step of the
            batch is divided. Without effect on worlds in vectors.

    Raises:
        Error: Bodies overlap, the model has Python functions, or an argument is impossible.
    """

    if not TYPE_CHECKING:
        __setattr__ = assign

    def __init__(
        self,
        model: Model,
        worlds: int,
        *,
        threads: int = 0,
        precision: Precision = "float64",
        variables: Variables | None = None,
        contact_method: ContactMethod = "stepping",
        step: float = 1e-3,
    ) -> None:
        super().__init__(checked(model), worlds, threads, precision, variables, contact_method, step)
        self._joint_names = [*model.joint_names, *model.loop_names]
        self._body_names = model.body_names
        self._effort: Array | None = None

    def _numbers(self, worlds: Worlds) -> list[int]:
        count = len(self)
        if worlds is None:
            return list(range(count))
        if isinstance(worlds, slice):
            return list(range(count))[worlds]
        array = np.atleast_1d(np.asarray(worlds))
        if array.dtype == np.bool_:
            if array.shape != (count,):
                raise Error(f"worlds: a mask has shape ({count},), not {array.shape}")
            return [int(i) for i in np.flatnonzero(array)]
        if array.size and not np.issubdtype(array.dtype, np.integer):
            raise Error(f"worlds: expected numbers of worlds, found an array of dtype {array.dtype}")
        return [int(i) for i in array.ravel()]

    @property
    def q(self) -> Array:
        """Coordinates (rad, m, quaternions), shape (worlds, nq), a copy; assign an array to set them, with velocities kept.

        Raises Error while worlds have different topologies: see :attr:`groups`.
        """
        return _fixed(self._read(self._numbers(None), "q"))

    @q.setter
    def q(self, values: ArrayLike) -> None:
        self.set_state(q=values)

    @property
    def v(self) -> Array:
        """Velocities (rad/s, m/s), shape (worlds, nv), a copy; assign an array to set them. Raises Error as :attr:`q` does."""
        return _fixed(self._read(self._numbers(None), "v"))

    @v.setter
    def v(self, values: ArrayLike) -> None:
        self.set_state(v=values)

    @property
    def p(self) -> Array:
        """Canonical momenta (N m s, N s), shape (worlds, nv), a copy; assign an array to set them. Raises Error as :attr:`q` does."""
        return _fixed(self._read(self._numbers(None), "p"))

    @p.setter
    def p(self, values: ArrayLike) -> None:
        self.set_state(p=values)

    def set_state(
        self,
        worlds: Worlds = None,
        *,
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
        p: ArrayLike | None = None,
        time: ArrayLike | None = None,
    ) -> None:
        """Set the state of some worlds, which must have the same topology.

        Args:
            worlds: Which; default: all.
            q: Shape (worlds, nq); without ``v`` and ``p`` the velocities are kept.
            v: Shape (worlds, nv).
            p: Shape (worlds, nv), instead of ``v``.
            time: s, one number or shape (worlds,).

        Raises:
            Error: The worlds have different topologies, a shape is wrong, a number is not finite, ``v`` and ``p`` are both given, or a
                loop can't be closed; nothing has changed.
        """
        numbers = self._numbers(worlds)

        def rows(values: ArrayLike | None, dimensions: int) -> Any:
            if values is None:
                return None
            array = np.asarray(values)
            if array.ndim == dimensions - 1:  # one row for all
                array = np.broadcast_to(array, (len(numbers), *array.shape))
            return array

        self._write(numbers, rows(q, 2), rows(v, 2), rows(p, 2), rows(time, 1))

    def reset(self, worlds: Worlds = None) -> None:
        """Return worlds to the model's start state, time and topology, without extra efforts.

        Args:
            worlds: Which, of any topologies; default: all.

        Raises:
            Error: There is no such world.
        """
        numbers = self._numbers(worlds)
        self._reset(numbers)
        if worlds is None:
            self._effort = None
        elif self._effort is not None:
            self._effort[numbers] = 0

    @property
    def effort(self) -> Array:
        """Extra efforts along the degrees of freedom (N m, N), shape (worlds, nv), as they were set last, a copy; assign an array.

        They act until they are set again. When a joint changes to another kind, those of the joint end, and the others stay with
        their joints. Raises Error while worlds have different topologies, and after a change of all of them until they are set.
        """
        shape = self.v.shape
        if self._effort is None:
            return _fixed(np.zeros(shape))
        if self._effort.shape != shape:
            raise Error("the efforts were set before the topology changed", hint="set them for the joints that there are now")
        return _fixed(self._effort.copy())

    @effort.setter
    def effort(self, values: ArrayLike) -> None:
        self.set_effort(values)

    def set_effort(self, effort: ArrayLike | Mapping[str, ArrayLike], worlds: Worlds = None) -> None:
        """Set extra efforts of some worlds, which act until they are set again.

        Args:
            effort: N m or N, shape (worlds, nv), or (nv,) for all of them; or by the names of joints, zero for others:
                ``{"arm/elbow": 2.0}``, a number for all worlds, or shape (worlds,) or (worlds, nv of the joint).
            worlds: Which, of the same topology; default: all.

        Raises:
            Error: The worlds have different topologies, the shape is wrong, or a number is not finite; nothing has changed.
        """
        numbers = self._numbers(worlds)
        array = np.asarray(effort) if not isinstance(effort, Mapping) else self._efforts_by_name(effort, numbers)
        if array.ndim == 1:
            array = np.broadcast_to(array, (len(numbers), *array.shape))
        self._set_efforts(numbers, array)
        if worlds is None or self._effort is None or self._effort.shape[1] != array.shape[1]:
            self._effort = np.zeros((len(self), array.shape[1]))
        self._effort[numbers] = array

    def _efforts_by_name(self, efforts: Mapping[str, ArrayLike], worlds: list[int]) -> Array:
        array = np.zeros((len(worlds), self._read(worlds, "v").shape[1]))
        for name, given in efforts.items():
            layout = self._layout(worlds[0], name) if worlds else None
            if layout is None:
                raise Error(f"effort: there is no joint {name!r} in the tree of these worlds", hint="batch.joints has their names")
            first, width = layout[3], layout[4]
            values = np.asarray(given, dtype=np.float64)
            try:
                array[:, first : first + width] = values[:, np.newaxis] if values.ndim == 1 else values
            except ValueError:
                shape = f"({len(worlds)},) or ({len(worlds)}, {width})"
                raise Error(f"effort: {name!r} needs a number or an array of shape {shape}, found {values.shape}") from None
        return array

    def apply(self, worlds: Worlds, *actions: Action, name: str | None = None) -> list[Event]:
        """Carry out actions now in some worlds, as one event in each.

        Args:
            worlds: Which; ``None``: all.
            actions: As for :meth:`Simulation.apply`.
            name: Of the events.

        Returns:
            The events with their certificates, one for each of the worlds, in their order.

        Raises:
            Error: An action is impossible in one of the worlds; that world and those after it are unchanged.
        """
        return self._apply(self._numbers(worlds), [(action.key, action.scenario_value()) for action in actions], name or "")

    def contact_forces(self, body: str | _core.ModelBody, worlds: Worlds = None) -> Array:
        """Sum of the forces of contacts on a body (N), world axes, shape (len(worlds), 3), a copy.

        Zero where it touches nothing, NaN where it was removed. After the state or topology was set: those with which the next
        step begins.

        Args:
            body: A body of the model, its name, or ``"ground"``.
            worlds: Which, also of different topologies; default: all.

        Raises:
            Error: There is no such body or world, or another thread is using the batch.
        """
        name = body.name if isinstance(body, _core.ModelBody) else body
        return _fixed(self._contact_forces(name, self._numbers(worlds)))

    @property
    def group(self) -> NDArray[np.intp]:
        """Number of the topology of each world, from 0, shape (worlds,): worlds with the same number have the same topology."""
        return np.asarray(self._groups(), dtype=np.intp)

    @property
    def groups(self) -> list[Group]:
        """The worlds by topology, with their arrays: q of shape (worlds of the group, nq), v and p of shape (…, nv), copies."""
        numbers = self.group
        all_groups: list[Group] = []
        for number in range(int(numbers.max()) + 1):
            worlds = np.flatnonzero(numbers == number)
            chosen = [int(i) for i in worlds]
            all_groups.append(Group(worlds, *(_fixed(self._read(chosen, which)) for which in ("q", "v", "p"))))
        return all_groups

    @property
    def diverged(self) -> NDArray[np.bool_]:
        """True for worlds whose last step diverged, ended where loops can't be closed, or was impossible. Shape (worlds,).

        Impossible is a step from a state in which bodies overlap by more than 1 mm. They stay where they were until their state is
        set; :meth:`message` says why.
        """
        return np.asarray(self._diverged(), dtype=np.bool_)

    @property
    def joints(self) -> Mapping[str, JointColumns]:
        """The model's joints in all worlds, also those that close loops: ``batch.joints["arm/elbow"].q`` has shape (worlds, nq)."""
        return Columns(self._joint_names, self._joint, keep=False)

    @property
    def bodies(self) -> Mapping[str, BodyColumns]:
        """The model's bodies in all worlds, by name: ``batch.bodies["arm/hand"].position`` has shape (worlds, 3)."""
        return Columns(self._body_names, self._body, keep=False)

    def _joint(self, name: str) -> JointColumns:
        columns: dict[str, Array] = {}
        start_kind, width_q, width_v = self._start_layout(name)
        for group in self.groups:
            layout = self._layout(int(group.worlds[0]), name)
            if layout is None:
                loop = self._loop_rows([int(i) for i in group.worlds], name)
                if loop is not None and loop[0] == start_kind:
                    for key, rows in (("q", loop[1]), ("v", loop[2])):
                        columns.setdefault(key, np.full((len(self), rows.shape[1]), np.nan))[group.worlds] = rows
                continue
            kind, first_q, nq, first_v, nv = layout
            if kind != start_kind:
                continue
            for key, source, first, width in (("q", group.q, first_q, nq), ("v", group.v, first_v, nv), ("p", group.p, first_v, nv)):
                target = columns.setdefault(key, np.full((len(self), width), np.nan))
                target[group.worlds] = source[:, first : first + width]
        widths = {"q": width_q, "v": width_v, "p": width_v}
        return JointColumns(*(_fixed(columns.get(key, np.full((len(self), width), np.nan))) for key, width in widths.items()))

    def _body(self, name: str) -> BodyColumns:
        rows = _fixed(self._motions(name))
        return BodyColumns(rows[:, 0:3], rows[:, 3:7], rows[:, 7:10], rows[:, 10:13])

    def __repr__(self) -> str:
        alone = "" if self.lanes > 1 else ", stepped one by one"
        return f"<momentree.Batch: {len(self)} worlds, {int(self.group.max()) + 1} topologies{alone}>"
