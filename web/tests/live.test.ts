// `momentree view --live`: the world of a running program in the page.
import { spawn, type ChildProcess } from "node:child_process";
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, it } from "vitest";
import { keep, launch, open, phone, phoneAcross, program, scenario, type View } from "./browser";

let browser: Browser;
let server: ChildProcess | null = null;
beforeAll(async () => {
  browser = await launch();
});
afterAll(() => browser?.close());
afterEach(async () => {
  server?.kill("SIGKILL");
  for (const context of browser.contexts()) await context.close();
});

/** Machines that draw by the processor take their time. */
const patience = { timeout: 80_000 };

function serve(file: string, ...options: string[]): Promise<string> {
  const child = spawn(program, ["view", "--live", scenario(file), "--no-browser", ...options], {
    stdio: ["ignore", "pipe", "ignore"],
  });
  server = child;
  return new Promise((told, failed) => {
    child.stdout.on("data", (text: Buffer) => told(text.toString().trim()));
    child.on("exit", (code) => failed(new Error(`it ended with ${code}`)));
  });
}

const ended = () =>
  new Promise<number | null>((told) => {
    server!.removeAllListeners("exit").on("exit", told);
  });

/** A page takes what the program sends with each picture, and the processor draws small ones sooner. */
const small: View = { width: 840, height: 520 };

async function live(address: string, view: View = small) {
  const opened = await open(browser, address, view);
  await opened.page.waitForFunction(() => Boolean(window.live?.app.run));
  return opened;
}
const moving = (page: Page, by = 0.1) =>
  page
    .evaluate((t) => window.live.app.run!.last.time + t, by)
    .then((time) => page.waitForFunction((t) => window.live.app.run!.last.time > t, time, patience));

it("shows the run as it goes on, in two pages at once", async () => {
  const address = await serve("four_bar.toml");
  const { page, complaints } = await live(address);
  await moving(page, 1);
  expect(await page.locator("h1").innerText()).not.toBe("momentree");
  const other = await live(address, { width: 500, height: 300 });
  await moving(other.page);
  // A page that is opened late begins its record there.
  expect(await other.page.evaluate(() => window.live.app.run!.time(0))).toBeGreaterThan(0.8);
  await keep(page, "live");
  expect([...complaints, ...other.complaints]).toEqual([]);
});

it("pauses, cuts and welds in the program", async () => {
  const { page, complaints } = await live(await serve("breaking_chain.toml"));
  await moving(page);
  await page.getByRole("button", { name: "Pause", exact: true }).click();
  await page.waitForFunction(() => !window.live.app.playing);
  const before = await page.evaluate(() => window.live.app.topology.mechanisms.length);
  await page.getByLabel("Joint", { exact: true }).selectOption({ index: 5 });
  await page.locator("fieldset.joint").getByRole("button", { name: "Break", exact: true }).click();
  await page.waitForFunction((n) => window.live.app.topology.mechanisms.length === n + 1, before, patience);
  await page.getByRole("button", { name: "Play", exact: true }).click();
  await moving(page);
  expect(await page.locator(".history").innerText()).toContain("break");
  expect(await page.getByRole("button", { name: "Undo" }).count()).toBe(0);
  expect(complaints).toEqual([]);
});

it.each([
  ["phone", phone],
  ["across", phoneAcross],
])("is readable on a phone: %s", async (name, view) => {
  const { page, complaints } = await live(await serve("crane.toml"), { ...view, scale: 1 });
  await moving(page);
  await keep(page, `live-${name}`);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  expect(wide).toBeLessThanOrEqual(0);
  expect(complaints).toEqual([]);
});

it("ends with Stop, and the page says so", async () => {
  const { page } = await live(await serve("pendulum.toml"));
  await moving(page);
  const end = ended();
  await page.getByRole("button", { name: "Stop", exact: true }).click();
  expect(await end).toBe(0);
  await page.waitForFunction(() => document.body.innerText.includes("The program has ended"), undefined, patience);
  for (const name of ["Grab", "Break", "Play"])
    expect(await page.getByRole("button", { name, exact: true }).first().isDisabled(), name).toBe(true);
  expect(await page.getByLabel("Time", { exact: true }).isEnabled()).toBe(true); // what it showed can be seen again
});

it("ends on Ctrl-C", async () => {
  const { page } = await live(await serve("pendulum.toml"));
  const end = ended();
  server!.kill("SIGINT");
  expect(await end).toBe(0);
  await page.waitForFunction(() => document.body.innerText.includes("The program has ended"), undefined, patience);
});
