#!/usr/bin/env python3
"""Compares the time predicted by `--dry-run` with the time of curving, on meshes that are difficult to repair.

    /usr/bin/python3 bench/repair_times.py FOLDER                             the meshes (.mesh)
    /usr/bin/python3 bench/repair_times.py FOLDER --camber build/bin/camber   and a table

panel: a wavy plate of 24 x 24 cells and one layer of a certain thickness, with one reference for the whole boundary, so that
the surrogate rounds the edges of the plate. scan: a closed surface of 7 220 triangles with noise, like the output of
a scanner. shear: a ball in a box, sheared until its elements are needles. Needs numpy.
"""
import argparse
import re
import resource
import subprocess
import time
from itertools import permutations
from pathlib import Path

import numpy as np


def boundary_of(elements):
    """Returns faces of one element only, oriented as in their elements."""
    faces = {}
    for a, b, c, d in elements:
        for face in ((b, c, d), (a, d, c), (a, b, d), (a, c, b)):
            faces.setdefault(tuple(sorted(face)), []).append(face)
    return [of[0] for of in faces.values() if len(of) == 1]


def write(path, points, triangles, elements=()):
    rows = lambda items: "".join(" ".join(str(v + 1) for v in item) + " 1\n" for item in items)
    text = f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n"
    text += "".join(f"{x!r} {y!r} {z!r} 0\n" for x, y, z in np.asarray(points).tolist())
    text += f"Triangles\n{len(triangles)}\n" + rows(triangles)
    if len(elements):
        text += f"Tetrahedra\n{len(elements)}\n" + rows(elements)
    path.write_text(text + "End\n")


def oriented(points, elements):
    out = []
    for a, b, c, d in elements:
        volume = np.linalg.det(points[[b, c, d]] - points[a])
        out.append((a, b, c, d) if volume > 0 else (b, a, c, d))
    return out


def panel(path, cells, thickness):
    number = lambda i, j, k: (i * (cells + 1) + j) * 2 + k
    bow = lambda x, y: 0.2 * np.sin(2 * np.pi * x) * np.sin(2 * np.pi * y)
    points = np.array([(i / cells, j / cells, bow(i / cells, j / cells) + k * thickness)
                       for i in range(cells + 1) for j in range(cells + 1) for k in range(2)])
    elements = []
    for i in range(cells):
        for j in range(cells):
            for corners in (((i, j), (i + 1, j), (i + 1, j + 1)), ((i, j), (i, j + 1), (i + 1, j + 1))):
                low, high = ([number(*at, k) for at in corners] for k in (0, 1))
                elements += [(*low, high[2]), (low[0], low[1], high[2], high[1]), (low[0], high[1], high[2], high[0])]
    elements = oriented(points, elements)
    write(path, points, boundary_of(elements), elements)


def scan(path, pieces, noise):
    """An icosahedron whose sides have pieces² triangles each, on a bumpy ball; noise: of the edge length."""
    golden = (1 + 5 ** 0.5) / 2
    corners = np.array([(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0), (0, -1, golden), (0, 1, golden),
                        (0, -1, -golden), (0, 1, -golden), (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1)])
    sides = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
             (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7),
             (9, 8, 1)]
    numbers, points, triangles = {}, [], []

    def number(p):
        key = tuple(np.round(p, 9))
        if key not in numbers:
            numbers[key] = len(points)
            points.append(p)
        return numbers[key]

    for a, b, c in sides:
        grid = {}
        for i in range(pieces + 1):
            for j in range(pieces + 1 - i):
                p = corners[a] + (corners[b] - corners[a]) * i / pieces + (corners[c] - corners[a]) * j / pieces
                grid[i, j] = number(p / np.linalg.norm(p))
        for i in range(pieces):
            for j in range(pieces - i):
                triangles.append((grid[i, j], grid[i + 1, j], grid[i, j + 1]))
                if i + j < pieces - 1:
                    triangles.append((grid[i + 1, j], grid[i + 1, j + 1], grid[i, j + 1]))
    points = np.array(points)
    x, y, z = points.T
    radius = 1 + 0.25 * np.sin(3 * x + 1) * np.cos(2 * y) + 0.15 * np.sin(5 * z) * x + 0.05 * np.sin(9 * y + 4 * z)
    edge = np.sqrt(4 * np.pi / len(triangles))
    points = points * radius[:, None] + np.random.default_rng(1).normal(0, noise * edge, points.shape)
    write(path, points, triangles)


def shear(path, cells, slope):
    """A grid of cubes around a spherical hole, x + slope y: boundary vertices of the hole on an ellipsoid."""
    number = lambda i, j, k: (i * (cells + 1) + j) * (cells + 1) + k
    points = np.array([(i, j, k) for i in range(cells + 1) for j in range(cells + 1) for k in range(cells + 1)], float)
    points = 2 * points / cells - 1
    radius = np.linalg.norm(points, axis=1)
    hole = 0.55
    elements = []
    for i in range(cells):
        for j in range(cells):
            for k in range(cells):
                for order in permutations(range(3)):
                    at = [[i, j, k]]
                    for axis in order:
                        at.append([c + (n == axis) for n, c in enumerate(at[-1])])
                    vertices = [number(*c) for c in at]
                    if min(radius[vertices]) >= hole:
                        elements.append(tuple(vertices))
    elements = oriented(points, elements)
    used = np.unique(np.array(elements))
    renumbered = {old: new for new, old in enumerate(used)}
    elements = [tuple(renumbered[v] for v in e) for e in elements]
    points = points[used]
    facets = boundary_of(elements)
    inner = {v for f in facets if np.abs(points[list(f)]).max(axis=1).min() < 1 - 1e-9 for v in f
             if np.abs(points[v]).max() < 1 - 1e-9}
    for v in inner:
        points[v] *= 0.5 * (1 + hole / np.linalg.norm(points[v]))
    points[:, 0] += slope * points[:, 1]
    write(path, points, facets, oriented(points, elements))


CASES = {
    "panel-1e-3": lambda path: panel(path, 24, 1e-3),
    "panel-1e-5": lambda path: panel(path, 24, 1e-5),
    "scan-0.1": lambda path: scan(path, 19, 0.1),
    "scan-0.3": lambda path: scan(path, 19, 0.3),
    "shear-30": lambda path: shear(path, 10, 30),
    "shear-300": lambda path: shear(path, 10, 300),
}


def measured(program, mesh, limit):
    """Returns predicted, wall-clock and CPU seconds, and the exit code."""
    command = [program, "curve", mesh, "-o", mesh.with_suffix(".out.mesh")]
    plan = subprocess.run([*command, "--dry-run"], capture_output=True, text=True).stdout
    predicted = re.search(r"^  time +(.*)$", plan, re.M)
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    try:
        code = subprocess.run(command, capture_output=True, timeout=limit).returncode
    except subprocess.TimeoutExpired:
        code = "-"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return predicted[1] if predicted else "-", time.monotonic() - began, after.ru_utime - before.ru_utime, code


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--camber", type=Path, help="the program; without it the meshes are written and not curved")
    parser.add_argument("--limit", type=float, default=600, help="seconds after which a run is ended")
    parser.add_argument("--cases", nargs="*", choices=CASES, default=list(CASES))
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    print(f"{'':<12}{'predicted':>20}{'wall s':>9}{'CPU s':>9}{'exit':>6}")
    for name in arguments.cases:
        mesh = arguments.folder / f"{name}.mesh"
        CASES[name](mesh)
        if arguments.camber:
            predicted, wall, cpu, code = measured(arguments.camber.resolve(), mesh, arguments.limit)
            print(f"{name:<12}{predicted:>20}{wall:>9.1f}{cpu:>9.1f}{code:>6}", flush=True)


if __name__ == "__main__":
    main()
