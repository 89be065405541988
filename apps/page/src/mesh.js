// The faces of a page with their nodes, the elements behind them, and values on either.
import { columns, ids, integers, numbers, octets } from "./arrays.js";

const cornersOf = 3;
const edges = [
  [0, 1],
  [1, 2],
  [2, 0],
];

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
    octets("keys"),
  ]);
  const places = placed(faceNodes, perFace, coordinates);
  return { ...behind, perFace, faceNodes, places, bends: bends(places), keys };
}

/// The step of the cut along `axis` at which an element comes to be kept.
export const keyOf = (mesh, element, axis, elements) => mesh.keys[axis * elements + element];

export const isInner = (mesh, face) => mesh.back[face] !== noElement;

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

export { edges };
