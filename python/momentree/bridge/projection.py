"""The velocities after an impact, from a mass matrix M and the Jacobian J of the constraint.

In the coordinates y = L^T v with M = L L^T, the kinetic energy is |y|^2 / 2, and a plastic impact is the orthogonal projection
of y on the velocities that the constraint allows:

    v+ = v - M^-1 J^T (J M^-1 J^T)^+ J v

An orthogonal projection remains accurate where J M^-1 J^T is nearly singular, as in redundant loops.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from momentree.bridge.certificate import FloatArray

RANK = 1e-10
"""A direction of a constraint counts if it moves the bodies by more than this, relative to the largest."""


@dataclass(frozen=True)
class Rows:
    """Rows of a Jacobian.

    ``scale`` tells motion from rounding: per entry, the magnitude of the vectors of which ``matrix`` has a component.
    """

    matrix: FloatArray
    scale: FloatArray

    @staticmethod
    def none(columns: int) -> Rows:
        """No rows."""
        return Rows(np.zeros((0, columns)), np.zeros((0, columns)))

    @staticmethod
    def difference(one: FloatArray, two: FloatArray) -> Rows:
        """(6, n) a relative velocity: three components of a linear and three of an angular one."""
        magnitude = [np.linalg.norm(each[k : k + 3], axis=0) for k in (0, 3) for each in (one, two)]
        linear, angular = magnitude[0] + magnitude[1], magnitude[2] + magnitude[3]
        return Rows(one - two, np.array([linear] * 3 + [angular] * 3))

    def take(self, columns: NDArray[np.intp]) -> Rows:
        """The same rows with some of the columns."""
        return Rows(self.matrix[:, columns], self.scale[:, columns])


@dataclass(frozen=True)
class Jump:
    """The result of an impact."""

    change: FloatArray
    """(n,) of the velocities."""
    impulse: FloatArray
    """(m,) of the new rows."""
    determined: bool
    """Whether this impulse is the only one."""
    held: FloatArray
    """(n,) the generalised impulse of the rows that hold already."""
    balance: float
    """Part of M change that no impulses explain, relative to the momentum, in the metric of the energy."""


class Impact:
    """New rows, which the velocities after the impact satisfy, and rows that hold already, which transmit impulses.

    The velocity along the held rows is not changed (it may differ from zero in an engine with compliant constraints), unless the
    new rows contradict that.
    """

    def __init__(self, mass: FloatArray, new: Rows, held: Rows) -> None:
        scale = np.sqrt(np.diag(mass))
        self._factor = scale[:, None] * np.linalg.cholesky(mass / np.outer(scale, scale))
        self._new, self._new_norm = self._weighted(new)
        self._held = self._weighted(held)[0]
        self._basis = _basis(self._new)[2]

    @property
    def holds(self) -> bool:
        """Whether there are held rows."""
        return len(self._held) > 0

    def _weighted(self, rows: Rows) -> tuple[FloatArray, FloatArray]:
        """J L^-T with rows of length at most about 1, and the lengths by which they were divided."""
        weighted = np.linalg.solve(self._factor, rows.matrix.T).T
        bound = np.abs(rows.scale) @ np.abs(np.linalg.inv(self._factor).T)
        length = np.linalg.norm(bound, axis=1)
        length[length == 0] = 1.0
        return weighted / length[:, None], length

    def _transmitted(self, step: FloatArray) -> FloatArray:
        """The change that the held rows add to ``step`` so that the velocity along them stays."""
        free = self._held - (self._held @ self._basis.T) @ self._basis
        left, sizes, right = _basis(free)
        wanted = -(left.T @ (self._held @ step)) / sizes
        return np.asarray(right.T @ wanted)

    def plastic(self, v: FloatArray) -> FloatArray:
        """(n,) change of ``v`` after which the new rows are at rest."""
        change = np.zeros_like(v)
        for _ in range(2):  # the second pass removes the rounding of the first
            y = self._factor.T @ (v + change)
            step = -self._basis.T @ (self._basis @ y)
            step += self._transmitted(step)
            change += np.linalg.solve(self._factor.T, step)
        return change

    def pushed(self, push: FloatArray) -> FloatArray:
        """(n,) change of the velocities by a generalised impulse (n,)."""
        step = np.asarray(np.linalg.solve(self._factor, push), dtype=np.float64)
        step += self._transmitted(step)
        return np.asarray(np.linalg.solve(self._factor.T, step), dtype=np.float64)

    def explain(self, v: FloatArray, change: FloatArray, push: FloatArray | None = None) -> Jump:
        """The impulses that cause ``change``; ``push`` is a generalised impulse that is known."""
        y = self._factor.T @ change
        if push is not None:
            y = y - np.linalg.solve(self._factor, push)
        stacked = np.vstack([self._new, self._held])
        left, sizes, right = _basis(stacked)
        held_rank = len(_basis(self._held)[1])
        coefficients = left @ ((right @ y) / sizes)
        impulse = coefficients[: len(self._new)] / self._new_norm
        rest = y - right.T @ (right @ y)
        whole = float(np.linalg.norm(self._factor.T @ v)) + float(np.linalg.norm(self._factor.T @ (v + change)))
        balance = float(np.linalg.norm(rest)) / whole if whole > 0 else 0.0
        held = self._factor @ (self._held.T @ coefficients[len(self._new) :])
        return Jump(change, impulse, len(sizes) - held_rank == len(self._new), held, balance)


def _basis(rows: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The singular value decomposition of the rows, without the directions that are only rounding."""
    if rows.size == 0:
        return np.zeros((len(rows), 0)), np.zeros(0), np.zeros((0, rows.shape[1]))
    left, sizes, right = np.linalg.svd(rows, full_matrices=False)
    kept = sizes > RANK
    return left[:, kept], sizes[kept], right[kept]
