"""Velocities after a change of the state of another engine, with the certificate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

import momentree as mt
from momentree.bridge.certificate import Certificate, FloatArray, Method, Totals, Wrench
from momentree.bridge.projection import Impact, Rows


class Engine(Protocol):
    """The state of another engine, evaluated."""

    @property
    def time(self) -> float:
        """s."""
        ...

    @property
    def v(self) -> FloatArray:
        """(nv,) a copy of the velocities before the change."""
        ...

    def held(self) -> Rows:
        """(m, nv) what active constraints hold."""
        ...

    def trees(self, bodies: Sequence[int], held: Rows) -> set[int]:
        """The mechanisms of these bodies, and those that active constraints connect with them."""
        ...

    def dofs(self, trees: set[int]) -> NDArray[np.intp]:
        """The DoFs of these mechanisms."""
        ...

    def mass(self, dofs: NDArray[np.intp]) -> FloatArray:
        """(n, n) the mass matrix, with armatures, of DoFs that are not coupled with others."""
        ...

    def totals(self, v: FloatArray) -> Totals:
        """Energy and momenta of the world at the velocities ``v`` (nv,)."""
        ...

    def momenta(self, v: FloatArray) -> float:
        """The sum of the magnitudes of the momenta of all bodies, to measure drift against."""
        ...

    def floats(self, bodies: Sequence[int]) -> bool:
        """Whether nothing joins these bodies to the world."""
        ...

    def unsuitable(self, request: Request) -> str:
        """Why momentree cannot make a change where no constraint is active; empty if it can."""
        ...

    def by_momentree(self, request: Request, trees: set[int]) -> FloatArray:
        """(nv,) velocities after the change."""
        ...


@dataclass(frozen=True)
class Request:
    """A change, as both methods need it."""

    action: str
    bodies: tuple[int, ...]
    """The bodies that it concerns; 0 is the world."""
    rows: Rows
    """(m, nv) what is at rest after the change."""
    point: FloatArray
    """Where the impulse of the certificate acts, world coordinates."""
    wrench: FloatArray
    """(6, m) from the impulses along the rows to (force, torque) about ``point``."""
    perform: Callable[[mt.Simulation], object]
    """The same change of the converted mechanisms."""
    joins: bool = True
    """Whether it joins mechanisms."""
    push: FloatArray | None = None
    """(nv,) generalised impulse from outside."""
    pushed: Wrench = field(default_factory=lambda: Wrench(np.zeros(3), np.zeros(3), np.zeros(3)))
    """The same as a wrench, about the world's origin."""


def solve(state: Engine, request: Request, method: Method, tolerance: float) -> tuple[FloatArray, Certificate]:
    """The velocities after the change, (nv,), and their certificate, whose errors are within ``tolerance``.

    Raises:
        mt.Error: if the method is not applicable, or if the errors are larger.
    """
    if method not in ("auto", "momentree", "projection"):
        raise mt.Error(f"unknown method '{method}'", request.action, "'auto', 'momentree' or 'projection'")
    held = state.held()
    trees = state.trees(request.bodies, held)
    dofs = state.dofs(trees)
    if len(dofs) == 0:
        raise mt.Error("neither body can move", request.action, "one of the bodies must have a joint between it and the world")
    acting = held.take(dofs)
    acting = Rows(*(part[np.any(acting.matrix != 0, axis=1)] for part in (acting.matrix, acting.scale)))
    impact = Impact(state.mass(dofs), request.rows.take(dofs), acting)
    reason = ""
    if method != "projection":
        reason = "an active constraint acts on these mechanisms" if len(acting.matrix) else state.unsuitable(request)
    if method == "momentree" and reason:
        raise mt.Error(f"momentree cannot make this change: {reason}", request.action, "use method='auto' or 'projection'")
    v = state.v
    projected = v.copy()
    push = None if request.push is None else request.push[dofs]
    projected[dofs] += impact.plastic(v[dofs]) if push is None else impact.pushed(push)
    agreement = None
    if method != "projection" and not reason:
        try:
            after = state.by_momentree(request, trees)
        except mt.Error as error:
            if method == "momentree":
                raise
            reason = f"momentree refuses the model: {error}"
        else:
            most = max(float(np.max(np.abs(v), initial=0.0)), float(np.max(np.abs(projected), initial=0.0)))
            agreement = float(np.max(np.abs(after - projected))) / most if most > 0 else 0.0
            certificate = _certify(state, request, impact, dofs, after, "momentree", "", agreement, tolerance)
            if certificate.ok or method == "momentree":
                return after, _checked(certificate)
            reason = f"the result of momentree is less exact: {_errors(certificate)}"
    certificate = _certify(state, request, impact, dofs, projected, "projection", reason, agreement, tolerance)
    return projected, _checked(certificate)


def unchanged(
    state: Engine, action: str, tolerance: float, after: Totals | None = None, residual: float = 0.0, released: float = 0.0
) -> Certificate:
    """The certificate of a change that leaves all velocities as they are; ``after`` … ``released`` if there is a new model."""
    before = state.totals(state.v)
    point = Wrench(np.zeros(3), np.zeros(3), np.zeros(3))
    after = after if after is not None else before
    energy, drift = _energy(before, after, released), _drift(state, before, after, point)
    return Certificate(
        action=action,
        method="none",
        reason="",
        time=state.time,
        before=before,
        after=after,
        lost=0.0,
        work=0.0,
        released=released,
        impulse=point,
        determined=True,
        residual=residual,
        balance=0.0,
        energy=energy,
        drift=drift,
        agreement=None,
        tolerance=tolerance,
    )


def _certify(
    state: Engine,
    request: Request,
    impact: Impact,
    dofs: NDArray[np.intp],
    after: FloatArray,
    method: Literal["momentree", "projection"],
    reason: str,
    agreement: float | None,
    tolerance: float,
) -> Certificate:
    v = state.v
    jump = impact.explain(v[dofs], (after - v)[dofs], None if request.push is None else request.push[dofs])
    wrench = request.wrench @ jump.impulse
    if request.push is not None:
        wrench = np.concatenate([request.pushed.force, request.pushed.torque - np.cross(request.point, request.pushed.force)])
    rate = np.abs(request.rows.matrix @ after)
    most = np.max(request.rows.scale, axis=1, initial=0.0) * float(np.max(np.abs(v) + np.abs(after), initial=0.0))
    residual = float(np.max(rate[most > 0] / most[most > 0], initial=0.0))
    first, last = state.totals(v), state.totals(after)
    if request.push is None:
        lost, work = state.totals(after - v).kinetic, float(jump.held @ after[dofs])
    else:
        lost, work = 0.0, float((jump.held + request.push[dofs]) @ (v + after)[dofs]) / 2
    free = not impact.holds and state.floats(request.bodies)
    drift = _drift(state, first, last, request.pushed) if free else 0.0
    return Certificate(
        request.action,
        method,
        reason,
        state.time,
        first,
        last,
        lost,
        work,
        0.0,
        Wrench(wrench[:3], wrench[3:], request.point),
        jump.determined,
        residual,
        jump.balance,
        _energy(first, last, lost - work),
        drift,
        agreement,
        tolerance,
    )


def _energy(before: Totals, after: Totals, gone: float) -> float:
    most = max(before.kinetic, after.kinetic, abs(gone))
    return (before.kinetic - gone - after.kinetic) / most if most > 0 else 0.0


def _drift(state: Engine, before: Totals, after: Totals, pushed: Wrench) -> float:
    change = np.linalg.norm(after.linear - before.linear - pushed.force)
    change += np.linalg.norm(after.angular - before.angular - pushed.torque)
    most = state.momenta(state.v) + float(np.linalg.norm(pushed.force) + np.linalg.norm(pushed.torque))
    return float(change) / most if most > 0 else 0.0


def _errors(certificate: Certificate) -> str:
    return ", ".join(f"{name} {error:.1e}" for name, error in certificate.errors.items() if not error <= certificate.tolerance)


def _checked(certificate: Certificate) -> Certificate:
    if not certificate.ok:
        raise mt.Error(
            f"the new velocities are not exact enough: {_errors(certificate)}, tolerance {certificate.tolerance:.1e}",
            certificate.action,
            "the masses differ too much for double precision: pass a larger tolerance",
        )
    return certificate
