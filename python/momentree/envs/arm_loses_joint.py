"""``momentree/ArmLosesJoint-v0``: an arm that reaches for targets while one of its joints fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from momentree._errors import Error
from momentree._records import Array
from momentree.batch import Batch
from momentree.envs._arm import PlanarArm
from momentree.envs._canvas import Canvas
from momentree.envs._one import Indices
from momentree.envs._single import TaskEnv
from momentree.envs._task import Mask, Task, angles_given, annulus, point_given, unknown_options
from momentree.envs._vector import TaskVectorEnv
from momentree.events import lock, set_parameters, unlock
from momentree.model import Model

ARM = PlanarArm(
    lengths=(0.35, 0.3, 0.25, 0.2),
    masses=(1.2, 0.9, 0.6, 0.3),
    torques=(12.0, 8.0, 4.0, 2.0),
    dampings=(2.0, 1.2, 0.6, 0.3),
    armature=0.03,
)
FAULTS = ("none", "jam", "limp")
_NONE, _JAM, _LIMP = range(3)
_LIMP_DAMPING = 0.05  # N m s/rad: the bearing, without gear and motor
_REACHED = 0.05  # m


class ArmLosesJoint(Task):
    """The task; :class:`ArmLosesJointEnv` describes it."""

    def __init__(
        self, worlds: int | None, threads: int, max_steps: int, faults: Sequence[str], observe_fault: bool, arm: PlanarArm
    ) -> None:
        model = Model()
        arm.add_to(model)
        super().__init__(model, arm, worlds, threads, max_steps)
        unknown = [each for each in faults if each not in FAULTS]
        if unknown or not faults:
            raise Error(f"faults: expected some of {', '.join(FAULTS)}, found {list(faults)}")
        self._faults = tuple(FAULTS.index(each) for each in faults)
        self._observe_fault = observe_fault
        n, joints = len(self.worlds), arm.joints
        width = 3 * joints + 4 + (joints if observe_fault else 0)
        self.observation_space = spaces.Box(-np.inf, np.inf, (width,), np.float64)
        self.action_space = spaces.Box(-1.0, 1.0, (joints,), np.float32)
        self._target = np.zeros((n, 2))
        self._reached = np.zeros(n, dtype=np.int64)
        self._distance = np.zeros(n)
        self._kind = np.zeros(n, dtype=np.int64)
        self._joint = np.zeros(n, dtype=np.int64)
        self._time = np.zeros(n)  # of the fault, from the episode's begin
        self._faulty = np.zeros(n, dtype=np.bool_)
        self._drives = np.ones((n, joints))  # 0 for motors that are lost
        self._random: list[np.random.Generator | None] = [None] * n
        if isinstance(self.worlds, Batch):  # parameters that were set and set back are not the declared ones: set them everywhere
            for joint in range(joints):
                self.worlds.apply(None, set_parameters(arm.name(joint), damping=arm.dampings[joint]))

    def begin(self, worlds: Indices, random: Sequence[np.random.Generator], options: Mapping[str, Any]) -> None:
        unknown_options(options, ("target", "q", "fault"))
        joints, end = self.arm.joints, self.max_steps * self.period
        target, fault = point_given(options, "target", len(worlds)), options.get("fault")
        for row, (world, generator) in enumerate(zip(worlds, random, strict=True)):
            self._random[world] = generator
            self.q[world] = generator.uniform(-0.6, 0.6, joints)
            self._target[world] = self._new_target(generator) if target is None else target[row]
            self._kind[world] = self._faults[generator.integers(len(self._faults))]
            self._joint[world] = generator.integers(joints)
            self._time[world] = generator.uniform(0.15, 0.5) * end
        if (q0 := angles_given(options, len(worlds), joints)) is not None:
            self.q[worlds] = q0
        if "fault" in options:
            self._set_fault(worlds, fault)
        self._reached[worlds] = 0
        self._faulty[worlds] = False
        self._drives[worlds] = 1.0
        still = np.zeros((len(worlds), joints))
        self.worlds.set_state(worlds, q=self.q[worlds], v=still, time=np.zeros(len(worlds)))
        self._distance[worlds] = np.linalg.norm(self.arm.points(self.q[worlds])[:, -1] - self._target[worlds], axis=1)

    def _set_fault(self, worlds: Indices, fault: Mapping[str, Any] | None) -> None:
        fault = fault or {"kind": "none", "joint": 0, "time": 0.0}
        if fault.get("kind") not in FAULTS or not 0 <= int(fault.get("joint", -1)) < self.arm.joints:
            raise Error(f"options: fault: expected kind ({', '.join(FAULTS)}), joint (from 0) and time (s), found {dict(fault)}")
        self._kind[worlds] = FAULTS.index(str(fault["kind"]))
        self._joint[worlds], self._time[worlds] = int(fault["joint"]), float(fault.get("time", 0.0))

    def _new_target(self, random: np.random.Generator) -> Array:
        return annulus(random, 0.4 * self.arm.reach, 0.85 * self.arm.reach, 2.0)

    def undo(self, worlds: Indices) -> None:
        for joint, name in enumerate(map(self.arm.name, range(self.arm.joints))):
            broken = worlds[self._faulty[worlds] & (self._joint[worlds] == joint)]
            if len(jammed := broken[self._kind[broken] == _JAM]):
                self.worlds.apply(jammed, unlock(name))
            if len(limp := broken[self._kind[broken] == _LIMP]):
                self.worlds.apply(limp, set_parameters(name, damping=self.arm.dampings[joint]))

    def act(self, action: Array, active: Mask) -> Array:
        action = np.clip(action, -1, 1)
        torque = action * np.asarray(self.arm.torques)
        self.push(torque * self._drives)
        self._move(torque, active)
        self.read()
        distance = np.linalg.norm(self.tip - self._target, axis=1)
        reward: Array = 4 * (self._distance - distance) - 0.005 * (action**2).sum(axis=1)
        reached = active & (distance < _REACHED)
        reward += reached
        self._reached += reached
        for world in np.flatnonzero(reached):
            generator = self._random[world]
            assert generator is not None
            self._target[world] = self._new_target(generator)
            distance[world] = np.linalg.norm(self.tip[world] - self._target[world])
        self._distance = np.where(active, distance, self._distance)
        return reward

    def _move(self, torque: Array, active: Mask) -> None:
        """A period, with the faults at their exact instants: their worlds take one more, shorter step."""
        h = self.period / self.substeps
        to = self._time - (self.steps - 1) * self.period
        due = active & ~self._faulty & (self._kind != _NONE) & (to < self.period)
        to = np.maximum(to, 0.0)  # a fault that was set for the past happens now
        last = np.where(due, np.minimum((to / h).astype(np.int64), self.substeps - 1), self.substeps)
        for k in range(self.substeps + bool(due.any())):
            durations = np.where(k < self.substeps, h, 0.0) * active
            durations = np.where(due & (k == last), to - last * h, durations)
            durations = np.where(due & (k == last + 1), (last + 1) * h - to, durations)
            durations = np.where(due & (k > last + 1), h, durations)
            self.worlds.step(np.where(durations < 1e-12, 0.0, durations))  # shorter than the clock can tell
            if (now := due & (k == last)).any():
                self._fail(now, torque)

    def _fail(self, now: Mask, torque: Array) -> None:
        for joint, name in enumerate(map(self.arm.name, range(self.arm.joints))):
            broken = now & (self._joint == joint)
            jammed, limp = np.flatnonzero(broken & (self._kind == _JAM)), np.flatnonzero(broken & (self._kind == _LIMP))
            if len(jammed):
                self.change(jammed, lock(name), name="jam")
            if len(limp):
                self.change(limp, set_parameters(name, damping=_LIMP_DAMPING), name="limp")
            self._drives[broken, joint] = 0.0
        self._faulty |= now
        self.read()
        self.push(torque * self._drives, only=now)

    def ended(self) -> Mask:
        return np.zeros(len(self.worlds), dtype=np.bool_)

    def observe(self) -> Array:
        parts = [np.cos(self.q), np.sin(self.q), self.v, self._target, self._target - self.tip]
        return np.concatenate([*parts, self._drives] if self._observe_fault else parts, axis=1)

    def info(self) -> dict[str, NDArray[Any]]:
        return {
            "distance": self._distance,
            "targets_reached": self._reached,
            "faulty_joint": np.where(self._faulty, self._joint, -1),
        }

    def draw(self, canvas: Canvas, world: int) -> None:
        canvas.disc(self._target[world], _REACHED, (60, 160, 90), 0.35)
        canvas.ring(self._target[world], _REACHED, 0.012, (40, 130, 70))
        colours = [(225, 228, 232)] * self.arm.joints
        if self._faulty[world]:
            colours[self._joint[world]] = (215, 60, 50) if self._kind[world] == _JAM else (240, 170, 40)
        canvas.arm(self.points[world], colours)
        canvas.disc(self.tip[world], 0.022, (40, 130, 70))


class ArmLosesJointEnv(TaskEnv):
    """An arm of four joints reaches for one target after the other. At a random instant one of its joints fails.

    A joint that jams (``"jam"``) is locked where it is: an impact, after which the arm has one degree of freedom less. One that
    goes limp (``"limp"``) loses its motor and gear and swings freely. The target that is reached (5 cm) is replaced by another.

    * **Action**, shape (4,): torque of each motor as a share of its largest (12, 8, 4, 2 N m); beyond ±1 it is clipped.
    * **Observation**, shape (20,): cosines (4) and sines (4) of the joint angles, joint velocities (4, rad/s), target (x, y in m),
      target minus tip (m), and 1 for each motor that works (4, unless ``observe_fault`` is False).
    * **Reward**: 4 per metre that the tip comes nearer to the target, +1 for reaching it, −0.005·|action|².
    * **End**: truncated after ``max_steps`` (200) periods of 40 ms; terminated only if the motion diverges.
    * **Options** of ``reset``: ``target`` (x, y), the first one; ``q`` (4,), the start angles; ``fault``: ``{"kind": "jam",
      "joint": 1, "time": 0.9}``, or None for no fault.
    * **Info**: ``distance`` (m), ``targets_reached``, ``faulty_joint`` (−1: none so far), ``events``.

    Args:
        render_mode: ``"rgb_array"`` or None.
        max_steps: Length of an episode.
        faults: What may happen: of ``"jam"``, ``"limp"`` and ``"none"``, each as probable as the others.
        observe_fault: Whether the observation tells which motors work.
        arm: Another arm.
    """

    def __init__(
        self,
        render_mode: str | None = None,
        max_steps: int = 200,
        faults: Sequence[str] = ("jam", "limp"),
        observe_fault: bool = True,
        arm: PlanarArm = ARM,
    ) -> None:
        super().__init__(ArmLosesJoint(None, 1, max_steps, faults, observe_fault, arm), render_mode)


class ArmLosesJointVectorEnv(TaskVectorEnv):
    """Many :class:`ArmLosesJointEnv` on one batch.

    Args:
        num_envs: Number of worlds.
        threads: Of the batch; 0: as many as the machine has.
        autoreset_mode: ``"NextStep"``, ``"SameStep"`` or ``"Disabled"``.
        render_mode: As for :class:`ArmLosesJointEnv`, as the others.
    """

    def __init__(
        self,
        num_envs: int = 1,
        threads: int = 0,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        max_steps: int = 200,
        faults: Sequence[str] = ("jam", "limp"),
        observe_fault: bool = True,
        arm: PlanarArm = ARM,
    ) -> None:
        task = ArmLosesJoint(num_envs, threads, max_steps, faults, observe_fault, arm)
        super().__init__(task, render_mode, autoreset_mode)
