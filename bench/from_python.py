#!/usr/bin/env python3
"""Cost of the Python module compared with the program: seconds and memory to read, build, curve, access and write a mesh.

    /usr/bin/python3 bench/from_python.py build [--elements 1e6] [--threads 2]

Each row is a separate process: its seconds and the maximum growth of its memory.
"""
import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time

WAYS = {
    "program: curve": None,
    "python: read, curve, write": "m = camber.read(mesh); made = camber.curve(m, threads=threads); made.mesh.write(out)",
    "python: read": "m = camber.read(mesh)",
    "python: read, all arrays": "m = camber.read(mesh); m.points, m.cells, m.corners, m.references",
    "python: arrays shared": "m = camber.Mesh(points, {'tetra': cells}, {'tetra': references})",
    "python: arrays copied": "m = camber.Mesh(points.copy(), {'tetra': cells.astype(int)}, {'tetra': references.copy()})",
    "python: nodes of degree 2": "m = curved; m.points, m.cells",
}
CHILD = """
import resource, sys, time
import numpy as np
import camber
mesh, out, way, threads = sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4])
if "arrays shared" in sys.argv[5] or "arrays copied" in sys.argv[5]:
    source = camber.read(mesh)
    points, cells, references = (np.array(a) for a in (source.points, source.corners["tetra"], source.references["tetra"]))
    del source
    for a in (points, cells, references):
        a.flags.writeable = False
if "nodes of degree 2" in sys.argv[5]:
    curved = camber.curve(camber.read(mesh), threads=threads).mesh
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
begin = time.perf_counter()
exec(way)
print(time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


def of_program(program, mesh, out, threads):
    begin = time.perf_counter()
    subprocess.run([program, "curve", mesh, "-o", out, "--threads", str(threads), "--quiet"], check=True)
    return time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss


def of_python(build, name, way, mesh, out, threads):
    said = subprocess.run([sys.executable, "-c", CHILD, mesh, out, way, str(threads), name], check=True, text=True,
                          capture_output=True, env={**os.environ, "PYTHONPATH": os.path.join(build, "python")}).stdout
    seconds, kilobytes = said.split()
    return float(seconds), int(kilobytes)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--elements", default="1e6")
    parser.add_argument("--threads", type=int, default=2)
    a = parser.parse_args()
    program = os.path.join(a.build, "bin", "camber")
    with tempfile.TemporaryDirectory() as folder:
        mesh, out = (os.path.join(folder, name) for name in ("mesh.meshb", "out.meshb"))
        subprocess.run([program, "generate", "shell", "--structure", "prisms", "--elements", a.elements, "-o", mesh, "--quiet"],
                       check=True)
        print("| way | s | MB |\n| --- | --- | --- |")
        for name, way in WAYS.items():
            seconds, kilobytes = (of_program(program, mesh, out, a.threads) if way is None
                                  else of_python(a.build, name, way, mesh, out, a.threads))
            print(f"| {name} | {seconds:.2f} | {kilobytes / 1024:.0f} |", flush=True)


if __name__ == "__main__":
    main()
