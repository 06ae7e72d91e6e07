// How often the picture is drawn, and how long that takes of the page's time.

/** Drawings are counted over this time (s), or over the last two if there are fewer in it. */
const span = 1;

/** Drawings further apart than this (s) do not belong together: the world stood still. */
const stillness = 10;

export class FrameRate {
  private readonly ends: number[] = [];
  private readonly durations: number[] = [];

  /** A drawing that began and ended at these times (s). */
  add(began: number, ended: number) {
    const before = this.ends.at(-1);
    if (before !== undefined && ended - before > stillness) this.forget(this.ends.length);
    this.ends.push(ended);
    this.durations.push(ended - began);
    const old = this.ends.findIndex((end) => end >= ended - span);
    this.forget(Math.min(old, this.ends.length - 2));
  }

  private forget(count: number) {
    if (count <= 0) return;
    this.ends.splice(0, count);
    this.durations.splice(0, count);
  }

  /** Drawings per second; NaN if there were fewer than two. */
  get rate(): number {
    const count = this.ends.length;
    return count < 2 ? NaN : (count - 1) / (this.ends[count - 1] - this.ends[0]);
  }

  /** Mean duration of a drawing (s). */
  get duration(): number {
    return this.durations.reduce((sum, each) => sum + each, 0) / this.durations.length;
  }
}
