"""Drake. The topology of a finalized MultibodyPlant is fixed; joints that are made or broken at run time are constraints of a
discrete plant, declared in advance and switched by SetConstraintActiveStatus; Joint.Lock sets the joint's speed to zero. Changes
that were not foreseen need another plant, to which the state is copied."""

from __future__ import annotations

from importlib.metadata import version

import numpy as np
from peers import Array, Evaluation, EvaluationModel, Experiment, Link, Motion, Way, alternating, main, shortest
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Joint,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    RotationalInertia,
    SpatialInertia,
)
from pydrake.systems.analysis import Simulator


def transform(R: Array, p: Array) -> RigidTransform:
    return RigidTransform(RotationMatrix(R), p)


class Plant:
    """A plant with bodies and joints; a link `fixed` (-1: none) is welded to its parent."""

    def __init__(self, links: list[Link], step: float = 0.0, gravity: float = 0.0, fixed: int = -1) -> None:
        self.plant = plant = MultibodyPlant(time_step=step)
        plant.mutable_gravity_field().set_gravity_vector([0, 0, gravity])
        self.bodies: list[RigidBody] = []
        self.joints: list[Joint | None] = []
        for i, link in enumerate(links):
            entries = link.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            central = RotationalInertia(*entries)
            inertia = SpatialInertia.MakeFromCentralInertia(link.mass, link.com, central) if link.mass > 0 else SpatialInertia.Zero()
            self.bodies.append(body := plant.AddRigidBody(link.name, inertia))
            joint = None
            if not link.free:
                parent = plant.world_body() if link.parent < 0 else self.bodies[link.parent]
                place = transform(link.turn, link.at)
                if i == fixed:
                    plant.WeldFrames(parent.body_frame(), body.body_frame(), place)
                else:
                    frame = plant.AddFrame(FixedOffsetFrame(link.name + "_inboard", parent.body_frame(), place))
                    kind = PrismaticJoint if link.joint == "prismatic" else RevoluteJoint
                    joint = plant.AddJoint(kind(link.name, frame, body.body_frame(), [0, 0, 1]))
            self.joints.append(joint)

    def finish(self) -> None:
        self.plant.Finalize()
        self.context = self.plant.CreateDefaultContext()

    def put(self, i: int, motion: Motion) -> None:
        """The state of a free body."""
        self.plant.SetFreeBodyPose(self.context, self.bodies[i], transform(motion.R, motion.p))
        self.plant.SetFreeBodySpatialVelocity(self.context, self.bodies[i], SpatialVelocity(motion.w, motion.v))

    def start(self, links: list[Link]) -> None:
        for i, link in enumerate(links):
            joint = self.joints[i]
            if joint is None:
                self.put(i, link.start)
            elif isinstance(joint, PrismaticJoint):
                joint.set_translation(self.context, link.angle)
                joint.set_translation_rate(self.context, link.rate)
            else:
                joint.set_angle(self.context, link.angle)
                joint.set_angular_rate(self.context, link.rate)

    def read(self, i: int) -> Motion:
        pose = self.bodies[i].EvalPoseInWorld(self.context)
        velocity = self.bodies[i].EvalSpatialVelocityInWorld(self.context)
        return Motion(pose.rotation().matrix(), pose.translation(), velocity.translational(), velocity.rotational())


class Engine:
    """`way`: "rebuild", "disable" (a broken pin), "lock" or "weld"; `step` of the discrete plant (s), 0: a continuous one."""

    def __init__(self, experiment: Experiment, way: str, step: float) -> None:
        self.e, self.way, self.step, self.elapsed = experiment, way, step, 0.0
        self.links = list(experiment.links)
        link, self.ids = experiment.links[experiment.body], []
        if way == "disable":
            self.loosen(experiment.start[experiment.body])
        self.now = Plant(self.links, step)
        plant, bodies = self.now.plant, self.now.bodies
        if way == "disable":  # the pin is two points on its axis
            for z in (0.0, 0.1):
                point = np.array([0, 0, z])
                parent = bodies[link.parent]
                self.ids.append(plant.AddBallConstraint(parent, link.at + link.turn @ point, bodies[experiment.body], point))
        if way == "weld":  # where the bodies will be
            outer = experiment.start[link.parent if experiment.change == "lock" else experiment.to]
            inner = experiment.start[experiment.body]
            relative = transform(outer.R.T @ inner.R, outer.R.T @ (inner.p - outer.p))
            carrier = bodies[link.parent if experiment.change == "lock" else experiment.to]
            self.ids.append(plant.AddWeldConstraint(carrier, relative, bodies[experiment.body], RigidTransform()))
        self.now.finish()
        if way == "weld":
            plant.SetConstraintActiveStatus(self.now.context, self.ids[0], False)
        self.now.start(self.links)
        if way in ("lock", "weld"):
            self.simulator = Simulator(plant, self.now.context)
            self.simulator.Initialize()

    def loosen(self, motion: Motion) -> None:
        old = self.links[self.e.body]
        self.links[self.e.body] = Link(old.name, -1, "free", old.mass, 0, 0, motion.R, motion.p, old.com, old.inertia, motion.v, motion.w)

    def change(self) -> None:
        if self.way == "rebuild":
            self.rebuild()
        elif self.way == "disable":
            for constraint in self.ids:
                self.now.plant.SetConstraintActiveStatus(self.now.context, constraint, False)
        else:
            if self.way == "lock":
                joint = self.now.joints[self.e.body]
                assert joint is not None
                joint.Lock(self.now.context)
            else:
                self.now.plant.SetConstraintActiveStatus(self.now.context, self.ids[0], True)
            self.simulator.AdvanceTo(self.step)
            self.elapsed = self.step

    def rebuild(self) -> None:
        old, e, fixed = self.now, self.e, -1
        held = old.read(e.body)
        if e.change == "cut":
            self.loosen(held)
        if e.change == "capture":
            hand, link = old.read(e.to), self.links[e.body]
            relative, fixed = (hand.R.T @ held.R, hand.R.T @ (held.p - hand.p)), e.body
            self.links[fixed] = Link(link.name, e.to, "weld", link.mass, 0, 0, *relative, link.com, link.inertia, link.linear, link.angular)
        self.now = Plant(self.links, 0.0, fixed=fixed)
        self.now.finish()
        plant, context = self.now.plant, self.now.context
        q, v = plant.GetPositions(context), plant.GetVelocities(context)
        q_before, v_before = old.plant.GetPositions(old.context), old.plant.GetVelocities(old.context)
        for joint, before in zip(self.now.joints, old.joints, strict=True):
            if joint is not None and before is not None:
                q[joint.position_start()] = q_before[before.position_start()]
                v[joint.velocity_start()] = v_before[before.velocity_start()]
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        for i, joint in enumerate(self.now.joints):
            if joint is None and i != fixed:
                self.now.put(i, old.read(i))
        self.now.bodies[-1].EvalSpatialVelocityInWorld(context)  # of all bodies at once

    def motions(self) -> list[Motion]:
        return [self.now.read(i) for i in range(len(self.links))]


def ways(change: str) -> list[Way]:
    def way(name: str, note: str, kind: str, step: float) -> Way:
        return Way(name, note, lambda experiment: Engine(experiment, kind, step))

    if change == "cut":
        return [
            way("rebuild, Finalize, copy the state", "needs a rebuild", "rebuild", 0),
            way("SetConstraintActiveStatus of two ball constraints", "foreseen: the pin is constraints until then", "disable", 1e-3),
        ]
    declared = "foreseen: declared beforehand, with the pose"
    found = [
        way("AddWeldConstraint, activated, step of 1 µs", declared, "weld", 1e-6),
        way("AddWeldConstraint, activated, step of 1 ms", declared, "weld", 1e-3),
    ]
    if change == "lock":
        return [*found, way("Joint.Lock, step of 1 µs", "zeroes the joint's speed", "lock", 1e-6)]
    return [*found, way("rebuild with WeldFrames, copy the rest", "needs a rebuild; takes on the hand's velocity", "rebuild", 0)]


class Forward:
    """EvalTimeDerivatives of a continuous plant, by articulated bodies."""

    def __init__(self, model: EvaluationModel) -> None:
        self.model = model
        self.on = Plant(model.links, 0.0, model.gravity)
        self.on.finish()
        self.on.start(model.links)
        plant, context = self.on.plant, self.on.context
        self.rows = [-1 if joint is None else joint.velocity_start() for joint in self.on.joints]
        self.states = []
        for q, u in model.states:
            x = plant.GetPositionsAndVelocities(context).copy()
            for i, joint in enumerate(self.on.joints):
                if joint is not None:
                    x[joint.position_start()], x[plant.num_positions() + joint.velocity_start()] = q[i], u[i]
            self.states.append(x)
        self.seconds = alternating(lambda: self.evaluate(0), lambda: self.evaluate(1))

    def evaluate(self, turn: int) -> None:
        self.on.plant.SetPositionsAndVelocities(self.on.context, self.states[turn])
        self.on.plant.EvalTimeDerivatives(self.on.context)

    def accelerations(self, turn: int) -> Array:
        self.evaluate(turn)
        rates = self.on.plant.EvalTimeDerivatives(self.on.context).get_generalized_velocity().CopyToVector()
        found = np.array([0.0 if row < 0 else rates[row] for row in self.rows])
        if not self.model.floating:
            return found
        root = self.on.bodies[0].EvalSpatialAccelerationInWorld(self.on.context)
        return np.concatenate([found, root.translational(), root.rotational()])


def overhead() -> float:
    """The same calls on a plant without bodies."""
    plant = MultibodyPlant(0.0)
    plant.Finalize()
    context, nothing = plant.CreateDefaultContext(), np.zeros(0)

    def calls() -> None:
        plant.SetPositionsAndVelocities(context, nothing)
        plant.EvalTimeDerivatives(context)

    return shortest(calls)


if __name__ == "__main__":
    evaluation = Evaluation("EvalTimeDerivatives", Forward, overhead)
    raise SystemExit(main("Drake " + version("drake"), ways, [evaluation]))
