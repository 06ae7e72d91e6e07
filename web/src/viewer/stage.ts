// The picture: a canvas with the mechanisms, ghosts and trails; the reader rotates it with the pointer or the arrow
// keys.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Model, Phase, Motion } from "../recording";
import { distanceFor, upOf, viewOf, type View } from "./camera";
import { Floor, lengthText, Sun } from "./floor";
import { aimAt, gathered, nearestTo, spheresOf, stepTowards } from "./follow";
import { themeOf, type Theme } from "./colours";
import { MechanismsView, type Hit } from "./mechanisms";
import { Pace } from "./pace";
import { ShapeLibrary } from "./shapes";

/** three.js reports a missing context in the console; and a trial costs as much as the picture's own context. */
function newRenderer(): THREE.WebGLRenderer {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("webgl2", { antialias: true });
  if (!context) throw new Error("it does not provide WebGL 2");
  const renderer = new THREE.WebGLRenderer({ canvas, context, antialias: true });
  renderer.setClearAlpha(1);
  return renderer;
}

export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(32, 1, 0.01, 1000);
  readonly renderer: THREE.WebGLRenderer;
  readonly controls: OrbitControls;
  readonly shapes: ShapeLibrary;
  readonly mechanisms: MechanismsView;
  theme: Theme = themeOf(false);
  private readonly light = new THREE.DirectionalLight(0xffffff, 1.2);
  private readonly sky = new THREE.HemisphereLight(0xffffff, 0x9aa4b2, 1.9);
  private view: View | null = null;
  private readonly floor: Floor;
  private readonly sun = new Sun();
  private readonly scale = document.createElement("p");
  private scheduled = false;
  private state: { poses: ArrayLike<number>; phase: Phase } | null = null;
  private readonly drawListeners: ((camera: THREE.PerspectiveCamera, height: number) => void)[] = [];
  private readonly themeListeners: ((theme: Theme) => void)[] = [];
  private readonly followListeners: ((on: boolean) => void)[] = [];
  private follows = false;
  /** The body that the reader moved the camera to, and its centre at the last picture: the camera goes with it. */
  private chosen: { body: number; at: THREE.Vector3 } | null = null;
  /** When the camera last followed (s). */
  private followed = 0;
  private readonly pace = new Pace();
  private shadows = true;
  private drawingListener: (began: number, ended: number) => void = () => undefined;
  /** How much of the picture's top is covered (px): a view of everything and a camera that follows leave it free. */
  roomAbove: () => number = () => 0;
  /** Distance of the camera at the last view of everything (m). */
  private home = Infinity;
  private readonly contextListeners: ((lost: boolean) => void)[] = [];
  private readonly resizeObserver: ResizeObserver;
  private disposed = false;
  private contextLost = false;

  /** Throws if the browser can't draw the picture. */
  constructor(
    private readonly host: HTMLElement,
    readonly model: Model,
  ) {
    this.renderer = newRenderer();
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.scale.className = "scale";
    host.append(this.renderer.domElement, this.scale);
    this.floor = new Floor(model.planes, model.ground);
    this.shapes = new ShapeLibrary(model);
    this.mechanisms = new MechanismsView(model, this.shapes, { faded: 0, pixels: 4, joints: true });
    this.camera.add(this.light);
    this.light.position.set(-0.6, 0.9, 1);
    this.scene.add(this.camera, this.sky, this.sun.light, this.sun.light.target, this.floor.group, this.mechanisms.group);
    this.camera.up.copy(upOf(model)); // before the controls, which read it only once
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    let before = { target: new THREE.Vector3(), distance: 0 };
    const aim = () => ({ target: this.controls.target.clone(), distance: this.controls.getDistance() });
    this.controls.addEventListener("start", () => (before = aim()));
    this.controls.addEventListener("end", () => {
      const after = aim();
      const moved = after.target.distanceTo(before.target) + Math.abs(after.distance - before.distance);
      if (this.follows && moved > 0.02 * after.distance) this.goWith(this.controls.target);
    });
    for (const [name, lost] of [
      ["webglcontextlost", true],
      ["webglcontextrestored", false],
    ] as const)
      this.canvas.addEventListener(name, () => this.reportLost(lost));
    this.resizeObserver = new ResizeObserver(() => this.resize());
    this.resizeObserver.observe(host);
    this.resize();
  }

  get canvas(): HTMLCanvasElement {
    return this.renderer.domElement;
  }

  /** Calls back when the browser has taken the graphics context away (true), and when it is restored. */
  onContextChange(listener: (lost: boolean) => void) {
    this.contextListeners.push(listener);
  }

  /** There is currently nothing to draw on. */
  get lost() {
    return this.contextLost;
  }

  private reportLost(lost: boolean) {
    if (this.disposed) return;
    this.contextLost = lost;
    this.canvas.style.visibility = lost ? "hidden" : "";
    if (!lost) this.draw();
    for (const listener of this.contextListeners) listener(lost);
  }

  /** Bodies in their own colours if they have any, or all in the colours of their mechanisms. */
  get ownColours() {
    return this.mechanisms.ownColours;
  }
  set ownColours(own: boolean) {
    this.mechanisms.ownColours = own;
    this.setTheme(this.theme);
  }

  setTheme(theme: Theme) {
    this.theme = theme;
    this.scene.background = new THREE.Color(theme.ground);
    for (const listener of this.themeListeners) listener(theme);
    if (this.view) this.layFloor(this.view);
    if (this.state) this.show(this.state.poses, this.state.phase);
  }

  /** Width of the region that the view was fitted to (m). */
  get size(): number {
    return this.view ? 2 * this.view.radius : 1;
  }

  /** Calls back when the colours change, and immediately. */
  onThemeChange(listener: (theme: Theme) => void) {
    this.themeListeners.push(listener);
    listener(this.theme);
  }

  /** Calls back after each drawing, with the times (s) when it began and ended. */
  set onDrawn(listener: (began: number, ended: number) => void) {
    this.drawingListener = listener;
  }

  /** Calls back before each drawing, with the height of the picture in pixels. */
  onDraw(listener: (camera: THREE.PerspectiveCamera, height: number) => void) {
    this.drawListeners.push(listener);
  }

  /** Whether the camera follows what moves: everything or, after a zoom or a shift by the reader, the body in the middle. */
  get following() {
    return this.follows;
  }
  set following(on: boolean) {
    this.follows = on;
    this.chosen = null;
    for (const listener of this.followListeners) listener(on);
  }
  onFollowChange(listener: (on: boolean) => void) {
    this.followListeners.push(listener);
  }

  private spheres() {
    return this.state ? spheresOf(this.model, this.state.poses, (body) => this.shapes.sphere(body)) : [];
  }

  private goWith(point: THREE.Vector3) {
    const spheres = this.spheres();
    const body = nearestTo(point, spheres);
    this.chosen = body < 0 ? null : { body, at: spheres[body]!.at };
  }

  /** Moves the camera a part of the way that it must go to keep the bodies in the picture. */
  private follow() {
    const now = performance.now() / 1000;
    const seconds = now - this.followed;
    this.followed = now;
    if (!this.follows || !this.view || !this.state) return;
    const { camera, controls } = this;
    const spheres = this.spheres();
    const at = this.chosen && spheres[this.chosen.body]?.at;
    if (this.chosen && at) {
      const moved = at.clone().sub(this.chosen.at);
      this.chosen.at = at;
      controls.target.add(moved);
      camera.position.add(moved);
      camera.updateMatrixWorld();
      return;
    }
    const offset = camera.position.clone().sub(controls.target);
    const distance = offset.length();
    const direction = offset.divideScalar(distance);
    const near = gathered(spheres, this.view.centre, 4 * this.view.radius);
    const present = { target: controls.target, distance };
    const lens = { fov: camera.fov, aspect: camera.aspect, above: this.shareAbove() };
    const aim = aimAt(near, present, direction, camera.up, lens, this.home);
    if (aim === present) return;
    const next = stepTowards(present, aim, seconds);
    controls.target.copy(next.target);
    camera.position.copy(next.target).addScaledVector(direction, next.distance);
    camera.updateMatrixWorld();
  }

  /** Looks at a point from the present direction and distance; the floor and what the camera follows move there, too. */
  lookTowards(point: THREE.Vector3) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    this.controls.target.copy(point);
    this.camera.position.copy(point).add(offset);
    if (this.view) this.view = { ...this.view, centre: point.clone() };
    this.controls.update();
    this.following = true;
    this.draw();
  }

  /** Sets the present poses of the bodies. `poses` is used until the next call. */
  show(poses: ArrayLike<number>, phase: Phase) {
    this.state = { poses, phase };
    this.mechanisms.place(poses, phase, this.theme);
    this.follow();
    this.draw();
  }

  /** Draws with the next frame of the browser. */
  draw() {
    if (this.scheduled) return;
    this.scheduled = true;
    const requested = performance.now();
    requestAnimationFrame(() => {
      const duration = (performance.now() - requested) / 1000;
      this.drawNow();
      if (this.shadows && this.pace.isSlow(duration)) this.simplify();
    });
  }

  drawNow() {
    this.scheduled = false;
    if (this.disposed) return;
    const began = performance.now();
    const height = this.canvas.clientHeight || 1;
    this.camera.updateMatrixWorld();
    this.mechanisms.fit(this.camera, height);
    for (const listener of this.drawListeners) listener(this.camera, height);
    this.renderer.render(this.scene, this.camera);
    this.drawingListener(began / 1000, performance.now() / 1000);
  }

  /** This machine draws too slowly: motion matters more than shadows and fine pixels. */
  private simplify() {
    this.shadows = this.sun.light.castShadow = false;
    this.renderer.setPixelRatio(1);
    this.resize();
  }

  private resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.drawNow();
  }

  /**
   * Fits the whole motion into the picture; `direction`: the viewing direction, by default one that suits the motion.
   */
  fit(run: Motion, direction?: THREE.Vector3) {
    this.view = viewOf(run, (body) => this.shapes.bounds(body));
    this.layFloor(this.view);
    this.aimAt(direction ? { ...this.view, direction } : this.view);
  }

  /** The floor below all moving bodies, its scale, and the lamp above them. */
  private layFloor(view: View) {
    this.floor.lay(view, this.theme);
    this.sun.stand(view);
    this.sun.light.castShadow = this.shadows && this.floor.receivesShadows;
    this.scale.textContent = `1 square: ${lengthText(this.floor.square)}`;
  }

  /** A view that is not of the whole motion. */
  lookAt(view: View) {
    this.view = view;
    this.layFloor(view);
    this.aimAt(view);
  }

  /** The share of the picture's height that is left free at its top. */
  private shareAbove(): number {
    const height = this.canvas.clientHeight;
    return height > 0 ? Math.min(this.roomAbove() / height, 0.4) : 0;
  }

  private aimAt(view: Pick<View, "box" | "centre" | "direction" | "up">) {
    this.camera.up.copy(view.up);
    this.controls.target.copy(this.aim(this.camera, view, view.direction, this.shareAbove()));
    this.controls.update();
    this.home = this.controls.getDistance();
    this.chosen = null;
    this.draw();
  }

  /** Returns the point that the camera looks at; `above`: the share of the picture's height that is left free at its top. */
  private aim(camera: THREE.PerspectiveCamera, view: Pick<View, "box" | "centre">, direction: THREE.Vector3, above = 0) {
    const distance = distanceFor(view.box, direction, camera.up, camera.fov, camera.aspect, 1 - above);
    const right = new THREE.Vector3().crossVectors(camera.up, direction).normalize();
    const raise = above * distance * Math.tan(THREE.MathUtils.degToRad(camera.fov) / 2);
    const target = new THREE.Vector3().crossVectors(direction, right).multiplyScalar(raise).add(view.centre);
    camera.near = distance / 1000;
    camera.far = distance * 100;
    camera.position.copy(target).addScaledVector(direction, distance);
    camera.lookAt(target);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    return target;
  }

  /** Rotates about the target by angles (rad), or zooms: for the keyboard. */
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

  /** The body under a point of the page, with a tolerance of some pixels for rods; null: none. */
  pick(clientX: number, clientY: number, tolerance = 8): Hit | null {
    if (!this.state) return null;
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(clientX - box.left, clientY - box.top);
    const pointer = new THREE.Vector2((2 * at.x) / box.width - 1, 1 - (2 * at.y) / box.height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(pointer, this.camera);
    const solid = ray.intersectObject(this.mechanisms.group, true).find((hit) => hit.object.userData.body !== undefined);
    if (solid) return { body: solid.object.userData.body as number, point: solid.point };
    return this.mechanisms.nearestRod(at, this.camera, box.width, box.height, tolerance);
  }

  /** A separate picture of bodies without ghosts and trails, from the same direction. */
  snapshot(
    poses: ArrayLike<number>,
    phase: Phase,
    view: Pick<View, "box" | "centre">,
    width: number,
    height: number,
  ): HTMLCanvasElement {
    const hidden = this.scene.children.filter(
      (child) => child.visible && child !== this.mechanisms.group && !this.isLight(child),
    );
    for (const child of hidden) child.visible = false;
    const camera = this.camera.clone();
    camera.aspect = width / height;
    this.aim(camera, view, this.camera.position.clone().sub(this.controls.target).normalize());
    const ratio = this.renderer.getPixelRatio();
    this.renderer.setSize(width, height, false);
    this.mechanisms.place(poses, phase, this.theme);
    this.mechanisms.fit(camera, height);
    this.renderer.render(this.scene, camera);
    const copy = document.createElement("canvas");
    copy.width = Math.round(width * ratio);
    copy.height = Math.round(height * ratio);
    copy.getContext("2d")?.drawImage(this.canvas, 0, 0, copy.width, copy.height);
    for (const child of hidden) child.visible = true;
    this.renderer.setSize(this.host.clientWidth, this.host.clientHeight, false);
    if (this.state) this.mechanisms.place(this.state.poses, this.state.phase, this.theme);
    this.drawNow();
    return copy;
  }

  private isLight(object: THREE.Object3D) {
    return object === this.sky || object === this.camera || object === this.sun.light;
  }

  dispose() {
    this.disposed = true;
    this.resizeObserver.disconnect();
    this.mechanisms.dispose();
    this.floor.dispose();
    this.sun.light.dispose();
    this.scale.remove();
    this.shapes.dispose();
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss(); // browsers keep few contexts, and take the oldest away
    this.canvas.remove();
  }
}
