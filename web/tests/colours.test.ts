// Colours of a body's own, which scenarios and model files give it, in all pages.
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, it } from "vitest";
import { fragmentOf } from "../src/playground/share";
import { mechanismColour, themeOf } from "../src/viewer/colours";
import {
  desktop,
  keep,
  launch,
  open,
  openReport,
  phone,
  pixelsLike,
  playgroundAddress,
  report,
  settled,
  temporary,
} from "./browser";

let browser: Browser;
beforeAll(async () => {
  browser = await launch();
});
afterAll(() => browser?.close());
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

const crane = `format = 1
title = "Painted crane"
[[mechanism]]
name = "crane"
[[mechanism.body]]
name = "jib"
mass = 50
com = [1, 0, 0]
inertia = [1, 10, 10]
shape = { box = [3, 0.4, 0.4], at = { xyz = [1.5, 0, 0] }, colour = "lime" }
joint = { kind = "revolute", axis = [0, 0, 1], at = { xyz = [0, 0, 4] } }
[[mechanism.body]]
name = "load"
mass = 20
com = [0, 0, -1]
inertia = [1, 1, 1]
shape = { sphere = 0.6, at = { xyz = [0, 0, -1] }, colour = "#ff00ff" }
joint = { kind = "ball", parent = "jib", at = { xyz = [3, 0, 0] }, damping = 0.5 }
[[event]]
at = 0.3
break = "crane/load"
[integrate]
step = 1e-2
until = 0.6
`;
const own = ["#00ff00", "#ff00ff"];

async function seen(page: Page, dark = false) {
  await settled(page);
  const theme = themeOf(dark);
  const counts = await pixelsLike(page, ".stage canvas", [...own, mechanismColour(theme, 0), mechanismColour(theme, 1)], 110);
  return { lime: counts[0], magenta: counts[1], first: counts[2], second: counts[3] };
}

it("a report shows them, outlines what detached, and can show mechanism colours instead", async () => {
  const file = join(temporary(), "crane.toml");
  writeFileSync(file, crane);
  const folder = report(file);
  for (const [view, themes] of [
    [desktop, [false, true]],
    [phone, [false]],
  ] as const) {
    const { page, complaints } = await openReport(browser, folder, view, 0.2);
    for (const key of ["g", "t"]) await page.keyboard.press(key); // without ghosts and trails
    for (const dark of themes) {
      await page.emulateMedia({ colorScheme: dark ? "dark" : "light" });
      await page.getByLabel("Time", { exact: true }).fill("330");
      const before = await seen(page, dark);
      expect(before.lime).toBeGreaterThan(500);
      expect(before.magenta).toBeGreaterThan(500);
      expect(before.second).toBeLessThan(20);
      await page.getByLabel("Time", { exact: true }).fill("660");
      const after = await seen(page, dark);
      expect(after.lime).toBeGreaterThan(500);
      expect(after.magenta).toBeGreaterThan(500);
      const outlined = after.second - before.second;
      expect(after.first - before.first).toBeLessThan(outlined / 2); // the heaviest has no outline
      expect(after.second).toBeGreaterThan(before.second + 100);
      await keep(page, `painted_${view.width}${dark ? "_dark" : ""}`);
      await page.keyboard.press("o");
      const button = page.locator("button", { hasText: "Own colours" });
      expect(await button.getAttribute("aria-pressed")).toBe("false");
      const mechanisms = await seen(page, dark);
      expect([mechanisms.lime, mechanisms.magenta]).toEqual([0, 0]);
      expect(mechanisms.second).toBeGreaterThan(500);
      await page.keyboard.press("o");
    }
    expect(complaints).toEqual([]);
  }
});

it("the playground shows them, too, and keeps the choice", async () => {
  const { page, complaints } = await open(browser, playgroundAddress + (await fragmentOf(crane)));
  await page.waitForFunction(() => Boolean(window.playground?.app.run));
  expect((await seen(page)).magenta).toBeGreaterThan(500);
  await page.getByRole("button", { name: "Own colours" }).click();
  expect((await seen(page)).magenta).toBe(0);
  const run = await page.evaluateHandle(() => window.playground.app.run);
  await page.getByRole("button", { name: "⟲" }).click();
  await page.waitForFunction((before) => window.playground.app.run !== before, run);
  expect((await seen(page)).magenta).toBe(0);
  await page.keyboard.press("o");
  expect((await seen(page)).magenta).toBeGreaterThan(500);
  await keep(page, "painted_playground");
  await page.getByLabel("Scenario", { exact: true }).first().selectOption("breaking_chain_accurate");
  await page.waitForFunction(() => document.title.startsWith("Breaking chain"));
  expect(await page.getByRole("button", { name: "Own colours" }).isVisible()).toBe(false);
  expect(complaints).toEqual([]);
});
