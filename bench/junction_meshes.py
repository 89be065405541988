"""Straight meshes whose thin layers meet curved walls, with the exact surfaces of the walls (for bench/junctions.py)."""
import json
from dataclasses import dataclass, field

import numpy as np

X, Y, Z, ORIGIN = np.array([1, 0, 0]), np.array([0, 1, 0]), np.array([0, 0, 1]), np.zeros(3)
SIDES = ((5, 6), (3, 4), (1, 2))  # references of the first and the last side along i, j and k; in 2D along i and k: the last two
PART, SHEET = 8, 9  # references of the second part of an end wall, and of a sheet within the volume


# ---------------------------------------------------------------- surfaces

@dataclass(frozen=True)
class Surface:
    """An analytic surface (in 2D a curve): its kind and its parameters, with the names that `--geometry` has."""
    kind: str
    parameters: dict

    def distance(self, points):
        """Signed distances of points."""
        p = {key: np.asarray(value, float) for key, value in self.parameters.items()}
        d = points - p.get("point", p.get("centre"))
        if self.kind == "plane":
            return d @ p["normal"] / np.linalg.norm(p["normal"])
        if self.kind == "sphere":
            return np.linalg.norm(d, axis=1) - p["radius"]
        axis = p["axis"] / np.linalg.norm(p["axis"])
        along = d @ axis
        across = np.linalg.norm(d - along[:, None] * axis, axis=1)
        if self.kind == "cylinder":
            return across - p["radius"]
        return np.hypot(across - p["major_radius"], along) - p["minor_radius"]


def plane(point, normal):
    return Surface("plane", {"point": list(point), "normal": list(normal)})


def sphere(centre, radius):
    return Surface("sphere", {"centre": list(centre), "radius": radius})


def cylinder(point, axis, radius):
    return Surface("cylinder", {"point": list(point), "axis": list(axis), "radius": radius})


def torus(centre, axis, major, minor):
    return Surface("torus", {"centre": list(centre), "axis": list(axis), "major_radius": major, "minor_radius": minor})


# ---------------------------------------------------------------- meshes

@dataclass
class Mesh:
    """A straight mesh. `surfaces` are the exact surfaces by reference.

    The program gets those that are not planes, or those of the references `analytic`.
    """
    points: np.ndarray
    cells: np.ndarray
    facets: np.ndarray
    references: np.ndarray
    surfaces: dict = field(default_factory=dict)
    analytic: tuple = None
    cad: object = None  # function that makes the CAD model in Gmsh's OpenCASCADE kernel
    noise: float = 0.0  # largest shift of a coordinate of a vertex from its exact position

    def geometry(self):
        """The value of `--geometry`; empty if the program gets no surface."""
        curved = [{"references": [int(r)], s.kind: {k: np.asarray(v, float).tolist() for k, v in s.parameters.items()}}
                  for r, s in self.surfaces.items()
                  if self.analytic is None or r in self.analytic]
        return json.dumps({"analytic": curved}, separators=(",", ":")) if curved else ""

    def write(self, path):
        """Writes the mesh in GMF (ASCII)."""
        names = {2: "Edges", 3: "Triangles", 4: "Tetrahedra"}
        with open(path, "w", encoding="ascii") as file:
            file.write(f"MeshVersionFormatted 2\nDimension {self.points.shape[1]}\nVertices\n{len(self.points)}\n")
            file.writelines(" ".join(map(repr, row)) + " 0\n" for row in self.points.tolist())
            for rows, references in ((self.cells, np.ones(len(self.cells), int)), (self.facets, self.references)):
                file.write(f"{names[rows.shape[1]]}\n{len(rows)}\n")
                np.savetxt(file, np.column_stack([rows + 1, references]), "%d")
            file.write("End\n")

    def check(self, tolerance):
        """Raises an error unless the mesh conforms without overlaps and vertices are on their surfaces."""
        sides = np.sort(np.concatenate([np.delete(self.cells, corner, 1) for corner in range(self.cells.shape[1])]), axis=1)
        simplices = self.points[np.hstack([sides, self.cells.T.reshape(-1, 1)])]
        sign = np.sign(np.linalg.det(simplices[:, 1:] - simplices[:, :1]))
        _, face, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
        if count.max() > 2 or (sign == 0).any() or np.bincount(face.reshape(-1), sign)[count == 2].any():
            raise ValueError("elements are degenerate, overlap, or do not conform")
        if len(np.unique(np.sort(self.facets, axis=1), axis=0)) < (count == 1).sum():
            raise ValueError("the boundary is not complete")
        for reference, surface in self.surfaces.items():
            off = surface.distance(self.points[np.unique(self.facets[self.references == reference])])
            if len(off) == 0 or np.abs(off).max() > tolerance:
                raise ValueError(f"vertices of reference {reference} are off their surface")


def faces_of(cells):
    """The sides of simplices with sorted vertices, each once, and the number of simplices that have it."""
    sides = np.concatenate([np.delete(cells, corner, 1) for corner in range(cells.shape[1])])
    return np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)


def extrude(simplices, levels, count):
    """Prisms over simplices, cut by vertex numbers. Vertex v of the base has the number v + count * k on level k."""
    base = np.sort(simplices, axis=1)
    cut = np.concatenate([np.hstack([base[:, :m + 1], base[:, m:] + count]) for m in range(base.shape[1])])
    return np.concatenate([cut + count * level for level in range(levels)])


def grid(*counts):
    """Vertex indices and simplices of a block with these numbers of cells."""
    cells, number = np.array([[0]]), 1
    for count in counts:
        cells, number = extrude(cells, count, number), number * (count + 1)
    indices = np.indices([count + 1 for count in counts[::-1]])[::-1]
    return indices.reshape(len(counts), -1).T, cells


def grid_in_fives(*counts):
    """A block of which each cell is cut into five tetrahedra. Diagonals of opposite sides of a cell cross."""
    indices, _ = grid(*counts)
    number = {tuple(index): v for v, index in enumerate(indices)}
    cells = []
    for cell in np.ndindex(*counts):
        corner = {c: number[tuple(np.add(cell, c))] for c in np.ndindex(2, 2, 2)}
        odd = [c for c in corner if (sum(c) + sum(cell)) % 2]
        cells.append([corner[c] for c in odd])
        for tip in (c for c in corner if c not in odd):
            cells.append([corner[tip], *(corner[c] for c in odd if np.abs(np.subtract(c, tip)).sum() == 1)])
    return indices, np.array(cells)


def ring(indices, cells, pole=False):
    """The block with its two sides of i joined. With `pole`, its side k = 0 is collapsed to a line."""
    positions, last = indices.copy(), indices[:, 0].max()
    positions[:, 0] %= last
    positions[pole & (indices[:, -1] == 0), 0] = 0
    vertices, number = np.unique(positions, axis=0, return_inverse=True)
    cells = number.reshape(-1)[cells]
    corners = np.sort(cells, axis=1)
    return vertices, cells[(np.diff(corners, axis=1) > 0).all(axis=1)]


def build(block, place, surfaces=None, sheet=0, part=0, **more):
    """Returns the mesh of a block whose vertices are at place(i, j, k), with references of its sides as SIDES has them.

    With `sheet`, facets within the volume on level k = sheet are listed. With `part`, facets of reference 4 above that level
    have another reference.
    """
    indices, cells = block
    points = np.stack(place(*indices.T), axis=1).astype(float)
    corners = points[cells]
    negative = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
    cells[negative, :2] = cells[negative, 1::-1]
    facets, count = faces_of(cells)
    at = indices[facets]
    references = np.zeros(len(facets), int)
    for axis, (first, last) in enumerate(SIDES[-indices.shape[1]:]):
        for reference, level in ((first, 0), (last, indices[:, axis].max())):
            references[(count == 1) & (at[:, :, axis] == level).all(axis=1)] = reference
    if sheet:
        references[(at[:, :, -1] == sheet).all(axis=1)] = SHEET
    if part:
        references[(references == 4) & (at[:, :, -1] >= part).all(axis=1)] = PART
    is_listed = references > 0
    return Mesh(points, cells, facets[is_listed], references[is_listed], surfaces or {}, **more)


def heights(first, total, growth=1.7):
    """Heights of the levels of layers, from 0 until `total` is reached."""
    levels = [0.0]
    while levels[-1] < total:
        levels.append(levels[-1] + first * growth ** (len(levels) - 1))
    return np.array(levels)


# ---------------------------------------------------------------- layers on a cylinder that end on a wall

@dataclass(frozen=True)
class End:
    """An end wall: its height z(x, y), its surface, and the surface of its second part."""
    height: object
    surface: Surface
    second: Surface = None


def bowl(centre, radius):
    """The lower half of a sphere."""
    x, y, z = centre
    return End(lambda a, b: z - np.sqrt(radius ** 2 - (a - x) ** 2 - (b - y) ** 2), sphere(centre, radius))


BOWL = bowl((0, 0, 3.2284271247461903), 3)
STEEP = bowl((1, -0.5, 2.5), 2)
TILTED = End(lambda x, y: 1.5 - x - 0.3 * y, plane((0, 0, 1.5), (1, 0.3, 1)))
CROSSING = End(lambda x, y: 2 - np.sqrt(1.69 - x * x), cylinder((0, 0, 2), Y, 1.3))
TWO_PARTS = End(BOWL.height, BOWL.surface, BOWL.surface)


def fillet(level, radius=0.2):
    """The plane z = 0.4 up to this distance from the axis, then a fillet that rises from it."""
    def height(x, y):
        return 0.4 + radius - np.sqrt(radius ** 2 - np.maximum(np.hypot(x, y) - level, 0) ** 2)
    return End(height, plane((0, 0, 0.4), Z), torus((0, 0, 0.4 + radius), Z, level, radius))


def on_cylinder(first, end=BOWL, total=0.1, both=False, outer=True, part=0, sheet=0, growth=1.7, side=1, cells=(10, 4),
                block=grid):
    """Layers on a quarter of the cylinder of radius 1, from z = 0 to the end wall; with `both` there are layers on that too.

    `outer`: the outer wall has a surface. `side`: -1 for layers inside the cylinder.
    """
    levels = heights(first, total, growth)
    last = heights(first, 0.4)[::-1]
    share = 1 - last / last[0] if both else np.linspace(0, 1, cells[1] + 1)

    def place(i, j, k):
        angle, radius = np.pi / 2 * i / cells[0], 1 + side * levels[k.astype(int)]
        x, y = radius * np.cos(angle), radius * np.sin(angle)
        return x, y, np.interp(j, np.arange(len(share)), share) * end.height(x, y)
    surfaces = {1: cylinder(ORIGIN, Z, 1), 3: plane(ORIGIN, Z), 4: end.surface, 5: plane(ORIGIN, Y), 6: plane(ORIGIN, X)}
    if outer:
        surfaces[2] = cylinder(ORIGIN, Z, 1 + side * levels[-1])
    if end.second:
        surfaces[PART] = end.second
    return build(block(cells[0], len(share) - 1, len(levels) - 1), place, surfaces, sheet, part)


def noisy(mesh, noise):
    """The mesh with each coordinate of each vertex moved by at most `noise`."""
    mesh.points += np.random.default_rng(5).uniform(-noise, noise, mesh.points.shape)
    mesh.noise = noise
    return mesh


def without_surfaces(mesh):
    """The mesh alone: the program makes the geometry from it."""
    mesh.surfaces = {}
    return mesh


def on_fillet(first, part=5):
    return on_cylinder(first, fillet(1 + heights(first, 0.1)[part]), part=part)


def on_circle(first, total=0.1, cells=12):
    """Triangles: layers on the circle of radius 1 that end on another circle."""
    levels, centre, radius = heights(first, total), np.array([-1.0, 1.0]), 1.2

    def place(i, k):
        q, far = 1 + levels[k], np.linalg.norm(centre)
        angle = np.arctan2(centre[1], centre[0]) - np.arccos((q * q + far ** 2 - radius ** 2) / (2 * q * far))
        return q * np.cos(angle * i / cells), q * np.sin(angle * i / cells)
    circles = {1: sphere((0, 0), 1), 2: sphere((0, 0), 1 + levels[-1]), 4: sphere(centre, radius), 3: plane((0, 0), (0, 1))}
    return build(grid(cells, len(levels) - 1), place, circles)


# ---------------------------------------------------------------- panels, shells, pipes

def panel(major, minor, thickness, cells=24, jitter=0.2, block=grid):
    """A patch of a torus (of a sphere if `major` is 0), thickened along its normals, with a distorted grid."""
    shift = np.random.default_rng(1).uniform(-jitter, jitter, (2, cells + 1, cells + 1))
    shift[0, [0, -1]] = shift[1][:, [0, -1]] = 0
    turn, low, high = (1.0, -0.6, 1.8) if major else (np.pi / 3, 0.2, 1.2)

    def place(i, j, k):
        a, b = turn * (i + shift[0, i, j]) / cells, low + (high - low) * (j + shift[1, i, j]) / cells
        radius = minor + thickness * k
        across = major + radius * np.cos(b)
        return across * np.cos(a), across * np.sin(a), radius * np.sin(b)
    wall = (lambda radius: torus(ORIGIN, Z, major, radius)) if major else (lambda radius: sphere(ORIGIN, radius))
    surfaces = {1: wall(minor), 2: wall(minor + thickness), 5: plane(ORIGIN, Y),
                6: plane(ORIGIN, (-np.sin(turn), np.cos(turn), 0))}
    return build(block(cells, cells, 1), place, surfaces)


def shell(anisotropy, cells=4, growth=1.9):
    """The space between spheres of radius 1 and 3, over a subdivided octahedron, with layers on the inner sphere."""
    (a, b), triangles = grid(cells, cells)[0].T, grid(cells, cells)[1]
    b = cells - b
    triangles = triangles[((a + b)[triangles] <= cells).all(axis=1)]
    octants = [np.stack([x * a, y * b, z * (cells - a - b)], axis=1)[triangles].reshape(-1, 3)
               for x in (1, -1) for y in (1, -1) for z in (1, -1)]
    lattice, number = np.unique(np.concatenate(octants), axis=0, return_inverse=True)
    directions = lattice / np.linalg.norm(lattice, axis=1)[:, None]
    levels = heights(np.pi / 2 / cells / anisotropy, 2, growth)
    levels *= 2 / levels[-1]
    level = np.repeat(np.arange(len(levels)), len(lattice))
    cells = extrude(number.reshape(-1, 3), len(levels) - 1, len(lattice))
    return build((level[:, None], cells), lambda k: ((1 + levels[k])[:, None] * np.tile(directions, (len(levels), 1))).T,
                 {1: sphere(ORIGIN, 1), 2: sphere(ORIGIN, 3)})


def elbow(first, bend=1.5, radius=0.5, around=16, along=8):
    """A quarter of a bent pipe with layers on its wall and plane ends."""
    inward = heights(first, 0.5 * radius, 2)
    radii = np.concatenate([[0, 0.25 * radius], radius - inward[::-1]])

    def place(i, j, k):
        turn, angle = np.pi / 2 * j / along, 2 * np.pi * i / around
        across = bend + radii[k] * np.cos(angle)
        return across * np.cos(turn), across * np.sin(turn), radii[k] * np.sin(angle)
    return build(ring(*grid(around, along, len(radii) - 1), pole=True), place,
                 {2: torus(ORIGIN, Z, bend, radius), 3: plane(ORIGIN, Y), 4: plane(ORIGIN, X)})


CASES = {
    **{f"layers {first}, sphere end": (on_cylinder, float(first)) for first in ("1e-2", "1e-3", "2e-4", "5e-5")},
    **{f"layers {first}, growth {growth}, sphere end": (lambda f=first, g=growth: on_cylinder(float(f), growth=g),)
       for first, growth in (("5e-3", 1.2), ("2e-5", 2.4))},
    "layers 5e-5 inside the cylinder, sphere end": (lambda: on_cylinder(5e-5, side=-1),),
    "layers 1e-4, crossing cylinder end": (on_cylinder, 1e-4, CROSSING),
    "layers 5e-5, tilted plane end": (on_cylinder, 5e-5, TILTED),
    "layers 5e-5, sphere end in two references": (lambda: on_cylinder(5e-5, TWO_PARTS, part=1),),
    "layers 5e-5, plane end with tangent fillet": (on_fillet, 5e-5),
    "layers 5e-4 on both walls": (lambda: on_cylinder(5e-4, both=True),),
    "layers 5e-5, steep sphere end off axis": (on_cylinder, 5e-5, STEEP),
    "layers 5e-4, growth 1.6, long cells, sphere end, outer wall without surface":
        (lambda: on_cylinder(5e-4, total=0.0349, outer=False, growth=1.6, cells=(10, 2)),),
    **{f"layers 5e-5, {total:g} thick, outer wall {'with' if outer else 'without'} surface":
       (lambda t=total, o=outer: on_cylinder(5e-5, total=t, outer=o),) for total in (0.02, 0.002) for outer in (True, False)},
    "layers 5e-5, inner sheet without surface": (lambda: on_cylinder(5e-5, sheet=5),),
    "layers 1e-3, sphere end, geometry of the mesh": (lambda: without_surfaces(on_cylinder(1e-3)),),
    **{f"sphere panel, {thickness} thick": (panel, 0, 1, float(thickness)) for thickness in ("1e-2", "3e-4", "1e-4")},
    **{f"torus panel, {thickness} thick": (panel, 2, 0.5, float(thickness)) for thickness in ("3e-3", "3e-5")},
    "sphere panel, 3e-4 thick, geometry of the mesh": (lambda: without_surfaces(panel(0, 1, 3e-4)),),
    "sphere panel, 0.3 thick, 3 x 3 cells": (panel, 0, 1, 0.3, 3),
    "torus panel, 0.3 thick, 3 x 3 cells": (panel, 2, 0.5, 0.3, 3),
    "torus panel, 2e-3 thick, crossing diagonals": (lambda: panel(2, 0.5, 2e-3, block=grid_in_fives),),
    **{f"2D, layers {first} on a circle, circle end": (on_circle, float(first)) for first in ("1e-3", "5e-5")},
    **{f"layers 1e-3, sphere end, vertex noise {noise}": (lambda n=noise: noisy(on_cylinder(1e-3), float(n)),)
       for noise in ("3e-5",)},
    "layers 1e-3, sphere end, vertex noise 2e-4, geometry of the mesh":
        (lambda: without_surfaces(noisy(on_cylinder(1e-3), 2e-4)),),
    "elbow, layers 1e-3": (elbow, 1e-3),
    **{f"shell, anisotropy {anisotropy}": (shell, anisotropy) for anisotropy in (10, 100, 1000, 10000)},
}
