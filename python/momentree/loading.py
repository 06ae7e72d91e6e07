"""Simulations from scenario and model files."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from typing import Any

from momentree import _core
from momentree._arguments import anywhere, overrides
from momentree.simulation import Simulation


def load(
    path: str | os.PathLike[str],
    *,
    set: Mapping[str, Any] | None = None,
    state: str | os.PathLike[str] | None = None,
) -> Simulation:
    """Load a scenario (TOML) or a model (URDF, SDF, MJCF) and make it ready to run, its events scheduled.

    Args:
        path: The file.
        set: Changes of the scenario by dotted keys: ``{"integrate.step": 1e-4, "mechanism.tug.pose.xyz": [0, 0, 1]}``.
        state: A state document to begin from, such as the ``final.json`` of another run.

    Returns:
        The simulation at its start. ``simulation.until`` is the end of the scenario's run, ``simulation.warnings`` what the reader
        warned of.

    Raises:
        Error: The file has errors: ``diagnostics`` lists all of them, with line and column.
    """
    simulation = Simulation.__new__(Simulation)
    arguments = (os.fspath(path), overrides(set), os.fspath(state) if state is not None else "", None)
    _core.SimulationBase.__init__(simulation, *arguments)
    simulation._begin(anywhere(("file", *arguments)))
    return simulation


def source_of(path: str | os.PathLike[str], options: Mapping[str, Any]) -> tuple[Any, ...]:
    """What a simulation of that file is made of, with the options of :class:`Simulation` that are given."""
    changed = {f"integrate.{key}": value for key, value in options.items() if value is not None}
    return anywhere(("file", os.fspath(path), overrides(changed), "", None))


_NAMES = {"robot": "model.urdf", "sdf": "model.sdf", "mujoco": "model.xml"}  # by the root element


def loads(text: str, name: str | None = None, *, set: Mapping[str, Any] | None = None) -> Simulation:
    """Load a scenario or model from its text.

    Args:
        text: The text of a file.
        name: For messages; its ending says what it is: ``"robot.urdf"``. Default: as the text begins, ``"scenario.toml"``,
            ``"model.urdf"`` … Files that the text names are located in the working folder.
        set: As for :func:`load`.

    Raises:
        Error: The text has errors: ``diagnostics`` lists all of them, with line and column.
    """
    if name is None:
        root = re.search(r"<(robot|sdf|mujoco)\b", text) if re.match(r"\s*<", text) else None
        name = _NAMES[root[1]] if root else "scenario.toml"
    simulation = Simulation.__new__(Simulation)
    arguments = (name, overrides(set), "", text)
    _core.SimulationBase.__init__(simulation, *arguments)
    simulation._begin(("file", *arguments))
    return simulation
