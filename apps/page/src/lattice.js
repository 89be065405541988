// A triangle in n^2 equal ones, as barycentric coordinates and indices.
import { BufferAttribute } from "three";

const made = new Map();

export function lattice(n) {
  if (!made.has(n)) made.set(n, make(n));
  return made.get(n);
}

function make(n) {
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
