// Lists what holds bodies together in addition to the joints of their trees: joints that close loops, springs, and couplings.
import type { Topology } from "../../../wasm/host.mjs";
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
import type { Model, Phase, Spring } from "../recording";
import { phaseAt } from "../viewer/frames";
import { endsOf, isSlack } from "../viewer/springs";
import type { App } from "./app";

export interface Connection {
  readonly kind: "loop" | "spring" | "coupling";
  readonly name: string;
  readonly text: string;
  readonly over?: boolean;
}

const of = (model: Model, body: number) => (body < 0 ? "the ground" : model.bodies[body].name);

/** The force that stretches a spring (N); negative: it is compressed; 0 while a rope is slack. */
export function tensionOf(spring: Spring, poses: ArrayLike<number>): number {
  const [from, to] = endsOf(spring, poses);
  const tension = spring.stiffness * (from.distanceTo(to) - spring.rest);
  return spring.tensionOnly ? Math.max(tension, 0) : tension;
}

/** Tensions are without the springs' damping. */
export function connectionsOf(model: Model, topology: Topology, phase: Phase, poses: ArrayLike<number>): Connection[] {
  const loops = topology.joints
    .filter(({ loop }) => loop)
    .map(({ name, kind, parent, child, locked }) => ({
      kind: "loop" as const,
      name,
      text: `${kind}${locked ? ", locked" : ""}, ${of(model, child)} to ${of(model, parent)}`,
    }));
  const acting = new Set((phase.springs ?? model.springs ?? []).map(({ name }) => name));
  const springs = (model.springs ?? []).map((spring) => {
    const ends = `${of(model, spring.from)} to ${of(model, spring.to)}`;
    const [from, to] = endsOf(spring, poses);
    const slack = isSlack(spring, from.distanceTo(to));
    const force = slack ? "slack" : spring.inextensible ? "taut" : `${digits(tensionOf(spring, poses), 3)} N`;
    const strength = spring.strength === null ? "" : ` of ${digits(spring.strength, 3)} N`;
    return acting.has(spring.name)
      ? {
          kind: "spring" as const,
          name: spring.name,
          text: `${spring.inextensible ? "cable" : spring.tensionOnly ? "rope" : "spring"}, ${ends}: ${force}${strength}`,
        }
      : { kind: "spring" as const, name: spring.name, text: `broken, ${ends}`, over: true };
  });
  const couplings = (topology.couplings ?? []).map(({ joint, follows, ended }) => ({
    kind: "coupling" as const,
    name: joint,
    text: `${ended ? "followed" : "follows"} ${follows || "a fixed value"}`,
    ...(ended && { over: true }),
  }));
  return [...loops, ...springs, ...couplings];
}

const titles = { loop: "closes a loop", spring: "spring", coupling: "coupling" };

/** Minimum time between two updates while frames arrive (ms). */
const pause = 200;

export function connections(app: App): HTMLElement {
  const list = h("ul", { class: "list", "aria-label": "Loops, springs and couplings" });
  const legend = h("legend", {}, "Loops and springs");
  const element = h("fieldset", { class: "connections", hidden: true }, legend, list);
  let drawn = 0;
  let shown = "";
  app.listen((changed) => {
    const { run } = app;
    if (!run) return;
    const now = performance.now();
    if (changed === "frame" && app.playing && now - drawn < pause) return;
    drawn = now;
    const frame = run.frame(app.frame);
    const all = connectionsOf(run.model, run.topology, phaseAt(run, frame.time), frame.poses);
    element.hidden = all.length === 0;
    const key = JSON.stringify(all.map(({ name, kind, over }) => [name, kind, over]));
    if (key === shown) {
      // The same rows: only their texts change, and a button keeps the focus.
      all.forEach(({ text }, i) => (list.children[i].querySelector(".about")!.textContent = text));
      return;
    }
    shown = key;
    legend.textContent = `Loops, springs and couplings (${all.filter(({ over }) => !over).length})`;
    list.replaceChildren(
      ...all.map(({ kind, name, text, over }) =>
        h(
          "li",
          over ? { class: "gone" } : {},
          h("span", { class: "what", title: titles[kind] }, name),
          h("span", { class: "about" }, text),
          kind === "loop" &&
            h(
              "button",
              {
                type: "button",
                title: "Break this joint: the loop opens",
                "aria-label": `Break ${name}`,
                onclick: () => app.act({ break: name }),
              },
              "Break",
            ),
        ),
      ),
    );
  });
  return element;
}
