import { deflateSync } from "node:zlib";
import { describe, expect, it } from "vitest";
import { fragmentOf, linkOf, scopeOf, textAt } from "./share";

describe("a link", () => {
  it("contains any text", async () => {
    for (const text of ["", 'title = "Größe ≤ 3"\n', "x".repeat(100_000)])
      expect(await linkOf(await fragmentOf(text))).toEqual({ content: "scenario", text, floor: false });
    expect((await fragmentOf("x".repeat(100_000))).length).toBeLessThan(400);
  });

  it("is empty without text; punctuation that follows it is ignored", async () => {
    for (const fragment of ["", "#"]) expect(await linkOf(fragment)).toEqual({ content: "nothing" });
    expect(await linkOf(`${await fragmentOf("a")}).`)).toEqual({ content: "scenario", text: "a", floor: false });
  });

  it("keeps the floor of the page", async () => {
    const fragment = await fragmentOf("a", true);
    expect(fragment).toMatch(/^#s1=/);
    expect(await linkOf(fragment)).toEqual({ content: "scenario", text: "a", floor: true });
  });

  it("that is damaged is reported, wherever the damage is", async () => {
    const whole = await fragmentOf('format = 1\ntitle = "A pendulum"\n');
    const others = ["#t=3", "#s", "#s=", "#s=!!", "#s=AAAA", "#S=AAAA", `${whole}%20x`];
    for (let at = 3; at < whole.length; at++) {
      others.push(whole.slice(0, at));
      others.push(`${whole.slice(0, at)}${whole[at] === "k" ? "V" : "k"}${whole.slice(at + 1)}`);
    }
    for (const fragment of others) {
      const link = await linkOf(fragment);
      // The last base64 digit may have unused bits.
      if (link.content === "scenario") expect(link.text).toBe('format = 1\ntitle = "A pendulum"\n');
      else expect(link, fragment).toMatchObject({ content: "error", message: expect.stringContaining("Ask for it again") });
    }
  });

  it("names a scenario of the gallery, or the address of a file", async () => {
    expect(await linkOf("#scenario=crane")).toEqual({ content: "name", name: "crane" });
    expect(await linkOf("#url=https%3A%2F%2Fexample.org%2Fa.toml")).toEqual({
      content: "address",
      address: "https://example.org/a.toml",
    });
    await expect(textAt("file:///a.toml", "https://example.org/")).rejects.toThrow("https://");
  });

  it("of a newer version is reported, and so is one that inflates to too much", async () => {
    expect(await linkOf("#s2=AAAA")).toMatchObject({ content: "error", message: expect.stringContaining("newer version") });
    const bomb = deflateSync(Buffer.alloc(40_000_000)).toString("base64url");
    expect(await linkOf(`#s=${bomb}`)).toMatchObject({ content: "error" });
  });

  it("has a description of where it can be opened", () => {
    expect(scopeOf({ protocol: "https:", hostname: "example.org" })).toBe("");
    expect(scopeOf({ protocol: "file:", hostname: "" })).toContain("this file");
    expect(scopeOf({ protocol: "http:", hostname: "127.0.0.1" })).toContain("this machine");
  });
});
