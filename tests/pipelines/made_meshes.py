"""Meshes made without the program: lattices of simplices of degree 1 and 2 as ASCII files."""
import itertools

import numpy as np

NAMES = {1: "Edges", 2: "Triangles", 3: "Tetrahedra"}
LOCAL_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))


def edges_of(simplex):
    return [(simplex[a], simplex[b]) for a, b in LOCAL_EDGES[:len(simplex) * (len(simplex) - 1) // 2]]


class Mesh:
    """Points, and rows of vertices (degree 1) or nodes (degree 2), counted from 0. Elements and facets have
    references."""

    def __init__(self, points, elements, facets, degree=1):
        self.points, self.elements, self.facets = np.array(points, float), elements, facets
        self.dim, self.degree = self.points.shape[1], degree
        self.element_references, self.facet_references = [1] * len(elements), [1] * len(facets)

    def text(self):
        lines = ["MeshVersionFormatted 2", f"Dimension {self.dim}", f"Vertices {len(self.points)}"]
        lines += [" ".join(repr(float(x)) for x in p) + " 0" for p in self.points]
        for k, rows, references in ((self.dim, self.elements, self.element_references),
                                    (self.dim - 1, self.facets, self.facet_references)):
            if len(rows):
                lines += [NAMES[k] + ("P2" if self.degree == 2 else "") + f" {len(rows)}"]
                lines += [" ".join(str(int(v) + 1) for v in row) + f" {r}" for row, r in zip(rows, references)]
        return "\n".join(lines + ["End", ""])


def lattice(dim, n):
    """[0, n]^dim cut into simplices, one for each order of the axes, with its boundary facets."""
    number = {at: i for i, at in enumerate(itertools.product(range(n + 1), repeat=dim))}
    elements = []
    for cell in itertools.product(range(n), repeat=dim):
        for order in itertools.permutations(range(dim)):
            corners = [cell]
            for axis in order:
                corners.append(tuple(c + (i == axis) for i, c in enumerate(corners[-1])))
            vertices = [number[c] for c in corners]
            matrix = np.array([np.subtract(c, corners[0]) for c in corners[1:]], float)
            if np.linalg.det(matrix) < 0:
                vertices[0], vertices[1] = vertices[1], vertices[0]
            elements.append(tuple(vertices))
    return with_boundary(Mesh(list(number), elements, []))


def moved(mesh, by, scale=1.0):
    """A scaled and translated copy."""
    return Mesh(scale * mesh.points + by, list(mesh.elements), list(mesh.facets))


def joined(one, other):
    """Both bodies in one mesh, with references 1 and 2 and without common vertices."""
    number = len(one.points)
    both = Mesh(np.concatenate([one.points, other.points]),
                one.elements + [tuple(v + number for v in e) for e in other.elements],
                one.facets + [tuple(v + number for v in f) for f in other.facets])
    both.element_references = [1] * len(one.elements) + [2] * len(other.elements)
    both.facet_references = [1] * len(one.facets) + [2] * len(other.facets)
    return both


def with_boundary(mesh):
    """The mesh of the elements with its boundary listed."""
    sides = {}
    for element in mesh.elements:
        for face in itertools.combinations(element, mesh.dim):
            sides.setdefault(tuple(sorted(face)), []).append(face)
    return Mesh(mesh.points, mesh.elements, [faces[0] for faces in sides.values() if len(faces) == 1])


def elevated(mesh, random=None, amplitude=0.0):
    """Elevates to degree 2: mid nodes at the edge middles; inner ones are displaced by up to the amplitude."""
    boundary = {tuple(sorted(e)) for facet in mesh.facets for e in edges_of(facet)}
    number, points = {}, list(mesh.points)
    for simplex in itertools.chain(mesh.elements, mesh.facets):
        for edge in edges_of(simplex):
            key = tuple(sorted(edge))
            if key in number:
                continue
            number[key] = len(points)
            node = (mesh.points[key[0]] + mesh.points[key[1]]) / 2
            if random is not None and key not in boundary:
                node = node + random.uniform(-amplitude, amplitude, mesh.dim)
            points.append(node)
    rows = [[tuple(s) + tuple(number[tuple(sorted(e))] for e in edges_of(s)) for s in simplices]
            for simplices in (mesh.elements, mesh.facets)]
    return Mesh(points, *rows, degree=2)


def permuted(mesh, random):
    """The mesh with points and elements in another order, and the old index of each new element."""
    new = random.permutation(len(mesh.points))  # new index of each old point
    order = random.permutation(len(mesh.elements))
    points = np.empty_like(mesh.points)
    points[new] = mesh.points
    other = Mesh(points, [tuple(new[v] for v in mesh.elements[e]) for e in order],
                 [tuple(new[v] for v in facet) for facet in mesh.facets], mesh.degree)
    return other, order


def scattered_square(n):
    """[0, 1]^2 cut into 2 n^2 triangles, with its boundary; vertices, triangles and edges in random order."""
    random = np.random.default_rng(n)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    at = random.permutation((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = at[i, j], at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]
    points = np.empty(((n + 1) ** 2, 2))
    points[at.ravel()] = np.stack(np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n, indexing="ij"), -1).reshape(-1, 2)
    sides = [(row[:-1], row[1:]) for row in (at[:, 0], at[-1], at[::-1, -1], at[0, ::-1])]
    facets = np.concatenate([np.stack(side, 1) for side in sides])
    elements = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Mesh(points, random.permutation(elements), random.permutation(facets))


def without_unused_points(points, elements):
    """The mesh of these elements with its whole boundary and without unused points."""
    used = sorted({v for element in elements for v in element})
    number = {v: i for i, v in enumerate(used)}
    elements = [tuple(number[v] for v in element) for element in elements]
    dim = len(elements[0]) - 1
    sides = {}
    for element in elements:
        for face in itertools.combinations(element, dim):
            sides.setdefault(tuple(sorted(face)), []).append(face)
    return Mesh(points[used], elements, [faces[0] for faces in sides.values() if len(faces) == 1])


def as_ball(points, radii):
    """Maps a cube [-n, n]^dim to a ball: points with largest coordinate k get the radius radii[k]."""
    most, length = np.abs(points).max(axis=1), np.linalg.norm(points, axis=1)
    scale = np.interp(most, range(len(radii)), radii) / np.where(length > 0, length, 1)
    return points * scale[:, None]


def ball_in_shell(dim, n, gap, layers=2):
    """A ball of radius 1 and a shell around it with an empty gap between them; facet references 1 and 2 by body."""
    whole = lattice(dim, 2 * (n + 1 + layers))
    points = whole.points - (n + 1 + layers)
    layer = [np.abs(points[list(e)].mean(axis=0)).max() for e in whole.elements]
    elements_outside_gap = [e for e, at in zip(whole.elements, layer) if not n < at < n + 1]
    radii = [k / n for k in range(n + 1)] + [1 + gap + 0.25 * k for k in range(layers + 1)]
    mesh = without_unused_points(as_ball(points, radii), elements_outside_gap)
    mesh.facet_references = [1 if np.linalg.norm(mesh.points[f[0]]) < 1 + gap / 2 else 2 for f in mesh.facets]
    return mesh


def block_beside_ball(dim, n, share, size=0.1):
    """A ball of radius 1 and a small block in front of the middle of one of its facets. `share` is the distance to the
    facet relative to the height of the sphere over it. Facet references 1 and 2 by body."""
    ball = lattice(dim, 2 * n)
    points = as_ball(ball.points - n, [k / n for k in range(n + 1)])
    facet = max(ball.facets, key=lambda f: np.dot(points[list(f)].mean(axis=0), np.arange(dim, 0, -1)))
    middle = points[list(facet)].mean(axis=0)
    sides = points[list(facet[1:])] - points[facet[0]]
    normal = np.linalg.svd(sides)[2][-1]
    normal *= np.sign(normal @ middle)
    away = np.zeros(dim)
    away[0] = 1
    mirror = away - normal
    block = lattice(dim, 1)
    at = (block.points - np.array([0] + [0.5] * (dim - 1))) * size
    elements = block.elements
    if np.linalg.norm(mirror) > 1e-12:  # a reflection inverts elements: they are reoriented
        at -= 2 * np.outer(at @ mirror, mirror) / (mirror @ mirror)
        elements = [(e[1], e[0], *e[2:]) for e in elements]
    at += middle + share * (1 - normal @ middle) * normal
    number = len(points)
    mesh = Mesh(np.concatenate([points, at]), ball.elements + [tuple(v + number for v in e) for e in elements],
                ball.facets + [tuple(v + number for v in f) for f in block.facets])
    mesh.facet_references = [1] * len(ball.facets) + [2] * len(block.facets)
    return mesh
