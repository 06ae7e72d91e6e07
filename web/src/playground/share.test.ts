import { describe, expect, it } from "vitest";
import { fragmentOf, textOf } from "./share";

describe("a link", () => {
  it("holds any text", async () => {
    for (const text of ["", 'title = "Größe ≤ 3"\n', "x".repeat(100_000)])
      expect(await textOf(await fragmentOf(text))).toBe(text);
    expect((await fragmentOf("x".repeat(100_000))).length).toBeLessThan(400);
  });
  it("is nothing where there is none, or none of ours", async () => {
    for (const fragment of ["", "#", "#t=3", "#s=", "#s=!!", "#s=AAAA"]) expect(await textOf(fragment)).toBeNull();
  });
});
