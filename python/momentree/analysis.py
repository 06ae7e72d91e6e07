"""Where a mechanism is at rest, how it vibrates, and which joint positions reach a target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Union

import numpy as np
from numpy.typing import ArrayLike

from momentree._core import Body
from momentree._errors import Error
from momentree._records import Array
from momentree.simulation import Simulation


@dataclass(frozen=True)
class DampedMode:
    """A mode of vibration with damping: an eigenvalue of A, or a pair of conjugate ones."""

    eigenvalue: complex
    """Eigenvalue (1/s): the mode is a multiple of exp(eigenvalue · t)."""
    shape: np.ndarray
    """Displacements of the degrees of freedom, complex numbers, shape (nv,); the largest one is 1."""

    @property
    def frequency(self) -> float:
        """Frequency of the vibration (Hz = 1/s); 0 without one."""
        return abs(self.eigenvalue.imag) / (2 * np.pi)

    @property
    def damping_ratio(self) -> float:
        """Damping relative to critical damping, a number; negative: it grows."""
        return -self.eigenvalue.real / abs(self.eigenvalue) if self.eigenvalue != 0 else 0.0

    @property
    def stable(self) -> bool:
        """Whether it does not grow."""
        return self.eigenvalue.real <= 1e-9 * (1 + abs(self.eigenvalue))


@dataclass(frozen=True)
class Linearization:
    """dx/dt = A x + B u for small changes x = (dq, dv) of the state and small efforts u.

    ``dq`` is a displacement like ``v * dt``: of ball and free joints a rotation (rad) and a translation (m) in child axes.
    """

    A: Array
    """State matrix, shape (2 nv, 2 nv), in SI units (m, rad, s)."""
    B: Array
    """Effect of efforts (N m, N) along the degrees of freedom, shape (2 nv, nv)."""
    projection: Array
    """Projection of x onto the changes that locks and closed loops allow, shape (2 nv, 2 nv), numbers. A counts other changes as
    the nearest allowed ones."""
    names: tuple[str, ...]
    """Degrees of freedom in the order of ``v``, named as columns of results: ``"arm/elbow.v0"``. A number of nv names."""

    def modes(self) -> list[DampedMode]:
        """Modes of A in the order of their natural frequencies: one for each pair of conjugate eigenvalues, with a number of nv
        components each. About an equilibrium they are its vibrations. Degrees of freedom that are held have none."""
        nv = len(self.names)
        basis, size, _ = np.linalg.svd(self.projection)
        basis = basis[:, size > 0.5]
        values, vectors = np.linalg.eig(basis.T @ self.A @ basis)
        modes: list[DampedMode] = []
        for value, vector in zip(values, (basis @ vectors).T, strict=True):
            if value.imag < 0:
                continue
            shape = vector[:nv]
            largest = shape[np.argmax(abs(shape))]
            modes.append(DampedMode(complex(value), shape / largest if largest != 0 else shape))
        return sorted(modes, key=lambda mode: abs(mode.eigenvalue))


@dataclass(frozen=True)
class Mode:
    """An undamped mode of vibration about an equilibrium."""

    square: float
    """Square of the angular frequency, in (rad/s)²; negative: the mechanism moves away."""
    shape: Array
    """Displacements of the degrees of freedom (m, rad), shape (nv,), so that shape · M shape = 1."""

    @property
    def frequency(self) -> float:
        """Natural frequency (Hz = 1/s); 0 if it does not vibrate."""
        return float(np.sqrt(max(self.square, 0.0)) / (2 * np.pi))


@dataclass(frozen=True)
class Equilibrium:
    """A configuration in which all forces balance: ``sim.set_state(q=found.q, v=0 * sim.v)`` moves a simulation there."""

    q: Array
    """Coordinates (rad, m), shape (nq,), in the order of ``sim.q``."""
    residual: float
    """The largest acceleration that is left (rad/s², m/s²)."""
    iterations: int
    """Number of steps that the search took."""
    modes: tuple[Mode, ...]
    """Undamped modes in the order of their squared frequencies: unstable ones (with negative squares, 1/s²) first."""
    resting: tuple[str, ...]
    """Degrees of freedom that hard stops hold, named as columns of results. A number of names."""
    taut: tuple[str, ...]
    """Names of the cables that hold, a number of them."""
    names: tuple[str, ...]
    """Degrees of freedom in the order of ``v``. A number of nv names."""

    @property
    def stable(self) -> bool:
        """Whether no mode moves away. A mode with frequency 0 is neutral: the mechanism stays where it is put."""
        return all(mode.square >= 0 for mode in self.modes)


@dataclass(frozen=True)
class Target:
    """Where a body is to be: a point of it, or its orientation, or both."""

    body: Union[str, Body]
    """Name or handle."""
    position: ArrayLike | None = None
    """Place of the point in the world (m), shape (3,)."""
    orientation: ArrayLike | None = None
    """Orientation of the body in the world: unit quaternion (w, x, y, z), shape (4,)."""
    point: ArrayLike | None = None
    """Point in the body's frame (m), shape (3,); default: its origin."""
    weight: float = 1.0
    """Importance beside other targets if not all can be reached, a number."""


@dataclass(frozen=True)
class KinematicSolution:
    """Joint positions that bring bodies to their targets: ``sim.set_state(q=found.q)`` moves a simulation there."""

    reached: bool
    """Whether all targets are reached within the tolerance. If not, ``q`` is the nearest configuration that was found."""
    q: Array
    """Coordinates (rad, m), shape (nq,), in the order of ``sim.q``."""
    position_error: float
    """The largest distance to a target (m)."""
    angle_error: float
    """The largest angle to a target's orientation (rad)."""
    iterations: int
    """Number of steps of all attempts."""
    attempts: int
    """Number of starting configurations that were tried."""


def _simulation(sim: object) -> Simulation:
    if not isinstance(sim, Simulation):
        raise Error(f"expected a simulation, not {type(sim).__name__}", hint="for example mt.Simulation(model), or mt.load(path)")
    return sim


def linearize(sim: Simulation) -> Linearization:
    """Exact derivatives of the equations of motion at the present state of a simulation, with all its forces.

    Args:
        sim: A simulation.

    Raises:
        Error: Bodies touch, a cable is taut, a function drives the world, or a joint that closes a loop has forces of its own:
            their derivatives are not available.
    """
    A, B, projection, names = _simulation(sim)._linearize()
    return Linearization(A, B, projection, tuple(names))


def equilibrium(sim: Simulation) -> Equilibrium:
    """The equilibrium that a mechanism reaches from the present configuration in a viscous fluid, without inertia.

    If it starts in an equilibrium, that is the one, stable or not. Closed loops stay closed, hard stops are not passed, cables
    are not stretched, and drives have their values at the present time. The simulation is not changed.

    Args:
        sim: A simulation.

    Raises:
        Error: There is none within reach, as for bodies that fall freely, or bodies can touch.
    """
    q, residual, iterations, squares, shapes, resting, taut, names = _simulation(sim)._equilibrium()
    modes = tuple(Mode(float(square), shape) for square, shape in zip(squares, shapes, strict=True))
    return Equilibrium(q, residual, iterations, modes, tuple(resting), tuple(taut), tuple(names))


def inverse_kinematics(
    sim: Simulation,
    targets: Target | Sequence[Target],
    *,
    tolerance: float = 1e-9,
    iterations: int = 200,
    attempts: int = 20,
    seed: int = 0,
) -> KinematicSolution:
    """Joint positions that bring points and orientations of bodies to targets, near the present configuration.

    All joints that are not locked or driven may move, within their hard stops; loops stay closed. Contacts are not considered.
    The simulation is not changed.

    Args:
        sim: A simulation.
        targets: One target, or several that are to be reached together.
        tolerance: How near is reached (m, rad).
        iterations: Steps of each attempt, at most.
        attempts: Starts: the present configuration, then random ones, until one reaches the targets. With closed loops only
            the present one is tried.
        seed: Determines the random ones.

    Raises:
        Error: A target has neither a position nor an orientation, or its body is unknown.
    """
    listed = [targets] if isinstance(targets, Target) else list(targets)
    for each in listed:
        if not isinstance(each, Target):
            raise Error(f"a target of inverse_kinematics must be an mt.Target, not {each!r}", hint='mt.Target("arm/hand", position=[0.4, 0, 0.3])')
        if not isinstance(each.weight, Real):
            raise Error(f"the weight of a target must be a number, not {each.weight!r}")
    given = [(each.body, each.position, each.orientation, each.point, float(each.weight)) for each in listed]
    return KinematicSolution(*_simulation(sim)._inverse_kinematics(given, tolerance, iterations, attempts, seed))
