"""Pictures as arrays: discs and thick lines, with smooth edges."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Colour = tuple[int, int, int]


class Canvas:
    """A square picture of the plane, x to the right and y up.

    Args:
        size: Width and height in pixels.
        extent: The picture shows −extent … extent of both coordinates, m.
        background: Red, green, blue, 0 … 255.
    """

    def __init__(self, size: int, extent: float, background: Colour = (250, 250, 248)) -> None:
        self._metres = 2 * extent / size
        axis = (np.arange(size) + 0.5) * self._metres - extent
        self._x, self._y = axis[None, :], -axis[:, None]
        self._pixels = np.empty((size, size, 3), dtype=np.float32)
        self._pixels[:] = background

    def _cover(self, distance: NDArray[Any], colour: Colour, opacity: float) -> None:
        share = (np.clip(0.5 - distance / self._metres, 0, 1) * opacity)[:, :, None].astype(np.float32)
        self._pixels += share * (np.asarray(colour, dtype=np.float32) - self._pixels)

    def disc(self, centre: Any, radius: float, colour: Colour, opacity: float = 1.0) -> None:
        """A disc; centre in m, shape (2,)."""
        self._cover(np.hypot(self._x - centre[0], self._y - centre[1]) - radius, colour, opacity)

    def ring(self, centre: Any, radius: float, width: float, colour: Colour) -> None:
        """A circle's line."""
        self._cover(np.abs(np.hypot(self._x - centre[0], self._y - centre[1]) - radius) - width / 2, colour, 1.0)

    def line(self, start: Any, end: Any, width: float, colour: Colour) -> None:
        """A line with round ends; start and end in m, shape (2,)."""
        dx, dy = float(end[0] - start[0]), float(end[1] - start[1])
        x, y = self._x - start[0], self._y - start[1]
        along = np.clip((x * dx + y * dy) / max(dx * dx + dy * dy, 1e-12), 0, 1)
        self._cover(np.hypot(x - along * dx, y - along * dy) - width / 2, colour, 1.0)

    def arm(self, points: NDArray[Any], joints: list[Colour]) -> None:
        """An arm: its joints and tip, m, shape (joints + 1, 2), and the joints' colours."""
        for k, (start, end) in enumerate(zip(points[:-1], points[1:], strict=True)):
            self.line(start, end, 0.075 - 0.01 * k, (70, 84, 104))
        for point, colour in zip(points, joints, strict=False):
            self.disc(point, 0.045, (40, 48, 60))
            self.disc(point, 0.028, colour)

    def pixels(self) -> NDArray[np.uint8]:
        """Shape (size, size, 3)."""
        return np.rint(self._pixels).astype(np.uint8)
