"""Where the package coacd, if it is installed, has the library that splits meshes into convex parts."""

from __future__ import annotations

import os
from importlib.util import find_spec


def locate() -> None:
    """Tell the engine, unless the environment does."""
    package = find_spec("coacd")
    if package is not None and package.origin is not None:
        library = os.path.join(os.path.dirname(package.origin), "lib_coacd.so")
        if os.path.exists(library):
            os.environ.setdefault("MOMENTREE_COACD", library)
