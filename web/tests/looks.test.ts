// What the picture tells beyond the shapes: shadows and a scale, names and frames on hover, arrows, and where the pieces
// are that left.
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, it } from "vitest";
import { mechanismColour, themeOf } from "../src/viewer/colours";
import {
  desktop,
  keep,
  launch,
  open,
  openReport,
  phoneAcross,
  pixelsLike,
  playgroundAddress,
  report,
  scenario,
  settled,
} from "./browser";

let browser: Browser;
let panda: string;
beforeAll(async () => {
  browser = await launch();
  panda = report(scenario("panda_lets_go.toml"), "--reactions");
});
afterAll(() => browser?.close());
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});
const patience = { timeout: 80_000 };
const light = themeOf(false);

async function playground(name: string, view = desktop): Promise<Page> {
  const { page } = await open(browser, `${playgroundAddress}#scenario=${name}`, view);
  await page.waitForFunction(() => Boolean(window.playground?.app.run));
  return page;
}

it("bodies without shapes are solid, and cast shadows on a floor that tells its scale", async () => {
  const iiwa = report(scenario("iiwa_falls_to_its_stops.toml"));
  const { page, complaints } = await openReport(browser, iiwa, desktop, 0.5);
  expect(await page.locator(".scale").innerText()).toMatch(/^1 square: [125]0* (mm|cm|m)$/);
  for (const name of ["Ghosts", "Trails"]) await page.getByRole("button", { name }).click();
  await settled(page);
  // A shadow is ink at 20 % on the ground; the robot covers more than lines would.
  const [shadow] = await pixelsLike(page, ".stage canvas", ["#c5c6c8"], 14);
  expect(shadow).toBeGreaterThan(400);
  const [robot] = await pixelsLike(page, ".stage canvas", [mechanismColour(light, 0)], 90);
  expect(robot).toBeGreaterThan(2500);
  await keep(page, "iiwa_solid");
  expect(complaints).toEqual([]);
});

it("meshes have their own colours, in reports and in the playground's gallery", async () => {
  const { page, complaints } = await openReport(browser, panda, desktop, 0.5);
  for (const name of ["Ghosts", "Trails"]) await page.getByRole("button", { name }).click();
  await settled(page);
  const [white, joints] = await pixelsLike(page, ".stage canvas", ["#e6e8ec", "#404040"], 14);
  expect(white).toBeGreaterThan(2000);
  expect(joints).toBeGreaterThan(50);
  expect(complaints).toEqual([]);

  const gallery = await playground("excavator_pin");
  await settled(gallery);
  const [yellow] = await pixelsLike(gallery, ".stage canvas", ["#c79330"], 30);
  expect(yellow).toBeGreaterThan(1500);
  await keep(gallery, "excavator");
});

it("arrows show momenta, and forces where the run recorded them", async () => {
  const { page, complaints } = await openReport(browser, panda, desktop, 1.3);
  for (const name of ["Ghosts", "Trails"]) await page.getByRole("button", { name }).click();
  const colours = [mechanismColour(light, 2), mechanismColour(light, 6)];
  await settled(page);
  expect(await pixelsLike(page, ".stage canvas", colours, 20)).toEqual([0, 0]);
  await page.keyboard.press("v");
  await settled(page);
  const [momentum, force] = await pixelsLike(page, ".stage canvas", colours, 20);
  expect(momentum).toBeGreaterThan(40);
  expect(force).toBeGreaterThan(40);
  expect(await page.locator(".vectors").innerText()).toMatch(/momentum, largest [\d.]+ N s\s+joint force, largest [\d.]+ N/);
  await keep(page, "panda_arrows");
  expect(complaints).toEqual([]);
});

it("the pointer on a body tells its name, mass and joint", async () => {
  const page = await playground("two_arms_hold_a_bar");
  const [a, b] = await page.evaluate(() => [window.playground.placeOf(0), window.playground.placeOf(1)]);
  await page.mouse.move((a.x + b.x) / 2, (a.y + b.y) / 2);
  const hover = page.locator(".hover");
  await expect
    .poll(() => hover.innerText(), patience)
    .toMatch(/left\/upper\s+4 kg, in left\s+revolute joint left\/shoulder to the ground/);
  await keep(page, "hover");
  const grip = await page.evaluate(() => {
    const [from, to] = [window.playground.placeOf("left/left grip"), window.playground.placeOf("right grip")];
    return { x: (from.x + to.x) / 2, y: (from.y + to.y) / 2 };
  });
  await page.mouse.move(grip.x, grip.y);
  await expect.poll(() => hover.innerText(), patience).toContain("revolute joint right grip closes a loop");
  await page.mouse.move(5, 5);
  await expect.poll(() => hover.isVisible(), patience).toBe(false);
});

it("no piece is lost: the camera follows, and pieces that are far away are named at the edge", async () => {
  for (const view of [desktop, { ...phoneAcross, scale: 1 }]) {
    const page = await playground("drop_the_load", view);
    await page.getByRole("button", { name: "Play", exact: true }).click();
    await page.waitForFunction(() => window.playground.app.run!.last.time > 2.8, undefined, patience);
    // All bodies are in the picture: what fell off, too.
    const box = (await page.locator(".stage canvas").boundingBox())!;
    const load = await page.evaluate(() =>
      window.playground.app.topology.joints.filter(({ kind }) => kind === "free").map(({ child }) => child),
    );
    expect(load.length).toBeGreaterThan(0);
    for (const body of load) {
      const at = await page.evaluate((n) => window.playground.placeOf(n), body);
      expect(at.x > box.x && at.x < box.x + box.width && at.y > box.y && at.y < box.y + box.height).toBe(true);
    }
    const stray = page.locator(".stray:visible");
    await stray.first().waitFor({ timeout: 150_000 });
    await page.getByRole("button", { name: "Pause", exact: true }).click();
    await expect.poll(() => stray.count(), patience).toBeGreaterThan(0);
    expect(await stray.first().innerText()).toMatch(/arm\/load|arm\/hook|.+, [\d.]+ k?m away/);
    await keep(page, `stray_${view.width}`);
    const place = (await stray.first().boundingBox())!;
    expect(place.x).toBeGreaterThanOrEqual(box.x - 1);
    expect(place.y + place.height).toBeLessThanOrEqual(box.y + box.height + 1);
    // A press looks there.
    await stray.first().click();
    await settled(page);
    const at = await page.evaluate((n) => window.playground.placeOf(n), load[0]);
    expect(Math.hypot(at.x - box.x - box.width / 2, at.y - box.y - box.height / 2)).toBeLessThan(0.5 * box.height);
  }
});

it("a zoom by the reader stays while the camera follows, and Fit ends it", async () => {
  const page = await playground("crane");
  const width = () =>
    page.evaluate(() => {
      const [a, b] = [window.playground.placeOf("crane/rail"), window.playground.placeOf("crane/rope3")];
      return Math.hypot(a.x - b.x, a.y - b.y);
    });
  const before = await width();
  const box = (await page.locator(".stage canvas").boundingBox())!;
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  for (let i = 0; i < 4; i++) await page.mouse.wheel(0, -400);
  await expect.poll(width, patience).toBeGreaterThan(1.6 * before);
  await page.getByRole("button", { name: "Play", exact: true }).click();
  await page.waitForFunction(() => window.playground.app.run!.last.time > 0.3, undefined, patience);
  await page.getByRole("button", { name: "Pause", exact: true }).click();
  expect(await width()).toBeGreaterThan(1.6 * before);
  expect(await page.getByRole("button", { name: "Follow" }).getAttribute("aria-pressed")).toBe("true");
  const zoomed = await width();
  await page.keyboard.press("a");
  await expect.poll(width, patience).toBeLessThan(0.9 * zoomed);
});
