"""Valid and hostile values for the fuzzer of the API."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import momentree as mt


class Raises:
    """Every conversion of it fails."""

    def _fail(self, *_: Any, **__: Any) -> Any:
        raise ZeroDivisionError("of a hostile object")

    __float__ = __int__ = __index__ = __array__ = __iter__ = __len__ = __getitem__ = __fspath__ = __bool__ = __hash__ = _fail
    __gt__ = __lt__ = __eq__ = __call__ = scenario_value = tolist = items = keys = _fail  # type: ignore[assignment]

    def __repr__(self) -> str:
        return "<hostile>"


class Busy:
    """Converting it uses the simulations: changes from inside a conversion."""

    def __init__(self, act: Callable[[], Any], size: int) -> None:
        self._act, self._size = act, size

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray[Any, Any]:
        self._act()
        return np.linspace(0.1, 0.4, self._size)

    def __float__(self) -> float:
        self._act()
        return 0.25

    def __iter__(self) -> Iterator[float]:
        self._act()
        return iter(np.linspace(0.1, 0.4, self._size).tolist())

    def __len__(self) -> int:
        self._act()
        return self._size

    def __getitem__(self, key: int) -> float:
        self._act()
        if key >= self._size:
            raise IndexError(key)
        return 0.5

    def __call__(self, *_: Any) -> Any:
        self._act()
        return 0.125

    def scenario_value(self) -> Any:
        self._act()
        return {"joint": "m0/body"}


class Liar(list[float]):
    """Says that it is longer or shorter than it is."""

    def __len__(self) -> int:
        return 7


class Table(dict[str, Any]):
    """A mapping whose items are no pairs, or never what they were."""

    def items(self) -> Any:
        return [("xyz", [1, 2, 3]), ("xyz", None), (3, 4), "ab"]


def cyclic() -> list[Any]:
    """A list that contains itself."""
    loop: list[Any] = [1.0]
    loop.append(loop)
    return loop


def nested(depth: int) -> Any:
    """A deep nest of lists and tables."""
    value: Any = 1.0
    for k in range(depth):
        value = [value] if k % 2 else {"xyz": value}
    return value


CONSTANTS: list[Any] = [
    None, True, False, 0, 1, -1, 2, 3, 0.0, -0.0, 0.5, 1e-3, 1e-12, 5e-324, 1e308, -1e308, float("nan"), float("inf"),
    float("-inf"), 10**400, 2**31, -(2**31), 2**63, 2**64, 1j, "", " ", "nan", "5 cm", "1 furlong", "a\0b", "\ud800", "ü/ß", "*",
    "m*", "m0/*", "ground", "m0/body", "m0/b1", "m0", "rk4", "dopri5", "energy", "m0/body.q", "fx", "x" * 5000, "[" * 2000,
    "format = 1", "a.urdf", b"m0/body", (), [], {}, set(), [[]], [[1, 2], [3]], [1, 2, 3], (0, 0, 1), [1, "2", None],
    ["a", "b", "c"], [float("nan")] * 3, [1e308] * 3, {"xyz": [0, 0, 1]}, {"quat": [0, 0, 0, 0]}, {"table": [[0, 1], [1, 2]]},
    {"sine": {}}, {"a": {"b": {}}}, {1: 2}, range(4), iter([1, 2]), object(), int, len, print, Ellipsis, NotImplemented,
    slice(None),
    slice(5, -1, -1), np.float32(1), np.int8(3), np.bool_(True), np.zeros(0), np.zeros((0, 3)), np.zeros((3, 0)), np.ones(3),
    np.ones(3, np.float32), np.ones(3, ">f8"), np.ones(6)[::2], np.ones((3, 3)).T, np.ones((2, 3, 4)), np.array(1.5),
    np.array([1, 2, None]), np.array(["a", "b"]), np.array([1 + 1j]), np.array([1, 2, 3], "M8[s]"), np.arange(5), np.ones(8,
    bool),
    np.ma.masked_array([1.0, 2.0, 3.0], [0, 1, 0]), np.array([(1, 2.0)], [("a", int), ("b", float)]), np.full(3, np.inf),
    memoryview(b"abc"), bytearray(24), nested(10), nested(60), cyclic(), Liar([1.0, 2.0, 3.0]), Table(a=1), Raises(),
    lambda *_: 0.0,
    lambda *_: (_ for _ in ()).throw(ZeroDivisionError("of a hostile function")), lambda *_: ((0, 0, 1), (0, 0, 0)),
    lambda w: w.time - 0.01, lambda *_: None, lambda *_: "x", lambda *_: [1, 2, 3, 4, 5, 6, 7], lambda *_: float("nan"),
    mt.Error("problem"), mt.Revolute(), mt.Free(), mt.Weld(), mt.Ball(damping=1), mt.Helical(pitch=0.2), mt.Revolute(axis=(0, 0,
    0)),
    mt.JointSpec("revolute", {"axis": Raises()}), mt.JointSpec("nothing", {}), mt.Action("break", {"joint": "m0/body"}),
    mt.Action("nothing", 3), mt.Action("break", cyclic()), mt.break_joint("*"), mt.lock("m0/body", [0, 99]), mt.unlock("m0/b1"),
    mt.speed("m0/body") > 0.1, mt.height("m0/body") < 0.5, mt.kinetic_energy("m0") > 1, mt.reaction("m0/b1").force > 1,
    mt.measured(lambda w: w.time) > 0.005, mt.position("m0/b1"), mt.reaction("m0/b1"),
]  # fmt: skip


class Values:
    """Draws values: of the pools, constants, or arrays of a plausible size."""

    def __init__(self, rng: random.Random, pools: dict[str, list[Any]]) -> None:
        self._rng, self._pools = rng, pools

    def any(self) -> Any:
        """Anything."""
        rng = self._rng
        choice = rng.random()
        if choice < 0.35:
            pool = self._pools[rng.choice(list(self._pools))]
            return rng.choice(pool) if pool else None
        if choice < 0.45:
            return np.array([rng.uniform(-1, 1) for _ in range(rng.randrange(12))])
        if choice < 0.50:
            return [rng.choice(CONSTANTS) for _ in range(rng.randrange(4))]
        return rng.choice(CONSTANTS)

    def name(self, names: list[str]) -> Any:
        """One of the names, or seldom anything."""
        return self._rng.choice(names) if names and self._rng.random() < 0.9 else self.any()
