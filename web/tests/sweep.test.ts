// The report of a sweep, from disk, in a browser.
import { mkdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, describe, expect, it } from "vitest";
import type { SweepDocument } from "../src/sweep/document";
import { desktop, keep, launch, open, phone, report, scenario, settled, temporary, type View } from "./browser";
import { builtPage, pendulumSweep, sweepPage } from "./pendulum_sweep";
import { strangeSweeps } from "./strange_sweeps";

let browser: Browser;
const html = readFileSync(builtPage, "utf8");
const wide: View = { width: 1400, height: 900 };
beforeAll(async () => {
  browser = await launch();
});
afterAll(() => browser?.close());
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

const animated = [297];
const sample = pendulumSweep({ animated });

function opened(data: SweepDocument | string, view: View = wide, hash = "", awaited = "h1") {
  const file = sweepPage(temporary(), html, data);
  return open(browser, pathToFileURL(file).href + hash, view, awaited);
}
const card = (page: Page, name: string) => page.getByRole("article", { name, exact: true });
const panel = (page: Page) => page.getByRole("complementary", { name: "Picked world" });
const bar = (page: Page) => page.locator(".marked-bar span").innerText();
const fits = (page: Page) => page.evaluate(() => document.documentElement.scrollWidth - innerWidth);

/** Where the plot has the point of a world, from what its axes are documented to be: 3 % of margin. */
async function pointOf(page: Page, world: number, x: string, y: string) {
  const box = (await page.locator(".scatter canvas").boundingBox())!;
  const share = (name: string) => {
    const all = sample.values[name].filter((value): value is number => typeof value === "number");
    const [low, high] = [Math.min(...all), Math.max(...all)];
    return ((sample.values[name][world] as number) - low + 0.03 * (high - low)) / (1.06 * (high - low));
  };
  return { x: box.x + 62 + share(x) * (box.width - 76), y: box.y + box.height - 42 - share(y) * (box.height - 72) };
}

describe("the report of a sweep", () => {
  it("opens from disk without messages or requests, and is small", async () => {
    const { page, complaints } = await opened(sample);
    expect(await page.title()).toBe("A pendulum of uncertain strength – momentree");
    expect(await page.locator("header p").first().innerText()).toBe(
      "600 worlds · 598 done · 2 failed · pendulum.toml varied by pendulum_sweep.toml · seed 7 · momentree 0.1.0",
    );
    expect(complaints).toEqual([]);
    expect(statSync(builtPage).size).toBeLessThan(100e3);
  });

  it("lists failures with their commands", async () => {
    const { page, complaints } = await opened(sample);
    await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
    await page.getByRole("heading", { name: "2 worlds failed" }).waitFor();
    await page.getByRole("button", { name: "Copy the command for world 431" }).click();
    await page.getByRole("button", { name: "Copy the command for world 431" }).getByText("Copied").waitFor();
    expect(await page.evaluate(() => navigator.clipboard.readText())).toBe("momentree sweep pendulum_sweep.toml --world 431");
    await page.getByRole("button", { name: "World 431", exact: true }).click();
    expect(await panel(page).innerText()).toContain("diverged at t = 0.412 s");
    expect(complaints).toEqual([]);
  });

  it("shows distributions whose bins are read and marked by pointer and keyboard", async () => {
    const { page, complaints } = await opened(sample);
    const { histogram } = sample.columns.find(({ name }) => name === "load")!;
    const slider = card(page, "load").getByRole("slider");
    await slider.focus();
    await page.keyboard.press("Home");
    await page.keyboard.press("ArrowRight");
    expect(await slider.getAttribute("aria-valuetext")).toContain(`: ${histogram!.counts[1]} worlds`);
    await page.keyboard.press("Enter");
    expect(await bar(page)).toMatch(new RegExp(`^${histogram!.counts[1]} worlds marked: load from`));
    const box = (await slider.boundingBox())!;
    const at = (bin: number) => box.x + ((bin + 0.5) * box.width) / histogram!.counts.length;
    await page.mouse.move(at(3), box.y + 50);
    await page.mouse.down();
    await page.mouse.move(at(5), box.y + 50, { steps: 3 });
    await page.mouse.up();
    const three = histogram!.counts.slice(3, 6).reduce((sum, count) => sum + count, 0);
    expect(await bar(page)).toMatch(new RegExp(`^${three} worlds marked`));
    await settled(page);
    const marked = card(page, "load").locator(".marked rect");
    expect(await marked.count()).toBe(3);
    await page.getByRole("button", { name: "Clear" }).click();
    await settled(page);
    expect(await marked.count()).toBe(0);
    expect(complaints).toEqual([]);
  });

  it("shows flags with their interval, and marks their worlds", async () => {
    const { page } = await opened(sample);
    const { share, interval } = sample.columns.find(({ name }) => name === "broke")!;
    const text = await card(page, "broke").innerText();
    expect(text).toContain(`95 % interval ${(100 * interval![0]).toFixed(1)} % to ${(100 * interval![1]).toFixed(1)} %`);
    await card(page, "broke").getByRole("button", { name: "Mark broke: yes" }).click();
    expect(await bar(page)).toBe(`${Math.round(share! * 598)} worlds marked: broke: yes`);
  });

  it("a sensitivity is a bar, and shows its dependence in the plot", async () => {
    const { page } = await opened(sample);
    const rows = card(page, "lands").getByRole("row");
    const { correlation } = sample.sensitivities!.find(({ measure, vary }) => measure === "lands" && vary.startsWith("event"))!;
    expect(await rows.nth(1).innerText()).toContain(correlation!.toFixed(2).replace("-", "−"));
    await rows.nth(2).getByRole("button").click();
    expect(await page.getByLabel("Vertical axis").inputValue()).toBe("lands");
    expect(await page.getByLabel("Horizontal axis").inputValue()).toMatch(/^mechanism/);
  });

  it("a click on a point picks its world, a drag marks worlds, keys go from world to world", async () => {
    const { page, complaints } = await opened(sample);
    const [x, y] = ["event.snap.when.exceeds", "load"];
    await page.getByLabel("Vertical axis").selectOption(y);
    await page.locator(".scatter").scrollIntoViewIfNeeded();
    const place = await pointOf(page, 20, x, y);
    await page.mouse.move(place.x, place.y);
    expect(await page.locator(".tip").innerText()).toContain("World ");
    await page.mouse.click(place.x, place.y);
    await panel(page).getByRole("heading", { name: "World 20", exact: true }).waitFor();
    const value = Number((await panel(page).locator("div", { hasText: /^load/ }).last().innerText()).split(/\s+/)[1]);
    expect(value).toBeCloseTo(sample.values.load[20] as number, 3);
    await page.locator(".scatter canvas").focus();
    await page.keyboard.press("ArrowRight");
    const strengths = sample.values[x] as number[];
    const drawn = (sample.values.world as number[]).filter((world) => sample.values[y][world] !== null);
    const next = drawn.filter((world) => strengths[world] > strengths[20]).sort((a, b) => strengths[a] - strengths[b])[0];
    await panel(page)
      .getByRole("heading", { name: `World ${next}`, exact: true })
      .waitFor();
    const box = (await page.locator(".scatter canvas").boundingBox())!;
    await page.mouse.move(box.x + 63, box.y + 31);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width - 15, box.y + box.height - 43, { steps: 4 });
    await page.mouse.up();
    expect(await bar(page)).toMatch(/^598 worlds marked/);
    const strengthAt = (await pointOf(page, next, x, y)).x;
    const ringAt = async () => {
      const ring = (await page.locator(".ring").boundingBox())!;
      return ring.x + ring.width / 2;
    };
    expect(Math.abs((await ringAt()) - strengthAt)).toBeLessThan(1.5);
    await page.getByLabel("Logarithmic x").check();
    expect(await ringAt()).toBeGreaterThan(strengthAt + 5); // a logarithm is concave
    await page.getByLabel("Logarithmic x").uncheck();
    const zoom = page.getByRole("button", { name: "Zoom to marked" });
    await zoom.click();
    expect(await zoom.getAttribute("aria-pressed")).toBe("true");
    await page.locator(".scatter canvas").focus();
    await page.keyboard.press("Escape");
    expect(await zoom.isVisible()).toBe(false);
    expect(await page.locator(".marked-bar").isVisible()).toBe(false);
    expect(complaints).toEqual([]);
  });

  it("the worst case is picked first, and its animation is the report of its run", async () => {
    const file = sweepPage(temporary(), html, sample);
    const target = join(dirname(file), "worlds", "297");
    mkdirSync(target, { recursive: true });
    writeFileSync(join(target, "report.html"), readFileSync(join(report(scenario("pendulum.toml")), "report.html")));
    const { page } = await open(browser, pathToFileURL(file).href, wide, "h1");
    const loads = (sample.values.load as (number | null)[]).map((load) => load ?? 0);
    expect(loads.indexOf(Math.max(...loads))).toBe(297);
    expect(await panel(page).innerText()).toContain("load: greatest");
    expect(await page.getByRole("link", { name: "Animation of world" }).count()).toBe(2); // of the load and of the speed
    await panel(page).getByRole("link", { name: "Animation" }).click();
    await page.waitForSelector(".stage canvas");
    expect(await page.locator(".clock").innerText()).toBe("0.000 s");
  });

  it("the table of worlds is sorted, filtered and saved", async () => {
    const { page, complaints } = await opened(sample);
    const table = page.getByRole("grid");
    await table.getByRole("columnheader", { name: "load" }).getByRole("button").click();
    await table.getByRole("columnheader", { name: "load" }).getByRole("button").click();
    expect(await table.getByRole("columnheader", { name: "load" }).getAttribute("aria-sort")).toBe("descending");
    expect(await table.locator("tbody th").first().innerText()).toBe("297");
    await page.getByLabel("Column of the condition").selectOption("load");
    await page.getByLabel("Value").fill("high");
    await page.getByRole("button", { name: "Add filter" }).click();
    await page.getByText("Give a number").waitFor();
    await page.getByLabel("Value").fill("20");
    await page.getByRole("button", { name: "Add filter" }).click();
    const above = (sample.values.load as (number | null)[]).filter((load) => load !== null && load >= 20);
    await page.getByText(`${above.length} worlds of 600`).waitFor();
    const [download] = await Promise.all([
      page.waitForEvent("download"),
      page.getByRole("button", { name: "Save as CSV" }).click(),
    ]);
    expect(download.suggestedFilename()).toBe("pendulum_sweep_worlds.csv");
    const lines = readFileSync(await download.path(), "utf8")
      .trim()
      .split("\n");
    expect([lines.length, lines[0], lines[1].split(",")[0]]).toEqual([
      above.length + 1,
      ["world", ...sample.columns.map(({ name }) => name)].join(","),
      "297",
    ]);
    await page.getByRole("button", { name: "Mark these in the plots" }).click();
    expect(await bar(page)).toBe(`${above.length} worlds marked: load ≥ 20`);
    await page.getByRole("button", { name: "Remove the filter load ≥ 20" }).click();
    await page.getByLabel("only marked").check();
    await page.getByText(`${above.length} worlds of 600`).waitFor();
    await page.getByRole("group", { name: "Table of worlds" }).focus();
    await page.keyboard.press("Home");
    await panel(page).getByRole("heading", { name: "World 297", exact: true }).waitFor();
    await page.keyboard.press("End");
    await settled(page);
    const lowest = sample.values.load.indexOf(Math.min(...(above as number[])));
    expect(await table.locator("tr[aria-selected=true] th").innerText()).toBe(String(lowest));
    expect(complaints).toEqual([]);
  });

  it("20 000 worlds: rows in view only, and the last one is there", async () => {
    const large = pendulumSweep({ worlds: 20_000 });
    const { page, complaints } = await opened(large);
    const table = page.getByRole("group", { name: "Table of worlds" });
    await table.evaluate((element) => (element.scrollTop = element.scrollHeight));
    await page.waitForFunction(() => document.querySelector(".worlds tbody tr:last-child th")?.textContent === "19999");
    expect(await page.locator(".worlds tbody tr").count()).toBeLessThan(80);
    expect(complaints).toEqual([]);
  });

  it("parts have names, and #world picks one", async () => {
    const { page } = await opened(sample, wide, "#world=20");
    await panel(page).getByRole("heading", { name: "World 20", exact: true }).waitFor();
    const nameless = await page
      .locator("button, select, input, a, [tabindex='0']")
      .evaluateAll((all) =>
        all
          .filter((e) => !(e.getAttribute("aria-label") || e.textContent?.trim() || e.closest("label")?.textContent?.trim()))
          .map((e) => e.outerHTML),
      );
    expect(nameless).toEqual([]);
  });

  it("explains itself: ? opens the help, and closes it", async () => {
    const { page, complaints } = await opened(sample, phone);
    await page.getByRole("button", { name: "Help" }).tap();
    const help = page.getByRole("dialog", { name: "Help" });
    expect(await help.innerText()).toContain("Distributions");
    await page.keyboard.press("?");
    expect(await help.count()).toBe(0);
    expect(complaints).toEqual([]);
  });

  it("on a phone the picked world is a sheet that can be closed", async () => {
    const { page, complaints } = await opened(sample, phone);
    expect(await panel(page).isVisible()).toBe(false);
    await page.getByRole("button", { name: "World 431", exact: true }).tap();
    const box = (await panel(page).boundingBox())!;
    expect(box.y + box.height).toBeCloseTo(844, 0);
    await panel(page).getByRole("button", { name: "Close" }).tap();
    expect(await panel(page).isVisible()).toBe(false);
    expect(complaints).toEqual([]);
  });
});

describe("the layout", () => {
  it.each([
    ["a desktop", wide, { desktop: wide, desktop_dark: { ...wide, dark: true }, small: desktop }],
    ["a phone", phone, { phone, phone_dark: { ...phone, dark: true }, landscape: { width: 844, height: 390 } }],
  ] as [string, View, Record<string, View>][])("fits %s, in both themes and sizes", async (_name, first, views) => {
    const { page, complaints } = await opened(sample, first);
    for (const [name, { width, height, dark }] of Object.entries(views)) {
      await page.emulateMedia({ colorScheme: dark ? "dark" : "light" });
      await page.setViewportSize({ width, height });
      await settled(page);
      expect(await fits(page), name).toBeLessThanOrEqual(0);
      await keep(page, `sweep_${name}`, true);
    }
    expect(complaints).toEqual([]);
  });

  describe.each(Object.entries(strangeSweeps))("of %s", (name, { data, says }) => {
    it("fits a desktop, and a window of the size of a phone in the dark", async () => {
      const { page, complaints } = await opened(data, wide);
      for (const kind of ["desktop", "phone_dark"]) {
        if (kind === "phone_dark") {
          await page.emulateMedia({ colorScheme: "dark" });
          await page.setViewportSize({ width: phone.width, height: phone.height });
          await settled(page);
        }
        expect(await fits(page), kind).toBeLessThanOrEqual(0);
        for (const text of says) await page.getByText(text).first().waitFor();
        expect(await page.locator("body").innerText()).not.toMatch(/NaN|undefined|Infinity/);
        await keep(page, `sweep_${name}_${kind}`, true);
      }
      expect(complaints).toEqual([]);
    });
  });
});

describe("damaged data", () => {
  it.each([
    ["", "This page contains no sweep"],
    ["{", "The sweep can't be shown: its data are damaged, or the file is cut off."],
    ["[]", "The sweep can't be shown: the document is missing, or not an object."],
    ['{"format": 2}', "The sweep can't be shown: format is 2, but this page reads format 1."],
    ['{"format": 1, "columns": [{}], "values": {"world": []}}', "The sweep can't be shown: columns[0] has no name."],
  ])("%s", async (text, message) => {
    const { page } = await opened(text, wide, "", ".nothing");
    expect(await page.locator(".nothing").innerText()).toContain(message);
  });

  it("without JavaScript the page says what it is", async () => {
    const { page } = await opened(sample, { ...wide, noScript: true }, "", "noscript p");
    expect(await page.locator("noscript").innerText()).toContain("This is the report of a momentree sweep");
  });

  it("names are text, whatever they contain", async () => {
    const nasty = "</script><script>alert(1)</script><img src=x onerror=alert(2)>";
    const data: SweepDocument = {
      format: 1,
      title: nasty,
      columns: [{ name: nasty, role: "measure", about: nasty, unit: nasty }],
      values: { world: [0, 1], [nasty]: [1, 2] },
      failures: [{ world: 3, why: nasty, replay: nasty }],
      worst: [
        { measure: nasty, end: "least", worlds: [{ world: 0, value: 1, replay: nasty, animation: "javascript:alert(3)" }] },
      ],
    };
    const { page, complaints } = await opened(data);
    expect(await page.locator("h1").innerText()).toBe(nasty);
    expect(await page.getByRole("link").count()).toBe(0);
    expect(complaints).toEqual([]);
  });
});
