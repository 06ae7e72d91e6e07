"""Types of arguments, for annotations: ``def arm(length: momentree.typing.Number) -> momentree.Model``.

Nothing else of the package needs this module. Names of bodies and joints may be handles wherever a name is expected.
"""

from __future__ import annotations

from momentree._records import Array
from momentree._vocabulary import BodyName, JointName, Number, Numbers, Pose, Signal, Signals, Undetermined, Vector
from momentree.batch import ContactMethod, Precision, Variables, Worlds
from momentree.model import Axes, Parent, Shape
from momentree.simulation import DriveFunction, ForceFunction, Trigger

__all__ = [
    "Array",
    "Axes",
    "BodyName",
    "ContactMethod",
    "DriveFunction",
    "ForceFunction",
    "JointName",
    "Number",
    "Numbers",
    "Parent",
    "Pose",
    "Precision",
    "Shape",
    "Signal",
    "Signals",
    "Trigger",
    "Undetermined",
    "Variables",
    "Vector",
    "Worlds",
]
