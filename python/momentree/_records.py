"""Records: plain values that describe a world or what happened in it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from momentree._views import StateView

Array = NDArray[np.float64]
"""An array of doubles."""


class Rates(NamedTuple):
    """Time derivatives of the state. The arrays are overwritten by the next evaluation; copy what is to be kept.

    Packed by joint number, as ``sim.q`` and ``sim.p``.
    """

    qdot: StateView
    """Time derivatives of q (rad/s, m/s; of quaternions: 1/s), shape (nq,). Equations (21) to (27) of the paper."""
    pdot: StateView
    """Time derivatives of the canonical momenta p (N m, N), shape (nv,). Equation (20) of the paper."""


class Contact(NamedTuple):
    """A point at which two bodies touch. Vectors are in world axes, of shape (3,)."""

    one: str
    """Name of the first body."""
    other: str
    """Name of the second body, or ``"ground"``."""
    point: Array
    """Where they touch (m), shape (3,)."""
    normal: Array
    """Unit vector from ``other`` to ``one``, shape (3,)."""
    force: Array
    """Force on ``one`` (N), shape (3,): that along the normal, and friction. Of redundant points, such as the corners of a box,
    forces that only press; while contacts are stepped through, means over the last step."""
    slip: Array
    """Velocity of ``one``, less that of ``other``, along the surface (m/s), shape (3,)."""
    slips: bool
    """Whether it slips; otherwise it sticks, or has no friction."""
    determined: bool | None
    """False if redundant contacts leave the force open: this is one of those possible. None while it is stepped through."""
    moment: Array
    """Moment on ``one`` of torsional and rolling friction (N m), shape (3,)."""


class Energy(NamedTuple):
    """Energies of a world (J)."""

    kinetic: float
    """Kinetic energy (J), that of rotors included."""
    potential: float
    """Energy (J) of gravity (zero at the world's origin), springs and soft stops."""

    @property
    def total(self) -> float:
        """Kinetic and potential energy (J)."""
        return self.kinetic + self.potential


class Momentum(NamedTuple):
    """Momenta of a world, world axes."""

    linear: Array
    """Linear momentum (N s), shape (3,)."""
    angular: Array
    """Angular momentum about the world's origin (N m s), shape (3,)."""


class Wrench(NamedTuple):
    """A force and a torque, or an impulse of both."""

    force: Array
    """Force (N), or linear impulse (N s), shape (3,)."""
    torque: Array
    """Torque (N m), or angular impulse (N m s), shape (3,)."""


class Coupling(NamedTuple):
    """An exact coupling of joints."""

    joint: str
    """Name of the joint in the model."""
    follows: str | None
    """Name of the joint that it follows; ``None`` if it is held."""
    ended: bool
    """True once one of its joints broke, left the world or was changed."""
    effort: float
    """Effort on the joint along its DoF (N m or N); −f′(q) times that acts on the joint that it follows. 0 if it has ended."""
    determined: bool
    """False if redundant equations leave the effort open."""


class EventContact(NamedTuple):
    """Where bodies hit each other, came to rest on each other, or began to slip, to stick or to part. World axes."""

    one: str
    """Name of the body on which the impulse acts."""
    other: str
    """Name of the other body, or ``"ground"``."""
    point: Array
    """Where they touch (m), shape (3,)."""
    normal: Array
    """Unit vector from the other body to the first one, shape (3,)."""
    impulse: Array
    """Impulse on the first body (N s), shape (3,); of several points of the two bodies, the sum. Zero of all but impacts."""
    scaled: float
    """A number from 0 to 1: the part of the expansion that the law of impact let happen."""
    in_turn: bool
    """True if simultaneous contacts were taken in turn."""
    cable: str = ""
    """Name of the cable that became taut or slack; empty if the bodies touch."""


class LoopStatus(NamedTuple):
    """The equations of all closed loops of a world."""

    rows: int
    """Number of equations; 0 without loops."""
    rank: int
    """How many of them are independent."""
    residual: float
    """By how much the loops are open: the largest error of an equation (m, or the sine of an angle)."""


class Totals(NamedTuple):
    """Energies and momenta of a whole world, just before or after an event."""

    kinetic: float
    """Kinetic energy (J)."""
    potential: float
    """Potential energy (J)."""
    linear: Array
    """Linear momentum (N s), world axes, shape (3,)."""
    angular: Array
    """Angular momentum about the world's origin (N m s), world axes, shape (3,)."""
    loops: LoopStatus = LoopStatus(0, 0, 0.0)
    """The equations of the closed loops."""

    @property
    def energy(self) -> float:
        """Kinetic and potential energy (J)."""
        return self.kinetic + self.potential


class Mechanism(NamedTuple):
    """One tree of bodies at an instant."""

    name: str
    """Its name; a part that comes off is named after its root body."""
    root: str
    """Name of its root body."""
    grounded: bool
    """True if its root is joined to the ground; False if it is free."""
    bodies: list[str]
    """Names, the root first, parents before children."""


@dataclass(frozen=True)
class ActionRecord:
    """What one action of an event did. Names are those just before the event, except ``joint`` of an action that makes one."""

    kind: str
    """As in scenario files: ``"break"``; ``"hit"``, ``"rest"`` and ``"leave"`` for stops; ``"add"`` and ``"remove"`` for bodies."""
    target: str
    """What was acted on, as text: ``"chain/41"``, ``"satellite/hull to tug/gripper"``."""
    joint: str
    """The joint that it acted on or made, or an empty string."""
    body: str
    """The body that it acted on, or an empty string."""
    to: str
    """The body that ``body`` was joined to, ``"ground"`` or an empty string."""
    skipped: str
    """Why nothing was done; empty: it was carried out."""
    spring: str = ""
    """The spring that it acted on, or an empty string."""

    def __str__(self) -> str:
        return f"{self.kind} {self.target}" + (f" skipped: {self.skipped}" if self.skipped else "")


@dataclass(frozen=True, eq=False, repr=False)
class Event:
    """An event that happened, with its certificate: what it conserved and what it lost.

    Events are compared by identity.
    """

    time: float
    """When it happened (s)."""
    name: str
    """Its name, as given by ``named`` or in the scenario; otherwise made from its actions."""
    actions: tuple[ActionRecord, ...]
    """What its actions did, in order."""
    mechanisms_before: tuple[str, ...]
    """Names of the mechanisms before it."""
    mechanisms_after: tuple[str, ...]
    """Names of the mechanisms after it."""
    before: Totals
    """Energies and momenta of the world just before it."""
    after: Totals
    """Energies and momenta of the world just after it."""
    released: float
    """Energy of springs and rotors that left with their freedom (J)."""
    lost: float
    """Energy lost in the impact: the kinetic energy of the velocity jump (J)."""
    work: float
    """Energy added by impulses and new parameters (J)."""
    impulse: dict[str, Wrench] = field(default_factory=dict[str, Wrench])
    """By joint: the parent's impulse on the child (N s, N m s) about the child's origin, in the child's axes, shapes (3,)."""
    ground_impulse: Wrench = field(default_factory=lambda: Wrench(np.zeros(3), np.zeros(3)))
    """The ground's impulse on the mechanisms (N s, N m s) about the world's origin, world axes, shapes (3,)."""
    hardest_joint: str = ""
    """Name of the joint with the largest linear impulse; empty if no joint transmitted one."""
    duration_ns: float = 0.0
    """Time that the change itself took (ns)."""
    contact: EventContact | None = None
    """Of an event at a contact: its bodies, point, normal and impulse; otherwise None."""
    reason: str = ""
    """Why contacts are stepped through from then on, or that no finite force lets a contact slip on; otherwise empty."""
    stepped: tuple[str, ...] = ()
    """The mechanisms whose contacts are stepped through from then on, or located again; empty for other events."""

    @property
    def linear_error(self) -> float:
        """Change of the linear momentum beyond the ground's impulse (N s): zero to round-off unless the event adds an impulse."""
        return float(np.linalg.norm(self.after.linear - self.before.linear - self.ground_impulse.force))

    @property
    def angular_error(self) -> float:
        """Change of the angular momentum beyond the ground's impulse (N m s), about the world's origin."""
        return float(np.linalg.norm(self.after.angular - self.before.angular - self.ground_impulse.torque))

    def __str__(self) -> str:
        what = "; ".join(str(action) for action in self.actions) or self.reason or ", ".join(self.stepped)
        if self.contact is not None:
            what = f"cable {self.contact.cable}" if self.contact.cable else f"{self.contact.one} and {self.contact.other}"
            what += f"  {self.reason}" if self.reason else ""
        return f"{self.time:.9g} s  {self.name}  {what}"

    def __repr__(self) -> str:
        return f"<momentree.Event: {self}>"


@dataclass(frozen=True)
class MissedEvent:
    """A scheduled event that has not happened so far, and why."""

    name: str
    """Its name; may be empty."""
    time: float
    """When it is due (s); infinite if that depends on a condition or on another event."""
    after: str
    """The event that it waits for, or an empty string."""
    quantity: str
    """The quantity of its condition, or an empty string."""
    of: list[str]
    """Joints, bodies or mechanisms that the quantity belongs to."""
    threshold: float
    """Threshold of the condition, in the quantity's SI unit."""
    exceeds: bool
    """True if the quantity has to rise above the threshold, False if it has to fall below it."""
    nearest: float
    """The value that came nearest to the threshold, in the same unit, NaN if there was none."""
    nearest_time: float
    """When the quantity had that value (s)."""
