// The panel next to the picture: joints, sliders, events and branches.
import { groupsOf, groupText } from "../contacts";
import { h } from "../panels/dom";
import { massOf } from "../recording";
import { typicalLength } from "../viewer/mechanisms";
import type { App } from "./app";

/** Joints by name, without a pointer: the same actions as the tools. */
export function jointControls(app: App): HTMLElement {
  const choice = h("select", { "aria-label": "Joint", onchange: () => app.run && update() });
  const button = (label: string, action: "break" | "free" | "lock" | "unlock", title: string) =>
    h("button", { type: "button", title, onclick: () => app.act({ [action]: choice.value }) }, label);
  const lock = button("Lock", "lock", "Fixes the joint in its present position by an impulse");
  const unlock = button("Unlock", "unlock", "Releases the lock");
  const breaks = button("Break", "break", "The bodies beyond it detach");
  const free = button("Free", "free", "It becomes a joint with six degrees of freedom in the same mechanism");
  const state = h("p", { class: "joint-state" });
  const field = (parameter: "damping" | "stiffness", unit: string) => {
    const input = h("input", { type: "number", min: 0, step: "any", "aria-label": `${parameter} of the joint (${unit})` });
    input.addEventListener("change", () => {
      const value = input.valueAsNumber;
      if (Number.isFinite(value)) app.send({ type: "act", action: { set: { joint: choice.value, [parameter]: value } } });
    });
    return { parameter, input, label: h("label", {}, parameter === "damping" ? "Damping" : "Stiffness", input, unit) };
  };
  const fields = [field("damping", "N m s, N s/m"), field("stiffness", "N m, N/m")];
  const update = () => {
    const joint = app.topology?.joints.find(({ name }) => name === choice.value);
    for (const each of [lock, unlock, breaks, free]) each.disabled = !joint;
    for (const { input } of fields) input.disabled = !joint || joint.kind === "weld";
    if (!joint) return;
    for (const { parameter, input } of fields)
      if (input !== document.activeElement) input.value = String(joint[parameter] ?? 0);
    lock.disabled = joint.locked !== 0 || joint.kind === "weld";
    unlock.disabled = joint.locked === 0;
    state.textContent = [joint.kind, ...(joint.locked ? ["locked"] : []), ...(joint.loop ? ["closes a loop"] : [])].join(", ");
  };
  let shown: unknown = null;
  let chosen: string | null = null;
  const show = () => {
    if (chosen !== app.chosenJoint) {
      chosen = app.chosenJoint;
      if (chosen !== null && [...choice.options].some(({ value }) => value === chosen)) choice.value = chosen;
    }
    if (shown === app.topology) return update();
    shown = app.topology;
    const before = choice.value;
    const joints = (app.topology?.joints ?? []).filter(({ kind }) => kind !== "free");
    choice.replaceChildren(...joints.map(({ name }) => h("option", { value: name }, name)));
    const former = joints.find(({ name }) => name === before);
    const shownFirst = former ?? joints.find(({ kind }) => kind !== "weld") ?? joints[0];
    if (shownFirst) choice.value = shownFirst.name;
    update();
  };
  app.listen(show);
  return h(
    "fieldset",
    { class: "joint" },
    h("legend", {}, "Joint"),
    choice,
    h("div", { class: "buttons" }, breaks, lock, unlock, free),
    ...fields.map(({ label }) => label),
    state,
  );
}

/** Welds two bodies by name, without a pointer. */
export function weldControls(app: App): HTMLElement {
  const body = h("select", { "aria-label": "Body to weld" });
  const to = h("select", { "aria-label": "Weld to" });
  const weld = h(
    "button",
    {
      type: "button",
      title: "Joins them rigidly; two bodies of one mechanism close a loop",
      onclick: () => app.act({ weld: { body: body.value, to: to.value } }),
    },
    "Weld together",
  );
  const update = () => (weld.disabled = body.value === to.value || body.value === "");
  for (const choice of [body, to]) choice.addEventListener("change", update);
  app.listen((changed) => {
    if (changed !== "world") return;
    const options = () => (app.run?.model.bodies ?? []).map(({ name }) => h("option", { value: name }, name));
    body.replaceChildren(...options());
    to.replaceChildren(...options(), h("option", { value: "ground" }, "the ground"));
    to.selectedIndex = Math.min(1, to.options.length - 1);
    update();
  });
  return h("fieldset", { class: "joint" }, h("legend", {}, "Bodies"), body, to, h("div", { class: "buttons" }, weld));
}

export function sliders(app: App): HTMLElement {
  const gravity = h("input", { type: "range", min: 0, max: 20, step: 0.01 });
  const gravityText = h("output");
  const damping = h("input", { type: "range", min: 0, max: 1, step: 0.01, value: 0 });
  const dampingText = h("output");
  const strength = h("input", { type: "range", min: -1, max: 3, step: 0.05, value: 3 });
  const strengthText = h("output", {}, "as given");
  let direction: [number, number, number] = [0, 0, -1];
  const scale = () => {
    const model = app.run?.model;
    return model ? massOf(model.bodies) * typicalLength(model) ** 2 : 0;
  };
  const showGravity = () => (gravityText.textContent = `${Number(gravity.value).toFixed(2)} m/s²`);
  const added = () => scale() * Number(damping.value) ** 3;
  const showDamping = () => (dampingText.textContent = `+${added().toPrecision(2)} N m s`);
  gravity.addEventListener("input", () => {
    const g = Number(gravity.value);
    app.send({ type: "gravity", value: [g * direction[0], g * direction[1], g * direction[2]] });
    showGravity();
  });
  damping.addEventListener("change", () => app.send({ type: "damping", factor: 1, offset: added() }));
  damping.addEventListener("input", showDamping);
  /** From a tenth of the weight of everything on earth to a thousand times it. */
  const force = () => massOf(app.run?.model.bodies ?? []) * 9.81 * 10 ** Number(strength.value);
  const showStrength = () => (strengthText.textContent = `${Number(force().toPrecision(2))} N`);
  strength.addEventListener("input", showStrength);
  strength.addEventListener("change", () => app.send({ type: "strength", force: force() }));
  app.listen((changed) => {
    if ((changed !== "world" && changed !== "sliders") || !app.scenario) return;
    const [x, y, z] = app.scenario.gravity;
    const size = Math.hypot(x, y, z);
    if (changed === "world" || gravity !== document.activeElement) {
      if (size > 0) direction = [x / size, y / size, z / size];
      gravity.value = String(size);
      showGravity();
    }
    if (changed !== "world") return;
    damping.value = "0";
    showDamping();
    strength.value = "3";
    strengthText.textContent = "as given";
  });
  return h(
    "fieldset",
    {},
    h("legend", {}, "World"),
    h("label", {}, "Gravity", gravity, gravityText),
    h("label", { title: "Added to the damping of every joint" }, "Damping", damping, dampingText),
    !app.live &&
      h(
        "label",
        { title: "Joints break when their force exceeds this: pull until they do" },
        "Strength",
        strength,
        strengthText,
      ),
  );
}

/** Events, each with a button to go back to just before it; and the other branches. */
export function history(app: App): HTMLElement {
  const list = h("ul", { class: "list", "aria-label": "Events" });
  const branches = h("ul", { class: "list", "aria-label": "Branches" });
  let shownFrom = 0;
  const beforeStart = "before the start of what this page recorded";
  const show = (changed: string) => {
    const run = app.run;
    const from = run?.time(0) ?? 0;
    if (changed !== "world" && changed !== "branch" && from === shownFrom) return;
    shownFrom = from;
    const most = 200;
    const all = run?.events ?? [];
    const events = groupsOf(all, 0.25)
      .map((group) => ({ text: groupText(all, group), event: all[group.first], index: group.first }))
      .filter(({ event }) => event.bodies || !event.changes.every(({ kind }) => kind === "set"));
    list.replaceChildren(
      ...events
        .slice(-most)
        .reverse()
        .map(({ text, event, index }) =>
          h(
            "li",
            {},
            h(
              "button",
              {
                type: "button",
                class: "event",
                title: `${text}: ${event.time < from ? beforeStart : "show this instant"}`,
                disabled: event.time < from,
                onclick: () => app.seek(event.time),
              },
              h("span", { class: "time" }, `${event.time.toFixed(3)} s`),
              h("span", { class: "description" }, text),
            ),
            !app.live &&
              h("button", { type: "button", title: "Go back to just before it", onclick: () => app.undo(index) }, "Undo"),
          ),
        ),
    );
    if (events.length > most) list.append(h("li", { class: "nothing" }, `and ${events.length - most} earlier ones`));
    if (list.childElementCount === 0) list.append(h("li", { class: "nothing" }, "No events yet."));
    branches.replaceChildren(
      ...(run?.otherBranches ?? [])
        .slice(-20)
        .reverse()
        .map(({ number, end, lastAction }) =>
          h(
            "li",
            {},
            h("button", { type: "button", onclick: () => app.resumeBranch(number) }, `to ${end.toFixed(2)} s: ${lastAction}`),
          ),
        ),
    );
    heading.hidden = (run?.otherBranches.length ?? 0) === 0;
  };
  const heading = h("h2", {}, "Other branches");
  app.listen(show);
  show("world");
  return h("section", { class: "history" }, h("h2", {}, "Events"), list, heading, branches);
}
