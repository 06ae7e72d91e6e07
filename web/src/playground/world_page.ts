// The part of a page that shows a world and acts on it: picture with tools, timeline, plots and readouts, panel. Controls
// that need a world are disabled without one.
import { h, isCovered } from "../panels/dom";
import { helpButton, type HelpSection } from "../panels/help";
import { mountStage, ownColoursTitle } from "../panels/mount_stage";
import { FrameRate } from "../panels/frame_rate";
import { Hover } from "../panels/hover";
import { Save } from "../panels/save";
import { Strays } from "../panels/strays";
import { tabs } from "../panels/tabs";
import { Timeline } from "../panels/timeline";
import { Vectors } from "../panels/vectors";
import { Impacts } from "../viewer/impacts";
import { themeButton } from "../panels/theme_button";
import { turnByKeys } from "../panels/turn_by_keys";
import { viewMenu } from "../panels/view_menu";
import { onThemeChange, type Theme } from "../viewer/colours";
import type { Model } from "../recording";
import { phaseAt } from "../viewer/frames";
import type { Stage } from "../viewer/stage";
import type { App } from "./app";
import { Placeholder } from "./placeholder";
import { PointerTools, type Tool } from "./pointer_tools";
import { forcesOf, loadColours } from "./load_colours";
import { Readings } from "./readings";
import { initialView } from "./initial_view";

const click = matchMedia("(pointer: coarse)").matches ? "Tap" : "Click";
const tools: readonly { tool: Tool; label: string; key: string; hint: string }[] = [
  { tool: "grab", label: "Grab", key: "g", hint: "Drag a body and throw it, or break a joint" },
  { tool: "break", label: "Break", key: "b", hint: `${click} a joint: its outboard bodies become a separate mechanism` },
  { tool: "lock", label: "Lock", key: "l", hint: `${click} a joint to lock or unlock it` },
  {
    tool: "weld",
    label: "Weld",
    key: "w",
    hint: `${click} two bodies to join them rigidly; two of one mechanism close a loop`,
  },
];

/** What differs between the pages that show a world. */
export interface Shell {
  /** Of the page, while the world has no title. */
  readonly name: string;
  /** The header names the world, so that the title need not. */
  readonly namesWorld?: boolean;
  /** Between the title and the buttons for help and colours. */
  readonly header: readonly HTMLElement[];
  readonly about: string;
  readonly help: readonly HelpSection[];
  /** The panel next to the picture. */
  readonly controls: readonly HTMLElement[];
  /** Tabs beside the panel. */
  readonly tabs: readonly { readonly name: string; readonly content: HTMLElement }[];
  /** A button next to that for playing. */
  readonly restart?: HTMLElement;
  /** A button beside the tools. */
  readonly tool?: { readonly button: HTMLElement; readonly key: string };
}

export function showWorldPage(page: HTMLElement, app: App, shell: Shell) {
  let stage: Stage | null = null;
  let pointer: PointerTools | null = null;
  let vectors: Vectors | null = null;
  let impacts: Impacts | null = null;
  let frameRate: FrameRate | null = null;
  let shownParts: HTMLElement[] = [];
  let theme: Theme | null = null;
  let tool: Tool = "grab";
  let first = -1;
  let acts = true;
  let loads = true;
  let own = true;

  const title = h("h1", {}, shell.name);
  const placeholder = new Placeholder();
  const host = h("div", { class: "stage" });
  const toolButtons = tools.map((each) => {
    const button = h(
      "button",
      { type: "button", title: `${each.hint} (${each.key.toUpperCase()})`, onclick: () => choose(each.tool) },
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
  const colours = h("button", { type: "button", title: `${ownColoursTitle} (O)`, "aria-pressed": "true" }, "Own colours");
  colours.addEventListener("click", () => {
    own = !own;
    colours.setAttribute("aria-pressed", String(own));
    if (stage) stage.ownColours = own;
  });
  let follows = true;
  const follow = h("button", { type: "button", title: "The camera follows what moves (M)", "aria-pressed": "true" }, "Follow");
  const showFollowing = (on: boolean) => {
    follows = on;
    follow.setAttribute("aria-pressed", String(on));
  };
  follow.addEventListener("click", () => {
    showFollowing(!follows);
    if (stage) stage.following = follows;
  });
  const arrows = h(
    "button",
    { type: "button", title: "Momenta of bodies, forces of joints and of contacts (V)", "aria-pressed": "false" },
    "Arrows",
  );
  arrows.addEventListener("click", () => {
    if (!vectors) return;
    vectors.visible = !vectors.visible;
    arrows.setAttribute("aria-pressed", String(vectors.visible));
    draw();
  });
  const save = new Save({
    stage: () => stage,
    title: () => app.run?.model.title ?? "",
    play: () => app.playing || app.play(true),
    ended: () => false,
    report: (message) => app.showNotice(message),
  });
  const hint = h("p", { class: "hint" });
  const load = h("p", { class: "hint load" });
  const notice = h("p", { class: "notice", role: "status" });
  const choose = (next: Tool) => {
    tool = next;
    first = -1;
    if (pointer) pointer.tool = next;
    if (stage) stage.mechanisms.showsJoints = next === "break" || next === "lock";
    draw();
    for (const each of toolButtons) each.button.setAttribute("aria-pressed", String(each.tool === next));
    hint.textContent = tools.find((each) => each.tool === next)?.hint ?? "";
  };
  const buttons = h(
    "div",
    { class: "tools", role: "group", "aria-label": "Tools" },
    ...toolButtons.map(({ button }) => button),
    ...(shell.tool ? [shell.tool.button] : []),
  );
  const menu = viewMenu(loadButton, colours, arrows, follow, fit, save.element);
  const over = h("div", { class: "over" }, buttons, menu.element);
  host.append(over, h("div", { class: "below" }, notice, load, hint), placeholder.element);

  const timeline = new Timeline(() => app.run, app, {
    speeds: [0.02, 0.05, 0.1, 0.25, 0.5, 1, 2],
    choose: (event) => app.seek(app.run!.events[event].time),
    shortest: 1,
    ...(shell.restart && { button: shell.restart }),
  });

  const readings = new Readings();
  const panel = h("div", { class: "controls" }, ...shell.controls);
  const side = tabs("What to do", [{ name: "Play", content: panel }, ...shell.tabs]);
  for (const part of [over, timeline.element, panel]) part.inert = true;
  hint.hidden = true;

  page.append(
    h("header", {}, title, ...shell.header, h("span", { class: "gap" }), helpButton(shell.about, shell.help), themeButton()),
    h("section", { class: "picture", "aria-label": "Picture" }, host, timeline.element),
    readings.element,
    side,
  );

  const scene = {
    poses: () => app.run!.poses(app.frame),
    phase: () => phaseAt(app.run!, app.run!.time(app.frame)),
  };
  const actions = {
    grab: (body: number, point: readonly [number, number, number], target: readonly [number, number, number]) => {
      if (app.shownFrame !== null) app.continueFrom(app.run!.time(app.frame));
      app.send({ type: "grab", body: app.run!.model.bodies[body].name, point, target });
      if (!app.playing) app.play(true);
    },
    pull: (target: readonly [number, number, number]) => app.send({ type: "pull", target }),
    release: () => app.send({ type: "release" }),
    joint: (name: string) => {
      const joint = app.topology?.joints.find((each) => each.name === name);
      if (!joint || joint.kind === "free") return app.showNotice("There is no joint here");
      app.chosenJoint = name;
      if (tool === "break") app.act({ break: name });
      else app.act({ [joint.locked ? "unlock" : "lock"]: name });
    },
    body: (body: number) => {
      const names = app.run!.model.bodies;
      if (first < 0 || first === body) {
        first = body;
        hint.textContent = `Click the body to which ${names[body].name} is to be welded`;
      } else {
        app.act({ weld: { body: names[first].name, to: names[body].name } });
        choose("weld");
      }
    },
  };

  function showWorld(model: Model) {
    stage?.dispose();
    for (const each of shownParts) each.remove();
    for (const each of host.querySelectorAll(".placeholder")) each.remove();
    for (const part of [over, timeline.element, panel]) part.inert = false;
    stage = mountStage(host, model, [
      "The simulation, the plots and the panel work without it: joints can be broken and locked by name.",
    ]);
    pointer = stage && new PointerTools(stage, scene, actions);
    over.hidden = stage === null;
    showActing();
    if (!stage) return;
    stage.roomAbove = menu.room;
    choose(tool);
    turnByKeys(stage);
    stage.canvas.setAttribute(
      "aria-label",
      `${model.title || "The scenario"}: the mechanisms in 3D. Arrow keys rotate the picture, plus and minus zoom.`,
    );
    stage.ownColours = own;
    stage.following = follows;
    stage.onFollowChange(showFollowing);
    const now = () => app.run && { poses: scene.poses(), phase: scene.phase(), names: app.run.mechanisms };
    const arrows = vectors?.visible ?? false;
    vectors = new Vectors(stage);
    impacts = new Impacts(stage);
    const counter = (frameRate = new FrameRate());
    stage.onDrawn = (began, ended) => counter.add(began, ended);
    vectors.visible = arrows;
    shownParts = [new Strays(stage, now).element, new Hover(stage, now).element, vectors.legend];
    host.append(...shownParts);
    colours.hidden = !stage.shapes.coloured;
    if (theme) stage.setTheme(theme);
    resetView();
  }

  /** Without its program a world only shows what happened. */
  function showActing() {
    acts = !app.ended;
    for (const { button } of toolButtons) button.disabled = app.ended;
    if (app.run) panel.inert = app.ended;
    hint.hidden = app.ended || stage === null;
    timeline.playable = !app.ended;
    if (pointer) pointer.enabled = !app.ended;
  }

  function resetView() {
    if (app.run && stage) stage.lookAt(initialView(app.run, app.frame, stage.shapes));
  }

  function draw() {
    const { run } = app;
    if (!run) return;
    const frame = run.frame(app.frame);
    const carried = loads ? loadColours(frame, run.topology) : null;
    if (stage) {
      stage.mechanisms.colourJoints(carried?.colours ?? new Map());
      stage.mechanisms.highlighted = first;
      stage.show(frame.poses, phaseAt(run, frame.time));
      impacts?.show(run, frame.time);
      vectors?.show(run, frame.time, frame.poses, forcesOf(frame, run.topology));
    }
    pointer?.show();
    load.textContent = carried?.text ?? "";
  }

  app.listen((changed) => {
    if (changed === "world" && app.run) {
      showWorld(app.run.model);
      const name = app.run.model.title || shell.name;
      if (!shell.namesWorld) title.textContent = name;
      document.title = `${name} – momentree`;
    }
    if (!app.run && app.notice) placeholder.show("Nothing to show", app.notice);
    const text = app.run ? app.notice : "";
    const noticed = text !== notice.textContent;
    notice.textContent = text;
    if (acts === app.ended) showActing();
    if (changed !== "status" || noticed) draw(); // labels at the edge make way for the notice
    if (app.run) readings.show(app.run, app.frame, changed !== "frame" || !app.playing);
  });
  onThemeChange((next) => {
    theme = next;
    stage?.setTheme(next);
    readings.setTheme(next);
    draw();
  });
  choose("grab");

  document.addEventListener("keydown", (event) => {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || target.matches("textarea, select, input:not([type=range])")) return;
    if (!app.run || isCovered()) return;
    const found = stage && !app.ended && toolButtons.find(({ key }) => key === event.key.toLowerCase());
    if (found) choose(found.tool);
    else if (event.key.toLowerCase() === shell.tool?.key) shell.tool.button.click();
    else if (event.key === " " && !target.matches("button")) app.toggle();
    else if (event.key.toLowerCase() === "r" && shell.restart) shell.restart.click();
    else if (event.key.toLowerCase() === "f") loadButton.click();
    else if (event.key.toLowerCase() === "p" && stage) save.savePicture();
    else if (event.key.toLowerCase() === "v") arrows.click();
    else if (event.key.toLowerCase() === "m") follow.click();
    else if (event.key.toLowerCase() === "a") fit.click();
    else if (event.key.toLowerCase() === "o" && !colours.hidden) colours.click();
    else return;
    event.preventDefault();
  });

  return {
    placeholder,
    openTab: (name: string) => side.querySelector<HTMLElement>(`#panel-${name}-tab`)?.click(),
    // For programs that use the page: position in it of a joint, by its name or as the inboard joint of a body.
    /** Frames per second of the picture, and the page's time for each (s). */
    frameRate: () => frameRate && { rate: frameRate.rate, duration: frameRate.duration },
    placeOf: (of: number | string) => {
      const joint = scene
        .phase()
        .joints.find((each) => (typeof of === "string" ? each.name === of : !each.loop && each.child === of));
      return joint && pointer ? pointer.placeOf(joint) : null;
    },
  };
}
