"""Random mechanisms for the tests of the bridge to Drake."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw  # type: ignore[import-not-found,unused-ignore]
from pydrake.multibody import plant as plants  # type: ignore[import-not-found,unused-ignore]
from pydrake.multibody import tree  # type: ignore[import-not-found,unused-ignore]

Rng = np.random.Generator
SIMPLE = ("revolute", "prismatic", "weld", "revolute")
OTHERS = ("revolute", "ball", "universal", "planar")


def _pose(rng: Rng) -> Any:
    return RigidTransform(RollPitchYaw(rng.uniform(-3, 3, 3)), rng.uniform(-0.4, 0.4, 3))


def _inertia(rng: Rng) -> Any:
    box = tree.SpatialInertia.SolidBoxWithMass(rng.uniform(0.3, 3), *rng.uniform(0.1, 0.5, 3))
    return box.ReExpress(RollPitchYaw(rng.uniform(-3, 3, 3)).ToRotationMatrix()).Shift(rng.uniform(-0.2, 0.2, 3))


def _joint(rng: Rng, kind: str, name: str, parent: Any, child: Any) -> Any:
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    make: dict[str, Callable[[], Any]] = {
        "revolute": lambda: tree.RevoluteJoint(name, parent, child, axis),
        "prismatic": lambda: tree.PrismaticJoint(name, parent, child, axis),
        "weld": lambda: tree.WeldJoint(name, parent, child, RigidTransform()),
        "ball": lambda: tree.BallRpyJoint(name, parent, child),
        "universal": lambda: tree.UniversalJoint(name, parent, child),
        "planar": lambda: tree.PlanarJoint(name, parent, child, np.zeros(3)),
    }
    return make[kind]()


def plant_of(
    rng: Rng,
    sizes: tuple[tuple[int, bool], ...],
    kinds: tuple[str, ...] = SIMPLE,
    step: float = 1e-3,
    before: Callable[[Any], None] | None = None,
) -> Any:
    """Trees ``a0``, ``a1`` … and ``b0`` … of (number of bodies, whether the tree floats), without gravity."""
    plant = plants.MultibodyPlant(step)
    if step > 0:
        plant.set_discrete_contact_approximation(plants.DiscreteContactApproximation.kSap)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    for letter, (size, floating) in zip("abc", sizes):
        bodies: list[Any] = []
        for i in range(size):
            body = plant.AddRigidBody(f"{letter}{i}", _inertia(rng))
            if i or not floating:
                parent = bodies[rng.integers(len(bodies))] if i else plant.world_body()
                outer = plant.AddFrame(tree.FixedOffsetFrame(f"{letter}{i}.outer", parent.body_frame(), _pose(rng)))
                inner = plant.AddFrame(tree.FixedOffsetFrame(f"{letter}{i}.inner", body.body_frame(), _pose(rng)))
                kind = str(rng.choice(kinds)) if i else "revolute"
                joint = plant.AddJoint(_joint(rng, kind, f"j{letter}{i}", outer, inner))
                if kind in ("revolute", "prismatic") and rng.random() < 0.4:
                    actuator = plant.AddJointActuator(f"m{letter}{i}", joint)
                    actuator.set_default_rotor_inertia(rng.uniform(0.01, 0.1))
                    actuator.set_default_gear_ratio(1.5)
            bodies.append(body)
    if before is not None:
        before(plant)
    plant.Finalize()
    return plant


def state_of(rng: Rng, plant: Any) -> Any:
    """A context with random positions and velocities."""
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, rng.uniform(-1, 1, plant.num_positions()))
    for index in plant.GetFloatingBaseBodies():
        pose = RigidTransform(RollPitchYaw(rng.uniform(-3, 3, 3)), rng.uniform(-1, 1, 3))
        plant.SetFloatingBaseBodyPoseInWorldFrame(context, plant.get_body(index), pose)
    plant.SetVelocities(context, rng.normal(size=plant.num_velocities()))
    return context


def jacobian(plant: Any, context: Any, body: str, point: Any) -> Any:
    """(6, nv) velocity of a point (world coordinates) of a body, and its angular velocity."""
    frame, world = plant.GetBodyByName(body).body_frame(), plant.world_frame()
    local = frame.CalcPoseInWorld(context).inverse() @ point
    rows = plant.CalcJacobianSpatialVelocity(context, tree.JacobianWrtVariable.kV, frame, local, world, world)
    return np.vstack([rows[3:], rows[:3]])
