// Faces as instances of a lattice, in bins by how much they bend: each bin is as fine as its faces need on the screen.
import {
  BufferAttribute,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  InstancedInterleavedBuffer,
  InterleavedBufferAttribute,
  Mesh,
} from "three";

const chordError = 0.25; // pixels
const finest = 16;
const mostTriangles = 12e6;
const mostAlike = 3e6; // triangles, where all faces may be as fine as the one that needs it most
const fineness = [1, 2, 3, 4, 6, 8, 11, finest];
const binRatio = 4; // of bends: n doubles from bin to bin

function binned(bends, faces, size) {
  const bins = new Map();
  for (const f of faces) {
    const share = bends[f] / size;
    const bin = share > 1e-9 ? Math.ceil(Math.log(share) / Math.log(binRatio)) : -Infinity;
    if (!bins.has(bin)) bins.set(bin, []);
    bins.get(bin).push(f);
  }
  return [...bins].map(([bin, list]) => ({ bend: size * binRatio ** bin, faces: Uint32Array.from(list) }));
}

function keysOf(mesh, elements, faces, owner) {
  const keys = new Uint8Array(4 * faces.length);
  const axes = mesh.keys.length / elements;
  faces.forEach((f, i) => {
    const e = owner[f];
    if (e >= elements) return;
    for (let axis = 0; axis < axes; ++axis) keys[4 * i + axis] = mesh.keys[axis * elements + e];
    keys[4 * i + 3] = 1;
  });
  return new InstancedBufferAttribute(keys, 4);
}

function geometryOf(mesh, elements, faces) {
  const geometry = new InstancedBufferGeometry();
  geometry.instanceCount = faces.length;
  const places = new Float32Array(18 * faces.length);
  faces.forEach((f, i) => places.set(mesh.places.subarray(18 * f, 18 * f + 18), 18 * i));
  const buffer = new InstancedInterleavedBuffer(places, 18);
  ["p0", "p1", "p2", "d0", "d1", "d2"].forEach((name, i) =>
    geometry.setAttribute(name, new InterleavedBufferAttribute(buffer, 3, 3 * i)),
  );
  geometry.setAttribute("front", keysOf(mesh, elements, faces, mesh.front));
  geometry.setAttribute("back", keysOf(mesh, elements, faces, mesh.back));
  return geometry;
}

/// Meshes of three.js for these faces, with `material`.
export function patches(mesh, page, faces, material) {
  return binned(mesh.bends, faces, page.radius).map((bin) => {
    const object = new Mesh(geometryOf(mesh, page.counts.elements, bin.faces), material);
    object.frustumCulled = false;
    object.userData = bin;
    return object;
  });
}

/// As fine as `pixels` a unit of length ask for, within what may be drawn at once. All alike where that is few triangles:
/// between faces of another fineness the background shines through, by as much as the chords are off.
export function refine(objects, pixels) {
  const wanted = objects.map(({ userData: { bend } }) =>
    Math.min(Math.max(Math.ceil(Math.sqrt((bend * pixels) / chordError)), 1), finest),
  );
  const count = (i) => objects[i].userData.faces.length;
  const most = Math.max(...wanted);
  if (objects.reduce((sum, _, i) => sum + count(i), 0) * most ** 2 <= mostAlike) wanted.fill(most);
  const total = objects.reduce((sum, _, i) => sum + count(i) * wanted[i] ** 2, 0);
  const share = Math.min(1, Math.sqrt(mostTriangles / total));
  objects.forEach((object, i) => {
    const n = fineness.find((n) => n >= Math.floor(wanted[i] * share)) ?? finest;
    const { position, index } = lattice(n);
    if (object.geometry.index === index) return;
    object.geometry.setAttribute("position", position);
    object.geometry.setIndex(index);
  });
}

/// Sets whether the elements of faces are drawn.
export function setDrawn(objects, drawn) {
  for (const { geometry, userData } of objects)
    for (const side of ["front", "back"]) {
      const attribute = geometry.getAttribute(side);
      userData.faces.forEach((f, i) => (attribute.array[4 * i + 3] = drawn[side][f]));
      attribute.needsUpdate = true;
    }
}

/// Puts values of elements or of faces, two a face, or of nodes, six a face, on the faces.
export function setValues(objects, mesh, quantity, values) {
  for (const { geometry, userData } of objects) {
    const { faces } = userData;
    if (quantity.on === "nodes") {
      const [corners, edges] = nodal(mesh, faces, values);
      geometry.setAttribute("atCorners", new InstancedBufferAttribute(corners, 3));
      geometry.setAttribute("atEdges", new InstancedBufferAttribute(edges, 3));
      continue;
    }
    const pairs = new Float32Array(2 * faces.length);
    faces.forEach((f, i) => {
      const [a, b] = quantity.on === "faces" ? [f, f] : [mesh.front[f], mesh.back[f]];
      pairs[2 * i] = values[a] ?? NaN;
      pairs[2 * i + 1] = values[b] ?? NaN;
    });
    geometry.setAttribute("values", new InstancedBufferAttribute(pairs, 2));
  }
}

/// Without nodes at the edges: linear between the corners.
function nodal(mesh, faces, values) {
  const corners = new Float32Array(3 * faces.length);
  const edges = new Float32Array(3 * faces.length);
  faces.forEach((f, i) => {
    for (let k = 0; k < 3; ++k) corners[3 * i + k] = values[mesh.faceNodes[mesh.perFace * f + k]];
    for (let k = 0; k < 3; ++k)
      edges[3 * i + k] =
        mesh.perFace === 6
          ? values[mesh.faceNodes[6 * f + 3 + k]]
          : 0.5 * (corners[3 * i + k] + corners[3 * i + ((k + 1) % 3)]);
  });
  return [corners, edges];
}

// ---------------------------------------------------------------- lattices

/// Lattices by their fineness.
const lattices = new Map();

/// A triangle in n^2 equal ones, as barycentric coordinates and indices.
function lattice(n) {
  if (!lattices.has(n)) lattices.set(n, makeLattice(n));
  return lattices.get(n);
}

function makeLattice(n) {
  const points = [];
  const at = (i, j) => j * (n + 1) - (j * (j - 1)) / 2 + i; // j-th row from the edge, i-th in it
  for (let j = 0; j <= n; ++j) for (let i = 0; i + j <= n; ++i) points.push((n - i - j) / n, i / n, j / n);
  const triangles = [];
  for (let j = 0; j < n; ++j)
    for (let i = 0; i + j < n; ++i) {
      triangles.push(at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + j + 1 < n) triangles.push(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  return {
    position: new BufferAttribute(new Float32Array(points), 3),
    index: new BufferAttribute(new Uint16Array(triangles), 1),
  };
}
