// Sliders for the coordinates of a joint; three rotations represent a quaternion.
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
import { exponential, logarithm } from "./rotations";

/** The parts of a joint's coordinates: numbers with a unit, and quaternions, whose four components have none. */
function partsOf(units: readonly string[]) {
  const parts: { unit: string; at: number }[] = [];
  for (let at = 0; at < units.length; at += units[at] ? 1 : 4) parts.push({ unit: units[at], at });
  return parts;
}

/** The values of the sliders of coordinates with these units. */
export const valuesOf = (units: readonly string[], q: ArrayLike<number>): number[] =>
  partsOf(units).flatMap(({ unit, at }) => (unit ? q[at] : [...logarithm([q[at], q[at + 1], q[at + 2], q[at + 3]])]));

/** The coordinates with these units for values of the sliders. */
export function coordinatesOf(units: readonly string[], values: readonly number[]): number[] {
  let next = 0;
  const take = () => values[next++];
  return partsOf(units).flatMap(({ unit }) => (unit ? take() : [...exponential([take(), take(), take()])]));
}

/** Labels of the sliders; "q1" is the coordinate's name in results. */
export function labelsOf(units: readonly string[]): { label: string; unit: string }[] {
  const parts = partsOf(units);
  return parts.flatMap(({ unit, at }) => {
    if (!unit) return ["x", "y", "z"].map((axis) => ({ label: `rotation ${axis}`, unit: "rad" }));
    const label = unit === "rad" ? "angle" : "displacement";
    return { label: parts.length > 1 ? `${label} q${at}` : label, unit };
  });
}

interface PosedJoint {
  readonly name: string;
  readonly kind: string;
  /** Of the coordinates. */
  readonly units: readonly string[];
}

interface Sliders {
  readonly element: HTMLElement;
  /** Shows other coordinates. */
  set(q: ArrayLike<number>): void;
}

/** Sliders of one joint; `reach`: range of lengths (m). `changed` is called with the joint's coordinates. */
export function jointSliders(
  { name, kind, units }: PosedJoint,
  start: ArrayLike<number>,
  reach: number,
  changed: (q: number[]) => void,
): Sliders {
  const values = valuesOf(units, start);
  const rows = labelsOf(units).map(({ label, unit }, i) => {
    const output = h("output");
    const show = () => {
      output.textContent = unit === "rad" ? `${digits((values[i] * 180) / Math.PI)}°` : `${digits(values[i])} ${unit}`;
    };
    const limit = unit === "rad" ? Math.PI : reach;
    const slider = h("input", {
      type: "range",
      min: Math.min(-limit, values[i]),
      max: Math.max(limit, values[i]),
      step: "any",
      value: values[i],
      "aria-label": `${name}: ${label}`,
      oninput: () => {
        values[i] = Number(slider.value);
        show();
        changed(coordinatesOf(units, values));
      },
    });
    show();
    const refresh = () => {
      slider.value = String(values[i]);
      show();
    };
    return { element: h("label", {}, h("span", {}, label), slider, output), refresh };
  });
  const title = h("legend", {}, name, " ", h("span", { class: "kind" }, kind));
  return {
    element: h("fieldset", {}, title, ...rows.map(({ element }) => element)),
    set: (q) => {
      values.splice(0, values.length, ...valuesOf(units, q));
      for (const { refresh } of rows) refresh();
    },
  };
}
