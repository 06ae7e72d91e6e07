"""Other engines that read the same files, with one interface, for test_peers_agree.py.

Positions and velocities are in momentree's conventions, which every adapter translates into its engine's own:

- Vectors contain a free base first, if there is one, and then one number for each of the layout's joints, in its order.
- A free base has its position and a quaternion (w, x, y, z), and as velocities the linear and the angular velocity of its frame along
  the axes of that frame. Pinocchio has the same ones (with quaternions x, y, z, w); Drake takes all velocities along the world's
  axes, the angular ones first; MuJoCo takes the linear velocity along the world's axes.
- Efforts do work on these velocities. What acts in the joints by itself (dampers, springs, stops) is switched off in the engines and
  is given to them as efforts; `passive` tells what it would be.
"""

from __future__ import annotations

import importlib
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Layout:
    """The joints of one degree of freedom, by the names in the file, and whether the base is free."""

    joints: tuple[str, ...]
    floating: bool

    @property
    def first(self) -> int:
        """The index of the first joint in a vector of velocities."""
        return 6 if self.floating else 0

    @property
    def nv(self) -> int:
        return self.first + len(self.joints)


@dataclass(frozen=True)
class State:
    """`base`: position (3,), quaternion (4,); `q` (joints,), `v` (nv,)."""

    position: Array
    quaternion: Array
    q: Array
    v: Array

    @property
    def rotation(self) -> Array:
        """From the base's axes to the world's, (3, 3)."""
        w, x, y, z = self.quaternion
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )


def random_state(layout: Layout, random: np.random.Generator) -> State:
    quaternion = random.normal(size=4)
    q = random.uniform(-3, 3, len(layout.joints))
    return State(random.uniform(-1, 1, 3), quaternion / np.linalg.norm(quaternion), q, random.uniform(-2, 2, layout.nv))


class Engine(Protocol):
    def set(self, state: State) -> None: ...
    def mass_matrix(self) -> Array: ...
    def inverse_dynamics(self, a: Array) -> Array:
        """M a + c: the efforts that these accelerations need, with gravity."""
        ...

    def accelerations(self, efforts: Array) -> Array:
        """By the engine's own forward dynamics."""
        ...

    def passive(self) -> Array:
        """Efforts of the dampers and springs that the engine found in the file."""
        ...


def prepared(path: Path, folder: Path) -> Path:
    """A copy of an URDF file, which every engine can read as it is, momentree included:

    - without shapes, whose meshes are not there: some engines look for them, or make masses of them;
    - without `mimic`: momentree and Pinocchio leave it out if it is not asked for, Drake makes a constraint of it;
    - without a link called `world`, which is the ground in Drake, and so could not be free;
    - a link whose inertia no body can have (ANYmal's base, 1e-3 kg, has all six entries 1e-6) keeps its moments: Drake would replace
      the inertia, and MuJoCo refuses the file.
    """
    tree = ElementTree.parse(path)
    for link in tree.iter("link"):
        for kind in ("visual", "collision"):
            for shape in link.findall(kind):
                link.remove(shape)
        if link.get("name") == "world":
            link.set("name", "world_link")
        for inertia in link.iter("inertia"):
            ixx, iyy, izz, ixy, ixz, iyz = (float(inertia.get(key, "0")) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
            low, middle, high = np.linalg.eigvalsh([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
            if low + middle < high * (1 - 1e-6):
                for key in ("ixy", "ixz", "iyz"):
                    inertia.set(key, "0")
    for joint in tree.iter("joint"):
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)
        for end in (*joint.findall("parent"), *joint.findall("child")):
            if end.get("link") == "world":
                end.set("link", "world_link")
    copy = folder / path.name
    tree.write(copy)
    return copy


class Translation:
    """From momentree's velocities to an engine's: v' = T v, so that a' = T a + drift, M = Tᵀ M' T, efforts = Tᵀ efforts'."""

    def __init__(self, layout: Layout, index: Array) -> None:
        """`index`: where the joints are in the engine's vectors."""
        self.T: Array = np.zeros((layout.nv, layout.nv))
        self.T[index, np.arange(layout.first, layout.nv)] = 1
        self.drift: Array = np.zeros(layout.nv)

    def mass_matrix(self, theirs: Array) -> Array:
        return np.asarray(self.T.T @ theirs @ self.T)


class Pinocchio:
    def __init__(self, path: Path, layout: Layout) -> None:
        self.pin = pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed (pip install pin)")
        free = [pin.JointModelFreeFlyer()] if layout.floating else []
        self.model = pin.buildModelFromUrdf(str(path), *free)
        self.data = self.model.createData()
        self.layout = layout
        self.joints = [self.model.joints[self.model.getJointId(name)] for name in layout.joints]
        assert self.model.nv == layout.nv and all(joint.nv == 1 for joint in self.joints)
        self.index = np.array([*range(layout.first), *(joint.idx_v for joint in self.joints)])  # theirs[index] = ours
        self.damping = np.array(self.model.damping)[self.index]

    def set(self, state: State) -> None:
        self.q, self.v = self.pin.neutral(self.model), np.empty(self.layout.nv)
        if self.layout.floating:
            self.q[:3] = state.position
            self.q[3:7] = state.quaternion[[1, 2, 3, 0]]
        for joint, q in zip(self.joints, state.q, strict=True):
            # A continuous joint is a point on the unit circle.
            self.q[joint.idx_q : joint.idx_q + joint.nq] = [q] if joint.nq == 1 else [np.cos(q), np.sin(q)]
        self.v[self.index] = state.v

    def _theirs(self, ours: Array) -> Array:
        theirs = np.empty(self.layout.nv)
        theirs[self.index] = ours
        return theirs

    def mass_matrix(self) -> Array:
        upper = np.triu(self.pin.crba(self.model, self.data, self.q))
        whole = upper + np.triu(upper, 1).T
        return np.asarray(whole[np.ix_(self.index, self.index)])

    def inverse_dynamics(self, a: Array) -> Array:
        found = self.pin.rnea(self.model, self.data, self.q, self.v, self._theirs(a))
        return np.asarray(found)[self.index]

    def accelerations(self, efforts: Array) -> Array:
        found = self.pin.aba(self.model, self.data, self.q, self.v, self._theirs(efforts))
        return np.asarray(found)[self.index]

    def passive(self) -> Array:
        return -self.damping * self.v[self.index]


class Drake:
    def __init__(self, path: Path, layout: Layout) -> None:
        pytest.importorskip("pydrake", reason="Drake is not installed (pip install drake)")
        plants = importlib.import_module("pydrake.multibody.plant")
        parsing = importlib.import_module("pydrake.multibody.parsing")
        self.tree = importlib.import_module("pydrake.multibody.tree")
        self.transforms = importlib.import_module("pydrake.math")
        self.common = importlib.import_module("pydrake.common.eigen_geometry")
        self.layout = layout
        self.plant = plant = plants.MultibodyPlant(0.0)
        (model,) = parsing.Parser(plant).AddModels(str(path))
        root = self._root(model)
        if not layout.floating:
            plant.WeldFrames(plant.world_frame(), root.body_frame())
        joints = [plant.GetJointByName(name, model) for name in layout.joints]
        damping = [joint.default_damping_vector()[0] for joint in joints]
        for joint in joints:
            joint.set_default_damping_vector(np.zeros(1))
        self.damping = np.array([0.0] * layout.first + damping)
        plant.Finalize()
        assert plant.num_velocities() == layout.nv
        self.context = plant.CreateDefaultContext()
        self.root = root
        self.position = np.array([joint.position_start() for joint in joints], dtype=int)
        self.index = np.array([joint.velocity_start() for joint in joints], dtype=int)
        self.base = root.floating_velocities_start_in_v() if layout.floating else 0
        self.translation = Translation(layout, self.index)

    def _root(self, model: Any) -> Any:
        """The link that is no joint's child."""
        plant = self.plant
        children = {plant.get_joint(i).child_body().index() for i in plant.GetJointIndices(model)}
        return next(plant.get_body(i) for i in plant.GetBodyIndices(model) if i not in children)

    def set(self, state: State) -> None:
        plant, translation, first = self.plant, self.translation, self.layout.first
        if first:
            R, base = state.rotation, self.base
            quaternion = self.common.Quaternion(state.quaternion / np.linalg.norm(state.quaternion))
            pose = self.transforms.RigidTransform(quaternion, state.position)
            plant.SetFreeBodyPose(self.context, self.root, pose)
            translation.T[base : base + 3, 3:6] = R
            translation.T[base + 3 : base + 6, 0:3] = R
            translation.drift[base + 3 : base + 6] = R @ np.cross(state.v[3:6], state.v[0:3])
        q = plant.GetPositions(self.context)
        q[self.position] = state.q
        plant.SetPositions(self.context, q)
        plant.SetVelocities(self.context, translation.T @ state.v)

    def mass_matrix(self) -> Array:
        return self.translation.mass_matrix(self.plant.CalcMassMatrix(self.context))

    def inverse_dynamics(self, a: Array) -> Array:
        forces = self.tree.MultibodyForces(self.plant)
        self.plant.CalcForceElementsContribution(self.context, forces)
        theirs = self.translation.T @ a + self.translation.drift
        return np.asarray(self.translation.T.T @ self.plant.CalcInverseDynamics(self.context, theirs, forces))

    def accelerations(self, efforts: Array) -> Array:
        translation = self.translation
        theirs = np.linalg.solve(translation.T.T, efforts)
        self.plant.get_applied_generalized_force_input_port().FixValue(self.context, theirs)
        rates = self.plant.EvalTimeDerivatives(self.context).get_generalized_velocity().CopyToVector()
        return np.asarray(np.linalg.solve(translation.T, rates - translation.drift))

    def passive(self) -> Array:
        v = np.linalg.solve(self.translation.T, self.plant.GetVelocities(self.context))
        return np.asarray(-self.damping * v)


class MuJoCo:
    def __init__(self, path: Path, layout: Layout) -> None:
        self.mujoco = mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install mujoco)")
        self.layout = layout
        self.model = model = self._model(path)
        assert model.nv == layout.nv
        disabled = mujoco.mjtDisableBit
        self.no_passive = disabled.mjDSBL_DAMPER | disabled.mjDSBL_SPRING
        model.opt.disableflags |= disabled.mjDSBL_CONSTRAINT | self.no_passive
        self.data = mujoco.MjData(model)
        joints = [model.joint(name) for name in layout.joints]
        self.position = np.array([joint.qposadr[0] for joint in joints], dtype=int)
        self.index = np.array([joint.dofadr[0] for joint in joints], dtype=int)
        self.translation = Translation(layout, self.index)
        self.translation.T[3:6, 3:6] = np.eye(3) if layout.floating else self.translation.T[3:6, 3:6]

    def _model(self, path: Path) -> Any:
        spec = self.mujoco.MjSpec.from_file(str(path))
        if self.layout.floating and path.suffix == ".urdf":
            spec.compiler.fusestatic = False  # the root would become a part of the ground
            spec.worldbody.first_body().add_freejoint()
        return spec.compile()

    def set(self, state: State) -> None:
        data, translation = self.data, self.translation
        if self.layout.floating:
            R = state.rotation
            data.qpos[:3], data.qpos[3:7] = state.position, state.quaternion
            translation.T[0:3, 0:3] = R
            translation.drift[0:3] = R @ np.cross(state.v[3:6], state.v[0:3])
        data.qpos[self.position] = state.q
        data.qvel[:] = translation.T @ state.v
        data.qfrc_applied[:] = 0
        self.mujoco.mj_forward(self.model, data)

    def mass_matrix(self) -> Array:
        whole = np.zeros((self.layout.nv, self.layout.nv))
        self.mujoco.mj_fullM(self.model, self.data, whole)
        return self.translation.mass_matrix(whole)

    def inverse_dynamics(self, a: Array) -> Array:
        self.data.qacc[:] = self.translation.T @ a + self.translation.drift
        self.mujoco.mj_inverse(self.model, self.data)
        return np.asarray(self.translation.T.T @ self.data.qfrc_inverse)

    def accelerations(self, efforts: Array) -> Array:
        self.data.qfrc_applied[:] = np.linalg.solve(self.translation.T.T, efforts)
        self.mujoco.mj_forward(self.model, self.data)
        return np.asarray(np.linalg.solve(self.translation.T, self.data.qacc - self.translation.drift))

    def passive(self) -> Array:
        self.model.opt.disableflags &= ~self.no_passive
        self.mujoco.mj_forward(self.model, self.data)
        self.model.opt.disableflags |= self.no_passive
        return np.asarray(self.translation.T.T @ self.data.qfrc_passive)
