"""Progress of a run or a sweep in the terminal or a notebook."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any

Show = Callable[[float], None]


def _bar(total: float, unit: str) -> Any:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    form = "{l_bar}{bar}| {n:.6g}/{total:.6g} " + unit + " [{elapsed}<{remaining}]"
    return tqdm(total=total, unit=unit, bar_format=form)


@contextmanager
def progress_bar(start: float, end: float, wanted: bool, unit: str = "s") -> Generator[Show | None, None, None]:
    """A function to be called with the simulated time (s), or the number of worlds, or ``None`` if no display is wanted."""
    if not wanted:
        yield None
        return
    bar = _bar(end - start, unit)
    if bar is None:

        def write(now: float) -> None:
            share = (now - start) / (end - start) if end > start else 1.0
            print(f"\r{100 * share:5.1f} %  {now:.6g} {unit}", end="", file=sys.stderr, flush=True)

        yield write
        print(file=sys.stderr)
        return
    with bar:

        def update(now: float) -> None:
            bar.update(now - start - bar.n)

        yield update
        bar.update(end - start - bar.n)
