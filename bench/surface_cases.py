"""Analytic surfaces for bench/surfaces.py: initial triangles and metrics. All lengths are in model units."""
import functools
import subprocess
from pathlib import Path

import numpy as np

import analytic_metrics as metrics


class Case:
    """make(folder) writes the initial mesh and returns its path. `faces` are functions of points (n, 3), the signed distances from the
    faces of the true surface; the mesh gives the face of each reference. `field` is a metric as in analytic_metrics."""

    def __init__(self, make, faces, area, field, runs=1, size=None, chord_error=None):
        self.make, self.faces, self.area, self.field, self.runs = make, faces, area, field, runs
        self.size, self.chord_error = size, chord_error  # options without a file if the size is constant


def constant(x, size):
    return np.broadcast_to(np.eye(3), (len(x), 3, 3)), np.full((len(x), 3), size)


def plane(axis, at):
    return lambda x: x[:, axis] - at


def round_z(radius, x0=0.0, y0=0.0):
    """A cylinder along z."""
    return lambda x: np.hypot(x[:, 0] - x0, x[:, 1] - y0) - radius


# ---------------------------------------------------------------- meshes

def write_mesh(path, points, triangles, references):
    rows = [f"{x:.17g} {y:.17g} {z:.17g} 0" for x, y, z in points]
    cells = [f"{a} {b} {c} {r}" for (a, b, c), r in zip(triangles + 1, references)]
    path.write_text("\n".join(["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(rows)), *rows, "Triangles", str(len(cells)), *cells,
                               "End", ""]))
    return path


def write_stl(path, points, triangles, references):
    """Writes ASCII STL with one solid per reference."""
    lines = []
    for reference in np.unique(references):
        lines.append(f"solid face {reference}")
        for corners in points[triangles[references == reference]]:
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            lines.append("facet normal {} {} {}\nouter loop".format(*(normal / np.linalg.norm(normal))))
            lines += ["vertex {} {} {}".format(*corner) for corner in corners]
            lines.append("endloop\nendfacet")
        lines.append(f"endsolid face {reference}")
    path.write_text("\n".join([*lines, ""]))
    return path


def joined(points, triangles):
    """Merges points at the same position."""
    _, first, number = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    return points[first], number.reshape(-1)[triangles]


def grid(across, along):
    """Returns (across + 1) x (along + 1) points row by row, and two triangles per cell."""
    corner = (np.arange(along)[:, None] * (across + 1) + np.arange(across)).ravel()
    up = across + 1
    return np.concatenate([np.stack([corner, corner + 1, corner + up + 1], 1), np.stack([corner, corner + up + 1, corner + up], 1)])


def sphere(folder):
    """An icosahedron, cut twice into four, on the unit sphere: 320 triangles."""
    t = (1 + 5 ** 0.5) / 2
    points = np.array([[-1, t, 0], [1, t, 0], [-1, -t, 0], [1, -t, 0], [0, -1, t], [0, 1, t], [0, -1, -t], [0, 1, -t], [t, 0, -1], [t, 0, 1],
                       [-t, 0, -1], [-t, 0, 1]])
    triangles = np.array([[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
                          [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]])
    for _ in range(2):
        corners = points[triangles]
        middles = (corners + np.roll(corners, -1, axis=1)) / 2
        a, b, c = corners.transpose(1, 0, 2)
        ab, bc, ca = middles.transpose(1, 0, 2)
        points = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], 1).reshape(-1, 3)
        points, triangles = joined(points, np.arange(len(points)).reshape(-1, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
    return write_mesh(folder / "sphere.mesh", points / np.linalg.norm(points, axis=1)[:, None], triangles, np.ones(len(triangles), int))


MAJOR, MINOR = 1.0, 0.4


def torus(folder):
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 33), np.linspace(0, 2 * np.pi, 17))
    beside = MAJOR + MINOR * np.cos(v.ravel())
    points = np.stack([beside * np.cos(u.ravel()), beside * np.sin(u.ravel()), MINOR * np.sin(v.ravel())], 1)
    points, triangles = joined(points, grid(32, 16))
    return write_mesh(folder / "torus.mesh", points, triangles, np.ones(len(triangles), int))


def off_torus(x):
    return np.hypot(np.hypot(x[:, 0], x[:, 1]) - MAJOR, x[:, 2]) - MINOR


def torus_curvature(x, chord_error=0.002, most=0.3):
    """Returns chords with the given distance from their circle along the principal directions, and their minimum across the surface."""
    r, axial = metrics.around_axis(x)
    radial, around = axial[:, 0], axial[:, 1]
    outward = r - MAJOR
    angle = np.arctan2(x[:, 2], outward)
    normal = np.cos(angle)[:, None] * radial + np.sin(angle)[:, None] * [0, 0, 1]
    over = np.cross(normal, around)
    bend = np.stack([abs(np.cos(angle)) / (MAJOR + MINOR * np.cos(angle)), np.full(len(x), 1 / MINOR)], 1)
    sizes = np.minimum(np.sqrt(8 * chord_error / np.maximum(bend, 1e-12)), most)
    return np.stack([around, over, normal], 1), np.concatenate([sizes, sizes.min(1)[:, None]], 1)


def cube(folder, n=6):
    """Its sides are references 1 to 6."""
    s, t = (a.ravel() for a in np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n))
    points, triangles = [], []
    for axis in range(3):
        for at in (0.0, 1.0):
            side = np.empty((len(s), 3))
            side[:, axis], side[:, (axis + 1) % 3], side[:, (axis + 2) % 3] = at, s, t
            cells = grid(n, n) if at == 1 else grid(n, n)[:, ::-1]
            triangles.append(cells + len(points) * len(s))
            points.append(side)
    references = np.repeat(np.arange(6) + 1, 2 * n * n)
    return write_mesh(folder / "cube.mesh", *joined(np.concatenate(points), np.concatenate(triangles)), references)


RADIUS, HEIGHT, CHORD_ERROR = 0.5, 2.0, 0.002


def cylinder(folder, around=20, along=6):
    """The side is reference 1, the caps are 2 and 3."""
    u, z = np.meshgrid(np.linspace(0, 2 * np.pi, around + 1), np.linspace(0, HEIGHT, along + 1))
    side = np.stack([RADIUS * np.cos(u.ravel()), RADIUS * np.sin(u.ravel()), z.ravel()], 1)
    middles = len(side) + np.arange(2)
    points = np.concatenate([side, [[0, 0, 0], [0, 0, HEIGHT]]])
    rim = np.arange(around)
    top = along * (around + 1) + rim
    triangles = [grid(around, along), np.stack([rim + 1, rim, np.full(around, middles[0])], 1),
                 np.stack([top, top + 1, np.full(around, middles[1])], 1)]
    references = np.repeat([1, 2, 3], [len(t) for t in triangles])
    return write_stl(folder / "cylinder.stl", *joined(points, np.concatenate(triangles)), references)


def cylinder_sizes(x, most=0.1):
    """Returns the size, around the side at most the chord with the given distance from its circle."""
    r, rows = metrics.around_axis(x)
    sizes = np.full((len(x), 3), most)
    on_side = r > RADIUS - 2 * CHORD_ERROR  # or on one of its chords
    sizes[on_side, 1] = min(most, (8 * CHORD_ERROR * RADIUS) ** 0.5)
    return rows, sizes


HOLES = ((0.25, 0.5, 0.5), (0.2, 1.4, 0.5))  # radius, x, y


def part(folder):
    """A plate with two holes, meshed by Gmsh: triangles only, with one physical group per face."""
    script = 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 2, 1, 0.6};\n'
    script += "".join(f"Cylinder({i + 2}) = {{{x}, {y}, -1, 0, 0, 3, {r}}};\n" for i, (r, x, y) in enumerate(HOLES))
    script += "BooleanDifference(9) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };\n"
    script += "".join(f'Physical Surface("face {i}", {i}) = {{{i}}};\n' for i in range(1, 9))
    geo, mesh = Path(folder) / "part.geo", Path(folder) / "part.msh"
    geo.write_text(script + "Mesh.MeshSizeMax = 0.4;\nMesh.MeshSizeFromCurvature = 10;\n")
    subprocess.run(["gmsh", "-v", "1", str(geo), "-2", "-format", "msh41", "-o", str(mesh)], check=True)
    return mesh


CUBE_FACES = [plane(axis, at) for axis in range(3) for at in (0.0, 1.0)]
PART_FACES = [plane(axis, at) for axis, most in enumerate((2.0, 1.0, 0.6)) for at in (0.0, most)] + [round_z(*hole) for hole in HOLES]
PART_AREA = 2 * (2 + 0.6 + 1.2) + sum(2 * np.pi * r * 0.6 - 2 * np.pi * r * r for r, *_ in HOLES)


def of_size(size):
    return functools.partial(constant, size=size)


CASES = {
    "sphere": Case(sphere, [lambda x: np.linalg.norm(x, axis=1) - 1], 4 * np.pi, of_size(0.1), size=0.1),
    "torus": Case(torus, [off_torus], 4 * np.pi ** 2 * MAJOR * MINOR, torus_curvature, runs=3),
    "cube": Case(cube, CUBE_FACES, 6.0, metrics.linear, runs=5),
    "cylinder": Case(cylinder, [round_z(RADIUS), plane(2, 0.0), plane(2, HEIGHT)], 2 * np.pi * RADIUS * (RADIUS + HEIGHT),
                     cylinder_sizes, size=0.1, chord_error=CHORD_ERROR),
    "part": Case(part, PART_FACES, PART_AREA, of_size(0.1), size=0.1),
}
