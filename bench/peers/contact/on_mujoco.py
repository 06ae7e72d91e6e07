"""MuJoCo, with its defaults: contacts are soft, and friction cones pyramids. The chain hangs from an equality, which is switched off.
Variant "stiff": the time constant of contacts is two steps, the least that it accepts. Variant "elliptic": that, and elliptic cones."""

from __future__ import annotations

import mujoco
import numpy as np
from engine import Row, main
from scenes import Body, Scene, quaternion


def numbers(values: object) -> str:
    return " ".join(repr(float(x)) for x in np.ravel(values))


def geom(kind: str, size: list[float]) -> str:
    if kind == "box":
        return f'type="box" size="{numbers(np.array(size) / 2)}"'
    return f'type="capsule" size="{numbers(size)}"' if size[1] > 0 else f'type="sphere" size="{size[0]!r}"'


def element(scene: Scene, i: int) -> str:
    body: Body = scene.bodies[i]
    text = [f'<body name="{body.name}" pos="{numbers(body.p)}" quat="{numbers(quaternion(body.R))}">']
    inertia = [body.inertia[k] for k in (0, 4, 8, 1, 2, 5)]
    text.append(f'<inertial pos="{numbers(body.com)}" mass="{body.mass!r}" fullinertia="{numbers(inertia)}"/>')
    if body.parent < 0:
        text.append("<freejoint/>")
    for hinge in body.hinges:
        text.append(f'<joint axis="{numbers(hinge.axis)}" pos="{numbers(hinge.anchor)}" damping="{hinge.damping!r}"/>')
    for shape in body.shapes:
        text.append(f'<geom {geom(shape.kind, shape.size)} pos="{numbers(shape.p)}" quat="{numbers(quaternion(shape.R))}"/>')
    text += [element(scene, k) for k, child in enumerate(scene.bodies) if child.parent == i]
    return "\n".join([*text, "</body>"])


def mjcf(scene: Scene, step: float, variant: str) -> str:
    hard = f'solref="{2 * step!r} 1"' if variant in ("stiff", "elliptic") else ""
    cone = 'cone="elliptic"' if variant == "elliptic" else ""
    roots = "\n".join(element(scene, i) for i, body in enumerate(scene.bodies) if body.parent < 0)
    off = "\n".join(f'<exclude body1="{scene.bodies[i].name}" body2="{scene.bodies[j].name}"/>' for i, j in scene.off)
    held = f'<connect body1="{scene.bodies[0].name}" anchor="{numbers(scene.held)}"/>' if scene.held else ""
    return f"""<mujoco><option timestep="{step!r}" {cone}><flag autoreset="disable"/></option><size memory="200M"/><compiler angle="radian" autolimits="false"/>
<default><geom condim="3" friction="{scene.friction!r} 0 0" {hard}/></default>
<worldbody><geom name="floor" type="plane" size="0 0 1"/>{roots}</worldbody>
<contact>{off}</contact><equality>{held}</equality></mujoco>"""


class World:
    def __init__(self, scene: Scene, step: float, variant: str) -> None:
        self.scene, self.step = scene, step
        self.model = mujoco.MjModel.from_xml_string(mjcf(scene, step, variant))
        self.data = mujoco.MjData(self.model)
        self.ids = [self.model.body(body.name).id for body in scene.bodies]
        for i, body in zip(self.ids, scene.bodies, strict=True):
            for j in range(self.model.body_jntadr[i], self.model.body_jntadr[i] + self.model.body_jntnum[i]):
                q, v = self.model.jnt_qposadr[j], self.model.jnt_dofadr[j]
                if self.model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE:
                    self.data.qvel[v : v + 3] = body.v
                    self.data.qvel[v + 3 : v + 6] = np.reshape(body.R, (3, 3)).T @ body.w
                else:
                    self.data.qpos[q] = body.hinges[j - self.model.body_jntadr[i]].q
        mujoco.mj_forward(self.model, self.data)

    @property
    def time(self) -> float:
        return float(self.data.time)

    def advance(self, until: float) -> None:
        count = round((until - self.data.time) / self.step)
        if count > 0:
            mujoco.mj_step(self.model, self.data, count)

    def release(self) -> None:
        self.data.eq_active[0] = 0

    def state(self) -> Row:
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        R, p = self.data.xmat[self.ids].reshape(-1, 3, 3).copy(), self.data.xpos[self.ids].copy()
        v, w, found = np.empty_like(p), np.empty_like(p), np.empty(6)
        for k, i in enumerate(self.ids):
            mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_XBODY, i, found, 0)
            w[k] = found[:3]
            v[k] = found[3:] + np.cross(found[:3], R[k] @ np.array(self.scene.bodies[k].com))
        return R, p, v, w

    def note(self) -> str:
        return ""


if __name__ == "__main__":
    main(World)
