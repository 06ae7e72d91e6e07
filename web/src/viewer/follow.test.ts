import * as THREE from "three";
import { describe, expect, it } from "vitest";
import { aimAt, gathered, nearestTo, stepTowards, type Sphere } from "./follow";

let seed = 11;
const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
const vector = (size: number) => new THREE.Vector3(random() - 0.5, random() - 0.5, random() - 0.5).multiplyScalar(size);
const up = new THREE.Vector3(0, 0, 1);
const lens = { fov: 32, aspect: 1 };

describe("the camera that follows", () => {
  it("sees all pieces after it moved, as a projection confirms", () => {
    for (let n = 0; n < 300; n++) {
      const spheres: Sphere[] = Array.from({ length: 1 + Math.floor(6 * random()) }, () => ({
        at: vector(10),
        radius: 0.3 * random(),
      }));
      const direction = vector(1).normalize();
      if (Math.abs(direction.dot(up)) > 0.95) continue;
      const aspect = 0.4 + 2 * random();
      const above = n % 2 === 0 ? 0 : 0.4 * random();
      const { target, distance } = aimAt(spheres, { target: vector(3), distance: 0.5 + random() }, direction, up, {
        fov: 32,
        aspect,
        above,
      });
      const camera = new THREE.PerspectiveCamera(32, aspect, 1e-3, 1e4);
      camera.up.copy(up);
      camera.position.copy(target).addScaledVector(direction, distance);
      camera.lookAt(target);
      camera.updateMatrixWorld();
      for (const { at } of spheres) {
        const seen = at.clone().project(camera);
        expect(Math.max(Math.abs(seen.x), Math.abs(seen.y + above) / (1 - above))).toBeLessThanOrEqual(0.95);
        expect(seen.z).toBeLessThan(1);
      }
    }
  });

  it("stays where it is while all pieces are in the picture", () => {
    const present = { target: new THREE.Vector3(), distance: 20 };
    const spheres = [{ at: new THREE.Vector3(1, 1, 1), radius: 0.1 }];
    expect(aimAt(spheres, present, new THREE.Vector3(0, -1, 0), up, lens)).toBe(present);
  });

  it("moves away from what hides the top of the picture, and stays there", () => {
    const direction = new THREE.Vector3(0, -1, 0);
    const spheres = [{ at: new THREE.Vector3(0, 0, 1), radius: 0.1 }];
    const present = { target: new THREE.Vector3(), distance: 5 }; // the sphere is at 1 / 1.43 of the upper half
    expect(aimAt(spheres, present, direction, up, lens)).toBe(present);
    const below = { ...lens, above: 0.2 };
    const aim = aimAt(spheres, present, direction, up, below);
    expect(aim.target.z).toBeGreaterThan(1);
    expect(aim.distance).toBe(5);
    expect(aimAt(spheres, aim, direction, up, below)).toBe(aim);
  });

  it("comes back, but not nearer than it was, when what is left is small in the picture", () => {
    const spheres = [{ at: new THREE.Vector3(1, 0, 0), radius: 0.1 }];
    const far = { target: new THREE.Vector3(0, 0, -9), distance: 80 };
    const { target, distance } = aimAt(spheres, far, new THREE.Vector3(0, -1, 0), up, lens, 20);
    expect([...target.toArray(), distance]).toEqual([1, 0, 0, 20].map((x) => expect.closeTo(x, 9)));
    const there = { target, distance };
    expect(aimAt(spheres, there, new THREE.Vector3(0, -1, 0), up, lens, 20)).toBe(there);
  });

  it("goes as far in few pictures as in many, and keeps what falls in the picture at three pictures a second", () => {
    const [start, aim] = [0, 5].map((x) => ({ target: new THREE.Vector3(x, 0, 0), distance: 10 + x }));
    let many = start;
    for (let i = 0; i < 20; i++) many = stepTowards(many, aim, 1 / 60);
    const few = stepTowards(start, aim, 1 / 3);
    expect(many.target.x).toBeCloseTo(few.target.x, 12);
    expect(many.distance).toBeCloseTo(few.distance, 12);
    const direction = new THREE.Vector3(0, -1, 0);
    for (const rate of [3, 8, 60]) {
      let camera = { target: new THREE.Vector3(), distance: 8 };
      for (let t = 0; t < 4; t += 1 / rate) {
        const sphere = { at: new THREE.Vector3(2 * t, 0, -0.5 * 9.81 * t * t), radius: 0.1 };
        camera = stepTowards(camera, aimAt([sphere], camera, direction, up, lens), 1 / rate);
        const half = camera.distance * Math.tan(THREE.MathUtils.degToRad(16));
        expect(Math.abs(sphere.at.z - camera.target.z)).toBeLessThan(0.95 * half);
      }
    }
  });

  it("leaves pieces that are too far away, but never all of them", () => {
    const sphere = (x: number): Sphere => ({ at: new THREE.Vector3(x, 0, 0), radius: 0.1 });
    const home = new THREE.Vector3();
    expect(gathered([sphere(0), null, sphere(100)], home, 10)).toHaveLength(1);
    expect(gathered([sphere(90), sphere(100), sphere(500)], home, 20).map(({ at }) => at.x)).toEqual([90, 100]);
    expect(gathered([null], home, 20)).toEqual([]);
  });

  it("goes with the body in the middle after the reader moved the camera", () => {
    const sphere = (x: number): Sphere => ({ at: new THREE.Vector3(x, 0, 0), radius: 0.1 });
    expect(nearestTo(new THREE.Vector3(2.2, 0, 0), [sphere(0), null, sphere(2), sphere(3)])).toBe(2);
    expect(nearestTo(new THREE.Vector3(), [null])).toBe(-1);
  });
});
