"""Progress of a run in the terminal or a notebook."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any

Show = Callable[[float], None]


def _bar(total: float) -> Any:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm(total=total, unit="s", bar_format="{l_bar}{bar}| {n:.3g}/{total:.3g} s [{elapsed}<{remaining}]")


@contextmanager
def progress_bar(start: float, end: float, wanted: bool) -> Generator[Show | None, None, None]:
    """A function to be called with the simulated time (s), or ``None`` if no display is wanted."""
    if not wanted:
        yield None
        return
    bar = _bar(end - start)
    if bar is None:

        def write(time: float) -> None:
            share = (time - start) / (end - start) if end > start else 1.0
            print(f"\r{100 * share:5.1f} %  t = {time:.3g} s", end="", file=sys.stderr, flush=True)

        yield write
        print(file=sys.stderr)
        return
    with bar:

        def update(time: float) -> None:
            bar.update(time - start - bar.n)

        yield update
        bar.update(end - start - bar.n)
