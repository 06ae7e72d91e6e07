// Colours joints by load: as a fraction of the load at which they break if that is known, otherwise of the largest
// force.
import { loadSize, type Frame } from "../engine/messages";
import { digits } from "../panels/numbers";
import type { Topology } from "../../../wasm/host.mjs";

const steps = ["#3b6fd4", "#2fa37c", "#c9a21a", "#e5761c", "#d92525"];

/** From zero (blue) to the maximum load (red). */
export function loadColour(share: number): string {
  const place = Math.min(Math.max(share, 0), 1) * (steps.length - 1);
  return steps[Math.min(Math.round(place), steps.length - 1)];
}

export interface LoadColours {
  readonly colours: ReadonlyMap<string, string>;
  /** As text: the joint that is nearest to breaking, or that carries the largest force. */
  readonly text: string;
}

export function loadColours(frame: Frame, topology: Topology): LoadColours {
  const rows = topology.joints
    .filter(({ kind }) => kind !== "free")
    .map((joint) => {
      const [share, force, determined] = frame.loads.subarray(loadSize * joint.row, loadSize * joint.row + 3);
      return { joint, share: share ?? NaN, force: force ?? NaN, determined: determined !== 0 };
    });
  const of = ({ joint, determined }: (typeof rows)[number]) =>
    determined ? joint.name : `${joint.name} (the loops leave it open: the least of those possible)`;
  const most = Math.max(...rows.map(({ force }) => (Number.isFinite(force) ? force : 0)), 1e-12);
  const known = rows.filter(({ share }) => Number.isFinite(share));
  const colours = new Map<string, string>();
  for (const { joint, share, force } of rows) {
    if (!Number.isFinite(known.length > 0 ? share : force)) continue;
    colours.set(joint.name, loadColour(known.length > 0 ? share : force / most));
  }
  const worst = [...(known.length > 0 ? known : rows.filter(({ force }) => Number.isFinite(force)))].sort((a, b) =>
    known.length > 0 ? b.share - a.share : b.force - a.force,
  )[0];
  if (!worst) return { colours, text: "" };
  const text =
    known.length > 0
      ? `Closest to breaking: ${of(worst)}, at ${(100 * worst.share).toFixed(0)} % of its strength`
      : `Largest joint force: ${digits(worst.force, 3)} N, at ${of(worst)}`;
  return { colours, text };
}

/** Forces of joints on their children, in the children's axes. */
export function forcesOf(frame: Frame, topology: Topology): (joint: { readonly name: string }) => readonly number[] | null {
  const rows = new Map(topology.joints.map(({ name, row }) => [name, row]));
  return ({ name }) => {
    const row = rows.get(name);
    return row === undefined ? null : Array.from(frame.loads.subarray(loadSize * row + 3, loadSize * (row + 1)));
  };
}
