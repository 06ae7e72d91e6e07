// Panels of which one is visible; the arrow keys move from tab to tab.
import { h } from "./dom";

export function tabs(label: string, panels: readonly { readonly name: string; readonly content: HTMLElement }[]): HTMLElement {
  const buttons: HTMLButtonElement[] = [];
  const bodies: HTMLElement[] = [];
  const show = (chosen: number) => {
    buttons.forEach((button, i) => {
      button.setAttribute("aria-selected", String(i === chosen));
      button.tabIndex = i === chosen ? 0 : -1;
      bodies[i].hidden = i !== chosen;
    });
  };
  const onKey = (event: KeyboardEvent) => {
    const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (step === 0) return;
    event.preventDefault();
    event.stopPropagation();
    const next = (buttons.indexOf(event.target as HTMLButtonElement) + step + panels.length) % panels.length;
    show(next);
    buttons[next].focus();
  };
  panels.forEach(({ name, content }, i) => {
    const id = `panel-${name.toLowerCase().replace(/[^a-z]+/g, "-")}`;
    buttons.push(
      h(
        "button",
        { type: "button", role: "tab", "aria-controls": id, id: `${id}-tab`, onclick: () => show(i), onkeydown: onKey },
        name,
      ),
    );
    bodies.push(h("div", { class: "tabpanel", role: "tabpanel", id, "aria-labelledby": `${id}-tab` }, content));
  });
  show(0);
  return h(
    "section",
    { class: "details" },
    h("div", { class: "tabs", role: "tablist", "aria-label": label }, ...buttons),
    ...bodies,
  );
}
