"""Dynamics of mechanisms whose topology changes while they move.

Build a :class:`Model` or :func:`load` a scenario, URDF, SDF or MJCF file; make a :class:`Simulation` of it; schedule changes with
``at``, ``when``, ``after`` and ``every``, or ``apply`` them; ``run``. Units are SI and radians; vectors are (x, y, z) in world axes
unless said otherwise, quaternions (w, x, y, z).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from momentree import _attributes, _coacd, _core, distributions, events, joints
from momentree._calls import explain_calls
from momentree._core import Body, Context, Joint, ModelBody, Snapshot, Spring, World, __version__
from momentree._errors import Diagnostic, Error, RunError
from momentree._records import (
    ActionRecord,
    Contact,
    Coupling,
    Energy,
    Event,
    EventContact,
    LoopStatus,
    Mechanism,
    MissedEvent,
    Momentum,
    Rates,
    Totals,
    Wrench,
)
from momentree._views import StateView
from momentree._vocabulary import Action, Condition, JointSpec, Onset, Quantity, Reaction
from momentree.analysis import (
    DampedMode,
    Equilibrium,
    KinematicSolution,
    Linearization,
    Mode,
    Target,
    equilibrium,
    inverse_kinematics,
    linearize,
)
from momentree.batch import Batch, BodyColumns, Group, JointColumns
from momentree.distributions import *
from momentree.events import *
from momentree.function_sweep import sweep
from momentree.joints import *
from momentree.live import LiveView
from momentree.loading import load, loads
from momentree.model import Model
from momentree.run import BodyRows, JointRows, Run, SpringRows
from momentree.simulation import Scheduled, Simulation
from momentree.sweeps import Share, Sweep, SweepResults, load_sweep

__all__: list[str] = [
    "Action",
    "ActionRecord",
    "Batch",
    "Body",
    "BodyColumns",
    "BodyRows",
    "Condition",
    "Contact",
    "Context",
    "Coupling",
    "DampedMode",
    "Diagnostic",
    "Energy",
    "Equilibrium",
    "Error",
    "Event",
    "EventContact",
    "Group",
    "Joint",
    "JointColumns",
    "JointRows",
    "JointSpec",
    "KinematicSolution",
    "Linearization",
    "LiveView",
    "LoopStatus",
    "Mechanism",
    "MissedEvent",
    "Mode",
    "Model",
    "ModelBody",
    "Momentum",
    "Onset",
    "Quantity",
    "Rates",
    "Reaction",
    "Run",
    "RunError",
    "Scheduled",
    "Share",
    "Simulation",
    "Snapshot",
    "Spring",
    "SpringRows",
    "StateView",
    "Sweep",
    "SweepResults",
    "Target",
    "Totals",
    "World",
    "Wrench",
    "__version__",
    "equilibrium",
    "inverse_kinematics",
    "linearize",
    "load",
    "load_sweep",
    "loads",
    "sweep",
]
__all__ += distributions.__all__
__all__ += events.__all__
__all__ += joints.__all__

_coacd.locate()
explain_calls(_core)
for _each in (Body, Context, Joint, ModelBody, Snapshot, Spring, World):
    setattr(_each, "__setattr__", _attributes.assign)

_LATER = ("bridge", "envs", "typing")  # imported when they are used first; the former two need other packages

if TYPE_CHECKING:
    from momentree import bridge as bridge
    from momentree import typing as typing
else:  # a type checker would take every name for an attribute of this module

    def __getattr__(name: str) -> Any:
        if name in _LATER:
            import importlib

            try:
                return importlib.import_module(f"momentree.{name}")
            except ImportError as error:  # so that hasattr, inspect and help go on without it
                raise AttributeError(f"module 'momentree' has no attribute '{name}' here: {error}") from error
        raise AttributeError(f"module 'momentree' has no attribute '{name}'")


def __dir__() -> list[str]:
    """The public names, those included that are imported later."""
    return sorted([*__all__, *_LATER])
