// The scenario's text: line numbers, and problems at their lines.
import type { Diagnostic } from "../../../wasm/host.mjs";
import { h } from "../panels/dom";

/** Delay after the last keystroke before the text is checked (ms). */
const pause = 350;

export class Editor {
  readonly element = h("section", { class: "editor", "aria-label": "Scenario" });
  private readonly area = h("textarea", { spellcheck: "false", wrap: "off", "aria-label": "Scenario (TOML)" });
  private readonly numbers = h("div", { class: "numbers", "aria-hidden": "true" });
  private readonly problems = h("ul", { class: "problems", "aria-live": "polite", "aria-label": "Problems" });
  private wrong = new Map<number, string>();

  private timer = 0;

  /** `run`: runs the text. `check`: called after a pause in typing; the problems found are passed to mark(). */
  constructor(
    private readonly run: (text: string) => void,
    check: (text: string) => void,
  ) {
    const start = h("button", { type: "button", title: "Ctrl+Enter", onclick: () => this.run(this.text) }, "Run this");
    const field = h("div", { class: "field" }, this.numbers, this.area);
    this.element.append(field, this.problems, h("div", { class: "buttons" }, start));
    this.area.addEventListener("input", () => {
      this.count();
      clearTimeout(this.timer);
      this.timer = window.setTimeout(() => check(this.text), pause);
    });
    this.area.addEventListener("scroll", () => (this.numbers.scrollTop = this.area.scrollTop));
    this.area.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" || !(event.ctrlKey || event.metaKey)) return;
      event.preventDefault();
      this.run(this.text);
    });
  }

  get text() {
    return this.area.value;
  }
  set text(text: string) {
    clearTimeout(this.timer);
    this.area.value = text;
    this.mark([]);
  }

  /** Shows problems and scrolls to the first error. */
  show(diagnostics: readonly Diagnostic[]) {
    clearTimeout(this.timer);
    this.mark(diagnostics);
    const first = diagnostics.find((d) => d.severity === "error");
    if (first) this.reveal(first.line);
  }

  /** Shows problems without moving the cursor or the view. */
  mark(diagnostics: readonly Diagnostic[]) {
    this.wrong = new Map(diagnostics.map((d) => [d.line, d.severity]));
    const shown = diagnostics.filter((d) => d.severity !== "note");
    this.problems.replaceChildren(
      ...shown.map((d) => {
        const text = `${d.severity}: ${d.what}${d.hint ? `; ${d.hint}` : ""}`;
        const where = h("button", { type: "button", onclick: () => this.goTo(d) }, d.line > 0 ? `line ${d.line}` : "file");
        return h("li", { class: d.severity }, where, " ", text);
      }),
    );
    this.count();
  }

  private count() {
    const lines = this.area.value.split("\n").length;
    const rows: HTMLElement[] = [];
    for (let line = 1; line <= lines; line++) rows.push(h("div", { class: this.wrong.get(line) }, String(line)));
    this.numbers.replaceChildren(...rows);
    this.numbers.scrollTop = this.area.scrollTop;
  }

  private reveal(line: number) {
    const height = this.area.scrollHeight / Math.max(1, this.area.value.split("\n").length);
    this.area.scrollTop = Math.max(0, (line - 4) * height);
  }

  private goTo({ line, column }: Diagnostic) {
    const lines = this.area.value.split("\n");
    const start = lines.slice(0, line - 1).reduce((sum, text) => sum + text.length + 1, 0);
    this.area.focus();
    this.area.setSelectionRange(start + Math.max(0, column - 1), start + (lines[line - 1]?.length ?? 0));
    this.reveal(line);
    this.area.scrollIntoView({ block: "nearest" });
  }
}
