// Checked access to parsed JSON. An error names the place and what is there.

export type Json = Readonly<Record<string, unknown>>;

export function fail(where: string, what: string): never {
  throw new Error(`${where} ${what}`);
}

export function record(value: unknown, where: string): Json {
  if (typeof value !== "object" || value === null || Array.isArray(value)) fail(where, "is missing, or not an object");
  return value as Json;
}

export function list(value: unknown, where: string): readonly unknown[] {
  if (!Array.isArray(value)) fail(where, "is missing, or not a list");
  return value;
}

export const items = <T>(value: unknown, where: string, read: (item: Json, where: string) => T): T[] =>
  list(value, where).map((item, i) => read(record(item, `${where}[${i}]`), `${where}[${i}]`));

/** `otherwise` if it is missing or null. */
export function textOr(value: Json, key: string, where: string, otherwise: string): string {
  const text = value[key] ?? otherwise;
  return typeof text === "string" ? text : fail(`${where}: ${key}`, `is not a text: ${JSON.stringify(text)}`);
}

/** `otherwise` if it is missing or null. */
export function numberOr(value: Json, key: string, where: string, otherwise: number): number {
  const number = value[key] ?? otherwise;
  return typeof number === "number" ? number : fail(`${where}: ${key}`, `is not a number: ${JSON.stringify(number)}`);
}

/** `otherwise` if it is missing or null. */
export function oneOf<T extends string>(value: Json, key: string, where: string, of: readonly T[], otherwise: T): T {
  const text = value[key] ?? otherwise;
  return (
    of.find((each) => each === text) ??
    fail(`${where}: ${key}`, `is ${JSON.stringify(text)}, and not one of ${of.map((each) => `"${each}"`).join(", ")}`)
  );
}
