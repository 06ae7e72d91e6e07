// The arrows of momenta and forces in a picture, with the sizes of the longest.
import type { Joint, Motion } from "../recording";
import { Arrows, ArrowScale } from "../viewer/arrows";
import { mechanismColour } from "../viewer/colours";
import { forcesAt, momentaAt } from "../viewer/momenta";
import type { Stage } from "../viewer/stage";
import { h } from "./dom";
import { digits } from "./numbers";

/** Numbers of the colours, which are unlike those of the first mechanisms. */
const [momentumColour, forceColour] = [2, 6];

export class Vectors {
  readonly legend = h("p", { class: "vectors", "aria-live": "off" });
  visible = false;
  private readonly momenta = new Arrows();
  private readonly forces = new Arrows();
  private scales = { momenta: new ArrowScale(), forces: new ArrowScale() };

  constructor(private readonly stage: Stage) {
    stage.scene.add(this.momenta.group, this.forces.group);
    stage.onDraw((camera, height) => {
      this.momenta.fit(camera, height);
      this.forces.fit(camera, height);
    });
  }

  /** `force`: of a joint on its child, in the child's axes; null: unknown. */
  show(run: Motion, time: number, poses: ArrayLike<number>, force: (joint: Joint) => readonly number[] | null) {
    const momenta = this.visible ? momentaAt(run, time, poses) : [];
    const forces = this.visible ? forcesAt(run, time, poses, force) : [];
    const longest = 0.22 * this.stage.size;
    const colour = (number: number) => mechanismColour(this.stage.theme, number);
    this.momenta.set(momenta, this.scales.momenta.for(momenta, longest), colour(momentumColour));
    this.forces.set(forces, this.scales.forces.for(forces, longest), colour(forceColour));
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
      forces.length > 0
        ? entry(forceColour, `joint force, largest ${digits(most(forces), 3)} N`)
        : h("span", {}, "joint forces: not recorded (--reactions)"),
    );
  }
}
