// Runs with contact in a real browser: the report of a bouncing box, and crates in the playground.
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Browser } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, test } from "vitest";
import {
  desktop,
  keep,
  launch,
  open,
  openReport,
  phone,
  phoneAcross,
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

const box = `format = 1
title = "A box lands"
[world]
floor = { friction = 0.4, restitution = 0.3 }
[[mechanism]]
name = "box"
root = "free"
pose = { xyz = [0, 0, 1] }
state = { velocity = { linear = [1, 0, 0], angular = [2, 3, -1] } }
[[mechanism.body]]
name = "box"
mass = 2
inertia = [0.03, 0.04, 0.05]
collision = { box = [0.4, 0.3, 0.2] }
[integrate]
method = "dop853"
until = 2
[output]
every = "10 ms"
`;
const written = () => {
  const file = join(temporary(), "box.toml");
  writeFileSync(file, box);
  return file;
};

test("a report groups the contacts of a bouncing box, and its impacts have certificates", async () => {
  const folder = report(written());
  const { page, complaints } = await openReport(browser, folder, desktop, 0.45);
  const events = page.getByRole("tabpanel").first();
  const lines = events.locator("ol.list > li");
  expect(await lines.count()).toBeGreaterThan(4);
  expect(await lines.count()).toBeLessThan(60);
  await expect.poll(() => lines.first().textContent()).toContain("impact: box/box and the ground");
  await lines.first().getByRole("button").click();
  await expect
    .poll(() => page.locator(".certificate").textContent())
    .toMatch(/box\/box and the ground at \(0\.3055.*Impulse: 8\.69/);
  const group = events.locator("details").first();
  await group.locator("summary").click();
  await expect.poll(() => group.getByRole("button").count()).toBeGreaterThan(1);
  await group.getByRole("button").nth(1).click();
  expect(await group.getByRole("button").nth(1).getAttribute("aria-pressed")).toBe("true");
  const marks = await page.locator(".marks button").count();
  expect(marks).toBeGreaterThan(4);
  expect(marks).toBeLessThan(130);
  expect(complaints).toEqual([]);
  await keep(page, "contact_report");
});

test.each([
  ["upright", phone],
  ["across", phoneAcross],
] as const)("a report with contact fits a phone held %s", async (name, view) => {
  const { page, complaints } = await openReport(browser, report(written()), view, 0.5);
  await settled(page);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  expect(complaints).toEqual([]);
  await keep(page, `contact_report_${name}`);
});

test("crates in the playground fall, and the list of events shows their impacts", async () => {
  const { page, complaints } = await open(browser, playgroundAddress, desktop);
  await page.waitForFunction(() => Boolean(window.playground?.app.run));
  await page.getByLabel("Scenario", { exact: true }).first().selectOption("hanging_boxes_fall");
  await page.waitForFunction(() => document.title.startsWith("Hanging crates"));
  await page.getByRole("button", { name: "Play", exact: true }).click();
  // The processor draws and computes: on a busy machine a second of the motion can take a minute.
  await expect
    .poll(() => page.getByRole("list", { name: "Events" }).textContent(), { timeout: 270_000 })
    .toMatch(/\d+ × impact/);
  expect(complaints).toEqual([]);
  await keep(page, "contact_playground");
}, 300_000);
