// The arrows of momenta and forces in a picture, with the sizes of the longest.
import * as THREE from "three";
import type { Joint, Motion } from "../recording";
import { Arrows, ArrowScale, type Arrow } from "../viewer/arrows";
import { mechanismColour } from "../viewer/colours";
import { frameAt } from "../viewer/frames";
import { forcesAt, momentaAt } from "../viewer/momenta";
import type { Stage } from "../viewer/stage";
import { h } from "./dom";
import { digits } from "./numbers";

/** Numbers of the colours, which are unlike those of the first mechanisms. */
const [momentumColour, forceColour, contactColour] = [2, 6, 3];

/** Forces of contacts on their first bodies, at the last frame before a time. */
function contactsAt(run: Motion, time: number): Arrow[] {
  return (run.contacts?.(frameAt(run, time)) ?? []).map(({ point, force }) => ({
    from: new THREE.Vector3(...point),
    vector: new THREE.Vector3(...force),
  }));
}

export class Vectors {
  readonly legend = h("p", { class: "vectors", "aria-live": "off" });
  visible = false;
  private readonly momenta = new Arrows();
  private readonly forces = new Arrows();
  private readonly contacts = new Arrows();
  private scales = { momenta: new ArrowScale(), forces: new ArrowScale() };

  constructor(private readonly stage: Stage) {
    stage.scene.add(this.momenta.group, this.forces.group, this.contacts.group);
    stage.onDraw((camera, height) => {
      this.momenta.fit(camera, height);
      this.forces.fit(camera, height);
      this.contacts.fit(camera, height);
    });
  }

  /** `force`: of a joint on its child, in the child's axes; null: unknown. */
  show(run: Motion, time: number, poses: ArrayLike<number>, force: (joint: Joint) => readonly number[] | null) {
    const momenta = this.visible ? momentaAt(run, time, poses) : [];
    const forces = this.visible ? forcesAt(run, time, poses, force) : [];
    const roundOff = 1e-9 * this.stage.size * run.model.bodies.reduce((sum, { mass }) => sum + mass, 0);
    const contacts = this.visible ? contactsAt(run, time) : [];
    const longest = 0.22 * this.stage.size;
    const colour = (number: number) => mechanismColour(this.stage.theme, number);
    this.momenta.set(momenta, this.scales.momenta.for(momenta, longest, roundOff), colour(momentumColour));
    const scale = this.scales.forces.for([...forces, ...contacts], longest); // forces of both kinds can be compared
    this.forces.set(forces, scale, colour(forceColour));
    this.contacts.set(contacts, scale, colour(contactColour));
    this.legend.hidden = !this.visible;
    if (!this.visible) return;
    const entry = (number: number, text: string) => {
      const swatch = h("span", { class: "swatch" });
      swatch.style.background = colour(number);
      return h("span", {}, swatch, ` ${text}`);
    };
    const most = (arrows: typeof momenta) => Math.max(0, ...arrows.map(({ vector }) => vector.length()));
    this.legend.replaceChildren(
      entry(momentumColour, `momentum, largest ${digits(most(momenta), 3)} N s`),
      forces.length > 0 || run.contacts
        ? entry(forceColour, `joint force, largest ${digits(most(forces), 3)} N`)
        : h("span", {}, "joint forces: not recorded (--reactions)"),
      ...(contacts.length > 0 ? [entry(contactColour, `contact force, largest ${digits(most(contacts), 3)} N`)] : []),
    );
  }
}
