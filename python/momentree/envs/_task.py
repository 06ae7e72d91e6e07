"""What environments have in common: an arm in one or many worlds, its actions, and its episodes. Arrays have a row per world."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from momentree._errors import Error
from momentree._records import Array, Event
from momentree._vocabulary import Action
from momentree.batch import Batch, Group
from momentree.envs._arm import PlanarArm
from momentree.envs._canvas import Canvas
from momentree.envs._one import Indices, OneWorld, Worlds
from momentree.model import Model

Mask = NDArray[np.bool_]


@dataclass
class Outcome:
    """What a step brought, a row per world."""

    reward: Array
    terminated: Mask
    truncated: Mask
    events: dict[int, list[Event]] = field(default_factory=dict[int, list[Event]])
    """The changes of topology in this step, by world."""


class Task(ABC):
    """Episodes of an arm in one world (``worlds=None``, on a simulation) or in many (on a batch).

    Args:
        model: With the arm's joints first.
        arm: The arm.
        worlds: How many, or None.
        threads: Of the batch.
        max_steps: After which an episode is truncated.
    """

    period = 0.04
    """Time between actions, s."""
    substeps = 4
    """Steps of integration in a period."""

    def __init__(self, model: Model, arm: PlanarArm, worlds: int | None, threads: int, max_steps: int) -> None:
        if max_steps < 1:
            raise Error(f"max_steps: expected at least 1, found {max_steps}")
        self.arm = arm
        self.max_steps = max_steps
        h = self.period / self.substeps
        self.worlds: Worlds = OneWorld(model, step=h) if worlds is None else Batch(model, worlds, threads=threads)
        n = len(self.worlds)
        self.steps = np.zeros(n, dtype=np.int64)
        self.q: Array = np.zeros((n, arm.joints))
        """Joint angles (rad)."""
        self.v: Array = np.zeros((n, arm.joints))
        """Joint velocities (rad/s)."""
        self.points = arm.points(self.q)
        self._groups: list[Group] = self.worlds.groups
        self._events: dict[int, list[Event]] = {}

    # What a task defines

    observation_space: spaces.Space[Any]
    action_space: spaces.Space[Any]

    @abstractmethod
    def begin(self, worlds: Indices, random: Sequence[np.random.Generator], options: Mapping[str, Any]) -> None:
        """Begin new episodes in these worlds, each with its own generator."""

    @abstractmethod
    def undo(self, worlds: Indices) -> None:
        """Give these worlds of a batch the model's topology again."""

    @abstractmethod
    def observe(self) -> Array:
        """Observations, shape (worlds, …)."""

    @abstractmethod
    def act(self, action: Array, active: Mask) -> Array:
        """Take the actions and move the active worlds by a period; returns their rewards."""

    @abstractmethod
    def ended(self) -> Mask:
        """The worlds whose task has come to its end."""

    @abstractmethod
    def info(self) -> dict[str, NDArray[Any]]:
        """Further numbers, a row per world."""

    @abstractmethod
    def draw(self, canvas: Canvas, world: int) -> None:
        """Draw a world."""

    # Episodes

    def reset(self, worlds: Indices, random: Sequence[np.random.Generator], options: Mapping[str, Any] | None) -> None:
        """Begin new episodes in these worlds."""
        if not len(worlds):
            return
        if isinstance(self.worlds, OneWorld):
            self.worlds.renew()
        else:
            self.undo(worlds)
        self.steps[worlds] = 0
        self.begin(worlds, random, options or {})
        self.read()

    def step(self, action: Array, active: Mask) -> Outcome:
        """Make a step in the active worlds; the others stay as they are, with reward 0."""
        self._events = {}
        self.steps += active
        reward = np.where(active, self.act(action, active), 0.0)
        terminated = active & (self.ended() | self.worlds.diverged)
        return Outcome(reward, terminated, active & ~terminated & (self.steps >= self.max_steps), self._events)

    def checked(self, action: Any) -> Array:
        """Actions of all worlds as numbers, after checks of shape, kind and NaN."""
        space, n = self.action_space, len(self.worlds)
        shape = (n, *(space.shape or ()))
        array = np.asarray(action)
        if isinstance(self.worlds, OneWorld):
            array = array[None, ...]
        if array.shape != shape:
            first = 1 if isinstance(self.worlds, OneWorld) else 0
            raise Error(
                f"action: expected an array of shape {shape[first:]}, found {array.shape[first:]}",
                hint="env.action_space.sample() is one that fits",
            )
        if not np.issubdtype(array.dtype, np.number):
            raise Error(f"action: expected numbers, found an array of dtype {array.dtype}")
        if isinstance(space, spaces.MultiDiscrete):
            if not np.issubdtype(array.dtype, np.integer) or (array < 0).any() or (array >= space.nvec).any():
                raise Error(f"action: expected integers from 0 to {(space.nvec - 1).tolist()}")
        elif not np.isfinite(array).all():
            bad = np.argwhere(~np.isfinite(array))[0]
            raise Error(f"action: world {bad[0]} has {array[tuple(bad)]} in component {bad[1]}", hint="expected finite numbers")
        return array.astype(np.float64)

    # The arm

    def read(self) -> None:
        """Read the arm's state."""
        self._groups = self.worlds.groups
        for group in self._groups:
            self.q[group.worlds] = group.q[:, : self.arm.joints]
            self.v[group.worlds] = group.v[:, : self.arm.joints]
        self.points = self.arm.points(self.q)

    @property
    def tip(self) -> Array:
        """Where the tip is, m, shape (worlds, 2)."""
        return self.points[:, -1]

    def push(self, torque: Array, only: Mask | None = None) -> None:
        """Set the motors' torques (N m), shape (worlds, joints), from now on, in all worlds or some."""
        for group in self._groups:
            chosen = group.worlds if only is None else group.worlds[only[group.worlds]]
            if len(chosen):
                effort = np.zeros((len(chosen), group.v.shape[1]))
                effort[:, : self.arm.joints] = torque[chosen]
                self.worlds.set_effort(effort, chosen)

    def state_of(self, worlds: Indices) -> tuple[Array, Array, Array]:
        """Copies of q, v and p of some worlds, in ascending order and of one topology; each a row per world."""
        for group in self.worlds.groups:
            if worlds[0] in group.worlds:
                rows = np.searchsorted(group.worlds, worlds)
                return np.array(group.q[rows]), np.array(group.v[rows]), np.array(group.p[rows])
        raise AssertionError("every world is in a group")

    def change(self, worlds: Indices, *actions: Action, name: str) -> None:
        """Apply actions in some worlds, as one event in each."""
        for world, event in zip(worlds, self.worlds.apply(worlds, *actions, name=name), strict=True):
            self._events.setdefault(int(world), []).append(event)
        self._groups = []  # they have changed: read() again


def point_given(options: Mapping[str, Any], key: str, worlds: int) -> Array | None:
    """The option ``key`` as a point (m) for each world, shape (worlds, 2), or None."""
    if options.get(key) is None:
        return None
    point = np.asarray(options[key], dtype=np.float64)
    if point.shape not in ((2,), (worlds, 2)) or not np.isfinite(point).all():
        raise Error(f"options: {key}: expected two finite numbers (x, y in m)")
    return np.broadcast_to(point, (worlds, 2))


def angles_given(options: Mapping[str, Any], worlds: int, joints: int) -> Array | None:
    """The option ``q`` as angles (rad) for each world, shape (worlds, joints), or None."""
    if options.get("q") is None:
        return None
    q = np.asarray(options["q"], dtype=np.float64)
    if q.shape not in ((joints,), (worlds, joints)) or not np.isfinite(q).all():
        raise Error(f"options: q: expected {joints} finite numbers (rad)")
    return np.broadcast_to(q, (worlds, joints))


def unknown_options(options: Mapping[str, Any], known: Sequence[str]) -> None:
    """Raises Error for options that the task does not know."""
    for key in options:
        if key not in (*known, "reset_mask"):
            raise Error(f"options: unknown key '{key}'", hint=f"the keys are {', '.join(known)}")


def annulus(random: np.random.Generator, inner: float, outer: float, angle: float) -> Array:
    """A point at a distance of inner … outer (m) from the shoulder and at ±angle (rad), shape (2,)."""
    radius, turn = random.uniform(inner, outer), random.uniform(-angle, angle)
    return radius * np.array([np.cos(turn), np.sin(turn)])
