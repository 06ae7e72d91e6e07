// A short message below the header, which goes away by itself and moves nothing.
import { h } from "./dom";

/** How long it is shown (ms). */
const duration = 5000;

export class Toast {
  readonly element = h("output", { class: "toast", "aria-live": "polite" });
  private timer: ReturnType<typeof setTimeout> | undefined;

  show(text: string) {
    const below = document.querySelector("header")?.getBoundingClientRect().bottom ?? 0;
    this.element.style.top = `${Math.max(below, 0) + 6}px`;
    this.element.textContent = text;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => (this.element.textContent = ""), duration);
  }
}
