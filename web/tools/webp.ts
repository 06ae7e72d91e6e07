import type { Page } from "playwright-core";

/** A PNG as WebP, a quarter of its size: encoded by the browser itself, in a page without a content policy. */
export async function webp(page: Page, png: Buffer, quality = 0.86): Promise<Buffer> {
  const text = await page.evaluate(
    async ([data, quality]) => {
      const image = new Image();
      image.src = `data:image/png;base64,${data}`;
      await image.decode();
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [image.width, image.height];
      canvas.getContext("2d")!.drawImage(image, 0, 0);
      return canvas.toDataURL("image/webp", quality).split(",")[1];
    },
    [png.toString("base64"), quality] as const,
  );
  return Buffer.from(text, "base64");
}

function chunk(name: string, ...parts: Buffer[]): Buffer {
  const data = Buffer.concat(parts);
  const size = Buffer.alloc(4);
  size.writeUInt32LE(data.length);
  return Buffer.concat([Buffer.from(name), size, data, Buffer.alloc(data.length % 2)]);
}

function uint24(...numbers: number[]): Buffer {
  const bytes = Buffer.alloc(3 * numbers.length);
  numbers.forEach((number, i) => bytes.writeUIntLE(number, 3 * i, 3));
  return bytes;
}

/** The chunks of an image in a WebP file that an animation takes over. */
function imageOf(file: Buffer): Buffer {
  const taken: Buffer[] = [];
  for (let at = 12; at < file.length; ) {
    const end = at + 8 + file.readUInt32LE(at + 4);
    if (["VP8 ", "VP8L", "ALPH"].includes(file.toString("latin1", at, at + 4))) taken.push(file.subarray(at, end + (end % 2)));
    at = end + (end % 2);
  }
  return Buffer.concat(taken);
}

/** WebP files of equal size as an animated one, which repeats forever. Each is shown for its duration (ms). */
export function animation(frames: readonly { image: Buffer; duration: number }[], width: number, height: number): Buffer {
  const animated = 0b10;
  const size = uint24(width - 1, height - 1);
  const header = chunk("VP8X", Buffer.from([animated, 0, 0, 0]), size);
  const forever = chunk("ANIM", Buffer.from([255, 255, 255, 255, 0, 0]));
  const noBlending = Buffer.from([0b10]);
  const all = frames.map(({ image, duration }) =>
    chunk("ANMF", uint24(0, 0), size, uint24(duration), noBlending, imageOf(image)),
  );
  return chunk("RIFF", Buffer.from("WEBP"), header, forever, ...all);
}
