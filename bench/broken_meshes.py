#!/usr/bin/env python3
"""Broken meshes of degree 2 from CAD, made with Gmsh: coarse curved parts without high-order optimisation. Optionally repairs
them with the optimisers of Gmsh and with Camber.

    python3 bench/broken_meshes.py FOLDER                                        the meshes (.mesh), their straight meshes
                                                                                 (-straight.mesh), Gmsh's .msh, the models (.step)
    python3 bench/broken_meshes.py FOLDER --camber build/bin/camber --optimise   and a table of both repairs

Needs Gmsh with its OpenCASCADE kernel and its Python module: `apt-get install gmsh python3-gmsh` (on Debian they belong to
the system's Python, /usr/bin/python3), or `pip install gmsh`. The same version of Gmsh makes the same meshes.

The optimisers of Gmsh use the CAD model, along which boundary nodes may slide, and run on the generated mesh with their
default options. Their seconds are those of the call; Camber's seconds are those of the whole program with files.
`camber check` evaluates the results. An element is invalid if its Jacobian determinant is not certified positive. `min` is
the minimum determinant as a share of that of the straight element. The first repair by Camber does not move the boundary;
remaining invalid elements mostly have boundary triangles that Gmsh folded. `CAD` is `camber repair --cad` with nodes sliding
on the model. `shape` is `camber curve --cad --objective shape` of the straight mesh. `moved` is the number of boundary nodes
at new positions and their largest distance from an original position.
"""
import argparse
import json
import math
import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path

try:
    import gmsh
except ImportError:
    sys.exit("broken_meshes.py: the Python module gmsh is missing: apt-get install gmsh python3-gmsh, and run "
             "/usr/bin/python3; or pip install gmsh")


# ---------------------------------------------------------------- the parts: each function builds a model in Gmsh

def sizes(least, most, per_turn=0):
    """Sets edge lengths and the number of elements per full circle of curvature (0: ignored)."""
    for option, value in (("MeshSizeMin", least), ("MeshSizeMax", most), ("MeshSizeFromCurvature", per_turn)):
        gmsh.option.setNumber("Mesh." + option, value)


def bore():
    """A block with a bore next to one side, which leaves a thin wall."""
    occ = gmsh.model.occ
    occ.cut([(3, occ.addBox(0, 0, 0, 4, 3, 2))], [(3, occ.addCylinder(2, 1.03, 0, 0, 0, 2, 1))])
    occ.synchronize()
    sizes(0.9, 0.9)


def elbow():
    """A quarter of a bent pipe with a thin wall."""
    occ = gmsh.model.occ
    occ.cut([(3, occ.addTorus(0, 0, 0, 3, 1, angle=math.pi / 2))],
            [(3, occ.addTorus(0, 0, 0, 3, 0.88, angle=math.pi / 2))])
    occ.synchronize()
    sizes(0.7, 0.7)


def gap():
    """The space between a box and a sphere with a small gap."""
    occ = gmsh.model.occ
    occ.cut([(3, occ.addBox(-1.5, -1.5, -1.02, 3, 3, 3))], [(3, occ.addSphere(0, 0, 0, 1))])
    occ.synchronize()
    sizes(0.6, 0.6)


def fillet():
    """A block with some rounded edges and a pocket close to them."""
    occ = gmsh.model.occ
    block = occ.addBox(0, 0, 0, 3, 2, 1)
    occ.synchronize()
    upper = [tag for _, tag in gmsh.model.getEntitiesInBoundingBox(-0.1, -0.1, 0.9, 3.1, 2.1, 1.1, 1)]
    occ.fillet([block], upper, [0.5])
    pocket = occ.addCylinder(1.5, 1, 0, 0, 0, 0.93, 0.85)
    occ.cut([(3, block)], [(3, pocket)])
    occ.synchronize()
    sizes(0.85, 0.85)


def crossing():
    """Two hollow cylinders that intersect."""
    occ = gmsh.model.occ
    outer, _ = occ.fuse([(3, occ.addCylinder(-3, 0, 0, 6, 0, 0, 1))], [(3, occ.addCylinder(0, 0, 0, 0.5, 0, 3, 0.7))])
    inner, _ = occ.fuse([(3, occ.addCylinder(-3, 0, 0, 6, 0, 0, 0.92))],
                        [(3, occ.addCylinder(0, 0, 0, 0.5, 0, 3, 0.64))])
    occ.cut(outer, inner)
    occ.synchronize()
    sizes(0.55, 0.55)


def layer():
    """Layers around a quarter of a cylinder, independent of its curvature: the first has 1/60 of the edge length."""
    occ, turn = gmsh.model.occ, math.pi / 2
    at = lambda r, angle: occ.addPoint(r * math.cos(angle), r * math.sin(angle), 0)
    centre, a, b, c, d = occ.addPoint(0, 0, 0), at(1, 0), at(1, turn), at(3, turn), at(3, 0)
    inner, outer = occ.addCircleArc(a, centre, b), occ.addCircleArc(d, centre, c)
    sides = occ.addLine(a, d), occ.addLine(b, c)
    section = occ.addPlaneSurface([occ.addCurveLoop([inner, sides[1], -outer, -sides[0]])])
    occ.extrude([(2, section)], 0, 0, 2, numElements=[4])
    occ.synchronize()
    mesh = gmsh.model.mesh
    for curve in (inner, outer):
        mesh.setTransfiniteCurve(curve, 5)
    for curve in sides:
        mesh.setTransfiniteCurve(curve, 15, "Progression", 1.4)
    mesh.setTransfiniteSurface(section)
    sizes(0.01, 2)


def wing():
    """The air around a swept, tapered wing with a sharp trailing edge, with a thin layer about the skin: all coarse."""
    occ = gmsh.model.occ

    def section(y, x, chord, points=24):
        def half(t):  # NACA 0015; the last coefficient closes the trailing edge
            return 0.75 * (0.2969 * math.sqrt(t) - 0.1260 * t - 0.3516 * t ** 2 + 0.2843 * t ** 3 - 0.1036 * t ** 4)
        along = [0.5 * (1 - math.cos(math.pi * i / points)) for i in range(points + 1)]
        nose, tail = occ.addPoint(x, y, 0), occ.addPoint(x + chord, y, 0)
        side = lambda up: occ.addBSpline([nose, *(occ.addPoint(x + chord * t, y, up * chord * half(t))
                                                  for t in along[1:-1]), tail])
        return occ.addWire([side(1), -side(-1)])

    def blade(scale, tip):
        """Returns a section about the quarter chord of the wing, larger by `scale`."""
        sections = [section(y, x + 0.25 * chord * (1 - scale), chord * scale) for y, x, chord in
                    ((0, 0, 1), (tip, 0.4 * tip, 1 - 0.275 * tip))]
        return occ.addThruSections(sections, makeSolid=True, makeRuled=True)

    skin, rim = blade(1, 2), blade(1.1, 2.04)
    layer, _ = occ.cut(rim, skin, removeObject=True, removeTool=False)
    air, _ = occ.cut([(3, occ.addBox(-1.5, 0, -1.5, 4.5, 3.5, 3))], skin)
    occ.fragment(air, layer)
    occ.synchronize()
    near = gmsh.model.getEntitiesInBoundingBox(-0.2, -0.1, -0.2, 2, 2.2, 0.2, 0)
    gmsh.model.mesh.setSize(near, 0.12)
    sizes(0.01, 0.9)


PARTS = {part.__name__: part for part in (bore, elbow, gap, fillet, crossing, layer, wing)}
OPTIMISERS = {  # numbers of Mesh.HighOrderOptimize
    "1 optimise": ["HighOrder"], "2 elastic, optimise": ["HighOrderElastic", "HighOrder"],
    "3 elastic": ["HighOrderElastic"], "4 fast curving": ["HighOrderFastCurving"]}


# ---------------------------------------------------------------- meshes and files

def generate(part):
    """Meshes the part in a separate process and drops the output of Gmsh."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    gmsh.initialize([], False)
    for option, value in (("General.Terminal", 0), ("General.NumThreads", 1), ("Mesh.ElementOrder", 2),
                          ("Mesh.HighOrderOptimize", 0), ("Mesh.Binary", 0)):
        gmsh.option.setNumber(option, value)
    PARTS[part]()
    gmsh.model.mesh.generate(3)


NODES = {9: 6, 11: 10}  # Gmsh element types: triangle and tetrahedron of degree 2


def rows_of(dimension, kind, order):
    """Returns elements of a kind in GMF node order with Gmsh's numbers, and their CAD entity as reference."""
    rows = []
    for _, entity in gmsh.model.getEntities(dimension):
        _, nodes = gmsh.model.mesh.getElementsByType(kind, entity)
        for at in range(0, len(nodes), NODES[kind]):
            rows.append([int(nodes[at + i]) for i in order] + [entity])
    return rows


def write_gmf(path, degree=2):
    """Writes the mesh or its straight simplices (degree 1) in GMF (ASCII). Gmsh orders the nodes of a tetrahedron
    e01 e12 e02 e03 e23 e13: the last two are swapped."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    point = {int(tag): coordinates[3 * i:3 * i + 3] for i, tag in enumerate(tags)}
    tetrahedron, triangle = ([0, 1, 2, 3, 4, 5, 6, 7, 9, 8], [0, 1, 2, 3, 4, 5]) if degree == 2 else ([0, 1, 2, 3], [0, 1, 2])
    suffix = "P2" if degree == 2 else ""
    blocks = {"Tetrahedra" + suffix: rows_of(3, 11, tetrahedron), "Triangles" + suffix: rows_of(2, 9, triangle)}
    used = sorted({tag for row in blocks["Tetrahedra" + suffix] for tag in row[:-1]})
    numbers = {tag: i + 1 for i, tag in enumerate(used)}
    with open(path, "w") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(used)}\n")
        for tag in used:
            file.write(" ".join(repr(float(x)) for x in point[tag]) + " 0\n")
        for name, rows in blocks.items():
            file.write(f"{name}\n{len(rows)}\n")
            file.writelines(" ".join(str(numbers[tag]) for tag in row[:-1]) + f" {row[-1]}\n" for row in rows)
        file.write("End\n")


def make(part, folder):
    generate(part)
    write_gmf(folder / f"{part}.mesh")
    write_gmf(folder / f"{part}-straight.mesh", degree=1)
    gmsh.write(str(folder / f"{part}.msh"))
    gmsh.write(str(folder / f"{part}.step"))


def optimise(part, name, path, seconds):
    """Repeats the mesh, which is the same, and runs one optimiser on it. `seconds` receives the time."""
    generate(part)
    start = time.perf_counter()
    try:
        for method in OPTIMISERS[name]:
            gmsh.model.mesh.optimize(method)
    except Exception as error:  # Gmsh raises no more precise type
        sys.exit(f"{part}: Gmsh {name}: {error}")
    seconds.value = time.perf_counter() - start
    write_gmf(path)


# ---------------------------------------------------------------- the table

def check(camber, path):
    """Returns the number of elements, of those not certified valid, and the minimum scaled Jacobian."""
    found = json.loads(subprocess.run([camber, "check", path, "--json"], capture_output=True, text=True).stdout)
    return found["elements"], found["invalid"] + found["undecided"], found["min_scaled_jacobian"]


def boundary_of(path):
    """Returns the positions of the nodes of boundary triangles in an ASCII file."""
    words = iter(path.read_text().split())
    points, nodes = [], set()
    for word in words:
        if word == "Vertices":
            points = [tuple(float(next(words)) for _ in range(4))[:3] for _ in range(int(next(words)))]
        elif word == "TrianglesP2":
            for _ in range(int(next(words))):
                nodes.update([int(next(words)) for _ in range(7)][:6])
    return {points[n - 1] for n in nodes}


def cell(camber, path, original, seconds):
    """Returns elements not certified valid, minimum scaled Jacobian, time and moved boundary nodes."""
    _, invalid, least = check(camber, path)
    return f"{invalid}, {least:.2g}, {seconds:.2f} s, {len(boundary_of(path) - original)}"


def by_optimiser(part, name, folder, camber, original, limit):
    """The cell of one of Gmsh's optimisers."""
    path = folder / f"{part}-gmsh-{name[0]}.mesh"
    seconds = multiprocessing.Value("d", 0)
    process = multiprocessing.Process(target=optimise, args=(part, name, path, seconds))
    process.start()
    process.join(limit)
    if process.is_alive():
        process.kill()
        return f"not done in {limit:g} s"
    return cell(camber, path, original, seconds.value) if process.exitcode == 0 else "gave up"


def by_camber(camber, original, path, *arguments):
    """The cell of one run of Camber."""
    start = time.perf_counter()
    done = subprocess.run([camber, *arguments, "-o", path], capture_output=True, text=True)
    seconds = time.perf_counter() - start
    if done.returncode > 1:
        sys.exit(f"broken_meshes.py: {done.stderr}")
    return cell(camber, path, original, seconds)


def ways_of_camber(part, folder, tolerance):
    """{title: (name of the output, arguments)}"""
    mesh, straight, model = folder / f"{part}.mesh", folder / f"{part}-straight.mesh", folder / f"{part}.step"
    with_model = lambda bound: ("repair", mesh, "--cad", model, "--min-scaled-jacobian", bound)
    return {"boundary fixed": ("fixed", ("repair", mesh, "--boundary-tolerance", "0")),
            f"tolerance {tolerance:g}": ("moved", ("repair", mesh, "--boundary-tolerance", str(tolerance))),
            "CAD, valid": ("cad", with_model("1e-9")),
            "CAD, 0.2": ("cad-0.2", with_model("0.2")),
            "straight mesh, `shape`, CAD, 0.2": ("shape", ("curve", straight, "--cad", model, "--objective", "shape", "--min-scaled-jacobian", "0.2"))}


def row(part, options):
    """The cells of one part."""
    original = boundary_of(options.folder / f"{part}.mesh")
    elements, invalid, _ = check(options.camber, options.folder / f"{part}.mesh")
    cells = [part, elements, invalid]
    for name, arguments in ways_of_camber(part, options.folder, options.tolerance).values():
        cells.append(by_camber(options.camber, original, options.folder / f"{part}-camber-{name}.mesh", *arguments))
    for name in OPTIMISERS if options.optimise else ():
        cells.append(by_optimiser(part, name, options.folder, options.camber, original, options.limit))
    return cells


def in_process_of_its_own(target, *arguments):
    """Gmsh keeps options from one model to the next, a new process does not."""
    process = multiprocessing.Process(target=target, args=arguments)
    process.start()
    process.join()
    if process.exitcode != 0:
        sys.exit(f"broken_meshes.py: Gmsh failed on {arguments[0]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="output folder for the meshes")
    parser.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; none: all")
    parser.add_argument("--camber", help="the program: print the table, with its repair")
    parser.add_argument("--optimise", action="store_true", help="run Gmsh's optimisers too (needs --camber)")
    parser.add_argument("--tolerance", type=float, default=0.1,
                        help="tolerance of the boundary in a second repair (the parts are 3 to 6 across)")
    parser.add_argument("--limit", type=float, default=600, help="seconds for an optimiser")
    arguments = parser.parse_args()
    if unknown := set(arguments.parts) - set(PARTS):
        parser.error(f"unknown parts: {', '.join(sorted(unknown))}")
    if arguments.optimise and not arguments.camber:
        parser.error("--optimise needs --camber to evaluate the results")
    arguments.folder.mkdir(parents=True, exist_ok=True)
    if arguments.camber:
        optimisers = [f"Gmsh {name}" for name in OPTIMISERS] if arguments.optimise else []
        titles = ["part", "elements", "invalid", *ways_of_camber("", arguments.folder, arguments.tolerance), *optimisers]
        print("| " + " | ".join(titles) + " |\n" + "|---" * len(titles) + "|", flush=True)
    for part in arguments.parts or PARTS:
        in_process_of_its_own(make, part, arguments.folder)
        if arguments.camber:
            print("| " + " | ".join(map(str, row(part, arguments))) + " |", flush=True)
        else:
            print(arguments.folder / f"{part}.mesh", flush=True)


if __name__ == "__main__":
    main()
