// The plots next to the picture: energy, momentum, and the data of any joint; each with a choice of quantities.
import type { Column, JointQuantity, Recording, RunEvent, WorldQuantity } from "../recording";
import { affectedBodies } from "../viewer/before_after";
import type { Theme } from "../viewer/colours";
import { inboardJoints } from "../viewer/frames";
import type { Player } from "../viewer/player";
import { h } from "./dom";
import { Plot, significantColumns } from "./plot";
import { Scales } from "./scales";

const worldNames: Record<WorldQuantity, string> = {
  energy: "Energy by kind",
  balance: "Error of the energy balance",
  linear: "Linear momentum",
  angular: "Angular momentum",
};
const jointNames: Record<JointQuantity, string> = {
  q: "coordinate q",
  v: "velocity v",
  p: "momentum p",
  force: "reaction force",
  torque: "reaction torque",
};

const readable: Record<string, string> = {
  gravity: "potential",
  elastic: "springs",
  dissipated: "dissipated",
  lost: "lost in impacts",
  released: "released",
  work: "work done on it",
  "linear.x": "x",
  "linear.y": "y",
  "linear.z": "z",
  "angular.x": "x",
  "angular.y": "y",
  "angular.z": "z",
};

/** Present energy plus energy lost, minus energy added: it is constant if the balance closes. */
export function balanceOf(columns: readonly Column[]): Column | null {
  const terms = columns.map((column) => ({
    values: column.values,
    sign: column.label === "work" ? -1 : 1,
  }));
  if (terms.length === 0) return null;
  const values = new Float64Array(terms[0].values.length);
  for (const { values: term, sign } of terms) for (let i = 0; i < values.length; i++) values[i] += sign * term[i];
  const worked = terms.some(({ values: term, sign }) => sign < 0 && Array.from(term).some((value) => value !== 0));
  return { label: worked ? "all, less work" : "all", unit: "J", values };
}

/** Relative precision of joint columns, which are stored in single precision. */
const single = 2.4e-7;

export class Plots {
  readonly element = h("section", { class: "plots", "aria-label": "Plots" });
  private readonly all: Plot[] = [];
  private readonly scales: Scales;
  private readonly joint = h("select", { "aria-label": "Joint" });
  private readonly quantity = h("select", { "aria-label": "Quantity of the joint" });

  constructor(
    private readonly run: Recording,
    private readonly player: Player,
  ) {
    this.scales = new Scales(run);
    this.world(["energy", "balance"]);
    this.world(["linear", "angular"]);
    if (run.joints.length > 0) this.joints();
  }

  setTheme(theme: Theme) {
    for (const plot of this.all) plot.setTheme(theme);
  }

  /** Shows this joint in the joint plot. */
  chooseJoint(name: string) {
    if (!this.run.joints.includes(name)) return;
    this.joint.value = name;
    this.joint.dispatchEvent(new Event("change"));
  }

  private add(
    controls: HTMLElement[],
    content: () => { title: string; columns: readonly Column[]; scale: number; precision: number },
  ) {
    const plot = new Plot(this.run, this.player);
    const show = () => {
      const { title, columns, scale, precision } = content();
      plot.show(title, columns, scale, precision);
    };
    for (const control of controls) control.addEventListener("change", show);
    this.all.push(plot);
    this.element.append(
      h("figure", {}, h("figcaption", {}, h("div", { class: "choice" }, ...controls), plot.legend), plot.element),
    );
    show();
  }

  private world(quantities: readonly WorldQuantity[]) {
    const choice = h("select", { "aria-label": "Plotted quantity" });
    for (const quantity of quantities) choice.append(h("option", { value: quantity }, worldNames[quantity]));
    this.add([choice], () => {
      const quantity = choice.value as WorldQuantity;
      const columns = this.run.world(quantity);
      const balance = quantity === "energy" ? balanceOf(columns) : null;
      const shown = significantColumns(columns, quantity === "energy" ? 1e-7 : 0).map((column) => ({
        ...column,
        label: readable[column.label] ?? column.label,
      }));
      return {
        title: worldNames[quantity],
        columns: balance && columns.length > 0 ? [...shown, balance] : shown,
        scale: this.scales.world(quantity),
        precision: 0,
      };
    });
  }

  private joints() {
    const fill = () => {
      const before = this.quantity.value;
      const recorded = (Object.keys(jointNames) as JointQuantity[]).filter(
        (q) => this.run.joint(this.joint.value, q).length > 0,
      );
      this.quantity.replaceChildren(...recorded.map((q) => h("option", { value: q }, jointNames[q])));
      if (recorded.includes(before as JointQuantity)) this.quantity.value = before;
    };
    for (const name of this.run.joints) this.joint.append(h("option", {}, name));
    this.joint.addEventListener("change", fill);
    // First the joint that breaks or joins, otherwise that of any event.
    const separating = this.run.events.filter((event) => event.mechanisms.before.join() !== event.mechanisms.after.join());
    for (const event of [...separating, ...this.run.events]) {
      const joint = this.loopOf(event) ?? affectedBodies(this.run, event).map((body) => this.jointOf(body))[0];
      if (joint === undefined) continue;
      this.joint.value = joint;
      break;
    }
    fill();
    this.add([this.joint, this.quantity], () => {
      const quantity = this.quantity.value as JointQuantity;
      const columns = this.run.joint(this.joint.value, quantity);
      return {
        title: `${this.joint.value}: ${jointNames[quantity] ?? ""}`,
        columns,
        scale: Math.max(0, ...columns.map(({ unit }) => this.scales.joint(quantity, unit))),
        precision: single,
      };
    });
  }

  private jointOf(body: number): string | undefined {
    const name = inboardJoints(this.run.model.joints).get(body)?.name;
    return name !== undefined && this.run.joints.includes(name) ? name : undefined;
  }

  /** The joint that closes a loop and that an event made, changed or broke. */
  private loopOf({ changes }: RunEvent): string | undefined {
    const loops = new Set(this.run.phases.flatMap(({ joints }) => joints.filter(({ loop }) => loop).map(({ name }) => name)));
    const done = changes.filter(({ skipped }) => skipped === undefined).flatMap(({ joint }) => joint ?? []);
    return done.find((name) => loops.has(name) && this.run.joints.includes(name));
  }
}
