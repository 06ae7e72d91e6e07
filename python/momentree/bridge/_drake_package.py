"""The package of Drake. Its type information does not describe arrays as NumPy does, so that everything of it is ``Any``."""

from __future__ import annotations

from importlib import import_module
from typing import Any

try:
    tree: Any = import_module("pydrake.multibody.tree")
    math: Any = import_module("pydrake.math")
except ImportError as error:
    raise ImportError("momentree.bridge.drake needs Drake: pip install drake") from error

MultibodyPlant = Any
Context = Any
