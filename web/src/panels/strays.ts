// Names of mechanisms that are outside the picture, at its edge in the direction where they are; a press makes the camera follow.
import * as THREE from "three";
import type { Phase } from "../recording";
import { mechanismColour } from "../viewer/colours";
import { spheresOf } from "../viewer/follow";
import { lengthText } from "../viewer/floor";
import type { Stage } from "../viewer/stage";
import { h } from "./dom";

const most = 4;

interface Stray {
  readonly name: string;
  readonly mechanism: number;
  readonly at: THREE.Vector3;
}

/** Mechanisms without a body in the picture: by their heaviest body. */
function straysOf(stage: Stage, poses: ArrayLike<number>, phase: Phase, names: readonly string[]): Stray[] {
  const spheres = spheresOf(stage.model, poses, (body) => stage.shapes.sphere(body));
  const seen = new Set<number>();
  const heaviest = new Map<number, number>();
  const at = new THREE.Vector3();
  spheres.forEach((sphere, b) => {
    if (!sphere) return;
    const m = phase.mechanism[b];
    const before = heaviest.get(m);
    if (before === undefined || stage.model.bodies[before].mass < stage.model.bodies[b].mass) heaviest.set(m, b);
    at.copy(sphere.at).project(stage.camera);
    if (Math.abs(at.x) < 1 && Math.abs(at.y) < 1 && at.z < 1) seen.add(m);
  });
  return [...heaviest]
    .filter(([m]) => !seen.has(m))
    .map(([m, b]) => ({ name: names[m] ?? "", mechanism: m, at: spheres[b]!.at }));
}

/** A long name without its middle: mechanisms of one origin have the same start, and differ at the end. */
export const withoutMiddle = (name: string, most = 18) =>
  name.length <= most ? name : `${name.slice(0, Math.floor(most / 3))}…${name.slice(1 - most + Math.floor(most / 3))}`;

interface Label {
  readonly left: number;
  /** Of its centre, as `left` (px). */
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

/** The same labels, moved towards the middle of a picture of this height until none covers another. */
export function apart(labels: readonly Label[], height: number): Label[] {
  const placed: Label[] = [];
  for (const label of labels) {
    const step = label.top > height / 2 ? -1 : 1;
    const covers = ({ left, top, width, height: tall }: Label, at: number) =>
      Math.abs(left - label.left) < (width + label.width) / 2 + 4 && Math.abs(top - at) < (tall + label.height) / 2 + 4;
    let { top } = label;
    while (placed.some((other) => covers(other, top)) && top > 0 && top < height) top += step;
    placed.push({ ...label, top });
  }
  return placed;
}

export class Strays {
  readonly element = h("div", { class: "strays", role: "group", "aria-label": "Outside the picture" });
  private readonly buttons: HTMLButtonElement[] = [];
  private shown: Stray[] = [];

  constructor(
    private readonly stage: Stage,
    private readonly present: () => { poses: ArrayLike<number>; phase: Phase; names: readonly string[] } | null,
  ) {
    for (let i = 0; i < most; i++) {
      const button = h("button", { type: "button", class: "stray", title: "Outside the picture", hidden: true });
      button.addEventListener("click", () => {
        const stray = this.shown[i];
        if (stray) stage.lookTowards(stray.at);
      });
      this.buttons.push(button);
      this.element.append(button);
    }
    stage.onDraw((camera) => this.place(camera));
  }

  private place(camera: THREE.PerspectiveCamera) {
    const now = this.present();
    this.shown = now ? straysOf(this.stage, now.poses, now.phase, now.names).slice(0, most) : [];
    const { clientWidth: width, clientHeight: height, parentElement: picture } = this.stage.canvas;
    this.buttons.forEach((button, i) => {
      const stray = this.shown[i];
      button.hidden = !stray;
      if (!stray) return;
      const away = `${lengthText(Math.max(stray.at.distanceTo(this.stage.controls.target), 1e-9))} away`;
      const text = `${stray.name}, ${away}`;
      if (button.title === text) return;
      button.title = text;
      button.setAttribute("aria-label", text);
      button.textContent = `${withoutMiddle(stray.name)}, ${away}`;
      button.style.setProperty("--of", mechanismColour(this.stage.theme, stray.mechanism));
    });
    if (this.shown.length === 0) return;
    // Between the buttons above and the texts below.
    const tall = (selector: string) => picture?.querySelector<HTMLElement>(selector)?.offsetHeight ?? 0;
    const [above, below] = [tall(".over .tools") + 12, Math.max(tall(".below"), 20) + 12];
    const labels = this.shown.map((stray, i) => {
      const { offsetWidth, offsetHeight } = this.buttons[i];
      // In the camera's axes: behind it, the direction aside still tells where to turn.
      const aside = stray.at.clone().applyMatrix4(camera.matrixWorldInverse);
      const angle = Math.atan2(aside.y, aside.x);
      const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
      const x = 0.5 * (width - offsetWidth) - 6;
      const y = Math.max(0.5 * (height - offsetHeight) - (sin > 0 ? above : below), 10);
      const share = Math.min(x / Math.max(Math.abs(cos), 1e-6), y / Math.max(Math.abs(sin), 1e-6));
      return { left: 0.5 * width + share * cos, top: 0.5 * height - share * sin, width: offsetWidth, height: offsetHeight };
    });
    apart(labels, height).forEach(({ left, top }, i) => {
      this.buttons[i].style.left = `${left}px`;
      this.buttons[i].style.top = `${top}px`;
    });
  }
}
