// The report of a run: reads the data in the page and shows them.
import { Player } from "../viewer/player";
import { endTime, phaseAt, posesAt, startTime } from "../viewer/frames";
import { Stage } from "../viewer/stage";
import { watchTheme } from "../viewer/colours";
import { recordingOf, type ReportData } from "./data";

const page = document.getElementById("page")!;
const data = JSON.parse(document.getElementById("recording")!.textContent ?? "null") as ReportData | null;
if (data === null) {
  page.textContent = "This page holds no run: `momentree run SCENARIO --report` writes one that does.";
} else {
  const run = recordingOf(data);
  const stage = new Stage(page, run.model);
  const player = new Player(() => [startTime(run), endTime(run)]);
  const poses = new Float64Array(7 * run.model.bodies.length);
  watchTheme((theme) => stage.setTheme(theme));
  player.listen((time) => stage.show(posesAt(run, time, poses), phaseAt(run, time)));
  stage.fit(run);
}
