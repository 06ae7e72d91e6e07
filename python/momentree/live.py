"""The live view: a page in the browser that shows a simulation while it runs."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from types import TracebackType

from momentree import _core
from momentree._arguments import called, number
from momentree._errors import Error

_FRAME = 1 / 60  # s


class LiveView:
    """A page that shows a simulation while the program runs it; ``Simulation.show`` makes one.

    The page can pause the run, slow it down, break, lock, weld and grab, and move the program's sliders. All of that happens in
    ``update`` and ``run``, between two steps. The page is served on this machine alone, until the view is closed.
    """

    def __init__(self, simulation: _core.SimulationBase, title: str, port: int, browser: bool, paused: bool, speed: float) -> None:
        self._view = _core._LiveView(simulation, title, port, browser, paused, speed)
        self._simulation = simulation
        self._changed: dict[str, Callable[[float], object]] = {}
        self._shown = -math.inf

    @property
    def address(self) -> str:
        """Address of the page. It ends with a random key, so that other users of this machine cannot read the page."""
        return self._view.address

    @property
    def warnings(self) -> list[str]:
        """Meshes that cannot be drawn."""
        return self._view.warnings

    @property
    def pages(self) -> int:
        """Number of times that the page has been opened."""
        return self._view.pages

    @property
    def stopped(self) -> bool:
        """Whether the reader has pressed Stop."""
        return self._view.stopped

    def slider(
        self,
        name: str,
        least: float,
        most: float,
        value: float | None = None,
        *,
        unit: str = "",
        changed: Callable[[float], object] | None = None,
    ) -> None:
        """Add a slider to the page; ``view[name]`` is its value.

        Args:
            name: Its name on the page.
            least: Its smallest value.
            most: Its largest value.
            value: Where it begins; default: ``least``.
            unit: Shown after the value.
            changed: Called by ``update`` and ``run`` with each new value; may change the simulation.

        Raises:
            Error: The name is taken, or the numbers are not in order.
        """
        low, high = number(least, "least"), number(most, "most")
        start = low if value is None else number(value, "value")
        if changed is not None:
            called(changed, "changed")
        self._view.slider(name, low, high, start, unit)
        if changed is not None:
            self._changed[name] = changed

    def __getitem__(self, slider: str) -> float:
        """Value of a slider."""
        return self._view.value(slider)

    def _exchange(self) -> None:
        self._shown = time.monotonic()
        for name, value in self._view.exchange():
            if name in self._changed:
                self._changed[name](value)

    def update(self) -> bool:
        """Show the present state, at most sixty times per second, and do what the reader asked for.

        Waits while the page is paused: ``while view.update(): sim.step()``.

        Returns:
            False once the reader has pressed Stop.
        """
        if self._view.playing and time.monotonic() - self._shown < _FRAME:
            return not self._view.stopped
        self._exchange()
        while not self._view.playing and not self._view.stopped:
            self._view.wait(0.1)
            self._exchange()
        return not self._view.stopped

    def run(self, until: float = math.inf) -> bool:
        """Run to ``until`` (s) at the page's speed, in real time unless the reader changes it; Ctrl-C ends it.

        Returns:
            False if the reader has pressed Stop.

        Raises:
            RunError: The run diverged, stalled, or an action was refused; the page says so, too.
        """
        end = number(until, "until")
        if math.isnan(end):
            raise Error("until: expected a time, found nan")
        while self._simulation.time < end:
            self._exchange()
            if self._view.stopped:
                return False
            if not self._view.playing:
                self._view.wait(0.1)
            elif not self._view.advance(end):
                self._view.wait(0.004)
        self._exchange()
        return not self._view.stopped

    def close(self) -> None:
        """Stop serving the page; an open page keeps what it has shown."""
        self._view.close()

    def __enter__(self) -> LiveView:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<momentree.LiveView {self.address}>"


def show(
    self: _core.SimulationBase,
    *,
    title: str = "",
    port: int = 0,
    browser: bool = True,
    paused: bool = False,
    speed: float = 1.0,
) -> LiveView:
    """Show this simulation in a page of the browser while the program runs it.

    ``sim.show().run()`` runs in real time until the reader presses Stop. In a loop of your own, call ``update``:
    ``view = sim.show()``, then ``while view.update(): sim.step()``. The address is printed, too.

    Args:
        title: Of the page; default: that of the scenario.
        port: Where to serve the page; 0: any free port.
        browser: Open it in the browser, where there is a screen.
        paused: Begin when the reader presses play.
        speed: Of ``LiveView.run``: simulated seconds per second.

    Raises:
        Error: The port is in use, or the speed is not positive.
    """
    view = LiveView(self, title, port, browser, paused, number(speed, "speed"))
    print(view.address, file=sys.stderr)
    return view
