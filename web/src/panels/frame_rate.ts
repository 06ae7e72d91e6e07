// How often the picture is drawn, and how long that takes of the page's time.

/** Drawings are counted over this time (s). */
const span = 1;

export class FrameRate {
  private readonly ends: number[] = [];
  private readonly durations: number[] = [];

  /** A drawing that began and ended at these times (s). */
  add(began: number, ended: number) {
    this.ends.push(ended);
    this.durations.push(ended - began);
    while (this.ends[0] < ended - span) {
      this.ends.shift();
      this.durations.shift();
    }
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
