// Round numbers along an axis.
import { digits } from "../../panels/numbers";

export interface Ticks {
  readonly at: readonly number[];
  readonly labels: readonly string[];
}

/** At most about `most` ticks within these limits, a multiple of 1, 2 or 5 apart. */
export function ticksOf(low: number, high: number, most: number): Ticks {
  if (!(high > low)) return { at: [low], labels: [digits(low)] };
  const rough = (high - low) / Math.max(most, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((each) => each >= rough * (1 - 1e-9))!;
  const at: number[] = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) at.push(i * step);
  return { at, labels: at.map((value) => labelOf(value, step)) };
}

/** With the decimals that a step needs. */
function labelOf(value: number, step: number): string {
  if (Math.abs(value) < 1e-9 * step) return "0";
  const size = Math.max(Math.abs(value), step);
  const text =
    size >= 1e6 || step < 1e-5
      ? value.toExponential(
          Math.min(Math.max(Math.floor(Math.log10(size) + 1e-9) - Math.floor(Math.log10(step) + 1e-9), 0), 20),
        )
      : value.toFixed(Math.max(Math.ceil(-Math.log10(step) - 1e-9), 0));
  return text.replace("e+", "e").replaceAll("-", "−");
}
