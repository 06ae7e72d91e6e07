"""One world with the interface of a batch."""

from __future__ import annotations

from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from momentree._errors import RunError
from momentree._records import Array, Event
from momentree._vocabulary import Action
from momentree.batch import Batch, Group
from momentree.model import Model
from momentree.simulation import Simulation

Indices = NDArray[np.intp]


class OneWorld:
    """A simulation as a batch of one world, as far as environments use it: what is written for batches runs on it."""

    def __init__(self, model: Model, *, step: float) -> None:
        self._start = Simulation(model, method="rk4", step=step)
        self.simulation = self._start.branch()
        self._diverged = False

    def __len__(self) -> int:
        return 1

    def renew(self) -> None:
        """Begin again with the model's topology, without the events so far."""
        self.simulation = self._start.branch()
        self._diverged = False

    @property
    def groups(self) -> list[Group]:
        """The world as the only group."""
        sim = self.simulation
        return [Group(np.zeros(1, dtype=np.intp), *(np.array(each)[None, :] for each in (sim.q, sim.v, sim.p)))]

    @property
    def diverged(self) -> NDArray[np.bool_]:
        """Whether the last step diverged, shape (1,)."""
        return np.array([self._diverged])

    def set_state(self, worlds: Indices, **values: Any) -> None:
        """Set the state, as :meth:`momentree.Batch.set_state` does."""
        if len(worlds):
            self.simulation.set_state(**{key: np.asarray(value)[0] for key, value in values.items()})

    def set_effort(self, effort: ArrayLike, worlds: Indices) -> None:
        """Set extra efforts, as :meth:`momentree.Batch.set_effort` does; shape (1, nv)."""
        if len(worlds):
            self.simulation.effort = np.asarray(effort)[0]

    def step(self, h: Array) -> None:
        """Step by h[0] seconds. A world that diverged stays where it is."""
        if h[0] > 0 and not self._diverged:
            try:
                self.simulation.step(float(h[0]))
            except RunError:
                self._diverged = True

    def apply(self, worlds: Indices, *actions: Action, name: str | None = None) -> list[Event]:
        """Carry out actions now, as one event."""
        return [self.simulation.apply(*actions, name=name)] if len(worlds) else []


Worlds = Union[Batch, OneWorld]
