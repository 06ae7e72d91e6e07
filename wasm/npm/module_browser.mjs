// Bundlers recognise this form of URL, and copy the module to where it can be fetched.
const address = new URL("./momentree.wasm", import.meta.url);

export async function readModule() {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`cannot load ${address}: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}
