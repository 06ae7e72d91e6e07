"""Many environments at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from momentree._errors import Error
from momentree._records import Array
from momentree.batch import Batch
from momentree.envs._one import Indices
from momentree.envs._single import TaskEnv, check_render_mode, picture
from momentree.envs._task import Mask, Task


class TaskVectorEnv(VectorEnv[Array, Any, NDArray[Any]]):
    """A task in many worlds, on one :class:`momentree.Batch`. Each world has its own generator of random numbers.

    The autoreset mode is ``metadata["autoreset_mode"]``: by default a world whose episode is over begins the next one in the
    following step, which ignores its action.
    """

    metadata = {**TaskEnv.metadata, "autoreset_mode": AutoresetMode.NEXT_STEP}
    picture_size = TaskEnv.picture_size

    def __init__(self, task: Task, render_mode: str | None, autoreset_mode: AutoresetMode | str) -> None:
        super().__init__()
        check_render_mode(render_mode)
        self._task = task
        self.num_envs = len(task.worlds)
        self.render_mode = render_mode
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {**type(self).metadata, "autoreset_mode": self.autoreset_mode}
        self.single_observation_space = task.observation_space
        self.single_action_space = task.action_space
        self.observation_space = batch_space(task.observation_space, self.num_envs)
        self.action_space = batch_space(task.action_space, self.num_envs)
        self._random: list[np.random.Generator] = []
        self._over: Mask = np.zeros(self.num_envs, dtype=np.bool_)

    @property
    def batch(self) -> Batch:
        """The worlds."""
        assert isinstance(self._task.worlds, Batch)
        return self._task.worlds

    def _seed(self, seed: int | Sequence[int | None] | None) -> None:
        n = self.num_envs
        if seed is None and self._random:
            return
        if seed is None or isinstance(seed, (int, np.integer)):
            seeds: list[int | None] = [None if seed is None else int(seed) + i for i in range(n)]
        else:
            seeds = list(seed)
            if len(seeds) != n:
                raise Error(f"seed: expected one number or {n}, found {len(seeds)}")
        old = self._random
        self._random = [old[i] if each is None and old else seeding.np_random(each)[0] for i, each in enumerate(seeds)]

    def _begin(self, worlds: Indices, options: dict[str, Any] | None) -> None:
        numbers: list[int] = worlds.tolist()
        self._task.reset(worlds, [self._random[i] for i in numbers], options)
        self._over[worlds] = False

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode in all worlds, or in those of ``options["reset_mask"]`` (bool, shape (num_envs,)).

        Args:
            seed: World i is seeded with ``seed + i``; or one number for each world.
            options: Of the task, in place of random values.

        Returns:
            Observations, shape (num_envs, …), and info.
        """
        self._seed(seed)
        mask = (options or {}).get("reset_mask")
        chosen = np.ones(self.num_envs, dtype=np.bool_) if mask is None else np.asarray(mask)
        if chosen.shape != (self.num_envs,) or chosen.dtype != np.bool_:
            raise Error(f"options: reset_mask: expected booleans of shape ({self.num_envs},)")
        self._begin(np.flatnonzero(chosen), options)
        return self._task.observe(), self._info({})

    def step(self, actions: Any) -> tuple[Array, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Make a step of ``period`` seconds in all worlds.

        Returns:
            Observations (num_envs, …), rewards, terminated, truncated (num_envs,), and info: ``info["events"][i]`` is the list
            of the changes of topology in world i where ``info["_events"][i]``.

        Raises:
            Error: The actions have the wrong shape, or numbers that are not finite.
            ResetNeeded: No episode has begun, or, without autoreset, one is over.
        """
        task, mode = self._task, self.autoreset_mode
        if not self._random or (mode is AutoresetMode.DISABLED and self._over.any()):
            raise ResetNeeded("an episode is over, or none has begun: call reset()")
        values = task.checked(actions)
        begin = self._over.copy()
        if mode is AutoresetMode.NEXT_STEP:
            self._begin(np.flatnonzero(begin), None)
        outcome = task.step(values, ~begin)
        over = outcome.terminated | outcome.truncated
        infos = self._info(outcome.events)
        observations = task.observe()
        if mode is AutoresetMode.SAME_STEP and over.any():
            ended = np.flatnonzero(over)
            final_infos: dict[str, Any] = {}
            for i in ended:
                last = {key: infos[key][i] for key in infos if not key.startswith("_") and infos["_" + key][i]}
                final_infos = self._add_info(final_infos, {"final_obs": observations[i], "final_info": last}, int(i))
            self._begin(ended, None)
            observations = task.observe()
            infos = {**self._info(outcome.events), **final_infos}
        else:
            self._over = over
        return observations, outcome.reward, outcome.terminated, outcome.truncated, infos

    def _info(self, events: dict[int, list[Any]]) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        for key, values in self._task.info().items():
            infos[key], infos["_" + key] = values.copy(), np.ones(self.num_envs, dtype=np.bool_)
        if events:
            infos["events"] = np.full(self.num_envs, None, dtype=object)
            infos["_events"] = np.zeros(self.num_envs, dtype=np.bool_)
            for world, happened in events.items():
                infos["events"][world], infos["_events"][world] = happened, True
        return infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A picture of each world from above, each of shape (picture_size, picture_size, 3)."""
        if self.render_mode is None:
            return None
        return tuple(picture(self._task, world, self.picture_size) for world in range(self.num_envs))
