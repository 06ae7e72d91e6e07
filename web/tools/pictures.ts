// Draws the pictures of docs/pictures from actual runs: `./dev web pictures`, after the program was built. That of a sweep is
// of the pendulum in closed form that the tests of its page use.
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import type { Page } from "playwright-core";
import { drawGallery } from "./gallery";
import { launch, open, openReport, report, scenario, settled, temporary } from "../tests/browser";
import { builtPage, pendulumSweep, sweepPage } from "../tests/pendulum_sweep";
import { animation, webp } from "./webp";

const folder = new URL("../../docs/pictures/", import.meta.url).pathname;

interface Picture {
  readonly name: string;
  readonly scenario: string;
  readonly time: number;
  readonly dark?: boolean;
  readonly width: number;
  readonly height: number;
}

const pictures: readonly Picture[] = [
  { name: "report_chain", scenario: "breaking_chain_accurate.toml", time: 2.05, width: 1280, height: 800 },
  { name: "report_crane", scenario: "crane.toml", time: 4.0, dark: true, width: 1280, height: 800 },
];

/** Just after a joint of the swinging chain was broken by hand. */
async function breakByHand(page: Page) {
  const playTo = async (time: number) => {
    await page.getByRole("button", { name: "Play", exact: true }).click();
    await page.waitForFunction((t) => window.playground.app.run!.last.time >= t, time);
    await page.getByRole("button", { name: "Pause", exact: true }).click();
  };
  await page.waitForFunction(() => Boolean(window.playground?.app.run));
  await page.getByLabel("Speed").selectOption("0.25");
  await playTo(0.4);
  await page.getByRole("combobox", { name: "Joint" }).selectOption("chain/31");
  await page.getByRole("group", { name: "Joint" }).getByRole("button", { name: "Break", exact: true }).click();
  await page.waitForFunction(() => window.playground.app.topology.mechanisms.length === 2);
  await playTo((await page.evaluate(() => window.playground.app.run!.last.time)) + 0.3); // a slow machine is later
}

const browser = await launch();
const encoder = await browser.newPage();
for (const { name, scenario: file, time, dark, width, height } of pictures) {
  const { page, complaints } = await openReport(
    browser,
    report(scenario(file), "--reactions"),
    { width, height, dark: dark ?? false },
    time,
  );
  if (complaints.length > 0) throw new Error(complaints.join("\n"));
  await settled(page);
  const image = await webp(encoder, await page.screenshot());
  writeFileSync(join(folder, `${name}.webp`), image);
  console.log(`docs/pictures/${name}.webp: ${Math.round(image.length / 1000)} kB`);
  await page.context().close();
}
/** The picture of README: the pin of an excavator breaks, at half the speed. */
async function drawMotion() {
  const [from, to, end] = [0.8, 2.2, 3];
  const [width, height, rate] = [860, 480, 12];
  const folderOfRun = report(scenario("excavator_pin.toml"), "--reactions", "--until", String(end));
  const { page, complaints } = await openReport(browser, folderOfRun, { width: 1560, height: 900 }, 1.4);
  await page.locator(".stage canvas").focus();
  for (const key of "gt++") await page.keyboard.press(key); // no ghosts and no trails, and nearer
  await page.evaluate(() => (document.activeElement as HTMLElement).blur());
  const frames: { image: Buffer; duration: number }[] = [];
  for (let time = from; time <= to; time += 0.5 / rate) {
    await page.getByLabel("Time", { exact: true }).evaluate(
      (slider, value) => {
        (slider as HTMLInputElement).value = String(value);
        slider.dispatchEvent(new Event("input"));
      },
      (1000 * time) / end,
    );
    await settled(page);
    const box = (await page.locator(".stage canvas").boundingBox())!;
    const clip = { x: box.x + (box.width - width) / 2, y: box.y + (box.height - height) / 2, width, height };
    const last = time + 0.5 / rate > to;
    frames.push({ image: await webp(encoder, await page.screenshot({ clip }), 0.7), duration: last ? 1500 : 1000 / rate });
  }
  if (complaints.length > 0) throw new Error(complaints.join("\n"));
  const file = animation(frames, width, height);
  writeFileSync(join(folder, "excavator_pin.webp"), file);
  console.log(`docs/pictures/excavator_pin.webp: ${Math.round(file.length / 1000)} kB`);
  await page.context().close();
}
await drawMotion();

/** The sweep's page with three of its measures, which leaves room for the scatter plot. */
async function drawSweep() {
  const data = pendulumSweep({ failing: [], animated: Array.from({ length: 600 }, (_none, world) => world) });
  const columns = data.columns.filter(({ name }) => !["speed", "lands", "end"].includes(name));
  const worst = data.worst!.slice(0, 1);
  const html = readFileSync(builtPage, "utf8");
  const address = pathToFileURL(sweepPage(temporary(), html, { ...data, columns, worst })).href;
  const { page, complaints } = await open(browser, address, { width: 1400, height: 1270 }, "h1");
  await page.getByLabel("Colour").selectOption("mechanism.pendulum.body.bob.joint.q");
  await settled(page);
  if (complaints.length > 0) throw new Error(complaints.join("\n"));
  writeFileSync(join(folder, "report_sweep.webp"), await webp(encoder, await page.screenshot()));
  console.log("docs/pictures/report_sweep.webp");
  await page.context().close();
}
await drawSweep();
await drawGallery(browser, folder, encoder);

const address = `${new URL("../dist/playground.html", import.meta.url).href}#scenario=breaking_chain_accurate`;
const { page } = await open(browser, address, { width: 1280, height: 800 });
await breakByHand(page);
await settled(page);
writeFileSync(join(folder, "playground_break.webp"), await webp(encoder, await page.screenshot()));
console.log("docs/pictures/playground_break.webp");
await browser.close();
