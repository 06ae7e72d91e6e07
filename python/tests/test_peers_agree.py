"""The same robots in momentree and in other engines: masses, inverse dynamics, accelerations and damping, at random states.

Every engine reads the same file by its own reader and computes by its own algorithms (momentree from momenta; Pinocchio and Drake by
articulated bodies, MuJoCo by a factorised mass matrix). peer_engines.py translates conventions. An engine that is not installed is
skipped: `pip install pin drake mujoco` installs them all.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from peer_engines import Array, Drake, Engine, Layout, MuJoCo, Pinocchio, State, prepared, random_state

import momentree as mt

MODELS = Path(__file__).resolve().parents[2] / "scenarios" / "models"
ARMS = ["panda/panda.urdf", "iiwa14/iiwa14_no_collision.urdf", "ur5/ur5_robot.urdf"]
WALKERS = ["anymal_b/anymal.urdf", "simple_humanoid/simple_humanoid.urdf"]
# Only MuJoCo reads all of this file: the others leave out what is MuJoCo's own in it.
MJCF = "mjcf_humanoid/humanoid.xml"
STATES = 40
BOUND = 1e-10  # largest difference, relative to the scale of the entry


class Momentree:
    """In its own conventions. The efforts of the joints are set by drives, and add to what acts in them."""

    def __init__(self, path: Path, floating: bool) -> None:
        root = {f"mechanism.{path.stem}.root": "free" if floating else "fixed"} if path.suffix == ".urdf" else {}
        self.sim = sim = mt.load(path, set=root | {f"mechanism.{path.stem}.limits": False})
        joints = {name: sim.world.joints[name] for name in sim.model.joint_names}
        assert {joint.kind for joint in joints.values()} <= {"free", "weld", "revolute", "prismatic"}
        self.names = [name for name, joint in joints.items() if len(joint.v) == 1]
        assert [len(joint.v) for joint in joints.values() if len(joint.v) > 1] == [6] * floating
        self.layout = Layout(tuple(name.partition("/")[2] for name in self.names), floating)
        self.drives = np.zeros(len(self.names))
        for i, name in enumerate(self.names):
            sim.drive(name, lambda _, i=i: self.drives[i])

    def set(self, state: State, drives: Array) -> None:
        base = [state.position, state.quaternion] if self.layout.floating else []
        self.drives[:] = drives
        self.sim.set_state(q=np.concatenate([*base, state.q]), v=state.v)


@dataclass
class Pair:
    ours: Momentree
    theirs: Engine
    random: np.random.Generator

    def states(self) -> Iterator[State]:
        """Both engines are at each of them, with random drives of the joints in momentree."""
        layout = self.ours.layout
        for _ in range(STATES):
            state = random_state(layout, self.random)
            self.ours.set(state, self.random.uniform(-1, 1, len(layout.joints)))
            self.theirs.set(state)
            yield state


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("robots")


Case = tuple[type[Engine], str, bool]
CASES: list[Case] = [(MuJoCo, MJCF, True)]
CASES += [(engine, file, free) for engine in (Pinocchio, Drake, MuJoCo) for file in ARMS + WALKERS for free in (False, True)]


def named(case: Case) -> str:
    engine, file, free = case
    return f"{engine.__name__}-{file.split('/')[0]}-{'free' if free else 'fixed'}"


@pytest.fixture(params=CASES, ids=named)
def pair(request: pytest.FixtureRequest, folder: Path) -> Pair:
    kind, file, free = request.param
    path = MODELS / file
    if path.suffix == ".urdf":
        path = prepared(path, folder)
    ours = Momentree(path, free)
    return Pair(ours, kind(path, ours.layout), np.random.default_rng(sum(named(request.param).encode())))


def assert_close(ours: Array, theirs: Array, scale: Array) -> None:
    """`scale` of each entry: the root of its mass or its inverse, and so comparable for a base and a finger."""
    assert ours.shape == theirs.shape and np.abs(theirs).max() > 0
    assert (np.abs(ours - theirs) <= BOUND * scale).all()


def effort_scale(masses: Array, efforts: Array) -> Array:
    return np.asarray(np.sqrt(np.diag(masses) * (efforts @ np.linalg.solve(masses, efforts))))


def test_mass_matrix(pair: Pair) -> None:
    for _ in pair.states():
        theirs = pair.theirs.mass_matrix()
        assert_close(pair.ours.sim.mass_matrix(), theirs, np.sqrt(np.outer(np.diag(theirs), np.diag(theirs))))


def test_inverse_dynamics(pair: Pair) -> None:
    """With accelerations, and without: the bias c(q, v), which contains gravity."""
    nv = pair.ours.layout.nv
    for _ in pair.states():
        masses = pair.theirs.mass_matrix()
        for a in (pair.random.uniform(-10, 10, nv), np.zeros(nv)):
            theirs = pair.theirs.inverse_dynamics(a)
            assert_close(pair.ours.sim.inverse_dynamics(a), theirs, effort_scale(masses, theirs))
        assert_close(pair.ours.sim.bias(), theirs, effort_scale(masses, theirs))


def test_accelerations(pair: Pair) -> None:
    for _ in pair.states():
        theirs, masses = pair.theirs.accelerations(pair.ours.sim.efforts()), pair.theirs.mass_matrix()
        scale = np.sqrt(np.diag(np.linalg.inv(masses)) * (theirs @ masses @ theirs))
        assert_close(pair.ours.sim.accelerations(), theirs, scale)


def test_momentum_is_mass_times_velocity(pair: Pair) -> None:
    """The momenta of momentree's state against the other engine's masses."""
    for state in pair.states():
        masses = pair.theirs.mass_matrix()
        assert_close(np.array(pair.ours.sim.p), masses @ state.v, effort_scale(masses, masses @ state.v))


def test_dampers_and_springs(pair: Pair) -> None:
    """What acts in the joints, without drives, is what the other engine found in the file."""
    state = random_state(pair.ours.layout, pair.random)
    pair.ours.set(state, np.zeros(len(pair.ours.layout.joints)))
    pair.theirs.set(state)
    np.testing.assert_allclose(pair.ours.sim.efforts(), pair.theirs.passive(), rtol=BOUND, atol=0)
