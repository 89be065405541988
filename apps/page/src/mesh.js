// The mesh of a page: the faces with their nodes, the elements behind them, and values on either. The arrays of a page are
// base64 of a zlib stream of bytes, those of one significance side by side (docs/page.md).

// ---------------------------------------------------------------- arrays

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

async function numbers(name) {
  const bytes = await unpacked(name);
  return new Float32Array(words(bytes, bytes.length / 4).buffer);
}

async function integers(name) {
  const bytes = await unpacked(name);
  return new Int32Array(words(bytes, bytes.length / 4).buffer);
}

/// Ids that count up by first use: each is told by how far it is below the next new one.
async function ids(name) {
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
async function columns(name, count) {
  const all = await numbers(name);
  const rows = all.length / count;
  return Array.from({ length: count }, (_, c) => all.subarray(c * rows, (c + 1) * rows));
}

// ---------------------------------------------------------------- faces and values

const cornersOf = 3;

/// Places of the nodes of each face: three corners, then how far the node of each edge is off the middle of its chord.
/// 18 numbers a face.
function placed(faceNodes, perFace, coordinates) {
  const faces = faceNodes.length / perFace;
  const out = new Float32Array(faces * 18);
  coordinates.forEach((column, axis) => {
    for (let f = 0; f < faces; ++f)
      for (let i = 0; i < perFace; ++i) out[18 * f + 3 * i + axis] = column[faceNodes[perFace * f + i]];
  });
  return out;
}

/// How far a face is from flat: the largest distance of a node from the middle of its chord.
function bends(places) {
  const out = new Float32Array(places.length / 18);
  for (let f = 0; f < out.length; ++f)
    for (let k = 9; k < 18; k += 3) {
      const [x, y, z] = [places[18 * f + k], places[18 * f + k + 1], places[18 * f + k + 2]];
      out[f] = Math.max(out[f], Math.hypot(x, y, z));
    }
  return out;
}

const noElement = 0xffffffff;

/// For each face the element that it is drawn for, and the one behind it, of inner faces.
async function owners({ faces, inner, worst }) {
  const all = await ids("owners");
  const front = new Uint32Array(faces + inner + worst);
  const back = new Uint32Array(faces + inner + worst).fill(noElement);
  front.set(all.subarray(0, faces));
  for (let i = 0; i < inner; ++i) {
    front[faces + i] = all[faces + 2 * i];
    back[faces + i] = all[faces + 2 * i + 1];
  }
  front.set(all.subarray(faces + 2 * inner), faces + inner);
  return { front, back };
}

export async function readMesh(page) {
  const perFace = page.degree === 2 ? 2 * cornersOf : cornersOf;
  const [faceNodes, coordinates, behind, keys] = await Promise.all([
    ids("faces"),
    columns("nodes", page.dimension),
    owners(page.counts),
    unpacked("keys"),
  ]);
  const places = placed(faceNodes, perFace, coordinates);
  return { ...behind, perFace, faceNodes, places, bends: bends(places), keys };
}

const readers = { elements: numbers, nodes: numbers, faces: integers };
const read = new Map();

/// The values of a quantity, unpacked when they are asked for.
export function valuesOf(quantity) {
  if (!read.has(quantity.key))
    read.set(quantity.key, (quantity.scale === "categories" ? integers : readers[quantity.on])(quantity.key));
  return read.get(quantity.key);
}

/// For each face whether the element that it is drawn for, and the one behind it, are drawn: 1 or 0. Of a face of the
/// boundary the first is 0 also if the face's own group is hidden.
export async function drawnOwners(mesh, counts, groups) {
  const elements = new Uint8Array(counts.elements).fill(1);
  const faces = new Uint8Array(mesh.front.length).fill(1);
  for (const { quantity, references } of groups) {
    const values = await valuesOf(quantity);
    const drawn = quantity.on === "elements" ? elements : faces;
    values.forEach((reference, i) => {
      if (references.has(reference)) drawn[i] = 0;
    });
  }
  return {
    front: Uint8Array.from(mesh.front, (e, f) => elements[e] & faces[f]),
    back: Uint8Array.from(mesh.back, (e) => (e === noElement ? 0 : elements[e])),
  };
}
