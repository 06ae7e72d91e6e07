"""Exceptions of the package."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from momentree.run import Run

_PLACE = re.compile(r"^(?P<file>.*?)(?::(?P<line>\d+))(?::(?P<column>\d+))?$")


@dataclass(frozen=True)
class Diagnostic:
    """One problem of an input."""

    severity: str
    """``"error"``, ``"warning"`` or ``"note"``."""
    file: str
    """The input file, or an empty string."""
    line: int
    """Line in the file, from 1; 0 if the problem has no place."""
    column: int
    """Column in the line, from 1; 0 if the problem has no place."""
    problem: str
    """What is wrong."""
    hint: str
    """How to mend it; may be empty."""


class Error(ValueError):
    """A mistake in what the library was given: what is wrong, where, and how to mend it.

    ``str(error)`` is the text that the ``momentree`` command prints.
    """

    def __init__(
        self,
        problem: str,
        where: str = "",
        hint: str = "",
        text: str | None = None,
        diagnostics: list[Diagnostic] | None = None,
    ) -> None:
        self.problem: str = problem
        """What is wrong."""
        self.where: str = where
        """``file:line:column``, the name of a body or joint, the call, or an empty string."""
        self.hint: str = hint
        """How to mend it; may be empty."""
        self.diagnostics: list[Diagnostic] = list(diagnostics or [])
        """All problems of an input file, warnings included."""
        if text is None:
            text = (f"{where}: " if where else "") + problem + (f"; {hint}" if hint else "")
        self._text = text
        super().__init__(text)

    def _place(self) -> tuple[str | None, int | None, int | None]:
        match = _PLACE.match(self.where)
        if not match:
            return (self.where or None), None, None
        column = match["column"]
        return match["file"], int(match["line"]), int(column) if column else None

    @property
    def file(self) -> str | None:
        """The input file, or ``None``."""
        return self._place()[0]

    @property
    def line(self) -> int | None:
        """Line in the file, from 1, or ``None``."""
        return self._place()[1]

    @property
    def column(self) -> int | None:
        """Column in the line, from 1, or ``None``."""
        return self._place()[2]

    def __reduce__(self) -> tuple[type[Error], tuple[object, ...]]:
        return type(self), (self.problem, self.where, self.hint, self._text, self.diagnostics)


class RunError(Error):
    """A run that ended early: it diverged, stalled, or an action was refused.

    What was computed is kept: the simulation is in its last good state, and ``run`` holds the rows so far.
    """

    run: Run | None = None
    """What the run recorded before it ended; None if it was a single step."""

    def __reduce__(self) -> tuple[Any, ...]:
        return (*super().__reduce__(), {"run": self.run})
