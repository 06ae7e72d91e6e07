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
  const spheres = spheresOf(stage.model, poses, (body) => stage.shapes.reach(body));
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
    const { clientWidth: width, clientHeight: height } = this.stage.canvas;
    this.buttons.forEach((button, i) => {
      const stray = this.shown[i];
      button.hidden = !stray;
      if (!stray) return;
      // In the camera's axes: behind it, the direction aside still tells where to turn.
      const aside = stray.at.clone().applyMatrix4(camera.matrixWorldInverse);
      const angle = Math.atan2(aside.y, aside.x);
      const [x, y] = [0.5 * width - 92, 0.5 * height - 78];
      const share = Math.min(x / Math.max(Math.abs(Math.cos(angle)), 1e-6), y / Math.max(Math.abs(Math.sin(angle)), 1e-6));
      const [left, top] = [0.5 * width + share * Math.cos(angle), 0.5 * height - share * Math.sin(angle)];
      const text = `${stray.name}, ${lengthText(Math.max(stray.at.distanceTo(this.stage.controls.target), 1e-9))} away`;
      if (button.title !== text) {
        button.title = text;
        button.textContent = text;
        button.style.setProperty("--of", mechanismColour(this.stage.theme, stray.mechanism));
      }
      button.style.left = `${left}px`;
      button.style.top = `${top}px`;
    });
  }
}
