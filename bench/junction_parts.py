"""Straight meshes of CAD parts whose thin layers meet curved walls, with their models made by Gmsh (for bench/junctions.py)."""
import functools
import os
import sys

import gmsh
import numpy as np

from junction_meshes import BOWL, ORIGIN, X, Y, Z, bowl, build, cylinder, grid, heights, on_cylinder, plane, ring, sphere


def in_gmsh(function):
    """The function within a session of Gmsh. Messages of Gmsh and of OpenCASCADE on standard output are dropped."""
    @functools.wraps(function)
    def call(*values):
        sys.stdout.flush()
        output, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        gmsh.initialize([], False)
        try:
            return function(*values)
        finally:
            gmsh.finalize()
            os.dup2(output, 1)
            os.close(output)
            os.close(nowhere)
    return call


@in_gmsh
def write_step(make, path):
    """Writes the model that the function makes, as STEP."""
    make()
    gmsh.model.occ.synchronize()
    gmsh.write(str(path))
    return path


@in_gmsh
def irregular(*counts):
    """A block over irregular triangles, extruded into layers and cut into tetrahedra by Gmsh: vertex indices and tetrahedra."""
    square = gmsh.model.occ.addRectangle(0, 0, 0, counts[0], counts[1])
    gmsh.model.occ.extrude([(2, square)], 0, 0, counts[2], numElements=[counts[2]])
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.9)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 1.1)
    gmsh.model.mesh.generate(3)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    _, cells = gmsh.model.mesh.getElementsByType(4)
    used, cells = np.unique(cells, return_inverse=True)
    where = np.argsort(tags)[np.searchsorted(np.sort(tags), used)]
    return np.round(coordinates.reshape(-1, 3)[where], 9), cells.reshape(-1, 4)


def cut(body, *tools):
    """The body without the tools, all volumes."""
    return gmsh.model.occ.cut([(3, body)], [(3, tool) for tool in tools])[0][0][1]


def prism(curves, length):
    """The volume of a section in the plane z = 0, extruded along z."""
    occ = gmsh.model.occ
    face = occ.addPlaneSurface([occ.addCurveLoop(curves)])
    return next(tag for dimension, tag in occ.extrude([(2, face)], 0, 0, length) if dimension == 3)


# ---------------------------------------------------------------- wings on a fuselage: the span is z, the fuselage has the axis x

FUSELAGE, TIP = 0.5, 1.5  # radius; end of the mesh along the span


def between(section, outline):
    """The space around the wing, within the outline, from the fuselage to the tip plane. Both functions make curves."""
    whole = prism(outline(), TIP)
    cut(whole, prism(section(), TIP), gmsh.model.occ.addCylinder(-9, 0, 0, 18, 0, 0, FUSELAGE))


def around_wing(section, span, cells, cad, analytic=()):
    """The mesh of the space around a wing: points (x, y) of `section` by i and k, and shares of the span from 0 to 1."""
    def place(i, j, k):
        x, y = section[:, i, k]
        root = np.sqrt(FUSELAGE ** 2 - y * y)
        return x, y, root + span[j] * (TIP - root)
    surfaces = {3: cylinder(ORIGIN, X, FUSELAGE), 4: plane((0, 0, TIP), Z)}
    return build(ring(*grid(*cells)), place, surfaces, analytic=analytic, cad=cad)


def ellipse(a, b, x=0.0):
    return lambda: [gmsh.model.occ.addEllipse(x, 0, 0, a, b)]


def elliptic_wing(first, around=32, along=8, count=10, analytic=()):
    """Layers on an elliptic cylinder that end on the fuselage, up to a larger ellipse."""
    levels = heights(first, first * (1.7 ** count - 1) / 0.7 * (1 - 1e-9))
    turn = 2 * np.pi * np.arange(around + 1) / around
    turn = (turn - 0.25 * np.sin(2 * turn))[:, None]
    section = np.stack([(0.5 + levels) * np.cos(turn), (0.1 + levels) * np.sin(turn)])
    return around_wing(section, np.linspace(0, 1, along + 1), (around, along, count),
                       lambda: between(ellipse(0.5, 0.1), ellipse(0.5 + levels[-1], 0.1 + levels[-1])), analytic)


def naca_curves(count=40):
    """The section NACA 0012 as two splines, counterclockwise from the trailing edge."""
    x = 0.5 * (1 + np.cos(np.pi * np.arange(count + 1) / count))
    half = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x ** 2 + 0.2843 * x ** 3 - 0.1036 * x ** 4)
    half[[0, -1]] = 0
    add = gmsh.model.occ.addPoint
    upper = [add(a, b, 0) for a, b in zip(x, half)]
    lower = [add(a, -b, 0) for a, b in zip(x[-2:0:-1], half[-2:0:-1])]
    curves = [gmsh.model.occ.addBSpline(upper), gmsh.model.occ.addBSpline([upper[-1], *lower, upper[0]])]
    gmsh.model.occ.remove([(0, point) for point in upper[1:-1] + lower])
    return curves


@in_gmsh
def naca_points(around):
    """Points of the section on its splines, denser at the nose, and outward unit normals, counterclockwise from the tail."""
    curves = naca_curves()
    gmsh.model.occ.synchronize()
    from_nose = np.arange(around // 2 + 1) / (around // 2)
    from_nose *= 0.4 + 0.6 * from_nose
    points, normals = [], []
    for curve, at in zip(curves, (1 - from_nose[:0:-1], from_nose[:-1])):
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, curve)
        at = low + (high - low) * at
        points.append(np.reshape(gmsh.model.getValue(1, curve, at), (-1, 3))[:, :2])
        slopes = np.reshape(gmsh.model.getDerivative(1, curve, at), (-1, 3))
        normals.append(np.column_stack([slopes[:, 1], -slopes[:, 0]]) / np.linalg.norm(slopes, axis=1)[:, None])
    points, normals = np.concatenate(points), np.concatenate(normals)
    normals[[0, around // 2]] = [(1, 0), (-1, 0)]
    return points, normals


def naca_wing(first, around=32, count=12, beyond=3, growth=1.45):
    """Layers on a wing NACA 0012 and on the fuselage, up to an ellipse around the wing."""
    levels = first * (growth ** np.arange(count + 1) - 1) / (growth - 1)
    points, normals = naca_points(around)
    near = points[:, None] + levels[:, None] * normals[:, None]
    turn = 2 * np.pi * np.arange(around) / around
    far = np.stack([0.5 + 0.9 * np.cos(turn), 0.4 * np.sin(turn)], axis=1)[:, None]
    share = np.linspace(0, 1, beyond + 1)[1:, None]
    section = np.concatenate([near, near[:, -1:] + share * (far - near[:, -1:])], axis=1)
    section = np.concatenate([section, section[:1]]).transpose(2, 0, 1)
    step = levels / (TIP - FUSELAGE)
    span = np.concatenate([step, step[-1] + np.linspace(0, 1, beyond + 2)[1:] * (1 - step[-1])])
    return around_wing(section, span, (around, len(span) - 1, count + beyond), lambda: between(naca_curves, ellipse(0.9, 0.4, 0.5)))


# ---------------------------------------------------------------- a pipe, a plate with a hole, a crease

def pipe(first, total=0.1, around=40, along=4):
    """Layers on a whole cylinder that end on a sphere."""
    levels = heights(first, total)

    def place(i, j, k):
        angle, radius = 2 * np.pi * i / around, 1 + levels[k]
        x, y = radius * np.cos(angle), radius * np.sin(angle)
        return x, y, j / along * BOWL.height(x, y)

    def model():
        occ = gmsh.model.occ
        tube = occ.addCylinder(0, 0, 0, 0, 0, 2, 1 + levels[-1])
        cut(tube, occ.addCylinder(0, 0, -1, 0, 0, 4, 1), occ.addSphere(*BOWL.surface.parameters["centre"], 3))
    surfaces = {1: cylinder(ORIGIN, Z, 1), 2: cylinder(ORIGIN, Z, 1 + levels[-1]), 3: plane(ORIGIN, Z), 4: BOWL.surface}
    return build(ring(*grid(around, along, len(levels) - 1)), place, surfaces, analytic=(), cad=model)


def hole(first, total=0.1, around=32, along=4, beyond=3):
    """Layers on the wall of a hole in a plate with a cylindrical top: the plane and the top are trimmed faces."""
    levels = heights(first, total)

    def place(i, j, k):
        direction = np.array([np.cos(2 * np.pi * i / around), np.sin(2 * np.pi * i / around)])
        radius = 0.5 + levels[np.minimum(k, len(levels) - 1)]
        share = np.maximum(k - len(levels) + 1, 0) / beyond
        x, y = direction * ((1 - share) * radius + share / np.abs(direction).max(axis=0))
        return x, y, j / along * (np.sqrt(4 - y * y) - 1.5)

    def model():
        occ = gmsh.model.occ
        plate, _ = occ.intersect([(3, occ.addBox(-1, -1, 0, 2, 2, 1))], [(3, occ.addCylinder(-2, 0, -1.5, 4, 0, 0, 2))])
        cut(plate[0][1], occ.addCylinder(0, 0, -1, 0, 0, 3, 0.5))
    surfaces = {1: cylinder(ORIGIN, Z, 0.5), 3: plane(ORIGIN, Z), 4: cylinder((0, 0, -1.5), X, 2)}
    return build(ring(*grid(around, along, len(levels) - 1 + beyond)), place, surfaces, analytic=(), cad=model)


def crease(first, total=0.1, across=8, along=4, cad=False):
    """Layers on two cylinders that meet at an angle and have one reference, from a plane to a sphere.

    Without `cad` the program makes the geometry from the mesh.
    """
    levels, last = heights(first, total), bowl((0, 0, 3.2), 3)

    def place(i, j, k):
        x = 0.4 * i / across - 0.2
        z = np.sqrt(1 - (np.abs(x) + 0.6) ** 2) + levels[k]
        return x, j / along * last.height(x, z), z

    def roof(height):
        occ = gmsh.model.occ
        return occ.intersect([(3, occ.addCylinder(-0.6, -1, height, 0, 3, 0, 1))],
                             [(3, occ.addCylinder(0.6, -1, height, 0, 3, 0, 1))])[0][0][1]

    def model():
        occ = gmsh.model.occ
        body = cut(roof(levels[-1]), roof(0), occ.addSphere(0, 3.2, 0, 3))
        occ.intersect([(3, body)], [(3, occ.addBox(-0.2, 0, 0.3, 0.4, 1, 2))])
    surfaces = {3: plane(ORIGIN, Y), 4: sphere((0, 3.2, 0), 3), 5: plane((-0.2, 0, 0), X), 6: plane((0.2, 0, 0), X)}
    return build(grid(across, along, len(levels) - 1), place, surfaces if cad else {}, analytic=(), cad=model if cad else None)


CASES = {
    "layers 5e-4, sphere end, irregular triangles extruded by Gmsh": (lambda: on_cylinder(5e-4, block=irregular),),
    "elliptic wing on a fuselage, 10 layers from 5e-4, CAD": (elliptic_wing, 5e-4),
    "elliptic wing on an analytic fuselage, 10 layers from 5e-4, CAD": (lambda: elliptic_wing(5e-4, analytic=(3,)),),
    "wing NACA 0012 on a fuselage, 12 layers from 5e-4 on both, CAD": (naca_wing, 5e-4),
    "pipe, layers 1e-3, sphere end, CAD": (pipe, 1e-3),
    "hole in a plate, layers 1e-3 on its wall, CAD": (hole, 1e-3),
    "crease within a reference, layers 1e-3, sphere end, geometry of the mesh": (crease, 1e-3),
    "crease within a reference, layers 1e-3, sphere end, CAD": (lambda: crease(1e-3, cad=True),),
}
