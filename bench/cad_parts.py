#!/usr/bin/env python3
"""CAD parts, meshed by Gmsh and curved by Camber (`curve --cad`) and by Gmsh itself, in one run.

    python3 bench/cad_parts.py FOLDER                                 the models (.step) and their straight meshes (.msh)
    python3 bench/cad_parts.py FOLDER --camber build/bin/camber       and a Markdown table of both
    python3 bench/cad_parts.py FOLDER wing slab --camber ...          some of them

Needs Gmsh with its OpenCASCADE kernel and its Python module: `apt-get install python3-gmsh` (on Debian it is of the
system's Python, /usr/bin/python3).

- wing:      air around half a tapered wing, NACA 0012 as two splines, sharp trailing edge, flat tip
- round-tip: the same with a tip that is the section turned about its chord: a pole at each end
- junction:  two pipes of different radii that meet at 60 degrees, inside and outside
- slab:      a block with all edges rounded by a hundredth of its size
- bulb:      a spline turned about its axis: a seam and two poles
- egg:       a sphere stretched, as a spline surface: a seam and two poles
- blend:     a cylinder on a plate with a fillet between, tangent to both
- inches:    a plate with a hole in inches, meshed in metres

Distances of nodes are measured twice: by the report of Camber (from the associated face or edge), and by the projection of
OpenCASCADE onto the face to which Gmsh classified the triangle. The latter has an error of about 1e-7 and also detects nodes
on a wrong face. Both are shares of the diagonal of the part. `camber check` evaluates the elements. Seconds are wall-clock
times: the whole program for Camber; setOrder(2) and the optimiser without files for Gmsh.
"""
import argparse
import json
import math
import multiprocessing
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import gmsh

from broken_meshes import check, write_gmf


def sizes(least, most, on_circle=0):
    gmsh.option.setNumber("Mesh.MeshSizeMin", least)
    gmsh.option.setNumber("Mesh.MeshSizeMax", most)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", on_circle)


# ---------------------------------------------------------------- the parts: a model, and sizes of its mesh

def half_thickness(t):
    """NACA 0012; the last coefficient closes the trailing edge."""
    return 0.6 * (0.2969 * math.sqrt(t) - 0.1260 * t - 0.3516 * t ** 2 + 0.2843 * t ** 3 - 0.1036 * t ** 4)


def section(y, x, chord, points=40):
    """Returns the two halves of the section as splines from the nose to the trailing edge, and these two points."""
    occ = gmsh.model.occ
    along = [0.5 * (1 - math.cos(math.pi * i / points)) for i in range(points + 1)]
    nose, tail = occ.addPoint(x, y, 0), occ.addPoint(x + chord, y, 0)
    half = lambda up: occ.addBSpline([nose, *(occ.addPoint(x + chord * t, y, up * chord * half_thickness(t))
                                              for t in along[1:-1]), tail])
    return half(1), half(-1), nose, tail


def blade(root, tip):
    occ = gmsh.model.occ
    sections = [section(*root), section(*tip)]
    skin = occ.addThruSections([occ.addWire([up, -down]) for up, down, _, _ in sections], makeSolid=True, makeRuled=True)
    return skin, sections[1]


def air_around(body):
    occ = gmsh.model.occ
    occ.cut([(3, occ.addBox(-2, 0, -2, 5, 4, 4))], body)
    occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 1)
    sizes(0.02, 0.9)


def near_wing():
    """Refines the mesh near the points of the wing in the file."""
    gmsh.model.mesh.setSize(gmsh.model.getEntitiesInBoundingBox(-0.2, -0.1, -0.3, 2, 2.5, 0.3, 0), 0.1)


def wing():
    air_around(blade((0, 0, 1), (2, 0.4, 0.6))[0])


def round_tip():
    occ = gmsh.model.occ
    skin, (upper, _, nose, tail) = blade((0, 0, 1), (2, 0, 1))
    half = occ.addPlaneSurface([occ.addCurveLoop([upper, occ.addLine(tail, nose)])])
    turned = occ.revolve([(2, half)], 0, 2, 0, 1, 0, 0, -math.pi)
    air_around(occ.fuse(skin, [entity for entity in turned if entity[0] == 3])[0])


def junction():
    occ = gmsh.model.occ
    lean = math.radians(60)
    pipes = lambda wall: occ.fuse([(3, occ.addCylinder(-3, 0, 0, 6, 0, 0, 1 - wall))],
                                  [(3, occ.addCylinder(0, 0, 0, 3 * math.cos(lean), 0, 3 * math.sin(lean), 0.6 - wall))])[0]
    occ.cut(pipes(0), pipes(0.1))
    occ.synchronize()
    sizes(0.05, 0.4, 16)


def slab():
    occ = gmsh.model.occ
    block = occ.addBox(0, 0, 0, 1, 1, 0.5)
    occ.synchronize()
    occ.fillet([block], [edge for _, edge in gmsh.model.getEntities(1)], [0.01])
    occ.synchronize()
    sizes(0.02, 0.1)


def turned(points, size):
    """Rotates a spline in the plane y = 0 with both ends on the axis z about that axis."""
    occ = gmsh.model.occ
    profile = [occ.addPoint(x, 0, z) for x, z in points]
    spline = occ.addBSpline(profile)
    face = occ.addPlaneSurface([occ.addCurveLoop([spline, occ.addLine(profile[-1], profile[0])])])
    occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, 2 * math.pi)
    occ.remove([(2, face)], recursive=True)
    occ.synchronize()
    sizes(0.02, size, 14)


def bulb():
    turned([(0, 0), (0.5, 0), (1, 0.4), (0.9, 1.2), (0.3, 1.6), (0.35, 2.2), (0.3, 2.6), (0, 2.6)], 0.35)


def egg():
    occ = gmsh.model.occ
    occ.dilate([(3, occ.addSphere(0, 0, 0, 1))], 0, 0, 0, 1, 1.3, 2)
    occ.synchronize()
    sizes(0.05, 0.5, 12)


def blend():
    occ = gmsh.model.occ
    body, _ = occ.fuse([(3, occ.addBox(-2, -2, -0.5, 4, 4, 0.5))], [(3, occ.addCylinder(0, 0, 0, 0, 0, 1.5, 0.7))])
    occ.synchronize()
    rim = [edge for _, edge in gmsh.model.getEntitiesInBoundingBox(-0.8, -0.8, -0.01, 0.8, 0.8, 0.01, 1)]
    occ.fillet([body[0][1]], rim, [0.3])
    occ.synchronize()
    sizes(0.05, 0.6, 16)


def inches():
    occ = gmsh.model.occ
    plate = occ.addBox(0, 0, 0, 4, 3, 1)
    occ.cut([(3, plate)], [(3, occ.addCylinder(2, 1.5, -1, 0, 0, 3, 0.75))])
    occ.synchronize()
    sizes(0.005, 0.015, 16)  # mesh size in metres


PARTS = {"wing": wing, "round-tip": round_tip, "junction": junction, "slab": slab, "bulb": bulb, "egg": egg,
         "blend": blend, "inches": inches}
UNITS = {"inches": ("m", "M")}  # unit of the mesh: names in Camber and in Gmsh


def put_into_inches(path):
    """Changes the unit of a file from millimetres, which Gmsh writes, to inches and keeps the numbers (ISO 10303-41, conversion_based_unit)."""
    text = path.read_text()
    last = max(map(int, re.findall(r"^#(\d+)", text, re.MULTILINE)))
    metric, exponents, measure = (f"#{last + k}" for k in (1, 2, 3))
    unit = re.search(r"#(\d+) = \( LENGTH_UNIT\(\) NAMED_UNIT\(\*\) SI_UNIT\(.MILLI.,.METRE.\) \);", text)
    inch = (f"#{unit[1]} = ( CONVERSION_BASED_UNIT('INCH',{measure}) LENGTH_UNIT() NAMED_UNIT({exponents}) );\n"
            f"{metric} = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );\n"
            f"{exponents} = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
            f"{measure} = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),{metric});")
    path.write_text(text.replace(unit[0], inch))


# ---------------------------------------------------------------- Gmsh, in a separate process for each call

def quiet():
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    gmsh.initialize([], False)
    for option, value in (("General.Terminal", 0), ("General.NumThreads", 1), ("Mesh.Binary", 0),
                          ("Mesh.MshFileVersion", 4.1), ("Mesh.HighOrderOptimize", 0)):
        gmsh.option.setNumber(option, value)


def open_model(part, folder):
    if part in UNITS:
        gmsh.option.setString("Geometry.OCCTargetUnit", UNITS[part][1])
    gmsh.open(str(folder / f"{part}.step"))


def make(part, folder):
    """Writes the model to a file and meshes the model read from that file."""
    quiet()
    PARTS[part]()
    gmsh.model.occ.remove(gmsh.model.occ.getEntities(0))  # those that bound nothing
    gmsh.model.occ.synchronize()
    gmsh.write(str(folder / f"{part}.step"))
    gmsh.model.remove()
    if part in UNITS:
        put_into_inches(folder / f"{part}.step")
    open_model(part, folder)
    if part in ("wing", "round-tip"):
        near_wing()
    gmsh.model.mesh.generate(3)
    gmsh.write(str(folder / f"{part}.msh"))


def curve_by_gmsh(part, folder, seconds):
    quiet()
    open_model(part, folder)
    gmsh.merge(str(folder / f"{part}.msh"))
    start = time.perf_counter()
    gmsh.model.mesh.setOrder(2)
    seconds[0] = time.perf_counter() - start
    write_gmf(folder / f"{part}-order2.mesh")
    start = time.perf_counter()
    gmsh.model.mesh.optimize("HighOrderFastCurving")
    seconds[1] = time.perf_counter() - start
    write_gmf(folder / f"{part}-gmsh.mesh")
    gmsh.write(str(folder / f"{part}-gmsh.msh"))


def nodes_of_faces(path):
    """Returns the positions of the nodes of the quadratic triangles of each face."""
    gmsh.open(str(path))
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    point = {int(tag): coordinates[3 * i:3 * i + 3] for i, tag in enumerate(tags)}
    out = {}
    for _, face in gmsh.model.getEntities(2):
        _, nodes = gmsh.model.mesh.getElementsByType(9, face)
        out[face] = [point[n] for n in sorted({int(n) for n in nodes})]
    gmsh.model.remove()
    return out


def measure(part, path, folder, farthest):
    """Measures a result. `farthest` is by OpenCASCADE's projection onto the classified face, as a share of the diagonal."""
    quiet()
    faces = nodes_of_faces(path)
    open_model(part, folder)
    box = gmsh.model.getBoundingBox(-1, -1)
    size = math.dist(box[:3], box[3:])
    for face, points in faces.items():
        for p in points:
            on, _ = gmsh.model.getClosestPoint(2, face, list(p))
            d = math.dist(p, on) / size
            if d > farthest[0]:
                farthest[0], farthest[1:4], farthest[4] = d, list(p), face


def apart(target, *arguments, numbers=0, limit=600):
    shared = multiprocessing.Array("d", numbers) if numbers else None
    process = multiprocessing.Process(target=target, args=arguments + ((shared,) if numbers else ()))
    process.start()
    process.join(limit)
    if process.is_alive():
        process.kill()
        return None
    if process.exitcode != 0:
        print(f"cad_parts.py: Gmsh ended with {process.exitcode} in {target.__name__} of {arguments[0]}", file=sys.stderr)
        return None
    return list(shared) if numbers else True


# ---------------------------------------------------------------- the table

def run_camber(part, camber, folder, threads=1):
    report, out = folder / f"{part}.json", folder / f"{part}-camber.msh"
    unit = ["--cad-unit", UNITS[part][0]] if part in UNITS else []
    start = time.perf_counter()
    done = subprocess.run([camber, "curve", folder / f"{part}.msh", "-o", out, "--cad", folder / f"{part}.step", *unit,
                           "--min-scaled-jacobian", "0.1", "--report", report, "--threads", str(threads)], capture_output=True, text=True)
    seconds = time.perf_counter() - start
    if done.returncode > 1:
        print(f"{part}: {done.stderr}", file=sys.stderr)
        return None, None, seconds
    return json.loads(report.read_text()), out, seconds


HEAD = ("part", "tetrahedra", "faces, edges, vertices met", "in doubt: facets, edges, vertices", "vertices off",
        "nodes off", "by OpenCASCADE", "relaxed surface edges", "invalid", "below 0.1", "min", "s",
        "Gmsh order 2: invalid, min; time", "+ FastCurving: invalid, min; time")


def row(part, camber, folder):
    report, out, seconds = run_camber(part, camber, folder)
    if report is None:
        return [part, "refused"]
    (folder / f"{part}.report.json").write_text(json.dumps(report, indent=1))
    cad, valid = report["boundary"]["cad"], report["validity"]
    by_occ = apart(measure, part, out, folder, numbers=5)
    by_gmsh = apart(curve_by_gmsh, part, folder, numbers=2)
    def verdict(name):
        _, invalid, least = check(camber, folder / f"{part}-{name}.mesh")
        return f"{invalid}, {least:.3g}"

    size = report_size(folder / f"{part}.msh")
    return [part, report["mesh"]["elements"],
            "{matched_faces}/{faces}, {matched_edges}/{edges}, {matched_vertices}/{vertices}".format(**cad),
            "{ambiguous_facets}, {ambiguous_edges}, {ambiguous_vertices}".format(**cad),
            f"{cad['largest_vertex_distance'] / size:.1e}", f"{cad['largest_node_distance'] / size:.1e}",
            f"{by_occ[0]:.1e}" if by_occ else "–", report["relax"]["relaxed_surface_edges"],
            valid["invalid"] + valid["undecided"], valid["below_bound"], f"{valid['min_scaled_jacobian']:.3g}",
            f"{seconds:.1f}", f"{verdict('order2')}; {by_gmsh[0]:.2f} s" if by_gmsh else "–",
            f"{verdict('gmsh')}; {by_gmsh[1]:.2f} s" if by_gmsh else "–"]


def report_size(path):
    """Returns the diagonal of a mesh in MSH 4.1 (ASCII)."""
    lines = iter(path.read_text().splitlines())
    points = []
    for line in lines:
        if line == "$Nodes":
            blocks = int(next(lines).split()[0])
            for _ in range(blocks):
                count = int(next(lines).split()[3])
                for _ in range(count):
                    next(lines)
                points += [tuple(map(float, next(lines).split()[:3])) for _ in range(count)]
    return math.dist(*[[f(p[k] for p in points) for k in range(3)] for f in (min, max)])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="output folder for models and meshes")
    parser.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; none: all")
    parser.add_argument("--camber", help="the program: print the table")
    arguments = parser.parse_args()
    if unknown := set(arguments.parts) - set(PARTS):
        parser.error(f"unknown parts: {', '.join(sorted(unknown))}")
    if arguments.camber and not shutil.which(arguments.camber):
        parser.error(f"{arguments.camber} is not a program")
    arguments.folder.mkdir(parents=True, exist_ok=True)
    if arguments.camber:
        print("| " + " | ".join(HEAD) + " |\n" + "|---" * len(HEAD) + "|", flush=True)
    for part in arguments.parts or PARTS:
        if not apart(make, part, arguments.folder, limit=60):
            continue
        if not arguments.camber:
            print(arguments.folder / f"{part}.step", flush=True)
            continue
        print("| " + " | ".join(map(str, row(part, arguments.camber, arguments.folder))) + " |", flush=True)


if __name__ == "__main__":
    main()
