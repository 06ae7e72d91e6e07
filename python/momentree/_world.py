"""Bodies and joints of a world by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from momentree._core import Body, Joint, World


class Bodies(Mapping[str, "Body"]):
    """The bodies of a world by name; an unknown name is an error that suggests the nearest one."""

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

    def _ipython_key_completions_(self) -> list[str]:
        return self._world._body_names()

    def __repr__(self) -> str:
        return f"<momentree.Bodies: {', '.join(self)}>"


class Joints(Mapping[str, "Joint"]):
    """The joints of a world by name; an unknown name is an error that suggests the nearest one."""

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

    def _ipython_key_completions_(self) -> list[str]:
        return self._world._joint_names()

    def __repr__(self) -> str:
        return f"<momentree.Joints: {', '.join(self)}>"
