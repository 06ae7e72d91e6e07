"""What a bridge returns next to the new velocities: the evidence that they are right."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Method = Literal["auto", "momentree", "projection"]
"""How velocities are computed: ``"momentree"`` converts the mechanisms and performs the change there, ``"projection"`` uses the
mass matrix of the other engine, ``"auto"`` takes the first that is applicable."""


@dataclass(frozen=True)
class Wrench:
    """A force and a torque, or the impulses of both, in world axes."""

    force: FloatArray
    """(3,) N, or N s."""
    torque: FloatArray
    """(3,) N m, or N m s, about ``point``."""
    point: FloatArray
    """(3,) m, world coordinates."""


@dataclass(frozen=True)
class Totals:
    """Energy and momentum of the whole world at an instant."""

    kinetic: float
    """J, with armatures."""
    linear: FloatArray
    """(3,) N s, world axes."""
    angular: FloatArray
    """(3,) N m s about the world's origin, world axes."""


@dataclass(frozen=True)
class Certificate:
    """How the energy and the momenta of the world changed, and how exactly the new velocities solve the equations of the impact.

    All errors are relative, and are computed from the mass matrix and the Jacobians of the engine that owns the state, however
    the velocities were computed.
    """

    action: str
    """For example ``"weld hand to crate"``."""
    method: Literal["momentree", "projection", "none"]
    """What computed the velocities; ``"none"`` if the change leaves them as they are."""
    reason: str
    """Why it was not momentree; empty if it was, or if the method was given."""
    time: float
    """s."""
    before: Totals
    after: Totals
    lost: float
    """J: kinetic energy of the velocity jump. A plastic impact loses exactly this energy. 0 for other changes."""
    work: float
    """J: what an applied impulse supplied, and compliant constraints that are not quite at rest."""
    released: float
    """J: kinetic energy of armatures that left with a joint that broke."""
    impulse: Wrench
    """What the body received through the new constraint, N s and N m s, about the constraint's point."""
    determined: bool
    """False if other impulses would have the same effect, as in a redundant loop; ``impulse`` is then the smallest of them."""
    residual: float
    """Velocity that the constraint forbids, relative to what the largest velocity could cause there."""
    balance: float
    """What the impulses do not explain of the change of momentum, relative to the momentum, in the metric of the energy."""
    energy: float
    """before + work - lost - released - after, relative to the larger of the energies."""
    drift: float
    """Change of the total momenta, relative to the sum of those of the bodies. 0 where something holds the mechanisms."""
    agreement: float | None
    """Largest difference of a velocity between the two methods, relative to the largest velocity; None if only one was used."""
    tolerance: float = 1e-12
    """The bound of the errors."""

    @property
    def errors(self) -> dict[str, float]:
        """The errors that must be within the tolerance."""
        found = {"residual": self.residual, "balance": self.balance, "energy": abs(self.energy), "drift": self.drift}
        if self.method == "momentree" and self.agreement is not None:
            found["agreement"] = self.agreement
        return found

    @property
    def ok(self) -> bool:
        """All errors are within the tolerance (and none of them is a NaN)."""
        return all(error <= self.tolerance for error in self.errors.values())

    @property
    def ground(self) -> Wrench:
        """The impulse that the world received from outside: from the ground, and from an impulse that was applied."""
        return Wrench(self.after.linear - self.before.linear, self.after.angular - self.before.angular, np.zeros(3))

    def __str__(self) -> str:
        force, torque = float(np.linalg.norm(self.impulse.force)), float(np.linalg.norm(self.impulse.torque))
        errors = ", ".join(f"{name} {error:.1e}" for name, error in self.errors.items())
        return (
            f"{self.action} at {self.time:.9g} s by {self.method}: kinetic energy {self.before.kinetic:.6g} J -> "
            f"{self.after.kinetic:.6g} J, lost {self.lost:.6g} J, impulse {force:.6g} N s and {torque:.6g} N m s; "
            f"{errors}: {'ok' if self.ok else 'NOT OK'}"
        )
