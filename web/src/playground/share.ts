// A scenario as a link: in the fragment, which is never sent to a server. It has the scenario's text, compressed, or the name of
// one of the gallery, or the address of a file.

/** Larger than any scenario; a few bytes can inflate to any size. */
const mostBytes = 32e6;

const streamOf = (bytes: Uint8Array, through: GenericTransformStream) =>
  new Blob([bytes as BlobPart]).stream().pipeThrough(through as ReadableWritablePair<Uint8Array, Uint8Array>);

/** Throws if the bytes are incomplete, or inflate to more than `most`. */
export async function inflated(bytes: Uint8Array, most = Infinity): Promise<Uint8Array> {
  const reader = streamOf(bytes, new DecompressionStream("deflate")).getReader();
  const parts: Uint8Array[] = [];
  let size = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    parts.push(value);
    size += value.length;
    if (size > most) {
      await reader.cancel();
      throw new RangeError("too large");
    }
  }
  return new Uint8Array(await new Blob(parts as BlobPart[]).arrayBuffer());
}

const deflated = async (bytes: Uint8Array) =>
  new Uint8Array(await new Response(streamOf(bytes, new CompressionStream("deflate"))).arrayBuffer());

export const bytesOf = (base64: string) => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));

/** `floor`: of a scenario with the floor of this page, which older pages do not have. */
export async function fragmentOf(text: string, floor = false): Promise<string> {
  const packed = await deflated(new TextEncoder().encode(text));
  let binary = "";
  for (const byte of packed) binary += String.fromCharCode(byte);
  return `#s${floor ? onFloor : ""}=${btoa(binary).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "")}`;
}

/** The content of an address's fragment: nothing, a scenario, or unreadable data and the reason. */
export type Link =
  | { readonly content: "nothing" }
  | { readonly content: "scenario"; readonly text: string; readonly floor: boolean }
  | { readonly content: "name"; readonly name: string }
  | { readonly content: "address"; readonly address: string }
  | { readonly content: "error"; readonly message: string };

/** The version of links to scenarios with the floor of this page. */
const onFloor = "1";

const damaged = "It may have been cut off or changed when it was copied or sent. Ask for it again.";

function decoded(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

/** The text of a scenario at an address, which may be relative to the page. Throws if it can't be loaded. */
export async function textAt(address: string, page: string): Promise<string> {
  const url = new URL(address, page);
  if (!/^https?:$/.test(url.protocol)) throw new Error("addresses begin with https://");
  const response = await fetch(url);
  if (!response.ok) throw new Error(`the server answered ${response.status} ${response.statusText}`.trim());
  const bytes = await response.arrayBuffer();
  if (bytes.byteLength > mostBytes) throw new Error("the file is too large");
  return new TextDecoder().decode(bytes);
}

export async function linkOf(fragment: string): Promise<Link> {
  if (fragment === "" || fragment === "#") return { content: "nothing" };
  const elsewhere = /^#(scenario|url)=(.+)$/s.exec(fragment);
  if (elsewhere?.[1] === "scenario") return { content: "name", name: decoded(elsewhere[2]) };
  if (elsewhere) return { content: "address", address: decoded(elsewhere[2]) };
  const found = /^#s(\d*)=([\w-]*)(.*)$/s.exec(fragment);
  if (!found) return { content: "error", message: `This address does not end with a scenario. ${damaged}` };
  const [, version, base64, rest] = found;
  if (version !== "" && version !== onFloor)
    return { content: "error", message: "This link was made by a newer version of momentree. Open it with that." };
  try {
    if (/[^\s.,;:!?)\]>"'*]/.test(rest)) throw new Error("not base64"); // a sentence's punctuation is harmless
    const bytes = await inflated(bytesOf(base64.replace(/-/g, "+").replace(/_/g, "/")), mostBytes);
    const text = new TextDecoder("utf-8", { fatal: true }).decode(bytes);
    return { content: "scenario", text, floor: version === onFloor };
  } catch {
    return { content: "error", message: `The link to this scenario is damaged. ${damaged}` };
  }
}

/** Where a link to this page can be opened, as text; empty: anywhere. */
export function scopeOf({ protocol, hostname }: Pick<Location, "protocol" | "hostname">): string {
  if (protocol === "file:") return "it opens where this file is";
  if (hostname === "127.0.0.1" || hostname === "localhost") return "it opens on this machine until the command ends";
  return "";
}
