// The pictures of docs/gallery.md: the motion in a scenario's report, at a chosen time, in docs/pictures/gallery.
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Browser, Page } from "playwright-core";
import { openReport, report, scenario, settled } from "../tests/browser";

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
  ["panda_lets_go", 1.6],
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

export async function drawGallery(browser: Browser, folder: string, webp: (png: Buffer) => Promise<Buffer>) {
  mkdirSync(join(folder, "gallery"), { recursive: true });
  for (const [name, time] of scenes) {
    const view = { width: 1040, height: 640 };
    const { page, complaints } = await openReport(browser, report(scenario(`${name}.toml`)), view, time);
    if (complaints.length > 0) throw new Error(complaints.join("\n"));
    await settled(page);
    const image = await webp(await pictureOf(page));
    writeFileSync(join(folder, "gallery", `${name}.webp`), image);
    console.log(`docs/pictures/gallery/${name}.webp: ${Math.round(image.length / 1000)} kB`);
    await page.context().close();
  }
}

/** The 3D picture without the buttons over it. */
async function pictureOf(page: Page): Promise<Buffer> {
  await page.evaluate(() => {
    for (const tools of document.querySelectorAll<HTMLElement>(".tools")) tools.style.visibility = "hidden";
  });
  return page.locator(".stage").screenshot();
}
