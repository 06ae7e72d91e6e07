"""Sweeps of Python functions."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Union, cast

import numpy as np
from numpy.typing import NDArray

from momentree._arguments import called
from momentree._core import _draw
from momentree._errors import Error
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
    jobs: int = 1,
    executor: Executor | None = None,
) -> SweepResults:
    """Call a Python function for each world of a sweep: ``function(**values)`` returns a number or a dictionary of numbers.

    An exception of the function is the status of its world. A key that a world does not return is NaN, or False if it is a flag;
    a single number is the measure ``value``.

    Args:
        function: What computes a world. With processes it must be importable: a function of a module.
        parameters: ``{"mass": [1, 2], "angle": angles}`` combines all values, and the last one varies fastest; a sequence of
            dictionaries has one for each world; a number N makes N calls ``function(seed=...)`` with different seeds.
            Distributions, such as ``{"mass": mt.normal(1, 0.1)}``, need `worlds`.
        worlds: Number of worlds. Values are then drawn, those of sequences with equal probabilities.
        sampling: How distributions are drawn: ``"random"``, ``"latin"`` (hypercube) or ``"sobol"``.
        seed: Determines the drawn values, and the seeds of the worlds if `parameters` is a number.
        jobs: Threads; 0: one for each processor. They run side by side only where the function releases the GIL, as runs do.
        executor: Computes the worlds instead: a ``ProcessPoolExecutor``, or ``mpi4py.futures.MPIPoolExecutor``.

    Returns:
        The results in the order of the worlds, whatever computed them.

    Raises:
        Error: The parameters are no such values, or two worlds return different kinds of values under one name.
    """
    called(function, "sweep")
    count = _index(jobs, "jobs")
    if count < 0:
        raise Error(f"jobs: expected the number of threads, found {count}", hint="0: one for each processor")
    rows = _worlds(parameters, _index(seed, "seed"), None if worlds is None else _index(worlds, "worlds"), sampling)
    with _pool(executor, count) as pool:
        outcomes = _map(pool, function, rows)
    failures = {k: why for k, (why, _) in enumerate(outcomes) if why}
    values = {name: _parameter([each.get(name) for each in rows]) for name in _names(rows)}
    found = [returned for _, returned in outcomes]
    measures = {name: _measure(name, [each.get(name) for each in found]) for name in _names(found)}
    for name in measures:
        if name in values:
            raise Error(f"the function returns {name!r}, which is a parameter", hint="rename one of them")
    return SweepResults(np.arange(len(rows), dtype=np.int64), values, measures, failures)


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


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _parameter(column: list[Any]) -> Column:
    if all(value is None or _is_number(value) for value in column):
        return np.array([math.nan if value is None else value for value in column], dtype=np.float64)
    if all(isinstance(value, bool) for value in column):
        return np.array(column, dtype=np.bool_)
    return np.array(["" if value is None else str(value) for value in column])


def _measure(name: str, column: list[Any]) -> Column:
    there = [value for value in column if value is not None]
    flags = sum(isinstance(value, bool) for value in there)
    if there and flags == len(there):
        return np.array([bool(value) for value in column], dtype=np.bool_)
    if flags:
        raise Error(f"the function returns {name!r} as a number in some worlds and as True or False in others")
    return np.array([math.nan if value is None else value for value in column], dtype=np.float64)


def _outcome(returned: Any) -> dict[str, Any]:
    found: Mapping[Any, Any] = {"value": returned}
    if isinstance(returned, Mapping):
        found = cast("Any", returned)
    measures: dict[str, Any] = {}
    for key, given in found.items():
        value: Any = given
        if isinstance(given, (np.generic, np.ndarray)) and given.size == 1:
            value = cast("Any", given).item()
        if value is not None and not isinstance(value, bool):
            if not _is_number(value):
                raise TypeError(f"the function returned {given!r:.40} as {key!r}, which is no number")
            value = float(value)
        measures[_name(key)] = value
    return measures


def _call(function: Callable[..., Any], worlds: Sequence[Mapping[str, Any]]) -> list[Outcome]:
    outcomes: list[Outcome] = []
    for values in worlds:
        try:
            outcomes.append(("", _outcome(function(**values))))
        except Exception as error:  # noqa: BLE001
            outcomes.append((f"{type(error).__name__}: {error}" if str(error) else type(error).__name__, {}))
    return outcomes


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


def _map(pool: Executor | None, function: Callable[..., Any], worlds: list[dict[str, Any]]) -> list[Outcome]:
    if pool is None:
        return _call(function, worlds)
    size = max(1, len(worlds) // 1000)
    futures: list[Future[list[Outcome]]] = []
    try:
        for first in range(0, len(worlds), size):
            futures.append(pool.submit(_call, function, worlds[first : first + size]))
        return [outcome for future in futures for outcome in future.result()]
    finally:
        for future in futures:
            future.cancel()
