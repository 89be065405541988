#!/usr/bin/env python3
"""Remeshes standalone surface meshes to analytic metrics with Camber, and with Mmg if it is installed, in one run.

    bench/surfaces.py build/bin/camber                                 Mmg (mmgs_O3) if it is on the PATH
    bench/surfaces.py build/bin/camber --mmg ~/mmg/build/bin --cases sphere,part

The cases (bench/surface_cases.py):
    sphere      320 triangles of the unit sphere to size 0.1
    torus       radii 1 and 0.4, to the sizes of a chord error of 0.002 along its principal directions, three runs
    cube        6 sides of 6 x 6 squares with ridges, to UGAWG's linear metric, five runs
    cylinder    20 sides and two caps, from STL, to size 0.1 and a chord error of 0.002
    part        a plate with two holes, meshed coarsely by Gmsh, from MSH, to size 0.1 (needs gmsh)

Between runs the metric is evaluated at the vertices of the previous mesh. All programs run with their defaults, one thread, and
without gradation (Mmg: -hgrad -1). Mmg reads the same triangles from a .mesh. Seconds are CPU seconds of all runs.
Printed are the share of edges with lengths from 1/sqrt 2 to sqrt 2 in the formula; the minimum and mean quality of triangles in the metrics at their
vertices, negative if a triangle is folded over; the maximum distances of vertices and of triangle midpoints from the true surface; the relative
change of the area; and the state of the Euler characteristic and the references.
"""
import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import analytic_metrics as metrics
import surface_measure
from program import seconds_of
from surface_cases import CASES, write_mesh

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "oracle"))
import gmf  # noqa: E402


def camber_words(program, case, mesh, sizes, out, turn):
    # The output lists its ridges: after the first run no angle is needed.
    return [program, "remesh", mesh, "--metric", sizes or case.size, "-o", out, "--threads", "1",
            *(("--geometry-error", case.chord_error) if case.chord_error else ()), *(("--set", "features/ridge_angle=180") if turn else ())]


def mmg_words(program, case, mesh, sizes, out, _):
    if sizes:
        size_words = ["-sol", sizes]
    elif case.chord_error:
        size_words = ["-A", "-hmax", case.size, "-hausd", case.chord_error]  # anisotropic sizes by Mmg, like those of Camber
    else:
        size_words = ["-hsiz", case.size]
    return [program, "-in", mesh, "-out", out, "-v", "0", "-hgrad", "-1", *size_words]


def read(mesh):
    file = gmf.read(mesh)
    return file.points, file.cells["Triangles"].nodes, file.cells["Triangles"].refs


def brought(words_of, program, case, start):
    """Remeshes to last.meshb. Returns seconds, or None if the program fails."""
    seconds, mesh = 0, start
    for turn in range(case.runs):
        if not case.size:
            metrics.write_solution("last.solb", metrics.tensors(case.field, read(mesh)[0]))
        Path("next.meshb").unlink(missing_ok=True)
        took = seconds_of(words_of(program, case, mesh, None if case.size else "last.solb", "next.meshb", turn))
        if took is None or not os.path.exists("next.meshb"):
            return None
        seconds += took
        shutil.move("next.meshb", "last.meshb")
        mesh = "last.meshb"
    return seconds


COLUMNS = ["triangles", "seconds", "unit edges", "smallest", "mean quality", "vertices off", "middles off", "area", "Euler", "references"]


def cells(row):
    if row is None:
        return ["-"] * len(COLUMNS)
    change_words = ["changed", "kept"]
    return [f"{row['triangles']:,}".replace(",", " "), f"{row['seconds']:.2f}", f"{100 * row['unit']:.1f} %", f"{row['least']:.3f}",
            f"{row['mean']:.3f}", f"{row['vertices']:.1e}", f"{row['middles']:.1e}", f"{100 * row['area']:+.2f} %", change_words[row["euler"]],
            change_words[row["references"]]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("--mmg", help="the folder of Mmg's programs; default: the PATH")
    parser.add_argument("--cases", default=",".join(CASES), help="comma-separated (%(default)s)")
    options = parser.parse_args()
    camber = os.path.abspath(options.camber)
    mmg = shutil.which("mmgs_O3", path=os.path.expanduser(options.mmg) if options.mmg else None)
    if mmg is None:
        print("surfaces.py: Mmg is not installed: left out", file=sys.stderr)
    print("| case | by | " + " | ".join(COLUMNS) + " |\n|" + "---|" * (2 + len(COLUMNS)))
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in options.cases.split(","):
            case = CASES[name]
            start = case.make(Path(folder))
            subprocess.run([camber, "convert", start, "-o", "start.mesh"], check=True, capture_output=True)
            begin = read("start.mesh")
            write_mesh(Path("start.mesh"), *begin)  # Mmg does not read CAD parameters in text files
            surface = surface_measure.Surface(case.faces, *begin)
            for by, program, words_of, mesh in (("Camber", camber, camber_words, start), ("Mmg", mmg, mmg_words, "start.mesh")):
                seconds = brought(words_of, program, case, mesh) if program else None
                row = None if seconds is None else surface_measure.judged(case, surface, *read("last.meshb")) | {"seconds": seconds}
                print(f"| {name} | {by} | " + " | ".join(cells(row)) + " |", flush=True)
        os.chdir("/")


if __name__ == "__main__":
    main()
