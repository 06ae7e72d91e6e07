"""DART. Joints are locked by their actuator type, or held with impulses by the constraint solver (SERVO, WeldJointConstraint) in
the next step. In C++ a skeleton can be split and grafted by joints of other kinds (../dart.cpp); in Python split and moveTo keep the
kind of the joint, so a body that gets another kind of joint is replaced by one of the same properties, to which its children move."""

from __future__ import annotations

import dartpy as dart
import numpy as np
from peers import Array, Evaluation, EvaluationModel, Experiment, Link, Motion, Way, alternating, main, shortest

dynamics = dart.dynamics
WORLD = dynamics.Frame.World()


def pose(R: Array, p: Array) -> dart.math.Isometry3:
    made = dart.math.Isometry3()
    made.set_rotation(R)
    made.set_translation(p)
    return made


class World:
    """Bodies and joints, each mechanism in a skeleton of its own, or `together` in one."""

    def __init__(self, links: list[Link], gravity: float = 0.0, step: float = 1e-3, together: bool = False) -> None:
        self.world = dart.simulation.World()
        self.world.setGravity([0, 0, gravity])
        self.world.setTimeStep(step)
        self.nodes: list[dynamics.BodyNode] = []
        for link in links:
            parent = None if link.parent < 0 else self.nodes[link.parent]
            new = not self.nodes or (parent is None and not together)
            skeleton = dynamics.Skeleton(link.name) if new else (parent or self.nodes[0]).getSkeleton()
            self.nodes.append(self.add(skeleton, parent, link))
            if new:
                self.world.addSkeleton(skeleton)
        for link, node in zip(links, self.nodes, strict=True):
            if link.free:
                self.put(node, link.start)
            else:
                node.getParentJoint().setPosition(0, link.angle)
                node.getParentJoint().setVelocity(0, link.rate)

    @staticmethod
    def add(skeleton: dynamics.Skeleton, parent: dynamics.BodyNode | None, link: Link) -> dynamics.BodyNode:
        kind = {"free": "Free", "revolute": "Revolute", "prismatic": "Prismatic", "weld": "Weld"}[link.joint]
        joint, node = getattr(skeleton, f"create{kind}JointAndBodyNodePair")(parent)
        joint.setName(link.name)
        node.setName(link.name)
        node.setInertia(dynamics.Inertia(link.mass, link.com, link.inertia))
        if not link.free:
            joint.setTransformFromParentBodyNode(pose(link.turn, link.at))
        if link.joint in ("revolute", "prismatic"):
            joint.setAxis([0, 0, 1])
        return node

    @staticmethod
    def put(node: dynamics.BodyNode, motion: Motion) -> None:
        joint = node.getParentJoint()
        joint.setTransform(pose(motion.R, motion.p))
        joint.setSpatialVelocity(np.concatenate([motion.w, motion.v]), WORLD, WORLD)

    def read(self, i: int) -> Motion:
        node = self.nodes[i]
        at = node.getTransform()
        return Motion(at.rotation(), at.translation(), node.getLinearVelocity(), node.getAngularVelocity())


class Engine:
    """`way`: "replace", "servo", "lock" or "weld"; `step` (s) of the step in which the change acts, 0: none."""

    def __init__(self, experiment: Experiment, way: str, step: float) -> None:
        self.e, self.way, self.step, self.elapsed = experiment, way, step, 0.0
        self.on = World(experiment.links, step=step or 1e-3)

    def change(self) -> None:
        e, on = self.e, self.on
        body = on.nodes[e.body]
        joint = body.getParentJoint()
        if self.way == "replace":
            self.replace()
        elif self.way == "lock":
            joint.setActuatorType(dynamics.ActuatorType.LOCKED)
        elif self.way == "servo":  # holds still with any force required
            joint.setActuatorType(dynamics.ActuatorType.SERVO)
            joint.setForceLowerLimit(0, -np.inf)
            joint.setForceUpperLimit(0, np.inf)
            joint.setCommand(0, 0)
        else:
            weld = dart.constraint.WeldJointConstraint(on.nodes[e.to], body)
            on.world.getConstraintSolver().addConstraint(weld)
        if self.step > 0:
            on.world.step()
            self.elapsed = self.step

    def replace(self) -> None:
        """A body on another kind of joint, in the place and with the children of the old one."""
        e, on, link = self.e, self.on, self.e.links[self.e.body]
        old, held = on.nodes[e.body], on.read(e.body)
        if e.change == "cut":
            skeleton, parent = dynamics.Skeleton("part"), None
            place, joint = (held.R, held.p), "free"
        else:
            hand, parent = on.read(e.to), on.nodes[e.to]
            skeleton = parent.getSkeleton()
            place, joint = (hand.R.T @ held.R, hand.R.T @ (held.p - hand.p)), "weld"
        made = Link(link.name, e.to, joint, link.mass, 0, 0, *place, link.com, link.inertia, held.v, held.w)
        on.nodes[e.body] = node = on.add(skeleton, parent, made)
        if joint == "free":
            on.put(node, held)
            on.world.addSkeleton(skeleton)
        emptied = old.getSkeleton()
        for child in [old.getChildBodyNode(k) for k in range(old.getNumChildBodyNodes())]:
            child.moveTo(skeleton, node)
        old.remove()
        if joint == "weld":
            on.world.removeSkeleton(emptied)

    def motions(self) -> list[Motion]:
        return [self.on.read(i) for i in range(len(self.e.links))]


def ways(change: str) -> list[Way]:
    def way(name: str, note: str, kind: str, step: float) -> Way:
        return Way(name, note, lambda experiment: Engine(experiment, kind, step))

    solver, usual = "impulse of the constraint solver", "the same at a usual step"
    if change == "cut":
        return [way("a body on a FreeJoint in its place, moveTo", "", "replace", 0)]
    if change == "lock":
        return [
            way("SERVO at speed 0, step of 1 µs", solver, "servo", 1e-6),
            way("SERVO at speed 0, step of 1 ms", usual, "servo", 1e-3),
            way("LOCKED, step of 1 µs", "zeroes the joint's speed", "lock", 1e-6),
        ]
    return [
        way("WeldJointConstraint, step of 1 µs", solver, "weld", 1e-6),
        way("WeldJointConstraint, step of 1 ms", usual, "weld", 1e-3),
        way("a body on a WeldJoint in its place, moveTo", "takes on the hand's velocity", "replace", 0),
    ]


class Forward:
    def __init__(self, model: EvaluationModel) -> None:
        self.model = model
        self.on = World(model.links, model.gravity, together=True)
        self.skeleton = skeleton = self.on.nodes[0].getSkeleton()
        self.rows = [node.getParentJoint().getIndexInSkeleton(0) for node in self.on.nodes]
        self.states = []
        for q, u in model.states:
            positions, velocities = skeleton.getPositions(), skeleton.getVelocities()
            for i, link in enumerate(model.links):
                if not link.free:
                    positions[self.rows[i]], velocities[self.rows[i]] = q[i], u[i]
            self.states.append((positions, velocities))
        self.seconds = alternating(lambda: self.evaluate(0), lambda: self.evaluate(1))

    def evaluate(self, turn: int) -> None:
        positions, velocities = self.states[turn]
        self.skeleton.setPositions(positions)
        self.skeleton.setVelocities(velocities)
        self.skeleton.computeForwardDynamics()

    def accelerations(self, turn: int) -> Array:
        self.evaluate(turn)
        found = self.skeleton.getAccelerations()[self.rows]
        if not self.model.floating:
            return found
        found[0] = 0
        root = self.on.nodes[0]
        return np.concatenate([found, root.getLinearAcceleration(), root.getAngularAcceleration()])


def overhead() -> float:
    """The same calls on a skeleton without bodies."""
    skeleton, nothing = dynamics.Skeleton(), np.zeros(0)

    def calls() -> None:
        skeleton.setPositions(nothing)
        skeleton.setVelocities(nothing)
        skeleton.computeForwardDynamics()

    return shortest(calls)


if __name__ == "__main__":
    evaluation = Evaluation("computeForwardDynamics", Forward, overhead)
    raise SystemExit(main("DART " + dart.__version__, ways, [evaluation]))
