// The sliders of a program.
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
import type { App } from "../playground/app";

export function programSliders(app: App): HTMLElement {
  const rows = h("div", {});
  const element = h("fieldset", { hidden: true }, h("legend", {}, "Program"), rows);
  const shown = new Map<string, { input: HTMLInputElement; show: () => void }>();
  let layout = "";
  app.listen((changed) => {
    if (changed !== "sliders") return;
    const key = JSON.stringify(app.sliders.map(({ name, least, most, unit }) => [name, least, most, unit]));
    element.hidden = app.sliders.length === 0;
    if (key !== layout) {
      layout = key;
      shown.clear();
      rows.replaceChildren(
        ...app.sliders.map(({ name, least, most, value, unit }) => {
          const input = h("input", { type: "range", min: least, max: most, step: (most - least) / 1000, value });
          const text = h("output");
          const show = () => (text.textContent = `${digits(Number(input.value), 3)}${unit ? ` ${unit}` : ""}`);
          input.addEventListener("input", () => {
            show();
            app.send({ type: "slider", name, value: Number(input.value) });
          });
          show();
          shown.set(name, { input, show });
          return h("label", {}, name, input, text);
        }),
      );
    }
    // Another page may have moved them; not under the reader's hand.
    for (const { name, value } of app.sliders) {
      const slider = shown.get(name);
      if (!slider || slider.input === document.activeElement) continue;
      slider.input.value = String(value);
      slider.show();
    }
  });
  return element;
}
