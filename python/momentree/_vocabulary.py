"""The base classes of joints, actions and conditions: values that describe what a scenario file describes by its tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Union, cast

import numpy as np
from numpy.typing import NDArray

from momentree._core import Body, Joint, ModelBody, Spring, World
from momentree._errors import Error

Number = Union[float, int, str, np.floating[Any]]
"""A number in SI units, or a string with a unit: ``"5 cm"``."""
Vector = Union[Sequence[Number], NDArray[Any]]
"""Three numbers."""
Numbers = Union[Number, Sequence[Number], NDArray[Any]]
"""One number, or one for each degree of freedom or coordinate."""
Signal = Union[Number, Mapping[str, Any]]
"""A number, or a function of time: ``{"table": [[t, value], …]}``, ``{"sine": {…}}``, ``{"rate": …}``."""
Signals = Union[Signal, Sequence[Signal]]
"""One signal, or one for each degree of freedom."""
Pose = Union[Vector, Mapping[str, Any]]
"""A position (m), or ``{"xyz": …, "quat": …}`` or ``{"xyz": …, "rpy": …}``."""
BodyName = Union[str, Body, ModelBody]
"""A body: its name, or a handle."""
JointName = Union[str, Joint]
"""A joint: its name, or a handle."""
Component = Literal["fx", "fy", "fz", "mx", "my", "mz"]
"""Of a wrench: forces, then torques."""


Undetermined = Literal["least_norm"]
"""What a condition takes for a reaction that closed loops leave open."""


def given(**fields: Any) -> dict[str, Any]:
    """The fields that are not None."""
    return {key: value for key, value in fields.items() if value is not None}


def pose(at: Pose | None) -> Any:
    """A pose as scenario files have it."""
    if at is None or isinstance(at, Mapping):
        return at
    return {"xyz": at}


def drive_of(effort: Signals | None, drive: Mapping[str, Any] | None) -> Mapping[str, Any] | None:
    """A drive that includes an effort."""
    return drive if effort is None else {**(drive or {}), "effort": effort}


def _handles(values: Sequence[object]) -> list[Any]:
    return [value for value in values if isinstance(value, (Body, Joint))]


class JointSpec:
    """A joint of any kind, to be given to :meth:`Model.add`, :func:`change_joint` or :func:`attach`.

    :func:`Revolute`, :func:`Ball` … make one. It is a value: equal if kind and parameters are, and not changed by its use.
    """

    __slots__ = ("fields", "kind")

    def __init__(self, kind: str, fields: Mapping[str, Any]) -> None:
        self.kind: str = kind
        """As in scenario files: ``"revolute"``."""
        self.fields: dict[str, Any] = dict(fields)
        """The parameters that were given, in SI units or as text with units."""

    def scenario_value(self) -> dict[str, Any]:
        """The joint as a table of a scenario file."""
        return {"kind": self.kind, **self.fields}

    def __repr__(self) -> str:
        text = ", ".join(f"{key}={value!r}" for key, value in self.fields.items())
        return f"momentree.{self.kind.capitalize()}({text})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, JointSpec) and repr(self) == repr(other)

    def __hash__(self) -> int:
        return hash(repr(self))


class Action:
    """What an event does: :func:`break_joint`, :func:`lock`, :func:`weld` … make one.

    Give it to :meth:`Simulation.apply`, :meth:`Scheduled.then` or :meth:`Batch.apply`. One that was made with names may be given to
    any simulation, one made with handles only to theirs.
    """

    def __init__(self, key: str, value: Any, names: Sequence[object] = ()) -> None:
        self.key: str = key
        """Its key in scenario files: ``"break"``."""
        self.value: Any = value
        """Its value in scenario files; may contain handles."""
        self._handles = _handles(names)

    def scenario_value(self) -> Any:
        """Its value in scenario files, with names in place of handles."""
        return _plain(self.value)

    def __repr__(self) -> str:
        return f"<momentree.Action {self.key} {self.value!r}>"

    def __getstate__(self) -> dict[str, Any]:
        return {"key": self.key, "value": _plain(self.value), "_handles": []}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)


def break_spring(spring: str | Spring) -> Action:
    """Breaks a spring, or parts a cable: it exerts no force from then on.

    Args:
        spring: Name of the spring or cable, or its handle.
    """
    return Action("break", {"joint": spring if isinstance(spring, str) else spring.name})


class Condition:
    """A quantity with its threshold, for :meth:`Simulation.when`; ``reaction("load").force > 40`` makes one.

    The instant at which the quantity crosses the threshold is located to ``event_tolerance``, whatever the step. It is met when the
    quantity crosses, not while it is past the threshold; a quantity that is past it when the run begins meets it at once.
    """

    def __init__(self, quantity: Quantity, threshold: Number | None, exceeds: bool) -> None:
        self.quantity: Quantity = quantity
        """What is compared."""
        self.threshold: Number | None = threshold
        """In the SI unit of the quantity, or text with a unit; None for what is true or not: :func:`touch`, :func:`slip`."""
        self.exceeds: bool = exceeds
        """True for ``>``, False for ``<``."""
        self._options: dict[str, Any] = {}

    def _with(self, **options: Any) -> Condition:
        copy = Condition(self.quantity, self.threshold, self.exceeds)
        copy._options = {**self._options, **options}
        return copy

    def repeated(self, hysteresis: Number | None = None) -> Condition:
        """The same condition, which may be met again.

        Args:
            hysteresis: It is armed again once the quantity is back past the threshold by this much, in the quantity's unit; default:
                1 % of the threshold.
        """
        return self._with(repeat=True, hysteresis=hysteresis)

    def lasting(self, seconds: Number) -> Condition:
        """The same condition, met only after the quantity was past the threshold for ``seconds`` without interruption."""
        return self._with(**{"for": seconds})

    def per_step(self) -> Condition:
        """The same condition, evaluated only at the ends of steps: cheaper, and as exact as the step is long."""
        return self._with(locate="per step")

    def scenario_value(self) -> dict[str, Any]:
        """The condition as an event's table of a scenario file."""
        threshold = given(**{"exceeds" if self.exceeds else "below": self.threshold})
        quantity = {self.quantity.key: _plain(self.quantity.value), **self.quantity.options}
        return {"when": {**quantity, **threshold}, **given(**self._options)}

    def __repr__(self) -> str:
        if self.threshold is None:
            return f"<momentree.Condition {self.quantity}>"
        return f"<momentree.Condition {self.quantity} {'>' if self.exceeds else '<'} {self.threshold}>"

    def __bool__(self) -> bool:
        raise Error(
            "a condition is not true or false by itself",
            hint="pass it to sim.when(…); for two conditions schedule two events",
        )


class Quantity:
    """A scalar function of the world's state: :func:`distance`, :func:`speed`, :func:`measured` … make one.

    Comparing it with a number by ``>`` or ``<`` makes a :class:`Condition`.
    """

    def __init__(self, key: str, value: Any, names: Sequence[object] = (), options: Mapping[str, Any] | None = None) -> None:
        self.key: str = key
        """Its key in scenario files; ``"function"`` for a Python function."""
        self.value: Any = value
        """Its value in scenario files, or the function."""
        self.options: dict[str, Any] = dict(options or {})
        """Keys that go with it in scenario files: ``{"undetermined": "least_norm"}``."""
        self._handles = _handles(names)

    def __gt__(self, threshold: Number) -> Condition:
        return Condition(self, threshold, True)

    def __lt__(self, threshold: Number) -> Condition:
        return Condition(self, threshold, False)

    def exceeds(self, threshold: Number) -> Condition:
        """The condition of rising above a threshold, in the quantity's SI unit; the same as ``quantity > threshold``."""
        return self > threshold

    def below(self, threshold: Number) -> Condition:
        """The condition of falling below a threshold, in the quantity's SI unit; the same as ``quantity < threshold``."""
        return self < threshold

    def __repr__(self) -> str:
        return f"{self.key}({self.value!r})"


class Onset(Quantity):
    """A quantity that also makes a condition without a threshold: :func:`slip`, that bodies begin to slip.

    :meth:`Simulation.when` takes it as that condition.
    """

    def begins(self) -> Condition:
        """The condition without a threshold, which may then be :meth:`~Condition.repeated`."""
        return Condition(self, None, True)


def measured(function: Callable[[World], float]) -> Quantity:
    """Any function of the world's state, continuous where its crossing is to be located.

    Args:
        function: Called with the :class:`World` at states that steps try; may read only that world. Exceptions that it raises end
            the run and propagate.

    Raises:
        Error: It is not callable.
    """
    if not callable(function):
        raise Error("measured: expected a function of the world", hint="for example lambda world: world.joints['arm'].q[0]")
    return Quantity("function", function)


class Reaction:
    """The wrench that a joint transmits, equation (32) of the paper: quantities for conditions.

    It is the wrench of the parent on the child, about the origin of the joint's frame on the child, in the child's axes.
    """

    def __init__(self, joint: JointName, undetermined: Undetermined | None = None) -> None:
        self._joint = joint
        self._options = given(undetermined=undetermined)

    @property
    def force(self) -> Quantity:
        """Norm of the force (N); of a spring, the size of its force."""
        return Quantity("reaction_force", self._joint, [self._joint], self._options)

    @property
    def torque(self) -> Quantity:
        """Norm of the torque (N m)."""
        return Quantity("reaction_torque", self._joint, [self._joint], self._options)

    def component(self, name: Component) -> Quantity:
        """One component in the child's axes: ``"fx"``, ``"fy"``, ``"fz"`` (N), ``"mx"``, ``"my"`` or ``"mz"`` (N m)."""
        return Quantity("reaction", {"joint": self._joint, "component": name}, [self._joint], self._options)


def _plain(value: Any) -> Any:
    """Names in place of handles, so that the value does not depend on a simulation."""
    if isinstance(value, (Body, Joint, ModelBody)):
        return value.name
    if hasattr(value, "scenario_value"):
        return _plain(value.scenario_value())
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in cast("Mapping[str, Any]", value).items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in cast("Sequence[Any]", value)]
    return value
