// The page: picture with its tools, timeline, plots and readouts, panel, editor.
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
import { tabs } from "../panels/tabs";
import { themeButton } from "../panels/theme_button";
import { watchTheme, type Theme } from "../viewer/colours";
import { phaseAt } from "../viewer/frames";
import { Stage } from "../viewer/stage";
import type { App } from "./app";
import { Chart } from "./chart";
import { Editor } from "./editor";
import { gallery } from "./gallery";
import { Hand, type Tool } from "./hand";
import { loadsOf } from "./loads";
import { happenings, jointControls, sliders } from "./panel";
import { roomOf } from "./room";
import { fragmentOf } from "./share";

const speeds = [0.02, 0.05, 0.1, 0.25, 0.5, 1, 2];
const tools: readonly { tool: Tool; label: string; key: string; says: string }[] = [
  { tool: "grab", label: "Grab", key: "g", says: "Drag a body and throw it" },
  { tool: "cut", label: "Cut", key: "c", says: "Click a joint: what hangs on it flies off" },
  { tool: "lock", label: "Lock", key: "l", says: "Click a joint to lock it, or to free it again" },
  { tool: "weld", label: "Weld", key: "w", says: "Click a body, then another: they become one" },
];

export function showPlayground(page: HTMLElement, app: App) {
  let stage: Stage | null = null;
  let hand: Hand | null = null;
  let theme: Theme | null = null;
  let tool: Tool = "grab";
  let first = -1;
  let loads = true;

  const title = h("h1", {}, "momentree playground");
  const choice = h("select", { "aria-label": "Scenario" });
  for (const { name, title: words } of gallery) choice.append(h("option", { value: name }, words));
  choice.append(h("option", { value: "" }, "(your own)"));
  choice.addEventListener("change", () => {
    const example = gallery.find(({ name }) => name === choice.value);
    if (example) start(example.text);
  });
  const shared = h("output", { class: "shared", "aria-live": "polite" });
  const share = h("button", { type: "button", title: "A link that holds this scenario" }, "Share");
  share.addEventListener("click", async () => {
    location.hash = await fragmentOf(editor.text);
    try {
      await navigator.clipboard.writeText(location.href);
      shared.textContent = "link copied";
    } catch {
      shared.textContent = "the link is in the address bar";
    }
  });

  const editor = new Editor(
    (text) => start(text),
    (text) => app.check(text),
  );
  const start = (text: string) => {
    app.play(false);
    if (editor.text !== text) editor.text = text;
    choice.value = gallery.find((example) => example.text === text)?.name ?? "";
    app.load(text);
  };
  app.onChecked = (diagnostics) => editor.mark(diagnostics);
  app.onDiagnostics = ({ diagnostics }) => {
    editor.show(diagnostics);
    if (diagnostics.some(({ severity }) => severity === "error")) openTab("scenario");
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
    { type: "button", title: "Joints in the colours of their load (F)", "aria-pressed": "true" },
    "Forces",
  );
  loadButton.addEventListener("click", () => {
    loads = !loads;
    loadButton.setAttribute("aria-pressed", String(loads));
    draw();
  });
  const fit = h(
    "button",
    { type: "button", title: "All in the picture (A)", onclick: () => app.run && stage?.fit(app.run) },
    "Fit",
  );
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
  host.append(
    h("div", { class: "over" }, buttons, h("div", { class: "tools" }, loadButton, fit)),
    h("div", { class: "below" }, notice, load, hint),
  );

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

  const energy = new Chart("Energy", "J", [
    { label: "kinetic", of: (t) => t.kinetic },
    { label: "potential", of: (t) => t.potential },
    { label: "total", of: (t) => t.kinetic + t.potential },
  ]);
  const momentum = new Chart("Momentum", "N s", [
    { label: "x", of: (t) => t.linear[0] },
    { label: "y", of: (t) => t.linear[1] },
    { label: "z", of: (t) => t.linear[2] },
  ]);
  const readout = h("dl", { class: "readout", "aria-label": "Momentum" });
  const plots = h("div", { class: "plots" }, energy.element, momentum.element, readout);
  const panel = h("div", { class: "controls" }, jointControls(app), sliders(app), happenings(app));
  const side = tabs("What to do", [
    { name: "Play", content: panel },
    { name: "Scenario", content: editor.element },
  ]);
  const openTab = (name: string) => side.querySelector<HTMLElement>(`#panel-${name}-tab`)?.click();

  page.append(
    h("header", {}, title, choice, share, shared, h("span", { class: "gap" }), themeButton()),
    h("section", { class: "picture", "aria-label": "Picture" }, host, timeline),
    plots,
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

  function look() {
    if (app.run && stage) stage.lookAt(roomOf(app.run, app.frame, (body) => stage!.shapes.reach(body)));
  }

  function draw() {
    const { run } = app;
    if (!run || !stage) return;
    const frame = run.frame(app.frame);
    const carried = loads ? loadsOf(frame, run.topology) : null;
    stage.mechanisms.colourJoints(carried?.colours ?? new Map());
    stage.mechanisms.highlighted = first;
    stage.show(frame.poses, phaseAt(run, frame.time));
    hand?.show();
    load.textContent = carried?.says ?? "";
    const end = run.time(run.frames - 1);
    slider.max = String(Math.max(end, 1e-3));
    slider.value = String(frame.time);
    slider.setAttribute("aria-valuetext", `${frame.time.toFixed(2)} s`);
    clock.textContent = `${frame.time.toFixed(2)} s`;
  }

  let drawnPlots = 0;
  function drawPlots(force = false) {
    const { run } = app;
    const now = performance.now();
    if (!run || (!force && now - drawnPlots < 120)) return;
    drawnPlots = now;
    energy.show(run, app.frame);
    momentum.show(run, app.frame);
    const { linear, angular, balance } = run.totals(app.frame);
    const vector = (v: readonly number[]) => v.map((x) => digits(Math.abs(x) < 1e-12 ? 0 : x, 5)).join("  ");
    const rows: [string, string][] = [
      ["Linear momentum (N s)", vector(linear)],
      ["Angular momentum (N m s)", vector(angular)],
      ["Energy balance, error (J)", digits(balance.error, 3)],
      ["Engine, per frame", `${(1000 * app.engineSeconds).toFixed(1)} ms`],
    ];
    readout.replaceChildren(...rows.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
    readout.dataset.linear = linear.join(" ");
    readout.dataset.angular = angular.join(" ");
    readout.dataset.time = String(run.time(app.frame));
  }

  function drawMarks() {
    const { run } = app;
    if (!run) return;
    const end = Math.max(run.time(run.frames - 1), 1e-3);
    marks.replaceChildren(
      ...run.events.slice(-60).map((event) => {
        const says = `${event.time.toFixed(3)} s: ${event.actions.join("; ")}`;
        const mark = h("button", { type: "button", title: says, "aria-label": says, onclick: () => app.look(event.time) });
        mark.style.left = `${(100 * event.time) / end}%`;
        return mark;
      }),
    );
  }

  app.listen((changed) => {
    if (changed === "world" && app.run) {
      stage?.dispose();
      stage = new Stage(host, app.run.model);
      hand = new Hand(stage, scene, wishes);
      take(tool);
      stage.canvas.tabIndex = 0;
      stage.canvas.setAttribute("role", "img");
      stage.canvas.setAttribute("aria-label", `${app.run.model.title}: the mechanisms in 3D`);
      if (theme) stage.setTheme(theme);
      look();
      title.textContent = app.run.model.title || "momentree playground";
      document.title = `${title.textContent} – momentree`;
    }
    notice.textContent = app.notice;
    play.setAttribute("aria-label", app.playing ? "Pause" : "Play");
    play.dataset.playing = String(app.playing);
    if (changed !== "status") draw();
    drawPlots(changed !== "frame" || !app.playing);
    if (changed !== "status" && (changed !== "frame" || app.run!.events.length > 0)) drawMarks();
  });
  watchTheme((next) => {
    theme = next;
    stage?.setTheme(next);
    energy.setTheme(next);
    momentum.setTheme(next);
    draw();
  });
  take("grab");

  document.addEventListener("keydown", (event) => {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || target.matches("textarea, select, input:not([type=range])")) return;
    const found = toolButtons.find(({ key }) => key === event.key.toLowerCase());
    if (found) take(found.tool);
    else if (event.key === " " && !target.matches("button")) app.toggle();
    else if (event.key.toLowerCase() === "r") again.click();
    else if (event.key.toLowerCase() === "f") loadButton.click();
    else if (event.key.toLowerCase() === "a") fit.click();
    else return;
    event.preventDefault();
  });

  return {
    start,
    // For those who write programs that play: where a joint is on the page.
    placeOf: (child: number) => {
      const link = scene.phase().links.find((each) => each.child === child);
      return link && hand ? hand.placeOf(link) : null;
    },
  };
}
