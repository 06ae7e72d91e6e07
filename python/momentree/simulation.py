"""Simulations: worlds that move, and whose topology changes."""

from __future__ import annotations

import copyreg
import math
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Union

from numpy.typing import ArrayLike

from momentree import _core, live
from momentree._arguments import called, number
from momentree._attributes import assign
from momentree._core import Body, Context, Snapshot, World
from momentree._errors import Error, RunError
from momentree._records import Event
from momentree._vocabulary import (
    Action,
    BodyName,
    Condition,
    JointName,
    JointSpec,
    Number,
    Numbers,
    Onset,
    Pose,
    Quantity,
    Vector,
)
from momentree.model import Belt, Collision, Model, Parent, Shape, body_fields, checked
from momentree.run import Run

Trigger = Union[Condition, Onset, Callable[[World], float]]
"""What ``when`` accepts: a condition, or a function of the world that rises above 0."""
DriveFunction = Callable[[Context], ArrayLike]
"""A function that drives a joint: it returns the effort along each degree of freedom (N m, N)."""
ForceFunction = Callable[[Context], tuple[ArrayLike, ArrayLike]]
"""A function that acts on a body: it returns a force (N) and a torque (N m), world axes."""


class Scheduled:
    """An event that is scheduled, to be given actions: ``sim.at(1.8).then(momentree.break_joint("chain/41"))``.

    ``at``, ``when``, ``after`` and ``every`` of a :class:`Simulation` make one. Its methods return it, so that calls can be chained.
    """

    if not TYPE_CHECKING:  # a type checker would take any assignment for allowed
        __setattr__ = assign

    def __init__(self, simulation: Simulation, scheduled: Any) -> None:
        self._simulation = simulation
        self._scheduled = scheduled

    def then(self, *actions: Action) -> Scheduled:
        """Add actions, which happen at one instant as one impact.

        Raises:
            Error: A name is unknown or a value impossible, or the event has happened; nothing was added.
        """
        self._scheduled._then(self._simulation._checked(actions))
        return self

    def named(self, name: str) -> Scheduled:
        """Name the event, for ``after``, ``Event.name`` and reports; a joint that it makes then has that name, too."""
        self._scheduled._named(name)
        return self


class Simulation(_core.SimulationBase):
    """A running world with its state, event queue and energy ledger.

    A simulation may be used by one thread at a time; runs release the GIL. Exceptions that a callback raises end the run and
    propagate; the simulation is then at the last instant that it reached, and can go on.

    Args:
        model: What moves. Later changes of the model do not affect the simulation. Or the path of a file: see :func:`load`.
        method: ``"rk4"`` (default, unless a file says otherwise), ``"midpoint"``, ``"damped"`` and ``"stepping"`` (through contacts) have fixed steps; ``"dopri5"`` and ``"dop853"`` are adaptive.
        variables: Of the state, ``"momenta"`` or ``"velocities"``; default: velocities for adaptive methods, else momenta.
        step: s, by default 1 ms unless a file says otherwise; the first step of adaptive methods.
        rtol: Relative error per step of adaptive methods.
        atol: Absolute error per step of adaptive methods.
        max_step: Longest step of adaptive methods, and of the motion between impulses of ``"stepping"`` (s).
        event_tolerance: Accuracy of located instants (s).
        resolve: True: bodies that overlap at the start are pushed apart, with the least motion; an Error if that is impossible.
    """

    _source: tuple[Any, ...]
    _event_cache: list[Event]
    _functions: list[Callable[..., Any]]
    last_run: Run | None = None
    """The last run, complete or not: what a run computed before an exception ended it."""

    if not TYPE_CHECKING:
        __setattr__ = assign

    def __init__(
        self,
        model: Model | str | os.PathLike[str],
        *,
        method: str | None = None,
        variables: str | None = None,
        step: Number | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        max_step: Number | None = None,
        event_tolerance: Number | None = None,
        resolve: bool | None = None,
    ) -> None:
        options = {"method": method, "step": step, "rtol": rtol, "atol": atol, "max_step": max_step}
        options |= {"variables": variables, "event_tolerance": event_tolerance, "resolve": resolve}
        if isinstance(model, (str, os.PathLike)):
            from momentree.loading import source_of

            source = source_of(model, options)
            _core.SimulationBase.__init__(self, *source[1:])
            return self._begin(source)
        super().__init__(checked(model), options)
        self._begin(("model", model.copy(), options))

    def _begin(self, source: tuple[Any, ...]) -> None:
        self._source = source
        self._event_cache = []
        self._functions = []  # the engine borrows them
        self.last_run = None
        self.keep_history(100)

    # What it is made of

    @property
    def model(self) -> Model:
        """A copy of the model that it began with; changes of topology are not in it."""
        copy = Model.__new__(Model)
        _core.ModelBase.__init__(copy, self._model())
        return copy

    def __getitem__(self, name: str) -> Any:
        """The joint of that name, or else the body. Raises Error if there is neither.

        Bodies and joints often share a name: ``sim.world.bodies[name]`` is always the body. Type checkers do not know which it is:
        for them, ``sim.world.joints[name]`` is a :class:`Joint`.
        """
        world = self.world
        if world._has_joint(name) or not world._has_body(name):
            return world._joint(name)
        return world._body(name)

    def _ipython_key_completions_(self) -> list[str]:
        world = self.world
        return list(dict.fromkeys([*world._joint_names(), *world._body_names()]))

    # Events

    def _checked(self, actions: Sequence[Action]) -> list[tuple[str, Any]]:
        for action in actions:
            if not isinstance(action, Action):
                raise Error(
                    f"expected an action, found {type(action).__name__}", hint="for example momentree.break_joint('chain/41')"
                )
            for handle in action._handles:
                self._check_handle(handle)
        return [(action.key, action.scenario_value()) for action in actions]

    def at(self, time: Number) -> Scheduled:
        """Schedule actions at an instant.

        Args:
            time: s, or a string with a unit; not before the present.

        Raises:
            Error: The time is past or not finite.
        """
        return Scheduled(self, self._at(time))

    def when(self, condition: Trigger) -> Scheduled:
        """Schedule actions for when a condition is met.

        Args:
            condition: ``momentree.reaction("load").force > 40``, or ``momentree.slip("crate", "floor")``, which needs no threshold;
                or a function of the world, and the event happens when it rises above 0, with a located instant.

        Raises:
            Error: A name is unknown, or the condition can never be met.
        """
        if isinstance(condition, Onset):
            condition = condition.begins()
        if isinstance(condition, Quantity):
            raise Error("when: a quantity without a threshold", hint="compare it: momentree.reaction('load').force > 40")
        if not isinstance(condition, Condition):
            from momentree._vocabulary import measured

            condition = measured(condition) > 0
        for handle in condition.quantity._handles:
            self._check_handle(handle)
        if condition.quantity.key != "function":
            return Scheduled(self, self._when(condition.scenario_value()))
        options = condition._options
        hysteresis = options.get("hysteresis")
        self._functions.append(condition.quantity.value)
        scheduled = self._when_measured(
            condition.quantity.value,
            number(condition.threshold, "the threshold of a function"),
            condition.exceeds,
            bool(options.get("repeat", False)),
            -1.0 if hysteresis is None else number(hysteresis, "hysteresis"),
            number(options.get("for", 0.0), "lasting"),
            options.get("locate") != "per step",
        )
        return Scheduled(self, scheduled)

    def value(self, quantity: Quantity) -> float:
        """The present value of a quantity, as conditions see it, in its SI unit; NaN if there is none, as for a joint that broke.

        Args:
            quantity: ``momentree.height("crane/load")``, ``momentree.reaction("crane/hook").force`` …

        Raises:
            Error: A name is unknown, or closed loops leave the reaction open.
        """
        if not isinstance(quantity, Quantity):
            raise Error(f"expected a quantity, found {type(quantity).__name__}", hint="for example momentree.height('crane/load')")
        for handle in quantity._handles:
            self._check_handle(handle)
        if quantity.key == "function":
            return float(quantity.value(self.world))
        return self._value((quantity > 1.0).scenario_value())  # any threshold

    def after(self, event: str, delay: Number = 0.0) -> Scheduled:
        """Schedule actions ``delay`` seconds after the event with the name ``event``, each time that it happens."""
        return Scheduled(self, self._after(event, delay))

    def every(self, period: Number, start: Number = 0.0) -> Scheduled:
        """Schedule actions at ``start`` (s) and every ``period`` seconds from then on, without instants that are past."""
        return Scheduled(self, self._every(period, start))

    def apply(self, *actions: Action, name: str | None = None) -> Event:
        """Carry out actions now, as one event: all of them at one instant are one impact.

        Args:
            actions: :func:`break_joint`, :func:`lock` …
            name: Of the event.

        Returns:
            The event with its certificate.

        Raises:
            Error: One of them is impossible; nothing has happened.
        """
        return self._apply(self._checked(actions), name or "")

    @property
    def events(self) -> list[Event]:
        """The events that happened so far, in order, with their certificates; a copy of the list."""
        count = self._event_count
        if len(self._event_cache) > count:
            self._event_cache = []
        if len(self._event_cache) < count:
            self._event_cache += self._events(len(self._event_cache))
        return list(self._event_cache)

    # Functions

    def drive(self, joint: JointName, function: DriveFunction | None) -> None:
        """Drive a joint by a function from now on, in addition to its parameters and to ``effort``.

        It belongs to the joint: changes of topology, snapshots and branches keep it until the joint breaks or becomes another.

        Args:
            joint: Name or handle.
            function: Called at every stage of every step with the :class:`Context`, the only thing that it may read. Returns the
                effort along each degree of freedom (N m, N): a number, or shape (nv,). ``None`` removes it.

        Raises:
            Error: The name is unknown, or the handle is of another simulation.
        """
        if function is not None:
            self._functions.append(called(function, "drive"))
        self._drive(joint, function)

    def force(self, body: BodyName, function: ForceFunction | None) -> None:
        """Apply a wrench to a body by a function from now on, in addition to the model's forces.

        Args:
            body: Name or handle.
            function: Called at every stage of every step with the :class:`Context`. Returns force (N) and torque (N m) about the
                origin of the body's frame, in world axes, each of shape (3,). ``None`` removes it.

        Raises:
            Error: The name is unknown, or the handle is of another simulation.
        """
        if function is not None:
            self._functions.append(called(function, "force"))
        self._force(body, function)

    # History

    def snapshot(self) -> Snapshot:
        """The complete state at this instant: restoring it is exact to the last bit, across any number of changes."""
        snapshot = self._snapshot()
        snapshot._functions, snapshot._simulation = list(self._functions), self
        return snapshot

    def restore(self, snapshot: Snapshot) -> None:
        """Return to a snapshot of this simulation or of one that it shares a model with by :meth:`branch`.

        Events scheduled after the snapshot stay scheduled unless their time is past.

        Raises:
            Error: The snapshot is of a simulation of another model.
        """
        if not isinstance(snapshot, _core.Snapshot):
            raise Error(f"expected a snapshot, found {type(snapshot).__name__}", hint="snapshot = sim.snapshot()")
        self._functions += [each for each in snapshot._functions if not any(each is own for own in self._functions)]
        self._restore(snapshot)
        self._event_cache = []

    def undo(self, number: int = -1, again: bool = False) -> None:
        """Undo one of the last 100 events, or of those that :meth:`keep_history` kept: the world is exactly as it was just before.

        Args:
            number: Its place in :attr:`events`; negative numbers count from the last.
            again: Let it happen again when its condition is met; otherwise it stays in the past.

        Raises:
            Error: There is no such event, or no history.
        """
        super().undo(number, again)
        self._event_cache = []

    def restore_state(self, text: str, name: str = "state.json") -> None:
        """Begin from a state document of a simulation of the same model, such as the ``final.json`` of a run.

        Args:
            text: The document (JSON), as :meth:`state_json` returns it.
            name: Of the document, for messages.

        Raises:
            Error: The document has errors, or is of another model; nothing has changed.
        """
        super().restore_state(text, name)
        self._event_cache = []

    # Bodies

    def add(
        self,
        name: str,
        *,
        mass: Number | None = None,
        com: Vector | None = None,
        inertia: Numbers | None = None,
        density: Number | None = None,
        parent: Parent | Body = None,
        at: Pose | None = None,
        child_at: Pose | None = None,
        joint: JointSpec | None = None,
        q: Numbers | None = None,
        v: Numbers | None = None,
        joint_name: str | None = None,
        shape: Shape | None = None,
        collision: Collision | None = None,
        belt: Belt | None = None,
    ) -> Body:
        """Add a body to the running world. The velocities of other bodies do not change.

        The arguments are those of :meth:`Model.add`; ``parent`` may also be a handle of this simulation. With a ``collision`` it
        hits what it touches by the model's contact rules; what it overlaps is an Error or, with ``resolve``, pushed apart.

        Returns the body's handle.

        Raises:
            Error: A value is impossible, a name unknown or used twice, or contact not supported; the world is unchanged.
        """
        fields = body_fields(mass, com, inertia, density, at, child_at, joint, q, v, joint_name, shape, collision, belt)
        self._add(name, parent, fields)
        return self.world.bodies[name]

    # Running

    def run(
        self,
        until: Number | None = None,
        *,
        record_every: Number | None = None,
        reactions: bool = False,
        observe: Callable[[World], bool | None] | None = None,
        progress: bool = False,
        check: bool = True,
    ) -> Run:
        """Run to ``until`` and record what happens. Releases the GIL; Ctrl-C ends it and keeps what was computed.

        Args:
            until: s, or a string with a unit; not before the present; default: the end of the scenario.
            record_every: Time between recorded rows (s, or a string with a unit); 0: after every step; ``inf``: only start and end; default:
                as the scenario says.
            reactions: Also record the accelerations and reactions of joints.
            observe: Called with the world at each row; may schedule events, and end the run by returning ``False``.
            progress: Show a progress bar (with tqdm, if it is installed).
            check: Raise RunError for a run that failed; otherwise the returned run's ``status`` says why it ended.

        Returns:
            The recorded run, which is ``last_run`` as well.

        Raises:
            Error: The end is past.
            RunError: The run diverged, stalled, or an action was refused. Its ``run`` holds the rows so far.
            KeyboardInterrupt: Ctrl-C; like any exception of a callback it leaves the rows so far in ``last_run``.
        """
        end = self.until if until is None else _core._seconds(until, "until")
        if end < self.time and not math.isclose(end, self.time):
            of_scenario = ", the end of the scenario's run," if until is None else ""
            raise Error(
                f"until: {end:.9g} s{of_scenario} is past: the time is {self.time:.9g} s",
                hint="it is an instant, not a duration: add it to sim.time",
            )
        every = self._output_every if record_every is None else _core._seconds(record_every, "record_every")
        if every == math.inf:
            every = max(2 * end, 1e-9)  # no multiple of it is between start and end
        if observe is not None:
            called(observe, "observe")
        found: list[Run] = []
        ended: list[tuple[str, str]] = []

        def finished(record: Any, status: str, reason: str) -> None:
            found.append(Run(record, self))
            ended.append((status, reason))
            self.last_run = found[0]

        from momentree._progress import progress_bar

        with progress_bar(self.time, end, progress) as show:
            self._run(end, every, reactions, observe, show, finished)
        status, reason = ended[0]
        if check and status not in ("ok", "interrupted"):
            error = RunError(reason)
            error.run = found[0]
            raise error
        return found[0]

    show = live.show

    def branch(self) -> Simulation:
        """An independent simulation that goes on from here: world, event queue and energy ledger, without history.

        It may be used by another thread. Python functions are shared with this simulation.
        """
        copy = type(self).__new__(type(self))
        _core.SimulationBase.__init__(copy, self)
        copy._begin(self._source)
        copy._functions = list(self._functions)
        return copy

    __copy__ = branch

    def __deepcopy__(self, memo: object) -> Simulation:
        return self.branch()

    def __getstate__(self) -> dict[str, Any]:
        if self._has_functions:
            raise TypeError("a simulation with Python functions as drives, forces or conditions can't be pickled")
        return {"source": self._source, "hash": self._hash, "state": self._saved()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        kind, *arguments = state["source"]
        if kind == "model":
            super().__init__(*arguments)
        else:
            _core.SimulationBase.__init__(self, *arguments)
            if self._hash != state["hash"]:
                raise Error("the scenario has changed since the simulation was pickled", where=arguments[0], hint="load it again")
        self._begin(state["source"])
        self._go_on_from(state["state"])

    def __repr__(self) -> str:
        return f"<momentree.Simulation: {len(self.world.bodies)} bodies, t = {self.time:.9g} s>"


def _pickled(snapshot: Snapshot) -> tuple[Callable[[Simulation], Snapshot], tuple[Simulation]]:
    """A snapshot is pickled as a simulation in that state."""
    branch = snapshot._simulation.branch()
    branch.restore(snapshot)
    return Simulation.snapshot, (branch,)


copyreg.pickle(Snapshot, _pickled)
