// Pictures and videos that pages save, and how fast the picture is drawn.
import { readFileSync } from "node:fs";
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, it } from "vitest";
import { desktop, launch, open, openReport, playgroundAddress, report, scenario } from "./browser";

let browser: Browser;
beforeAll(async () => {
  browser = await launch();
});
afterAll(() => browser?.close());
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

async function saved(page: Page, press: () => Promise<void>) {
  const [download] = await Promise.all([page.waitForEvent("download", { timeout: 150_000 }), press()]);
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
}

/** Size, length (s) and the spread of brightness in the middle of a video, as a browser reads it. */
async function measured(video: Buffer, type: string) {
  const page = await browser.newPage();
  const data = await page.evaluate(
    async ([text, kind]) => {
      const element = document.createElement("video");
      element.muted = true;
      element.src = `data:${kind};base64,${text}`;
      await new Promise((done, failed) => {
        element.onloadeddata = done;
        element.onerror = () => failed(new Error(element.error?.message ?? "not a video"));
      });
      await element.play();
      await new Promise((done) => (element.onended = done));
      return { width: element.videoWidth, height: element.videoHeight, length: element.currentTime };
    },
    [video.toString("base64"), type] as const,
  );
  await page.close();
  return data;
}

it("the picture is saved as a PNG of what is shown", async () => {
  const { page, complaints } = await open(browser, playgroundAddress, desktop);
  await page.waitForFunction(() => Boolean(window.playground?.app.run));
  const { name, bytes } = await saved(page, () => page.keyboard.press("p"));
  expect(name).toBe("excavator-the-pin-of-the-boom-cylinder-breaks.png");
  expect(bytes.subarray(1, 4).toString()).toBe("PNG");
  const box = (await page.locator(".stage canvas").boundingBox())!;
  expect(Math.abs(bytes.readUInt32BE(16) - box.width)).toBeLessThan(1);
  expect(Math.abs(bytes.readUInt32BE(20) - box.height)).toBeLessThan(1);
  expect(bytes.length).toBeGreaterThan(5000); // an empty picture takes less
  expect(complaints).toEqual([]);
});

it("the playground records a video from a press to the next", async () => {
  const { page, complaints } = await open(browser, playgroundAddress, desktop);
  await page.waitForFunction(() => Boolean(window.playground?.app.run));
  await page.locator("summary", { hasText: "Save" }).click();
  await page.getByRole("button", { name: "Record video" }).click();
  await page.waitForFunction(() => window.playground.app.run!.last.time > 0.4);
  await page.waitForTimeout(1500);
  const { name, bytes } = await saved(page, () => page.getByRole("button", { name: "Stop and save" }).click());
  expect(name).toMatch(/^excavator-the-pin-of-the-boom-cylinder-breaks\.(mp4|webm)$/);
  const { width, height, length } = await measured(bytes, name.endsWith("mp4") ? "video/mp4" : "video/webm");
  expect([width, height].every((size) => size > 300)).toBe(true);
  expect(length).toBeGreaterThan(0.8);
  expect(complaints).toEqual([]);
});

it("a report records its run from the start to the end", async () => {
  const folder = report(scenario("four_bar.toml"), "--until", "1.2");
  const { page, complaints } = await openReport(browser, folder, desktop, 1);
  await page.locator("summary", { hasText: "Save" }).click();
  const { name, bytes } = await saved(page, () => page.getByRole("button", { name: "Record video" }).click());
  const { length } = await measured(bytes, name.endsWith("mp4") ? "video/mp4" : "video/webm");
  expect(length).toBeGreaterThan(0.8);
  expect(complaints).toEqual([]);
});

it("the playground counts its pictures while it plays", async () => {
  const { page, complaints } = await open(browser, playgroundAddress, desktop);
  await page.waitForFunction(() => Boolean(window.playground?.app.run));
  await page.getByRole("button", { name: "Play", exact: true }).click();
  await expect
    .poll(() => page.evaluate(() => window.playground.frameRate()?.rate ?? 0), { timeout: 150_000 })
    .toBeGreaterThan(0);
  expect(complaints).toEqual([]);
});
