"""momentree. The chain hangs from a joint, which breaks. Variants: "stepping"; "rk4" and "dop853", which locate
contacts; "reference", dop853 with small tolerances."""

from __future__ import annotations

import math
from collections.abc import Callable

import momentree as mt
import numpy as np
from engine import Row, links, main
from scenes import Scene, matrix, quaternion


def rotation(R: object) -> dict[str, list[float]]:
    return {"quat": quaternion(np.reshape(R, (3, 3)))}


class World:
    def __init__(self, scene: Scene, step: float, variant: str) -> None:
        model = mt.Model()
        self.scene, self.every = scene, 0.0 if variant == "stepping" else 1e-3
        tops: list[str] = []
        for i, body in enumerate(scene.bodies):
            name = f"{tops[body.parent].split('/')[0] if body.parent >= 0 else body.name}/{body.name}"
            shapes = [
                {**self.shape(shape.kind, shape.size), "at": {"xyz": shape.p, **rotation(shape.R)}} for shape in body.shapes
            ]
            own = {"mass": body.mass, "com": body.com, "inertia": self.six(body.inertia), "collision": shapes}
            if body.parent < 0:
                R = np.reshape(body.R, (3, 3))
                if scene.held and i == 0:
                    where = np.array(body.p) + R @ scene.held
                    model.add(name, joint=mt.Ball(), at={"xyz": list(where), **rotation(body.R)}, child_at=scene.held, **own)
                else:
                    v = [*(R.T @ body.v), *(R.T @ body.w)]
                    model.add(name, joint=mt.Free(), q=[*body.p, *quaternion(body.R)], v=v, **own)
            parent = tops[body.parent] if body.parent >= 0 else None
            made = links(scene, i)
            for k, link in enumerate(made):
                last = k + 1 == len(made)
                at = {"xyz": list(link["p"]), **rotation(link["R"])}
                hinge = link["hinge"]
                joint = mt.Revolute(axis=hinge.axis, damping=hinge.damping or None)
                if last:
                    model.add(name, parent=parent, at=at, child_at=list(link["anchor"]), joint=joint, q=hinge.q, **own)
                else:
                    parent = f"{name}-{k}"
                    model.add(parent, mass=0, parent=tops[body.parent] if k == 0 else f"{name}-{k - 1}", at=at, joint=joint, q=hinge.q)
            tops.append(name)
        model.add_floor(friction=scene.friction)
        model.add_contact(friction=scene.friction)
        for one, other in scene.off:
            model.add_contact((tops[one], tops[other]), off=True)
        options = {"rtol": 1e-10, "atol": 1e-12} if variant == "reference" else {}
        self.sim = mt.Simulation(model, method="dop853" if variant == "reference" else variant, step=step, **options)
        self.bodies = [self.sim.world.bodies[name] for name in tops]

    @staticmethod
    def shape(kind: str, size: list[float]) -> dict[str, object]:
        if kind == "box":
            return {"box": size}
        return {"capsule": {"radius": size[0], "length": 2 * size[1]}} if size[1] > 0 else {"sphere": size[0]}

    @staticmethod
    def six(inertia: list[float]) -> list[float]:
        return [inertia[k] for k in (0, 4, 8, 1, 2, 5)]

    @property
    def time(self) -> float:
        return float(self.sim.time)

    def advance(self, until: float) -> None:
        self.sim.run(until, record_every=math.inf)

    def watch(self, until: float, look: Callable[[], None]) -> None:
        """One run: one for each step would add a short step to some. Methods that locate contacts have steps of all lengths: with them,
        the motion is written at equal intervals."""
        self.sim.run(until, record_every=self.every, observe=lambda world: look())

    def release(self) -> None:
        self.sim.apply(mt.break_joint(self.bodies[0].name))

    def state(self) -> Row:
        R = np.array([matrix(body.quaternion) for body in self.bodies])
        p, w = np.array([body.position for body in self.bodies]), np.array([body.angular for body in self.bodies])
        arms = np.einsum("nij,nj->ni", R, np.array([body.com for body in self.scene.bodies]))
        return R, p, np.array([body.linear for body in self.bodies]) + np.cross(w, arms), w

    def note(self) -> str:
        switched = [event for event in self.sim.events if event.name == "stepping"]
        hits = sum(1 for event in self.sim.events if event.name.startswith("impact"))
        said = [f"{hits} impacts located"] if hits else []
        return ", ".join(said + [f"steps through contacts from {event.time:.3g} s" for event in switched[:1]])


if __name__ == "__main__":
    main(World)
