import { describe, expect, it } from "vitest";
import { MeshBasicMaterial, Vector3 } from "three";
import { joined, partsFrom, type Meshes, type PackedPart } from "./meshes";
import type { MeshPart, Shape, Vec3 } from "./recording";
import { modelOf, type ModelFile } from "./result_files";
import { meshGeometry } from "./viewer/mesh_geometry";
import { meshesOf } from "./viewer/shapes";

const base64 = (numbers: readonly number[]) => Buffer.from(Uint16Array.from(numbers).buffer).toString("base64");
const at = { xyz: [0, 0, 0], quat: [1, 0, 0, 0] } as const;

describe("packed meshes", () => {
  const part: PackedPart = {
    colour: "#ff0000",
    low: [-1, 0, 2],
    high: [1, 4, 2],
    points: base64([0, 0, 0, 65535, 65535, 0, 13107, 0, 65535]),
    triangles: base64([0, 1, 2]),
  };
  const meshes = { meshes: [null, { parts: [part] }], files: { "a.stl": 1, "b.stl": 0 } };

  it("positions lie between the corners of the box", () => {
    const [unpacked] = partsFrom(meshes)({ kind: "mesh", mesh: 1, at });
    expect(unpacked.colour).toBe("#ff0000");
    const expected = [-1, 0, 2, 1, 4, 2, -0.6, 0, 2];
    expected.forEach((x, i) => expect(unpacked.positions[i]).toBeCloseTo(x, 6));
    expect([...unpacked.triangles]).toEqual([0, 1, 2]);
  });

  it("shapes refer to them by number or by file; those that are not there have no parts", () => {
    const partsOf = partsFrom(meshes);
    const parts = (shape: Omit<Shape, "at">) => partsOf({ ...shape, at }).length;
    expect(parts({ kind: "mesh", file: "a.stl" })).toBe(1);
    expect(partsOf({ kind: "mesh", file: "a.stl", at })).toBe(partsOf({ kind: "mesh", mesh: 1, at })); // unpacked once
    expect(parts({ kind: "mesh", file: "b.stl" })).toBe(0);
    expect(parts({ kind: "mesh", file: "c.stl" })).toBe(0);
    expect(parts({ kind: "mesh", mesh: 7 })).toBe(0);
    expect(parts({ kind: "box" })).toBe(0);
    expect(partsFrom(undefined)({ kind: "mesh", mesh: 1, at })).toEqual([]);
  });

  it("two lists become one; of a name in both, the first one's mesh is meant", () => {
    const blue = { parts: [{ ...part, colour: "#0000ff" }] };
    const both = joined({ meshes: [blue], files: { "a.stl": 0 } }, { ...meshes, files: { ...meshes.files, "c.stl": 1 } });
    const colour = (shape: Omit<Shape, "at">) => partsFrom(both)({ ...shape, at })[0]?.colour;
    expect(colour({ kind: "mesh", file: "a.stl" })).toBe("#0000ff");
    expect(colour({ kind: "mesh", file: "c.stl" })).toBe("#ff0000");
    expect(colour({ kind: "mesh", file: "b.stl" })).toBeUndefined();
    expect(joined(undefined, meshes)).toBe(meshes);
  });
});

describe("what the ground has besides planes", () => {
  it("is drawn as it is, meshes with their own triangles", () => {
    const ground = [
      { kind: "sphere", radius: 2, at },
      {
        kind: "mesh",
        at,
        points: [
          [0, 0, 1],
          [2, 0, 1],
          [0, 3, 1],
        ],
        triangles: [[0, 1, 2]],
      },
    ];
    const file = { title: "", gravity: [0, 0, 0], mechanisms: [], joints: {}, bodies: {}, ground } as unknown as ModelFile;
    const [ball, mesh] = modelOf(file).ground ?? [];
    expect(ball).toEqual(ground[0]);
    expect([...(mesh.parts?.[0].positions ?? [])]).toEqual([0, 0, 1, 2, 0, 1, 0, 3, 1]);
    expect([...(mesh.parts?.[0].triangles ?? [])]).toEqual([0, 1, 2]);
    expect(modelOf({ ...file, ground: undefined } as unknown as ModelFile).ground).toBeUndefined();
  });
});

describe("a shape that pages do not know", () => {
  it("is drawn by its triangles", () => {
    const points = [
      [0, 0, 0],
      [1, 0, 0],
      [0, 1, 0],
    ];
    const shape = { kind: "egg", radius: 2, points, triangles: [[0, 1, 2]], at };
    const body = { mass: 1, com: [0, 0, 0], extent: [], shape };
    const file = { title: "", gravity: [0, 0, 0], mechanisms: [], joints: {}, bodies: { a: body } } as unknown as ModelFile;
    const [drawn] = meshesOf(modelOf(file).bodies[0].shapes[0], new MeshBasicMaterial());
    expect(drawn.geometry.getAttribute("position").count).toBeGreaterThanOrEqual(3);
  });
});

describe("bodies whose meshes the engine could not read", () => {
  const body = { mass: 1, com: [0, 0, 0], extent: [], shape: { kind: "box", size: [1, 1, 1], at } };
  const shapesOf = (meshes: Meshes | undefined) => {
    const missing = { ...body, missing_shapes: [{ kind: "mesh", file: "a.stl", at }] };
    const file = { title: "", gravity: [0, 0, 0], mechanisms: [], joints: {}, bodies: { a: missing } } as unknown as ModelFile;
    return modelOf(file, undefined, meshes).bodies[0].shapes;
  };

  it("are drawn with the page's meshes if it has them, otherwise as what touches", () => {
    const triangle = { low: [0, 0, 0], high: [1, 1, 1], points: base64([0, 0, 0]), triangles: base64([0, 0, 0]) } as const;
    expect(shapesOf({ meshes: [{ parts: [triangle] }], files: { "a.stl": 0 } }).map(({ kind }) => kind)).toEqual(["mesh"]);
    expect(shapesOf({ meshes: [null], files: { "a.stl": 0 } }).map(({ kind }) => kind)).toEqual(["box"]);
    expect(shapesOf(undefined).map(({ kind }) => kind)).toEqual(["box"]);
  });
});

describe("the geometry of a mesh", () => {
  /** A closed cube, or a sphere of radius 1 about the origin. */
  const cube: MeshPart = {
    positions: Float32Array.from([0, 1, 2, 3, 4, 5, 6, 7].flatMap((i) => [2 * (i & 1) - 1, (i & 2) - 1, (i & 4) / 2 - 1])),
    triangles: Uint16Array.from([
      0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5,
    ]),
  };
  function sphere(n: number): MeshPart {
    const positions: number[] = [];
    const triangles: number[] = [];
    for (let i = 0; i <= n; i++)
      for (let j = 0; j < n; j++) {
        const [a, b] = [(Math.PI * (i + 0.5)) / (n + 1), (2 * Math.PI * j) / n];
        positions.push(Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a));
      }
    for (let i = 0; i < n; i++)
      for (let j = 0; j < n; j++) {
        const [p, q] = [i * n + j, i * n + ((j + 1) % n)];
        triangles.push(p, p + n, q, q, p + n, q + n);
      }
    return { positions: Float32Array.from(positions), triangles: Uint16Array.from(triangles) };
  }
  const vectorsOf = (mesh: MeshPart, scale: Vec3, name: string) => {
    const attribute = meshGeometry(mesh, scale).getAttribute(name);
    return Array.from({ length: attribute.count }, (_, i) => new Vector3().fromBufferAttribute(attribute, i));
  };

  it("edges of a cube stay sharp: normals along the axes; outlines spread from its centre", () => {
    const [points, normals] = [vectorsOf(cube, [1, 1, 1], "position"), vectorsOf(cube, [1, 1, 1], "normal")];
    const outward = vectorsOf(cube, [1, 1, 1], "outward");
    expect(points).toHaveLength(36);
    points.forEach((point, i) => {
      expect(Math.max(...normals[i].toArray().map(Math.abs))).toBeCloseTo(1, 6);
      expect(normals[i].dot(point)).toBeCloseTo(1, 6);
      expect(outward[i].dot(point)).toBeGreaterThan(1.5);
    });
  });

  it("a sphere looks round: normals point from its centre, also if a scale mirrors and flattens it", () => {
    for (const scale of [
      [1, 1, 1],
      [1, -1, 1],
      [2, 2, -2],
    ] as const) {
      const points = vectorsOf(sphere(24), scale, "position");
      vectorsOf(sphere(24), scale, "normal").forEach((normal, i) => {
        expect(normal.dot(points[i]) / points[i].length()).toBeGreaterThan(0.98);
      });
    }
  });
});
