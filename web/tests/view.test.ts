// `momentree view` and `play`: pages from 127.0.0.1, for this machine's browser alone.
import { spawn, type ChildProcess } from "node:child_process";
import { request, type IncomingMessage } from "node:http";
import type { Browser } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, it } from "vitest";
import { keep, launch, open, program, report, scenario, settled } from "./browser";

let browser: Browser;
let server: ChildProcess | null = null;
beforeAll(async () => {
  browser = await launch();
});
afterAll(() => browser?.close());
afterEach(() => server?.kill("SIGKILL"));

const view = (...what: string[]) => serving("view", ...what);

/** Starts a command; its address. */
function serving(...what: string[]): Promise<string> {
  const child = spawn(program, [...what, "--no-browser"], { stdio: ["ignore", "pipe", "ignore"] });
  server = child;
  return new Promise((told, failed) => {
    child.stdout.on("data", (text: Buffer) => told(text.toString().trim()));
    child.on("error", failed);
    child.on("exit", (code) => failed(new Error(`it ended with ${code}`)));
  });
}

/** Its exit code after Ctrl-C. */
const ended = () =>
  new Promise<number | null>((told) => {
    server!.removeAllListeners("exit").on("exit", told);
    server!.kill("SIGINT");
  });

const answer = (address: string, headers: Record<string, string>, method = "GET") =>
  new Promise<IncomingMessage>((told, failed) => {
    request(address, { headers, method }, (response) => {
      response.resume();
      told(response);
    })
      .on("error", failed)
      .end();
  });

it("shows a result, and ends on Ctrl-C", async () => {
  const address = await view(report(scenario("pendulum.toml")));
  expect(address).toMatch(/^http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]{32}$/);
  const { page, complaints } = await open(browser, address);
  expect(await page.locator("h1").innerText()).not.toBe("");
  expect(complaints).toEqual([]);
  await page.context().close();
  expect(await ended()).toBe(0);
});

it("serves only the page, only to this machine's browser, with a content policy", async () => {
  const address = await view(scenario("pendulum.toml"));
  const { host } = new URL(address);
  const port = host.split(":")[1];
  const status = async (headers: Record<string, string>, path = "", method = "GET") =>
    (await answer(path ? new URL(path, address).href : address, headers, method)).statusCode;
  expect(await status({ host })).toBe(200);
  expect(await status({ host: `localhost:${port}` })).toBe(200);
  expect(await status({ host: `rebound.example:${port}` })).toBe(403);
  expect(await status({ host: "127.0.0.1" })).toBe(403);
  expect(await status({ host, origin: "http://elsewhere.example" })).toBe(403);
  expect(await status({ host, origin: "null" })).toBe(403);
  expect(await status({ host, origin: `http://${host}` })).toBe(200);
  for (const path of ["/", "../etc/passwd", `${new URL(address).pathname}/x`]) expect(await status({ host }, path)).toBe(404);
  expect(await status({ host }, "", "POST")).toBe(405);
  expect(await status({ host, "content-length": "300000000" }, "", "POST")).toBe(413);
  const { headers } = await answer(address, { host });
  expect(headers["content-security-policy"]).toMatch(
    /^default-src 'none'; script-src 'sha256-[^']+'; .*frame-ancestors 'none'$/,
  );
  expect(headers["x-content-type-options"]).toBe("nosniff");
  expect(headers["access-control-allow-origin"]).toBeUndefined();
});

it("shows a model with a slider for each DoF, which moves it", async () => {
  const address = await view(scenario("models/panda/panda.urdf"));
  const { page, complaints } = await open(browser, address);
  expect(await page.locator("fieldset").count()).toBe(9);
  const before = await page.locator(".stage canvas").screenshot();
  const slider = page.getByLabel("panda/panda_joint2: angle");
  await slider.fill("0.8");
  await settled(page);
  expect(await page.locator("fieldset", { hasText: "panda_joint2" }).locator("output").innerText()).toBe("45.84°");
  expect((await page.locator(".stage canvas").screenshot()).equals(before)).toBe(false);
  await keep(page, "panda_posed");
  await page.keyboard.press("?");
  const help = page.getByRole("dialog", { name: "Help" });
  expect(await help.innerText()).toContain("slider");
  await page.keyboard.press("?");
  expect(await help.count()).toBe(0);
  await page.getByRole("button", { name: "Back to the start" }).click();
  await settled(page);
  expect((await page.locator(".stage canvas").screenshot()).equals(before)).toBe(true);
  expect(complaints).toEqual([]);
  await page.context().close();
});

it("plays with a model, as changed by --set, in the playground", async () => {
  const address = await serving("play", scenario("models/panda/panda.urdf"), "--set", "mechanism.panda.limits=false");
  const { page, complaints } = await open(browser, address);
  await page.waitForFunction(() => Boolean(window.playground?.app.run));
  expect(await page.getByLabel("Joint", { exact: true }).locator("option").allInnerTexts()).toContain("panda/panda_joint2");
  await page.getByRole("button", { name: "Play", exact: true }).click();
  await page.waitForFunction(() => window.playground.app.run!.last.time > 0.1);
  await keep(page, "playground-model");
  expect(complaints).toEqual([]);
  expect(await ended()).toBe(0);
});
