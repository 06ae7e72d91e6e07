"""One environment."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from momentree._errors import Error
from momentree._records import Array
from momentree.envs._canvas import Canvas
from momentree.envs._one import OneWorld
from momentree.envs._task import Task
from momentree.simulation import Simulation

_ALL = np.zeros(1, dtype=np.intp)


class TaskEnv(gymnasium.Env[Array, Any]):
    """A task in one world, on a :class:`momentree.Simulation`."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": round(1 / Task.period)}
    picture_size = 320
    """Width and height of pictures, pixels."""

    def __init__(self, task: Task, render_mode: str | None) -> None:
        check_render_mode(render_mode)
        self._task = task
        self._running = False
        self.render_mode = render_mode
        self.observation_space = task.observation_space
        self.action_space = task.action_space

    @property
    def simulation(self) -> Simulation:
        """The simulation of the present episode: its world, energies and events. The next ``reset`` makes a new one."""
        assert isinstance(self._task.worlds, OneWorld)
        return self._task.worlds.simulation

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: Of the environment's ``np_random``.
            options: Of the task, in place of random values.

        Returns:
            Observation, info.
        """
        super().reset(seed=seed)
        self._task.reset(_ALL, [self.np_random], options)
        self._running = True
        return self._task.observe()[0], self._info([])

    def step(self, action: Any) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Make a step of ``period`` seconds.

        Returns:
            Observation, reward, terminated, truncated, info; ``info["events"]`` are the changes of topology.

        Raises:
            Error: The action has the wrong shape, or numbers that are not finite.
            ResetNeeded: The episode is over, or none has begun.
        """
        if not self._running:
            raise ResetNeeded("the episode is over, or none has begun: call reset()")
        outcome = self._task.step(self._task.checked(action), np.ones(1, dtype=np.bool_))
        terminated, truncated = bool(outcome.terminated[0]), bool(outcome.truncated[0])
        self._running = not (terminated or truncated)
        return self._task.observe()[0], float(outcome.reward[0]), terminated, truncated, self._info(outcome.events.get(0, []))

    def _info(self, events: list[Any]) -> dict[str, Any]:
        return {**{key: values[0].item() for key, values in self._task.info().items()}, "events": events}

    def render(self) -> NDArray[np.uint8] | None:
        """The world from above, shape (picture_size, picture_size, 3), or None without a render mode."""
        if self.render_mode is None:
            gymnasium.logger.warn("render() without a render mode: make the environment with render_mode='rgb_array'")
            return None
        return picture(self._task, 0, self.picture_size)


def check_render_mode(render_mode: str | None) -> None:
    """Raises Error for a mode that there is not."""
    if render_mode not in (None, "rgb_array"):
        raise Error(f"render_mode: unknown mode '{render_mode}'", hint="'rgb_array' or None")


def picture(task: Task, world: int, size: int) -> NDArray[np.uint8]:
    """A world from above, shape (size, size, 3)."""
    canvas = Canvas(size, 1.12 * task.arm.reach)
    canvas.disc((0, 0), task.arm.reach, (240, 241, 238))
    task.draw(canvas, world)
    return canvas.pixels()
