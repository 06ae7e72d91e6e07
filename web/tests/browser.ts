// A browser for tests and pictures: pages are opened from disk, what they complain about is kept.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium, type Browser, type Page } from "playwright-core";

const from = (name: string, standard: string) => process.env[name] ?? standard;
const repository = resolve(from("MOMENTREE_SOURCE", fileURLToPath(new URL("../..", import.meta.url))));
export const program = resolve(from("MOMENTREE_PROGRAM", join(repository, "build/release/momentree")));
export const scenario = (name: string) => join(repository, "scenarios", name);

const folders: string[] = [];

/** A folder for what a test writes. */
export function temporary(): string {
  folders.push(mkdtempSync(join(tmpdir(), "momentree-web-")));
  return folders[folders.length - 1];
}

export function removeTemporary() {
  for (const folder of folders.splice(0)) rmSync(folder, { recursive: true, force: true });
}

/** Runs a scenario with its report; the result folder. */
export function report(file: string, ...options: string[]): string {
  const folder = join(temporary(), "result");
  execFileSync(program, ["run", file, "--report", "--quiet", "--out", folder, ...options], {
    stdio: ["ignore", "ignore", "pipe"],
  });
  return folder;
}

/** WebGL by the processor, as there is no graphics card where tests run, or none at all. */
export function launch({ webgl = true } = {}): Promise<Browser> {
  const paths = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
  const executablePath = process.env.CHROMIUM ?? paths.find((path) => existsSync(path));
  if (!executablePath) throw new Error("no Chromium is installed; CHROMIUM may say where it is");
  const gl = webgl ? ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] : ["--disable-3d-apis"];
  return chromium.launch({ executablePath, args: ["--no-sandbox", ...gl] });
}

/** What the playground tells programs. */
interface App {
  run: {
    frames: number;
    time(frame: number): number;
    last: { time: number; totals: Totals };
    events: { time: number }[];
    model: { bodies: unknown[] };
  } | null;
  topology: { joints: { child: number; kind: string; locked: number; name: string; loop?: boolean }[]; mechanisms: unknown[] };
  playing: boolean;
}
interface Totals {
  kinetic: number;
  linear: number[];
  angular: number[];
}
declare global {
  interface Window {
    playground: {
      app: App;
      placeOf(of: number | string): { x: number; y: number };
      frameRate(): { rate: number; duration: number } | null;
    };
    /** The same of a live view. */
    live: Window["playground"];
  }
}

export interface View {
  readonly width: number;
  readonly height: number;
  readonly dark?: boolean;
  readonly scale?: number;
  readonly touch?: boolean;
  readonly noScript?: boolean;
  /** The reader has no objection to motion: pages start to play. */
  readonly motion?: boolean;
}

export const desktop: View = { width: 1280, height: 800 };
export const phone: View = { width: 390, height: 844, scale: 2, touch: true };
export const phoneAcross: View = { width: 844, height: 390, scale: 2, touch: true };

export interface Opened {
  readonly page: Page;
  /** What stood in the console, was thrown, or was asked from anywhere but the page itself. */
  readonly complaints: string[];
}

/** `awaited`: what is there when the page has begun. */
export async function open(browser: Browser, address: string, view: View = desktop, awaited = "canvas"): Promise<Opened> {
  const context = await browser.newContext({
    viewport: { width: view.width, height: view.height },
    colorScheme: view.dark ? "dark" : "light",
    deviceScaleFactor: view.scale ?? 1,
    hasTouch: view.touch ?? false,
    reducedMotion: view.motion ? "no-preference" : "reduce",
    javaScriptEnabled: !view.noScript,
  });
  const page = await context.newPage();
  const complaints: string[] = [];
  page.on("console", (message) => complaints.push(`${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => complaints.push(`thrown: ${error.message}`));
  page.on("dialog", (dialog) => complaints.push(`dialog: ${dialog.message()}`) && void dialog.dismiss());
  page.on("request", (request) => {
    const own = address.split("#")[0];
    if (![own, `${own}/stream`, `${own}/act`].includes(request.url().split("#")[0]) && !/^(data|blob):/.test(request.url()))
      complaints.push(`asked for ${request.url()}`);
  });
  await page.goto(address);
  await page.waitForSelector(awaited);
  if (!view.noScript) await settled(page);
  return { page, complaints };
}

export const openReport = (browser: Browser, folder: string, view?: View, time?: number, awaited?: string) =>
  open(browser, pathToFileURL(join(folder, "report.html")).href + (time === undefined ? "" : `#t=${time}`), view, awaited);

/** The playground's page, as it is built. */
export const playgroundAddress = pathToFileURL(
  join(fileURLToPath(new URL("..", import.meta.url)), "dist", "playground.html"),
).href;

/** Until what was asked for is drawn. */
export const settled = (page: Page) =>
  page.evaluate(
    () => new Promise<void>((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 30)))),
  );

/** Keeps what the page looks like, where the tests were told to. */
export async function keep(page: Page, name: string, fullPage = false) {
  const folder = process.env.MOMENTREE_SCREENSHOTS;
  if (!folder) return;
  mkdirSync(folder, { recursive: true });
  await page.screenshot({ path: join(folder, `${name}.png`), fullPage });
}

/** Of what a part of the page looks like: how many pixels are within `within` of each of some colours. */
export async function pixelsLike(page: Page, selector: string, colours: readonly string[], within = 40): Promise<number[]> {
  const png = (await page.locator(selector).screenshot()).toString("base64");
  return page.evaluate(
    async ([data, wanted, bound]) => {
      const image = new Image();
      image.src = `data:image/png;base64,${data}`;
      await image.decode();
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [image.width, image.height];
      const context = canvas.getContext("2d")!;
      context.drawImage(image, 0, 0);
      const { data: rgba } = context.getImageData(0, 0, canvas.width, canvas.height);
      return (wanted as string[]).map((colour) => {
        const [r, g, b] = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
        let count = 0;
        for (let i = 0; i < rgba.length; i += 4)
          if (Math.hypot(rgba[i] - r, rgba[i + 1] - g, rgba[i + 2] - b) < (bound as number)) count++;
        return count;
      });
    },
    [png, colours, within] as const,
  );
}

/** How many pixels of two screenshots of the same size differ by more than the rounding of translucent parts over the picture. */
export async function differing(page: Page, a: Buffer, b: Buffer): Promise<number> {
  return page.evaluate(
    async (screenshots) => {
      const [one, other] = await Promise.all(
        screenshots.map(async (png) => {
          const image = new Image();
          image.src = `data:image/png;base64,${png}`;
          await image.decode();
          const canvas = document.createElement("canvas");
          [canvas.width, canvas.height] = [image.width, image.height];
          const context = canvas.getContext("2d")!;
          context.drawImage(image, 0, 0);
          return context.getImageData(0, 0, canvas.width, canvas.height).data;
        }),
      );
      let count = 0;
      for (let i = 0; i < one.length; i++) if (Math.abs(one[i] - other[i]) > 3) count++;
      return count;
    },
    [a.toString("base64"), b.toString("base64")],
  );
}
