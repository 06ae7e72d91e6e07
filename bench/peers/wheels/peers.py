"""The measurement of engines from Python: the experiments, models and judge are those of the C++ programs.

They come from the shared library of ../shared.cpp, whose path is the first argument of a program. Lengths in m, masses in kg,
rotations as matrices from the body's axes to the world's, velocities in world axes, if nothing else is said.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Motion(NamedTuple):
    """Of a body's frame: rotation (3, 3), position, velocity of the origin and angular velocity (3,)."""

    R: Array
    p: Array
    v: Array
    w: Array


@dataclass
class Link:
    """A body and its inboard joint; see Link in ../experiment.hpp. `inertia` (3, 3): about the centre of mass, in the body's axes."""

    name: str
    parent: int
    joint: str
    mass: float
    angle: float
    rate: float
    turn: Array
    at: Array
    com: Array
    inertia: Array
    linear: Array
    angular: Array

    @property
    def free(self) -> bool:
        return self.joint == "free"

    @property
    def start(self) -> Motion:
        """Of a free link."""
        return Motion(self.turn, self.at, self.linear, self.angular)


@dataclass
class Experiment:
    number: int
    name: str
    change: str
    body: int
    to: int
    links: list[Link]
    start: list[Motion]


@dataclass
class EvaluationModel:
    """`states`: two pairs of positions and velocities in the order of the links, between which evaluations alternate."""

    number: int
    name: str
    gravity: float
    batch: int
    allowed: float
    links: list[Link]
    states: list[tuple[Array, Array]]

    @property
    def floating(self) -> bool:
        return self.links[0].free


class Trial(Protocol):
    """An engine with an experiment's bodies in their initial state; see Trial in ../measure.hpp."""

    elapsed: float

    def change(self) -> None: ...
    def motions(self) -> list[Motion]: ...


@dataclass
class Way:
    name: str
    note: str
    make: Callable[[Experiment], Trial]


class Evaluator(Protocol):
    """An engine with a model; see Evaluator in ../evaluation.hpp."""

    def seconds(self, count: int) -> float:
        """Time of so many evaluations, which alternate between the two states."""
        ...

    def accelerations(self, turn: int) -> Array:
        """Of the links (a free one has 0), then of a free link: of its origin, and angular, in world axes; newly evaluated."""
        ...


@dataclass
class Evaluation:
    """`overhead`: the time (s) that Python takes for the calls of one evaluation."""

    name: str
    make: Callable[[EvaluationModel], Evaluator]
    overhead: Callable[[], float]
    floating: bool = True
    most: int = 1 << 30


def link_of(data: dict[str, Any]) -> Link:
    for key in ("turn", "at", "com", "inertia", "linear", "angular"):
        data[key] = np.array(data[key])
    for key in ("turn", "inertia"):
        data[key] = data[key].reshape(3, 3)
    return Link(**data)


def motion_of(data: dict[str, list[float]]) -> Motion:
    return Motion(np.array(data["R"]).reshape(3, 3), *(np.array(data[key]) for key in "pvw"))


@dataclass
class Judge:
    """The shared library."""

    path: str
    library: ctypes.CDLL = field(init=False)

    def __post_init__(self) -> None:
        self.library = ctypes.CDLL(self.path)
        numbers = ctypes.POINTER(ctypes.c_double)
        for name, result, arguments in (
            ("experiments", ctypes.c_char_p, []),
            ("models", ctypes.c_char_p, [ctypes.c_int, ctypes.POINTER(ctypes.c_char_p)]),
            ("off_start", ctypes.c_double, [ctypes.c_int, numbers]),
            ("judge", None, [ctypes.c_int, numbers, ctypes.c_double, numbers]),
            ("imbalance", ctypes.c_double, [ctypes.c_int, ctypes.c_int, numbers]),
        ):
            function = getattr(self.library, "peers_" + name)
            function.restype, function.argtypes = result, arguments

    @staticmethod
    def _numbers(values: Array) -> Any:
        return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

    def experiments(self) -> list[Experiment]:
        all_data = json.loads(self.library.peers_experiments())
        for number, data in enumerate(all_data):
            data["links"] = [link_of(link) for link in data["links"]]
            data["start"] = [motion_of(motion) for motion in data["start"]]
            all_data[number] = Experiment(number, **data)
        return list(all_data)

    def models(self, files: Sequence[str]) -> list[EvaluationModel]:
        names = (ctypes.c_char_p * len(files))(*(file.encode() for file in files))
        models = []
        for number, data in enumerate(json.loads(self.library.peers_models(len(files), names))):
            states = [(np.array(data["q0"]), np.array(data["u0"])), (np.array(data["q1"]), np.array(data["u1"]))]
            links = [link_of(link) for link in data["links"]]
            models.append(EvaluationModel(number, data["name"], data["gravity"], data["batch"], data["allowed"], links, states))
        return models

    @staticmethod
    def _flat(motions: Sequence[Motion]) -> Array:
        return np.ascontiguousarray(np.concatenate([np.concatenate([np.ravel(part) for part in motion]) for motion in motions]))

    def off_start(self, experiment: Experiment, motions: Sequence[Motion]) -> float:
        return float(self.library.peers_off_start(experiment.number, self._numbers(self._flat(motions))))

    def judge(self, experiment: Experiment, motions: Sequence[Motion], elapsed: float) -> dict[str, float]:
        found = np.empty(6)
        self.library.peers_judge(experiment.number, self._numbers(self._flat(motions)), elapsed, self._numbers(found))
        return dict(zip(("linear", "angular", "energy", "exact_loss", "position", "velocity"), found.tolist(), strict=True))

    def imbalance(self, model: EvaluationModel, turn: int, accelerations: Array) -> float:
        return float(self.library.peers_imbalance(model.number, turn, self._numbers(np.ascontiguousarray(accelerations))))


def shortest(call: Callable[[], object], count: int = 2000, repetitions: int = 30) -> float:
    """Time of a call (s): the shortest mean of `count` calls."""
    best = float("inf")
    for _ in range(repetitions):
        begin = time.perf_counter()
        for _ in range(count):
            call()
        best = min(best, time.perf_counter() - begin)
    return best / count


def alternating(one: Callable[[], object], other: Callable[[], object]) -> Callable[[int], float]:
    """`Evaluator.seconds` for calls that evaluate in one state and in the other."""

    def seconds(count: int) -> float:
        begin = time.perf_counter()
        for _ in range(count // 2):
            one()
            other()
        if count % 2:
            one()
        return time.perf_counter() - begin

    return seconds


def put(result: dict[str, Any]) -> None:
    """To file descriptor 3; engines write messages to the standard output."""
    os.write(3, (json.dumps(result, ensure_ascii=False) + "\n").encode())


def measure(judge: Judge, engine: str, experiment: Experiment, way: Way) -> None:
    trial = way.make(experiment)
    off = judge.off_start(experiment, trial.motions())
    if not off < 1e-9:
        sys.exit(f"{engine}, {experiment.name}, {way.name}: bodies do not start as they should, off by {off:g}")
    trial.change()
    found = judge.judge(experiment, trial.motions(), trial.elapsed)
    elapsed = trial.elapsed
    times: list[float] = []
    begin = time.perf_counter()
    while len(times) < 15 or (len(times) < 501 and time.perf_counter() - begin < 1.5):
        trial = way.make(experiment)
        gc.disable()
        at = time.perf_counter()
        trial.change()
        times.append(time.perf_counter() - at)
        gc.enable()
    result = {"experiment": experiment.name, "engine": engine, "way": way.name, **found, "elapsed": elapsed}
    put(result | {"microseconds": 1e6 * statistics.median(times), "note": way.note})


def evaluate(judge: Judge, engine: str, ways: Sequence[Evaluation], files: Sequence[str]) -> int:
    wrong = 0
    for model in judge.models(files):
        for way in ways:
            if len(model.links) > way.most or (model.floating and not way.floating):
                continue
            evaluator = way.make(model)
            error = max(judge.imbalance(model, turn, evaluator.accelerations(turn)) for turn in (0, 1, 0))
            if not error < model.allowed:
                print(f"{engine}, {way.name}, {model.name}: the accelerations are wrong, off balance by {error:g}", file=sys.stderr)
                wrong = 1
                continue
            best, repeat, begin = float("inf"), 0, time.perf_counter()
            gc.disable()
            while repeat < 20 or time.perf_counter() - begin < 1:
                best = min(best, evaluator.seconds(model.batch) / model.batch)
                repeat += 1
            gc.enable()
            result = {"model": model.name, "engine": engine, "way": way.name, "imbalance": error,
                      "ns_per_body": 1e9 * best / len(model.links), "python_us": 1e6 * way.overhead()}  # fmt: skip
            put(result)
    return wrong


def main(engine: str, ways: Callable[[str], list[Way]], evaluations: Sequence[Evaluation]) -> int:
    """`PROGRAM LIBRARY` measures the changes, `PROGRAM LIBRARY evaluate FILE…` evaluations."""
    judge = Judge(sys.argv[1])
    if len(sys.argv) > 2:
        return evaluate(judge, engine, evaluations, sys.argv[3:])
    for experiment in judge.experiments():
        for way in ways(experiment.change):
            measure(judge, engine, experiment, way)
    return 0
