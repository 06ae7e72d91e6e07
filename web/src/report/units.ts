// The units of columns: by quantity, and for joints by kind and place (docs/scenario.md lists the coordinates of the kinds).
import type { JointKind, JointQuantity, WorldQuantity } from "../recording";

export const worldUnit = (quantity: WorldQuantity) => (quantity === "linear" ? "N s" : quantity === "angular" ? "N m s" : "J");

/** By place of q: an angle, a length, or a part of a quaternion. */
const coordinates: Record<JointKind, string> = {
  revolute: "a",
  prismatic: "l",
  helical: "a",
  cylindrical: "al",
  universal: "aa",
  ball: "uuuu",
  planar: "lla",
  free: "llluuuu",
  weld: "",
};
const freedoms: Record<JointKind, string> = {
  revolute: "a",
  prismatic: "l",
  helical: "a",
  cylindrical: "al",
  universal: "aa",
  ball: "aaa",
  planar: "lla",
  free: "lllaaa",
  weld: "",
};

const units: Record<"q" | "v" | "p", Record<string, string>> = {
  q: { a: "rad", l: "m", u: "" },
  v: { a: "rad/s", l: "m/s" },
  p: { a: "N m s", l: "N s" },
};

/** How many coordinates a joint of that kind has. */
export const coordinatesOf = (kind: JointKind) => coordinates[kind].length;

/** Empty where the kind is not known: a joint that an event makes of several kinds. */
export function jointUnit(kind: JointKind | undefined, quantity: JointQuantity, place: number): string {
  if (quantity === "force") return "N";
  if (quantity === "torque") return "N m";
  if (!kind) return "";
  return units[quantity][(quantity === "q" ? coordinates : freedoms)[kind][place]] ?? "";
}
