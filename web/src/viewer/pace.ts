// Notices that the browser can't keep up with the pictures of a motion, as where a processor draws them.

/** The browser is slow if it takes longer than this for a picture (s), on average. */
const slow = 1 / 24;
/** One picture counts at most this much (s): the first is slow everywhere, and a page in the background draws none. */
const most = 0.25;
/** Time spent on pictures that decides (s). */
const needed = 5 / 3;

export class Pace {
  private count = 0;
  private sum = 0;

  /** `duration`: from the request of a picture to its drawing (s). Returns whether the last pictures were slow. */
  isSlow(duration: number): boolean {
    this.count++;
    this.sum += Math.min(duration, most);
    if (this.sum < needed) return false;
    const mean = this.sum / this.count;
    this.count = this.sum = 0;
    return mean > slow;
  }
}
