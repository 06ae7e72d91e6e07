"""Random models and states for the tests: every kind of joint, branching trees, springs, drives and couplings of efforts."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

import momentree as mt

KINDS = ["Revolute", "Prismatic", "Helical", "Cylindrical", "Universal", "Ball", "Planar", "Free", "Weld"]


def unit(rng: random.Random, size: int) -> list[float]:
    """A random direction."""
    while True:
        numbers = [rng.gauss(0, 1) for _ in range(size)]
        length = float(np.linalg.norm(numbers))
        if length > 0.1:
            return [x / length for x in numbers]


def vector(rng: random.Random, size: float = 0.5) -> list[float]:
    """Three numbers up to `size`."""
    return [rng.uniform(-size, size) for _ in range(3)]


def joint(rng: random.Random, kind: str, *, passive: bool = False) -> mt.JointSpec:
    """A joint of that kind with random axes; some with springs, dampers, friction and drives unless `passive`."""
    fields: dict[str, Any] = {}
    if kind in ("Revolute", "Prismatic", "Helical", "Cylindrical"):
        fields["axis"] = unit(rng, 3)
    if kind == "Universal":
        fields["axis"], fields["axis2"] = [0, 0, 1], [1, 0, 0]
    if kind == "Helical":
        fields["pitch"] = rng.uniform(0.05, 0.5)
    if not passive and kind != "Weld":
        if rng.random() < 0.4:
            fields["damping"] = rng.uniform(0, 0.2)
        if kind in ("Revolute", "Prismatic", "Cylindrical", "Universal") and rng.random() < 0.4:
            fields["stiffness"] = rng.uniform(0, 5)
        if rng.random() < 0.3:
            fields["armature"] = rng.uniform(0, 0.1)
        if kind in ("Revolute", "Prismatic") and rng.random() < 0.3:
            fields["effort"] = {"sine": {"amplitude": rng.uniform(0, 1), "frequency": rng.uniform(0.1, 3)}}
    maker: Any = getattr(mt, kind)
    made: mt.JointSpec = maker(**fields)
    return made


def random_model(seed: int, bodies: int, *, passive: bool = False, kinds: list[str] | None = None, moving: bool = True) -> mt.Model:
    """A forest of `bodies` bodies in random states.

    Args:
        seed: Everything follows from it.
        bodies: How many.
        passive: No springs, dampers and drives: the energy is conserved.
        kinds: Kinds of joints to choose from; default: all.
        moving: With start velocities.
    """
    rng = random.Random(seed)
    model = mt.Model(gravity=vector(rng, 10))
    names: list[str] = []
    for k in range(bodies):
        parent = None if not names or rng.random() < 0.15 else rng.choice(names)
        name = f"m{k}/body" if parent is None else f"{parent.split('/')[0]}/b{k}"
        kind = rng.choice(kinds or KINDS)
        if kind == "Weld" and parent is None:
            kind = "Revolute"
        a, b, c = (rng.uniform(0.05, 0.2) for _ in range(3))  # moments of a box: the triangle inequality holds
        mass = rng.uniform(0.2, 3)
        model.add(
            name,
            mass=mass,
            com=vector(rng, 0.3),
            inertia=[mass * (b * b + c * c), mass * (a * a + c * c), mass * (a * a + b * b)],
            parent=parent,
            at={"xyz": vector(rng), "quat": unit(rng, 4)},
            child_at={"xyz": vector(rng, 0.2), "quat": unit(rng, 4)},
            joint=joint(rng, kind, passive=passive),
        )
        names.append(name)
    return model


def random_state(sim: mt.Simulation, seed: int, size: float = 1.0) -> None:
    """Sets random coordinates and velocities."""
    rng = random.Random(seed)
    q: list[float] = []
    for each in sorted((sim.world.joints[name] for name in sim.world.joints), key=lambda one: one.index):
        quaternion = each.kind in ("ball", "free")
        q += [rng.uniform(-size, size) for _ in range(len(each.q) - 4 * quaternion)] + (unit(rng, 4) if quaternion else [])
    v = np.array([rng.uniform(-size, size) for _ in sim.v])
    sim.set_state(q=q, v=v)


def fingerprint(sim: mt.Simulation) -> tuple[Any, ...]:
    """Every bit of a simulation's state."""
    return (sim.time, sim.q.tobytes(), sim.v.tobytes(), sim.p.tobytes(), tuple(sim.world.joints), sim.energy)


def some_action(sim: mt.Simulation, rng: random.Random) -> mt.Action:
    """An action that names parts of the simulation; it need not be possible."""
    joints, bodies = list(sim.world.joints), list(sim.world.bodies)
    joint_name, body, other = rng.choice(joints), rng.choice(bodies), rng.choice([*bodies, "ground"])
    floating = [each.root for each in sim.world.mechanisms if not each.grounded]
    if floating and rng.random() < 0.5:
        root = rng.choice(floating)
        mine = next(each.bodies for each in sim.world.mechanisms if each.root == root)
        other = rng.choice([each for each in bodies if each not in mine] or ["ground"])
        return rng.choice(
            [
                lambda: mt.weld(root, other),
                lambda: mt.attach(root, other, joint(rng, rng.choice(KINDS[:-1])), at=vector(rng)),
                lambda: mt.reroot(rng.choice(mine)),
            ]
        )()
    return rng.choice(
        [
            lambda: mt.break_joint(joint_name),
            lambda: mt.free_joint(joint_name),
            lambda: mt.lock(joint_name),
            lambda: mt.unlock(joint_name),
            lambda: mt.change_joint(joint_name, joint(rng, rng.choice(KINDS))),
            lambda: mt.weld(body, other),
            lambda: mt.attach(body, other, joint(rng, rng.choice(KINDS[:-1]))),
            lambda: mt.reroot(body),
            lambda: mt.impulse(body, force=vector(rng), torque=vector(rng), point=vector(rng)),
            lambda: mt.set_parameters(joint_name, damping=rng.uniform(0, 1)),
        ]
    )()
