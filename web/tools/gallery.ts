// The pictures of docs/gallery.md: the motion in a scenario's report, at a chosen time, in docs/pictures/gallery.
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Browser, Page } from "playwright-core";
import { openReport, report, scenario, settled } from "../tests/browser";
import { webp } from "./webp";

/** Scenario and time (s) of each picture, in the order of the page. */
const scenes: readonly (readonly [string, number])[] = [
  ["breaking_chain_accurate", 2.05],
  ["falling_chimney", 3.9],
  ["partial_failure", 2.9],
  ["guyed_mast", 4.4],
  ["crane", 4.0],
  ["drop_the_load", 2.0],
  ["capture", 3.6],
  ["modular_robot", 4.0],
  ["chain_to_ring", 1.6],
  ["four_bar", 1.7],
  ["excavator", 3.0],
  ["two_arms_hold_a_bar", 2.6],
  ["jammed_joint", 1.4],
  ["servo_arm", 4.5],
  ["panda_lets_go", 1.3],
  ["ur5_power_cut", 0.8],
  ["quadruped_knee", 0.6],
  ["humanoid_loses_a_forearm", 0.6],
  ["iiwa_falls_to_its_stops", 0.6],
  ["tree_of_joints", 1.0],
  ["hanging_boxes_fall", 1.27],
  ["crane_sets_down", 2.57],
  ["leaking_gripper", 2.54],
  ["chimney_comes_to_rest", 5.1],
  ["rocking_block", 0.9],
  ["rimless_wheel", 3.5],
  ["bicycle", 1.6],
  ["dominoes", 0.75],
  ["chain_piles_up", 1.0],
  ["wrecking_ball", 2.2],
  ["walker_falls", 5.0],
];

export async function drawGallery(browser: Browser, folder: string, encoder: Page) {
  mkdirSync(join(folder, "gallery"), { recursive: true });
  for (const [name, time] of scenes) {
    const view = { width: 1040, height: 800, scale: 2 };
    const { page, complaints } = await openReport(browser, report(scenario(`${name}.toml`)), view, time);
    if (complaints.length > 0) throw new Error(complaints.join("\n"));
    await settled(page);
    const image = await webp(encoder, await largePicture(page, encoder));
    writeFileSync(join(folder, "gallery", `${name}.webp`), image);
    console.log(`docs/pictures/gallery/${name}.webp: ${Math.round(image.length / 1000)} kB`);
    await page.context().close();
  }
}

/** The 3D picture without what is over it. */
async function pictureOf(page: Page): Promise<Buffer> {
  await page.evaluate(() => {
    for (const over of document.querySelectorAll<HTMLElement>(".stage > :not(canvas)")) over.style.visibility = "hidden";
    (document.activeElement as HTMLElement).blur();
  });
  return page.locator(".stage").screenshot();
}

/** The part of the picture around the bodies, which are found by their contrast in a picture without ghosts, trails and floor. */
async function largePicture(page: Page, encoder: Page): Promise<Buffer> {
  const whole = await pictureOf(page);
  await page.locator(".stage canvas").focus();
  for (const key of "gt") await page.keyboard.press(key);
  await settled(page);
  const bare = await pictureOf(page);
  const text = await encoder.evaluate(
    async ([whole, bare]) => {
      const drawn = async (data: string) => {
        const image = new Image();
        image.src = `data:image/png;base64,${data}`;
        await image.decode();
        const canvas = document.createElement("canvas");
        [canvas.width, canvas.height] = [image.width, image.height];
        const context = canvas.getContext("2d", { willReadFrequently: true })!;
        context.drawImage(image, 0, 0);
        return { canvas, pixels: context.getImageData(0, 0, image.width, image.height).data };
      };
      const { canvas } = await drawn(whole);
      const { width, height } = canvas;
      const bodies = (await drawn(bare)).pixels;
      let [left, right, top, bottom] = [width, 0, height, 0];
      for (let y = 0; y < height; y++)
        for (let x = 0; x < width; x++) {
          const i = 4 * (y * width + x);
          const [r, g, b] = [bodies[i], bodies[i + 1], bodies[i + 2]];
          if (Math.max(r, g, b) - Math.min(r, g, b) < 50 && Math.min(r, g, b) > 110) continue; // ground, shadow, grid
          [left, right] = [Math.min(left, x), Math.max(right, x)];
          [top, bottom] = [Math.min(top, y), Math.max(bottom, y)];
        }
      // Bodies fill two thirds of the picture in one direction; its sides are as 3 to 2.
      const size = Math.min(Math.max((right - left) / 0.7, (1.5 * (bottom - top)) / 0.7, 500), width, 1.5 * height);
      const within = (middle: number, part: number, all: number) => Math.min(Math.max(middle - part / 2, 0), all - part);
      const cut = document.createElement("canvas");
      [cut.width, cut.height] = [900, 600];
      const at = [within((left + right) / 2, size, width), within((top + bottom) / 2, size / 1.5, height)] as const;
      const to = cut.getContext("2d")!;
      to.imageSmoothingQuality = "high";
      to.drawImage(canvas, ...at, size, size / 1.5, 0, 0, 900, 600);
      return cut.toDataURL("image/png").split(",")[1];
    },
    [whole.toString("base64"), bare.toString("base64")] as const,
  );
  return Buffer.from(text, "base64");
}
