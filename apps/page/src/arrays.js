// The arrays of a page: base64 of a zlib stream of bytes, those of one significance side by side (docs/page.md).

const bytesOf = (text) =>
  Uint8Array.fromBase64 ? Uint8Array.fromBase64(text) : Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

async function unpacked(name) {
  const element = document.getElementById(`camber-${name}`);
  const packed = bytesOf(element.textContent.trim());
  element.remove(); // a large page need not keep it
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/// `count` words of 32 bits from their four planes of bytes, the lowest first.
function words(bytes, count, offset = 0) {
  const out = new Uint32Array(count);
  for (let i = 0; i < count; ++i)
    out[i] =
      bytes[offset + i] |
      (bytes[offset + count + i] << 8) |
      (bytes[offset + 2 * count + i] << 16) |
      (bytes[offset + 3 * count + i] << 24);
  return out;
}

export async function numbers(name) {
  const bytes = await unpacked(name);
  return new Float32Array(words(bytes, bytes.length / 4).buffer);
}

export async function integers(name) {
  const bytes = await unpacked(name);
  return new Int32Array(words(bytes, bytes.length / 4).buffer);
}

export const octets = unpacked;

/// Ids that count up by first use: each is told by how far it is below the next new one.
export async function ids(name) {
  const bytes = await unpacked(name);
  const out = words(bytes, bytes.length / 4);
  let next = 0;
  for (let i = 0; i < out.length; ++i) {
    out[i] = next - out[i];
    if (out[i] === next) ++next;
  }
  return out;
}

/// Columns of floats, one after the other.
export async function columns(name, count) {
  const all = await numbers(name);
  const rows = all.length / count;
  return Array.from({ length: count }, (_, c) => all.subarray(c * rows, (c + 1) * rows));
}
