// The clock of the picture: time, speed, playing or paused. It draws nothing; drawing code listens to it.

export type Listener = (time: number) => void;

export class Player {
  private listeners: Listener[] = [];
  private now = 0;
  private running = false;
  private pace = 1;

  /** `range`: returns first and last time (s); called each time, because a recording may grow. */
  constructor(private readonly range: () => readonly [number, number]) {
    this.now = range()[0];
  }

  get time() {
    return this.now;
  }
  get playing() {
    return this.running;
  }
  get speed() {
    return this.pace;
  }
  set speed(factor: number) {
    this.pace = factor;
    this.tell();
  }

  /** Calls back with the time immediately and whenever the time or the playing state changes. */
  listen(listener: Listener) {
    this.listeners.push(listener);
    listener(this.now);
  }

  seek(time: number) {
    const [first, last] = this.range();
    this.now = Math.min(Math.max(time, first), last);
    this.tell();
  }

  /** At the end, playing restarts from the beginning. */
  play() {
    const [first, last] = this.range();
    if (this.now >= last) this.now = first;
    this.running = true;
    this.tell();
  }

  pause() {
    this.running = false;
    this.tell();
  }

  toggle() {
    if (this.running) this.pause();
    else this.play();
  }

  /** `seconds` of wall-clock time have passed. Stops at the end. */
  advance(seconds: number) {
    if (!this.running) return;
    const last = this.range()[1];
    this.now += seconds * this.pace;
    if (this.now >= last) {
      this.now = last;
      this.running = false;
    }
    this.tell();
  }

  private tell() {
    for (const listener of this.listeners) listener(this.now);
  }
}
