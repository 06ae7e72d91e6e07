"""Records: plain values that describe a world or what happened in it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Rates(NamedTuple):
    """Time derivatives of the state. The arrays are overwritten by the next evaluation."""

    qdot: Array
    """Time derivatives of q (rad/s, m/s, quaternion rates), shape (nq,)."""
    pdot: Array
    """Time derivatives of p (N m, N), shape (nv,). Equation (20)."""


class Energy(NamedTuple):
    """Energies of a world (J)."""

    kinetic: float
    """With the kinetic energy of rotors."""
    potential: float
    """Of gravity (zero at the world's origin), springs and soft stops."""

    @property
    def total(self) -> float:
        """Sum of both."""
        return self.kinetic + self.potential


class Momentum(NamedTuple):
    """Momenta of a world, world axes."""

    linear: Array
    """N s, shape (3,)."""
    angular: Array
    """N m s about the world's origin, shape (3,)."""


class Wrench(NamedTuple):
    """A force and a torque, or an impulse of both."""

    force: Array
    """N (or N s), shape (3,)."""
    torque: Array
    """N m (or N m s), shape (3,)."""


class Totals(NamedTuple):
    """Energies (J) and momenta (N s, N m s) of a whole world, world axes, the angular one about the world's origin."""

    kinetic: float
    potential: float
    linear: Array
    angular: Array

    @property
    def energy(self) -> float:
        """Kinetic and potential energy."""
        return self.kinetic + self.potential


class Mechanism(NamedTuple):
    """One tree of bodies."""

    name: str
    root: str
    grounded: bool
    """False if its root is free."""
    bodies: list[str]
    """Names, the root first, parents before children."""


@dataclass(frozen=True)
class ActionRecord:
    """What one action of an event did. Names are those just before the event, except ``joint`` of an action that makes one."""

    kind: str
    """As in scenario files: ``"break"``; ``"hit"``, ``"rest"`` and ``"leave"`` for stops."""
    target: str
    joint: str
    body: str
    to: str
    skipped: str
    """Why nothing was done; empty: it was carried out."""

    def __str__(self) -> str:
        return f"{self.kind} {self.target}" + (f" skipped: {self.skipped}" if self.skipped else "")


@dataclass(frozen=True, eq=False)
class Event:
    """An event that happened, with its certificate: what it conserved and what it lost."""

    time: float
    """s"""
    name: str
    actions: tuple[ActionRecord, ...]
    mechanisms_before: tuple[str, ...]
    mechanisms_after: tuple[str, ...]
    before: Totals
    after: Totals
    released: float
    """Energy of springs and rotors that left with their freedom (J)."""
    lost: float
    """Energy lost in the impact: the kinetic energy of the velocity jump (J)."""
    work: float
    """Energy added by impulses and new parameters (J)."""
    impulse: dict[str, Wrench] = field(default_factory=dict)
    """By joint: the parent's impulse on the child (N s, N m s) about the child's origin, in the child's axes."""
    ground_impulse: Wrench = field(default_factory=lambda: Wrench(np.zeros(3), np.zeros(3)))
    """The ground's impulse on the mechanisms about the world's origin, world axes."""
    hardest_joint: str = ""
    """The joint with the largest linear impulse."""
    duration_ns: float = 0.0
    """Time that the change itself took (ns)."""

    @property
    def linear_error(self) -> float:
        """Change of the linear momentum beyond the ground's impulse (N s): zero to round-off unless the event adds an impulse."""
        return float(np.linalg.norm(self.after.linear - self.before.linear - self.ground_impulse.force))

    @property
    def angular_error(self) -> float:
        """The same for the angular momentum (N m s)."""
        return float(np.linalg.norm(self.after.angular - self.before.angular - self.ground_impulse.torque))

    def __str__(self) -> str:
        what = "; ".join(str(action) for action in self.actions)
        return f"{self.time:.9g} s  {self.name}  {what}"


@dataclass(frozen=True)
class MissedEvent:
    """A scheduled event that has not happened so far, and why."""

    name: str
    time: float
    """When it is due (s); infinite if that depends on a condition or on another event."""
    after: str
    quantity: str
    of: list[str]
    threshold: float
    exceeds: bool
    nearest: float
    """The value that came nearest to the threshold, NaN if there was none."""
    nearest_time: float
