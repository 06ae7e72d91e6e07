// The triangles of a mesh with their normals: faces that meet at a small angle look round, the others keep their edge.
import * as THREE from "three";
import type { MeshPart, Vec3 } from "../recording";

/** Cosine of the angle up to which an edge looks round. */
const round = Math.cos((40 * Math.PI) / 180);

/**
 * Each triangle has its own corners: `position`, `normal` and `outward`, the mean normal at the point for outlines. A scale that
 * mirrors the mesh turns its triangles over.
 */
export function meshGeometry({ positions, triangles }: MeshPart, scale: Vec3): THREE.BufferGeometry {
  const corners = triangles.length;
  const position = new Float32Array(3 * corners);
  const mirrored = scale[0] * scale[1] * scale[2] < 0;
  const point = (c: number) => triangles[mirrored ? c - (c % 3) + (2 - (c % 3)) : c];
  for (let c = 0; c < corners; c++) for (let k = 0; k < 3; k++) position[3 * c + k] = positions[3 * point(c) + k] * scale[k];

  // By triangle: the normal, its length twice the area.
  const faces = new Float32Array(corners);
  const [a, b, n] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  for (let c = 0; c < corners; c += 3) {
    n.fromArray(position, 3 * c);
    a.fromArray(position, 3 * c + 3).sub(n);
    b.fromArray(position, 3 * c + 6).sub(n);
    n.crossVectors(a, b).toArray(faces, c);
  }
  // By point: the triangles at it.
  const starts = new Uint32Array(positions.length / 3 + 1);
  for (let c = 0; c < corners; c++) starts[triangles[c] + 1]++;
  for (let p = 1; p < starts.length; p++) starts[p] += starts[p - 1];
  const at = new Uint32Array(corners);
  const filled = starts.slice();
  for (let c = 0; c < corners; c++) at[filled[triangles[c]]++] = c - (c % 3);

  const normal = new Float32Array(3 * corners);
  const outward = new Float32Array(3 * corners);
  for (let c = 0; c < corners; c++) {
    const own = c - (c % 3);
    n.fromArray(faces, own);
    const length = n.length();
    a.set(0, 0, 0);
    b.set(0, 0, 0);
    for (let i = starts[point(c)]; i < starts[point(c) + 1]; i++) {
      const [x, y, z] = [faces[at[i]], faces[at[i] + 1], faces[at[i] + 2]];
      b.set(b.x + x, b.y + y, b.z + z);
      if (n.x * x + n.y * y + n.z * z >= round * length * Math.hypot(x, y, z)) a.set(a.x + x, a.y + y, a.z + z);
    }
    a.normalize().toArray(normal, 3 * c);
    b.normalize().toArray(outward, 3 * c);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(normal, 3));
  geometry.setAttribute("outward", new THREE.BufferAttribute(outward, 3));
  return geometry;
}
