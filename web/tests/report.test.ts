// The report of the breaking chain, from disk, in a browser.
import { readFileSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";
import { mechanismColour, themeOf } from "../src/viewer/colours";
import {
  desktop,
  keep,
  launch,
  openReport,
  phone,
  pixelsLike,
  report,
  scenario,
  settled,
  temporary,
  type View,
} from "./browser";
import { csv } from "./tables";

let browser: Browser;
let chain: string;
beforeAll(async () => {
  browser = await launch();
  chain = report(scenario("breaking_chain.toml"));
});
afterAll(() => browser?.close());

const clock = (page: Page) => page.locator(".clock").innerText();
const names = (page: Page) => page.locator(".names li").allInnerTexts();
const light = themeOf(false);

/** The value that the legend of a plot shows for a series. */
async function shown(page: Page, series: string): Promise<number> {
  const text = await page
    .locator(".legend li", { hasText: new RegExp(`^${series}`) })
    .first()
    .innerText();
  return Number(text.slice(series.length).trim().split(" ")[0].replace("−", "-"));
}

/** Three bars that the ground closes; the crank's joint to the coupler breaks, and then the bearing of the rocker. */
const fourBar = `format = 1
title = "Four-bar"
[[mechanism]]
name = "bars"
[mechanism.chain]
links = 3
length = 0.4
mass = 1
inertia = 0.013
axis = [0, 1, 0]
angle = "-40 deg"
[[loop]]
name = "bearing"
kind = "revolute"
axis = [0, 1, 0]
body = "bars/3"
at = { xyz = [0.6, 0, 0] }
child_at = { xyz = [0.4, 0, 0] }
[[event]]
at = 0.3
break = "bars/2"
[[event]]
at = 0.5
break = "bearing"
[integrate]
until = 0.8
`;

describe("the report of a run with a closed loop", () => {
  it("has one mechanism until it breaks; the certificate and the energies tell of the loop", async () => {
    const file = join(temporary(), "four_bar.toml");
    writeFileSync(file, fourBar);
    const { page, complaints } = await openReport(browser, report(file, "--reactions"));
    expect(await names(page)).toEqual(["bars"]);
    await keep(page, "report-loop");
    const event = (name: string) => page.locator(".events .list button", { hasText: name });
    const certificate = () => page.locator(".certificate").innerText();
    await event("break bars/2").click();
    expect(await names(page)).toEqual(["bars", "bars/3"]);
    expect(await certificate()).toMatch(/equations of loops\s+5\s+–/);
    expect(await certificate()).toMatch(/independent of them\s+2\s+–/);
    expect(await certificate()).toContain("residual of loops");
    await event("break bearing").click();
    expect(await certificate()).not.toContain("loops");
    await page.getByLabel("Joint", { exact: true }).selectOption("bearing");
    expect(await page.getByLabel("Quantity of the joint").locator("option").allInnerTexts()).toContain("reaction force");
    await page.getByRole("tab", { name: "Times and energy" }).click();
    expect(await page.locator(".summary").innerText()).toContain("by closing loops and removing overlaps");
    expect(complaints).toEqual([]);
    await page.context().close();
  });
});

describe("the report of a run", () => {
  // One page for what leaves no trace in it but the time, to which each test goes itself.
  let page: Page;
  let complaints: string[];
  beforeAll(async () => {
    ({ page, complaints } = await openReport(browser, chain));
  });
  afterAll(() => page?.context().close());

  it("opens from disk without messages or requests", async () => {
    expect(await page.title()).toBe("Breaking chain – momentree");
    await page.getByRole("note").getByText("the energy balance is off by").waitFor();
    expect(await clock(page)).toBe("0.000 s");
    expect(await names(page)).toEqual(["chain"]);
    expect(complaints).toEqual([]);
    const data = /id="recording">([^<]*)</.exec(readFileSync(join(chain, "report.html"), "utf8"))![1];
    expect(statSync(join(chain, "report.html")).size - data.length).toBeLessThan(1e6);
  });

  it("plays, and stops at the end", async () => {
    await page.keyboard.press("Home");
    await page.getByRole("button", { name: "Play", exact: true }).click();
    await page.waitForFunction(() => parseFloat(document.querySelector(".clock")!.textContent!) > 0.3);
    await page.getByRole("button", { name: "Pause", exact: true }).click();
    const stopped = await clock(page);
    await page.waitForTimeout(200);
    expect(await clock(page)).toBe(stopped);
    await page.getByLabel("Speed").selectOption("5");
    await page.keyboard.press("Escape");
    await page.getByRole("button", { name: "Play", exact: true }).click();
    await page.waitForFunction(() => document.querySelector(".clock")!.textContent === "3.000 s");
    await page.getByRole("button", { name: "Play", exact: true }).waitFor();
    await page.getByLabel("Speed").selectOption("1");
    expect(complaints).toEqual([]);
  });

  it("its slider sets the time, also by the pointer, and pauses", async () => {
    await page.keyboard.press("Home");
    await page.getByRole("button", { name: "Play", exact: true }).click();
    const slider = page.getByLabel("Time", { exact: true });
    await slider.fill("500");
    expect(await clock(page)).toBe("1.500 s");
    await page.getByRole("button", { name: "Play", exact: true }).waitFor();
    const box = (await slider.boundingBox())!;
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.8 * box.width, box.y + box.height / 2, { steps: 4 });
    await page.mouse.up();
    expect(parseFloat(await clock(page))).toBeCloseTo(2.4, 1);
    expect(complaints).toEqual([]);
  });

  it("jumps to the break: two mechanisms in two colours, the pair before and after, and the certificate", async () => {
    const { page, complaints } = await openReport(browser, chain);
    const colours = [mechanismColour(light, 0), mechanismColour(light, 1)];
    await page.getByRole("button", { name: "Ghosts" }).click();
    await page.getByRole("button", { name: "Trails" }).click();
    await settled(page);
    const before = await pixelsLike(page, ".stage canvas", colours);
    expect(before[0]).toBeGreaterThan(800);
    expect(before[1]).toBe(0);
    await page.locator(".marks button").click();
    expect(await clock(page)).toBe("1.800 s");
    expect(await names(page)).toEqual(["chain", "chain/41"]);
    await settled(page);
    const after = await pixelsLike(page, ".stage canvas", colours);
    expect(after[0]).toBeGreaterThan(300);
    expect(after[1]).toBeGreaterThan(300);
    const [first, second] = [
      await pixelsLike(page, ".pair figure:nth-child(1) canvas", colours),
      await pixelsLike(page, ".pair figure:nth-child(2) canvas", colours),
    ];
    expect([first[0] > 50, first[1], second[0] > 20, second[1] > 20]).toEqual([true, 0, true, true]);
    const [event] = readFileSync(join(chain, "events.jsonl"), "utf8")
      .trim()
      .split("\n")
      .map((line) => JSON.parse(line));
    const energy = await page.locator(".certificate tbody tr").first().locator("td").allInnerTexts();
    expect(Number(energy[0])).toBeCloseTo(event.before.kinetic + event.before.potential, 4);
    expect(Math.abs(Number(energy[2].replaceAll("−", "-")))).toBeLessThan(1e-12);
    await keep(page, "chain_at_the_break");
    expect(complaints).toEqual([]);
    await page.context().close();
  });

  it("plots show the time of the picture and the numbers of the tables; a click on one sets the time", async () => {
    await page.getByLabel("Time", { exact: true }).fill("400");
    expect(await clock(page)).toBe("1.200 s");
    const row = csv(chain, "energy.csv").find(({ time }) => Math.abs(time - 1.2) < 1e-9)!;
    expect(await shown(page, "kinetic")).toBeCloseTo(row.kinetic, 2);
    expect(await shown(page, "x")).toBeCloseTo(row["linear.x"], 3);
    await page.getByLabel("Joint", { exact: true }).selectOption("chain/7");
    await page.getByLabel("Quantity of the joint").selectOption("v");
    const joint = csv(chain, "joints.csv").find(({ time }) => Math.abs(time - 1.2) < 1e-9)!;
    expect(await shown(page, "v0")).toBeCloseTo(joint["chain/7.v0"], 2);
    // The legend has the values under the pointer, in all plots.
    const over = (await page.locator(".u-over").first().boundingBox())!;
    await page.mouse.move(over.x + over.width / 4, over.y + 20);
    const under = csv(chain, "energy.csv").find(({ time }) => Math.abs(time - 0.75) < 0.011)!;
    expect(Math.abs((await shown(page, "kinetic")) / under.kinetic - 1)).toBeLessThan(0.1);
    expect(await shown(page, "v0")).not.toBeCloseTo(joint["chain/7.v0"], 2);
    await page.mouse.move(over.x + over.width / 4, over.y - 60);
    expect(await shown(page, "kinetic")).toBeCloseTo(row.kinetic, 2);
    await page.mouse.click(over.x + over.width / 2, over.y + 20);
    expect(parseFloat(await clock(page))).toBeCloseTo(1.5, 1);
    const line = (await page.locator(".now").first().boundingBox())!;
    expect(line.x - over.x).toBeCloseTo(over.width / 2, -0.5);
  });

  it("plots fill their boxes, and their axes are whole, with legends of one and of several lines", async () => {
    const { page: other } = await openReport(browser, report(scenario("dominoes.toml")), desktop, 0.5);
    for (const joint of [1, 3]) {
      await other.getByLabel("Joint", { exact: true }).selectOption({ index: joint });
      const spare = await other
        .locator(".plot")
        .evaluateAll((all) => all.map((e) => e.clientHeight - e.querySelector<HTMLElement>(".uplot")!.offsetHeight));
      expect(spare.length).toBe(3);
      for (const height of spare) expect(Math.abs(height)).toBeLessThanOrEqual(1);
    }
    await other.context().close();
  });

  it("is controlled by the keyboard, and describes the picture", async () => {
    await page.keyboard.press("Home");
    await page.keyboard.press("Shift+ArrowRight");
    expect(await clock(page)).toBe("1.800 s");
    await page.keyboard.press("ArrowRight");
    expect(await clock(page)).toBe("1.820 s");
    await page.keyboard.press("End");
    expect(await clock(page)).toBe("3.000 s");
    await page.keyboard.press("Shift+ArrowLeft");
    expect(await clock(page)).toBe("1.800 s");
    await page.keyboard.press("Home");
    expect(await clock(page)).toBe("0.000 s");
    expect(await page.locator(".stage canvas").getAttribute("aria-label")).toContain("100 bodies in 1 mechanism at 0.000 s");
    await page.keyboard.press("g");
    expect(await page.getByRole("button", { name: "Ghosts" }).getAttribute("aria-pressed")).toBe("false");
    await page.getByRole("tab", { name: "Events" }).focus();
    await page.keyboard.press("ArrowRight");
    expect(await page.getByRole("tabpanel").innerText()).toContain("Topology change");
    const nameless = await page
      .locator("button, select, input")
      .evaluateAll((all) =>
        all
          .filter((e) => !(e.getAttribute("aria-label") || e.textContent?.trim() || e.getAttribute("title")))
          .map((e) => e.outerHTML),
      );
    expect(nameless).toEqual([]);
    expect(complaints).toEqual([]);
  });

  it("a click on a body shows its joint in the plots", async () => {
    await page.keyboard.press("Home");
    const box = (await page.locator(".stage canvas").boundingBox())!;
    const before = await page.getByLabel("Joint", { exact: true }).inputValue();
    // Somewhere on the chain at its start: the first place along a line of tries.
    for (let i = 1; i < 60 && (await page.getByLabel("Joint", { exact: true }).inputValue()) === before; i++)
      await page.mouse.click(box.x + (box.width * i) / 60, box.y + 0.35 * box.height);
    expect(await page.getByLabel("Joint", { exact: true }).inputValue()).not.toBe(before);
  });

  it("names and titles are text, whatever they contain", async () => {
    const text = readFileSync(scenario("pendulum.toml"), "utf8");
    const nasty = "</script><script>alert(1)</script><img src=x onerror=alert(2)>";
    const file = join(temporary(), "nasty.toml");
    writeFileSync(file, text.replace(/^title.*$/m, `title = "${nasty}"`));
    const { page, complaints } = await openReport(browser, report(file));
    expect(await page.locator("h1").innerText()).toBe(nasty);
    expect(complaints).toEqual([]);
    await page.context().close();
  });
});

describe.each([
  ["breaking_chain", 2.05],
  ["panda_lets_go", 1.3],
  ["humanoid_loses_a_forearm", 0.75],
  ["crane", 4.0],
  ["falling_chimney", 4.2],
  ["capture", 2.6],
])("%s", (name, time) => {
  it("fits a desktop, and a window of the size of a phone in the dark, and is drawn", async () => {
    const { page, complaints } = await openReport(browser, reportOf(name), desktop, time);
    await fits(page, desktop);
    await keep(page, `${name}_desktop`);
    await page.emulateMedia({ colorScheme: "dark" });
    await page.setViewportSize({ width: phone.width, height: phone.height });
    await page.keyboard.press("f");
    await settled(page);
    await fits(page, { ...phone, dark: true });
    await keep(page, `${name}_phone_dark`, true);
    expect(complaints).toEqual([]);
    await page.context().close();
  });
});

it.each([
  ["phone", phone],
  ["desktop_dark", { ...desktop, dark: true }],
] as const)("the report opens at once on a %s as it must be", async (kind, view) => {
  const { page, complaints } = await openReport(browser, chain, view, 2.05);
  await fits(page, view);
  await keep(page, `breaking_chain_${kind}`, view.width < 800);
  expect(complaints).toEqual([]);
  await page.context().close();
});

/** Nothing is beside the window, and the mechanism is drawn. */
async function fits(page: Page, view: View) {
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  const theme = themeOf(view.dark ?? false);
  const [seen, white] = await pixelsLike(page, ".stage canvas", [mechanismColour(theme, 0), "#e6e8ec"], 90);
  expect(view.dark ? seen + white : seen).toBeGreaterThan(view.dark ? 150 : 50); // of long thin chains, too
  if (view.width < 1000) return;
  for (const box of await page.locator(".plots figure").evaluateAll((all) => all.map((e) => e.getBoundingClientRect())))
    expect([box.bottom <= view.height + 1, box.height > 120]).toEqual([true, true]); // beside the picture, not below the fold
}

const reports = new Map<string, string>();
function reportOf(name: string): string {
  if (name === "breaking_chain") return chain;
  if (!reports.has(name)) reports.set(name, report(scenario(`${name}.toml`), "--reactions"));
  return reports.get(name)!;
}
