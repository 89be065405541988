#!/usr/bin/env python3
"""Reads a sample of some hundreds of files of other programs, made by Gmsh, meshio and VTK and by hand in other formats, with
`camber info`, `convert` and `check`.

    /usr/bin/python3 bench/sample_of_files.py build/bin/camber [ANOTHER_CAMBER…] [--folder FOLDER]

Prints, for each program, the number of files of each kind that are read with the expected numbers of simplices, reported with unsupported
kinds of cells, read otherwise, or rejected with a reason. docs/formats.md has the table. Needs gmsh, meshio and vtk
(Debian: gmsh, python3-meshio, python3-vtk9, python3-h5py). Files of missing programs are skipped.
"""
import argparse
import collections
import json
import subprocess
import tempfile
from pathlib import Path

import sample_by_hand
import sample_by_meshio
import sample_by_vtk

# Formats of Gmsh that Camber reads or whose extensions it knows: name, extension, True if binary.
FORMATS = [("msh1", "msh", False), ("msh22", "msh", False), ("msh22", "msh", True), ("msh3", "msh", False), ("msh40", "msh", False),
           ("msh41", "msh", False), ("msh41", "msh", True), ("mesh", "mesh", False), ("vtk", "vtk", False), ("vtk", "vtk", True),
           ("su2", "su2", False), ("cgns", "cgns", False)]

MODELS = {  # name: the script, the dimension, the orders
    "ball": ('SetFactory("OpenCASCADE"); Sphere(1) = {0, 0, 0, 1}; Physical Volume("ball", 1) = {1}; Physical Surface("skin", 2) = {1};', 3, (1, 2)),
    "no-groups": ('SetFactory("OpenCASCADE"); Box(1) = {0, 0, 0, 1, 2, 1};', 3, (1, 2)),
    "two-solids": ('SetFactory("OpenCASCADE"); Box(1) = {0, 0, 0, 2, 2, 2}; Sphere(2) = {1, 1, 1, 0.6};'
                   'BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; } Physical Volume("inside", 5) = {2};'
                   'Physical Volume("outside", 6) = {3}; Physical Surface("walls", 7) = {1:20};', 3, (1, 2)),
    "surface": ('SetFactory("OpenCASCADE"); Cylinder(1) = {0, 0, 0, 0, 0, 2, 1}; Physical Surface("skin", 1) = {1:3};', 2, (1, 2)),
    "square": ('SetFactory("OpenCASCADE"); Rectangle(1) = {0, 0, 0, 2, 1}; Disk(2) = {1, 0.5, 0, 0.2};'
               'BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };'
               'Physical Surface("plate", 1) = {3}; Physical Curve("hole", 2) = {5}; Physical Curve("rim", 3) = {1:4};', 2, (1, 2)),
    "embedded": ('Point(1) = {0, 0, 0}; Point(2) = {2, 0, 0}; Point(3) = {2, 2, 0}; Point(4) = {0, 2, 0}; Point(5) = {0.5, 1, 0};'
                 'Point(6) = {1.5, 1, 0}; Point(7) = {3, 3, 0}; Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};'
                 'Line(5) = {5, 6}; Line(6) = {3, 7}; Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1}; Curve{5} In Surface{1};'
                 'Physical Surface(1) = {1}; Physical Curve(2) = {1:4}; Physical Curve(3) = {5, 6};', 2, (1,)),
    "quads": ('Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Line(1) = {1, 2}; Transfinite Curve {1} = 4;'
              'Extrude {0, 1, 0} { Curve{1}; Layers{3}; Recombine; }', 2, (1,)),
    "hexahedra": ('Point(1) = {0, 0, 0}; Extrude {1, 0, 0} { Point{1}; Layers{2}; } Extrude {0, 1, 0} { Curve{1}; Layers{2}; Recombine; }'
                  'Extrude {0, 0, 1} { Surface{5}; Layers{2}; Recombine; }', 3, (1,)),
    "prisms": ('Point(1) = {0, 0, 0}; Extrude {1, 0, 0} { Point{1}; Layers{2}; } Extrude {0, 1, 0} { Curve{1}; Layers{2}; }'
               'Extrude {0, 0, 1} { Surface{5}; Layers{2}; Recombine; }', 3, (1,)),
    "cubic": ('SetFactory("OpenCASCADE"); Sphere(1) = {0, 0, 0, 1}; Physical Volume(1) = {1};', 3, (3,)),
}


def gmsh(*arguments):
    return subprocess.run(["gmsh", "-nopopup", "-v", "1", *map(str, arguments)], capture_output=True, encoding="utf-8", errors="replace", timeout=300)


def by_gmsh(folder):
    """Yields (kind, path, simplices of the highest dimension, or None if no mesh can store the cells)."""
    for name, (script, dimension, orders) in MODELS.items():
        geo = folder / (name + ".geo")
        geo.write_text(script.replace(";", ";\n") + "Mesh.MeshSizeMax = 0.6;\n")
        for order in orders:
            reference = folder / f"{name}-{order}-reference.msh"
            gmsh(geo, f"-{dimension}", "-order", order, "-format", "msh41", "-o", reference)
            counts = sample_by_meshio.counts(reference)
            for kind, ending, binary in FORMATS:
                path = folder / f"gmsh-{name}-{order}-{kind}{'-bin' if binary else ''}.{ending}"
                gmsh(geo, f"-{dimension}", "-order", order, *(["-bin"] if binary else []), "-format", kind, "-o", path)
                if path.exists() and path.stat().st_size > 0:
                    yield "Gmsh " + kind, path, counts
    for name in ("ball", "square"):
        for kind in ("msh22", "msh41"):
            for options in (["-save_all"], ["-part", "3"], ["-setnumber", "Mesh.SaveParametric", "1"]):
                path = folder / f"gmsh-{name}-{kind}{options[0]}{options[1].replace('.', '') if len(options) > 1 else ''}.msh"
                gmsh(folder / (name + ".geo"), f"-{MODELS[name][1]}", *options, "-format", kind, "-o", path)
                if path.exists():
                    yield "Gmsh " + kind, path, sample_by_meshio.counts(folder / f"{name}-1-reference.msh")


def stl_by_gmsh(folder):
    """Yields surfaces as STL: one solid, one per surface, in binary."""
    for name in ("ball", "two-solids", "surface", "no-groups"):
        expected = sample_by_meshio.triangles(folder / f"{name}-1-reference.msh")
        for way, options in (("one", []), ("solids", ["-setnumber", "Mesh.StlOneSolidPerSurface", "1"]), ("bin", ["-bin"])):
            path = folder / f"gmsh-{name}-{way}.stl"
            gmsh(folder / (name + ".geo"), "-2", *options, "-o", path)
            if path.exists():
                yield "Gmsh stl", path, expected


def files_in(folder):
    yield from by_gmsh(folder)
    yield from stl_by_gmsh(folder)
    references = [folder / f"{name}-{order}-reference.msh" for name in ("ball", "two-solids", "square", "surface") for order in (1, 2)]
    yield from sample_by_meshio.files(folder, references)
    yield from sample_by_vtk.files(folder)
    yield from sample_by_hand.files(folder)


def run(camber, *arguments):
    return subprocess.run([camber, *map(str, arguments)], capture_output=True, encoding="utf-8", errors="replace", timeout=300)


def verdict(camber, path, counts, scratch):
    """Returns a class, and the message unless the class is a good one."""
    info = run(camber, "info", path, "--json")
    if info.returncode != 0:
        return "refused", info.stderr.strip()
    content = json.loads(info.stdout)
    if "not_held" in content:
        return "counted by kind", ""
    done = run(camber, "convert", path, "-o", scratch / "out.meshb")
    checked = run(camber, "check", path)
    if done.returncode != 0 or checked.returncode > 1:
        return "refused", (done.stderr + checked.stderr).strip()
    highest = content.get("tetrahedra", 0) or content.get("triangles", 0)
    if counts is not None and highest != counts:
        return "read, other counts", f"{highest} simplices, {counts} written"
    if checked.returncode == 1 and "face of no" in checked.stdout:
        curved = run(camber, "curve", path, "-o", scratch / "out.meshb")
        if curved.returncode > 1:
            return "refused", curved.stderr.strip().splitlines()[-1]
    return "read well", ""


CLASSES = ["read well", "counted by kind", "read, other counts", "refused"]


def table(camber, files, scratch):
    by_kind, reasons = collections.defaultdict(collections.Counter), collections.defaultdict(list)
    for kind, path, counts in files:
        found, why = verdict(camber, path, counts, scratch)
        by_kind[kind][found] += 1
        if why:
            reasons[why.replace(str(path), "FILE").splitlines()[-1].split(" (")[0][:120]].append(path.name)
    print(f"\n{camber}: {len(files)} files\n")
    print(f"| {'written by':<22} | files | " + " | ".join(CLASSES) + " |\n|---|" + "---|" * (len(CLASSES) + 1))
    rows = [*sorted(by_kind.items()), ("all", sum(by_kind.values(), collections.Counter()))]
    for kind, found in rows:
        print(f"| {kind:<22} | {sum(found.values())} | " + " | ".join(str(found[c]) for c in CLASSES) + " |")
    print()
    for why, names in sorted(reasons.items(), key=lambda item: -len(item[1])):
        print(f"{len(names):4}  {why}   ({', '.join(names[:3])}{' …' if len(names) > 3 else ''})")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--folder", help="folder for the files (default: a temporary one)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(arguments.folder or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        files = list(files_in(folder))
        for program in arguments.programs:
            table(str(Path(program).resolve()), files, Path(temporary))


if __name__ == "__main__":
    main()
