// How fast the playground draws 500 bodies on this machine, by its own counter: npm run frames.
import { fragmentOf } from "../src/playground/share";
import { desktop, launch, open, playgroundAddress } from "../tests/browser";

const chains = Array.from(
  { length: 5 },
  (_none, i) => `[[mechanism]]
name = "chain${i}"
pose = { xyz = [0, ${i}, 0] }
[mechanism.chain]
links = 100
length = 0.05
mass = 0.01
inertia = 2e-6
axis = [0, 1, 0]
angle = "2 deg"
`,
);
const text = `format = 1
title = "Five chains"
${chains.join("")}
[integrate]
step = 2e-3
`;

const browser = await launch();
const { page } = await open(browser, playgroundAddress + (await fragmentOf(text)), desktop);
await page.waitForFunction(() => window.playground?.app.run?.model.bodies.length === 500);
await page.getByRole("button", { name: "Play", exact: true }).click();
await page.waitForTimeout(10_000);
const { rate, duration } = (await page.evaluate(() => window.playground.frameRate()))!;
console.log(
  `500 bodies: ${rate.toFixed(1)} frames/s drawn by the processor, ${(1000 * duration).toFixed(1)} ms of the page for each`,
);
await browser.close();
