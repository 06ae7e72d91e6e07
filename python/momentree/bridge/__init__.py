"""Topology changes for simulations of other engines.

``momentree.bridge.mujoco`` and ``momentree.bridge.drake`` each need the package of that engine; they are imported when they are
used first. Their functions return certificates:

- :class:`Certificate`: how energy and momenta changed, the impulse, and how exactly the velocities solve the equations;
- :class:`Totals` and :class:`Wrench`, which are parts of it.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from momentree.bridge.certificate import Certificate, Totals, Wrench

__all__ = ["Certificate", "Totals", "Wrench"]


def __getattr__(name: str) -> ModuleType:
    if name in ("mujoco", "drake"):
        return import_module(f"momentree.bridge.{name}")
    raise AttributeError(f"module 'momentree.bridge' has no attribute '{name}'")
