"""Energies, centres of mass and depths of overlap from the motions of the bodies, the same for all engines."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scenes import Array, Scene

GRAVITY = 9.81


@dataclass
class Motion:
    """Of every body at every instant: rotation of its frame, position of the frame, velocity of the centre of mass, angular velocity."""

    t: Array
    R: Array
    p: Array
    v: Array
    w: Array


def centres(scene: Scene, motion: Motion) -> Array:
    com = np.array([body.com for body in scene.bodies])
    return np.asarray(motion.p + np.einsum("tnij,nj->tni", motion.R, com))


def energies(scene: Scene, motion: Motion) -> Array:
    mass = np.array([body.mass for body in scene.bodies])
    inertia = np.array([body.inertia for body in scene.bodies]).reshape(-1, 3, 3)
    w = np.einsum("tnji,tnj->tni", motion.R, motion.w)  # body axes
    kinetic = 0.5 * np.einsum("n,tni,tni->t", mass, motion.v, motion.v) + 0.5 * np.einsum("tni,nij,tnj->t", w, inertia, w)
    return np.asarray(kinetic + GRAVITY * np.einsum("n,tn->t", mass, centres(scene, motion)[:, :, 2]))


def rise(energy: Array) -> float:
    """The largest gain since an earlier instant, relative to what the fall set free. Nothing here should add energy."""
    gain = float(np.max(energy - np.minimum.accumulate(energy)))
    return gain / float(energy[0] - np.min(energy))


def between_segments(a: Array, u: Array, b: Array, v: Array) -> Array:
    """Distances of segments a + s u and b + t v with s, t in [−1, 1]."""
    d = a - b
    uu, vv, uv = (np.einsum("ni,ni->n", x, y) for x, y in ((u, u), (v, v), (u, v)))
    ud, vd = np.einsum("ni,ni->n", u, d), np.einsum("ni,ni->n", v, d)
    tiny = 1e-300
    determinant = uu * vv - uv * uv

    def distance(s: Array, t: Array) -> Array:
        return np.asarray(np.linalg.norm(d + s[:, None] * u - t[:, None] * v, axis=1))

    def best_t(s: Array) -> Array:
        return np.clip((vd + s * uv) / (vv + tiny), -1, 1)

    def best_s(t: Array) -> Array:
        return np.clip((t * uv - ud) / (uu + tiny), -1, 1)

    inner = np.clip(np.where(determinant > 1e-12 * uu * vv, (uv * vd - vv * ud) / (determinant + tiny), 0.0), -1, 1)
    one = np.ones_like(uu)
    found = [distance(s, best_t(s)) for s in (inner, one, -one)]
    found += [distance(best_s(t), t) for t in (best_t(inner), one, -one)]
    return np.asarray(np.min(found, axis=0))


def overlap_of_boxes(p: Array, R: Array, half: Array, q: Array, S: Array, other: Array) -> Array:
    """The least motion that separates two boxes (separating axes); negative or 0 if they do not overlap. Axes: columns of R and S."""
    d = q - p
    axes = [R[:, :, k] for k in range(3)] + [S[:, :, k] for k in range(3)]
    axes += [np.cross(R[:, :, i], S[:, :, j]) for i in range(3) for j in range(3)]
    depth = np.full(len(p), np.inf)
    for axis in axes:
        size = np.linalg.norm(axis, axis=1)
        usable = size > 1e-6
        n = axis / np.where(usable, size, 1.0)[:, None]
        reach = np.einsum("nk,nk->n", half, np.abs(np.einsum("nik,ni->nk", R, n)))
        reach += np.einsum("nk,nk->n", other, np.abs(np.einsum("nik,ni->nk", S, n)))
        depth = np.where(usable, np.minimum(depth, reach - np.abs(np.einsum("ni,ni->n", d, n))), depth)
    return depth


@dataclass
class Depths:
    """Of bodies in the floor and in each other. All shapes of a scene are of one kind."""

    scene: Scene
    deepest: float = field(default=0.0)

    def __post_init__(self) -> None:
        shapes = [(i, shape) for i, body in enumerate(self.scene.bodies) for shape in body.shapes]
        self.body = np.array([i for i, _ in shapes])
        self.size = np.array([shape.size for _, shape in shapes])
        self.R = np.array([shape.R for _, shape in shapes]).reshape(-1, 3, 3)
        self.p = np.array([shape.p for _, shape in shapes])
        self.boxes = shapes[0][1].kind == "box"
        self.radius = np.linalg.norm(self.size, axis=1) / 2 if self.boxes else np.sum(self.size, axis=1)
        off = {tuple(pair) for pair in self.scene.off}
        pairs = [
            (i, j)
            for i in range(len(shapes))
            for j in range(i + 1, len(shapes))
            if self.body[i] != self.body[j] and (min(self.body[i], self.body[j]), max(self.body[i], self.body[j])) not in off
        ]
        self.pairs = np.array(pairs, dtype=int).reshape(-1, 2)

    def at(self, R: Array, p: Array) -> float:
        """The deepest overlap (m) of bodies with these rotations and positions."""
        R, p = R[self.body] @ self.R, p[self.body] + np.einsum("nij,nj->ni", R[self.body], self.p)
        if self.boxes:
            lowest = p[:, 2] - 0.5 * np.einsum("nk,nk->n", self.size, np.abs(R[:, 2, :]))
        else:
            along = R[:, :, 2] * self.size[:, 1:2]
            lowest = p[:, 2] - np.abs(along[:, 2]) - self.size[:, 0]
        deepest = max(0.0, -float(np.min(lowest)))
        i, j = self.pairs[:, 0], self.pairs[:, 1]
        near = np.einsum("ni,ni->n", p[i] - p[j], p[i] - p[j]) < (self.radius[i] + self.radius[j]) ** 2
        i, j = i[near], j[near]
        if len(i) == 0:
            return deepest
        if self.boxes:
            depth = overlap_of_boxes(p[i], R[i], self.size[i] / 2, p[j], R[j], self.size[j] / 2)
        else:
            depth = self.size[i, 0] + self.size[j, 0] - between_segments(p[i], along[i], p[j], along[j])
        return max(deepest, float(np.max(depth)))

    def largest(self, motion: Motion) -> float:
        every = max(1, len(motion.t) // 1500)
        return max(self.at(motion.R[k], motion.p[k]) for k in range(0, len(motion.t), every))


def apart(scene: Scene, motion: Motion, reference: Motion) -> float:
    """Root mean square of the distances of centres of mass from where the reference has them at its end (m)."""
    at, end = centres(scene, motion), float(reference.t[-1])
    k = int(np.clip(np.searchsorted(motion.t, end - 1e-9), 1, len(motion.t) - 1))
    part = (end - motion.t[k - 1]) / (motion.t[k] - motion.t[k - 1])  # its steps may not end there
    d = (1 - part) * at[k - 1] + part * at[k] - centres(scene, reference)[-1]
    return float(np.sqrt(np.mean(np.einsum("ni,ni->n", d, d))))
