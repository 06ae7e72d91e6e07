"""Exudyn. Joints are items of a system; they are switched by their parameter activeConnector, and the solver continues from the
present state with those that are active. A joint that was not foreseen is added and the system assembled again. A tree of minimal
coordinates (ObjectKinematicTree) cannot change: it takes part in the evaluations."""

from __future__ import annotations

import time

import exudyn as exu
import numpy as np
from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree
from exudyn.rigidBodyUtilities import RigidBodyInertia
from peers import Array, Evaluation, EvaluationModel, Experiment, Motion, Way, main


def settings_of(step: float, steps: int) -> exu.SimulationSettings:
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = step * steps
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    return settings


class Engine:
    """`way`: "deactivate", "activate" or "add" (a joint that was not foreseen), then a step (s), 0: none."""

    def __init__(self, experiment: Experiment, way: str, step: float) -> None:
        self.e, self.way, self.step, self.elapsed = experiment, way, step, 0.0
        self.container = exu.SystemContainer()
        self.mbs = mbs = self.container.AddSystem()
        ground = mbs.CreateGround()
        self.bodies, self.joints = [], {}
        for i, (link, at) in enumerate(zip(experiment.links, experiment.start, strict=True)):
            inertia = RigidBodyInertia(mass=link.mass, com=link.com, inertiaTensor=link.inertia, inertiaTensorAtCOM=True)
            self.bodies.append(
                mbs.CreateRigidBody(
                    inertia=inertia,
                    referencePosition=at.p,
                    referenceRotationMatrix=at.R,
                    initialVelocity=at.v,
                    initialAngularVelocity=at.w,
                )
            )
            if not link.free:
                parent = ground if link.parent < 0 else self.bodies[link.parent]
                self.joints[i] = self.join(parent, self.bodies[i], at, [1, 1, 1, 1, 1, 0])
        if way == "activate":
            self.extra = self.hold()
            mbs.SetObjectParameter(self.extra, "activeConnector", False)
        mbs.Assemble()
        self.settings = settings_of(step, 1)
        integration = self.settings.timeIntegration.generalizedAlpha  # constraints of velocities: they jump
        integration.useIndex2Constraints = integration.useNewmark = True

    def join(self, parent: exu.ObjectIndex, body: exu.ObjectIndex, at: Motion, axes: list[int]) -> exu.ObjectIndex:
        return self.mbs.CreateGenericJoint(
            itemNumbers=[parent, body], position=at.p, rotationMatrixAxes=at.R, constrainedAxes=axes, useGlobalFrame=True
        )

    def hold(self) -> exu.ObjectIndex:
        """The joint that locks or captures the body where it is at the start, which is where it is at the change."""
        e, at = self.e, self.e.start[self.e.body]
        if e.change == "lock":
            return self.join(self.bodies[e.links[e.body].parent], self.bodies[e.body], at, [0, 0, 0, 0, 0, 1])
        return self.join(self.bodies[e.to], self.bodies[e.body], at, [1, 1, 1, 1, 1, 1])

    def change(self) -> None:
        if self.way == "deactivate":
            self.mbs.SetObjectParameter(self.joints[self.e.body], "activeConnector", False)
            return
        if self.way == "activate":
            self.mbs.SetObjectParameter(self.extra, "activeConnector", True)
        else:
            self.hold()
            self.mbs.Assemble()
        self.mbs.SolveDynamic(self.settings)
        self.elapsed = self.step

    def motions(self) -> list[Motion]:
        variables = exu.OutputVariableType

        def read(body: exu.ObjectIndex, variable: exu.OutputVariableType) -> Array:
            return np.array(self.mbs.GetObjectOutputBody(body, variable))

        return [
            Motion(
                read(body, variables.RotationMatrix).reshape(3, 3),
                read(body, variables.Position),
                read(body, variables.Velocity),
                read(body, variables.AngularVelocity),
            )
            for body in self.bodies
        ]


def ways(change: str) -> list[Way]:
    def way(name: str, note: str, kind: str, step: float) -> Way:
        return Way(name, note, lambda experiment: Engine(experiment, kind, step))

    if change == "cut":
        return [way("GenericJoint, activeConnector = False", "maximal coordinates: all joints are constraints", "deactivate", 0)]
    declared = "foreseen: declared beforehand, with the pose"
    return [
        way("GenericJoint, activeConnector = True, step of 1 µs", declared, "activate", 1e-6),
        way("GenericJoint, activeConnector = True, step of 1 ms", declared, "activate", 1e-3),
        way("CreateGenericJoint, Assemble, step of 1 ms", "needs to be assembled again", "add", 1e-3),
    ]


class Forward:
    """Steps of the explicit Euler method, each of which evaluates once; so many that the start of the solver does not count. The
    time of a step does not depend on the state."""

    def __init__(self, model: EvaluationModel) -> None:
        self.model = model
        self.container = exu.SystemContainer()
        self.mbs = mbs = self.container.AddSystem()
        n = len(model.links)
        node = mbs.AddNode(
            NodeGenericODE2(
                numberOfODE2Coordinates=n,
                referenceCoordinates=[0.0] * n,
                initialCoordinates=[0.0] * n,
                initialCoordinates_t=[0.0] * n,
            )
        )
        kinds = {"revolute": exu.JointType.RevoluteZ, "prismatic": exu.JointType.PrismaticZ}
        mbs.AddObject(
            ObjectKinematicTree(
                nodeNumber=node,
                gravity=[0, 0, model.gravity],
                jointTypes=[kinds[link.joint] for link in model.links],
                linkParents=[link.parent for link in model.links],
                jointTransformations=exu.Matrix3DList([link.turn for link in model.links]),
                jointOffsets=exu.Vector3DList([link.at for link in model.links]),
                linkInertiasCOM=exu.Matrix3DList([link.inertia for link in model.links]),
                linkCOMs=exu.Vector3DList([link.com for link in model.links]),
                linkMasses=[link.mass for link in model.links],
            )
        )
        mbs.Assemble()
        self.steps = 0

    def run(self, turn: int, steps: int) -> float:
        """The time that it took (s)."""
        q, u = self.model.states[turn]
        self.mbs.systemData.SetODE2Coordinates(q, exu.ConfigurationType.Initial)
        self.mbs.systemData.SetODE2Coordinates_t(u, exu.ConfigurationType.Initial)
        settings = settings_of(1e-8, steps)
        settings.timeIntegration.explicit.computeEndOfStepAccelerations = False
        settings.linearSolver.solverType = exu.LinearSolverType.EigenDense
        begin = time.perf_counter()
        self.mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.ExplicitEuler)
        return time.perf_counter() - begin

    def seconds(self, count: int) -> float:
        if self.steps == 0:
            self.steps = 20
            while self.run(0, self.steps) < 0.1:
                self.steps *= 4
        return self.run(1, self.steps) / self.steps * count

    def accelerations(self, turn: int) -> Array:
        self.run(turn, 1)
        return np.array(self.mbs.systemData.GetODE2Coordinates_tt())


if __name__ == "__main__":
    evaluation = Evaluation("ObjectKinematicTree, a step of ExplicitEuler", Forward, lambda: 0.0, floating=False, most=100)
    raise SystemExit(main("Exudyn " + exu.config.Version(), ways, [evaluation]))
