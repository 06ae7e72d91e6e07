// Colours of points by the values of a column: a scale for numbers, the colours of series for flags and texts. All
// stand out from the ground, and numbers more so the greater they are.
import { mechanismColour, mixed, type Theme } from "../../viewer/colours";
import type { Column } from "../document";

const lightStops = ["#c9711a", "#b0446e", "#5b2f86", "#14103f"];
const darkStops = ["#8468d6", "#d65d8b", "#f7a35c", "#fbe9a0"];

export const steps = 32;

/** The colour of a share of the range from least to greatest. */
export function scaleColour(theme: Theme, share: number): string {
  const stops = theme.dark ? darkStops : lightStops;
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const below = Math.min(Math.floor(at), stops.length - 2);
  return mixed(stops[below], stops[below + 1], at - below);
}

export interface PointColours {
  readonly palette: readonly string[];
  /** By row, an index into the palette; the last is for missing values. */
  readonly of: Uint8Array;
}

const missingColour = (theme: Theme) => (theme.dark ? "#7c8794" : "#84909d");

export function pointColours(theme: Theme, column: Column | null, rows: number): PointColours {
  if (!column) return { palette: [mechanismColour(theme, 0)], of: new Uint8Array(rows) };
  const numbers = column.kind === "number";
  const kinds = numbers ? steps : Math.min(Math.max(column.labels.length, 1), theme.mechanisms.length);
  const palette = Array.from({ length: kinds }, (_none, i) =>
    numbers ? scaleColour(theme, i / (steps - 1)) : mechanismColour(theme, i),
  );
  const { least, greatest } = column;
  const of = Uint8Array.from(column.values, (value) => {
    if (!Number.isFinite(value)) return kinds;
    if (!numbers) return value % kinds;
    return greatest > least ? Math.round(Math.min(Math.max((value - least) / (greatest - least), 0), 1) * (steps - 1)) : 0;
  });
  return { palette: [...palette, missingColour(theme)], of };
}
