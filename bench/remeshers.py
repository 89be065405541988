#!/usr/bin/env python3
"""Remeshes straight meshes to analytic metrics with Camber, and with Mmg and refine if they are installed, in one run.

    bench/remeshers.py build/bin/camber                                        Mmg (mmg2d_O3, mmg3d_O3) and refine (ref) if they are on the PATH
    bench/remeshers.py build/bin/camber --mmg ~/mmg/build/bin --refine ~/refine/build/src --cases steady,linear

The cases:
    steady          a cube remeshed by Camber to polar-1 with 0.77 times its sizes, once more in the same metric
    half            the same with half of the sizes, one run
    linear, polar-1 a cube of 6 x 6 x 6 cells, five runs
    slanted         the same cube, a layer of 1e-5 at an oblique plane, three runs
    circle          a square of 10 x 10 cells, ten runs

Camber in degree 2 starts from the same meshes with nodes at the midpoints of edges, and for *steady* and *half* from its own result.
Between runs the metric is evaluated at the vertices of the previous mesh. All programs run with their defaults, one thread, and
without gradation (Mmg: -hgrad -1; refine has none). Seconds are CPU seconds of all runs of a case.
bench/analytic_metrics.py evaluates the meshes: lengths along edges in the formula, qualities in the metrics at the vertices
(in degree 2: lengths of curved edges, and 1 over the mean distortion).
"""
import argparse
import functools
import os
import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import analytic_metrics as metrics
from program import seconds_of

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "oracle"))
import gmf  # noqa: E402

CUBE, SQUARE = ("box", "--set", "cells=[6,6,6]"), ("rectangle", "--set", "cells=[10,10]")
FINE = 0.77
# field, scale, input mesh, runs
CASES = {"steady": (metrics.polar_1, FINE, "adapted", 1), "half": (metrics.polar_1, FINE / 2, "adapted", 1),
         "linear": (metrics.linear, 1, CUBE, 5), "polar-1": (metrics.polar_1, 1, CUBE, 5), "slanted": (metrics.slanted, 1, CUBE, 3), "circle": (metrics.circle, 1, SQUARE, 10)}


def camber_words(program, mesh, sizes, out, turn):
    # The output lists its ridges: after the first run no angle is needed.
    return [program, "remesh", mesh, "--metric", sizes, "-o", out, "--threads", "1", "--geometry", "straight",
            *(("--set", "features/ridge_angle=180") if turn else ())]


def curved_words(program, mesh, sizes, out, turn):
    """Returns the command for degree 2. A straight input gets nodes."""
    if is_straight(mesh):
        subprocess.run([program, "curve", mesh, "--metric", "1", "--geometry", "straight", "-o", "curved.meshb"], check=True, stdout=subprocess.DEVNULL)
        mesh = "curved.meshb"
    return camber_words(program, mesh, sizes, out, turn)


def mmg_words(program, mesh, sizes, out, _):
    return [program, "-in", mesh, "-sol", sizes, "-out", out, "-v", "0", "-hgrad", "-1"]


def refine_words(program, mesh, sizes, out, _):
    return [program, "adapt", mesh, "-x", out, "--metric", sizes]


class Remesher:
    """A name, the program for each dimension, and its arguments."""

    def __init__(self, name, of_dimension, words):
        self.name, self.of_dimension, self.words = name, of_dimension, words


def found(name, folder):
    return shutil.which(name, path=os.path.expanduser(folder) if folder else None)


def remeshers(options):
    camber = os.path.abspath(options.camber)
    all_of = [Remesher("Camber", {2: camber, 3: camber}, camber_words),
              Remesher("Camber, degree 2", {2: camber, 3: camber}, curved_words),
              Remesher("Mmg", {d: found(f"mmg{d}d_O3", options.mmg) for d in (2, 3)}, mmg_words),
              Remesher("refine", {d: found("ref", options.refine) for d in (2, 3)}, refine_words)]
    for one in all_of:
        if not any(one.of_dimension.values()):
            print(f"remeshers.py: {one.name} is not installed: left out", file=sys.stderr)
    return all_of


def of_elements(file):
    return "Tetrahedra" if file.dim == 3 else "Triangles"


def is_straight(mesh):
    file = gmf.read(mesh)
    return of_elements(file) in file.cells


def read(mesh):
    """Returns points, nodes of elements and local edges of degree 2: see metrics.judged."""
    file = gmf.read(mesh)
    name = of_elements(file)
    nodes = file.cells[name if name in file.cells else name + "P2"].nodes
    return file.points[:, :file.dim], nodes, gmf.LOCAL_EDGES[file.dim]


def vertices(mesh):
    x, nodes, _ = read(mesh)
    return x[:nodes[:, :x.shape[1] + 1].max() + 1]


def drop_edges(mesh):
    """Removes listed edges: refine finds the edges of a box itself and fails if they are listed."""
    file = gmf.read(mesh)
    keywords = {"Triangles": 6, "Tetrahedra": 8}
    with open(mesh, "wb") as out:
        out.write(struct.pack("<5i", 1, 2, 3, out.tell() + 20, 3))

        def block(keyword, rows):
            out.write(struct.pack("<3i", keyword, out.tell() + 12 + rows.nbytes, len(rows)))
            out.write(rows.tobytes())

        block(4, np.array([(*x, 0) for x in file.points], dtype="<f8,<f8,<f8,<i4"))
        for name, keyword in keywords.items():
            block(keyword, np.hstack([file.cells[name].nodes + 1, file.cells[name].refs[:, None]]).astype("<i4"))
        out.write(struct.pack("<2i", 54, 0))


class Bench:
    def __init__(self, camber):
        self.camber = os.path.abspath(camber)

    def quietly(self, words):
        """Returns CPU seconds, or None if the program writes no mesh."""
        Path("next.meshb").unlink(missing_ok=True)
        return seconds_of(words)

    def begin(self, start, remesher):
        if start != "adapted":
            self.quietly([self.camber, "generate", *start, "-o", "start.meshb"])
            return "start.meshb"
        words = curved_words if remesher.words is curved_words else camber_words
        adapted = f"adapted-{words.__name__}.meshb"
        if not os.path.exists(adapted):
            self.begin(CUBE, remesher)
            camber = Remesher("Camber", {3: self.camber}, words)
            self.brought(camber, functools.partial(metrics.polar_1, scale=FINE), "start.meshb", 5)
            shutil.copy("last.meshb", adapted)
        return adapted

    def brought(self, remesher, field, mesh, runs):
        """Remeshes to last.meshb. Returns seconds."""
        shutil.copy(mesh, "last.meshb")
        if remesher.name == "refine" and gmf.read(mesh).dim == 3:
            drop_edges("last.meshb")
        seconds = 0
        for turn in range(runs):
            x = vertices("last.meshb")
            metrics.write_solution("last.solb", metrics.tensors(field, x))
            words = remesher.words(remesher.of_dimension[x.shape[1]], "last.meshb", "last.solb", "next.meshb", turn)
            took = self.quietly(words)
            if took is None or not os.path.exists("next.meshb"):
                print(f"remeshers.py: {remesher.name} left no mesh in run {turn + 1}", file=sys.stderr)
                return None
            seconds += took
            shutil.move("next.meshb", "last.meshb")
        return seconds

    def row(self, case, remesher):
        formula, scale, start, runs = CASES[case]
        field = functools.partial(formula, scale=scale)
        mesh = self.begin(start, remesher)
        if remesher.of_dimension[2 if start is SQUARE else 3] is None:
            return None
        seconds = self.brought(remesher, field, mesh, runs)
        return None if seconds is None else metrics.judged(field, *read("last.meshb")) | {"seconds": seconds}


def cell(row):
    if row is None:
        return "-"
    return (f"{row['elements']:,}".replace(",", " ") + f", {row['seconds']:.1f} s, {100 * row['unit']:.1f} %, {row['least']:.3f}, {row['mean']:.3f}, "
            f"{row['shortest']:.2f} to {row['longest']:.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("--mmg", help="the folder of Mmg's programs; default: the PATH")
    parser.add_argument("--refine", help="the folder of refine's ref; default: the PATH")
    parser.add_argument("--cases", default=",".join(CASES), help="comma-separated (%(default)s)")
    options = parser.parse_args()
    all_of, bench = remeshers(options), Bench(options.camber)
    print("Elements, seconds, unit edges, smallest and mean quality, lengths:\n")
    print("| case | " + " | ".join(one.name for one in all_of) + " |\n|" + "---|" * (1 + len(all_of)))
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for case in options.cases.split(","):
            print(f"| {case} | " + " | ".join(cell(bench.row(case, one)) for one in all_of) + " |", flush=True)
        os.chdir("/")


if __name__ == "__main__":
    main()
