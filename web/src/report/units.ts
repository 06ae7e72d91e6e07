// Units of columns: by quantity, and for joints by kind and index (docs/scenario.md lists the coordinates of the
// kinds).
import type { JointKind, JointQuantity, WorldQuantity } from "../recording";

export const worldUnit = (quantity: WorldQuantity) => (quantity === "linear" ? "N s" : quantity === "angular" ? "N m s" : "J");

/** By index of q: an angle, a length, or a component of a quaternion. */
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

/** Number of coordinates of a joint of that kind. */
export const coordinatesOf = (kind: JointKind) => coordinates[kind].length;

/** Empty if the kind is not known: the joint is made by events in several kinds. */
export function jointUnit(kind: JointKind | undefined, quantity: JointQuantity, place: number): string {
  if (quantity === "force") return "N";
  if (quantity === "torque") return "N m";
  if (!kind) return "";
  return units[quantity][(quantity === "q" ? coordinates : freedoms)[kind][place]] ?? "";
}
