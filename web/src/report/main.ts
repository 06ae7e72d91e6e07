// The report of a run: reads the data in the page and shows them.
import "../panels/styles/base.css";
import "../panels/styles/parts.css";
import "../panels/styles/overlays.css";
import "../panels/styles/help.css";
import "./style.css";
import "../panels/styles/across.css";
import "../panels/styles/fingers.css";
import { h } from "../panels/dom";
import { recordingOf, type ReportData } from "./data";
import { showRun } from "./page";

const page = document.getElementById("page")!;

function notesOf(data: ReportData): string[] {
  const notes: string[] = [];
  if (data.thinned) notes.push("not every row is shown here");
  if (data.joints_left_out) notes.push("too many joints to plot here: see joints.csv");
  return notes;
}

/** `#t=1.9` opens at that time, paused; otherwise the run plays, unless the reader prefers reduced motion. */
function begin(data: ReportData) {
  const player = showRun(page, recordingOf(data), notesOf(data));
  const given = /^#t=([-+0-9.e]+)$/.exec(location.hash);
  if (given) player.seek(Number(given[1]));
  else if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) player.play();
}

/** The data in the page; null if it contains none. Throws if they are damaged. */
function dataIn(): ReportData | null {
  const text = document.getElementById("recording")?.textContent;
  if (text === undefined || text === null) throw new Error("the file is cut off");
  try {
    return JSON.parse(text.trim() || "null") as ReportData | null;
  } catch {
    throw new Error("its data are damaged, or the file is cut off");
  }
}

try {
  const data = dataIn();
  if (data) begin(data);
  else
    page.append(
      h("p", { class: "nothing" }, "This page contains no run: `momentree run SCENARIO --report` writes one that does."),
    );
} catch (error) {
  const text = error instanceof Error ? error.message : String(error);
  page.replaceChildren(h("p", { class: "nothing", role: "alert" }, `The run can't be shown: ${text}.`));
  throw error;
}
