// The playground's help.
import { viewRows, type HelpSection } from "../panels/help";

export const about =
  "The mechanisms in the picture are simulated in this page. Drag a body to throw it; break, lock and weld while they move. " +
  "With a floor below them they land on it. " +
  "The plots show what that does to energy and momentum.";

export const sections: readonly HelpSection[] = [
  {
    title: "Tools",
    rows: [
      ["G", "Grab: drag a body, release it while it moves to throw it"],
      ["B", "Break: click a joint; what is beyond it detaches"],
      ["L", "Lock: click a joint to lock it, and again to unlock it"],
      ["W", "Weld: click two bodies; two of one mechanism close a loop"],
      ["D", "Floor: the scenario starts again above a floor, on which all bodies land"],
    ],
  },
  {
    title: "Time",
    rows: [
      ["Space", "play or pause"],
      ["R", "from the start"],
      ["slider", "show an earlier moment; playing from there starts a new branch"],
    ],
  },
  {
    title: "View",
    rows: [
      ...viewRows,
      ["M", "follow: the camera keeps what moves in the picture; pieces outside are named at its edge"],
      ["P", "save the picture; the menu Save also records a video"],
      ["A", "show everything"],
      ["V", "arrows: momenta of bodies, forces of joints and of contacts"],
      ["pointer on a body", "its name, mass and joint, and its frame"],
      ["F", "colour joints by their load"],
      ["O", "bodies in their own colours, or in those of their mechanisms"],
    ],
  },
];
