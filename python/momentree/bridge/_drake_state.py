"""A Drake state and what follows from it: Jacobians, the mass matrix, momenta, and its mechanisms in momentree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import momentree as mt
from momentree.bridge._change import Request
from momentree.bridge._drake_package import Context, MultibodyPlant, tree
from momentree.bridge.certificate import FloatArray, Totals
from momentree.bridge.projection import Rows

WORLD = 0
CONVERTED = {"revolute", "prismatic", "weld", "quaternion_floating"}
"""The joints that momentree has in the same coordinates."""


@dataclass(frozen=True)
class Reserved:
    """A weld or ball constraint that was added to a plant before it was finalised."""

    constraint: Any
    """Its number, as Drake has returned it."""
    body: Any
    """The body A of the constraint."""
    to: Any
    """The body B."""
    pose: Any
    """X_AP, the frame in A that coincides with one in B."""
    other: Any
    """X_BQ, the frame in B."""
    ball: bool
    """Whether only the origins coincide."""


class DrakeState:
    """The configuration and the velocities of a context of a plant."""

    def __init__(self, plant: MultibodyPlant, context: Context, reserved: Sequence[Reserved] = ()) -> None:
        if not plant.is_finalized():
            raise mt.Error("the plant is not finalised", "drake", "call plant.Finalize() first")
        self.plant = plant
        self.context = context
        self._scratch = plant.CreateDefaultContext()
        self._scratch.SetTimeStateAndParametersFrom(context)
        self._v: FloatArray = np.array(plant.GetVelocities(context))
        if not np.all(np.isfinite(self._v)) or not np.all(np.isfinite(plant.GetPositions(context))):
            raise mt.Error("the state is not finite", "drake", "the simulation has diverged: go back to an earlier state")
        self._reserved = self._active(reserved)
        self.joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
        self.inboard = {int(joint.child_body().index()): joint for joint in self.joints}
        self._roots: dict[int, int] = {WORLD: WORLD}
        for body in range(plant.num_bodies()):
            self.root(body)

    def _active(self, reserved: Sequence[Reserved]) -> list[Reserved]:
        known = {each.constraint: each for each in reserved}
        every = self.plant.GetConstraintIds()
        active = [number for number in every if self.plant.GetConstraintActiveStatus(self.context, number)]
        if any(number not in known for number in active):
            raise mt.Error(
                "a constraint of the plant is active, and Drake does not tell which bodies it joins",
                "drake",
                "make it by reserve() and pass it in reserved=, or deactivate it",
            )
        return [known[number] for number in active]

    @property
    def time(self) -> float:
        """s."""
        return float(self.context.get_time())

    @property
    def v(self) -> FloatArray:
        """(nv,) a copy of the velocities before the change."""
        return self._v.copy()

    def root(self, body: int) -> int:
        """The body of this mechanism whose joint moves relative to the world; the world if it cannot move."""
        if body not in self._roots:
            joint = self.inboard[body]
            above = self.root(int(joint.parent_body().index()))
            self._roots[body] = above if above or joint.num_velocities() == 0 else body
        return self._roots[body]

    def body_name(self, body: int) -> str:
        """The name of a body in the converted model; ``"ground"`` if it cannot move."""
        root = self.root(body)
        return f"tree{root}/body{body}" if root else "ground"

    def joint_name(self, body: int) -> str:
        """The name of the inboard joint of a body in the converted model."""
        return f"tree{self.root(body)}/joint{body}"

    def floats(self, bodies: Sequence[int]) -> bool:
        """Whether nothing joins these bodies to the world."""
        roots = [self.root(body) for body in bodies]
        return all(root and self.inboard[root].type_name().endswith("floating") for root in roots)

    def held(self) -> Rows:
        """(m, nv) what locked joints and active constraints hold."""
        matrix, scale = [np.zeros((0, len(self._v)))], [np.zeros((0, len(self._v)))]
        unit = np.eye(len(self._v))
        for joint in self.joints:
            if joint.num_velocities() and joint.is_locked(self.context):
                rows = unit[joint.velocity_start() : joint.velocity_start() + joint.num_velocities()]
                matrix.append(rows)
                scale.append(rows)
        for each in self._reserved:
            one, two = int(each.body.index()), int(each.to.index())
            rows6 = self.relative(one, two, self.position(one) + self.rotation(one) @ each.pose.translation())
            matrix.append(rows6.matrix[:3] if each.ball else rows6.matrix)
            scale.append(rows6.scale[:3] if each.ball else rows6.scale)
        return Rows(np.vstack(matrix), np.vstack(scale))

    def trees(self, bodies: Sequence[int], held: Rows) -> set[int]:
        """The mechanisms of these bodies, by their roots, and those that active constraints connect with them."""
        found = {self.root(body) for body in bodies} - {WORLD}
        groups = [{self.root(int(each.body.index())), self.root(int(each.to.index()))} - {WORLD} for each in self._reserved]
        for _ in groups:
            for group in groups:
                if group & found:
                    found |= group
        return found

    def dofs(self, trees: set[int]) -> NDArray[np.intp]:
        """The DoFs of mechanisms."""
        chosen = [joint for body, joint in self.inboard.items() if self.root(body) in trees]
        spans = [np.arange(joint.velocity_start(), joint.velocity_start() + joint.num_velocities()) for joint in chosen]
        return np.sort(np.concatenate(spans)).astype(np.intp) if spans else np.zeros(0, dtype=np.intp)

    def mass(self, dofs: NDArray[np.intp]) -> FloatArray:
        """(n, n) the mass matrix, with reflected inertias."""
        mass = np.array(self.plant.CalcMassMatrix(self._scratch))[np.ix_(dofs, dofs)]
        return np.asarray((mass + mass.T) / 2)

    def totals(self, v: FloatArray) -> Totals:
        """Energy and momenta at the velocities ``v`` (nv,)."""
        self.plant.SetVelocities(self._scratch, v)
        momentum = self.plant.CalcSpatialMomentumInWorldAboutPoint(self._scratch, np.zeros(3))
        mass = np.array(self.plant.CalcMassMatrix(self._scratch))
        linear, angular = np.array(momentum.translational()), np.array(momentum.rotational())
        return Totals(0.5 * float(v @ mass @ v), linear, angular)

    def momenta(self, v: FloatArray) -> float:
        """The sum of the magnitudes of the momenta of all bodies, to measure drift against."""
        self.plant.SetVelocities(self._scratch, v)
        total = 0.0
        for index in range(1, self.plant.num_bodies()):
            body = self._body(index)
            inertia = body.CalcSpatialInertiaInBodyFrame(self._scratch)
            motion = self.plant.EvalBodySpatialVelocityInWorld(self._scratch, body)
            arm = self.rotation(index) @ inertia.get_com()
            speed = float(np.linalg.norm(motion.translational() + np.cross(motion.rotational(), arm)))
            central = inertia.Shift(inertia.get_com()).CalcRotationalInertia()
            spin = float(np.max(central.get_moments())) * float(np.linalg.norm(motion.rotational()))
            total += inertia.get_mass() * speed * (1.0 + float(np.linalg.norm(self.position(index) + arm))) + spin
        return total

    def jacobian(self, body: int, point: FloatArray) -> FloatArray:
        """(6, nv): velocity of a point (world coordinates) fixed to the body, and its angular velocity; world axes."""
        local = self.rotation(body).T @ (point - self.position(body))
        world = self.plant.world_frame()
        rows = self.plant.CalcJacobianSpatialVelocity(
            self._scratch, tree.JacobianWrtVariable.kV, self._body(body).body_frame(), local, world, world
        )
        return np.vstack([rows[3:], rows[:3]])

    def relative(self, body: int, to: int, point: FloatArray) -> Rows:
        """(6, nv): the velocity of ``body`` relative to ``to``, at a point, and its relative angular velocity."""
        return Rows.difference(self.jacobian(body, point), self.jacobian(to, point))

    def position(self, body: int) -> FloatArray:
        """(3,) m, of the body's frame, world axes."""
        return np.array(self.plant.EvalBodyPoseInWorld(self._scratch, self._body(body)).translation())

    def rotation(self, body: int) -> FloatArray:
        """(3, 3) body to world."""
        return np.array(self.plant.EvalBodyPoseInWorld(self._scratch, self._body(body)).rotation().matrix())

    def quaternion(self, body: int) -> FloatArray:
        """(4,) body to world."""
        return np.array(self.plant.EvalBodyPoseInWorld(self._scratch, self._body(body)).rotation().ToQuaternion().wxyz())

    def unsuitable(self, request: Request) -> str:
        """Why momentree cannot make a change where no constraint is active; empty if it can."""
        wanted = self.trees(request.bodies, Rows.none(0))
        for joint in (each for body, each in self.inboard.items() if self.root(body) in wanted):
            if joint.type_name() not in CONVERTED:
                return f"a joint is of the kind {joint.type_name()}"
            if joint.type_name() == "quaternion_floating" and int(joint.parent_body().index()) != WORLD:
                return "a floating joint has a parent"
        if not request.joins:
            return ""
        roots = [self.root(body) for body in request.bodies]
        if len(set(roots)) < len(roots):
            return "it closes a loop"
        return "" if any(root and self.floats([root]) for root in roots) else "it closes a loop through the world"

    def by_momentree(self, request: Request, trees: set[int]) -> FloatArray:
        """(nv,) velocities after the change."""
        copy = self.simulation(trees)
        request.perform(copy)
        v = self.v
        for body, joint in self.inboard.items():
            if self.root(body) not in trees or joint.num_velocities() == 0:
                continue
            start = joint.velocity_start()
            if joint.type_name() != "quaternion_floating":
                v[start] = copy.world.joints[self.joint_name(body)].v[0]
                continue
            motion = copy.world.bodies[self.body_name(body)]
            turn = joint.frame_on_parent().CalcPoseInWorld(self._scratch).rotation().matrix().T
            arm = self.rotation(body) @ joint.frame_on_child().GetFixedPoseInBodyFrame().translation()
            v[start : start + 3] = turn @ motion.angular
            v[start + 3 : start + 6] = turn @ (np.asarray(motion.linear) + np.cross(motion.angular, arm))
        return v

    def simulation(self, trees: set[int]) -> mt.Simulation:
        """These mechanisms in momentree, without gravity, forces and limits."""
        reflected = np.zeros(len(self._v))
        for index in self.plant.GetJointActuatorIndices():
            actuator = self.plant.get_joint_actuator(index)
            reflected[actuator.joint().velocity_start()] += actuator.calc_reflected_inertia(self._scratch)
        result = mt.Model(gravity=(0.0, 0.0, 0.0))
        for body in self._downwards(trees):
            joint = self.inboard[body]
            inertia = self._body(body).CalcSpatialInertiaInBodyFrame(self._scratch)
            central = inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
            moments = tuple(float(central[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
            com = tuple(float(x) for x in inertia.get_com())
            start = joint.velocity_start()
            parent = int(joint.parent_body().index())
            fixed = self.root(parent) == WORLD
            below = joint.frame_on_child().GetFixedPoseInBodyFrame()
            if joint.type_name() == "quaternion_floating":
                turn = self.rotation(body)
                motion = self.jacobian(body, self.position(body)) @ self._v
                kind: mt.JointSpec = mt.Free()
                q = np.concatenate([self.position(body), self.quaternion(body)])
                rates = np.concatenate([turn.T @ motion[:3], turn.T @ motion[3:]])
                at, child_at, above = _place(np.zeros(3), np.array([1.0, 0, 0, 0])), None, None
            else:
                frame = joint.frame_on_parent()
                pose = frame.CalcPoseInWorld(self._scratch) if fixed else frame.GetFixedPoseInBodyFrame()
                at = _place(pose.translation(), pose.rotation().ToQuaternion().wxyz())
                child_at = _place(below.translation(), below.rotation().ToQuaternion().wxyz())
                above = None if fixed else self.body_name(parent)
                q, rates = np.zeros(0), np.zeros(0)
                if joint.num_velocities():
                    q = np.array([self.plant.GetPositions(self._scratch)[joint.position_start()]])
                    rates = self._v[start : start + 1]
                kind = _kind(joint, float(reflected[start]) if joint.num_velocities() else 0.0)
            result.add(
                self.body_name(body),
                mass=float(inertia.get_mass()),
                com=com,
                inertia=moments,
                parent=above,
                at=at,
                child_at=child_at,
                joint=kind,
                q=q,
                v=rates,
                joint_name=self.joint_name(body),
            )
        return mt.Simulation(result)

    def _downwards(self, trees: set[int]) -> list[int]:
        """Parents before children."""
        order: list[int] = []

        def visit(body: int) -> None:
            parent = int(self.inboard[body].parent_body().index())
            if self.root(parent) in trees and parent not in order:
                visit(parent)
            if body not in order:
                order.append(body)

        for body in self.inboard:
            if self.root(body) in trees:
                visit(body)
        return order

    def _body(self, index: int) -> Any:
        return self.plant.get_body(tree.BodyIndex(index))


def _kind(joint: Any, armature: float) -> mt.JointSpec:
    if joint.type_name() == "revolute":
        return mt.Revolute(axis=tuple(joint.revolute_axis()), armature=armature)
    if joint.type_name() == "prismatic":
        return mt.Prismatic(axis=tuple(joint.translation_axis()), armature=armature)
    return mt.Weld()


def _place(xyz: FloatArray, quaternion: FloatArray) -> dict[str, tuple[float, ...]]:
    return {"xyz": tuple(float(x) for x in xyz), "quat": tuple(float(x) for x in quaternion)}
