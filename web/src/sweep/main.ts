// The report of a sweep: reads the document in the page and shows it.
import "../panels/styles/base.css";
import "../panels/styles/parts.css";
import "../panels/styles/help.css";
import "./style.css";
import "./plots/plots.css";
import "./worlds.css";
import "../panels/styles/fingers.css";
import { h } from "../panels/dom";
import { showSweep } from "./page";
import { sweepOf } from "./read";

const page = document.getElementById("page")!;

/** The document in the page; null if it contains none. Throws if it is damaged. */
function documentIn(): unknown {
  const text = document.getElementById("sweep")?.textContent;
  if (text === undefined || text === null) throw new Error("the file is cut off");
  try {
    return JSON.parse(text.trim() || "null");
  } catch {
    throw new Error("its data are damaged, or the file is cut off");
  }
}

try {
  const data = documentIn();
  if (data !== null) showSweep(page, sweepOf(data));
  else
    page.append(
      h("p", { class: "nothing" }, "This page contains no sweep: `momentree sweep SWEEP.toml --report` writes one that does."),
    );
} catch (error) {
  const text = error instanceof Error ? error.message : String(error);
  page.replaceChildren(h("p", { class: "nothing", role: "alert" }, `The sweep can't be shown: ${text}.`));
  throw error;
}
