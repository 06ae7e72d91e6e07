// What the colours of points mean.
import { h } from "../../panels/dom";
import { digits } from "../../panels/numbers";
import type { Theme } from "../../viewer/colours";
import type { Column } from "../document";
import { pointColours, scaleColour } from "./point_colours";
import { titleOf } from "../words";

function swatch(kind: string, fill: string): HTMLElement {
  const one = h("span", { class: kind });
  one.style.background = fill;
  return one;
}

/** Items of a list. */
export function pointLegend(theme: Theme, colour: Column | null): HTMLElement[] {
  if (!colour) return [];
  if (colour.kind === "number") {
    const stops = Array.from({ length: 9 }, (_none, i) => scaleColour(theme, i / 8));
    const bar = swatch("gradient", `linear-gradient(to right, ${stops.join(", ")})`);
    return [h("li", {}, `${titleOf(colour)}: ${digits(colour.least)} `, bar, ` ${digits(colour.greatest)}`)];
  }
  const { palette } = pointColours(theme, colour, 0);
  const kinds = palette.length - 1;
  const labels = colour.labels.slice(0, kinds);
  return [
    h("li", {}, `${colour.name}:`),
    ...labels.map((label, i) => h("li", {}, swatch("swatch", palette[i]), label)),
    ...(colour.labels.length > kinds ? [h("li", {}, "others repeat these colours")] : []),
    ...(colour.missing > 0 ? [h("li", {}, swatch("swatch", palette[kinds]), "no value")] : []),
  ];
}
