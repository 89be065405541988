#!/usr/bin/env python3
"""Compares nodes of boundary edges by length and by accuracy with the projected midpoint, in anisotropic metrics.

    python3 bench/surface_lengths.py FOLDER --camber build/bin/camber              Markdown table
    python3 bench/surface_lengths.py FOLDER torus wing --camber build/bin/camber   some of the bodies

Needs Gmsh with its OpenCASCADE kernel and its Python module: `apt-get install python3-gmsh`.

- torus:    radii 1 and 0.3; a layer across y = −x/2
- wing:     air around half a wing, NACA 0012 (bench/cad_parts.py); a layer across x = 0.4 + y/2, as of a swept shock
- cylinder: radius 1, height 2, its lids ridges; a layer across x = 0.3 − z/2

In the layer the metric is up to 4.5 times as long across as along. Each body is curved onto its CAD model, onto the surrogate
of its own mesh, and (torus, cylinder) onto that of a mesh with half the size, across whose facets nodes move. Gains are ratios
− 1 of the lengths in the metric with the projected midpoint and with the node (by accuracy: of root mean square distances from the
geometry), for the sums over all processed edges, and for one edge.
"""
import argparse
import json
import multiprocessing
import subprocess
from pathlib import Path

import gmsh

from cad_parts import near_wing, quiet, wing

COLUMNS = ("body", "geometry", "by", "edges asked", "placed", "nothing better", "mean reduction", "largest", "walked", "limited",
           "off, far, elements", "largest distance", "invalid")


def layer(across, thickness, size):
    """Returns expressions of a metric with sizes `size`, along x up to 4.5 times smaller where `across` is 0."""
    fine = f"{1 / size ** 2:g}*{20 * thickness:g}/({thickness:g}+({across})^2)"
    return json.dumps({"expression": {"tensor": [fine, "0", f"{1 / size ** 2:g}", "0", "0", f"{1 / size ** 2:g}"]}})


def torus():
    gmsh.model.occ.addTorus(0, 0, 0, 1, 0.3)
    return 0.15, "y+0.5*x", 0.05


def cylinder():
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 2, 1)
    return 0.2, "x-0.3+0.5*z", 0.05


def air():
    wing()
    return None, "x-0.4-0.5*y", 0.02


BODIES = {"torus": torus, "wing": air, "cylinder": cylinder}
FINER = ("torus", "cylinder")


def make(body, path):
    """Makes the mesh and the model of a body, and returns the metric."""
    quiet()
    size, across, thickness = BODIES[body]()
    gmsh.model.occ.remove(gmsh.model.occ.getEntities(0))
    gmsh.model.occ.synchronize()
    if size:
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    else:
        near_wing()
    gmsh.write(str(path.with_suffix(".step")))
    gmsh.model.mesh.generate(3)
    gmsh.write(str(path))
    if body in FINER:
        gmsh.option.setNumber("Mesh.MeshSizeMax", size / 2)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size / 2)
        gmsh.model.mesh.clear()
        gmsh.model.mesh.generate(3)
        gmsh.write(str(path.with_name(f"{body}-finer.msh")))
    gmsh.finalize()
    return layer(across, thickness, size or 0.2)


def rows(body, folder, camber):
    mesh = folder / f"{body}.msh"
    with multiprocessing.Pool(1) as alone:
        metric = alone.apply(make, (body, mesh))
    geometries = {"CAD": ["--cad", mesh.with_suffix(".step")], "surrogate": []}
    if body in FINER:
        geometries["finer"] = ["--geometry", json.dumps({"mesh": str(mesh.with_name(f"{body}-finer.msh").resolve())})]
    for geometry, chosen in geometries.items():
        for by in ("projection", "length", "accuracy"):
            report = folder / f"{body}-{geometry}-{by}.json"
            done = subprocess.run([camber, "curve", mesh, "-o", report.with_suffix(".meshb"), "--metric", metric, "--report", report,
                                   "--set", f"stages/curve/boundary_nodes={by}", *chosen], capture_output=True, text=True, check=False)
            if done.returncode > 1:
                raise SystemExit(f"{body}, {geometry}, {by}: {done.stderr}")
            found = json.loads(report.read_text(encoding="utf-8"))
            boundary, validity = found["boundary"], found["validity"]
            nodes = boundary.get("nodes")
            figures = ("–",) * 8 if nodes is None else (
                nodes["edges"], nodes["moved"], nodes["no_improvement"], f"{100 * nodes['mean_reduction']:.2f} %", f"{100 * nodes['largest_reduction']:.1f} %",
                nodes["on_other_facets"], nodes["limited"], "{off_geometry}, {too_far}, {limited_by_elements}".format(**nodes))
            yield body, geometry, by, *figures, f"{boundary['largest_distance']:.1e}", validity["invalid"] + validity["undecided"]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("bodies", nargs="*", help=f"of {', '.join(BODIES)}; none: all")
    parser.add_argument("--camber", required=True)
    arguments = parser.parse_intermixed_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|")
    for body in arguments.bodies or BODIES:
        for row in rows(body, arguments.folder, arguments.camber):
            print("| " + " | ".join(map(str, row)) + " |", flush=True)
