#!/usr/bin/env python3
"""Meshes whose thin layers meet curved walls, curved to degree 2 by `camber curve` with its default options.

    python3 bench/junctions.py build/bin/camber                      all cases, as a Markdown table
    python3 bench/junctions.py build/bin/camber --only 'panel|2D'    the cases whose names match
    python3 bench/junctions.py build/bin/camber --keep FOLDER        and keep meshes, CAD models and reports there
    python3 bench/junctions.py build/bin/camber --options '--objective shape'    with further options of `curve`

Needs NumPy, and for the CAD parts Gmsh with its OpenCASCADE kernel (on Debian: python3-numpy, python3-gmsh, of /usr/bin/python3).

Columns:
- elements: tetrahedra, in 2D triangles;
- invalid: elements that the program reports as invalid before its repair, and in the end;
- min det J: the smallest Bézier coefficient of det J divided by det J of the straight element, computed here from the
  written mesh; and the program's smallest scaled Jacobian. The coefficient is a lower bound and may be negative in a valid
  element, which the program certifies by subdivision;
- off surfaces: the largest distance of mid nodes of the boundary from their exact analytic surfaces, computed here (–: the
  case has none); and the largest distance from the geometry of the run that the program reports;
- relaxed: boundary edges that the program relaxed;
- seconds of the whole program, and its exit code.
"""
import argparse
import itertools
import json
import math
import re
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import junction_meshes
try:
    import junction_parts
except ImportError:
    junction_parts = None

HEADER = ("case", "elements", "invalid", "min det J", "reported", "off surfaces", "reported", "relaxed", "s", "exit")
SECTIONS = {"Vertices": 0, "EdgesP2": 3, "TrianglesP2": 6, "TetrahedraP2": 10}  # numbers of nodes of the rows
EDGES = {2: [(0, 1), (1, 2), (2, 0)], 3: [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]}  # order of mid nodes in GMF


def read(path):
    """The sections of a mesh in GMF (ASCII) as arrays: points, and rows of node numbers from 0 with the reference last."""
    words, sections = path.read_text(encoding="ascii").split(), {}
    dimension = int(words[words.index("Dimension") + 1])
    for name, nodes in SECTIONS.items():
        if name in words:
            at, width = words.index(name), (nodes or dimension) + 1
            sections[name] = np.array(words[at + 2:at + 2 + width * int(words[at + 1])], float).reshape(-1, width)
    points = sections.pop("Vertices")[:, :dimension]
    return points, {name: rows.astype(int) - ([1] * SECTIONS[name] + [0]) for name, rows in sections.items()}


def bernstein(degree, at):
    """Bernstein polynomials of this degree at barycentric points: a row a point, and the exponents of the columns."""
    exponents = [e for e in itertools.product(range(degree + 1), repeat=at.shape[1]) if sum(e) == degree]
    factor = [math.factorial(degree) / math.prod(map(math.factorial, e)) for e in exponents]
    return np.stack([f * np.prod(at ** np.array(e), axis=1) for f, e in zip(factor, exponents)], axis=1), exponents


def smallest_det(points, cells):
    """The smallest Bézier coefficient of det J of each element of degree 2, divided by det J of the straight element."""
    dimension = points.shape[1]
    corners, middles = points[cells[:, :dimension + 1]], points[cells[:, dimension + 1:]]
    _, lattice = bernstein(dimension, np.ones((1, dimension + 1)))
    at = np.array(lattice) / dimension
    steps = np.eye(dimension + 1)[1:] - np.eye(dimension + 1)[0]  # derivatives of the barycentric coordinates
    jacobians = np.repeat((corners[:, 1:] - corners[:, :1])[:, None], len(at), axis=1)  # [element, point, step, coordinate]
    straight = np.linalg.det(jacobians[:, 0])
    for edge, (a, b) in enumerate(EDGES[dimension]):
        bow = middles[:, edge] - (corners[:, a] + corners[:, b]) / 2
        slope = 4 * (at[:, a, None] * steps[:, b] + at[:, b, None] * steps[:, a])
        jacobians += slope[None, :, :, None] * bow[:, None, None, :]
    matrix, _ = bernstein(dimension, at)
    return np.linalg.solve(matrix, np.linalg.det(jacobians).T).min(axis=0) / straight


def largest_distance(points, facets, surfaces):
    """The largest distance of mid nodes of boundary facets from the surfaces of their references; None without any."""
    corners = points.shape[1]
    found = [np.abs(surface.distance(points[np.unique(facets[facets[:, -1] == reference, corners:-1])])).max()
             for reference, surface in surfaces.items()]
    return max(found, default=None)


def figures(output, report, mesh):
    """The cells of the table that come from the written mesh and from the report."""
    points, sections = read(output)
    cells, facets = (sections[name] for name in (("TrianglesP2", "EdgesP2") if points.shape[1] == 2 else
                                                 ("TetrahedraP2", "TrianglesP2")))
    summary = json.loads(report.read_text())
    off = largest_distance(points, facets, mesh.surfaces)
    return [f"{summary['validity_before_correction']['invalid']} → {summary['validity']['invalid']}",
            f"{smallest_det(points, cells[:, :-1]).min():.3g}", f"{summary['validity']['min_scaled_jacobian']:.3g}",
            "–" if off is None else f"{off:.1e}",
            f"{summary['boundary']['node_deviation']['largest']:.1e}",
            str(summary.get("relax", {}).get("relaxed_surface_edges", 0))]


def run(program, name, mesh, folder, limit, options=()):
    """Curves the mesh of a case; returns its row of the table."""
    stem = folder / re.sub(r"[^\w.-]+", "-", name)
    straight, output, report = (stem.with_name(stem.name + end) for end in (".mesh", "-p2.mesh", ".json"))
    mesh.write(straight)
    words = [program, "curve", straight, "-o", output, "--report", report, *options]
    if mesh.cad:
        words += ["--cad", junction_parts.write_step(mesh.cad, stem.with_name(stem.name + ".step"))]
    if mesh.geometry():
        words += ["--geometry", mesh.geometry()]
    start = time.monotonic()
    try:
        process = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return [name, len(mesh.cells), *["–"] * 6, f"> {limit:g}", "–"]
    seconds = time.monotonic() - start
    stem.with_name(stem.name + ".txt").write_text(process.stdout + process.stderr)
    if not output.exists():
        print(f"{name}: {process.stderr.strip()[-600:]}", file=sys.stderr)
    cells = figures(output, report, mesh) if output.exists() else ["–"] * 6
    return [name, len(mesh.cells), *cells, f"{seconds:.1f}", process.returncode]


def row(cells):
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def cases(pattern):
    """Names and functions of the selected cases."""
    found = dict(junction_meshes.CASES)
    if junction_parts:
        found |= junction_parts.CASES
    else:
        print("junctions.py: without the cases that need Gmsh", file=sys.stderr)
    return {name: case for name, case in found.items() if re.search(pattern, name)}


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("program", help="the program camber")
    options.add_argument("--only", default="", metavar="REGEX", help="run the cases whose names match")
    options.add_argument("--keep", type=Path, metavar="DIR", help="folder for meshes, CAD models and reports")
    options.add_argument("--limit", type=float, default=600, metavar="SECONDS", help="time limit of a case (default: 600)")
    options.add_argument("--options", type=shlex.split, default=[], metavar="OPTIONS", help="further options of `curve`")
    arguments = options.parse_args()
    row(HEADER)
    row(["---"] * len(HEADER))
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for name, (make, *values) in cases(arguments.only).items():
            mesh = make(*values)
            mesh.check(1e-12 if not mesh.noise else 2 * mesh.noise)
            row(run(arguments.program, name, mesh, folder, arguments.limit, arguments.options))


if __name__ == "__main__":
    main()
