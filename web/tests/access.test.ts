// For fingers, keyboards, screen readers and weak eyes: sizes of targets, contrast, names of controls, on every page.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, describe, expect, it } from "vitest";
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
  scenario,
  settled,
  temporary,
  type View,
} from "./browser";
import { builtPage, pendulumSweep, sweepPage } from "./pendulum_sweep";

let browser: Browser;
let capture: string;
let chain: string; // has a warning
let sweep: string;
beforeAll(async () => {
  browser = await launch();
  capture = report(scenario("capture.toml"), "--reactions");
  chain = report(scenario("breaking_chain.toml"));
  const data = pendulumSweep({ failing: [3], animated: [297] });
  sweep = pathToFileURL(sweepPage(temporary(), readFileSync(builtPage, "utf8"), data)).href;
});
afterAll(() => browser?.close());
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

const pages = {
  playground: (view: View) => open(browser, playgroundAddress, view),
  report: (view: View) => openReport(browser, capture, view, 2.6),
  sweep: (view: View) => open(browser, sweep, view, "h1"),
};

/**
 * Visible buttons, choices, fields and links that are smaller than 44 px; words within text are no targets of their own
 * (WCAG 2.5.8), and the label of a box belongs to it.
 */
const small = (page: Page) =>
  page.locator("button, select, input, summary, a[href]").evaluateAll((all) =>
    all
      .map((e) => e.closest("label:has([type=checkbox])") ?? e)
      .filter(
        (e) => (e as HTMLElement).checkVisibility({ visibilityProperty: true }) && getComputedStyle(e).pointerEvents !== "none",
      )
      .filter((e) => !e.matches("dd button, td button, th button, .note button"))
      .map((e) => ({ box: e.getBoundingClientRect(), what: e.outerHTML.slice(0, 90) }))
      .filter(({ box }) => box.width > 0 && (box.width < 43.5 || box.height < 43.5))
      .map(({ box, what }) => `${box.width.toFixed(0)} × ${box.height.toFixed(0)}: ${what}`),
  );

/** Text whose contrast with its background is below 4.5 (3 for large text), as by WCAG 1.4.3. */
const pale = (page: Page) =>
  page.evaluate(() => {
    const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true })!;
    canvas.canvas.width = canvas.canvas.height = 1;
    const rgba = (colour: string): number[] => {
      canvas.clearRect(0, 0, 1, 1);
      canvas.fillStyle = colour;
      canvas.fillRect(0, 0, 1, 1);
      const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data;
      return [r, g, b, a / 255];
    };
    const over = (top: number[], below: number[]) => [0, 1, 2].map((k) => top[3] * top[k] + (1 - top[3]) * below[k]);
    const groundOf = (element: Element | null): number[] => {
      if (!element) return [255, 255, 255];
      const own = rgba(getComputedStyle(element).backgroundColor);
      return own[3] === 1 ? own.slice(0, 3) : over(own, groundOf(element.parentElement));
    };
    const luminance = (c: number[]) => {
      const [r, g, b] = c.map((x) => (x / 255 <= 0.03928 ? x / 255 / 12.92 : ((x / 255 + 0.055) / 1.055) ** 2.4));
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const found: string[] = [];
    for (const element of document.querySelectorAll("body *")) {
      if (![...element.childNodes].some((n) => n.nodeType === 3 && n.textContent!.trim())) continue;
      if (!(element as HTMLElement).checkVisibility() || element.closest("[inert], :disabled, .hidden-text, script, noscript"))
        continue;
      const style = getComputedStyle(element);
      const ground = groundOf(element);
      const [a, b] = [luminance(over(rgba(style.color), ground)), luminance(ground)].sort((x, y) => y - x);
      const large = parseFloat(style.fontSize) >= 24;
      if ((a + 0.05) / (b + 0.05) < (large ? 3 : 4.5))
        found.push(`${((a + 0.05) / (b + 0.05)).toFixed(2)}: ${element.outerHTML.slice(0, 90)}`);
    }
    return found;
  });

const nameless = (page: Page) =>
  page.locator("button, select, input, textarea, [role=img], dialog").evaluateAll((all) =>
    all
      .filter((e) => (e as HTMLElement).checkVisibility() || e.matches("dialog"))
      .filter((e) => !(e.getAttribute("aria-label") || e.textContent?.trim() || e.getAttribute("title") || e.closest("label")))
      .map((e) => e.outerHTML.slice(0, 90)),
  );

describe.each(["playground", "report", "sweep"] as const)("the %s", (name) => {
  const opened = async (view: View) => {
    const { page, complaints } = await pages[name](view);
    if (name === "playground") await page.waitForFunction(() => Boolean(window.playground?.app.run));
    return { page, complaints };
  };

  it("on a phone, upright and turned, fits, has targets of 44 px, and no part over another", async () => {
    const { page, complaints } = await opened({ ...phone, scale: 1 });
    const menu = page.getByRole("button", { name: "View", exact: true });
    for (const [held, { width, height }] of Object.entries({ upright: phone, across: phoneAcross })) {
      await page.setViewportSize({ width, height });
      await settled(page);
      expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), held).toBeLessThanOrEqual(0);
      // What is behind a button, too.
      if (name === "sweep") await page.getByRole("button", { name: "World 297", exact: true }).first().tap();
      else await menu.tap();
      expect(await small(page), held).toEqual([]);
      if (name === "sweep") await page.getByRole("button", { name: "Close", exact: true }).tap();
      else await menu.tap();
      // Plots and texts beside the picture do not overlap.
      const boxes = await page
        .locator(".plots > *, .details")
        .evaluateAll((all) => all.map((e) => e.getBoundingClientRect().toJSON() as DOMRect));
      boxes.forEach((box, i) => i > 0 && expect(box.top, held).toBeGreaterThanOrEqual(boxes[i - 1].bottom - 1));
      for (const plot of await page.locator(".plot").evaluateAll((all) => all.map((e) => e.clientHeight)))
        expect(plot, held).toBeGreaterThan(60);
      if (name !== "sweep") {
        await page.evaluate(() => scrollTo(0, 0));
        const picture = (await page.locator(".stage").boundingBox())!;
        const timeline = (await page.locator(".timeline").boundingBox())!;
        expect(picture.height, held).toBeGreaterThan(200);
        expect(timeline.y + timeline.height, held).toBeLessThanOrEqual(height + 1);
      }
      await keep(page, `${name}_${held}`);
    }
    await page.emulateMedia({ colorScheme: "dark" });
    await page.setViewportSize({ width: phone.width, height: phone.height });
    await settled(page);
    expect(await pale(page), "dark").toEqual([]);
    expect(await nameless(page)).toEqual([]);
    expect(complaints).toEqual([]);
  });

  it.skipIf(name === "sweep")("in a low window the plots are scrolled, not squeezed", async () => {
    const { page } = await opened({ width: 840, height: 520 });
    const parts = await page.locator(".plots > *").evaluateAll((all) =>
      all.map((each) => {
        const { top, bottom } = each.getBoundingClientRect();
        return {
          top,
          bottom,
          inside: Math.max(...[...each.querySelectorAll("canvas")].map((c) => c.getBoundingClientRect().bottom)),
        };
      }),
    );
    parts.forEach(({ top, bottom, inside }, i) => {
      if (i > 0) expect(top).toBeGreaterThanOrEqual(parts[i - 1].bottom - 1);
      expect(inside).toBeLessThanOrEqual(bottom + 1);
    });
    await keep(page, `${name}_low`);
  });

  it("text has contrast in both themes, and every control has a name", async () => {
    const { page } = await opened(desktop);
    for (const colorScheme of ["light", "dark"] as const) {
      await page.emulateMedia({ colorScheme });
      await settled(page);
      expect(await pale(page), colorScheme).toEqual([]);
    }
    expect(await nameless(page)).toEqual([]);
    expect(await page.evaluate(() => [document.documentElement.lang, document.querySelectorAll("main, h1").length])).toEqual([
      "en",
      2,
    ]);
  });
});

describe("the report on a phone held across", () => {
  it("has its details beside the picture, not below it: events, certificates and tabs can be read", async () => {
    const { page, complaints } = await openReport(browser, chain, { ...phoneAcross, scale: 1 }, 1.8);
    const picture = (await page.locator(".picture").boundingBox())!;
    const uncovered = async (selector: string) => {
      const part = page.locator(selector).first();
      await part.scrollIntoViewIfNeeded();
      const box = (await part.boundingBox())!;
      expect(box.x, selector).toBeGreaterThanOrEqual(picture.x + picture.width - 1);
      const hit = await part.evaluate((e) => {
        const { left, top, width, height } = e.getBoundingClientRect();
        return e.contains(document.elementFromPoint(left + width / 2, top + Math.min(height / 2, 40)));
      });
      expect(hit, selector).toBe(true);
    };
    await uncovered(".plots select");
    await uncovered(".events .list button");
    await uncovered(".certificate");
    await page.getByRole("tab", { name: "Times and energy" }).tap();
    await uncovered(".summary table");
    expect(await page.getByRole("tabpanel").innerText()).toContain("Energy balance");
    await keep(page, "report_across_details");
    // A warning has a line of the header; a tap shows all of it.
    await page.evaluate(() => {
      const line = document.querySelector("header .status")!;
      line.textContent = `Warning: ${"all of a long text ".repeat(20)}`;
    });
    const status = page.locator("header .status");
    const cut = () => status.evaluate((e) => e.scrollWidth > e.clientWidth);
    expect(await cut()).toBe(true);
    await status.tap();
    expect(await cut()).toBe(false);
    await status.tap();
    expect(await cut()).toBe(true);
    await status.focus();
    expect(await cut()).toBe(false);
    expect(complaints).toEqual([]);
  });
});

describe("with a thumb", () => {
  const ready = (page: Page) => page.waitForFunction(() => Boolean(window.playground?.app.run));
  const place = (page: Page, of: number) => page.evaluate((n) => window.playground.placeOf(n), of);

  it.each([
    ["upright", phone],
    ["across", phoneAcross],
  ] as const)("on a phone held %s one cuts and welds", async (_held, view) => {
    const { page, complaints } = await open(browser, playgroundAddress, { ...view, scale: 1 });
    await ready(page);
    await page.getByLabel("Scenario", { exact: true }).first().selectOption("two_arms_hold_a_bar");
    await page.waitForFunction(() => document.title.startsWith("Two arms"));
    const mechanisms = () => page.evaluate(() => window.playground.app.topology.mechanisms.length);
    // Beside the joint, as a thumb is.
    const tap = async (of: number, aside = 9) => {
      const at = await place(page, of);
      await page.touchscreen.tap(at.x + aside, at.y - aside);
    };
    const events = () => page.evaluate(() => window.playground.app.run!.events.length);
    const before = await mechanisms();
    await page.getByRole("button", { name: "Break", exact: true }).first().tap();
    await tap(2);
    await expect.poll(events, { timeout: 20_000 }).toBe(1);
    expect(await mechanisms()).toBe(before); // a loop still held the bar
    await page.getByRole("button", { name: "Weld", exact: true }).tap();
    await tap(1, 0);
    await tap(3, 0);
    await expect.poll(events, { timeout: 20_000 }).toBe(2);
    expect(complaints).toEqual([]);
  });

  it("a body follows a finger, and the page stays where it is", async () => {
    const { page, complaints } = await open(browser, `${playgroundAddress}#scenario=breaking_chain_accurate`, {
      ...phone,
      scale: 1,
    });
    await ready(page);
    const session = await page.context().newCDPSession(page); // touches as the screen sends them
    const from = await place(page, 60);
    const touch = (type: string, x?: number, y?: number) =>
      session.send("Input.dispatchTouchEvent", { type: type as never, touchPoints: x === undefined ? [] : [{ x, y: y! }] });
    await touch("touchStart", from.x + 14, from.y);
    for (let i = 1; i <= 6; i++) await touch("touchMove", from.x + 14, from.y - 10 * i);
    await page.waitForFunction(() => window.playground.app.playing);
    await expect.poll(async () => from.y - (await place(page, 60)).y, { timeout: 20_000 }).toBeGreaterThan(20);
    await touch("touchEnd");
    expect(await page.evaluate(() => scrollY)).toBe(0);
    expect(complaints).toEqual([]);
  });
});
