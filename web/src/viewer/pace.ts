// Notices that pictures of a motion follow each other too slowly, as where a processor draws them.

/** Pictures that are farther apart than this (s) are not of the same motion. */
const longest = 0.35;
/** Mean interval above which drawing is slow (s), and the number of intervals that decide. */
const slow = 1 / 24;
const needed = 40;

export class Pace {
  private last = -Infinity;
  private count = 0;
  private sum = 0;

  /** A picture is drawn at this time (s); returns whether drawing was slow over the last pictures. */
  isSlow(now: number): boolean {
    const interval = now - this.last;
    this.last = now;
    if (!(interval < longest)) {
      this.count = this.sum = 0;
      return false;
    }
    this.count++;
    this.sum += interval;
    if (this.count < needed) return false;
    const mean = this.sum / this.count;
    this.count = this.sum = 0;
    return mean > slow;
  }
}
