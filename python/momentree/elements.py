"""Elements between bodies, with the keys of scenario files. :class:`Model` has these methods."""

# Written by tools/python_vocabulary from the library's lists.
from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Union

from momentree import _core
from momentree._errors import Error
from momentree._vocabulary import Number, Vector, given

End = Union[str, _core.ModelBody, tuple[Union[str, _core.ModelBody], Vector]]
"""An end of an element: a body or ``"ground"``, or a pair of it and a point in its frame (m)."""


def _end(end: End) -> Any:
    if isinstance(end, tuple) and len(end) != 2:
        raise Error("an end of a spring is a body, or a pair of a body and a point", hint="for example ('arm/hand', (0, 0, 0.1))")
    body, point = end if isinstance(end, tuple) else (end, None)
    return given(body=body.name if isinstance(body, _core.ModelBody) else body, point=point)


class Elements(_core.ModelBase):
    """The elements of a model."""

    def add_spring(
        self,
        name: str,
        *,
        start: End,
        end: End,
        stiffness: Number | None = None,
        rest: Number | None = None,
        damping: Number | None = None,
        tension_only: bool | None = None,
        strength: Number | None = None,
    ) -> None:
        """Add a spring or a rope between two points of bodies.

        The points are of different bodies, or of a body and the ground. The force is along the line between them:
        stiffness·(length − rest) + damping·(rate of the length) pulls them together. It stays with the bodies, whatever they
        are joined to. ``sim.world.springs[name]`` has its length and tension; ``break_joint`` breaks it, and
        ``reaction(name).force`` is the size of its force.

        Args:
            name: Unique among springs, cables and joints.
            start: One end: a body, or ``"ground"``; or a pair of it and a point in its frame (m): ``("arm/hand", (0, 0,
                0.1))``.
            end: The other end, likewise.
            stiffness: Stiffness (N/m).
            rest: Length without force (m); default: the distance at the start.
            damping: Force per rate of the length (N s/m).
            tension_only: A rope: it pulls and never pushes.
            strength: It breaks when its force exceeds this (N).

        Raises:
            Error: A value is impossible or a name unknown or used twice; the model is unchanged.
        """
        self._add_element("spring", name, {"from": _end(start), "to": _end(end), **given(stiffness=stiffness, rest=rest, damping=damping, tension_only=tension_only, strength=strength)})

    def add_cable(
        self,
        name: str,
        *,
        start: End,
        end: End,
        length: Number | None = None,
        restitution: Number | None = None,
        strength: Number | None = None,
    ) -> None:
        """Add an inextensible cable between two points of bodies.

        The points are of different bodies, or of a body and the ground, and never farther apart than its length. It becomes
        taut by an impact (event ``taut NAME``), then exerts the tension that this takes, and is slack from the instant at
        which it would have to push (event ``slack NAME``). ``sim.world.springs[name]`` has its length and tension;
        ``break_joint`` cuts it.

        Args:
            name: Unique among springs, cables and joints.
            start: One end: a body, or ``"ground"``; or a pair of it and a point in its frame (m): ``("arm/hand", (0, 0,
                0.1))``.
            end: The other end, likewise.
            length: Its ends are never farther apart (m); default: the distance at the start.
            restitution: How its ends rebound when it becomes taut: 0 (not at all) to 1.
            strength: It breaks when its tension exceeds this (N).

        Raises:
            Error: A value is impossible or a name unknown or used twice; the model is unchanged.
        """
        self._add_element("cable", name, {"from": _end(start), "to": _end(end), **given(length=length, restitution=restitution, strength=strength)})

    def add_coupling(
        self,
        joint: str,
        follows: str | None = None,
        *,
        multiplier: Number | None = None,
        offset: Number | None = None,
        polynomial: Sequence[float] | None = None,
        stiffness: Number | None = None,
        damping: Number | None = None,
    ) -> None:
        """Add a coupling, which makes a joint follow another, exactly or by a spring between their coordinates.

        The joint is at multiplier·q(follows) + offset. At the start a joint that follows exactly takes the position and
        velocity that follow; ``sim.world.couplings`` has the effort of an exact coupling. With a stiffness it follows by a
        spring and a damper. A coupling ends when one of the joints breaks, becomes free or is changed.

        Args:
            joint: Full name of the joint that follows; it has one DoF.
            follows: Full name of the joint that leads; it has one DoF. Without it the joint is held at ``offset``.
            multiplier: The joint is at multiplier·q + offset, where q is its leader's coordinate.
            offset: Offset (rad or m).
            polynomial: a0 … a4: the joint is at a0 + a1·q + a2·q² + a3·q³ + a4·q⁴, in SI units; instead of multiplier and
                offset.
            stiffness: Stiffness of a spring by which the joint follows; without it, it follows exactly (N m/rad or N/m of the
                joint).
            damping: Damping of the spring (N m s/rad or N s/m of the joint).

        Raises:
            Error: A value is impossible or a name unknown or used twice; the model is unchanged.
        """
        self._add_element("coupling", "", given(joint=joint, follows=follows, multiplier=multiplier, offset=offset, polynomial=polynomial, stiffness=stiffness, damping=damping))
