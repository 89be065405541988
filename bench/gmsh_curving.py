#!/usr/bin/env python3
"""Curves layers around spheres to degree 2 with Gmsh's HighOrderFastCurving and with Camber's `objective: "shape"`, on the
same linear meshes, in one run, alternately. Prints a Markdown table.

    python3 bench/gmsh_curving.py build/bin/camber                            the meshes that Camber generates
    python3 bench/gmsh_curving.py build/bin/camber shell.meshb steep-1.4      a mesh file, and one of the generated meshes
    nice python3 bench/gmsh_curving.py build/bin/camber --repeats 9           on a machine with other load

Needs Gmsh with its OpenCASCADE kernel and its Python module: `apt-get install python3-gmsh` (on Debian it belongs to the
system's Python, /usr/bin/python3), or `pip install gmsh`. A mesh file must fill the space between two spheres about the
origin, with one reference for the triangles of each sphere.

Gmsh uses the exact CAD: two OpenCASCADE spheres, on which boundary vertices are classified with their parameters.
Camber uses the mesh only and builds a smooth surface from it, which is another problem. So the table also has the
distance of the boundary nodes from the spheres, and the results of Camber with the exact spheres
(`--geometry '{"analytic": ...}'`), which are comparable with Gmsh.

FastCurving curves Mesh.HighOrderNumLayers layers, 6 by default. In meshes with more layers the default leaves invalid
elements, so it also runs with a sufficient number of layers (`--layers`).

`camber check` evaluates the results. `not valid` is the number of elements whose det J is not certified positive. `min` is
the minimum det J as a share of that of the straight element. The pipeline of Camber includes repair, that of Gmsh does not:
the values before the arrow are those of Camber's report before repair. Seconds are medians of wall-clock times:
- Gmsh, one thread (FastCurving has no more): the call; with set-order; also with reading and writing files (binary
  .msh) and building the CAD, but without the start of Python and the loading of libraries;
- Camber: the stages `curve` to `commit`, which do the same as the call, with validation and repair; all stages
  without files, with the figures of the report; the whole program.
"""
import argparse
import json
import math
import multiprocessing
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from broken_meshes import boundary_of, check, gmsh, write_gmf


def shell(inner_size, outer_size, **layers):
    """Returns options of the generator: layers on a sphere are (count, first height, growth)."""
    names = ("count", "first_height", "growth")
    return {"inner_size": inner_size, "outer_size": outer_size,
            **{side: dict(zip(names, layer)) for side, layer in layers.items()}}


GENERATED = {
    "single": shell(0.3, 1.6, inner_layer=(8, 0.02, 1.25)),
    "double": shell(0.26, 0.85, inner_layer=(8, 0.02, 1.25), outer_layer=(6, 0.05, 1.25)),
    "steep-1.4": shell(0.46, 1.75, inner_layer=(10, 0.0026, 1.4)),
    "steep-1.6": shell(0.46, 1.75, inner_layer=(8, 0.0026, 1.6)),
    "thin": shell(0.46, 1.75, inner_layer=(17, 4.6e-5, 1.6)),
    "thin-1e5": shell(0.46, 1.75, inner_layer=(22, 4.6e-6, 1.6)),
    "thin-1e6": shell(0.46, 1.75, inner_layer=(27, 4.6e-7, 1.6)),
    "large": shell(0.11, 0.55, inner_layer=(12, 0.003, 1.25), outer_layer=(8, 0.02, 1.3)),
}
DEFAULT_LAYERS = 6  # Gmsh's Mesh.HighOrderNumLayers


def run(camber, *arguments, limit=None):
    """Runs Camber. Exit code 1 means invalid elements."""
    done = subprocess.run([camber, *map(str, arguments)], capture_output=True, text=True, timeout=limit)
    if done.returncode not in (0, 1):
        sys.exit(f"gmsh_curving.py: camber {arguments[0]} ended with {done.returncode}: {done.stderr}")


# ---------------------------------------------------------------- the linear mesh, and Gmsh's view of it

def linear_mesh(camber, case, folder):
    """Writes the case as ASCII GMF, generated or converted from a file."""
    path = folder / "linear.mesh"
    if case in GENERATED:
        pipeline = {"input": {"generate": {"shell": GENERATED[case]}}, "stages": [], "output": {"mesh": str(path)}}
        (folder / "generate.json").write_text(json.dumps(pipeline))
        run(camber, "run", folder / "generate.json")
    else:
        run(camber, "convert", case, "-o", path)
    return path


def blocks_of(path):
    """Returns rows of an ASCII file: vertices (x y z reference), tetrahedra and triangles (vertices from 1, reference)."""
    kinds, rows = {"Vertices": (4, float), "Tetrahedra": (5, int), "Triangles": (4, int)}, {}
    words = iter(path.read_text().split())
    for word in words:
        if word in kinds:
            width, kind = kinds[word]
            rows[word] = [[kind(next(words)) for _ in range(width)] for _ in range(int(next(words)))]
    return [rows.get(name, []) for name in kinds]


def spheres_of(case, points, triangles):
    """Returns radii by reference, the smaller one first."""
    radii = {}
    for reference in {row[3] for row in triangles}:
        lengths = [math.hypot(*points[n - 1][:3]) for row in triangles if row[3] == reference for n in row[:3]]
        radii[reference] = round(statistics.fmean(lengths), 12)
        if max(lengths) - min(lengths) > 1e-9 * max(lengths):
            sys.exit(f"gmsh_curving.py: {case}: triangles of reference {reference}: not on a sphere about the origin")
    if len(radii) != 2:
        sys.exit(f"gmsh_curving.py: {case}: {len(radii)} references of triangles; two spheres have two")
    return dict(sorted(radii.items(), key=lambda item: item[1]))


def model(radii):
    """Builds the exact CAD, rotated so that no vertex is at a pole of its parameters. Returns the volume and faces by reference."""
    gmsh.initialize([], False)
    for option, value in (("General.Terminal", 0), ("General.NumThreads", 1), ("Mesh.HighOrderOptimize", 0),
                          ("Mesh.Binary", 1), ("Mesh.SaveParametric", 1)):
        gmsh.option.setNumber(option, value)
    occ = gmsh.model.occ
    small, large = [(3, occ.addSphere(0, 0, 0, radius)) for radius in radii.values()]
    occ.rotate([small, large], 0, 0, 0, 1, 0.7, 0.3, 1.1)
    [(_, volume)], _ = occ.cut([large], [small])
    occ.synchronize()
    faces = {min(radii, key=lambda r: abs(radii[r] - math.hypot(*gmsh.model.getValue(2, face, [0.1, 0.2])))): face
             for _, face in gmsh.model.getEntities(2)}
    return volume, faces


def classify(blocks, radii, path):
    """Classifies the linear mesh on the CAD and writes a file of Gmsh."""
    points, tetrahedra, triangles = blocks
    volume, faces = model(radii)
    at = lambda nodes: [x for n in nodes for x in points[n - 1][:3]]
    inside = set(range(1, len(points) + 1))
    for reference, face in faces.items():
        corners = [n for row in triangles if row[3] == reference for n in row[:3]]
        nodes = sorted(set(corners))
        inside -= set(nodes)
        gmsh.model.mesh.addNodes(2, face, nodes, at(nodes), gmsh.model.getParametrization(2, face, at(nodes)))
        gmsh.model.mesh.addElementsByType(face, 2, [], corners)
    gmsh.model.mesh.addNodes(3, volume, sorted(inside), at(sorted(inside)))
    gmsh.model.mesh.addElementsByType(volume, 4, [], [n for row in tetrahedra for n in row[:4]])
    gmsh.write(str(path))


# ---------------------------------------------------------------- the two ways: seconds, and a file of degree 2

def curve_by_gmsh(radii, folder, layers, seconds):
    """Curves with Gmsh. `seconds` receives the time of the call, with set-order, and with files."""
    clock = [time.perf_counter()]
    tick = lambda: clock.append(time.perf_counter())
    model(radii)
    gmsh.option.setNumber("Mesh.HighOrderNumLayers", layers)
    gmsh.merge(str(folder / "linear.msh"))
    tick()
    gmsh.model.mesh.setOrder(2)
    tick()
    write_gmf(folder / "order2.mesh")
    tick()
    gmsh.model.mesh.optimize("HighOrderFastCurving")
    tick()
    gmsh.write(str(folder / "gmsh.msh"))
    tick()
    write_gmf(folder / f"layers{layers}.mesh")
    read, order, _, call, write = (b - a for a, b in zip(clock, clock[1:]))
    seconds[:] = call, call + order, call + order + read + write


def gmsh_apart(target, *arguments):
    """Runs a function in a separate process, since Gmsh keeps its options."""
    seconds = multiprocessing.Array("d", 3)
    process = multiprocessing.Process(target=target, args=arguments + ((seconds,) if target is curve_by_gmsh else ()))
    process.start()
    process.join()
    if process.exitcode != 0:
        sys.exit(f"gmsh_curving.py: Gmsh ended with {process.exitcode}")
    return list(seconds)


class Camber:
    """Runs of Camber with given options, and their results."""

    def __init__(self, name, threads, geometry="surrogate"):
        self.name, self.options = name, ("--threads", threads, "--geometry", geometry)
        self.before, self.seconds, self.in_time = "", [], True

    def curve(self, camber, folder, limit):
        """Curves a mesh. `seconds` receives the times of curve to commit, of stages without files, and of the program."""
        curved, report = folder / "camber.meshb", folder / "report.json"
        start = time.perf_counter()
        try:
            run(camber, "curve", folder / "linear.meshb", "-o", curved, "--report", report,
                "--set", "stages/curve/objective=shape", *self.options, limit=limit)
        except subprocess.TimeoutExpired:
            self.in_time = False
            return
        program = time.perf_counter() - start
        content = json.loads(report.read_text())
        stage = {row["stage"]: row["seconds"] for row in content["stages"]}
        call = sum(stage[name] for name in ("curve", "validate", "relax", "commit"))
        self.seconds.append((call, sum(stage.values()) - stage["read"] - stage["write"], program))
        before = content["validity_before_correction"]
        self.before = f"{before['invalid'] + before['undecided']}, {before['min_scaled_jacobian']:.3f}"
        run(camber, "convert", curved, "-o", folder / f"{self.name}.mesh")


# ---------------------------------------------------------------- the table

def head(layers):
    return ("case", "tetrahedra", "Gmsh order 2: not valid, min",
            f"+ FastCurving, {DEFAULT_LAYERS} layers (default): not valid, min; time (call, with set-order, with files)",
            f"+ FastCurving, {layers} layers", "Camber shape, 1 thread: not valid, min before → after repair; "
            "time (curve to commit, stages, program)", "2 threads: time", "Camber with the spheres, 1 thread",
            "off the spheres: Gmsh, Camber, Camber with the spheres")


def medians(rows):
    return ", ".join(f"{statistics.median(column):.2f} s" for column in zip(*rows))


def off(path, radii):
    """Returns the largest distance of boundary nodes from the nearer sphere."""
    farthest = max(min(abs(math.hypot(*p) - radius) for radius in radii.values()) for p in boundary_of(path))
    return f"{farthest:.1e}"


def row(camber, case, folder, repeats, limit, layers):
    linear = linear_mesh(camber, case, folder)
    run(camber, "convert", linear, "-o", folder / "linear.meshb")
    blocks = blocks_of(linear)
    radii = spheres_of(case, blocks[0], blocks[2])
    gmsh_apart(classify, blocks, radii, folder / "linear.msh")
    spheres = [{"references": [reference], "sphere": {"radius": radius}} for reference, radius in radii.items()]
    one_thread, two_threads, with_spheres = ways = (Camber("alone", 1), Camber("two", 2),
                                                    Camber("given", 1, json.dumps({"analytic": spheres})))
    by_gmsh = {DEFAULT_LAYERS: [], layers: []}
    for _ in range(repeats):
        for count, seconds in by_gmsh.items():
            seconds.append(gmsh_apart(curve_by_gmsh, radii, folder, count))
        for way in ways:
            if way.in_time:
                way.curve(camber, folder, limit)

    def verdict(name):
        elements, invalid, least = check(camber, folder / f"{name}.mesh")
        if elements != len(blocks[1]):
            sys.exit(f"gmsh_curving.py: {case}: {name} has {elements} tetrahedra of {len(blocks[1])}")
        return f"{invalid}, {least:.3f}"

    gmsh_cell = lambda count: f"{verdict(f'layers{count}')}; {medians(by_gmsh[count])}"
    seconds = lambda way: medians(way.seconds) if way.in_time else f"not done in {limit:g} s"
    camber_cell = lambda way: (f"{way.before} → {verdict(way.name)}; " if way.in_time else "") + seconds(way)
    distance = lambda name: off(folder / f"{name}.mesh", radii)
    return (case if case in GENERATED else Path(case).stem, len(blocks[1]), verdict("order2"),
            gmsh_cell(DEFAULT_LAYERS), gmsh_cell(layers), camber_cell(one_thread), seconds(two_threads), camber_cell(with_spheres),
            ", ".join([distance(f"layers{layers}")] + [distance(way.name) if way.in_time else "–"
                                                       for way in (one_thread, with_spheres)]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber", help="the program")
    parser.add_argument("cases", nargs="*", metavar="MESH",
                        help=f"a linear mesh (.mesh, .meshb), or one that Camber generates: {', '.join(GENERATED)}; "
                        "none: all of these")
    parser.add_argument("--repeats", type=int, default=5, help="runs of each program (default: 5)")
    parser.add_argument("--layers", type=int, default=20,
                        help="Mesh.HighOrderNumLayers for FastCurving's second run: the mesh's or more (default: 20)")
    parser.add_argument("--limit", type=float, default=60, help="seconds for one run of Camber (default: 60)")
    arguments = parser.parse_args()
    if not shutil.which(arguments.camber):
        parser.error(f"{arguments.camber} is not a program")
    for case in arguments.cases:
        if case not in GENERATED and not Path(case).is_file():
            parser.error(f"{case} is neither a file nor one of {', '.join(GENERATED)}")
    gmsh.initialize([], False)
    version = gmsh.option.getString("General.Version")
    gmsh.finalize()
    print(f"Gmsh {version}; load before: {os.getloadavg()[0]:.1f}\n", flush=True)
    columns = head(arguments.layers)
    print("| " + " | ".join(columns) + " |\n" + "|---" * len(columns) + "|", flush=True)
    for case in arguments.cases or GENERATED:
        with tempfile.TemporaryDirectory() as folder:
            cells = row(arguments.camber, case, Path(folder), arguments.repeats, arguments.limit, arguments.layers)
            print("| " + " | ".join(map(str, cells)) + " |", flush=True)
    print(f"\nload after: {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
