// Keyboard shortcuts of buttons, anywhere in the page.
import type { Motion } from "../recording";
import { frameAt } from "../viewer/frames";
import type { Player } from "../viewer/player";
import { isCovered } from "./dom";
import type { EventList } from "./events";

/** `buttons`: those that letters press. Keys that the focused element needs are left to it. */
export function listenToKeys(
  run: Motion,
  player: Player,
  buttons: ReadonlyMap<string, HTMLButtonElement>,
  events: Pick<EventList, "step">,
) {
  const step = (forward: boolean) => {
    const frame = frameAt(run, player.time);
    player.pause();
    const between = player.time > run.time(frame);
    player.seek(run.time(Math.min(Math.max(forward ? frame + 1 : between ? frame : frame - 1, 0), run.frames - 1)));
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || isCovered()) return;
    const target = event.target as HTMLElement;
    if (target.matches("select, input:not([type=range]), textarea")) return;
    const onButton = target.matches("button, summary");
    const onRange = target.matches("input[type=range]");
    switch (event.key) {
      case " ":
        if (onButton) return;
        player.toggle();
        break;
      case "ArrowLeft":
      case "ArrowRight":
        if (event.shiftKey) events.step(event.key === "ArrowRight");
        else if (onRange && target.getAttribute("aria-label") !== "Time") return;
        else step(event.key === "ArrowRight");
        break;
      case "Home":
      case "End":
        player.pause();
        player.seek(event.key === "Home" ? -Infinity : Infinity);
        break;
      default: {
        const button = buttons.get(event.key.toLowerCase());
        if (!button) return;
        button.click();
      }
    }
    event.preventDefault();
  });
}
