"""Draws a P2 mesh as SVG, its curved edges exactly: under an orthographic view a quadratic edge stays one.

    python3 docs/pictures/draw_mesh.py MESH OUT.svg [--view X,Y,Z] [--cut X,Y,Z[,OFFSET]] [--zoom X,Y,Z,RADIUS]

PNG from it: any SVG renderer, for example rsvg-convert -w 760. layers.png here is out/layers.meshb of configs/layers.json,
with --view=1,0.35,0.3 --cut=1,0,0 --zoom=0,0,0,1.9; layers-straight.png the same with --set 'stages=["elevate"]'.

2D: all triangles. 3D: the tetrahedra whose centre lies behind the cut plane (normal X,Y,Z), as seen along --view; their
outer faces are split finely for shading and sorted back to front. --zoom shows a window around a point only.
"""
import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "oracle"))
import gmf  # noqa: E402

SIZE = 900
SPLIT = 3
# Canonical nodes of a P2 triangle: v0 v1 v2 e01 e12 e20; of a tetrahedron: v0..v3 e01 e12 e20 e03 e13 e23.
TET_FACES = [(1, 2, 3, 5, 9, 8), (0, 3, 2, 7, 9, 6), (0, 1, 3, 4, 8, 7), (0, 2, 1, 6, 5, 4)]


def outer_faces(tets):
    """Faces (six nodes) that belong to one tetrahedron only."""
    faces = tets[:, TET_FACES].reshape(-1, 6)
    key = np.sort(faces[:, :3], axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]]


def frame(view):
    """Rows: right, up, towards the eye."""
    towards = view / np.linalg.norm(view)
    up = np.array([0.0, 0.0, 1.0]) if abs(towards[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])


def lattice(n):
    """Barycentric corners of the n² small triangles of a triangle."""
    cells = []
    for i in range(n):
        for j in range(n - i):
            cells.append([(i, j), (i + 1, j), (i, j + 1)])
            if i + j < n - 1:
                cells.append([(i + 1, j), (i + 1, j + 1), (i, j + 1)])
    ij = np.array(cells, float) / n
    return np.dstack([1 - ij.sum(axis=2), ij])


def shape_functions(xi):
    """Lagrange functions of the P2 triangle in canonical order."""
    a, b, c = xi[..., 0], xi[..., 1], xi[..., 2]
    return np.stack([a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a], axis=-1)


class Canvas:
    """Maps the plane to the picture and collects SVG elements."""

    def __init__(self, low, high):
        self.scale = SIZE / max(high - low)
        self.low, self.high = low, high
        width, height = (high - low) * self.scale
        self.parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-10 -10 {width + 20:.0f} {height + 20:.0f}" '
                      f'width="{width + 20:.0f}">', '<rect x="-10" y="-10" width="110%" height="110%" fill="white"/>']

    def at(self, p):
        return (p[0] - self.low[0]) * self.scale, (self.high[1] - p[1]) * self.scale

    def polygon(self, points, colour):
        text = " ".join("%.1f,%.1f" % self.at(p) for p in points)
        self.parts.append(f'<polygon points="{text}" fill="{colour}" stroke="{colour}" stroke-width="0.6"/>')

    def curves(self, edges, width):
        """Edges by (end, end, Lagrange node); the SVG control point is 2 P − (A + B)/2."""
        data = []
        for a, b, mid in edges:
            control = 2 * mid - (a + b) / 2
            data.append("M%.1f %.1f Q%.1f %.1f %.1f %.1f" % (*self.at(a), *self.at(control), *self.at(b)))
        self.parts.append(f'<path d="{" ".join(data)}" fill="none" stroke="#1b2a41" stroke-width="{width}" '
                          'stroke-linecap="round"/>')

    def text(self):
        return "\n".join(self.parts) + "\n</svg>\n"


def triangle_edges(nodes):
    return [(nodes[0], nodes[1], nodes[3]), (nodes[1], nodes[2], nodes[4]), (nodes[2], nodes[0], nodes[5])]


def window(points, zoom, axes):
    if zoom is None:
        return points.min(axis=0), points.max(axis=0)
    centre = axes @ np.array(zoom[:-1])
    return centre[:2] - zoom[-1], centre[:2] + zoom[-1]


def draw_2d(mesh, zoom):
    nodes = mesh.points[mesh.cells["TrianglesP2"].nodes]
    low, high = window(mesh.points, zoom, np.eye(2))
    canvas = Canvas(low, high)
    inside = ((nodes.max(axis=1) >= low) & (nodes.min(axis=1) <= high)).all(axis=1)
    for triangle in nodes[inside]:
        canvas.curves(triangle_edges(triangle), 0.8)
    return canvas.text()


def draw_3d(mesh, view, cut, zoom):
    tets = mesh.cells["TetrahedraP2"].nodes
    if cut is not None:
        normal, offset = np.array(cut[:3]), (cut[3] if len(cut) > 3 else 0.0)
        tets = tets[mesh.points[tets[:, :4]].mean(axis=1) @ normal <= offset]
    axes = frame(np.array(view))
    faces = (mesh.points @ axes.T)[outer_faces(tets)]
    low, high = window(faces.reshape(-1, 3)[:, :2], zoom, axes)
    shape = shape_functions(lattice(SPLIT))
    light = np.array([-0.35, 0.45, 0.82])
    canvas = Canvas(low, high)
    seen = ((faces[..., :2].max(axis=1) >= low) & (faces[..., :2].min(axis=1) <= high)).all(axis=1)
    faces = faces[seen]
    for face in faces[np.argsort(faces[..., 2].mean(axis=1))]:
        if np.cross(face[1] - face[0], face[2] - face[0])[2] < 0:
            continue
        for patch in shape @ face:
            n = np.cross(patch[1] - patch[0], patch[2] - patch[0])
            tone = 0.45 + 0.55 * max(0.0, n @ light / (np.linalg.norm(n) + 1e-300))
            canvas.polygon(patch, "#%02x%02x%02x" % tuple(int(255 * tone * c) for c in (0.70, 0.83, 0.97)))
        canvas.curves(triangle_edges(face[:, :2]), 1.0)
    return canvas.text()


def numbers(text):
    return [float(x) for x in text.split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("out")
    parser.add_argument("--view", type=numbers, default=[1.0, 0.6, 0.5])
    parser.add_argument("--cut", type=numbers)
    parser.add_argument("--zoom", type=numbers)
    options = parser.parse_args()
    mesh = gmf.read(options.mesh)
    three_d = "TetrahedraP2" in mesh.cells
    text = draw_3d(mesh, options.view, options.cut, options.zoom) if three_d else draw_2d(mesh, options.zoom)
    Path(options.out).write_text(text)


if __name__ == "__main__":
    main()
