// The playground's page: opens the scenario that was passed to it, the one in its address, or the first of the gallery.
// If a model was passed to it, it shows sliders for the joints instead.
import packedModule from "../../engine/momentree.wasm?packed";
import packedMeshes from "../../gallery/meshes.json?packed";
import EngineWorker from "../engine/worker?worker&inline";
import "../panels/styles/base.css";
import "../panels/styles/parts.css";
import "../panels/styles/overlays.css";
import "../panels/styles/help.css";
import "./style.css";
import "../posing/style.css";
import "../panels/styles/across.css";
import "../panels/styles/fingers.css";
import { Engine } from "../../../wasm/host.mjs";
import { joined, type Meshes } from "../meshes";
import { h } from "../panels/dom";
import { showModel } from "../posing/page";
import { App } from "./app";
import { gallery } from "./gallery";
import { showPlayground } from "./page";
import { bytesOf, inflated, linkOf, textAt, type Link } from "./share";

/** What the page is given: a model, or a scenario, with the meshes that it names. */
interface Content {
  model?: string;
  scenario?: string;
  meshes?: Meshes;
}

async function begin(page: HTMLElement) {
  if (typeof WebAssembly === "undefined" || typeof DecompressionStream === "undefined")
    throw new Error("this browser has no WebAssembly, or can't inflate data");
  const module = (await inflated(bytesOf(packedModule))).buffer as ArrayBuffer;
  const content = JSON.parse(document.getElementById("scenario")?.textContent || "null") as string | Content | null;
  const { model, scenario, meshes }: Content = typeof content === "string" ? { scenario: content } : (content ?? {});
  if (model !== undefined) return showModel(page, await Engine.of(module), model, meshes);
  const worker = new EngineWorker();
  // Of the gallery; links to its scenarios, and changed ones, name them, too.
  const known = JSON.parse(new TextDecoder().decode(await inflated(bytesOf(packedMeshes)))) as Meshes;
  const app = new App(worker, joined(meshes, known));
  worker.onerror = (event) => app.showNotice(`The engine can't start: ${event.message || "its worker is blocked"}`);
  worker.postMessage({ type: "module", bytes: module }, [module]);
  const playground = showPlayground(page, app);
  Object.assign(window, { playground: { app, placeOf: playground.placeOf, frameRate: playground.frameRate } });
  const own = scenario ?? gallery[0].text;
  /** Opens the scenario that the page's address gives, and nothing else in its place. */
  const open = async (link: Link) => {
    const fail = (message: string) => playground.showProblem(message, own);
    if (link.content === "error") fail(link.message);
    else if (link.content === "scenario") playground.start(link.text, { from: "The scenario in this link", floor: link.floor });
    else if (link.content === "name") {
      const example = gallery.find(({ name }) => name === link.name);
      if (example) playground.start(example.text);
      else fail(`The gallery has no scenario “${link.name}”.`);
    } else if (link.content === "address") {
      try {
        playground.start(await textAt(link.address, location.href), { from: "The scenario at this address" });
      } catch (error) {
        const reason = error instanceof TypeError ? "its server can't be reached, or does not allow it (CORS)" : String(error);
        fail(`The scenario at ${link.address} can't be loaded: ${reason.replace(/^Error: /, "")}.`);
      }
    }
  };
  window.addEventListener("hashchange", async () => {
    const link = await linkOf(location.hash);
    if (link.content !== "scenario" || link.text !== app.text || link.floor !== app.floor) await open(link);
  });
  const first = await linkOf(location.hash);
  if (first.content === "nothing") playground.start(own);
  else await open(first);
}

begin(document.getElementById("page")!).catch((error: unknown) => {
  const text = error instanceof Error ? error.message : String(error);
  document
    .getElementById("page")!
    .replaceChildren(
      h("p", { class: "nothing", role: "alert" }, `The playground can't start: ${text}.`),
      h("p", { class: "nothing" }, "It needs Chromium 111, Firefox 114, Safari 16.4 or later, with WebAssembly."),
    );
});
