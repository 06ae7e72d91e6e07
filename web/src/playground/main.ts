// The playground's page: takes a scenario that it was handed, that its address holds, or the first of the gallery.
import packedModule from "../../engine/momentree.wasm?packed";
import EngineWorker from "../engine/worker?worker&inline";
import "../panels/base.css";
import "../panels/parts.css";
import "./style.css";
import { App } from "./app";
import { gallery } from "./gallery";
import { showPlayground } from "./page";
import { bytesOf, inflated, textOf } from "./share";

async function begin(page: HTMLElement) {
  const module = await inflated(bytesOf(packedModule));
  const app = new App(new EngineWorker(), module.buffer as ArrayBuffer);
  const playground = showPlayground(page, app);
  Object.assign(window, { playground: { app, placeOf: playground.placeOf } });
  const handed: unknown = JSON.parse(document.getElementById("scenario")?.textContent || "null");
  const open = async () =>
    playground.start((await textOf(location.hash)) ?? (typeof handed === "string" ? handed : gallery[0].text));
  window.addEventListener("hashchange", async () => {
    const text = await textOf(location.hash);
    if (text !== null && text !== app.text) playground.start(text);
  });
  await open();
}

begin(document.getElementById("page")!).catch((error: unknown) => {
  document.getElementById("page")!.textContent = `The playground needs WebAssembly and WebGL: ${String(error)}`;
});
