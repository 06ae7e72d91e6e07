// Points of the scatter plot by their positions (px).
import type { Points } from "./scatter_picture";

/** The row of the nearest point within that distance; -1 if there is none. */
export function nearestPoint(at: Points, x: number, y: number, within: number): number {
  let [best, least] = [-1, within * within];
  for (let row = 0; row < at.x.length; row++) {
    const distance = (at.x[row] - x) ** 2 + (at.y[row] - y) ** 2;
    if (distance < least) [best, least] = [row, distance];
  }
  return best;
}

/**
 * The row of the next drawn point after `row`, to the right (1) or to the left (-1); with `up`, above or below. From a row
 * that is not drawn: the first or the last point. -1 if there are none.
 */
export function nextPoint(at: Points, row: number, step: number, up: boolean): number {
  const along = (r: number) => (up ? -at.y[r] : at.x[r]);
  const drawn = Array.from(at.x.keys()).filter((r) => Number.isFinite(at.x[r] + at.y[r]));
  const rows = drawn.sort((a, b) => along(a) - along(b) || a - b);
  const place = rows.indexOf(row);
  if (rows.length === 0) return -1;
  if (place < 0) return rows[step > 0 ? 0 : rows.length - 1];
  return rows[Math.min(Math.max(place + step, 0), rows.length - 1)];
}
