"""A MuJoCo state and what follows from it: poses, Jacobians, the mass matrix, momenta."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

import momentree as mt
from momentree.bridge._mujoco_package import MjData, MjModel, mujoco
from momentree.bridge.certificate import FloatArray, Totals
from momentree.bridge.projection import Rows

WORLD = 0


class State:
    """The configuration and the velocities of ``data``, evaluated on a copy, so that ``data`` stays as it is."""

    def __init__(self, model: MjModel, data: MjData) -> None:
        if data.model is not model and (data.qpos.shape != (model.nq,) or data.qvel.shape != (model.nv,)):
            raise mt.Error("the data belongs to another model", "mujoco", "pass the model with which the MjData was made")
        self.model = model
        self.data = copy.copy(data)
        self._v: FloatArray = np.array(data.qvel, dtype=np.float64)
        for name in ("qpos", "qvel"):
            if not np.all(np.isfinite(getattr(data, name))):
                raise mt.Error(f"data.{name} is not finite", "mujoco", "the simulation has diverged: go back to an earlier state")
        self.data.qvel[self.data.qvel == 0.0] = -0.0  # wakes sleeping trees, for which MuJoCo would compute nothing
        mujoco.mj_kinematics(model, self.data)
        mujoco.mj_comPos(model, self.data)
        mujoco.mj_tendon(model, self.data)
        mujoco.mj_makeM(model, self.data)

    @property
    def time(self) -> float:
        """s."""
        return float(self.data.time)

    @property
    def v(self) -> FloatArray:
        """(nv,) a copy of the velocities before the change."""
        return self._v.copy()

    def mass(self, dofs: NDArray[np.intp]) -> FloatArray:
        """(n, n) the mass matrix, with armatures, of DoFs that are not coupled with others."""
        nv = int(self.model.nv)
        mass = np.zeros((len(dofs), len(dofs)))
        unit, column = np.zeros(nv), np.zeros(nv)
        for i, dof in enumerate(dofs):
            unit[dof] = 1.0
            mujoco.mj_mulM(self.model, self.data, column, unit)
            unit[dof] = 0.0
            mass[:, i] = column[dofs]
        return (mass + mass.T) / 2

    def trees(self, bodies: Sequence[int], held: Rows) -> set[int]:
        """The kinematic trees of these bodies, and those that active equality constraints connect with them."""
        tree_of_dof = np.array(self.model.dof_treeid)
        found = {int(self.model.body_treeid[body]) for body in bodies} - {-1}
        groups = [set(tree_of_dof[np.flatnonzero(row)].tolist()) for row in held.matrix]
        grown = True
        while grown:
            grown = False
            for group in groups:
                if group & found and not group <= found:
                    found |= group
                    grown = True
        return found

    def dofs(self, trees: set[int]) -> NDArray[np.intp]:
        """The DoFs of kinematic trees."""
        return np.flatnonzero(np.isin(np.array(self.model.dof_treeid), list(trees)))

    def jacobian(self, body: int, point: FloatArray) -> FloatArray:
        """(6, nv): velocity of a point (world coordinates) fixed to the body, and its angular velocity; world axes."""
        rows = np.zeros((6, int(self.model.nv)))
        mujoco.mj_jac(self.model, self.data, rows[:3], rows[3:], point, body)
        return rows

    def relative(self, body: int, to: int, point: FloatArray) -> Rows:
        """(6, nv): the velocity of ``body`` relative to ``to``, at a point, and its relative angular velocity."""
        return Rows.difference(self.jacobian(body, point), self.jacobian(to, point))

    def position(self, body: int) -> FloatArray:
        """(3,) m, of the body's frame, world axes."""
        return np.array(self.data.xpos[body], dtype=np.float64)

    def quaternion(self, body: int) -> FloatArray:
        """(4,) of the body's frame, body to world."""
        return np.array(self.data.xquat[body], dtype=np.float64)

    def rotation(self, body: int) -> FloatArray:
        """(3, 3) body to world."""
        return np.array(self.data.xmat[body], dtype=np.float64).reshape(3, 3)

    def totals(self, v: FloatArray) -> Totals:
        """Energy and momenta at the velocities ``v`` (nv,)."""
        self.data.qvel[:] = v
        mujoco.mj_comVel(self.model, self.data)
        mujoco.mj_subtreeVel(self.model, self.data)
        moved = np.zeros(int(self.model.nv))
        mujoco.mj_mulM(self.model, self.data, moved, v)
        linear = np.array(self.data.subtree_linvel[WORLD]) * float(self.model.body_subtreemass[WORLD])
        angular = np.array(self.data.subtree_angmom[WORLD]) + np.cross(self.data.subtree_com[WORLD], linear)
        return Totals(0.5 * float(v @ moved), linear, angular)

    def momenta(self, v: FloatArray) -> float:
        """The sum of the magnitudes of the momenta of all bodies at ``v``, to measure drift against."""
        self.data.qvel[:] = v
        mujoco.mj_comVel(self.model, self.data)
        total = 0.0
        for body in range(1, int(self.model.nbody)):
            velocity = np.zeros(6)
            mujoco.mj_objectVelocity(self.model, self.data, int(mujoco.mjtObj.mjOBJ_BODY), body, velocity, 0)
            at = np.array(self.data.xipos[body])
            linear = float(self.model.body_mass[body]) * np.linalg.norm(velocity[3:])
            spin = float(np.max(self.model.body_inertia[body])) * np.linalg.norm(velocity[:3])
            total += float(linear * (1.0 + np.linalg.norm(at)) + spin)
        return total

    def held(self) -> Rows:
        """(m, nv) the Jacobian of all active equality constraints."""
        nv = int(self.model.nv)
        if not np.any(self.data.eq_active):
            return Rows.none(nv)
        mujoco.mj_flex(self.model, self.data)
        mujoco.mj_makeConstraint(self.model, self.data)
        number = int(self.data.nefc)
        kinds = np.array(self.data.efc_type[:number])
        chosen = np.flatnonzero(kinds == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY))
        matrix = np.zeros((number, nv))
        if mujoco.mj_isSparse(self.model):
            for row in chosen:
                start, length = int(self.data.efc_J_rowadr[row]), int(self.data.efc_J_rownnz[row])
                columns = self.data.efc_J_colind[start : start + length]
                matrix[row, columns] = self.data.efc_J[start : start + length]
        else:
            matrix[:] = np.array(self.data.efc_J[: number * nv]).reshape(number, nv)
        rows, numbers = matrix[chosen], np.array(self.data.efc_id)[chosen]
        scale = np.abs(rows)
        for number in np.unique(numbers):
            scale[numbers == number] = np.max(np.abs(rows[numbers == number]), axis=0)
        return Rows(rows, scale)
