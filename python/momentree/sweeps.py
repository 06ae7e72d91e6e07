"""Sweeps: many worlds of one scenario, or of one Python function, with varied values."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Union, cast

import numpy as np
from numpy.typing import NDArray

from momentree import _core
from momentree._attributes import assign_once
from momentree._errors import Error
from momentree._progress import progress_bar
from momentree._records import Array
from momentree.simulation import Simulation

if TYPE_CHECKING:
    import pandas as pd

Column = Union[Array, NDArray[np.bool_], NDArray[np.str_]]
"""Values of all worlds: numbers, flags or texts."""


class Sweep(_core.SweepBase):
    """A sweep file: a scenario, the values that vary, and what is recorded of each world.

    Args:
        path: The file (TOML).

    Raises:
        Error: The file or its scenario has errors: ``diagnostics`` lists all of them, with line and column.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        super().__init__(os.fspath(path))

    def __len__(self) -> int:
        return self.worlds

    def overrides(self, world: int) -> list[str]:
        """The varied values of a world as the command's ``--set`` takes them: ``KEY=VALUE``.

        Args:
            world: Its number, from 0.
        """
        return self._overrides(_index(world))

    def values(self, world: int) -> dict[str, float | str]:
        """The varied values of a world by name, in the units of the sweep file.

        Args:
            world: Its number, from 0.
        """
        columns = self._columns([_index(world)])
        return {name: column[0] if isinstance(column, list) else float(column[0]) for name, column in columns.items()}

    def world(self, world: int) -> Simulation:
        """One world as a simulation at its start, as :func:`load` makes it of the scenario with the overrides of the world.

        Args:
            world: Its number, from 0.

        Raises:
            Error: There is no such world, or its values are impossible.
        """
        simulation = Simulation.__new__(Simulation)
        arguments = (self.scenario, self.overrides(world), "", None)
        _core.SimulationBase.__init__(simulation, *arguments)
        simulation._begin(("file", *arguments))
        return simulation

    def run(
        self, jobs: int = 0, worlds: Iterable[int | np.integer[Any]] | None = None, *, progress: bool = False
    ) -> SweepResults:
        """Compute worlds in this process. Releases the GIL.

        The results do not depend on `jobs`; they are those of the command ``momentree sweep``, to the bit. The KeyboardInterrupt of
        Ctrl-C has the finished worlds as its attribute ``results``.

        Args:
            jobs: Threads; 0: one for each processor.
            worlds: Which ones, in this order; default: all.
            progress: Show a progress bar (with tqdm, if it is installed).

        Returns:
            The results. A world that fails has a status that says why.

        Raises:
            Error: There is no such world, or there is not enough memory for all results.
        """
        chosen = None if worlds is None else [_index(world) for world in worlds]
        count = self.worlds if chosen is None else len(chosen)
        with progress_bar(0, count, progress, "worlds") as show:
            numbers, failures, interruption, rows = self._compute(chosen, _index(jobs, "jobs"), show)
            if interruption is not None:
                worlds = rows if chosen is None else [chosen[row] for row in rows]
                failures = {k: failures[row] for k, row in enumerate(rows) if row in failures}
                vars(interruption)["results"] = self._results(worlds, numbers[rows], failures)
                raise interruption
        return self._results(chosen, numbers, failures)

    def _results(self, chosen: list[int] | None, numbers: Array, failures: Mapping[int, str]) -> SweepResults:
        world = np.arange(self.worlds, dtype=np.int64) if chosen is None else np.array(chosen, dtype=np.int64)
        values = {name: np.array(c) if isinstance(c, list) else c for name, c in self._columns(chosen).items()}
        measures: dict[str, Column] = {}
        for k, name in enumerate(self.measures):
            measures[name] = numbers[:, k].copy()
        return SweepResults(world, values, measures, failures, self)

    def __reduce__(self) -> tuple[type[Sweep], tuple[str]]:
        return type(self), (self.path,)

    def __repr__(self) -> str:
        return f"<momentree.Sweep '{self.name}': {self.worlds} worlds>"


def load_sweep(path: str | os.PathLike[str]) -> Sweep:
    """Load a sweep file (TOML). :func:`sweep` calls a Python function instead.

    Args:
        path: The file.

    Raises:
        Error: The file or its scenario has errors: ``diagnostics`` lists all of them, with line and column.
    """
    return Sweep(path)


def _index(value: Any, what: str = "world") -> int:
    if isinstance(value, (int, np.integer)) and not isinstance(value, bool):
        return int(cast("int", value))
    raise Error(f"{what}: expected an integer, found {value!r:.40}")


class Share(NamedTuple):
    """How often a flag is true."""

    value: float
    """A number from 0 to 1: of the worlds that have the flag, how many have it true. NaN if none has it."""
    lowest: float
    """Lower end of Wilson's interval at the 95 % level, a number from 0 to 1."""
    highest: float
    """Upper end of it, a number from 0 to 1."""
    worlds: int
    """Worlds that have the flag: failed ones do not."""


class SweepResults:
    """What a sweep computed, as columns: ``results["name"]`` is an array with a value for each of ``results.world``.

    Names are those of the varied values and of the measures. Measures are doubles, NaN where there is none: in worlds that failed,
    for example. Flags are 1 or 0: ``results["holds"] == 1`` are the worlds in which it is true, ``np.nanmean(results["holds"])`` is
    its share, and :meth:`share` adds an interval.
    """

    if not TYPE_CHECKING:  # a type checker would take any assignment for allowed
        __setattr__ = assign_once

    def __init__(
        self,
        world: NDArray[np.int64],
        values: Mapping[str, Column],
        measures: Mapping[str, Column],
        failures: Mapping[int, str],
        source: Sweep | None = None,
    ) -> None:
        self.world: NDArray[np.int64] = world
        """Numbers of the worlds, shape (worlds,)."""
        self.parameters: tuple[str, ...] = tuple(values)
        """Names of the varied values."""
        self.measures: tuple[str, ...] = tuple(measures)
        """Names of what was recorded."""
        self.status: list[str] = [f"failed: {failures[k]}" if k in failures else "done" for k in range(len(world))]
        """``"done"``, or ``"failed: "`` and why, of each world."""
        self._columns: dict[str, Column] = {**values, **measures}
        self._failures = dict(failures)
        self._source = source

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Which worlds failed, shape (worlds,)."""
        failed = np.zeros(len(self.world), dtype=np.bool_)
        failed[list(self._failures)] = True
        return failed

    def __len__(self) -> int:
        return len(self.world)

    def __getitem__(self, name: str) -> Any:
        """The column of that name, shape (worlds,). Raises Error if there is none."""
        if name not in self._columns:
            raise Error(f"the sweep has no column {name!r}", hint="its columns: " + ", ".join(self._columns))
        return self._columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._columns)

    def share(self, name: str) -> Share:
        """In which share of the worlds a flag is true, with its confidence interval. Failed worlds do not count.

        Args:
            name: The flag: a column of 1, 0 and NaN, or of booleans.

        Raises:
            Error: There is no such column, or it is no flag.
        """
        column = self[name]
        known = column[~np.isnan(column)] if column.dtype == np.float64 else column
        if column.dtype.kind not in "bf" or not np.isin(known, (0, 1)).all():
            raise Error(f"{name!r} is no flag", hint="a flag is true or false in each world")
        count, true = len(known), int(np.count_nonzero(known))
        if count == 0:
            return Share(math.nan, 0.0, 1.0, 0)
        value, squared = true / count, 1.959963984540054**2
        middle = (true + squared / 2) / (count + squared)
        half = math.sqrt(squared * (value * (1 - value) / count + squared / (4 * count**2))) / (1 + squared / count)
        lowest, highest = 0.0 if true == 0 else middle - half, 1.0 if true == count else middle + half
        return Share(value, lowest, highest, count)

    def to_pandas(self) -> pd.DataFrame:
        """The results as a DataFrame indexed by world: varied values, measures and ``status``.

        Raises:
            Error: pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError:
            raise Error("to_pandas needs pandas", hint="pip install pandas") from None
        index = pd.Index(self.world, name="world")
        return pd.DataFrame({**self._columns, "status": self.status}, index=index)

    def to_parquet(self, path: str | os.PathLike[str]) -> None:
        """Write the table of :meth:`to_pandas` as a Parquet file.

        Args:
            path: The file.

        Raises:
            Error: pandas or pyarrow is not installed.
        """
        try:
            self.to_pandas().to_parquet(path, engine="pyarrow")
        except ImportError:
            raise Error("to_parquet needs pandas and pyarrow", hint="pip install pandas pyarrow") from None

    def summary(self) -> dict[str, Any]:
        """Statistics, intervals, sensitivities and failures: the document ``sweep.json`` of the command, for these worlds.

        Raises:
            Error: The results are those of a Python function.
        """
        if self._source is None:
            raise Error("only the results of a sweep file have a summary", hint="to_pandas().describe() has statistics")
        measures = [np.where(self.failed, np.nan, self._columns[name]) for name in self.measures]
        numbers = np.stack(measures, axis=1) if measures else np.zeros((len(self), 0))
        document: dict[str, Any] = json.loads(self._source._summary(self.world, numbers, self._failures))
        return document

    def __repr__(self) -> str:
        failed = f", {len(self._failures)} failed" if self._failures else ""
        return f"<momentree.SweepResults: {len(self)} worlds{failed}; {', '.join(self.measures)}>"
