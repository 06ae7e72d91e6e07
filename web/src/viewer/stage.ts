// The picture: a canvas with the mechanisms, ghosts and trails; the reader turns it with the pointer or the arrow keys.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Model, Phase, Recording } from "../recording";
import { upOf, viewOf, type View } from "./camera";
import { mixed, themeOf, type Theme } from "./colours";
import { MechanismsView, type Hit } from "./mechanisms";
import { ShapeLibrary } from "./shapes";

export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(32, 1, 0.01, 1000);
  readonly renderer: THREE.WebGLRenderer;
  readonly controls: OrbitControls;
  readonly shapes: ShapeLibrary;
  readonly mechanisms: MechanismsView;
  theme: Theme = themeOf(false);
  private readonly light = new THREE.DirectionalLight(0xffffff, 1.9);
  private readonly sky = new THREE.HemisphereLight(0xffffff, 0x9aa4b2, 1.9);
  private view: View | null = null;
  private wanted = false;
  private state: { poses: ArrayLike<number>; phase: Phase } | null = null;
  private readonly beforeDraw: ((camera: THREE.PerspectiveCamera, height: number) => void)[] = [];
  private readonly onTheme: ((theme: Theme) => void)[] = [];
  private readonly watcher: ResizeObserver;

  /** Throws where the browser has no WebGL. */
  constructor(
    private readonly host: HTMLElement,
    model: Model,
  ) {
    this.renderer = new THREE.WebGLRenderer({ antialias: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    host.append(this.renderer.domElement);
    this.shapes = new ShapeLibrary(model);
    this.mechanisms = new MechanismsView(model, this.shapes, { faded: 0, pixels: 4, joints: true });
    this.camera.add(this.light);
    this.light.position.set(-0.6, 0.9, 1);
    this.scene.add(this.camera, this.sky, this.mechanisms.group);
    this.camera.up.copy(upOf(model)); // before the controls, which ask for it once
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    this.watcher = new ResizeObserver(() => this.resize());
    this.watcher.observe(host);
    this.resize();
  }

  get canvas(): HTMLCanvasElement {
    return this.renderer.domElement;
  }

  setTheme(theme: Theme) {
    this.theme = theme;
    this.scene.background = new THREE.Color(theme.ground);
    for (const listener of this.onTheme) listener(theme);
    if (this.state) this.show(this.state.poses, this.state.phase);
  }

  /** Called when the colours change, and at once. */
  whenThemed(listener: (theme: Theme) => void) {
    this.onTheme.push(listener);
    listener(this.theme);
  }

  /** Called before each drawing, with the height of the picture in pixels. */
  whenDrawn(listener: (camera: THREE.PerspectiveCamera, height: number) => void) {
    this.beforeDraw.push(listener);
  }

  /** The bodies where they are now. `poses` is kept until the next call. */
  show(poses: ArrayLike<number>, phase: Phase) {
    this.state = { poses, phase };
    this.mechanisms.place(poses, phase, this.theme);
    this.draw();
  }

  /** Draws with the next frame of the browser. */
  draw() {
    if (this.wanted) return;
    this.wanted = true;
    requestAnimationFrame(() => this.drawNow());
  }

  drawNow() {
    this.wanted = false;
    const height = this.canvas.clientHeight || 1;
    this.camera.updateMatrixWorld();
    this.mechanisms.fit(this.camera, height);
    for (const listener of this.beforeDraw) listener(this.camera, height);
    this.renderer.render(this.scene, this.camera);
  }

  private resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.drawNow();
  }

  /** The whole motion in the picture; `direction`: from where, else as it is fit for the motion. */
  fit(run: Recording, direction?: THREE.Vector3) {
    this.view = viewOf(run, (body) => this.shapes.reach(body));
    this.lookAt(direction ? { ...this.view, direction } : this.view);
  }

  /** A part of the picture. */
  lookAt(view: Pick<View, "centre" | "radius" | "direction" | "up">) {
    const half = THREE.MathUtils.degToRad(this.camera.fov) / 2;
    const across = Math.min(1, this.camera.aspect);
    const distance = view.radius / Math.sin(Math.atan(Math.tan(half) * across));
    this.camera.up.copy(view.up);
    this.camera.near = distance / 1000;
    this.camera.far = distance * 100;
    this.camera.position.copy(view.centre).addScaledVector(view.direction, distance);
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(view.centre);
    this.controls.update();
    this.draw();
  }

  /** Turns about the target by angles (rad), or nears it: for the keyboard. */
  turn(sideways: number, upwards: number, nearer = 1) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const right = new THREE.Vector3().crossVectors(this.camera.up, offset).normalize();
    const angle = offset.angleTo(this.camera.up);
    const tilt = Math.min(Math.max(angle - upwards, 0.05), Math.PI - 0.05) - angle;
    offset.applyAxisAngle(right, tilt).applyAxisAngle(this.camera.up, sideways).multiplyScalar(nearer);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  /** The body under a point of the page, rods with some pixels of patience; null: none. */
  pick(clientX: number, clientY: number, patience = 8): Hit | null {
    if (!this.state) return null;
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(clientX - box.left, clientY - box.top);
    const pointer = new THREE.Vector2((2 * at.x) / box.width - 1, 1 - (2 * at.y) / box.height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(pointer, this.camera);
    const solid = ray.intersectObject(this.mechanisms.group, true).find((hit) => hit.object.userData.body !== undefined);
    if (solid) return { body: solid.object.userData.body as number, point: solid.point };
    return this.mechanisms.nearestRod(at, this.camera, box.width, box.height, patience);
  }

  /** A colour for what is quiet: grids, trails of what is past. */
  quiet(share: number) {
    return mixed(this.theme.ink, this.theme.ground, share);
  }

  dispose() {
    this.watcher.disconnect();
    this.mechanisms.dispose();
    this.shapes.dispose();
    this.controls.dispose();
    this.renderer.dispose();
    this.canvas.remove();
  }
}
