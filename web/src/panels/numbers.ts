// Number formatting for readers: few digits, and suitable units.

/** A few digits, without needless zeros; powers of ten for very large or small numbers. */
export function digits(value: number, count = 4): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e5 && size >= 10 ** count - 0.5) return value.toFixed(0).replace("-", "−"); // 3000, not 3e3
  const text = size >= 1e5 || size < 1e-3 ? value.toExponential(Math.max(count - 2, 1)) : value.toPrecision(count);
  const [mantissa, power] = text.split("e");
  const short = mantissa.includes(".") ? mantissa.replace(/\.?0+$/, "") : mantissa;
  return (power === undefined ? short : `${short}e${Number(power)}`).replace("-", "−").replace("e-", "e−");
}

/** "41.2 ms". */
export function duration(seconds: number): string {
  const size = Math.abs(seconds);
  if (size === 0) return "0 s";
  if (size >= 1) return `${digits(seconds, 3)} s`;
  if (size >= 1e-3) return `${digits(seconds * 1e3, 3)} ms`;
  if (size >= 1e-6) return `${digits(seconds * 1e6, 3)} µs`;
  return `${digits(seconds * 1e9, 3)} ns`;
}

/** A time of the run, with as many decimals as `span` needs. */
export function instant(seconds: number, span: number): string {
  const decimals = span > 0 ? Math.min(Math.max(Math.ceil(2 - Math.log10(span)) + 1, 2), 9) : 3;
  return `${seconds.toFixed(decimals).replace("-", "−")} s`;
}

/** "1 body", "3 bodies". */
export const count = (number: number, one: string, many: string) => `${number} ${number === 1 ? one : many}`;
