"""The package of MuJoCo. It has no type information, so that everything of it is ``Any``."""

from __future__ import annotations

from importlib import import_module
from typing import Any

try:
    mujoco: Any = import_module("mujoco")
except ImportError as error:
    raise ImportError("momentree.bridge.mujoco needs MuJoCo: pip install mujoco") from error

MjModel = Any
MjData = Any
MjSpec = Any
