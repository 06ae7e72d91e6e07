// The help of the report of a sweep.
import type { HelpSection } from "../panels/help";

export const about =
  "The report of many runs, worlds, of a scenario whose parameters vary: how its measures are distributed, what they " +
  "depend on, and which worlds are the worst.";

export const sections: readonly HelpSection[] = [
  {
    title: "Distributions",
    rows: [
      ["click, drag", "mark the worlds of a bin or of several, in all plots and in the table"],
      ["← →, Enter", "choose a bin that has the focus, and mark its worlds"],
      ["least, greatest", "pick the world that has this value"],
      ["depends on", "plot the measure over this parameter"],
    ],
  },
  {
    title: "Relations",
    rows: [
      ["click a point", "pick its world"],
      ["drag", "mark the worlds in a rectangle, with a mouse or pen"],
      ["← → ↑ ↓", "pick the next world along an axis, if the plot has the focus"],
      ["Esc", "clear the marks"],
    ],
  },
  {
    title: "Worlds",
    rows: [
      ["click a head", "sort by that column; again: in the other direction"],
      ["↑ ↓", "pick the row above or below, if the table has the focus; also Page up, Page down, Home and End"],
      ["▶ Animation", "the report of the run of a world, if the sweep wrote it"],
      ["Copy", "the command that runs a world again"],
    ],
  },
];
