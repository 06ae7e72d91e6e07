// The picture for the keyboard: arrow keys rotate it, plus and minus zoom.
import type { Stage } from "../viewer/stage";

const turns: Readonly<Record<string, readonly [sideways: number, upwards: number, nearer: number]>> = {
  ArrowLeft: [-0.1, 0, 1],
  ArrowRight: [0.1, 0, 1],
  ArrowUp: [0, 0.1, 1],
  ArrowDown: [0, -0.1, 1],
  "+": [0, 0, 1 / 1.15],
  "-": [0, 0, 1.15],
};

export function turnByKeys(stage: Stage) {
  const { canvas } = stage;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.addEventListener("keydown", (event) => {
    const turn = turns[event.key];
    if (!turn || event.shiftKey || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    stage.turn(...turn);
  });
}
