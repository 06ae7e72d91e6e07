"""PyBullet. Bodies come from URDF, and a multibody's joints are fixed; joints that are made or broken at run time are constraints
between multibodies, or a motor that holds a joint. A change that was not foreseen loads other files and copies the state. There is no
function for accelerations, so it takes no part in the evaluations; ../bullet.cpp measures the same algorithm."""

from __future__ import annotations

import functools
import os
import tempfile
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pybullet as bullet
from peers import Array, Experiment, Link, Motion, Way, main


def numbers(values: Array) -> str:
    return " ".join(repr(float(x)) for x in values)


def rpy(R: Array) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll)."""
    return np.array([np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(R[2, 0]), np.arctan2(R[1, 0], R[0, 0])])


def urdf(links: list[Link], members: list[int]) -> str:
    """A mechanism whose root is the first of the members, which is free, or hangs on a base without mass."""
    root = links[members[0]]
    parts = [f'<robot name="{root.name}">']
    if not root.free:
        parts.append('<link name="ground"><inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>')
    for i in members:
        link = links[i]
        entries = link.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].tolist()
        moments = " ".join(f'{key}="{entry!r}"' for key, entry in zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), entries, strict=True))
        parts.append(
            f'<link name="{link.name}"><inertial><origin xyz="{numbers(link.com)}"/>'
            f'<mass value="{link.mass!r}"/><inertia {moments}/></inertial></link>'
        )
        if not link.free:
            parent = "ground" if link.parent < 0 else links[link.parent].name
            kind = "fixed" if link.joint == "weld" else "continuous"
            parts.append(
                f'<joint name="{link.name}" type="{kind}"><parent link="{parent}"/><child link="{link.name}"/><axis xyz="0 0 1"/>'
                f'<origin xyz="{numbers(link.at)}" rpy="{numbers(rpy(link.turn))}"/></joint>'
            )
    return "\n".join([*parts, "</robot>"])  # it reads lines of up to 1024 characters


def mechanisms(links: list[Link]) -> list[list[int]]:
    """The members of each, parents first."""
    found: list[list[int]] = []
    where: dict[int, list[int]] = {}
    for i, link in enumerate(links):
        if link.parent < 0:
            found.append([])
        where[i] = found[-1] if link.parent < 0 else where[link.parent]
        where[i].append(i)
    return found


def quaternion(R: Array) -> list[float]:
    return list(bullet.getQuaternionFromEuler(rpy(R).tolist()))


def matrix(quaternion: tuple[float, ...]) -> Array:
    return np.array(bullet.getMatrixFromQuaternion(quaternion)).reshape(3, 3)


@functools.cache
def server() -> int:
    return int(bullet.connect(bullet.DIRECT))


class World:
    def __init__(self, links: list[Link], step: float) -> None:
        self.links, self.step = links, step
        bullet.resetSimulation(physicsClientId=server())
        bullet.setTimeStep(step)
        self.ids: dict[int, tuple[int, int]] = {}
        self.load()

    def load(self) -> None:
        """From files, which is the only way to give inertias. No damping, and no motors, which a joint has by default."""
        for members in mechanisms(self.links):
            root = self.links[members[0]]
            with tempfile.NamedTemporaryFile("w", suffix=".urdf", dir=folder(), delete=False) as file:
                file.write(urdf(self.links, members))
            flags = bullet.URDF_USE_INERTIA_FROM_FILE | bullet.URDF_MAINTAIN_LINK_ORDER
            number = bullet.loadURDF(file.name, useFixedBase=not root.free, flags=flags)
            os.unlink(file.name)
            bullet.changeDynamics(number, -1, linearDamping=0, angularDamping=0, jointDamping=0, maxJointVelocity=1e6)
            for k, i in enumerate(members):
                self.ids[i] = number, k - 1 if root.free else k
            for k in range(bullet.getNumJoints(number)):
                bullet.changeDynamics(number, k, linearDamping=0, angularDamping=0, jointDamping=0, maxJointVelocity=1e6)
                bullet.setJointMotorControl2(number, k, bullet.VELOCITY_CONTROL, force=0)
            if root.free:
                self.put(members[0], root.start)

    def put(self, i: int, motion: Motion) -> None:
        """The state of a free body: of its centre of mass, for Bullet."""
        link, (number, _) = self.links[i], self.ids[i]
        arm = motion.R @ link.com
        bullet.resetBasePositionAndOrientation(number, (motion.p + arm).tolist(), quaternion(motion.R))
        bullet.resetBaseVelocity(number, (motion.v + np.cross(motion.w, arm)).tolist(), motion.w.tolist())

    def set(self, i: int, angle: float, rate: float) -> None:
        bullet.resetJointState(*self.ids[i], angle, rate)

    def read(self, i: int) -> Motion:
        link, (number, k) = self.links[i], self.ids[i]
        if k < 0:
            (centre, turn), (linear, angular) = bullet.getBasePositionAndOrientation(number), bullet.getBaseVelocity(number)
        else:
            state = bullet.getLinkState(number, k, computeLinkVelocity=True, computeForwardKinematics=True)
            centre, turn, linear, angular = state[0], state[1], state[6], state[7]
        R, w = matrix(turn), np.array(angular)
        arm = R @ link.com
        return Motion(R, np.array(centre) - arm, np.array(linear) - np.cross(w, arm), w)


@functools.cache
def folder() -> Path:
    return Path(tempfile.mkdtemp(dir="/dev/shm" if Path("/dev/shm").is_dir() else None))


class Engine:
    """`way`: "load", "remove" (constraints), "motor" or "fix"; `step` in which the change acts (s), 0: none."""

    def __init__(self, experiment: Experiment, way: str, step: float, iterations: int = 50) -> None:
        self.e, self.way, self.step, self.elapsed = experiment, way, step, 0.0
        self.constraints: list[int] = []
        links = list(experiment.links)
        if way == "remove":
            self.loosen(links, experiment.start[experiment.body])
        self.on = World(links, step or 1e-3)
        bullet.setPhysicsEngineParameter(numSolverIterations=iterations)
        for i, link in enumerate(links):
            if not link.free:
                self.on.set(i, link.angle, link.rate)
        if way == "remove":  # the pin is two points on its axis
            old = experiment.links[experiment.body]
            parent = experiment.links[old.parent]
            for z in (0.0, 0.1):
                outer = old.at + old.turn @ [0, 0, z] - parent.com
                inner = np.array([0, 0, z]) - old.com
                self.constraints.append(self.join(old.parent, bullet.JOINT_POINT2POINT, outer, inner, np.eye(3)))

    def loosen(self, links: list[Link], motion: Motion) -> None:
        old = links[self.e.body]
        made = Link(old.name, -1, "free", old.mass, 0, 0, motion.R, motion.p, old.com, old.inertia, motion.v, motion.w)
        links[self.e.body] = made

    def join(self, outer: int, kind: int, at: Array, child_at: Array, turn: Array) -> int:
        """A constraint between a body and the experiment's; places in the frames of their centres of mass."""
        one, other = self.on.ids[outer], self.on.ids[self.e.body]
        turned = quaternion(turn)
        return int(bullet.createConstraint(*one, *other, kind, [0, 0, 1], at.tolist(), child_at.tolist(), turned, [0, 0, 0, 1]))

    def change(self) -> None:
        e, on = self.e, self.on
        if self.way == "load":
            self.reload()
        for constraint in self.constraints:
            bullet.removeConstraint(constraint)
        if self.way == "motor":
            bullet.setJointMotorControl2(*on.ids[e.body], bullet.VELOCITY_CONTROL, targetVelocity=0, force=1e12)
        if self.way == "fix":
            hand, held = on.read(e.to), on.read(e.body)
            turn, arm = hand.R.T @ held.R, hand.R.T @ (held.p - hand.p)
            # The child's frame is at the body's origin.
            fixed = self.join(e.to, bullet.JOINT_FIXED, arm - on.links[e.to].com, -on.links[e.body].com, turn)
            bullet.changeConstraint(fixed, maxForce=1e12)
        if self.step > 0:
            bullet.stepSimulation()
            self.elapsed = self.step

    def reload(self) -> None:
        """Both parts anew, with the state of the whole."""
        old = self.on
        held = old.read(self.e.body)
        states = {i: bullet.getJointState(*old.ids[i])[:2] for i, link in enumerate(old.links) if not link.free}
        links = list(old.links)
        self.loosen(links, held)
        for number in {number for number, _ in old.ids.values()}:
            bullet.removeBody(number)
        old.links = links
        old.load()
        for i, link in enumerate(links):
            if not link.free:
                old.set(i, *states[i])

    def motions(self) -> list[Motion]:
        return [self.on.read(i) for i in range(len(self.e.links))]


def ways(change: str) -> list[Way]:
    def way(name: str, note: str, kind: str, step: float, iterations: int = 50) -> Way:
        return Way(name, note, lambda experiment: Engine(experiment, kind, step, iterations))

    if change == "cut":
        return [
            way("loadURDF of both parts, copy the state", "needs a rebuild, from files", "load", 0),
            way("removeConstraint of two JOINT_POINT2POINT", "foreseen: the pin is constraints until then", "remove", 0),
        ]
    usual = "50 iterations, the default"
    if change == "lock":
        return [
            way("VELOCITY_CONTROL at 0, step of 1 µs", usual, "motor", 1e-6),
            way("VELOCITY_CONTROL at 0, step of 1 ms", usual + ", a usual step", "motor", 1e-3),
        ]
    return [
        way("createConstraint(JOINT_FIXED), step of 1 µs", usual, "fix", 1e-6),
        way("createConstraint(JOINT_FIXED), step of 1 µs, 1000 iterations", "", "fix", 1e-6, 1000),
        way("createConstraint(JOINT_FIXED), step of 1 ms", usual + ", a usual step", "fix", 1e-3),
    ]


if __name__ == "__main__":
    raise SystemExit(main("PyBullet " + version("pybullet"), ways, []))
