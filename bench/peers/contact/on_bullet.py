"""Bullet, by PyBullet, with its defaults; no damping of bodies. The chain hangs from a constraint, which is removed.
Bodies come from URDF. Links between the hinges of a body have 1e-5 of its mass, as Bullet has no massless ones.
Variant "rigid": single bodies are btRigidBody instead of btMultiBody."""

from __future__ import annotations

import os
import tempfile
from typing import Any

import numpy as np
import pybullet as bullet
from engine import Row, links, main
from scenes import Array, Scene, matrix, quaternion


def numbers(values: object) -> str:
    return " ".join(repr(float(x)) for x in np.ravel(values))


def rpy(R: Array) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll)."""
    pitch = -np.arcsin(np.clip(R[2, 0], -1, 1))
    if abs(R[2, 0]) > 1 - 1e-12:
        return np.array([np.arctan2(-R[0, 1] * R[2, 0], R[1, 1]), pitch, 0.0])
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])


def principal(inertia: list[float]) -> tuple[Array, Array]:
    """Moments, and a rotation to their axes: URDF's inertia is diagonal then, and read in the same way by all versions."""
    moments, axes = np.linalg.eigh(np.reshape(inertia, (3, 3)))
    if np.linalg.det(axes) < 0:
        axes[:, 0] = -axes[:, 0]
    return moments, axes


def link(scene: Scene, i: int, anchor: Array) -> str:
    """The body, with its frame at the anchor."""
    body = scene.bodies[i]
    moments, axes = principal(body.inertia)
    i_ = " ".join(f'{key}="{value!r}"' for key, value in zip(("ixx", "iyy", "izz"), moments.tolist(), strict=True))
    text = [f'<link name="{body.name}"><inertial><origin xyz="{numbers(body.com - anchor)}" rpy="{numbers(rpy(axes))}"/>']
    text.append(f'<mass value="{body.mass!r}"/><inertia {i_} ixy="0" ixz="0" iyz="0"/></inertial>')
    for shape in body.shapes:
        if shape.kind == "box":
            form = f'<box size="{numbers(shape.size)}"/>'
        elif shape.size[1] > 0:
            form = f'<capsule radius="{shape.size[0]!r}" length="{2 * shape.size[1]!r}"/>'
        else:
            form = f'<sphere radius="{shape.size[0]!r}"/>'
        at = f'xyz="{numbers(np.array(shape.p) - anchor)}" rpy="{numbers(rpy(np.reshape(shape.R, (3, 3))))}"'
        text.append(f"<collision><origin {at}/><geometry>{form}</geometry></collision>")
    return "\n".join([*text, "</link>"])


class World:
    def __init__(self, scene: Scene, step: float, variant: str) -> None:
        self.scene, self.step, self.steps = scene, step, 0
        if bullet.isConnected():
            bullet.disconnect()
        bullet.connect(bullet.DIRECT)
        bullet.setGravity(0, 0, -9.81)
        bullet.setTimeStep(step)
        self.ids: list[tuple[int, int]] = [(-1, -1)] * len(scene.bodies)
        self.anchors = [np.array(body.hinges[-1].anchor) if body.hinges else np.zeros(3) for body in scene.bodies]
        plane = bullet.createMultiBody(0, bullet.createCollisionShape(bullet.GEOM_PLANE))
        bullet.changeDynamics(plane, -1, lateralFriction=scene.friction**0.5, restitution=0)
        for root, body in enumerate(scene.bodies):
            if body.parent < 0:
                self.load(root, variant)
        for one, other in scene.off:
            bullet.setCollisionFilterPair(self.ids[one][0], self.ids[other][0], self.ids[one][1], self.ids[other][1], 0)
        self.held: int | None = None
        if scene.held:
            number, k = self.ids[0]
            body = scene.bodies[0]
            pivot = principal(body.inertia)[1].T @ (np.array(scene.held) - body.com)
            where = np.array(body.p) + np.reshape(body.R, (3, 3)) @ scene.held
            self.held = bullet.createConstraint(
                number, k, -1, -1, bullet.JOINT_POINT2POINT, [0, 0, 0], pivot.tolist(), where.tolist()
            )

    def load(self, root: int, variant: str) -> None:
        scene = self.scene
        members = [root]
        members += [i for i, body in enumerate(scene.bodies) if self.root_of(i) == root and i != root]
        text = [f'<robot name="{scene.bodies[root].name}">', link(scene, root, np.zeros(3))]
        starts: list[float] = []
        shift = {root: np.zeros(3)}
        owner: dict[int, int] = {}
        for i in members[1:]:
            body = scene.bodies[i]
            parent, offset = scene.bodies[body.parent].name, shift[body.parent]
            made = links(scene, i)
            for k, each in enumerate(made):
                last = k + 1 == len(made)
                name = body.name if last else f"{body.name}-{k}"
                if last:
                    text.append(link(scene, i, each["anchor"]))
                else:
                    little = 1e-5 * body.mass
                    small = repr(little * 1e-2)
                    text.append(
                        f'<link name="{name}"><inertial><mass value="{little!r}"/><inertia ixx="{small}" iyy="{small}" izz="{small}" '
                        'ixy="0" ixz="0" iyz="0"/></inertial></link>'
                    )
                place = each["p"] - (offset if k == 0 else 0)
                hinge = each["hinge"]
                text.append(
                    f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{name}"/>'
                    f'<axis xyz="{numbers(np.array(hinge.axis) / np.linalg.norm(hinge.axis))}"/>'
                    f'<origin xyz="{numbers(place)}" rpy="{numbers(rpy(each["R"]))}"/>'
                    f'<dynamics damping="{hinge.damping!r}"/></joint>'
                )
                starts.append(hinge.q)
                parent = name
            owner[i] = len(starts) - 1
            shift[i] = made[-1]["anchor"]
        with tempfile.NamedTemporaryFile("w", suffix=".urdf", delete=False) as file:
            file.write("\n".join([*text, "</robot>"]))
        flags = bullet.URDF_USE_INERTIA_FROM_FILE | bullet.URDF_MAINTAIN_LINK_ORDER | bullet.URDF_USE_SELF_COLLISION
        options: dict[str, Any] = {"useMaximalCoordinates": True} if variant == "rigid" else {}
        number = bullet.loadURDF(file.name, flags=flags, **options)
        os.unlink(file.name)
        free: dict[str, Any] = {"linearDamping": 0, "angularDamping": 0, "maxJointVelocity": 1e6}
        law: dict[str, Any] = {"lateralFriction": scene.friction**0.5, "restitution": 0, "spinningFriction": 0, "rollingFriction": 0}
        names = {scene.bodies[i].name: i for i in members}
        bullet.changeDynamics(number, -1, **free, **law)
        self.ids[root] = number, -1
        order = {bullet.getJointInfo(number, k)[1].decode(): k for k in range(bullet.getNumJoints(number))}
        at = 0
        for i in members[1:]:
            for k in range(len(scene.bodies[i].hinges)):
                last = k + 1 == len(scene.bodies[i].hinges)
                j = order[scene.bodies[i].name if last else f"{scene.bodies[i].name}-{k}"]
                bullet.changeDynamics(number, j, **free, **law)
                bullet.setJointMotorControl2(number, j, bullet.VELOCITY_CONTROL, force=0)
                bullet.resetJointState(number, j, starts[at])
                at += 1
            self.ids[i] = number, order[scene.bodies[i].name]
        assert len(names) == len(members)
        body = scene.bodies[root]
        R = np.reshape(body.R, (3, 3))
        arm = R @ body.com
        w, x, y, z = quaternion(R @ principal(body.inertia)[1])
        bullet.resetBasePositionAndOrientation(number, (np.array(body.p) + arm).tolist(), [x, y, z, w])
        bullet.resetBaseVelocity(number, (np.array(body.v) + np.cross(body.w, arm)).tolist(), list(body.w))

    def root_of(self, i: int) -> int:
        while self.scene.bodies[i].parent >= 0:
            i = self.scene.bodies[i].parent
        return i

    @property
    def time(self) -> float:
        return self.steps * self.step

    def advance(self, until: float) -> None:
        count = round((until - self.time) / self.step)
        for _ in range(count):
            bullet.stepSimulation()
        self.steps += count

    def release(self) -> None:
        bullet.removeConstraint(self.held)

    def state(self) -> Row:
        rows = []
        for body, (number, k), anchor in zip(self.scene.bodies, self.ids, self.anchors, strict=True):
            if k < 0:
                centre, q = bullet.getBasePositionAndOrientation(number)
                v, w = bullet.getBaseVelocity(number)
                R = matrix([q[3], *q[:3]]) @ principal(body.inertia)[1].T
                p = np.array(centre) - R @ body.com
            else:
                state = bullet.getLinkState(number, k, computeLinkVelocity=True, computeForwardKinematics=True)
                R = matrix([state[5][3], *state[5][:3]])
                p, v, w = np.array(state[4]) - R @ anchor, state[6], state[7]
            rows.append((R, p, np.array(v), np.array(w)))
        return tuple(np.array(column) for column in zip(*rows, strict=True))  # type: ignore[return-value]

    def note(self) -> str:
        return ""


if __name__ == "__main__":
    main(World)
