// The clock of the picture: time, speed, playing or paused. It draws nothing; drawing code listens to it.

export type Listener = (time: number) => void;

export class Player {
  private listeners: Listener[] = [];
  private now = 0;
  private isPlaying = false;
  private factor = 1;

  /** `range`: returns first and last time (s); called each time, because a recording may grow. */
  constructor(private readonly range: () => readonly [number, number]) {
    this.now = range()[0];
  }

  get time() {
    return this.now;
  }
  get playing() {
    return this.isPlaying;
  }
  get speed() {
    return this.factor;
  }
  set speed(factor: number) {
    this.factor = factor;
    this.notify();
  }

  /** Calls back with the time immediately and whenever the time or the playing state changes. */
  listen(listener: Listener) {
    this.listeners.push(listener);
    listener(this.now);
  }

  seek(time: number) {
    const [first, last] = this.range();
    this.now = Math.min(Math.max(time, first), last);
    this.notify();
  }

  /** At the end, playing restarts from the beginning. */
  play() {
    const [first, last] = this.range();
    if (this.now >= last) this.now = first;
    this.isPlaying = true;
    this.notify();
  }

  pause() {
    this.isPlaying = false;
    this.notify();
  }

  toggle() {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  /** `seconds` of wall-clock time have passed. Stops at the end. */
  advance(seconds: number) {
    if (!this.isPlaying) return;
    const last = this.range()[1];
    this.now += seconds * this.factor;
    if (this.now >= last) {
      this.now = last;
      this.isPlaying = false;
    }
    this.notify();
  }

  private notify() {
    for (const listener of this.listeners) listener(this.now);
  }
}
