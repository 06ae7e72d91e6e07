// What the pages say where something is missing or damaged: never nothing, and never something else instead.
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, describe, expect, it } from "vitest";
import { fragmentOf } from "../src/playground/share";
import {
  desktop,
  differing,
  keep,
  launch,
  open,
  openReport,
  phone,
  playgroundAddress,
  program,
  report,
  scenario,
  settled,
  temporary,
} from "./browser";

let browser: Browser;
let plain: Browser; // without WebGL
let chain: string;
beforeAll(async () => {
  [browser, plain] = [await launch(), await launch({ webgl: false })];
  chain = report(scenario("breaking_chain.toml"));
});
afterAll(() => Promise.all([browser?.close(), plain?.close()]));
afterEach(async () => {
  for (const context of [...browser.contexts(), ...plain.contexts()]) await context.close();
});
const patience = { timeout: 80_000 };

const instead = (page: Page) => page.locator(".placeholder").innerText();
const ready = (page: Page) => page.waitForFunction(() => Boolean(window.playground?.app.run));
/** The graphics context goes, or comes back. */
const context = (page: Page, does: "loseContext" | "restoreContext") =>
  page.evaluate((what) => {
    const held = window as unknown as { extension?: Record<string, () => void> };
    held.extension ??= document
      .querySelector<HTMLCanvasElement>(".stage canvas")!
      .getContext("webgl2")!
      .getExtension("WEBGL_lose_context") as unknown as Record<string, () => void>;
    held.extension[what]();
  }, does);

describe("without WebGL", () => {
  it("a report says so, and shows its plots, events and tables", async () => {
    for (const view of [desktop, { ...phone, scale: 1, dark: true }]) {
      const { page, complaints } = await openReport(plain, chain, view, 0, ".placeholder");
      expect(await instead(page)).toMatch(/No 3D picture[\s\S]*hardware acceleration[\s\S]*Plots, events and tables/);
      expect(await page.locator(".stage canvas").count()).toBe(0);
      expect(await page.locator(".tools").count()).toBe(0);
      expect(await page.locator(".plot canvas").count()).toBe(3);
      if (view.touch) await page.keyboard.press("Shift+ArrowRight");
      else await page.locator(".marks button").click();
      expect(await page.locator(".clock").innerText()).toBe("1.800 s");
      expect(await page.locator(".names li").allInnerTexts()).toEqual(["chain", "chain/41"]);
      expect(await page.locator(".certificate").innerText()).toContain("linear momentum");
      await page.keyboard.press("ArrowRight");
      expect(await page.locator(".clock").innerText()).toBe("1.820 s");
      await keep(page, `no_webgl_${view.width}`);
      expect(complaints).toEqual([]);
    }
  });

  it("the playground says so, plays, and offers nothing that needs the picture", async () => {
    const address = `${playgroundAddress}#scenario=breaking_chain_accurate`;
    const { page, complaints } = await open(plain, address, desktop, ".plot canvas");
    await ready(page);
    expect(await instead(page)).toContain("No 3D picture");
    for (const name of ["Grab", "Weld", "Forces", "Fit"])
      expect(await page.getByRole("button", { name, exact: true }).isVisible(), name).toBe(false);
    await page.getByRole("button", { name: "Play", exact: true }).click();
    await page.waitForFunction(() => window.playground.app.run!.last.time > 0.1);
    await page.getByRole("button", { name: "Break", exact: true }).click();
    await page.waitForFunction(() => window.playground.app.topology.mechanisms.length === 2);
    await page.getByLabel("Scenario", { exact: true }).first().selectOption("capture");
    await page.waitForFunction(() => window.playground.app.run!.frames === 1);
    expect(await page.locator(".placeholder").count()).toBe(1);
    await keep(page, "no_webgl_playground");
    expect(complaints).toEqual([]);
  });
});

describe("a graphics context that is lost", () => {
  it("is reported, and the picture is drawn again when it is restored", async () => {
    const { page, complaints } = await openReport(browser, chain);
    const seek = async (place: string) => {
      await page.getByLabel("Time", { exact: true }).fill(place);
      await settled(page);
    };
    await page.locator(".marks button").click();
    await seek("640");
    const pictures = page.locator(".pair canvas");
    const pair = await pictures.last().screenshot();
    const before = await page.locator(".stage canvas").screenshot();
    await context(page, "loseContext");
    await page.waitForSelector(".placeholder");
    expect(await instead(page)).toMatch(/3D picture was lost[\s\S]*reload/i);
    expect(await page.locator(".tools").evaluate((e) => (e as HTMLElement).inert)).toBe(true);
    await page.locator(".marks button").click();
    expect(await pictures.count()).toBe(0); // rather than white ones
    await page.keyboard.press("End"); // the rest of the page goes on
    expect(await page.locator(".clock").innerText()).toBe("3.000 s");
    await keep(page, "context_lost");
    await context(page, "restoreContext");
    await expect.poll(() => page.locator(".placeholder").count(), patience).toBe(0);
    await seek("640");
    expect((await page.locator(".stage canvas").screenshot()).equals(before)).toBe(true);
    expect((await pictures.last().screenshot()).equals(pair)).toBe(true);
    expect(await page.locator(".tools").evaluate((e) => (e as HTMLElement).inert)).toBe(false);
    expect(complaints.filter((text) => !text.includes("Context"))).toEqual([]);
  });

  it("is reported in the playground, and its tools are enabled again when it is restored", async () => {
    const { page } = await open(browser, playgroundAddress);
    await ready(page);
    const inert = () => page.locator(".tools").evaluateAll((all) => all.map((e) => (e as HTMLElement).inert));
    await context(page, "loseContext");
    await page.waitForSelector(".placeholder");
    expect(await inert()).toEqual([true, true]);
    await context(page, "restoreContext");
    await expect.poll(() => page.locator(".placeholder").count(), patience).toBe(0);
    expect(await inert()).toEqual([false, false]);
    await context(page, "loseContext");
    await page.waitForSelector(".placeholder");
    await page.getByRole("button", { name: "⟲" }).click(); // another picture, with a context of its own
    await expect.poll(() => page.locator(".placeholder").count(), patience).toBe(0);
    expect(await inert()).toEqual([false, false]);
  });

  it("is not reported when a world replaces another", async () => {
    const { page, complaints } = await open(browser, playgroundAddress);
    await ready(page);
    for (let i = 0; i < 17; i++) {
      const frames = await page.evaluate(() => Object.assign(window, { before: window.playground.app.run }) && 0);
      await page.getByRole("button", { name: "⟲" }).click();
      await page.waitForFunction(
        (none) => (window as unknown as { before: unknown }).before !== window.playground.app.run || none,
        frames,
      );
    }
    await settled(page);
    expect(await page.locator(".stage canvas").count()).toBe(1);
    expect(await page.locator(".placeholder").count()).toBe(0);
    expect(complaints).toEqual([]); // browsers warn of more than 16 contexts
  });
});

describe("without JavaScript", () => {
  it("a report says what it is and where the numbers are", async () => {
    const { page } = await openReport(browser, chain, { ...desktop, noScript: true }, undefined, "noscript");
    expect(await page.locator("body").innerText()).toMatch(/report of a momentree run[\s\S]*JavaScript[\s\S]*bodies\.csv/);
    await keep(page, "no_script");
  });
  it("the playground says what it is", async () => {
    const { page } = await open(browser, playgroundAddress, { ...desktop, noScript: true }, "noscript");
    expect(await page.locator("body").innerText()).toMatch(/playground of momentree[\s\S]*JavaScript/);
  });
});

describe("a report", () => {
  it("that is cut off, or contains no run, says so", async () => {
    const whole = readFileSync(join(chain, "report.html"), "utf8");
    const [start, end] = [whole.indexOf('id="recording">') + 15, whole.lastIndexOf("</script>")];
    const folder = temporary();
    for (const [text, says] of [
      [whole.slice(0, start + 50_000), "cut off"],
      [whole.slice(0, start - 60), "cut off"],
      [`${whole.slice(0, start)}{"format": 1}${whole.slice(end)}`, "can't be shown"],
      [whole.slice(0, start) + whole.slice(end), "contains no run"],
    ]) {
      writeFileSync(join(folder, "report.html"), text);
      const { page } = await open(browser, pathToFileURL(join(folder, "report.html")).href, desktop, "p");
      expect(await page.locator("body").innerText()).toContain(says);
      await page.context().close();
    }
  });

  it("of a run that diverged shows the whole reason, and no motion that was not computed", async () => {
    const text = `format = 1
[[mechanism]]
name = "arm"
[mechanism.chain]
links = 4
length = 0.2
mass = 0.01
inertia = 1e-6
axis = [0, 1, 0]
angle = "30 deg"
damping = 50
[integrate]
step = "1 ms"
until = 5
`;
    const file = join(temporary(), "stiff.toml");
    writeFileSync(file, text);
    const folder = join(temporary(), "result");
    expect(spawnSync(program, ["run", file, "--report", "--quiet", "--out", folder]).status).toBe(1);
    for (const view of [desktop, phone]) {
      const { page, complaints } = await openReport(browser, `${folder}.partial`, view);
      const status = page.locator("header .status");
      expect(await status.innerText()).toMatch(
        /diverged at t = 0\.001 s: the damper of joint 'arm\/4' .* too stiff .*; use method = "damped", or a step below .* s$/,
      );
      expect(await status.evaluate((e) => e.scrollWidth <= e.clientWidth && getComputedStyle(e).textOverflow === "clip")).toBe(
        true,
      );
      expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
      const still = await page.locator(".stage canvas").screenshot();
      await page.getByLabel("Time", { exact: true }).fill("900");
      await settled(page);
      expect(await page.locator(".clock").innerText()).toBe("0.000900 s");
      const nearTheEnd = await page.locator(".stage canvas").screenshot();
      await page.getByLabel("Time", { exact: true }).fill("950");
      await settled(page);
      expect(await page.locator(".clock").innerText()).toBe("0.000950 s");
      expect(await differing(page, await page.locator(".stage canvas").screenshot(), nearTheEnd)).toBe(0);
      await page.keyboard.press("End");
      await settled(page);
      expect(await differing(page, await page.locator(".stage canvas").screenshot(), still)).toBeGreaterThan(0);
      await keep(page, `diverged_${view.width}`);
      expect(complaints).toEqual([]);
      await page.context().close();
    }
  });
});

describe("a link", () => {
  const good = `format = 1
title = "One pendulum"
[[mechanism]]
name = "p"
[mechanism.chain]
links = 1
length = 0.4
mass = 0.5
inertia = 0.007
axis = [0, 1, 0]
`;

  it("that is damaged says so, shows no other scenario, and offers one", async () => {
    const whole = await fragmentOf(good);
    for (const fragment of ["#s=garbage", whole.slice(0, -9), "#s2=AAAA", "#unknown"]) {
      const { page, complaints } = await open(browser, playgroundAddress + fragment, desktop, ".placeholder button");
      expect(await instead(page)).toMatch(fragment.startsWith("#s2") ? /newer version/ : /Ask for it again/);
      expect(await page.evaluate(() => window.playground?.app.run ?? null)).toBeNull();
      expect(await page.locator(".timeline").evaluate((e) => (e as HTMLElement).inert)).toBe(true);
      expect(await page.getByRole("combobox", { name: "Scenario" }).inputValue()).toBe("");
      if (fragment === "#s=garbage") await keep(page, "link_damaged");
      await page.getByRole("button", { name: "instead" }).click();
      await ready(page);
      expect(await page.title()).toContain("Excavator");
      expect(await page.evaluate(() => location.hash)).toBe(""); // a reload shows it again
      expect(await page.locator(".timeline").evaluate((e) => (e as HTMLElement).inert)).toBe(false);
      expect(complaints).toEqual([]);
      await page.context().close();
    }
  });

  it("whose scenario has errors says so and shows them; corrected, it runs", async () => {
    const fragment = await fragmentOf(good.replace("links", "lynks"));
    const { page, complaints } = await open(browser, playgroundAddress + fragment, desktop, ".problems li");
    expect(await instead(page)).toContain("The scenario in this link has errors");
    expect(await page.getByLabel("Problems").innerText()).toContain("did you mean 'links'?");
    expect(await page.evaluate(() => window.playground.app.run)).toBeNull();
    await keep(page, "link_with_errors");
    await page.getByRole("textbox", { name: "Scenario (TOML)" }).fill(good);
    await page.getByRole("button", { name: "Run this" }).click();
    await ready(page);
    expect(await page.title()).toContain("One pendulum");
    expect(await page.locator(".placeholder").count()).toBe(0);
    expect(complaints).toEqual([]);
  });

  it("of a scenario of a later format says so", async () => {
    const fragment = await fragmentOf(good.replace("format = 1", "format = 2"));
    const { page } = await open(browser, playgroundAddress + fragment, desktop, ".problems li");
    expect(await page.getByLabel("Problems").innerText()).toContain("format");
    expect(await page.evaluate(() => window.playground.app.run)).toBeNull();
  });

  it("that is opened while a world runs keeps that world, and says so", async () => {
    const { page } = await open(browser, playgroundAddress + (await fragmentOf(good)));
    await ready(page);
    for (const fragment of ["#s=garbage", await fragmentOf(good.replace("links", "lynks"))]) {
      await page.evaluate((hash) => (location.hash = hash), fragment);
      await expect.poll(() => page.locator(".notice").innerText(), patience).toContain("This is still “One pendulum”");
    }
    expect(await page.title()).toContain("One pendulum");
  });
});
