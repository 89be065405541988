#!/usr/bin/env python3
"""Plane CAD models, meshed by Gmsh and curved by Camber (`curve --cad`) in 2D.

    python3 bench/cad_curves.py FOLDER --camber build/bin/camber      the models (.step), their meshes (.msh), and a Markdown table

- airfoil:  air around a NACA 0012 in a box, two splines, sharp trailing edge
- hole:     a disc with a hole bounded by a closed spline
- seam:     an ellipse in a disc, each with a reference of its own: a curve between two materials

Needs Gmsh with its OpenCASCADE kernel and its Python module (on Debian of the system's Python, /usr/bin/python3).
"""
import argparse
import json
import math
import subprocess
from pathlib import Path

import gmsh

from cad_parts import half_thickness


def airfoil():
    occ = gmsh.model.occ
    along = [0.5 * (1 - math.cos(math.pi * i / 40)) for i in range(41)]
    nose, tail = occ.addPoint(0, 0, 0), occ.addPoint(1, 0, 0)
    halves = [occ.addBSpline([nose, *(occ.addPoint(t, up * half_thickness(t), 0) for t in along[1:-1]), tail])
              for up in (1, -1)]
    wing = occ.addPlaneSurface([occ.addCurveLoop(halves)])
    occ.cut([(2, occ.addRectangle(-3, -3, 0, 8, 6))], [(2, wing)])
    occ.synchronize()
    return 0.1, 0.8, 12


def hole():
    occ = gmsh.model.occ
    radius = [0.4 + 0.12 * math.cos(3 * 2 * math.pi * i / 12) for i in range(12)]
    points = [occ.addPoint(r * math.cos(2 * math.pi * i / 12), r * math.sin(2 * math.pi * i / 12), 0)
              for i, r in enumerate(radius)]
    inner = occ.addPlaneSurface([occ.addCurveLoop([occ.addBSpline([*points, points[0]])])])
    occ.cut([(2, occ.addDisk(0, 0, 0, 1, 1))], [(2, inner)])
    occ.synchronize()
    return 0.05, 0.25, 0


def seam():
    occ = gmsh.model.occ
    occ.fragment([(2, occ.addDisk(0, 0, 0, 1, 1))], [(2, occ.addDisk(0.1, 0, 0, 0.6, 0.3))])
    occ.synchronize()
    for tag, (_, face) in enumerate(gmsh.model.getEntities(2), 1):
        gmsh.model.addPhysicalGroup(2, [face], tag)
    for tag, (_, curve) in enumerate(gmsh.model.getEntities(1), 1):
        gmsh.model.addPhysicalGroup(1, [curve], 10 + tag)
    return 0.05, 0.25, 0


def make(folder, name, model):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add(name)
    least, most, on_circle = model()
    gmsh.option.setNumber("Mesh.MeshSizeMin", least)
    gmsh.option.setNumber("Mesh.MeshSizeMax", most)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", on_circle)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(folder / f"{name}.step"))
    gmsh.write(str(folder / f"{name}.msh"))
    gmsh.finalize()


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--camber", required=True)
    options = arguments.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    print("| model | triangles | edges, vertices met | doubtful | vertices off | nodes off | invalid | straight to curved |")
    print("|---|---|---|---|---|---|---|---|")
    for name, model in (("airfoil", airfoil), ("hole", hole), ("seam", seam)):
        make(options.folder, name, model)
        file = lambda ending: str(options.folder / f"{name}{ending}")
        subprocess.run([options.camber, "curve", file(".msh"), "-o", file("-p2.meshb"), "--cad", file(".step"),
                        "--report", file(".json")], check=True, capture_output=True)
        report = json.loads(Path(file(".json")).read_text())
        boundary, cad = report["boundary"], report["boundary"]["cad"]
        doubtful = cad["ambiguous_facets"] - cad["resolved_facets"] + cad["ambiguous_vertices"]
        print(f"| {name} | {report['mesh']['elements']} | {cad['matched_edges']} of {cad['edges']}, {cad['matched_vertices']} of "
              f"{cad['vertices']} | {doubtful} | {cad['largest_vertex_distance']:.1e} | {cad['largest_node_distance']:.1e} | "
              f"{report['validity']['invalid']} | {boundary['largest_distance_straight']:.1e} to "
              f"{boundary['largest_distance']:.1e} |")


if __name__ == "__main__":
    main()
