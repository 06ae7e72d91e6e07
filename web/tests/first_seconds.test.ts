// What somebody sees who opens the playground for the first time.
import type { Browser } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, it } from "vitest";
import { desktop, keep, launch, open, phone, playgroundAddress, type View } from "./browser";

let browser: Browser;
let plain: Browser; // without WebGL
beforeAll(async () => {
  [browser, plain] = [await launch(), await launch({ webgl: false })];
});
afterAll(() => Promise.all([browser?.close(), plain?.close()]));
afterEach(async () => {
  for (const context of [...browser.contexts(), ...plain.contexts()]) await context.close();
});

it("starts to move by itself, and something breaks before three seconds of its clock", async () => {
  const begin = async (view: View) => {
    const { page, complaints } = await open(browser, playgroundAddress, { ...view, scale: 1, motion: true });
    await page.waitForFunction(() => window.playground?.app.playing && window.playground.app.run!.last.time > 0.2);
    await keep(page, `first_seconds_${view.width}`);
    return { page, complaints };
  };
  const onPhone = await begin(phone);
  expect(onPhone.complaints).toEqual([]);
  await onPhone.page.context().close();
  const { page, complaints } = await begin(desktop);
  await page.waitForFunction(() => window.playground.app.run!.events.length > 0, undefined, { timeout: 150_000 });
  expect(await page.evaluate(() => window.playground.app.run!.events[0].time)).toBeLessThan(3);
  expect(complaints).toEqual([]);
});

it("starts to move without WebGL, too: the plots show it", async () => {
  const { page, complaints } = await open(plain, playgroundAddress, { ...desktop, motion: true }, ".plot canvas");
  await page.waitForFunction(() => window.playground?.app.run && window.playground.app.run.last.time > 0.2);
  expect(await page.locator(".placeholder").innerText()).toContain("No 3D picture");
  expect(complaints).toEqual([]);
});

it("stays still for readers who prefer reduced motion", async () => {
  const { page } = await open(browser, playgroundAddress);
  await page.waitForFunction(() => Boolean(window.playground?.app.run));
  await page.waitForTimeout(300);
  expect(await page.evaluate(() => [window.playground.app.playing, window.playground.app.run!.last.time])).toEqual([false, 0]);
});

it("explains itself: ? opens and closes the help, which names every key", async () => {
  for (const view of [desktop, phone]) {
    const { page, complaints } = await open(browser, playgroundAddress, { ...view, scale: 1 });
    await page.waitForFunction(() => Boolean(window.playground?.app.run));
    const help = page.getByRole("dialog", { name: "Help" });
    await page.keyboard.press("?");
    await help.waitFor();
    const keys = await help.locator("kbd").allInnerTexts();
    for (const button of await page.locator("[title*='(']").evaluateAll((all) => all.map((e) => (e as HTMLElement).title))) {
      const key = /\(([A-Z])\)$/.exec(button)?.[1];
      if (key) expect(keys.join(" "), button).toContain(key);
    }
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
    await keep(page, `help_${view.width}`);
    await page.keyboard.press("Escape");
    expect(await help.count()).toBe(0);
    await page.getByRole("button", { name: "Help" }).click();
    await help.getByRole("button", { name: "Close the help" }).click();
    expect(await help.count()).toBe(0);
    expect(complaints).toEqual([]);
  }
});
