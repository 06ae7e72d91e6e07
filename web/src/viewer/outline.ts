// Outlines of bodies with their own colours, in the colour of their mechanism: the shape's back faces, some pixels
// wider.
import * as THREE from "three";

/** Adds the attribute `outward` to a geometry: normals shared at corners, so that the widened shape has no gaps. */
export function addOutward(geometry: THREE.BufferGeometry) {
  const position = geometry.getAttribute("position");
  const normal = geometry.getAttribute("normal");
  geometry.computeBoundingBox();
  const size = geometry.boundingBox!.getSize(new THREE.Vector3()).length() || 1;
  const key = (i: number) =>
    [position.getX(i), position.getY(i), position.getZ(i)].map((x) => Math.round((1e5 * x) / size)).join();
  const sums = new Map<string, THREE.Vector3>();
  const vector = new THREE.Vector3();
  for (let i = 0; i < position.count; i++) {
    const at = key(i);
    if (!sums.has(at)) sums.set(at, new THREE.Vector3());
    sums.get(at)!.add(vector.fromBufferAttribute(normal, i));
  }
  const outward = new Float32Array(3 * position.count);
  for (let i = 0; i < position.count; i++)
    vector
      .copy(sums.get(key(i))!)
      .normalize()
      .toArray(outward, 3 * i);
  geometry.setAttribute("outward", new THREE.BufferAttribute(outward, 3));
}

/** The size of the picture (CSS pixels), shared by all materials of a view. */
export type Resolution = { value: THREE.Vector2 };

/**
 * `behind`: the outline lies this much (m) farther away than the back faces. It hides what is farther away still, and so parts
 * two bodies of which one is in front of the other, but not the surfaces next to a small part of a mesh.
 */
export function outlineMaterial(pixels: number, behind: number, resolution: Resolution): THREE.MeshBasicMaterial {
  // Drawn with the transparent objects, which are ordered by `renderOrder`.
  const material = new THREE.MeshBasicMaterial({ side: THREE.BackSide, transparent: true });
  material.onBeforeCompile = (shader) => {
    shader.uniforms.resolution = resolution;
    shader.vertexShader = `attribute vec3 outward;\nuniform vec2 resolution;\n${shader.vertexShader}`.replace(
      "#include <project_vertex>",
      `#include <project_vertex>
      vec2 aside = (projectionMatrix * modelViewMatrix * vec4(outward, 0.0)).xy * resolution;
      vec4 away = projectionMatrix * (mvPosition - vec4(0.0, 0.0, ${behind.toExponential()}, 0.0));
      gl_Position.z = min(away.z / away.w, 1.0) * gl_Position.w;
      gl_Position.xy += ${pixels.toFixed(1)} * 2.0 * gl_Position.w * aside / max(length(aside), 1e-6) / resolution;`,
    );
  };
  return material;
}
