// Shown in place of the picture while there is no world: the reason, and a button to continue.
import { h } from "../panels/dom";

export class Placeholder {
  readonly element = h("div", { class: "placeholder", role: "alert" });

  constructor() {
    this.show("Loading", "Starting the engine …");
  }

  /** `action`: a button's label and effect. */
  show(title: string, text: string, action?: { label: string; run: () => void }) {
    this.element.replaceChildren(h("h2", {}, title), h("p", {}, text));
    if (action) this.element.append(h("button", { type: "button", onclick: action.run }, action.label));
  }
}
