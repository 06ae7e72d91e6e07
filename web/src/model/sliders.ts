// Sliders for the DoFs of a joint: rotations about three axes represent quaternions.
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
import type { Joint, JointKind, Vec3 } from "../recording";
import { exponential, logarithm } from "./rotations";

interface Freedom {
  readonly label: string;
  readonly unit: "rad" | "m";
}

const angle = (label: string): Freedom => ({ label, unit: "rad" });
const length = (label: string): Freedom => ({ label, unit: "m" });
const turns = [angle("turn x"), angle("turn y"), angle("turn z")];

const freedoms: Record<JointKind, readonly Freedom[]> = {
  revolute: [angle("angle")],
  prismatic: [length("displacement")],
  helical: [angle("angle")],
  cylindrical: [angle("angle"), length("displacement")],
  universal: [angle("about axis"), angle("about axis2")],
  ball: turns,
  planar: [length("x"), length("y"), angle("about z")],
  free: [length("x"), length("y"), length("z"), ...turns],
  weld: [],
};

/** Converts a joint's coordinates to the values of its sliders, and back. */
export function slidersOf(kind: JointKind, q: ArrayLike<number>): number[] {
  const values = Array.from(q);
  if (kind === "ball") return [...logarithm([values[0], values[1], values[2], values[3]])];
  if (kind === "free") return [...values.slice(0, 3), ...logarithm([values[3], values[4], values[5], values[6]])];
  return values;
}

export function coordinatesOf(kind: JointKind, values: readonly number[]): number[] {
  const turn = (from: number) => exponential([values[from], values[from + 1], values[from + 2]] as Vec3);
  if (kind === "ball") return [...turn(0)];
  if (kind === "free") return [...values.slice(0, 3), ...turn(3)];
  return [...values];
}

/** Sliders of one joint; `reach`: range of lengths (m). `changed` is called with the joint's coordinates. */
export function jointSliders(
  joint: Joint,
  start: ArrayLike<number>,
  reach: number,
  changed: (q: number[]) => void,
): HTMLElement {
  const values = slidersOf(joint.kind, start);
  const rows = freedoms[joint.kind].map((freedom, i) => {
    const shown = h("output", {}, "");
    const show = () => {
      shown.textContent = freedom.unit === "rad" ? `${digits((values[i] * 180) / Math.PI)}°` : `${digits(values[i])} m`;
    };
    const far = freedom.unit === "rad" ? Math.PI : reach;
    const slider = h("input", {
      type: "range",
      min: Math.min(-far, values[i]),
      max: Math.max(far, values[i]),
      step: "any",
      value: values[i],
      "aria-label": `${joint.name}: ${freedom.label}`,
      oninput: () => {
        values[i] = Number(slider.value);
        show();
        changed(coordinatesOf(joint.kind, values));
      },
    });
    show();
    return h("label", {}, h("span", {}, freedom.label), slider, shown);
  });
  return h("fieldset", {}, h("legend", {}, joint.name, " ", h("span", { class: "kind" }, joint.kind)), ...rows);
}
