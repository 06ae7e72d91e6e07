// "?": a dialog that explains the page, with the keys of its buttons.
import { h } from "./dom";

/** A key or a gesture, and its effect. */
export type HelpRow = readonly [keys: string, effect: string];

export interface HelpSection {
  readonly title: string;
  readonly rows: readonly HelpRow[];
}

/** The button that opens the help; the key "?" opens it, too. */
export function helpButton(about: string, sections: readonly HelpSection[]): HTMLButtonElement {
  const close = h(
    "button",
    { type: "button", class: "close", "aria-label": "Close the help", onclick: () => dialog.close() },
    "✕",
  );
  const dialog = h(
    "dialog",
    { class: "help", "aria-label": "Help" },
    h("div", { class: "help-head" }, h("h2", {}, "Help"), close),
    h("p", {}, about),
    ...sections.flatMap(({ title, rows }) => [
      h("h3", {}, title),
      h("dl", {}, ...rows.flatMap(([keys, effect]) => [h("dt", {}, h("kbd", {}, keys)), h("dd", {}, effect)])),
    ]),
  );
  // A click beside the dialog closes it.
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  document.body.append(dialog);
  const button = h(
    "button",
    { type: "button", class: "square", title: "Help (?)", "aria-label": "Help", "aria-haspopup": "dialog" },
    "?",
  );
  button.addEventListener("click", () => dialog.open || dialog.showModal());
  document.addEventListener("keydown", (event) => {
    if (event.key !== "?" || event.ctrlKey || event.metaKey || event.altKey) return;
    if ((event.target as HTMLElement).matches("textarea, input:not([type=range])")) return;
    event.preventDefault();
    if (dialog.open) dialog.close();
    else dialog.showModal();
  });
  return button;
}

/** The view, which all pages with a picture have. */
export const viewRows: readonly HelpRow[] = [
  ["drag the background", "rotate the view; with two fingers or the right button, move it"],
  ["wheel, pinch", "zoom"],
  ["← → ↑ ↓ + −", "the same with the keyboard, if the picture has the focus"],
];
