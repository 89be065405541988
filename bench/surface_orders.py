#!/usr/bin/env python3
"""Order of convergence of curved boundaries to a known surface, on irregular meshes, each with half the size of the previous one.

    python3 bench/surface_orders.py FOLDER --camber build/bin/camber               Markdown table; FOLDER/orders.json
    python3 bench/surface_orders.py FOLDER --camber build/bin/camber torus cone    some of the bodies

Needs Gmsh with its OpenCASCADE kernel, its Python module, meshio and SciPy: `apt-get install python3-gmsh python3-meshio python3-scipy`.

Bodies are standalone surfaces, meshed by Gmsh (Delaunay, independent of the curvature), with vertices on the surface.

- torus, cylinder, cone: closed forms; the last two with open rims
- bump:  a sphere whose radius is 1 + 0.15 xy + 0.1 z³; without a CAD file
- naca:  the skin of a wing of constant section, NACA 0012 as one spline, sharp at its trailing edge; sizes by points on a circle
- patch: a bicubic B-spline with 6 × 6 poles, strongly bent

Evaluated are Camber's surrogate (`camber geometry --surface`: its cubic triangles at sixths, separately on edges and inside) and
boundaries of degree 2 (`camber curve` with and without `--cad`: nodes of edges, and all points at sixths with their normals).
Distances and normals are those of the closed form, of Newton's method along the gradient (bump), or in the parameters of
Gmsh's faces (naca, patch). Values are maxima over at most 1500 triangles; normals in radians. For boundaries also the root mean
square by area, and the maximum of the distance divided by the cube of the longest edge of the triangle. The maximum decreases
a little slower than the distance of each triangle, since larger meshes have more irregular triangles.
"""
import argparse
import json
import math
import multiprocessing
import subprocess
from pathlib import Path

import gmsh
import meshio
import numpy as np
import scipy.spatial

from cad_parts import half_thickness, quiet

MOST_TRIANGLES = 1500


# ---------------------------------------------------------------- bodies: the model in Gmsh

def skin_of(solid):
    """Keeps the curved faces of a solid and removes the solid and its lids."""
    occ = gmsh.model.occ
    occ.synchronize()
    faces = gmsh.model.getBoundary([solid], oriented=False)
    lids = [face for face in faces if gmsh.model.getType(*face) == "Plane"]
    occ.remove([solid])
    occ.remove(lids)


def torus():
    skin_of((3, gmsh.model.occ.addTorus(0, 0, 0, 1, 0.4)))


def cylinder():
    skin_of((3, gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 2, 1)))


def cone():
    skin_of((3, gmsh.model.occ.addCone(0, 0, 0, 0, 0, 1.5, 1, 0.4)))


def bump():
    skin_of((3, gmsh.model.occ.addSphere(0, 0, 0, 1)))


def naca(points=40):
    """A wing section as one spline around the nose, where two would meet at an angle of 25 degrees."""
    occ = gmsh.model.occ
    along = [0.5 * (1 - math.cos(math.pi * i / points)) for i in range(points + 1)]
    upper = [(t, half_thickness(t)) for t in along[:-1]] + [(1, 0)]
    around = upper[::-1] + [(t, -z) for t, z in upper[1:]]
    # The first of Gmsh's degrees is that across rows of poles.
    occ.addBSplineSurface([occ.addPoint(x, y, z) for y in (0, 0.3) for x, z in around], len(around), 1, 5)


def patch():
    occ = gmsh.model.occ
    poles = [occ.addPoint(i / 5, j / 5, 0.25 * math.sin(1.9 * i + 0.7) * math.cos(1.3 * j))
             for j in range(6) for i in range(6)]
    occ.addBSplineSurface(poles, 6, 3, 3)


# ---------------------------------------------------------------- exact surfaces: (distance, unit normal) of points

def of_torus(p):
    ring = np.hypot(p[:, 0], p[:, 1])
    across = np.stack([ring - 1, p[:, 2]])
    length = np.hypot(*across)
    flat = across[0] / length / ring
    return np.abs(length - 0.4), np.stack([p[:, 0] * flat, p[:, 1] * flat, across[1] / length], 1)


def of_lathe(radius, slope):
    """A straight line rotated about z: the radius at z = 0 and its growth with z."""
    def of_points(p):
        ring, lean = np.hypot(p[:, 0], p[:, 1]), math.hypot(1, slope)
        normal = np.stack([p[:, 0] / ring, p[:, 1] / ring, np.full(len(p), -slope)], 1) / lean
        return np.abs(ring - radius - slope * p[:, 2]) / lean, normal
    return of_points


def bump_radius(p):
    n = p / np.linalg.norm(p, axis=1)[:, None]
    return 1 + 0.15 * n[:, 0] * n[:, 1] + 0.1 * n[:, 2] ** 3


def of_bump(p):
    """F = |p| − R(p/|p|), with its gradient by central differences; the foot solves F = 0 and p − foot ∥ ∇F."""
    def value(q):
        return np.linalg.norm(q, axis=1) - bump_radius(q)

    def gradient(q, h=1e-5):
        return np.stack([(8 * (value(q + h * e) - value(q - h * e)) - value(q + 2 * h * e) + value(q - 2 * h * e)) / (12 * h)
                         for e in np.eye(3)], 1)

    foot = p.copy()
    for _ in range(12):
        g = gradient(foot)
        squared = (g * g).sum(1)
        beside = (p - foot) - ((p - foot) * g).sum(1)[:, None] / squared[:, None] * g
        foot = foot + beside - (value(foot + beside) / squared)[:, None] * g
    g = gradient(foot)
    return np.linalg.norm(p - foot, axis=1), g / np.linalg.norm(g, axis=1)[:, None]


def of_face(p, face, cells=200, steps=12):
    """Returns the nearest points of one face and its normals there by Newton's method on ½|S(u, v) − p|² within the bounds of (u, v), from the
    nearest point of a grid."""
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, face)
    low, high = np.array([u0, v0]), np.array([u1, v1])
    grid = np.stack(np.meshgrid(*np.linspace(low, high, cells + 1).T, indexing="ij"), -1).reshape(-1, 2)

    def at(uv):
        flat = uv.ravel()
        return (np.asarray(gmsh.model.getValue(2, face, flat)).reshape(-1, 3),
                np.asarray(gmsh.model.getDerivative(2, face, flat)).reshape(-1, 2, 3),
                np.asarray(gmsh.model.getSecondDerivative(2, face, flat)).reshape(-1, 3, 3))

    uv = grid[scipy.spatial.cKDTree(np.asarray(gmsh.model.getValue(2, face, grid.ravel())).reshape(-1, 3)).query(p)[1]]
    for _ in range(steps):
        point, first, second = at(uv)
        off = point - p
        bend = np.einsum("nd,nkd->nk", off, second)  # uu, vv, uv
        hessian = np.einsum("nid,njd->nij", first, first)
        bent = hessian + np.stack([bend[:, 0], bend[:, 2], bend[:, 2], bend[:, 1]], 1).reshape(-1, 2, 2)
        safe = np.linalg.det(bent) > 0.1 * np.linalg.det(hessian)
        hessian[safe] = bent[safe]
        slope = np.einsum("nid,nd->ni", first, off)
        uv = np.clip(uv - np.linalg.solve(hessian, slope[..., None])[..., 0], low, high)
    point, first, _ = at(uv)
    normal = np.cross(first[:, 0], first[:, 1])
    return np.linalg.norm(point - p, axis=1), normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]


def of_model(p):
    """Returns the nearest of all faces of Gmsh's model, which has no trimmed faces."""
    best, normals = np.full(len(p), np.inf), np.zeros_like(p)
    for _, face in gmsh.model.getEntities(2):
        distance, normal = of_face(p, face)
        nearer = distance < best
        best[nearer], normals[nearer] = distance[nearer], normal[nearer]
    return best, normals


def of_wing(p):
    """Omits the last fiftieth of the chord: near a sharp edge the nearest side may be the other one."""
    distance, normal = of_model(p)
    behind = p[:, 0] > 0.98
    distance[behind], normal[behind] = 0, np.nan
    return distance, normal


BODIES = {  # function that makes it, exact surface, sizes (naca: points on a circle)
    "torus": (torus, of_torus, (0.4, 0.2, 0.1, 0.05)),
    "bump": (bump, of_bump, (0.4, 0.2, 0.1, 0.05)),
    "cylinder": (cylinder, of_lathe(1, 0), (0.5, 0.25, 0.125, 0.0625)),
    "cone": (cone, of_lathe(1, -0.4), (0.4, 0.2, 0.1, 0.05)),
    "naca": (naca, of_wing, (12, 24, 48, 96)),
    "patch": (patch, of_model, (0.16, 0.08, 0.04, 0.02)),
}


def mesh_body(body, size, path):
    """Makes the straight mesh and the model of a body, and returns the mean edge length."""
    maker, _, _ = BODIES[body]
    gmsh.model.remove()
    maker()
    gmsh.model.occ.remove(gmsh.model.occ.getEntities(0))
    gmsh.model.occ.synchronize()
    most = 1.2 / size if body == "naca" else size
    for option, value in (("MeshSizeFromCurvature", 0), ("MeshSizeMax", most), ("MeshSizeMin", 0 if body == "naca" else size),
                          ("Algorithm", 5)):
        gmsh.option.setNumber(f"Mesh.{option}", value)
    if body == "naca":  # as the radius of curvature grows, which is 0.0158 at the nose
        gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z: min(most, 2 * math.pi / size * (0.0158 + x)))
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.removeSizeCallback()
    gmsh.write(str(path.with_suffix(".brep")))
    _, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(gmsh.model.mesh.getNodes()[0])
    points = np.asarray(coordinates).reshape(-1, 3)[order]
    tags = np.sort(gmsh.model.mesh.getNodes()[0])
    triangles = np.concatenate([gmsh.model.mesh.getElements(2, face)[2][0] for _, face in gmsh.model.getEntities(2)])
    triangles = np.searchsorted(tags, triangles).reshape(-1, 3)
    if body == "naca":  # each side has its own trailing edge
        _, first_rows, number = np.unique(np.round(points, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
        points, triangles = points[first_rows], number[triangles]
    if body == "bump":
        points *= bump_radius(points)[:, None]
    references = np.ones(len(triangles), int)
    meshio.write(str(path), meshio.Mesh(points, [("triangle", triangles)], cell_data={"medit:ref": [references]}))
    sides = points[triangles] - points[np.roll(triangles, 1, 1)]
    return float(np.linalg.norm(sides, axis=2).mean()), len(triangles)


# ---------------------------------------------------------------- evaluation

def chosen(count):
    return np.sort(np.random.default_rng(1).permutation(count)[:MOST_TRIANGLES])


def angle(a, b):
    """Returns the angle between lines in radians, or 0 if one is not evaluated."""
    return np.nan_to_num(np.arcsin(np.minimum(1, np.linalg.norm(np.cross(a, b), axis=1))))


def judged_surrogate(body, path):
    """Evaluates the cubic triangles written by `camber geometry --surface`."""
    grid = meshio.read(path)
    cells, facets = grid.cells[0].data, np.asarray(grid.cell_data["facet"][0])
    cells = cells[np.isin(facets, chosen(int(facets.max())) + 1)]
    used = np.bincount(cells.ravel(), minlength=len(grid.points))
    inside, edges = used == 6, (used > 0) & (used < 6)
    distance, normal = BODIES[body][1](grid.points[used > 0])
    off = angle(normal, np.asarray(grid.point_data["normal"], float)[used > 0])
    return {"edges": distance[edges[used > 0]].max(), "inside": distance[inside[used > 0]].max(), "normal": off.max()}


def judged_boundary(body, path):
    """Evaluates a boundary of degree 2."""
    mesh = meshio.read(path)
    cells = mesh.cells_dict["triangle6"]
    cells = cells[chosen(len(cells))]
    nodes, _ = BODIES[body][1](mesh.points[np.unique(cells[:, 3:])])
    corners = mesh.points[cells[:, :3]]
    longest = np.linalg.norm(corners - np.roll(corners, 1, 1), axis=2).max(1)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    worst, squares, turned = np.zeros(len(cells)), np.zeros(len(cells)), 0
    for i in range(7):
        for j in range(7 - i):
            v, w = i / 6, j / 6
            u = 1 - v - w
            shapes = np.array([u * (2 * u - 1), v * (2 * v - 1), w * (2 * w - 1), 4 * u * v, 4 * v * w, 4 * w * u])
            by_v = np.array([1 - 4 * u, 4 * v - 1, 0, 4 * (u - v), 4 * w, -4 * w])
            by_w = np.array([1 - 4 * u, 0, 4 * w - 1, -4 * v, 4 * v, 4 * (u - w)])
            at = mesh.points[cells]
            point, a, b = (np.einsum("k,fkd->fd", s, at) for s in (shapes, by_v, by_w))
            normal = np.cross(a, b)
            distance, true = BODIES[body][1](point)
            worst, squares = np.maximum(worst, distance), squares + distance ** 2 / 28
            turned = max(turned, angle(true, normal / np.linalg.norm(normal, axis=1)[:, None]).max())
    return {"nodes": nodes.max(), "boundary": worst.max(), "rms": math.sqrt((squares * area).sum() / area.sum()),
            "per_cube": (worst / longest ** 3).max(), "normal": turned}


def measured(body, folder, camber):
    """Returns one row per size."""
    quiet()
    rows = []
    for size in BODIES[body][2]:
        path = folder / f"{body}-{size:g}.mesh"
        edge, triangles = mesh_body(body, size, path)

        def run(*arguments):
            subprocess.run([camber, *map(str, arguments)], check=True, capture_output=True)
        smooth, own, cad = (path.with_name(f"{path.stem}-{kind}") for kind in ("smooth.vtu", "own.msh", "cad.msh"))
        run("geometry", path, "--surface", smooth)
        run("curve", path, "-o", own)
        row = {"edge": edge, "triangles": triangles, "surrogate": judged_surrogate(body, smooth), "own": judged_boundary(body, own)}
        if body != "bump":
            run("curve", path, "-o", cad, "--cad", path.with_suffix(".brep"))
            row["cad"] = judged_boundary(body, cad)
        rows.append(row)
    gmsh.finalize()
    return rows


COLUMNS = (("surrogate", "edges"), ("surrogate", "inside"), ("surrogate", "normal"), ("own", "nodes"), ("own", "boundary"),
           ("own", "rms"), ("own", "normal"), ("cad", "nodes"), ("cad", "boundary"), ("cad", "rms"), ("cad", "normal"))


def cell(rows, part, value):
    """Returns the value of the finest mesh, and the order from the mesh with four times its size unless the value is rounding."""
    if part not in rows[0]:
        return "–"
    fine, coarse = rows[-1][part][value], rows[-3][part][value]
    if fine < 1e-9:
        return f"{fine:.0e}"
    return f"{fine:.1e}, {math.log(coarse / fine) / math.log(rows[-3]['edge'] / rows[-1]['edge']):.1f}"


def table(found):
    titles = ["body", "triangles", *(f"{part} {value}" for part, value in COLUMNS)]
    yield "| " + " | ".join(titles) + " |"
    yield "|" + "---|" * len(titles)
    for body, rows in found.items():
        yield "| " + " | ".join([body, f"{rows[0]['triangles']} to {rows[-1]['triangles']}",
                                 *(cell(rows, *column) for column in COLUMNS)]) + " |"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("bodies", nargs="*", default=list(BODIES), help=f"of {', '.join(BODIES)}")
    parser.add_argument("--camber", required=True)
    arguments = parser.parse_intermixed_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    found = {}
    for body in arguments.bodies or BODIES:
        with multiprocessing.Pool(1) as alone:
            found[body] = alone.apply(measured, (body, arguments.folder, arguments.camber))
    (arguments.folder / "orders.json").write_text(json.dumps(found, indent=1), encoding="utf-8")
    print("\n".join(table(found)))
