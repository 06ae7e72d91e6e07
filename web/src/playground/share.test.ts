import { deflateSync } from "node:zlib";
import { describe, expect, it } from "vitest";
import { fragmentOf, linkOf, reachOf } from "./share";

describe("a link", () => {
  it("holds any text", async () => {
    for (const text of ["", 'title = "Größe ≤ 3"\n', "x".repeat(100_000)])
      expect(await linkOf(await fragmentOf(text))).toEqual({ holds: "scenario", text });
    expect((await fragmentOf("x".repeat(100_000))).length).toBeLessThan(400);
  });

  it("holds nothing where there is none, and what a sentence leaves at its end does no harm", async () => {
    for (const fragment of ["", "#"]) expect(await linkOf(fragment)).toEqual({ holds: "nothing" });
    expect(await linkOf(`${await fragmentOf("a")}).`)).toEqual({ holds: "scenario", text: "a" });
  });

  it("that is damaged says so, wherever it is", async () => {
    const whole = await fragmentOf('format = 1\ntitle = "A pendulum"\n');
    const others = ["#t=3", "#s", "#s=", "#s=!!", "#s=AAAA", "#S=AAAA", `${whole}%20x`];
    for (let at = 3; at < whole.length; at++) {
      others.push(whole.slice(0, at));
      others.push(`${whole.slice(0, at)}${whole[at] === "k" ? "V" : "k"}${whole.slice(at + 1)}`);
    }
    for (const fragment of others) {
      const link = await linkOf(fragment);
      // The last base64 digit may have unused bits.
      if (link.holds === "scenario") expect(link.text).toBe('format = 1\ntitle = "A pendulum"\n');
      else expect(link, fragment).toMatchObject({ holds: "error", message: expect.stringContaining("Ask for it again") });
    }
  });

  it("of a newer version says that, and one that inflates without end is given up", async () => {
    expect(await linkOf("#s2=AAAA")).toMatchObject({ holds: "error", message: expect.stringContaining("newer version") });
    const bomb = deflateSync(Buffer.alloc(40_000_000)).toString("base64url");
    expect(await linkOf(`#s=${bomb}`)).toMatchObject({ holds: "error" });
  });

  it("says where it opens", () => {
    expect(reachOf({ protocol: "https:", hostname: "example.org" })).toBe("");
    expect(reachOf({ protocol: "file:", hostname: "" })).toContain("this file");
    expect(reachOf({ protocol: "http:", hostname: "127.0.0.1" })).toContain("this machine");
  });
});
