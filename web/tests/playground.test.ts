// The playground in a real browser: what a reader does to a mechanism, and what the momenta say of it.
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, test } from "vitest";
import { desktop, keep, launch, open, phone, playgroundAddress as address, type Opened, type View } from "./browser";

let browser: Browser;
beforeAll(async () => {
  browser = await launch();
});
afterAll(() => browser?.close());
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});
/** Machines that draw by the processor, while they do other things, take their time. */
const patience = { timeout: 80_000 };

const three = `format = 1
title = "Three links"
[world]
gravity = [0, -9.81, 0]
[[mechanism]]
name = "arm"
[mechanism.chain]
links = 3
length = 0.4
mass = 0.5
inertia = 0.007
angle = "20 deg"
`;

async function playground(view: View = desktop, fragment = ""): Promise<Opened> {
  const opened = await open(browser, address + fragment, view);
  await opened.page.waitForFunction(() => Boolean(window.playground?.app.run));
  return opened;
}

/** Loads a text by the editor and goes back to the tools. */
async function load(page: Page, text: string) {
  await page.getByRole("tab", { name: "Scenario" }).click();
  await page.getByRole("textbox", { name: "Scenario (TOML)" }).fill(text);
  await page.getByRole("button", { name: "Run this" }).click();
  await page.waitForFunction(() => document.title.startsWith("Three links"));
  await page.getByRole("tab", { name: "Play" }).click();
}

async function playTo(page: Page, time: number) {
  await page.getByRole("button", { name: "Play", exact: true }).click();
  await page.waitForFunction((t) => window.playground.app.run!.last.time >= t, time);
  await page.getByRole("button", { name: "Pause", exact: true }).click();
  await still(page);
}

/** Until the worker has nothing more to say. */
async function still(page: Page) {
  let time = -1;
  for (;;) {
    const now = await page.evaluate(() => window.playground.app.run!.last.time);
    if (now === time) return;
    time = now;
    await page.waitForTimeout(80);
  }
}

const totals = (page: Page) => page.evaluate(() => window.playground.app.run!.last.totals);
const clickJoint = async (page: Page, child: number) => {
  const at = await page.evaluate((number) => window.playground.placeOf(number), child);
  await page.mouse.click(at.x, at.y);
};
const size = (v: number[]) => Math.hypot(...v);
const apart = (a: number[], b: number[]) => size(a.map((x, i) => x - b[i]));

test("a click on a joint cuts it, and no momentum jumps", async () => {
  const { page, complaints } = await playground();
  await load(page, three);
  await playTo(page, 0.3);
  const before = await totals(page);
  const readout = await page.getByLabel("Momentum", { exact: true }).innerText();
  await page.keyboard.press("b");
  await clickJoint(page, 1);
  await page.waitForFunction(() => window.playground.app.topology.mechanisms.length === 2);
  const after = await totals(page);
  expect(size(before.linear)).toBeGreaterThan(0.1);
  expect(apart(before.linear, after.linear)).toBeLessThan(1e-12 * size(before.linear));
  expect(apart(before.angular, after.angular)).toBeLessThan(1e-12 * size(before.angular));
  expect(after.kinetic).toBeCloseTo(before.kinetic, 12);
  expect(await page.getByLabel("Momentum", { exact: true }).innerText()).toBe(readout);
  expect(await page.getByLabel("Events").innerText()).toContain("break arm/2");
  await keep(page, "playground-break");
  expect(complaints).toEqual([]);
});

test("a click locks a joint, another unlocks it; a lock keeps the part from bending", async () => {
  const { page, complaints } = await playground();
  await load(page, three);
  await playTo(page, 0.2);
  await page.keyboard.press("l");
  const locked = () => page.evaluate(() => window.playground.app.topology.joints.find(({ child }) => child === 2)!.locked);
  await clickJoint(page, 2);
  await expect.poll(locked, patience).toBe(1);
  await playTo(page, (await page.evaluate(() => window.playground.app.run!.last.time)) + 0.2);
  await clickJoint(page, 2);
  await expect.poll(locked, patience).toBe(0);
  expect(await page.getByLabel("Events").innerText()).toMatch(/unlock arm\/3[\s\S]*lock arm\/3/);
  expect(complaints).toEqual([]);
});

test("welding two bodies; a weld of two bodies that a joint joins is refused with a reason", async () => {
  const { page, complaints } = await playground();
  await load(page, three);
  await page.getByLabel("Joint", { exact: true }).selectOption("arm/3");
  await page.getByRole("button", { name: "Break", exact: true }).last().click();
  await page.waitForFunction(() => window.playground.app.topology.mechanisms.length === 2);
  const middle = async (body: number) => {
    const [a, b] = await page.evaluate((n) => [window.playground.placeOf(n), window.playground.placeOf(n + 1)], body);
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
  };
  await page.keyboard.press("w");
  const [first, second] = [await middle(0), await middle(1)];
  await page.mouse.click(second.x, second.y);
  await page.mouse.click(first.x, first.y);
  await expect.poll(() => page.locator(".notice").innerText(), patience).toContain("weld");
  expect(await page.evaluate(() => window.playground.app.topology.mechanisms.length)).toBe(2);
  expect(complaints).toEqual([]);
});

test("a weld of two bodies of one mechanism closes a loop; a click on its mark cuts it, and undo closes it again", async () => {
  for (const [view, name] of [
    [desktop, "desktop"],
    [{ ...phone, scale: 1 }, "phone"],
  ] as const) {
    const { page, complaints } = await playground(view);
    await load(page, three.replace("links = 3", "links = 4"));
    await playTo(page, 0.4);
    const middle = (body: number) =>
      page.evaluate((n) => {
        const [a, b] = [window.playground.placeOf(n), window.playground.placeOf(n + 1)];
        return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
      }, body);
    await page.getByRole("button", { name: "Weld", exact: true }).click();
    for (const at of [await middle(2), await middle(0)]) await page.mouse.click(at.x, at.y);
    const loops = () =>
      page.evaluate(() => window.playground.app.topology.joints.flatMap((joint) => (joint.loop ? joint.name : [])));
    await expect.poll(loops, patience).toHaveLength(1);
    const [weld] = await loops();
    expect(await page.evaluate(() => window.playground.app.topology.mechanisms.length)).toBe(1);
    await page.getByLabel("Joint", { exact: true }).selectOption(weld);
    expect(await page.locator(".joint-state").innerText()).toBe("weld, closes a loop");
    await keep(page, `playground-loop-${name}`);
    await page.getByRole("button", { name: "Break", exact: true }).first().click();
    const at = await page.evaluate((joint) => window.playground.placeOf(joint), weld);
    await page.mouse.click(at.x, at.y);
    await expect.poll(loops, patience).toEqual([]);
    await page.getByRole("button", { name: "Undo" }).first().click();
    await expect.poll(loops, patience).toEqual([weld]);
    expect(complaints).toEqual([]);
  }
});

test("a broken scenario shows its errors at their lines, and the world stays", async () => {
  const { page, complaints } = await playground();
  await load(page, three);
  await page.getByRole("tab", { name: "Scenario" }).click();
  const area = page.getByRole("textbox", { name: "Scenario (TOML)" });
  await area.fill(three.replace("links =", "lynks ="));
  // While one types, and when it is to be run.
  await expect.poll(() => page.getByLabel("Problems").innerText(), patience).toContain("did you mean 'links'?");
  await area.fill(three.replace("mass = 0.5", "mass = -0.5"));
  await expect.poll(() => page.getByLabel("Problems").innerText(), patience).toContain("mass");
  await area.fill(three.replace("links =", "lynks ="));
  await area.press("Control+Enter");
  await expect.poll(() => page.getByLabel("Problems").innerText(), patience).toContain("did you mean 'links'?");
  expect(await page.getByRole("button", { name: "line 8" }).count()).toBeGreaterThan(0);
  expect(await page.title()).toContain("Three links");
  await keep(page, "playground-errors");
  expect(complaints).toEqual([]);
});

test("undo returns to before a break; the other branch can be continued; a past instant is shown", async () => {
  const { page, complaints } = await playground();
  await load(page, three);
  await playTo(page, 0.2);
  const broken = await page.evaluate(() => window.playground.app.run!.last.time);
  await page.keyboard.press("b");
  await clickJoint(page, 1);
  await page.waitForFunction(() => window.playground.app.topology.mechanisms.length === 2);
  await playTo(page, broken + 0.3);
  const end = await page.evaluate(() => window.playground.app.run!.last.time);
  await page.getByRole("button", { name: "Undo" }).click();
  await page.waitForFunction(() => window.playground.app.topology.mechanisms.length === 1);
  expect(await page.evaluate(() => window.playground.app.run!.last.time)).toBe(broken);
  await page.getByLabel("Branches").getByRole("button").click();
  await page.waitForFunction(() => window.playground.app.topology.mechanisms.length === 2);
  await still(page);
  expect(await page.evaluate(() => window.playground.app.run!.last.time)).toBe(end);
  await page.getByLabel("Time", { exact: true }).fill("200");
  expect(Number.parseFloat(await page.locator(".clock").innerText())).toBeLessThan(end / 2);
  expect(complaints).toEqual([]);
});

test("a body that is grabbed follows the pointer", async () => {
  const { page, complaints } = await playground();
  await load(page, three);
  const from = await page.evaluate(() => window.playground.placeOf(2));
  const to = { x: from.x - 60, y: from.y - 90 };
  await page.keyboard.press("g");
  await page.mouse.move(from.x + 2, from.y);
  await page.mouse.down();
  await page.mouse.move(to.x, to.y, { steps: 6 });
  await expect
    .poll(async () => {
      const at = await page.evaluate(() => window.playground.placeOf(2));
      return Math.hypot(at.x - to.x, at.y - to.y);
    }, patience)
    .toBeLessThan(60);
  await keep(page, "playground-grab");
  await page.mouse.up();
  expect(complaints).toEqual([]);
});

test("a link contains the scenario", async () => {
  const { page } = await playground();
  await load(page, three);
  await page.getByRole("button", { name: "Share" }).click();
  await page.waitForFunction(() => location.hash.startsWith("#s="));
  const fragment = await page.evaluate(() => location.hash);
  const { page: other, complaints } = await playground(desktop, fragment);
  await other.waitForFunction(() => document.title.startsWith("Three links"));
  expect(complaints).toEqual([]);
});

test("Share tells below the header what it did, and no longer than needed", async () => {
  const { page } = await playground(phone);
  const height = () => page.locator("header").evaluate((e) => e.clientHeight);
  const before = await height();
  await page.getByRole("button", { name: "Share" }).tap();
  const message = page.locator("output.toast");
  await expect.poll(() => message.innerText(), patience).toMatch(/link/i);
  expect(await height()).toBe(before);
  await expect.poll(() => message.innerText(), patience).toBe("");
});

test("keys do nothing behind the help", async () => {
  const { page } = await playground();
  const pressed = () => page.locator(".tools [aria-pressed=true]").allInnerTexts();
  const before = await pressed();
  await page.keyboard.press("?");
  for (const key of ["b", "f", "v"]) await page.keyboard.press(key);
  expect(await pressed()).toEqual(before);
  await page.keyboard.press("Escape");
  expect(await page.locator("dialog[open]").count()).toBe(0);
  await page.keyboard.press("b");
  expect(await pressed()).toContain("Break");
});

test("on a phone, the menu View hides no tool, and closes after a press elsewhere", async () => {
  const { page } = await playground(phone);
  const menu = page.getByRole("button", { name: "View", exact: true });
  const open = async () => (await menu.getAttribute("aria-expanded")) === "true";
  await menu.tap();
  await page.locator("summary", { hasText: "Save" }).tap();
  for (const name of ["Forces", "Fit", "Weld"]) await page.getByRole("button", { name, exact: true }).tap({ trial: true });
  await page.getByRole("button", { name: "Floor", exact: true }).tap({ trial: true });
  expect(await open()).toBe(true);
  await page.getByRole("button", { name: "Weld", exact: true }).tap();
  expect(await open()).toBe(false);
  const [hint, scale] = await page
    .locator(".hint:not(.load), .scale")
    .evaluateAll((all) =>
      all.map((e) => ({ ...e.getBoundingClientRect().toJSON(), pad: parseFloat(getComputedStyle(e).paddingRight) })),
    )
    .then((boxes: { left: number; right: number; pad: number }[]) => boxes.sort((a, b) => a.left - b.left));
  expect(hint.right - hint.pad).toBeLessThanOrEqual(scale.left);
});

test("the gallery runs, on a phone and in the dark too", async () => {
  for (const [view, name] of [
    [{ ...desktop, dark: true }, "dark"],
    [phone, "phone"],
  ] as const) {
    const { page, complaints } = await playground(view);
    for (const scenario of ["capture", "crane", "tree_of_joints"]) {
      await page.getByLabel("Scenario", { exact: true }).first().selectOption(scenario);
      await page.waitForFunction((n) => window.playground.app.run!.frames === 1 && n !== "", scenario);
      await playTo(page, 0.3);
    }
    await keep(page, `playground-${name}`);
    expect(complaints).toEqual([]);
  }
});

test("loops and springs are listed; a loop joint is broken there, and bodies are welded by name", async () => {
  const { page, complaints } = await playground();
  await page.getByLabel("Scenario", { exact: true }).first().selectOption("two_arms_hold_a_bar");
  await page.waitForFunction(() => document.title.startsWith("Two arms"));
  const list = page.getByRole("list", { name: "Loops, springs and couplings" });
  await expect.poll(() => list.innerText(), patience).toMatch(/right grip\s+revolute, left\/bar to right\/fore/);
  await page.getByRole("button", { name: "Break right grip" }).click();
  await expect.poll(() => list.isVisible(), patience).toBe(false);
  await page.getByLabel("Body to weld").selectOption("left/bar");
  await page.getByLabel("Weld to").selectOption("left/upper");
  await page.getByRole("button", { name: "Weld together" }).click();
  await expect.poll(() => list.innerText(), patience).toContain("weld, left/bar to left/upper");
  await playTo(page, 0.3);
  await keep(page, "playground-loops");
  await page.getByLabel("Scenario", { exact: true }).first().selectOption("guyed_mast");
  await expect.poll(() => list.innerText(), patience).toMatch(/west guy\s+rope, mast\/pole to the ground: [\d.e]+ N of/);
  await playTo(page, 2.5);
  await expect.poll(() => list.innerText(), patience).toMatch(/west guy\s+broken/);
  await keep(page, "playground-springs");
  expect(complaints).toEqual([]);
});
