// What a reader must know about a run. A phone held across has a line for it; the whole text is shown while that has the focus
// (across.css).
import { h } from "./dom";

export function statusLine(attributes: { class: string; role: string }, strong: string, text: string): HTMLElement {
  const line = h("p", attributes, h("strong", {}, strong), text);
  const low = window.matchMedia("(max-height: 500px) and (min-width: 560px)");
  const follow = () => (low.matches ? line.setAttribute("tabindex", "0") : line.removeAttribute("tabindex"));
  low.addEventListener("change", follow);
  follow();
  // A second tap, or Escape, folds it again.
  line.addEventListener("mousedown", (event) => {
    if (document.activeElement !== line) return;
    event.preventDefault();
    line.blur();
  });
  line.addEventListener("keydown", ({ key }) => key === "Escape" && line.blur());
  return line;
}
