// The page of a run: picture and clock, plots next to it, events and times below.
import type { Recording } from "../recording";
import { h } from "../panels/dom";
import { EventList } from "../panels/events";
import { helpButton, viewRows } from "../panels/help";
import { listenToKeys } from "../panels/keys";
import { count } from "../panels/numbers";
import { Picture, type Forces } from "../panels/picture";
import { Plots } from "../panels/plots";
import { statusLine } from "../panels/status";
import { summaryPanel } from "../panels/summary";
import { tabs } from "../panels/tabs";
import { themeButton } from "../panels/theme_button";
import { Timeline } from "../panels/timeline";
import { onThemeChange } from "../viewer/colours";
import { endTime, frameAt, inboardJoints, startTime } from "../viewer/frames";
import { Player } from "../viewer/player";

function subtitle(run: Recording, notes: readonly string[]): string {
  const { summary, model } = run;
  const parts = [count(model.bodies.length, "body", "bodies"), count(run.events.length, "event", "events")];
  if (summary?.method) parts.push(summary.method);
  return [...parts, ...notes].join(" · ");
}

/** For an incomplete run: the complete reason and remedy. */
function statusOf(run: Recording): HTMLElement | false {
  const status = run.summary ? run.summary.status : "it has no summary";
  return status !== "done" && statusLine({ class: "status", role: "alert" }, "This run is not complete: ", status);
}

/** Warnings about the results: an energy balance that does not close. */
const warningsOf = (run: Recording): HTMLElement[] =>
  (run.summary?.warnings ?? []).map((text) => statusLine({ class: "status warning", role: "note" }, "Warning: ", text));

const help = () =>
  helpButton("The report of one run: its motion, plots and events. Every event has a certificate of what it conserved.", [
    {
      title: "Time",
      rows: [
        ["Space", "play or pause"],
        ["← →", "the previous or next frame"],
        ["Shift ← →", "the previous or next event"],
        ["Home, End", "the start or the end"],
        ["click a plot", "go to that time"],
      ],
    },
    {
      title: "View",
      rows: [
        ...viewRows,
        ["click a body", "show its path, and its joint in the plots"],
        ["M", "follow: the camera keeps what moves in the picture"],
        ["P", "save the picture; the menu Save also records a video of the run"],
        ["F", "show the whole motion"],
        ["G, T", "earlier poses; paths"],
        ["V", "arrows: momenta of bodies, forces of joints and of contacts"],
        ["pointer on a body", "its name, mass and joint, and its frame"],
        ["O", "bodies in their own colours, or in those of their mechanisms"],
      ],
    },
  ]);

/** Forces of joints, as the run recorded them. */
function forcesOf(run: Recording): Forces {
  const columns = new Map(run.joints.map((name) => [name, run.joint(name, "force")]));
  return (time) => {
    const frame = frameAt(run, time);
    return ({ name }) => {
      const force = columns.get(name);
      return force?.length === 3 ? force.map(({ values }) => values[frame]) : null;
    };
  };
}

/** `notes`: remarks for the reader about the data. */
export function showRun(page: HTMLElement, run: Recording, notes: readonly string[] = []): Player {
  const title = run.model.title || run.summary?.scenario?.name || "A run";
  document.title = `${title} – momentree`;
  const player = new Player(() => [startTime(run), endTime(run)]);
  page.append(
    h(
      "header",
      {},
      h("h1", {}, title),
      h("p", {}, subtitle(run, notes)),
      help(),
      themeButton(),
      statusOf(run),
      ...warningsOf(run),
    ),
  );

  const plots = new Plots(run, player);
  const jointOf = inboardJoints(run.model.joints);
  const picture = new Picture(run, player, (body) => plots.chooseJoint(jointOf.get(body)?.name ?? ""), {
    forces: forcesOf(run),
    alternatives: [
      "Plots, events and tables work without it. ",
      h("code", {}, "momentree view DIR --svg FILE"),
      " draws a result without a browser.",
    ],
  });
  const events = new EventList(run, picture.stage, player);
  const timeline = new Timeline(() => run, player, {
    speeds: [0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 5],
    choose: (event) => events.choose(event),
  });
  picture.element.append(timeline.element);
  const panels = [
    { name: `Events (${run.events.length})`, content: events.element },
    { name: "Times and energy", content: summaryPanel(run) },
  ];
  page.append(picture.element, plots.element, tabs("About the run", panels));
  onThemeChange((theme) => {
    picture.setTheme(theme);
    plots.setTheme(theme);
    events.show();
  });
  picture.stage?.onContextChange((lost) => lost || events.show());
  picture.fit();
  listenToKeys(run, player, picture.keys, events);

  let last = 0;
  const tick = (now: number) => {
    player.advance(Math.min((now - last) / 1000, 0.1));
    last = now;
    requestAnimationFrame(tick);
  };
  requestAnimationFrame((now) => {
    last = now;
    requestAnimationFrame(tick);
  });
  return player;
}
