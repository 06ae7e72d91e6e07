"""Sweeps of Python functions."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Union, cast

import numpy as np
from numpy.typing import NDArray

from momentree._arguments import called
from momentree._core import _draw
from momentree._errors import Error
from momentree._progress import Show, progress_bar
from momentree._records import Array
from momentree.distributions import Distribution
from momentree.sweeps import Column, SweepResults, _index

Parameters = Union[Mapping[str, Union[Sequence[Any], NDArray[Any], Distribution]], Sequence[Mapping[str, Any]], int]
"""What a function is called with: values to combine, one dictionary for each world, or a number of worlds."""
Outcome = tuple[str, dict[str, Any]]  # why it failed, or what it returned


def sweep(
    function: Callable[..., Any],
    parameters: Parameters,
    *,
    worlds: int | None = None,
    sampling: str = "random",
    seed: int = 0,
    jobs: int = 0,
    executor: Executor | None = None,
    progress: bool = False,
) -> SweepResults:
    """Call a Python function for each world of a sweep: ``function(**values)`` returns a number or a dictionary of numbers.

    An exception of the function is the status of its world. A key that a world does not return is NaN; a flag is 1 or 0; a
    single number is the measure ``value``. If the executor breaks, because one of its processes died, its unfinished worlds fail.
    An exception that ends the sweep, such as KeyboardInterrupt, has the finished worlds as its attribute ``results``.

    Args:
        function: What computes a world. With processes it must be importable: a function of a module.
        parameters: ``{"mass": [1, 2], "angle": angles}`` combines all values, and the last one varies fastest; a sequence of
            dictionaries has one for each world; a number N makes N calls ``function(seed=...)`` with different seeds.
            Distributions, such as ``{"mass": mt.normal(1, 0.1)}``, need `worlds`.
        worlds: Number of worlds. Values are then drawn, those of sequences with equal probabilities.
        sampling: How distributions are drawn: ``"random"``, ``"latin"`` (hypercube) or ``"sobol"``.
        seed: Determines the drawn values, and the seeds of the worlds if `parameters` is a number.
        jobs: Threads; 0: one for each processor. They run side by side only where the function releases the GIL, as runs do. With
            ``jobs=1``, a function may use what is not safe for threads, such as one simulation for all worlds.
        executor: Computes the worlds instead: a ``ProcessPoolExecutor``, or ``mpi4py.futures.MPIPoolExecutor``.
        progress: Show a progress bar (with tqdm, if it is installed).

    Returns:
        The results in the order of the worlds, whatever computed them.

    Raises:
        Error: The parameters are no such values, or the function returns a number under the name of a parameter.
    """
    called(function, "sweep")
    count = _index(jobs, "jobs")
    if count < 0:
        raise Error(f"jobs: expected the number of threads, found {count}", hint="0: one for each processor")
    rows = _worlds(parameters, _index(seed, "seed"), None if worlds is None else _index(worlds, "worlds"), sampling)
    outcomes: list[Outcome | None] = [None] * len(rows)
    try:
        with _pool(executor, count) as pool, progress_bar(0, len(rows), progress, "worlds") as show:
            _map(pool, function, rows, outcomes, show)
    except BaseException as error:
        vars(error)["results"] = _results(rows, outcomes)
        raise
    return _results(rows, outcomes)


def _results(rows: list[dict[str, Any]], outcomes: list[Outcome | None]) -> SweepResults:
    """Of the worlds that have an outcome."""
    done = [(k, outcome) for k, outcome in enumerate(outcomes) if outcome is not None]
    failures = {i: why for i, (_, (why, _)) in enumerate(done) if why}
    values = {name: _parameter([rows[k].get(name) for k, _ in done]) for name in _names(rows)}
    found = [returned for _, (_, returned) in done]
    measures: dict[str, Column] = {name: _measure([each.get(name) for each in found]) for name in _names(found)}
    return SweepResults(np.array([k for k, _ in done], dtype=np.int64), values, measures, failures)


def _worlds(parameters: Parameters, seed: int, count: int | None, sampling: str) -> list[dict[str, Any]]:
    if seed < 0 or (count is not None and count < 1):
        raise Error("the seed can't be negative, and worlds are at least 1")
    if isinstance(parameters, Mapping):
        names = [_name(each) for each in parameters]
        choices: list[list[Any] | Distribution] = []
        for name, given in cast("Mapping[str, Any]", parameters).items():
            if isinstance(given, Distribution):
                choices.append(given)
                continue
            if isinstance(given, str) or not hasattr(given, "__iter__"):
                raise Error(f"parameter {name!r}: expected a sequence of values, found {given!r:.40}", hint=f"[{given!r:.40}]")
            choices.append([_plain(each) for each in given])
        if count is not None:
            return _drawn(names, choices, seed, count, sampling)
        lists = [each for each in choices if not isinstance(each, Distribution)]
        if len(lists) < len(choices):
            raise Error("distributions need the number of worlds", hint="worlds=1000")
        return [dict(zip(names, each, strict=True)) for each in itertools.product(*lists)]
    if count is not None:
        raise Error("worlds: only a dictionary of distributions or sequences can be drawn from")
    if isinstance(parameters, (int, np.integer)) and not isinstance(parameters, bool):
        if parameters < 0:
            raise Error("the number of worlds can't be negative")
        return [{"seed": _seed(seed, world)} for world in range(int(parameters))]
    if isinstance(parameters, str) or not hasattr(parameters, "__iter__"):
        raise Error(
            f"expected parameters, found {parameters!r:.40}",
            hint='a dictionary of sequences, {"mass": [1, 2]}, a sequence of dictionaries, or a number of worlds',
        )
    worlds: list[dict[str, Any]] = []
    for number, each in enumerate(cast("Sequence[Any]", parameters)):
        if not isinstance(each, Mapping):
            raise Error(f"parameters of world {number}: expected a dictionary, found {each!r:.40}")
        worlds.append(_named(cast("Any", each)))
    return worlds


def _drawn(
    names: list[str], choices: list[list[Any] | Distribution], seed: int, count: int, sampling: str
) -> list[dict[str, Any]]:
    variables: list[tuple[str, tuple[str, Sequence[float]]]] = []
    for name, each in zip(names, choices, strict=True):
        variables.append((name, (each.kind, each.numbers) if isinstance(each, Distribution) else ("list", [len(each)])))
    worlds: list[dict[str, Any]] = [{} for _ in range(count)]
    for name, each, column in zip(names, choices, _draw(variables, count, seed, sampling).T, strict=True):
        for world, value in zip(worlds, column.tolist(), strict=True):
            world[name] = value if isinstance(each, Distribution) else each[int(value)]
    return worlds


def _seed(seed: int, world: int) -> int:
    """53 bits: a column of doubles holds them exactly."""
    return int(np.random.SeedSequence([seed, world]).generate_state(1, np.uint64)[0] >> np.uint64(11))


def _name(key: Any) -> str:
    if isinstance(key, str):
        return key
    raise Error(f"names are texts, found {key!r:.40}")


def _named(values: Mapping[Any, Any]) -> dict[str, Any]:
    return {_name(key): _plain(value) for key, value in values.items()}


def _plain(value: Any) -> Any:
    return cast("Any", value).item() if isinstance(value, np.generic) else value


def _names(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    return list(dict.fromkeys(name for row in rows for name in row))


def _measure(column: list[Any]) -> Array:
    return np.array([math.nan if value is None else value for value in column], dtype=np.float64)


def _parameter(column: list[Any]) -> Column:
    if column and all(isinstance(value, bool) for value in column):
        return np.array(column, dtype=np.bool_)
    if all(value is None or isinstance(value, (int, float)) for value in column):
        return _measure(column)
    return np.array(["" if value is None else str(value) for value in column])


def _outcome(returned: Any) -> dict[str, Any]:
    found: Mapping[Any, Any] = {"value": returned}
    if isinstance(returned, Mapping):
        found = cast("Any", returned)
    measures: dict[str, Any] = {}
    for key, given in found.items():
        value: Any = given
        if isinstance(given, (np.generic, np.ndarray)) and given.size == 1:
            value = cast("Any", given).item()
        if value is not None:
            if not isinstance(value, (int, float)):
                raise TypeError(f"the function returned {given!r:.40} as {key!r}, which is no number")
            value = float(value)  # flags, too
        measures[_name(key)] = value
    return measures


def _call(function: Callable[..., Any], worlds: Sequence[Mapping[str, Any]]) -> list[Outcome]:
    outcomes: list[Outcome] = []
    for values in worlds:
        try:
            outcomes.append(("", _outcome(function(**values))))
        except Exception as error:  # noqa: BLE001
            outcomes.append((_reason(error), {}))
    return outcomes


def _reason(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__


@contextmanager
def _pool(executor: Executor | None, jobs: int) -> Generator[Executor | None, None, None]:
    if executor is not None or jobs == 1:
        yield executor
        return
    pool = ThreadPoolExecutor(jobs or os.cpu_count() or 1)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _map(
    pool: Executor | None,
    function: Callable[..., Any],
    worlds: list[dict[str, Any]],
    outcomes: list[Outcome | None],
    show: Show | None,
) -> None:
    """Fills `outcomes` as far as it gets."""
    parameters = set(_names(worlds))
    first = True

    def take(start: int, found: list[Outcome]) -> None:
        nonlocal first
        for k, (why, returned) in enumerate(found, start):
            clash = next((name for name in returned if name in parameters), None)
            if clash is not None and first:
                raise Error(f"the function returns {clash!r}, which is a parameter", hint="rename one of them")
            first = first and bool(why)
            outcomes[k] = (why, returned) if clash is None else (f"the function returned {clash!r}, which is a parameter", {})
        if show is not None:
            show(start + len(found))

    if pool is None:
        for k, values in enumerate(worlds):
            take(k, _call(function, [values]))
        return
    size = max(1, len(worlds) // 1000)
    futures: dict[int, Future[list[Outcome]]] = {}
    broken = ""
    try:
        try:
            for start in range(0, len(worlds), size):
                futures[start] = pool.submit(_call, function, worlds[start : start + size])
        except BrokenExecutor as error:
            broken = _reason(error)
        for start, future in futures.items():
            try:
                take(start, future.result())
            except (BrokenExecutor, CancelledError) as error:
                broken = broken or _reason(error)
        if broken and all(outcome is None for outcome in outcomes):
            raise Error(f"the executor computed no world: {broken}")
        for k, outcome in enumerate(outcomes):
            outcomes[k] = outcome or (broken, {})
    except BaseException:
        for start, future in futures.items():
            if future.done() and not future.cancelled() and future.exception() is None and outcomes[start] is None:
                outcomes[start : start + size] = future.result()
        raise
    finally:
        for future in futures.values():
            future.cancel()
