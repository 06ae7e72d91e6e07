// The picked world: its values, the command that runs it again, and its animation.
import { h } from "../panels/dom";
import { command } from "./copy";
import type { Column, Role } from "./document";
import type { Explorer } from "./explorer";
import { breakable, replayOf, valueText } from "./words";

interface About {
  readonly tags: readonly string[];
  readonly replay: string;
  readonly animation: string | null;
  readonly failure: string | null;
}

/** What the document says about a world beside its values. */
function aboutWorld({ sweep }: Explorer, world: number): About {
  const among = sweep.worst.flatMap(({ measure, end, worlds }) =>
    worlds.flatMap((each, rank) => (each.world === world ? [{ ...each, measure, end, rank }] : [])),
  );
  const failure = sweep.failures.find((each) => each.world === world);
  return {
    tags: among.map(({ measure, end, rank }) => `${measure}: ${rank === 0 ? end : `${end}, number ${rank + 1}`}`),
    replay: among[0]?.replay || failure?.replay || replayOf(sweep.file, world),
    animation: among.find(({ animation }) => animation !== null)?.animation ?? null,
    failure: failure ? failure.why : null,
  };
}

function valuesOf(columns: readonly Column[], row: number, role: Role, title: string): HTMLElement | null {
  const some = columns.filter((column) => column.role === role);
  if (some.length === 0) return null;
  const line = (column: Column) =>
    h("div", {}, h("dt", {}, breakable(column.name)), h("dd", {}, valueText(column, column.values[row])));
  return h("div", {}, h("h3", {}, title), h("dl", { class: "world-values" }, ...some.map(line)));
}

export class WorldPanel {
  readonly element = h("aside", { class: "world", "aria-label": "Picked world" });
  private readonly spoken = h("p", { class: "hidden-text", "aria-live": "polite" });
  private readonly content = h("div", { class: "content" });

  constructor(private readonly explorer: Explorer) {
    this.element.append(this.spoken, this.content);
    explorer.listen((change) => change === "picked" && this.show());
    this.show();
  }

  private show() {
    const { explorer } = this;
    const { picked } = explorer;
    this.element.classList.toggle("empty", picked === null);
    if (picked === null) {
      this.spoken.textContent = "";
      this.content.replaceChildren(
        h("p", { class: "note" }, "Pick a world by a click on a point of the plot, a row of the table or a worst case."),
      );
      return;
    }
    const { tags, replay, animation, failure } = aboutWorld(explorer, picked);
    const row = explorer.rowOf(picked);
    const { columns } = explorer.sweep;
    const close = h(
      "button",
      { type: "button", class: "close", "aria-label": "Close", onclick: () => explorer.pick(null) },
      "×",
    );
    const parts: (HTMLElement | false | null)[] = [
      h("div", { class: "headline" }, h("h2", {}, `World ${picked}`), close),
      tags.length > 0 && h("ul", { class: "tags" }, ...tags.map((tag) => h("li", {}, tag))),
      failure !== null && h("p", { class: "failure" }, h("strong", {}, "Failed: "), failure || "no reason is given"),
      animation !== null && h("p", {}, h("a", { class: "animation", href: animation }, "▶ Animation")),
      replay !== "" && command(replay, `the command for world ${picked}`),
      ...(row < 0
        ? [h("p", { class: "note" }, "Its values are not in this page, which has only a sample of the worlds.")]
        : [valuesOf(columns, row, "measure", "Measured"), valuesOf(columns, row, "vary", "Varied")]),
    ];
    this.content.replaceChildren(...parts.filter((part): part is HTMLElement => Boolean(part)));
    this.spoken.textContent = [`World ${picked}`, ...tags].join(", ");
  }
}
