"""What a run computed: columns, plots, reports and files."""

from __future__ import annotations

import csv
import io
import json
import os
import tempfile
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from momentree._attributes import assign_once
from momentree._core import Snapshot, _Record
from momentree._errors import Error
from momentree._records import Array, Event, Wrench
from momentree._world import Columns

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from momentree.simulation import Simulation


# What the columns of a plot are, by the last part of their names.
_MEANINGS = {
    **dict.fromkeys(("energy", "kinetic", "gravity", "elastic", "dissipated", "lost", "released", "work", "error"), "energy (J)"),
    **dict.fromkeys(("reaction", "force"), "force (N)"),
    "torque": "torque (N m)",
    "position": "position (m)",
    "linear": "velocity (m/s)",
    "angular": "angular velocity (rad/s)",
    "tension": "tension (N)",
    "length": "length (m)",
    "rate": "rate (m/s)",
}


class JointRows:
    """The columns of one joint, row by row of ``run.time``.

    Rows are NaN where the joint did not exist; columns are NaN where it had fewer coordinates.
    """

    if not TYPE_CHECKING:  # a type checker would take any assignment for allowed
        __setattr__ = assign_once

    def __init__(self, name: str, columns: Mapping[str, Array]) -> None:
        self.name: str = name
        """Name of the joint."""
        self._columns = columns

    @property
    def q(self) -> Array:
        """Coordinates (rad, m, quaternions w, x, y, z continuous in sign), shape (rows, nq)."""
        return self._columns["q"]

    @property
    def v(self) -> Array:
        """Velocities (rad/s, m/s), shape (rows, nv)."""
        return self._columns["v"]

    @property
    def p(self) -> Array:
        """Canonical momenta (N m s, N s), shape (rows, nv)."""
        return self._columns["p"]

    def _with_reactions(self, key: str) -> Array:
        if key not in self._columns:
            raise Error(f"the run has no {'accelerations' if key == 'a' else 'reactions'}", hint="run it with reactions=True")
        return self._columns[key]

    @property
    def a(self) -> Array:
        """Time derivatives of v (rad/s², m/s²), shape (rows, nv); of a run with ``reactions=True``."""
        return self._with_reactions("a")

    @property
    def reaction(self) -> Wrench:
        """Wrench of the parent on the child, equation (32) of the paper; of a run with ``reactions=True``.

        Force (N) and torque (N m) about the origin of the joint's frame on the child, in the child's axes, each of shape (rows, 3).
        """
        wrench = self._with_reactions("wrench")
        return Wrench(wrench[:, :3], wrench[:, 3:])

    def __repr__(self) -> str:
        return f"<momentree.JointRows '{self.name}', {len(self.q)} rows>"


class BodyRows:
    """The motion of one body's frame, world axes, row by row of ``run.time``. Rows are NaN where the body was not in the world."""

    if not TYPE_CHECKING:  # a type checker would take any assignment for allowed
        __setattr__ = assign_once

    def __init__(self, name: str, rows: Array) -> None:
        self.name: str = name
        """Name of the body."""
        self._rows = rows

    @property
    def position(self) -> Array:
        """Origin of the body's frame (m), shape (rows, 3)."""
        return self._rows[:, 0:3]

    @property
    def quaternion(self) -> Array:
        """Orientation of the body's frame, unit quaternion (w, x, y, z), continuous in sign, shape (rows, 4)."""
        return self._rows[:, 3:7]

    @property
    def linear(self) -> Array:
        """Velocity of the frame's origin (m/s), shape (rows, 3)."""
        return self._rows[:, 7:10]

    @property
    def angular(self) -> Array:
        """Angular velocity (rad/s), shape (rows, 3)."""
        return self._rows[:, 10:13]

    def __repr__(self) -> str:
        return f"<momentree.BodyRows '{self.name}', {len(self._rows)} rows>"


class SpringRows:
    """What a spring did in a run, row by row; NaN once it was broken."""

    if not TYPE_CHECKING:  # a type checker would take any assignment for allowed
        __setattr__ = assign_once

    def __init__(self, name: str, rows: Array) -> None:
        self.name: str = name
        """Name of the spring."""
        self._rows = rows

    @property
    def length(self) -> Array:
        """Distance between its ends (m), shape (rows,)."""
        return self._rows[:, 0]

    @property
    def rate(self) -> Array:
        """Rate of the length (m/s), shape (rows,)."""
        return self._rows[:, 1]

    @property
    def tension(self) -> Array:
        """Force with which it pulls its ends together (N), shape (rows,); negative: it pushes."""
        return self._rows[:, 2]

    def __repr__(self) -> str:
        return f"<momentree.SpringRows '{self.name}', {len(self._rows)} rows>"


class Run:
    """A recorded run. Columns are computed when they are first asked for and kept.

    ``run["arm/elbow"].q`` are a joint's coordinates, ``run.bodies["arm/hand"].position`` a body's positions, row by row of
    ``run.time``.
    """

    if not TYPE_CHECKING:  # a type checker would take any assignment for allowed
        __setattr__ = assign_once

    def __init__(self, record: _Record, simulation: Simulation) -> None:
        self._record: _Record | None = record
        self._simulation: Simulation | None = simulation
        self._functions = list(simulation._functions)  # that states of rows refer to
        self.status: str = record.status
        """``"done"``, or why the run ended early."""
        self.time: Array = record.time
        """Times of the rows (s), shape (rows,)."""
        self.events: list[Event] = record.events
        """The events of this run, in order."""
        self.summary: dict[str, Any] = json.loads(record.summary)
        """What ``summary.json`` of the command contains."""
        self.warnings: list[str] = self.summary["warnings"]
        """What to know before using the results: actions that did nothing, an energy balance that does not close, bodies that passed
        through each other within a step."""
        self.final_state: str = record.final_state
        """The state document (JSON) at the end."""
        self.has_reactions: bool = record.has_reactions
        """True if accelerations and reactions of joints were recorded."""
        self.joints: Mapping[str, JointRows] = Columns(record.joint_names, self._joint)
        """Columns of the joints that the run had, by name."""
        self.bodies: Mapping[str, BodyRows] = Columns(record.body_names, self._body)
        """Motions of the bodies, by name."""
        self.springs: Mapping[str, SpringRows] = Columns(record.spring_names, self._spring)
        """Lengths and tensions of the springs, by name."""
        self._energy: NDArray[np.void] | None = None
        self._contacts: NDArray[np.void] | None = None

    @property
    def contacts(self) -> NDArray[np.void]:
        """The points at which bodies touched, a structured array with a row for each of them and each of ``time``.

        ``run.contacts["force"]`` is the force on ``one`` (N), shape (rows, 3); ``normal`` points from ``other`` to ``one``. Also
        ``time``, ``one``, ``other``, ``point`` (m) and ``slip``, the speed along the surface (m/s); all in world axes.

        Raises:
            Error: The run was made without ``reactions=True``.
        """
        if not self.has_reactions:
            raise Error("contacts are recorded with reactions only", hint="sim.run(until, reactions=True)")
        if self._contacts is None:
            lines = csv.reader(io.StringIO(self._recorded().contacts))
            next(lines)  # the header
            vectors = [(name, float, 3) for name in ("point", "normal", "force")]
            layout = np.dtype([("time", float), ("one", object), ("other", object), *vectors, ("slip", float)])
            rows = [
                (float(time), one, other, *(tuple(map(float, numbers[i : i + 3])) for i in (0, 3, 6)), float(numbers[9]))
                for time, one, other, *numbers in lines
            ]
            self._contacts = np.array(rows, dtype=layout)
        return self._contacts

    def _recorded(self) -> _Record:
        if self._record is None:
            raise Error("a run that was pickled can't make files, reports or states", hint="make them before it is pickled")
        return self._record

    def _joint(self, name: str) -> JointRows:
        return JointRows(name, self._recorded().joint(name))

    def _body(self, name: str) -> BodyRows:
        return BodyRows(name, self._recorded().body(name))

    def _spring(self, name: str) -> SpringRows:
        return SpringRows(name, self._recorded().spring(name))

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, name: str) -> Any:
        """The columns of the joint of that name, or else of the body. Raises Error if there is neither.

        Type checkers do not know which: for them, ``joints[name]`` is a :class:`JointRows` and ``bodies[name]`` a :class:`BodyRows`.
        """
        if name not in self.joints and name in self.bodies:
            return self.bodies[name]
        return self.joints[name]

    def _ipython_key_completions_(self) -> list[str]:
        return list(dict.fromkeys([*self.joints, *self.bodies]))

    @property
    def energy(self) -> NDArray[np.void]:
        """The energy ledger, a structured array of shape (rows,): ``run.energy["kinetic"]``.

        Fields (J): ``kinetic``, ``gravity``, ``elastic``, ``dissipated``, ``lost``, ``released``, ``work``, ``error``; momenta
        ``linear.x`` … (N s) and ``angular.x`` … (N m s) of the world, about its origin.
        """
        if self._energy is None:
            record = self._recorded()
            numbers = record.energies()
            table = np.empty(len(numbers), dtype=[(name, np.float64) for name in record.energy_columns])
            for k, name in enumerate(record.energy_columns):
                table[name] = numbers[:, k]
            self._energy = table
        return self._energy

    @property
    def event_table(self) -> NDArray[np.void]:
        """The events as a structured array, shape (events,).

        Fields: ``time`` (s), ``name``, and energies (J): ``kinetic_before``, ``kinetic_after``, ``energy_before``, ``energy_after``,
        ``lost``, ``released``, ``work``.
        """
        fields = ("kinetic_before", "kinetic_after", "energy_before", "energy_after", "lost", "released", "work")
        dtype: list[Any] = [("time", np.float64), ("name", object), *((name, np.float64) for name in fields)]
        rows = [
            (
                e.time,
                e.name,
                e.before.kinetic,
                e.after.kinetic,
                e.before.energy,
                e.after.energy,
                e.lost,
                e.released,
                e.work,
            )
            for e in self.events
        ]
        return np.array(rows, dtype=dtype)

    def state(self, row: int) -> Snapshot:
        """The state of a row, from which :meth:`Simulation.restore` of the simulation that ran can begin again.

        Args:
            row: Number of the row; negative numbers count from the end.

        Raises:
            IndexError: There is no such row.
            Error: The run was pickled.
        """
        count = len(self.time)
        if not -count <= row < count:
            raise IndexError(f"row {row} of {count}")
        snapshot = self._recorded().state(row % count)
        snapshot._functions, snapshot._simulation = list(self._functions), cast("Simulation", self._simulation)
        return snapshot

    # Files

    def save(self, folder: str | os.PathLike[str], *, report: bool = False) -> str:
        """Write the files that ``momentree run`` writes.

        Args:
            folder: Made or replaced; that of an incomplete run gets the ending ``.partial``.
            report: Also write ``report.html``.

        Returns:
            The folder that was written.

        Raises:
            Error: The folder can't be written, or the run was pickled.

        Warns:
            UserWarning: A mesh of a body can't be read, and is not drawn.
        """
        return self._recorded().write(os.fspath(folder), report)

    def report(self, path: str | os.PathLike[str] = "report.html") -> str:
        """Write a self-contained page with the motion in 3D, plots, and a certificate of each event; returns its path."""
        text = self._report_text()
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return os.fspath(path)

    def export(self, path: str | os.PathLike[str]) -> str:
        """Write the run as one file for other programs.

        Args:
            path: Its ending says the format, as in ``run.glb`` for animated glTF 2.0; ``momentree view --help`` lists them.

        Returns:
            The path.

        Raises:
            Error: No format has the name's ending, the file can't be written, or the run was pickled.

        Warns:
            UserWarning: A mesh of a body can't be read, and is not drawn.
        """
        with tempfile.TemporaryDirectory() as folder:
            self._recorded().export(os.path.join(folder, "run"), os.fspath(path))
        return os.fspath(path)

    def _report_text(self) -> str:
        with tempfile.TemporaryDirectory() as folder:
            written = self._recorded().write(os.path.join(folder, "run"), True)
            with open(os.path.join(written, "report.html"), encoding="utf-8") as file:
                return file.read()

    def _repr_html_(self) -> str:
        """The report as a frame of a notebook."""
        import html

        page = html.escape(self._report_text(), quote=True)
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 640px; border: 0" title="momentree"></iframe>'

    # Tables and plots

    def _column(self, name: str) -> tuple[Array, list[str]]:
        """Numbers and labels of ``"energy"``, ``"kinetic"``, ``"arm/elbow.q"``, ``"arm/hand.position"``, ``"rope.tension"`` …"""
        if name == "energy":
            e = self.energy
            parts = {"kinetic": e["kinetic"], "potential": e["gravity"] + e["elastic"]}
            parts["total"] = parts["kinetic"] + parts["potential"]
            return np.stack(list(parts.values()), axis=1), list(parts)
        if self._record is not None and name in self._record.energy_columns or self._energy is not None and name in (
            self._energy.dtype.names or ()
        ):
            return self.energy[name][:, None], [name]
        owner, _, field = name.rpartition(".")
        field = {"reaction": "force"}.get(field, field)
        if owner in self.joints and field in ("q", "v", "p", "a"):
            values: Array = getattr(self.joints[owner], field)
        elif owner in self.joints and field in ("force", "torque"):
            values = getattr(self.joints[owner].reaction, field)
        elif owner in self.bodies and field in ("position", "quaternion", "linear", "angular"):
            values = getattr(self.bodies[owner], field)
        elif owner in self.springs and field in ("length", "rate", "tension"):
            return getattr(self.springs[owner], field)[:, None], [name]
        else:
            raise Error(
                f"the run has no column '{name}'",
                hint="for example 'energy', 'arm/elbow.q', 'arm/elbow.force', 'arm/hand.position', 'rope.tension'",
            )
        width = values.shape[1]
        letters = "wxyz" if width == 4 else "xyz" if field not in ("q", "v", "p", "a") else "0123456"
        return values, [name] if width == 1 else [f"{name}.{letters[k]}" for k in range(width)]

    def plot(self, *columns: str, ax: Axes | None = None, events: bool = True) -> Axes:
        """Plot columns over time with matplotlib.

        Args:
            columns: ``"energy"`` (default), ``"arm/elbow.q"``, ``"arm/hand.position"`` …
            ax: Axes to draw into; default: new ones.
            events: Mark the events.

        Returns:
            The axes.

        Raises:
            Error: There is no such column, or matplotlib is not installed.
        """
        try:
            import matplotlib.pyplot as plt
        except ImportError:
            raise Error("plots need matplotlib", hint="pip install matplotlib") from None
        if ax is None:
            _, ax = plt.subplots(layout="constrained")
        for column in columns or ("energy",):
            values, labels = self._column(column)
            for k, label in enumerate(labels):
                ax.plot(self.time, values[:, k], label=label)
        if events:
            for event in self.events[:50]:
                ax.axvline(event.time, color="0.6", linewidth=0.8, linestyle="--", zorder=0)
        ax.set_xlabel("time (s)")
        fields = {_MEANINGS.get(column.rpartition(".")[2], "") for column in columns or ("energy",)}
        if len(fields) == 1:
            ax.set_ylabel(fields.pop())
        ax.legend(fontsize="small")
        return ax

    def to_pandas(self, *columns: str) -> pd.DataFrame:
        """The rows as a DataFrame indexed by time.

        Args:
            columns: As for :meth:`plot`; default: q and v of every joint, and the energies.

        Returns:
            One row for each of ``run.time``; columns with several components are split: ``arm/hand.position.x``.

        Raises:
            Error: There is no such column, or pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError:
            raise Error("to_pandas needs pandas", hint="pip install pandas") from None
        wanted = list(columns)
        if not wanted:
            wanted = [f"{joint}.{field}" for joint in self.joints for field in ("q", "v")] + ["kinetic", "gravity", "elastic"]
        table: dict[str, Array] = {}
        for column in wanted:
            values, labels = self._column(column)
            table.update({label: values[:, k] for k, label in enumerate(labels)})
        return pd.DataFrame(table, index=pd.Index(self.time, name="time"))

    def __getstate__(self) -> dict[str, Any]:
        state = dict(self.__dict__)
        if self._record is not None:
            state["_energy"] = self.energy
            if self.has_reactions:
                state["_contacts"] = self.contacts
            state["joints"] = {name: self.joints[name] for name in self.joints}
            state["bodies"] = {name: self.bodies[name] for name in self.bodies}
            state["springs"] = {name: self.springs[name] for name in self.springs}
        state["_record"] = state["_simulation"] = None
        state["_functions"] = []
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    def __repr__(self) -> str:
        end = self.time[-1] if len(self) else 0.0
        return f"<momentree.Run: {len(self)} rows to t = {end:.9g} s, {len(self.events)} events, {self.status}>"
