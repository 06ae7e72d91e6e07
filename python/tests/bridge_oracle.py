"""The velocities after an impact in 50 digits, from a mass matrix and a Jacobian: v+ = v - M^-1 J^T (J M^-1 J^T)^+ J v."""

from __future__ import annotations

from typing import Any

import mpmath  # type: ignore[import-untyped,import-not-found,unused-ignore]
import numpy as np

DIGITS = 50


def evaluated(model: Any, data: Any) -> Any:
    """A copy of the state, evaluated."""
    import mujoco  # type: ignore[import-untyped,import-not-found,unused-ignore]

    copy = mujoco.MjData(model)
    copy.qpos[:], copy.qvel[:] = data.qpos, data.qvel
    copy.mocap_pos[:], copy.mocap_quat[:] = data.mocap_pos, data.mocap_quat
    mujoco.mj_forward(model, copy)
    return copy


def jacobian(model: Any, data: Any, body: str | None, point: Any) -> Any:
    """(6, nv) velocity of a point of a body, and its angular velocity; ``data`` is evaluated."""
    import mujoco  # type: ignore[import-untyped,import-not-found,unused-ignore]

    rows = np.zeros((6, model.nv))
    if body is not None:
        number = model.body(body).id
        mujoco.mj_jacBody(model, data, rows[:3], rows[3:], number)
        arm = point - data.xpos[number]
        for i in range(model.nv):
            rows[:3, i] += np.cross(rows[3:, i], arm)
    return rows


def mass_matrix(model: Any, data: Any) -> Any:
    """(nv, nv); ``data`` is evaluated."""
    import mujoco  # type: ignore[import-untyped,import-not-found,unused-ignore]

    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    return mass


def plastic(mass: Any, rows: Any, v: Any) -> Any:
    """(nv,) velocities after ``rows`` were brought to rest."""
    with mpmath.workdps(DIGITS):
        metric, jac, before = mpmath.matrix(mass), mpmath.matrix(rows), mpmath.matrix(v)
        solved = _solve(metric, jac.T)
        values, vectors = mpmath.eigsy(jac * solved)
        cutoff = max(abs(value) for value in values) * mpmath.mpf("1e-24")  # below: rounding of the Jacobian, in a redundant loop
        rate = vectors.T * (jac * before)
        scaled = mpmath.matrix([r / value if value > cutoff else mpmath.mpf(0) for r, value in zip(rate, values)])
        return np.array([float(x) for x in before - solved * (vectors * scaled)])


def pushed(mass: Any, push: Any, v: Any) -> Any:
    """(nv,) velocities after a generalised impulse."""
    with mpmath.workdps(DIGITS):
        return np.array([float(x) for x in mpmath.matrix(v) + _solve(mpmath.matrix(mass), mpmath.matrix(push))])


def _solve(metric: Any, right: Any) -> Any:
    """M^-1 B by Cholesky's factorisation."""
    factor = mpmath.cholesky(metric)
    n = metric.rows
    result = right.copy()
    for column in range(result.cols):
        for i in range(n):
            known = sum(factor[i, k] * result[k, column] for k in range(i))
            result[i, column] = (result[i, column] - known) / factor[i, i]
        for i in reversed(range(n)):
            known = sum(factor[k, i] * result[k, column] for k in range(i + 1, n))
            result[i, column] = (result[i, column] - known) / factor[i, i]
    return result


def error(value: Any, reference: Any, before: Any) -> float:
    """Relative to the largest velocity."""
    return float(np.max(np.abs(value - reference)) / max(np.max(np.abs(reference)), np.max(np.abs(before))))
