// Columns as stored in the report's data: base64 of little-endian numbers.

const littleEndian = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;

export function bytesOf(base64: string, size: number): ArrayBuffer {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  if (!littleEndian) for (let i = 0; i < bytes.length; i += size) bytes.subarray(i, i + size).reverse();
  return bytes.buffer;
}

export const floats = (base64: string) => new Float32Array(bytesOf(base64, 4));
export const shorts = (base64: string) => new Uint16Array(bytesOf(base64, 2));
export const doubles = (base64: string) => new Float64Array(bytesOf(base64, 8));

/** The column with that index, from rows of `width` numbers. */
export function column(rows: Float32Array | Float64Array, width: number, place: number): Float64Array {
  const values = new Float64Array(rows.length / width);
  for (let row = 0; row < values.length; row++) values[row] = rows[row * width + place];
  return values;
}
