// Meshes as momentree writes them for pages (docs/howto/use-the-results.md): positions of 16 bits in a box, indices of corners.
import { shorts } from "./report/tables";
import type { MeshPart, Shape, Vec3 } from "./recording";

export interface PackedPart {
  readonly colour?: string;
  /** The corners of the box (m, before the shape's scale). */
  readonly low: Vec3;
  readonly high: Vec3;
  /** Base64 of 16-bit numbers: x, y, z per point, from 0 at `low` to 65535 at `high`. */
  readonly points: string;
  /** Base64 of 16-bit numbers: three points per triangle. */
  readonly triangles: string;
}

/** By number; null for a mesh that could not be read. */
export type PackedMeshes = readonly ({ readonly parts: readonly PackedPart[] } | null)[];

/** The meshes of a page: shapes refer to them by number, or by the name of a file. */
export interface Meshes {
  readonly meshes: PackedMeshes;
  readonly files?: Readonly<Record<string, number>>;
}

/** Of a name in both, the mesh of `first`. */
export function joined(first: Meshes | undefined, second: Meshes): Meshes {
  if (!first) return second;
  const count = first.meshes.length;
  const files = Object.fromEntries(Object.entries(second.files ?? {}).map(([name, number]) => [name, number + count]));
  return { meshes: [...first.meshes, ...second.meshes], files: { ...files, ...first.files } };
}

function partOf({ colour, low, high, points, triangles }: PackedPart): MeshPart {
  const levels = shorts(points);
  const positions = new Float32Array(levels.length);
  for (let i = 0; i < levels.length; i++) positions[i] = low[i % 3] + ((high[i % 3] - low[i % 3]) * levels[i]) / 65535;
  return { ...(colour && { colour }), positions, triangles: shorts(triangles) };
}

/** The parts of shapes' meshes, each mesh unpacked once; nothing for other shapes, and for meshes that are not there. */
export function partsFrom(given: Meshes | undefined): (shape: Shape) => readonly MeshPart[] {
  const unpacked = new Map<number, readonly MeshPart[]>();
  return ({ kind, mesh, file }) => {
    const number = mesh ?? given?.files?.[file ?? ""];
    if (kind !== "mesh" || !given || number === undefined) return [];
    let parts = unpacked.get(number);
    if (!parts) unpacked.set(number, (parts = (given.meshes[number]?.parts ?? []).map(partOf)));
    return parts;
  };
}
