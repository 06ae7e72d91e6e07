"""The scenes: bodies in trees above a floor, as plain data that every engine builds from.

A body has its place in the frame of its parent (a root: in the world), and hinges that are applied in this order, each about an axis
through an anchor in the body's frame. A root is free; if the scene has a `release`, the first root hangs by its point `held` (a ball
joint) until then. A capsule lies along the z axis of its shape's frame; without length it is a sphere. Lengths in m, masses in kg.
"""

from __future__ import annotations

import json
import random
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = list[float]


@dataclass
class Shape:
    """`size`: the sides of a box; radius and half the length of a capsule. `R`: rotation matrix, by rows."""

    kind: str
    size: Numbers
    R: Numbers
    p: Numbers


@dataclass
class Hinge:
    axis: Numbers
    anchor: Numbers
    q: float = 0.0
    damping: float = 0.0


@dataclass
class Body:
    name: str
    parent: int
    R: Numbers
    p: Numbers
    mass: float
    com: Numbers
    inertia: Numbers
    shapes: list[Shape]
    hinges: list[Hinge] = field(default_factory=list)
    v: Numbers = field(default_factory=lambda: [0.0, 0.0, 0.0])
    w: Numbers = field(default_factory=lambda: [0.0, 0.0, 0.0])


@dataclass
class Scene:
    """`compare_at`: when trajectories are compared, soon after the first impacts. `off`: pairs that pass through each other."""

    name: str
    title: str
    until: float
    compare_at: float
    bodies: list[Body]
    off: list[tuple[int, int]] = field(default_factory=list)
    friction: float = 0.5
    release: float = 0.0
    held: Numbers | None = None

    def write(self, path: Path) -> None:
        path.write_text(json.dumps(asdict(self)))


def read(path: str) -> Scene:
    data = json.loads(Path(path).read_text())
    for body in data["bodies"]:
        body["shapes"] = [Shape(**shape) for shape in body["shapes"]]
        body["hinges"] = [Hinge(**hinge) for hinge in body["hinges"]]
    data["bodies"] = [Body(**body) for body in data["bodies"]]
    return Scene(**data)


IDENTITY = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]


def turn(axis: Numbers | Array, angle: float) -> Array:
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K)


def quaternion(R: Array | Numbers) -> Numbers:
    """w, x, y, z."""
    R = np.reshape(R, (3, 3))
    K = np.array(
        [
            [R[0, 0] + R[1, 1] + R[2, 2], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]],
            [0, R[0, 0] - R[1, 1] - R[2, 2], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]],
            [0, 0, R[1, 1] - R[0, 0] - R[2, 2], R[1, 2] + R[2, 1]],
            [0, 0, 0, R[2, 2] - R[0, 0] - R[1, 1]],
        ]
    )
    values, vectors = np.linalg.eigh(K, UPLO="U")
    found = vectors[:, np.argmax(values)]
    return [float(x) for x in (found if found[0] >= 0 else -found)]


def matrix(q: Array | Numbers) -> Array:
    """Of w, x, y, z."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def flat(R: Array) -> Numbers:
    return [float(x) for x in np.ravel(R)]


def box(name: str, sides: Numbers, p: Numbers, R: Array, density: float = 500.0) -> Body:
    x, y, z = sides
    mass = density * x * y * z
    inertia = np.diag([y * y + z * z, x * x + z * z, x * x + y * y]) * mass / 12
    return Body(name, -1, flat(R), p, mass, [0.0, 0.0, 0.0], flat(inertia), [Shape("box", sides, IDENTITY, [0.0, 0.0, 0.0])])


def tilt(chance: random.Random) -> Array:
    """By up to 0.5 rad about a random axis."""
    axis = [chance.gauss(0, 1) for _ in range(3)]
    return turn(axis, chance.uniform(0, 0.5))


def block() -> Scene:
    """Rocks from edge to edge, and comes to rest."""
    sides, angle = [0.2, 0.3, 0.6], 0.25
    R = turn([0, 1, 0], angle)
    corner = R @ np.array([0.1, 0, -0.3])
    body = box("block", sides, [0.0, 0.0, float(-corner[2]) + 0.001], R)
    return Scene("block", "A block rocks", 2.0, 0.6, [body])


def thrown() -> Scene:
    """Lands on a corner, tumbles and slides."""
    body = box("box", [0.4, 0.3, 0.2], [0.0, 0.0, 0.6], turn([1, 2, 0.5], 0.7))
    body.v, body.w = [1.0, 0.3, 0.0], [2.0, 3.0, -1.0]
    return Scene("thrown", "A box is thrown", 2.0, 0.35, [body])


def boxes() -> Scene:
    """A grid of 10 by 10, each of which falls on the floor by itself."""
    chance = random.Random(1)
    bodies = []
    for i in range(10):
        for j in range(10):
            place = [0.35 * i, 0.35 * j, chance.uniform(0.25, 0.45)]
            bodies.append(box(f"box{i}{j}", [0.2, 0.2, 0.2], place, tilt(chance)))
    return Scene("boxes", "100 boxes fall on the floor", 2.0, 0.25, bodies)


def pile() -> Scene:
    """Four by five columns of five, close enough to fall on each other."""
    chance = random.Random(2)
    bodies = []
    for k in range(5):
        for i in range(4):
            for j in range(5):
                place = [0.26 * i + chance.uniform(-0.015, 0.015), 0.26 * j + chance.uniform(-0.015, 0.015), 0.25 + 0.36 * k]
                bodies.append(box(f"box{k}{i}{j}", [0.15, 0.15, 0.15], place, tilt(chance)))
    return Scene("pile", "100 boxes pile up", 2.0, 0.25, bodies)


def slender() -> Scene:
    """The chain with the inertia of thin rods, and with little damping."""
    scene = chain()
    scene.name, scene.title = "slender", "A chain of slender links comes off and falls"
    for body in scene.bodies:
        body.inertia = flat(np.diag([4e-5, 4e-5, 4e-6]))
        for hinge in body.hinges:
            hinge.damping = 2e-4
    return scene


def chain() -> Scene:
    """Twenty links, whose hinges have the axes y and x in turn, hang by the first. At 0.4 s it comes off."""
    length, radius, mass = 0.1, 0.012, 0.05
    moments = np.diag([4e-5, 4e-5, 4e-5])
    down = turn([1, 0, 0], np.pi)
    shape = Shape("capsule", [radius, length / 2], IDENTITY, [0.0, 0.0, length / 2])
    bodies = []
    for k in range(20):
        place = [0.0, 0.0, 2.3] if k == 0 else [0.0, 0.0, length]
        R = down @ turn([0, 1, 0], 0.3) if k == 0 else np.eye(3)
        axis = [0.0, 1.0, 0.0] if k % 2 == 0 else [1.0, 0.0, 0.0]
        hinges = [] if k == 0 else [Hinge(axis, [0.0, 0.0, 0.0], 0.07, 5e-3)]
        bodies.append(Body(f"link{k}", k - 1, flat(R), place, mass, [0.0, 0.0, length / 2], flat(moments), [shape], hinges))
    off = [(k, k + 1) for k in range(19)]
    held = [0.0, 0.0, 0.0]
    return Scene("chain", "A chain comes off and falls", 2.0, 0.72, bodies, off, release=0.4, held=held)


def humanoid(path: Path) -> Scene:
    """MuJoCo's humanoid, as MuJoCo reads it; without motors, tendons, springs, limits and armature, which not every engine has.

    Bodies without hinges become part of their parents.
    """
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(path))
    where: dict[int, tuple[int, Array, Array]] = {}  # of each body of the file: the body here, and its place in that one's frame
    bodies: list[Body] = []
    parts: list[list[tuple[float, Array, Array]]] = []  # masses, centres and inertias about them
    for b in range(1, model.nbody):
        R, p = matrix(model.body_quat[b]), np.array(model.body_pos[b])
        joints = range(model.body_jntadr[b], model.body_jntadr[b] + model.body_jntnum[b])
        if model.body_jntnum[b] == 0:
            host, host_R, host_p = where[model.body_parentid[b]]
            where[b] = host, host_R @ R, host_p + host_R @ p
        else:
            parent = model.body_parentid[b]
            at = (-1, np.eye(3), np.zeros(3)) if parent == 0 else where[parent]
            hinges = [
                Hinge(flat(model.jnt_axis[j]), flat(model.jnt_pos[j]), 0.0, float(model.dof_damping[model.jnt_dofadr[j]]))
                for j in joints
                if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_HINGE
            ]
            where[b] = len(bodies), np.eye(3), np.zeros(3)
            place = flat(at[2] + at[1] @ p)
            bodies.append(Body(model.body(b).name, at[0], flat(at[1] @ R), place, 0.0, [], [], [], hinges))
            parts.append([])
        host, host_R, host_p = where[b]
        turned = host_R @ matrix(model.body_iquat[b])
        inertia = turned @ np.diag(model.body_inertia[b]) @ turned.T
        parts[host].append((float(model.body_mass[b]), host_p + host_R @ model.body_ipos[b], inertia))
        for g in range(model.body_geomadr[b], model.body_geomadr[b] + model.body_geomnum[b]):
            half = float(model.geom_size[g][1]) if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_CAPSULE else 0.0
            at_R, at_p = host_R @ matrix(model.geom_quat[g]), host_p + host_R @ model.geom_pos[g]
            bodies[host].shapes.append(Shape("capsule", [float(model.geom_size[g][0]), half], flat(at_R), flat(at_p)))
    for body, its in zip(bodies, parts, strict=True):
        body.mass = sum(mass for mass, _, _ in its)
        com = sum((mass * centre for mass, centre, _ in its), np.zeros(3)) / body.mass
        inertia = np.zeros((3, 3))
        for mass, centre, own in its:
            arm = centre - com
            inertia += own + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        body.com, body.inertia = flat(com), flat(inertia)
    off = {(body.parent, i) for i, body in enumerate(bodies) if body.parent >= 0}
    for k in range(model.nexclude):
        one, other = where[model.exclude_signature[k] >> 16][0], where[model.exclude_signature[k] & 0xFFFF][0]
        off.add((min(one, other), max(one, other)))
    bodies[0].p[2] += 0.3
    bodies[0].w = [0.3, 1.0, 0.2]
    return Scene("humanoid", "A humanoid falls", 3.0, 0.28, bodies, sorted(off))
