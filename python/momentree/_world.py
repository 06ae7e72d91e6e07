"""Bodies, joints and springs by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, TypeVar, overload

from momentree._core import Body, Joint, Spring, World
from momentree._errors import Error


Value = TypeVar("Value")
Default = TypeVar("Default")


class Named(Mapping[str, Value]):
    """Values by name. An unknown name is an Error, but not to ``in`` and ``get``."""

    @overload
    def get(self, key: str, /) -> Value | None: ...
    @overload
    def get(self, key: str, /, default: Value | Default) -> Value | Default: ...
    def get(self, key: str, /, default: Any = None) -> Any:
        """The value of that name, or the default."""
        return self[key] if key in self else default

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)


class Columns(Named[Value]):
    """Values that are made when they are first asked for and kept."""

    def __init__(self, names: Sequence[str], make: Callable[[str], Value], keep: bool = True) -> None:
        self._names = list(names)
        self._make = make
        self._keep = keep
        self._made: dict[str, Value] = {}

    def __getitem__(self, name: str) -> Value:
        if name in self._made:
            return self._made[name]
        value = self._make(name)
        if self._keep:
            self._made[name] = value
        return value

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<{', '.join(self)}>"


class Bodies(Named[Body]):
    """The bodies of a world by name, in the order of adding, without those that were removed.

    An unknown name is an Error that suggests the nearest one.
    """

    def __init__(self, world: World) -> None:
        self._world = world

    def __getitem__(self, name: str) -> Body:
        return self._world._body(name)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self._world._has_body(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._world._body_names())

    def __len__(self) -> int:
        return len(self._world._body_names())

    def __repr__(self) -> str:
        return f"<momentree.Bodies: {', '.join(self)}>"


class Joints(Named[Joint]):
    """The joints of a world by name, in the order of their numbers, without those that were removed with their body. Loop joints
    come last.

    An unknown name is an Error that suggests the nearest one.
    """

    def __init__(self, world: World) -> None:
        self._world = world

    def __getitem__(self, name: str) -> Joint:
        return self._world._joint(name)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self._world._has_joint(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._world._joint_names())

    def __len__(self) -> int:
        return len(self._world._joint_names())

    def __repr__(self) -> str:
        return f"<momentree.Joints: {', '.join(self)}>"


class Springs(Named[Spring]):
    """The springs of a world by name, in the order of adding; those that are broken stay.

    An unknown name is an Error that suggests the nearest one.
    """

    def __init__(self, world: World) -> None:
        self._world = world

    def __getitem__(self, name: str) -> Spring:
        return self._world._spring(name)

    def __contains__(self, name: object) -> bool:
        return name in self._world._spring_names()

    def __iter__(self) -> Iterator[str]:
        return iter(self._world._spring_names())

    def __len__(self) -> int:
        return len(self._world._spring_names())

    def __repr__(self) -> str:
        return f"<momentree.Springs: {', '.join(self)}>"


class Loops(Joints):
    """The joints of a world that close loops, by name, in the order in which they were made.

    An unknown name is an Error that suggests the nearest one.
    """

    def __getitem__(self, name: str) -> Joint:
        joint = super().__getitem__(name)
        if not joint.loop:
            raise Error(f"the joint '{name}' closes no loop", hint="world.joints has all joints")
        return joint

    def __contains__(self, name: object) -> bool:
        return name in self._world._loop_names()

    def __iter__(self) -> Iterator[str]:
        return iter(self._world._loop_names())

    def __len__(self) -> int:
        return len(self._world._loop_names())

    def __repr__(self) -> str:
        return f"<momentree.Loops: {', '.join(self)}>"
