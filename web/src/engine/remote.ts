// A program that shows its simulation in this page: its messages arrive as server-sent events, and requests take the page's.
import { messageFrom, type EnginePort, type FromWorker, type ToWorker } from "./messages";

const isFrame = (text: string) => text.startsWith('{"type": "frame"');

/** Messages of which only the last one matters while others wait to be sent. */
const replaces = (later: ToWorker, earlier: ToWorker) =>
  later.type === earlier.type &&
  (["pull", "gravity", "damping", "speed"].includes(later.type) ||
    (later.type === "slider" && earlier.type === "slider" && later.name === earlier.name));

export class RemoteEngine implements EnginePort {
  onmessage: ((event: MessageEvent<FromWorker>) => void) | null = null;
  /** Called when the connection is lost (true), and when it is there again. */
  onlost: (lost: boolean) => void = () => undefined;
  private readonly waiting: ToWorker[] = [];
  private sending = false;
  private lost = false;

  private readonly arrived: string[] = [];
  private scheduled = false;

  /** `address`: of this page. */
  constructor(private readonly address: string) {
    const source = new EventSource(`${address}/stream`);
    source.onmessage = ({ data }: MessageEvent<string>) => {
      if (this.lost) this.lose(false);
      this.receive(data);
    };
    source.onopen = () => this.lose(false);
    source.onerror = () => this.lose(true);
  }

  private lose(lost: boolean) {
    this.lost = lost;
    this.onlost(lost);
  }

  /** Messages are handed on once per drawing, and of frames that follow each other only the last: a slow page does not lag. */
  private receive(text: string) {
    const { arrived } = this;
    const last = arrived[arrived.length - 1];
    if (last !== undefined && isFrame(last) && isFrame(text)) arrived.pop();
    arrived.push(text);
    if (this.scheduled) return;
    this.scheduled = true;
    requestAnimationFrame(() => {
      this.scheduled = false;
      for (const each of arrived.splice(0))
        this.onmessage?.(new MessageEvent("message", { data: messageFrom(JSON.parse(each)) }));
    });
  }

  postMessage(message: ToWorker) {
    const last = this.waiting[this.waiting.length - 1];
    if (last && replaces(message, last)) this.waiting.pop();
    this.waiting.push(message);
    if (!this.sending) void this.send();
  }

  /** Sends one message after another, so that they arrive in order. */
  private async send() {
    this.sending = true;
    try {
      for (let message = this.waiting.shift(); message; message = this.waiting.shift())
        await fetch(`${this.address}/act`, { method: "POST", body: JSON.stringify(message) });
    } catch {
      this.waiting.length = 0;
      this.lose(true);
    } finally {
      this.sending = false;
    }
  }
}
