#!/usr/bin/env python3
"""Round trips through file formats: a part with physical names is meshed by Gmsh, curved by Camber, written in
each format and read again. Also measures the speed of reading and writing.

    python3 bench/formats.py build/bin/camber                  the part, and the results of other programs for our files
    python3 bench/formats.py build/bin/camber --large 10       seconds and MB/s for a box of about 10 million tetrahedra

Needs gmsh, and for the checks by other programs python3-meshio, python3-vtk9 and cgns-convert (`./x setup --all`). The largest
difference is that of node positions in model units. Tags and names are compared one by one.

Seconds of --large are the best of three runs. `copy` is dd of the file with fsync, which Camber also calls. `/ copy`
is the time of Camber divided by the time of this copy.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "oracle"))
import gmf  # noqa: E402

GEOMETRY = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 2, 1, 0.5};
Cylinder(2) = {0.6, 0.5, -1, 0, 0, 3, 0.25};
Sphere(3) = {1.5, 0.5, 0.5, 0.3};
BooleanDifference(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
Physical Volume("steel", 7) = {4};
eps = 1e-3;
hole() = Surface In BoundingBox{0.35 - eps, 0.25 - eps, -eps, 0.85 + eps, 0.75 + eps, 0.5 + eps};
bowl() = Surface In BoundingBox{1.2 - eps, 0.2 - eps, 0.1, 1.8 + eps, 0.8 + eps, 0.5 + eps};
all() = Boundary{ Volume{4}; };
wall() = Abs(all());
wall() -= hole();
wall() -= bowl();
Physical Surface("hole", 2) = {hole()};
Physical Surface("bowl", 3) = {bowl()};
Physical Surface("wall", 11) = {wall()};
"""
# format, extension, True if its files are read again
FORMATS = [("msh", ".msh"), ("msh-ascii", ".msh"), ("msh2", ".msh"), ("msh2-ascii", ".msh"), ("mfem", ".mfem"),
           ("vtu", ".vtu"), ("cgns", ".cgns"), ("gmf-binary", ".meshb"), ("gmf-ascii", ".mesh")]


def timed(*command):
    begin = time.perf_counter()
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr}")
    return time.perf_counter() - begin, done


def best_of_three(result_file, *command):
    """Returns the minimum seconds of three runs of a command that writes a new file."""
    seconds = []
    for _ in range(3):
        result_file.unlink(missing_ok=True)
        seconds.append(timed(*command)[0])
    return min(seconds)


def names_of(camber, path):
    done = subprocess.run([camber, "info", "--json", str(path)], capture_output=True, text=True, check=True)
    return {(g["dimension"], g["reference"]): g["name"] for g in json.loads(done.stdout).get("groups", [])}


def cells_of(mesh):
    """Returns sorted rows of nodes with their reference, by kind."""
    return {name: np.array(sorted(np.column_stack([c.nodes, c.refs]).tolist())) for name, c in mesh.cells.items()}


def difference(a, b):
    if a.points.shape != b.points.shape:
        return "other points"
    return f"{np.abs(a.points - b.points).max():.1g}"


def tags(a, b):
    mine, theirs = cells_of(a), cells_of(b)
    lost = [name for name in mine if name not in theirs]
    same = all(np.array_equal(mine[name], theirs[name]) for name in mine if name in theirs)
    return ("same" if same else "other") + (f", no {' '.join(lost)}" if lost else "")


def opinion(path, kind, folder):
    """Returns the counts of nodes and of cells of the highest dimension by other programs."""
    if kind.startswith("msh"):
        done = subprocess.run(["gmsh", path, "-save", "-format", "msh22", "-o", folder / "again.msh"], capture_output=True, text=True)
        words = ["gmsh " + ("reads it" if done.returncode == 0 and "Error" not in done.stdout else "refuses it")]
        import meshio
        return ", ".join(words + [meshio_says(meshio, path)])
    if kind == "vtu":
        import meshio
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(path))
        reader.Update()
        grid = reader.GetOutput()
        return f"VTK: {grid.GetNumberOfPoints()} nodes, {grid.GetNumberOfCells()} cells, {meshio_says(meshio, path)}"
    if kind == "cgns":
        done = subprocess.run(["cgnscheck", path], capture_output=True, text=True)
        text = done.stdout + done.stderr
        return "cgnscheck: " + (text.strip().splitlines() or ["nothing"])[-1]
    return ""


def meshio_says(meshio, path):
    import contextlib
    with contextlib.redirect_stdout(open(os.devnull, "w")), contextlib.redirect_stderr(open(os.devnull, "w")):
        try:
            mesh = meshio.read(path)
        except SystemExit:  # raised for files that it rejects
            return "meshio refuses it"
    counts = {}
    for block in mesh.cells:
        counts[block.type] = counts.get(block.type, 0) + len(block.data)
    return f"meshio: {len(mesh.points)} nodes, " + ", ".join(f"{n} {kind}" for kind, n in counts.items())


def part(camber, folder):
    (folder / "part.geo").write_text(GEOMETRY)
    timed("gmsh", folder / "part.geo", "-3", "-clmax", "0.12", "-format", "msh41", "-o", folder / "part.msh")
    seconds, _ = timed(camber, "curve", folder / "part.msh", "-o", folder / "curved.msh", "--report", folder / "report.json")
    timed(camber, "convert", folder / "curved.msh", "-o", folder / "curved.meshb")
    reference, names = gmf.read(folder / "curved.meshb"), names_of(camber, folder / "curved.msh")
    print(f"part.msh: {len(reference.points)} nodes, " +
          ", ".join(f"{len(c.nodes)} {name}" for name, c in reference.cells.items()) +
          f", names {' '.join(sorted(names.values()))}; curved in {seconds:.2f} s\n")
    print("| format | bytes | written, s | read, s | largest difference of nodes | tags | names | others say |\n" + "|---" * 8 + "|")
    for kind, ending in FORMATS:
        path, back = folder / f"part-{kind}{ending}", folder / "back.meshb"
        wrote, _ = timed(camber, "convert", folder / "curved.msh", "-o", path, "--format", kind)
        read, _ = timed(camber, "convert", path, "-o", back)
        again = gmf.read(back)
        restored = names_of(camber, path)
        print(f"| {kind} | {path.stat().st_size} | {wrote:.2f} | {read:.2f} | {difference(reference, again)} | "
              f"{tags(reference, again)} | {sum(restored.get(k) == n for k, n in names.items())} of {len(names)} | "
              f"{opinion(path, kind, folder)} |", flush=True)


def large(camber, folder, millions, kinds):
    cells = round((millions * 1e6 / 6) ** (1 / 3))
    config = {"input": {"generate": {"box": {"cells": [cells] * 3}}}, "stages": [], "output": {"mesh": str(folder / "1.meshb")}}
    (folder / "box.json").write_text(json.dumps(config))
    timed(camber, "run", folder / "box.json")
    timed(camber, "convert", folder / "1.meshb", "-o", folder / "2.meshb", "--elevate")
    print(f"{6 * cells ** 3} tetrahedra\n")
    print("Best of three; copy: dd bs=16M conv=fsync.\n")
    print("| degree | format | MB | copy, s | read and written as .meshb, s | MB/s | / copy | written from .meshb, s | MB/s | / copy |\n" +
          "|---" * 10 + "|")
    for degree in (1, 2):
        for kind, ending in FORMATS:
            if kinds and kind not in kinds:
                continue
            path, copy, back = folder / f"box{ending}", folder / "copy", folder / "back.meshb"
            wrote = best_of_three(path, camber, "convert", folder / f"{degree}.meshb", "-o", path, "--format", kind)
            size = path.stat().st_size / 1e6
            copied = best_of_three(copy, "dd", f"if={path}", f"of={copy}", "bs=16M", "conv=fsync")
            read = best_of_three(back, camber, "convert", path, "-o", back)
            print(f"| {degree} | {kind} | {size:.0f} | {copied:.2f} | {read:.2f} | {size / read:.0f} | {read / copied:.1f} | "
                  f"{wrote:.2f} | {size / wrote:.0f} | {wrote / copied:.1f} |", flush=True)
            for result_file in (path, copy, back):
                result_file.unlink()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("--large", type=float, metavar="MILLIONS")
    parser.add_argument("--formats", default="", help="of --large, only these: msh,vtu,…")
    parser.add_argument("--folder", type=Path, help="folder for the files")
    arguments = parser.parse_args()
    camber = str(Path(shutil.which(arguments.camber) or arguments.camber).resolve())
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        folder.mkdir(exist_ok=True)
        large(camber, folder, arguments.large, arguments.formats.split(",") if arguments.formats else []) if arguments.large else part(camber, folder)


if __name__ == "__main__":
    main()
