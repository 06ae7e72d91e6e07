// Draws the pictures of docs/examples from reports of their scenarios: part of `./dev web pictures`. Names of examples as
// arguments draw these alone.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Page } from "playwright-core";
import { launch, openReport, report, scenario, settled } from "../tests/browser";
import { webp } from "./webp";

const folder = new URL("../../docs/examples/pictures/", import.meta.url).pathname;

/**
 * `keys` are pressed on the picture: + and − zoom, arrows rotate; then the page saves it. With `joint`, the whole page is drawn,
 * with this joint in its plots.
 */
interface Picture {
  readonly name: string;
  readonly time: number;
  readonly keys: string;
  readonly joint?: string;
}

const pictures: readonly Picture[] = [
  { name: "debris_tug", time: 5.95, keys: "++++" },
  { name: "solar_array_jam", time: 11, keys: "" },
  { name: "blade_loss", time: 4.5, keys: "++>>>>>" },
  { name: "line_cascade", time: 5, keys: ">>>>>>v+++++++++++++" },
  { name: "crane", time: 4.0, keys: "" },
  { name: "excavator_pin", time: 1.4, keys: "+++" },
  { name: "hexapod", time: 2.7, keys: "++" },
  { name: "hand_over", time: 2.9, keys: "+++" },
  { name: "climbing_robot", time: 1.9, keys: "++" },
  { name: "chain_to_ring", time: 1.1, keys: "+++" },
  { name: "trapeze_catch", time: 2.1, keys: "++" },
  { name: "knee_ligament", time: 1.202, keys: ">>>>>++", joint: "leg/slide" },
];

const press: Readonly<Record<string, string>> = { "<": "ArrowLeft", ">": "ArrowRight", "^": "ArrowUp", v: "ArrowDown" };

async function saved(page: Page): Promise<Buffer> {
  const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("p")]);
  return readFileSync(await download.path());
}

mkdirSync(folder, { recursive: true });
const wanted = process.argv.slice(2);
const browser = await launch();
const encoder = await browser.newPage();
for (const { name, time, keys, joint } of pictures) {
  if (wanted.length > 0 && !wanted.includes(name)) continue;
  const { page, complaints } = await openReport(
    browser,
    report(scenario(`${name}.toml`), "--reactions"),
    { width: 1400, height: 900 },
    time,
  );
  await page.locator(".stage canvas").focus();
  for (const key of keys) await page.keyboard.press(press[key] ?? key);
  if (joint) await page.locator("select").filter({ hasText: joint }).first().selectOption(joint);
  await settled(page);
  const image = await webp(encoder, joint ? await page.screenshot() : await saved(page));
  if (complaints.length > 0) throw new Error(complaints.join("\n"));
  writeFileSync(join(folder, `${name}.webp`), image);
  console.log(`docs/examples/pictures/${name}.webp: ${Math.round(image.length / 1000)} kB`);
  await page.context().close();
}
await browser.close();
