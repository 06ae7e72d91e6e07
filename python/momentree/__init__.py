"""Dynamics of mechanisms whose topology changes while they move.

Build a :class:`Model` or :func:`load` a scenario, URDF, SDF or MJCF file; make a :class:`Simulation` of it; schedule changes with
``at``, ``when``, ``after`` and ``every``, or ``apply`` them; ``run``. Units are SI and radians; vectors are (x, y, z) in world axes
unless said otherwise, quaternions (w, x, y, z).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from momentree._core import Body, Context, Joint, ModelBody, Snapshot, World, __version__
from momentree._errors import Diagnostic, Error, RunError
from momentree._records import ActionRecord, Energy, Event, Mechanism, MissedEvent, Momentum, Rates, Totals, Wrench
from momentree._views import StateView
from momentree._vocabulary import Action, Condition, JointSpec, Quantity, Reaction
from momentree.batch import Batch, Group
from momentree.events import *
from momentree.events import __all__ as _event_names
from momentree.joints import *
from momentree.joints import __all__ as _joint_names
from momentree.model import Model
from momentree.run import BodyRows, JointRows, Run
from momentree.simulation import Scheduled, Simulation, load, loads

if TYPE_CHECKING:
    from momentree import bridge as bridge

__all__ = [
    "Action",
    "ActionRecord",
    "Batch",
    "Body",
    "BodyRows",
    "Condition",
    "Context",
    "Diagnostic",
    "Energy",
    "Error",
    "Event",
    "Group",
    "Joint",
    "JointRows",
    "JointSpec",
    "Mechanism",
    "MissedEvent",
    "Model",
    "ModelBody",
    "Momentum",
    "Quantity",
    "Rates",
    "Reaction",
    "Run",
    "RunError",
    "Scheduled",
    "Simulation",
    "Snapshot",
    "StateView",
    "Totals",
    "World",
    "Wrench",
    "__version__",
    "load",
    "loads",
    *_event_names,
    *_joint_names,
]


def __getattr__(name: str) -> Any:
    if name in ("bridge", "envs"):  # imported when used: they need other packages
        import importlib

        return importlib.import_module(f"momentree.{name}")
    raise AttributeError(f"module 'momentree' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted([*globals(), "bridge", "envs"])
