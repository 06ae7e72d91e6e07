// The page: picture with tools, timeline, plots and readouts, panel, editor. Controls that need a world are disabled
// without one.
import { h } from "../panels/dom";
import { ownColoursSays, stageIn } from "../panels/stage_in";
import { tabs } from "../panels/tabs";
import { marked } from "../panels/timeline";
import { themeButton } from "../panels/theme_button";
import { watchTheme, type Theme } from "../viewer/colours";
import type { Model } from "../recording";
import { phaseAt } from "../viewer/frames";
import type { Stage } from "../viewer/stage";
import type { App } from "./app";
import { Blank } from "./blank";
import { Editor } from "./editor";
import { gallery } from "./gallery";
import { Hand, type Tool } from "./hand";
import { loadsOf } from "./loads";
import { happenings, jointControls, sliders } from "./panel";
import { Readings } from "./readings";
import { roomOf } from "./room";
import { fragmentOf, reachOf } from "./share";

const speeds = [0.02, 0.05, 0.1, 0.25, 0.5, 1, 2];
const tools: readonly { tool: Tool; label: string; key: string; says: string }[] = [
  { tool: "grab", label: "Grab", key: "g", says: "Drag a body and throw it" },
  { tool: "cut", label: "Cut", key: "c", says: "Click a joint: the bodies beyond it break off" },
  { tool: "lock", label: "Lock", key: "l", says: "Click a joint to lock or unlock it" },
  { tool: "weld", label: "Weld", key: "w", says: "Click two bodies to join them rigidly" },
];

export function showPlayground(page: HTMLElement, app: App) {
  let stage: Stage | null = null;
  let hand: Hand | null = null;
  let theme: Theme | null = null;
  let tool: Tool = "grab";
  let first = -1;
  let loads = true;
  let own = true;

  const title = h("h1", {}, "momentree playground");
  const choice = h("select", { "aria-label": "Scenario" });
  for (const { name, title: words } of gallery) choice.append(h("option", { value: name }, words));
  choice.append(h("option", { value: "" }, "(your own)"));
  choice.addEventListener("change", () => {
    const example = gallery.find(({ name }) => name === choice.value);
    if (example) start(example.text);
  });
  const shared = h("output", { class: "shared", "aria-live": "polite" });
  const share = h("button", { type: "button", title: "Copy a link that contains this scenario" }, "Share");
  share.addEventListener("click", async () => {
    location.hash = await fragmentOf(editor.text);
    const reach = reachOf(location);
    let says = "link copied";
    try {
      await navigator.clipboard.writeText(location.href);
    } catch {
      says = "the link is in the address bar";
    }
    shared.textContent = reach ? `${says}; ${reach}` : says;
  });

  const editor = new Editor(
    (text) => start(text),
    (text) => app.check(text),
  );
  const blank = new Blank();
  let source = "";
  /** `from`: description of the text, as the beginning of a sentence. */
  const start = (text: string, from = "The scenario") => {
    source = from;
    app.play(false);
    if (editor.text !== text) editor.text = text;
    choice.value = gallery.find((example) => example.text === text)?.name ?? "";
    app.load(text);
  };
  /** There is no scenario to show: gives the reason, and shows no other scenario instead. */
  const refuse = (says: string, other: string) => {
    if (app.run) return app.say(`${says} This is still “${app.run.model.title}”.`);
    const title = gallery.find(({ text }) => text === other)?.title ?? "the scenario of this page";
    choice.selectedIndex = -1;
    blank.show("No scenario", says, { label: `Open “${title}” instead`, go: () => start(other) });
  };
  app.onChecked = (diagnostics) => editor.mark(diagnostics);
  app.onDiagnostics = ({ diagnostics }) => {
    editor.show(diagnostics);
    if (!diagnostics.some(({ severity }) => severity === "error")) return;
    openTab("scenario");
    const way = "Correct them and press “Run this”, or choose another scenario from the list at the top.";
    blank.show(`${source} has errors`, `They are listed with their lines below the text. ${way}`);
  };

  const host = h("div", { class: "stage" });
  const toolButtons = tools.map((each) => {
    const button = h(
      "button",
      { type: "button", title: `${each.says} (${each.key.toUpperCase()})`, onclick: () => take(each.tool) },
      each.label,
    );
    return { ...each, button };
  });
  const loadButton = h(
    "button",
    { type: "button", title: "Colour joints by their load (F)", "aria-pressed": "true" },
    "Forces",
  );
  loadButton.addEventListener("click", () => {
    loads = !loads;
    loadButton.setAttribute("aria-pressed", String(loads));
    draw();
  });
  const fit = h(
    "button",
    { type: "button", title: "Show everything (A)", onclick: () => app.run && stage?.fit(app.run) },
    "Fit",
  );
  const colours = h("button", { type: "button", title: `${ownColoursSays} (O)`, "aria-pressed": "true" }, "Own colours");
  colours.addEventListener("click", () => {
    own = !own;
    colours.setAttribute("aria-pressed", String(own));
    if (stage) stage.ownColours = own;
  });
  const hint = h("p", { class: "hint" });
  const load = h("p", { class: "hint load" });
  const notice = h("p", { class: "notice", role: "status" });
  const take = (next: Tool) => {
    tool = next;
    first = -1;
    if (hand) hand.tool = next;
    for (const each of toolButtons) each.button.setAttribute("aria-pressed", String(each.tool === next));
    hint.textContent = tools.find((each) => each.tool === next)?.says ?? "";
  };
  const buttons = h(
    "div",
    { class: "tools", role: "group", "aria-label": "Tools" },
    ...toolButtons.map(({ button }) => button),
  );
  const over = h("div", { class: "over" }, buttons, h("div", { class: "tools" }, loadButton, colours, fit));
  host.append(over, h("div", { class: "below" }, notice, load, hint), blank.element);

  const play = h("button", { class: "play", type: "button", "aria-label": "Play", onclick: () => app.toggle() });
  const slider = h("input", { type: "range", min: 0, max: 1, step: "any", value: 1, "aria-label": "Time" });
  slider.addEventListener("input", () => app.look(Number(slider.value)));
  const marks = h("div", { class: "marks" });
  const clock = h("output", { class: "clock" });
  const pace = h("select", { "aria-label": "Speed", title: "Speed", onchange: () => app.speed(Number(pace.value)) });
  for (const speed of speeds) pace.append(h("option", { value: speed, selected: speed === 1 }, `${speed}×`));
  const again = h(
    "button",
    { type: "button", title: "From the start (R)", onclick: () => start(app.text || editor.text) },
    "⟲",
  );
  const timeline = h(
    "div",
    { class: "timeline", role: "group", "aria-label": "Timeline" },
    play,
    again,
    h("div", { class: "line" }, marks, slider),
    clock,
    pace,
  );

  const readings = new Readings();
  const panel = h("div", { class: "controls" }, jointControls(app), sliders(app), happenings(app));
  const side = tabs("What to do", [
    { name: "Play", content: panel },
    { name: "Scenario", content: editor.element },
  ]);
  for (const part of [over, timeline, panel]) part.inert = true;
  hint.hidden = true;
  const openTab = (name: string) => side.querySelector<HTMLElement>(`#panel-${name}-tab`)?.click();

  page.append(
    h("header", {}, title, choice, share, shared, h("span", { class: "gap" }), themeButton()),
    h("section", { class: "picture", "aria-label": "Picture" }, host, timeline),
    readings.element,
    side,
  );

  const scene = {
    poses: () => app.run!.poses(app.frame),
    phase: () => phaseAt(app.run!, app.run!.time(app.frame)),
  };
  const jointOf = (child: number) => app.topology?.joints.find((joint) => joint.child === child);
  const wishes = {
    grab: (body: number, point: readonly [number, number, number], target: readonly [number, number, number]) => {
      if (app.looking !== null) app.goOnFrom(app.run!.time(app.frame));
      app.send({ say: "grab", body, point, target });
      if (!app.playing) app.play(true);
    },
    pull: (target: readonly [number, number, number]) => app.send({ say: "pull", target }),
    letGo: () => app.send({ say: "let go" }),
    joint: (child: number) => {
      const joint = jointOf(child);
      if (!joint || joint.kind === "free") return app.say("There is no joint to cut here");
      if (tool === "cut") app.act({ do: "cut", joint: joint.number });
      else app.act({ do: joint.locked ? "unlock" : "lock", joint: joint.number });
    },
    body: (body: number) => {
      const names = app.run!.model.bodies;
      if (first < 0 || first === body) {
        first = body;
        hint.textContent = `${names[body].name} to …: click another body`;
      } else {
        app.act({ do: "weld", body: first, to: body });
        take("weld");
      }
    },
  };

  function showWorld(model: Model) {
    stage?.dispose();
    for (const words of host.querySelectorAll(".instead")) words.remove();
    for (const part of [over, timeline, panel]) part.inert = false;
    stage = stageIn(host, model, [
      "The simulation, the plots and the panel work without it: joints can be cut and locked by name.",
    ]);
    hand = stage && new Hand(stage, scene, wishes);
    over.hidden = hint.hidden = stage === null;
    if (!stage) return;
    take(tool);
    stage.canvas.tabIndex = 0;
    stage.canvas.setAttribute("role", "img");
    stage.canvas.setAttribute("aria-label", `${model.title}: the mechanisms in 3D`);
    stage.ownColours = own;
    colours.hidden = !stage.shapes.coloured;
    if (theme) stage.setTheme(theme);
    look();
  }

  function look() {
    if (app.run && stage) stage.lookAt(roomOf(app.run, app.frame, (body) => stage!.shapes.reach(body)));
  }

  function draw() {
    const { run } = app;
    if (!run) return;
    const frame = run.frame(app.frame);
    const carried = loads ? loadsOf(frame, run.topology) : null;
    if (stage) {
      stage.mechanisms.colourJoints(carried?.colours ?? new Map());
      stage.mechanisms.highlighted = first;
      stage.show(frame.poses, phaseAt(run, frame.time));
    }
    hand?.show();
    load.textContent = carried?.says ?? "";
    const end = run.time(run.frames - 1);
    slider.max = String(Math.max(end, 1e-3));
    slider.value = String(frame.time);
    slider.setAttribute("aria-valuetext", `${frame.time.toFixed(2)} s`);
    clock.textContent = `${frame.time.toFixed(2)} s`;
  }

  function drawMarks() {
    const { run } = app;
    if (!run) return;
    const end = Math.max(run.time(run.frames - 1), 1e-3);
    marks.replaceChildren(
      ...marked(run.events, 0, end).map((index) => {
        const event = run.events[index];
        const says = `${event.time.toFixed(3)} s: ${event.actions.join("; ")}`;
        const mark = h("button", { type: "button", title: says, "aria-label": says, onclick: () => app.look(event.time) });
        mark.style.left = `${(100 * event.time) / end}%`;
        return mark;
      }),
    );
  }

  app.listen((changed) => {
    if (changed === "world" && app.run) {
      showWorld(app.run.model);
      title.textContent = app.run.model.title || "momentree playground";
      document.title = `${title.textContent} – momentree`;
    }
    if (!app.run && app.notice) blank.show("Nothing to show", app.notice);
    notice.textContent = app.run ? app.notice : "";
    play.setAttribute("aria-label", app.playing ? "Pause" : "Play");
    play.dataset.playing = String(app.playing);
    if (changed !== "status") draw();
    if (app.run) readings.show(app.run, app.frame, app.engineSeconds, changed !== "frame" || !app.playing);
    if (changed !== "status" && (changed !== "frame" || app.run!.events.length > 0)) drawMarks();
  });
  watchTheme((next) => {
    theme = next;
    stage?.setTheme(next);
    readings.setTheme(next);
    draw();
  });
  take("grab");

  document.addEventListener("keydown", (event) => {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || target.matches("textarea, select, input:not([type=range])")) return;
    if (!app.run) return;
    const found = stage && toolButtons.find(({ key }) => key === event.key.toLowerCase());
    if (found) take(found.tool);
    else if (event.key === " " && !target.matches("button")) app.toggle();
    else if (event.key.toLowerCase() === "r") again.click();
    else if (event.key.toLowerCase() === "f") loadButton.click();
    else if (event.key.toLowerCase() === "a") fit.click();
    else if (event.key.toLowerCase() === "o" && !colours.hidden) colours.click();
    else return;
    event.preventDefault();
  });

  return {
    start,
    refuse,
    // For programs that use the playground: position of a joint in the page.
    placeOf: (child: number) => {
      const link = scene.phase().links.find((each) => each.child === child);
      return link && hand ? hand.placeOf(link) : null;
    },
  };
}
