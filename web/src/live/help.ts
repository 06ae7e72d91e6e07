// The help of the live view.
import type { HelpSection } from "../panels/help";
import { sections as playground } from "../playground/help";

export const about =
  "This page shows the simulation of a program that is running. Drag a body to throw it; break, lock and weld while it moves. " +
  "All of it happens in the program, between two of its steps.";

export const sections: readonly HelpSection[] = playground.map((section) =>
  section.title === "Time"
    ? {
        title: "Time",
        rows: [
          ["Space", "pause the program, or let it go on"],
          ["slider", "show an earlier moment; the program waits meanwhile"],
          ["speed", "of a program that runs in real time"],
          ["Stop", "ends the run"],
        ],
      }
    : section,
);
