"""``momentree/Gripper-v0``: an arm that takes a part from a table, carries it, and drops it at a target."""

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
from momentree.events import break_joint, lock, unlock, weld
from momentree.joints import Free
from momentree.model import Model

ARM = PlanarArm(
    lengths=(0.4, 0.35, 0.25),
    masses=(1.2, 0.9, 0.5),
    torques=(12.0, 8.0, 4.0),
    dampings=(2.0, 1.2, 0.6),
    armature=0.03,
    height=0.3,
)
_RESTING, _HELD, _FLYING, _LANDED = range(4)
_PART = "part/part"
_FALL = float(np.sqrt(2 * ARM.height / 9.81))  # s, from the arm's plane to the floor
_NEAR, _SLOW = 0.04, 0.8  # m, m/s: what the jaws can grasp
_SUCCESS = 0.08  # m


class Gripper(Task):
    """The task; :class:`GripperEnv` describes it."""

    def __init__(self, worlds: int | None, threads: int, max_steps: int, actions: str) -> None:
        model = Model()
        ARM.add_to(model)
        model.add(_PART, mass=0.25, inertia=2e-4, joint=Free())
        super().__init__(model, ARM, worlds, threads, max_steps)
        n, joints = len(self.worlds), ARM.joints
        self.observation_space: spaces.Space[Any] = spaces.Box(-np.inf, np.inf, (3 * joints + 6,), np.float64)
        if actions == "continuous":
            self.action_space: spaces.Space[Any] = spaces.Box(-1.0, 1.0, (joints + 1,), np.float32)
        elif actions == "discrete":
            self.action_space = spaces.MultiDiscrete([3] * joints + [2])
        else:
            raise Error(f"actions: unknown kind '{actions}'", hint="'continuous' or 'discrete'")
        if isinstance(self.worlds, Batch):  # a joint that a break has made free is not the declared one: make it so everywhere
            for action in (weld(_PART, "ground"), break_joint("begin")):
                self.worlds.apply(None, action, name="begin")
        self._phase = np.full(n, _FLYING)
        self._part = np.zeros((n, 2))
        self._target = np.zeros((n, 2))
        self._released_at = np.zeros((n, 2))
        self._flight = np.zeros(n)  # s
        self._distance = np.zeros(n)

    def begin(self, worlds: Indices, random: Sequence[np.random.Generator], options: Mapping[str, Any]) -> None:
        unknown_options(options, ("part", "target", "q"))
        inner, outer = 0.45 * ARM.reach, 0.9 * ARM.reach
        part, target = (point_given(options, key, len(worlds)) for key in ("part", "target"))
        for row, (world, generator) in enumerate(zip(worlds, random, strict=True)):
            self.q[world] = generator.uniform(-0.8, 0.8, ARM.joints)
            drawn_part, drawn_target = annulus(generator, inner, outer, 1.8), annulus(generator, inner, outer, 1.8)
            while np.linalg.norm(drawn_part - drawn_target) < 0.4:
                drawn_target = annulus(generator, inner, outer, 1.8)
            self._part[world] = drawn_part if part is None else part[row]
            self._target[world] = drawn_target if target is None else target[row]
        if (q0 := angles_given(options, len(worlds), ARM.joints)) is not None:
            self.q[worlds] = q0
        q = np.zeros((len(worlds), ARM.joints + 7))
        q[:, : ARM.joints] = self.q[worlds]
        q[:, ARM.joints : ARM.joints + 2], q[:, ARM.joints + 2], q[:, ARM.joints + 3] = self._part[worlds], ARM.height, 1.0
        self.worlds.set_state(worlds, q=q, v=np.zeros((len(worlds), ARM.joints + 6)), time=np.zeros(len(worlds)))
        self.worlds.apply(worlds, lock(_PART), name="rest")  # on the table
        self._phase[worlds] = _RESTING
        self._flight[worlds] = 0.0
        self.points[worlds] = ARM.points(self.q[worlds])
        self._distance[worlds] = self._to_go()[worlds]

    def undo(self, worlds: Indices) -> None:
        for phase, action in ((_HELD, break_joint("grasp")), (_RESTING, unlock(_PART))):
            if len(chosen := worlds[self._phase[worlds] == phase]):
                self.worlds.apply(chosen, action, name="undo")

    def _to_go(self) -> Array:
        """The distance that is to become small: of hand and part, then of part and target, m."""
        resting = self._phase == _RESTING
        away: Array = np.linalg.norm(np.where(resting[:, None], self._part - self.tip, self._target - self._part), axis=1)
        return away

    def act(self, action: Array, active: Mask) -> Array:
        if isinstance(self.action_space, spaces.MultiDiscrete):
            drive, closed = action[:, :-1] - 1.0, action[:, -1] > 0
        else:
            drive, closed = np.clip(action[:, :-1], -1, 1), action[:, -1] > 0
        grasped = self._grasp(active & closed)
        self._release(active & ~closed)
        if not self._groups:
            self.read()
        before = np.where(grasped, self._to_go(), self._distance)
        self.push(drive * np.asarray(ARM.torques))
        for _ in range(self.substeps):
            self.worlds.step(np.where(active, self.period / self.substeps, 0.0))
        self.read()
        self._follow(active)
        self._distance = np.where(active, self._to_go(), self._distance)
        reward: Array = 2 * (before - self._distance) - 0.003 * (drive**2).sum(axis=1) + grasped
        landed = active & (self._phase == _LANDED)
        reward += np.where(landed, 5 * np.exp(-((self._distance / 0.2) ** 2)), 0.0)
        return reward

    def _grasp(self, closing: Mask) -> Mask:
        speed = np.linalg.norm(ARM.tip_velocity(self.points, self.v), axis=1)
        away = np.linalg.norm(self._part - self.tip, axis=1)
        grasped: Mask = closing & (self._phase == _RESTING) & (away < _NEAR) & (speed < _SLOW)
        if not grasped.any():
            return grasped
        worlds = np.flatnonzero(grasped)
        self.change(worlds, unlock(_PART), name="lift")
        heading = self.q[worlds].sum(axis=1) / 2
        q, v, _ = self.state_of(worlds)
        q[:, ARM.joints :] = 0.0
        q[:, ARM.joints : ARM.joints + 2], q[:, ARM.joints + 2] = self.tip[worlds], ARM.height  # the jaws move it to their middle
        q[:, ARM.joints + 3], q[:, ARM.joints + 6] = np.cos(heading), np.sin(heading)
        self.worlds.set_state(worlds, q=q, v=v)
        self.change(worlds, weld(_PART, ARM.name(ARM.joints - 1)), name="grasp")
        if isinstance(self.worlds, Batch):
            self._share_topology(self.worlds, worlds)
        self._phase[worlds] = _HELD
        self._part[worlds] = self.tip[worlds]
        return grasped

    @staticmethod
    def _share_topology(batch: Batch, worlds: Indices) -> None:
        """Make the welds of these worlds the same to the last bit, so that the batch computes them side by side.

        A weld keeps the part where it is in the hand, which is the middle of the jaws but for round-off. Here it is made again with
        the arm stretched along x, where the round-off is the same in all worlds; the arm's coordinates and momenta stay.
        """
        q, p = np.empty((len(worlds), ARM.joints)), np.empty((len(worlds), ARM.joints))
        for group in batch.groups:
            _, rows, places = np.intersect1d(group.worlds, worlds, assume_unique=True, return_indices=True)
            q[places], p[places] = group.q[rows, : ARM.joints], group.p[rows, : ARM.joints]
        batch.apply(worlds, break_joint("grasp"))
        home = np.zeros((len(worlds), ARM.joints + 7))
        home[:, ARM.joints], home[:, ARM.joints + 2], home[:, ARM.joints + 3] = ARM.reach, ARM.height, 1.0
        batch.set_state(worlds, q=home, v=np.zeros((len(worlds), ARM.joints + 6)))
        batch.apply(worlds, weld(_PART, ARM.name(ARM.joints - 1)), name="grasp")
        batch.set_state(worlds, q=q, p=p)

    def _release(self, opening: Mask) -> None:
        released = opening & (self._phase == _HELD)
        if released.any():
            self.change(np.flatnonzero(released), break_joint("grasp"), name="drop")
            self._phase[released], self._released_at[released], self._flight[released] = _FLYING, self.tip[released], 0.0

    def _follow(self, active: Mask) -> None:
        """Where the parts are, and which of them have landed."""
        held, flying = self._phase == _HELD, active & (self._phase == _FLYING)
        self._part[held] = self.tip[held]
        if not flying.any():
            return
        for group in self._groups:
            if group.q.shape[1] > ARM.joints:
                chosen = flying[group.worlds]
                self._part[group.worlds[chosen]] = group.q[chosen, ARM.joints : ARM.joints + 2]
        self._flight[flying] += self.period
        landed = flying & (self._flight >= _FALL)  # on the way back to the instant of landing, along the straight path from above
        share = (_FALL / np.where(landed, self._flight, _FALL))[:, None]
        at = self._released_at + (self._part - self._released_at) * share
        self._part = np.where(landed[:, None], at, self._part)
        self._phase[landed] = _LANDED

    def ended(self) -> Mask:
        return np.asarray(self._phase == _LANDED)

    def observe(self) -> Array:
        phase = np.stack([self._phase == _HELD, self._phase >= _FLYING], axis=1).astype(np.float64)
        return np.concatenate(
            [np.cos(self.q), np.sin(self.q), self.v, self._part - self.tip, self._target - self._part, phase], axis=1
        )

    def info(self) -> dict[str, NDArray[Any]]:
        away = np.linalg.norm(self._target - self._part, axis=1)
        return {"distance": away, "holding": self._phase == _HELD, "success": (self._phase == _LANDED) & (away < _SUCCESS)}

    def draw(self, canvas: Canvas, world: int) -> None:
        canvas.disc(self._target[world], _SUCCESS, (60, 110, 190), 0.25)
        canvas.ring(self._target[world], _SUCCESS, 0.012, (50, 90, 170))
        canvas.arm(self.points[world], [(225, 228, 232)] * ARM.joints)
        holding, size = self._phase[world] == _HELD, 0.045
        if self._phase[world] >= _FLYING:  # it looks smaller as it falls
            size *= 1 - 0.35 * min(self._flight[world] / _FALL, 1.0) ** 2
        canvas.disc(self._part[world], size, (225, 120, 40))
        canvas.ring(self.tip[world], 0.045, 0.014, (40, 48, 60) if holding else (130, 140, 150))


class GripperEnv(TaskEnv):
    """A planar arm of three joints with a gripper. A part lies on a table, in the plane of the arm, 0.3 m above the floor.

    Closing the gripper within 4 cm of the part, at less than 0.8 m/s, welds the part to the hand: an impact that takes energy. The
    arm is then heavier. Opening it breaks the weld: the part falls with the velocity that it has, so that it can be thrown, and the
    episode ends where it lands.

    * **Action**, continuous, shape (4,): torque of each motor as a share of its largest (12, 8, 4 N m), clipped to ±1; and the
      grasp switch, closed above 0. Discrete, ``MultiDiscrete([3, 3, 3, 2])``: each motor backwards, off or forwards at full torque;
      gripper open or closed.
    * **Observation**, shape (15,): cosines (3) and sines (3) of the joint angles, joint velocities (3, rad/s), part minus hand
      (x, y in m), target minus part (m), 1 while the part is held, 1 once it has been dropped.
    * **Reward**: 2 per metre that the hand comes nearer to the part and, once that is held, the part to the target; +1 for grasping;
      up to +5 for where it lands, 5 exp(−(distance / 0.2 m)²); −0.003·|torques' shares|².
    * **End**: terminated when the part lands, or if the motion diverges; truncated after ``max_steps`` (150) periods of 40 ms.
    * **Options** of ``reset``: ``part`` and ``target`` (x, y in m), ``q`` (3,), the start angles.
    * **Info**: ``distance`` of part and target (m), ``holding``, ``success`` (landed within 8 cm), ``events``.

    Args:
        render_mode: ``"rgb_array"`` or None.
        max_steps: Length of an episode.
        actions: ``"continuous"`` or ``"discrete"``.
    """

    def __init__(self, render_mode: str | None = None, max_steps: int = 150, actions: str = "continuous") -> None:
        super().__init__(Gripper(None, 1, max_steps, actions), render_mode)


class GripperVectorEnv(TaskVectorEnv):
    """Many :class:`GripperEnv` on one batch.

    Args:
        num_envs: Number of worlds.
        threads: Of the batch; 0: as many as the machine has.
        autoreset_mode: ``"NextStep"``, ``"SameStep"`` or ``"Disabled"``.
        render_mode: As for :class:`GripperEnv`, as the others.
    """

    def __init__(
        self,
        num_envs: int = 1,
        threads: int = 0,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        max_steps: int = 150,
        actions: str = "continuous",
    ) -> None:
        super().__init__(Gripper(num_envs, threads, max_steps, actions), render_mode, autoreset_mode)
