// Shown in place of the picture while there is no world: the reason, and a button to continue.
import { h } from "../panels/dom";

export class Blank {
  readonly element = h("div", { class: "instead", role: "alert" });

  constructor() {
    this.show("Loading", "Starting the engine …");
  }

  /** `way`: a button's label and action. */
  show(title: string, says: string, way?: { label: string; go: () => void }) {
    this.element.replaceChildren(h("h2", {}, title), h("p", {}, says));
    if (way) this.element.append(h("button", { type: "button", onclick: way.go }, way.label));
  }
}
