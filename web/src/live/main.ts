// The page of a live view: the world of a program that is running on this machine.
import "../panels/styles/base.css";
import "../panels/styles/parts.css";
import "../panels/styles/overlays.css";
import "../panels/styles/help.css";
import "../playground/style.css";
import "../panels/styles/across.css";
import "../panels/styles/fingers.css";
import { RemoteEngine } from "../engine/remote";
import type { Meshes } from "../meshes";
import { h } from "../panels/dom";
import { App } from "../playground/app";
import { connections } from "../playground/connections";
import { history, jointControls, sliders, weldControls } from "../playground/panel";
import { showWorldPage } from "../playground/world_page";
import { about, sections } from "./help";
import { programSliders } from "./sliders";

const { meshes } = JSON.parse(document.getElementById("live")?.textContent || "{}") as { meshes?: Meshes };
const engine = new RemoteEngine(location.pathname);
const app = new App(engine, meshes, true);
const stop = h(
  "button",
  { type: "button", title: "End the run of the program", onclick: () => app.send({ type: "stop" }) },
  "Stop",
);
const state = h("output", { class: "shared", "aria-live": "polite" });
const world = showWorldPage(document.getElementById("page")!, app, {
  name: "momentree",
  header: [stop, state],
  about,
  help: sections,
  controls: [programSliders(app), jointControls(app), weldControls(app), connections(app), sliders(app), history(app)],
  tabs: [],
});
world.placeholder.show("Connecting", "Waiting for the program …");
engine.onlost = (lost) => {
  state.textContent = lost ? "The program has ended, or does not answer; this page keeps what it showed" : "live";
  stop.disabled = lost;
  app.end(lost);
  if (lost && !app.run) world.placeholder.show("No program", "The program that served this page has ended.");
};
Object.assign(window, { live: { app, placeOf: world.placeOf, frameRate: world.frameRate } });
