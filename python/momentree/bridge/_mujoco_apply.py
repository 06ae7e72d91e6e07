"""Changes of a MuJoCo state: all of it, or nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import momentree as mt
from momentree.bridge import _mujoco_hold as holds_
from momentree.bridge._change import Request, solve, unchanged
from momentree.bridge._mujoco_hold import Hold, Stiffness
from momentree.bridge._mujoco_model import ConvertibleState
from momentree.bridge._mujoco_names import name_of
from momentree.bridge._mujoco_package import MjData, MjModel, MjSpec, mujoco
from momentree.bridge.certificate import Certificate, Method


@dataclass(frozen=True)
class Change:
    """A change that was made."""

    certificate: Certificate
    model: Any
    """The model to go on with: the given one, or a new one if the change was made with ``spec``."""
    data: Any
    """Its state."""
    spec: Any
    """The specification of a new model; otherwise what was given."""
    equalities: tuple[str, ...]
    """The equality constraints that the change activated or deactivated (names, or numbers as text)."""
    removed: tuple[str, ...] = ()
    """What left the model with a joint that broke: actuators, sensors, keys and so on that refer to it."""


def join(
    state: ConvertibleState,
    data: MjData,
    request: Request,
    holds: Sequence[Hold],
    equality: str | int | Sequence[str | int] | None,
    spec: MjSpec | None,
    stiffness: Stiffness,
    method: Method,
    tolerance: float,
) -> Change:
    """Makes a change that constraints hold from now on."""
    model = state.model
    holds_.check_stiffness(stiffness)
    holds_.check_enabled(model)
    if spec is not None and equality is not None:
        raise mt.Error("give the constraint or the specification, not both", request.action)
    found = holds_.find(model, data, holds, equality) if spec is None else []
    after, certificate = solve(state, request, method, tolerance)
    if spec is not None:
        edited, kept = holds_.recompiled(spec, model)
        for hold in holds:
            holds_.declare(edited, model, hold, holds_.free_name(edited, holds_.label_of(model, hold)), False)
        found = list(range(int(model.neq), int(model.neq) + len(holds)))
        model, data = holds_.compiled_with(edited, model, data, kept)
        spec = edited
    holds_.activate(model, data, state, holds, found, stiffness)
    data.qvel[:] = after
    mujoco.mj_forward(model, data)
    return Change(certificate, model, data, spec, tuple(name_of(model, "equality", i) for i in found))


def release(model: MjModel, data: MjData, found: Sequence[int], action: str, tolerance: float) -> Change:
    """Deactivates equality constraints."""
    if not found:
        raise mt.Error("no active equality constraint holds this", action)
    certificate = unchanged(ConvertibleState(model, data), action, tolerance)
    for i in found:
        data.eq_active[i] = 0
    mujoco.mj_forward(model, data)
    return Change(certificate, model, data, None, tuple(name_of(model, "equality", i) for i in found))
