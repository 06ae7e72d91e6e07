// A scenario as a link: compressed, in the fragment, which is never sent to a server.

const through = async (bytes: Uint8Array, stream: GenericTransformStream): Promise<Uint8Array> => {
  const out = new Response(
    new Blob([bytes as BlobPart]).stream().pipeThrough(stream as ReadableWritablePair<Uint8Array, Uint8Array>),
  );
  return new Uint8Array(await out.arrayBuffer());
};

export const inflated = (bytes: Uint8Array) => through(bytes, new DecompressionStream("deflate"));
const deflated = (bytes: Uint8Array) => through(bytes, new CompressionStream("deflate"));

export const bytesOf = (base64: string) => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));

export async function fragmentOf(text: string): Promise<string> {
  const packed = await deflated(new TextEncoder().encode(text));
  let binary = "";
  for (const byte of packed) binary += String.fromCharCode(byte);
  return `#s=${btoa(binary).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "")}`;
}

/** The text of a fragment; null where it has none, or what is there is no text of ours. */
export async function textOf(fragment: string): Promise<string | null> {
  const found = /^#s=([\w-]+)$/.exec(fragment);
  if (!found) return null;
  try {
    const bytes = await inflated(bytesOf(found[1].replace(/-/g, "+").replace(/_/g, "/")));
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    return null;
  }
}
