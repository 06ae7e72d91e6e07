// Saves what the picture shows: as a PNG, or as a video of the motion (MP4, or WebM where the browser can't write MP4).
import type { Stage } from "../viewer/stage";
import { h } from "./dom";

/** In order of preference. */
const formats = [
  { type: "video/mp4;codecs=avc1.640028", extension: "mp4" },
  { type: "video/mp4", extension: "mp4" },
  { type: "video/webm;codecs=vp9", extension: "webm" },
  { type: "video/webm", extension: "webm" },
] as const;

/** Usable on every system. */
export const fileName = (title: string, extension: string) =>
  `${
    title
      .normalize("NFKD")
      .replace(/[^\w]+/g, "-")
      .replace(/^-+|-+$/g, "")
      .slice(0, 60)
      .toLowerCase() || "momentree"
  }.${extension}`;

function download(blob: Blob, name: string) {
  const address = URL.createObjectURL(blob);
  h("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/** What a page states about its picture. */
export interface Saved {
  readonly stage: () => Stage | null;
  readonly title: () => string;
  /** Begins the motion that a video shows. */
  readonly play: () => void;
  /** Whether the motion has ended: the video ends, too. */
  readonly ended: () => boolean;
  readonly report: (message: string) => void;
}

export class Save {
  readonly element: HTMLElement;
  private readonly picture = h("button", { type: "button", title: "Save the picture (P)" }, "Picture (PNG)");
  private readonly video = h(
    "button",
    { type: "button", title: "Record a video of the motion, until pressed again" },
    "Record video",
  );
  private recorder: MediaRecorder | null = null;

  constructor(private readonly saved: Saved) {
    this.picture.addEventListener("click", () => this.savePicture());
    this.video.addEventListener("click", () => (this.recorder ? this.stop() : this.record()));
    const menu = h("details", { class: "save" }, h("summary", { title: "Save a picture or a video" }, "Save"));
    menu.append(h("div", { class: "menu" }, this.picture, this.video));
    // It closes after a choice, by Escape and by a press elsewhere.
    this.picture.addEventListener("click", () => (menu.open = false));
    document.addEventListener("pointerdown", (event) => {
      if (!menu.contains(event.target as Node) && !this.recorder) menu.open = false;
    });
    menu.addEventListener("keydown", (event) => {
      if (event.key === "Escape") menu.open = false;
    });
    this.element = menu;
  }

  savePicture() {
    const stage = this.saved.stage();
    if (!stage) return;
    stage.drawNow(); // the browser clears the canvas after it has shown it
    stage.canvas.toBlob((blob) => {
      if (blob) download(blob, fileName(this.saved.title(), "png"));
      else this.saved.report("The browser can't save the picture.");
    }, "image/png");
  }

  private record() {
    const stage = this.saved.stage();
    const format =
      typeof MediaRecorder === "undefined" ? undefined : formats.find(({ type }) => MediaRecorder.isTypeSupported(type));
    if (!stage || !format || !stage.canvas.captureStream) {
      this.saved.report("This browser can't record videos.");
      return;
    }
    const stream = stage.canvas.captureStream(60);
    const recorder = new MediaRecorder(stream, { mimeType: format.type, videoBitsPerSecond: 12e6 });
    const parts: Blob[] = [];
    recorder.ondataavailable = ({ data }) => data.size > 0 && parts.push(data);
    recorder.onerror = () => this.saved.report("The browser stopped recording the video.");
    recorder.onstop = () => {
      for (const track of stream.getTracks()) track.stop();
      this.recorder = null;
      this.show();
      if (parts.length > 0)
        download(new Blob(parts, { type: format.type.split(";")[0] }), fileName(this.saved.title(), format.extension));
      else this.saved.report("The video is empty: nothing moved.");
    };
    recorder.start(1000);
    this.recorder = recorder;
    this.show();
    this.saved.play();
    const watch = () => {
      if (this.recorder !== recorder) return;
      if (this.saved.stage() !== stage || this.saved.ended()) this.stop();
      else requestAnimationFrame(watch);
    };
    setTimeout(watch, 300);
  }

  private stop() {
    if (this.recorder?.state !== "inactive") this.recorder?.stop();
  }

  private show() {
    this.video.textContent = this.recorder ? "Stop and save" : "Record video";
    this.video.setAttribute("aria-pressed", String(this.recorder !== null));
    this.element.classList.toggle("recording", this.recorder !== null);
  }
}
