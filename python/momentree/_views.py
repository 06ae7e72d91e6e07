"""Arrays that follow the state of a simulation."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, SupportsIndex, cast, overload

import numpy as np
from numpy.typing import NDArray

from momentree._errors import Error

if TYPE_CHECKING:
    from momentree._core import _StateArrays


class StateView(np.ndarray[tuple[int], np.dtype[np.float64]]):
    """Coordinates, velocities, momenta or efforts of a simulation: an ``ndarray`` of shape (n,) that follows the state.

    Numbers that are written are taken over by the simulation's next operation. Slices follow the state as well; results of
    computations are plain arrays. A view keeps its memory alive. When the topology changes in such a way that the numbers belong to
    other joints, the view is stale: its numbers become NaN, and using it raises :class:`momentree.Error`. Take a new one then:
    ``sim.q``. ``view.copy()`` and ``numpy.array(view)`` make independent copies.
    """

    _owner: _StateArrays | None
    _name: str

    @classmethod
    def _of(cls, array: NDArray[np.float64], owner: _StateArrays, name: str) -> StateView:
        view = array.view(cls)
        view._owner = owner
        view._name = name
        return view

    def __array_finalize__(self, obj: object) -> None:
        # Slices of a view are views, too; results of computations own their memory and are plain numbers.
        self._owner = getattr(obj, "_owner", None) if self.base is not None else None
        self._name = getattr(obj, "_name", "")

    def _check(self) -> None:
        owner = self._owner
        if owner is not None and not owner.alive:
            raise Error(
                f"this view of {self._name or 'the state'} is stale: the topology has changed since it was taken",
                hint=f"take a new one: sim.{self._name or 'q'}",
            )

    @property
    def stale(self) -> bool:
        """True if the numbers came to belong to other joints since the view was taken."""
        return self._owner is not None and not self._owner.alive

    @overload  # type: ignore[override]
    def __getitem__(self, key: SupportsIndex) -> np.float64: ...
    @overload
    def __getitem__(self, key: slice) -> StateView: ...
    @overload
    def __getitem__(self, key: Any) -> Any: ...
    def __getitem__(self, key: Any) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        self._check()
        return super().__getitem__(key)

    def __setitem__(self, key: Any, value: Any) -> None:
        self._check()
        super().__setitem__(key, value)

    def __iter__(self) -> Any:
        self._check()
        return super().__iter__()

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        plain: list[Any] = []
        for each in inputs:
            if isinstance(each, StateView):
                each._check()
                each = each.view(np.ndarray)
            plain.append(each)
        out = kwargs.get("out")
        if out is not None:
            targets: list[Any] = []
            for each in out:
                if isinstance(each, StateView):
                    each._check()
                    each = each.view(np.ndarray)
                targets.append(each)
            kwargs["out"] = tuple(targets)
        result = getattr(ufunc, method)(*plain, **kwargs)
        if out is not None and len(out) == 1:
            return out[0]
        return result

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        def plain(value: Any) -> Any:
            if isinstance(value, StateView):
                value._check()
                return value.view(np.ndarray)
            if isinstance(value, (list, tuple)) and not hasattr(cast(Any, value), "_fields"):
                values = [plain(each) for each in cast("Sequence[Any]", value)]
                return tuple(values) if isinstance(value, tuple) else values
            return cast(Any, value)

        return func(*plain(args), **{key: plain(value) for key, value in kwargs.items()})

    def copy(self, order: Any = "C") -> NDArray[np.float64]:  # type: ignore[override]
        """An independent, plain array of the present numbers, shape (n,)."""
        self._check()
        return cast(NDArray[np.float64], self.view(np.ndarray).copy(order))

    def tolist(self) -> list[float]:
        """The present numbers as a list of n floats."""
        self._check()
        return super().tolist()

    def __repr__(self) -> str:
        if self.stale:
            return f"<stale momentree.StateView of {self._name}>"
        return super().__repr__()

    def __str__(self) -> str:
        self._check()
        return super().__str__()

    def __float__(self) -> float:
        self._check()
        return float(self.view(np.ndarray).item())

    def __reduce__(self) -> Any:
        self._check()
        return self.view(np.ndarray).copy().__reduce__()


# Methods that NumPy implements without asking __array_ufunc__ or __array_function__.
_METHODS = """all any argmax argmin argpartition argsort astype byteswap choose clip compress conj conjugate cumprod cumsum diagonal
dot dump dumps fill flatten getfield item max mean min nonzero partition prod put ravel repeat reshape round searchsorted setfield
sort squeeze std sum swapaxes take tobytes tofile trace transpose var __bool__ __complex__ __contains__ __copy__ __deepcopy__
__format__ __index__ __int__ __len__"""


def _checked(method: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(method)
    def call(self: StateView, /, *args: Any, **kwargs: Any) -> Any:
        self._check()
        return method(self, *args, **kwargs)

    return call


for _method in _METHODS.split():
    setattr(StateView, _method, _checked(getattr(np.ndarray, _method)))
