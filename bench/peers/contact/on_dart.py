"""DART, with its defaults but for the collision detector: Bullet's, as the default one has no capsules. The chain hangs from a constraint,
which is removed. Links between the hinges of a body have 1e-5 of its mass. Variant "fcl": the default detector."""

from __future__ import annotations

import dartpy as dart
import numpy as np
from engine import Row, links, main
from scenes import Array, Scene

dynamics = dart.dynamics
WORLD = dynamics.Frame.World()


def pose(R: object, p: object) -> dart.math.Isometry3:
    made = dart.math.Isometry3()
    made.set_rotation(np.reshape(R, (3, 3)))
    made.set_translation(np.array(p))
    return made


class World:
    def __init__(self, scene: Scene, step: float, variant: str) -> None:
        self.scene, self.step = scene, step
        self.world = dart.simulation.World()
        self.world.setGravity([0, 0, -9.81])
        self.world.setTimeStep(step)
        solver = self.world.getConstraintSolver()
        solver.setCollisionDetector(dart.collision.FCLCollisionDetector() if variant == "fcl" else dart.collision.BulletCollisionDetector())
        self.nodes: list[dynamics.BodyNode] = []
        for i, body in enumerate(scene.bodies):
            if body.parent < 0:
                skeleton = dynamics.Skeleton(body.name)
                joint, node = skeleton.createFreeJointAndBodyNodePair()
                self.fill(node, i)
                self.put(joint, i)
                self.world.addSkeleton(skeleton)
            else:
                node = self.nodes[body.parent]
                made = links(scene, i)
                for k, link in enumerate(made):
                    joint, node = node.getSkeleton().createRevoluteJointAndBodyNodePair(node)
                    hinge = link["hinge"]
                    joint.setTransformFromParentBodyNode(pose(link["R"], link["p"]))
                    if k + 1 == len(made):
                        joint.setTransformFromChildBodyNode(pose(np.eye(3), link["anchor"]))
                        self.fill(node, i)
                    else:
                        little = 1e-5 * scene.bodies[i].mass
                        node.setInertia(dynamics.Inertia(little, np.zeros(3), 1e-2 * little * np.eye(3)))
                    joint.setAxis(np.array(hinge.axis) / np.linalg.norm(hinge.axis))
                    joint.setDampingCoefficient(0, hinge.damping)
                    joint.setPosition(0, hinge.q)
            self.nodes.append(node)
        off = solver.getCollisionOption().collisionFilter
        for one, other in scene.off:
            off.addBodyNodePairToBlackList(self.nodes[one], self.nodes[other])
        for node in self.nodes:
            if node.getParentBodyNode() is None:
                node.getSkeleton().enableSelfCollisionCheck()
                node.getSkeleton().enableAdjacentBodyCheck()
        self.world.addSkeleton(self.floor(variant))
        self.held = None
        if scene.held:
            body = scene.bodies[0]
            where = np.array(body.p) + np.reshape(body.R, (3, 3)) @ scene.held
            self.held = dart.constraint.BallJointConstraint(self.nodes[0], where)
            solver.addConstraint(self.held)

    def fill(self, node: dynamics.BodyNode, i: int) -> None:
        body = self.scene.bodies[i]
        node.setName(body.name)
        node.setInertia(dynamics.Inertia(body.mass, np.array(body.com), np.reshape(body.inertia, (3, 3))))
        for shape in body.shapes:
            if shape.kind == "box":
                form = dynamics.BoxShape(np.array(shape.size))
            elif shape.size[1] > 0:
                form = dynamics.CapsuleShape(shape.size[0], 2 * shape.size[1])
            else:
                form = dynamics.SphereShape(shape.size[0])
            self.touch(node, form).setRelativeTransform(pose(shape.R, shape.p))

    def touch(self, node: dynamics.BodyNode, form: dynamics.Shape) -> dynamics.ShapeNode:
        made = node.createShapeNode(form)
        made.createCollisionAspect()
        made.createDynamicsAspect()
        made.getDynamicsAspect().setFrictionCoeff(self.scene.friction)
        return made

    def floor(self, variant: str) -> dynamics.Skeleton:
        skeleton = dynamics.Skeleton("floor")
        _, node = skeleton.createWeldJointAndBodyNodePair()
        form = dynamics.BoxShape(np.array([40.0, 40.0, 2.0]))
        self.touch(node, form).setRelativeTransform(pose(np.eye(3), [0, 0, -1]))
        return skeleton

    def put(self, joint: dynamics.FreeJoint, i: int) -> None:
        body = self.scene.bodies[i]
        joint.setTransform(pose(body.R, body.p))
        joint.setSpatialVelocity(np.concatenate([body.w, body.v]), WORLD, WORLD)

    @property
    def time(self) -> float:
        return float(self.world.getTime())

    def advance(self, until: float) -> None:
        for _ in range(round((until - self.world.getTime()) / self.step)):
            self.world.step()

    def release(self) -> None:
        self.world.getConstraintSolver().removeConstraint(self.held)

    def state(self) -> Row:
        R: list[Array] = []
        p, v, w = [], [], []
        for node in self.nodes:
            at = node.getTransform()
            R.append(at.rotation()), p.append(at.translation())
            v.append(node.getCOMLinearVelocity()), w.append(node.getAngularVelocity())
        return np.array(R), np.array(p), np.array(v), np.array(w)

    def note(self) -> str:
        return ""


if __name__ == "__main__":
    main(World)
