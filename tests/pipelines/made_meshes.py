"""Meshes for tests of the program, made without it: lattices of simplices, of degree 1 and 2, as ASCII files."""
import itertools

import numpy as np

NAMES = {1: "Edges", 2: "Triangles", 3: "Tetrahedra"}
LOCAL_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))


def edges_of(simplex):
    return [(simplex[a], simplex[b]) for a, b in LOCAL_EDGES[:len(simplex) * (len(simplex) - 1) // 2]]


class Mesh:
    """Points, then rows of vertices (degree 1) or nodes (degree 2); all from 0.  `references` are of points, elements
    and facets."""

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
    """[0, n]^dim cut into simplices, one for each order of the axes, with the boundary's facets."""
    number = {at: i for i, at in enumerate(itertools.product(range(n + 1), repeat=dim))}
    elements, sides = [], {}
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
    for element in elements:
        for face in itertools.combinations(element, dim):
            sides.setdefault(tuple(sorted(face)), []).append(face)
    facets = [faces[0] for faces in sides.values() if len(faces) == 1]
    return Mesh(list(number), elements, facets)


def elevated(mesh, random=None, amplitude=0.0):
    """Degree 2: mid nodes at the middles of the edges, those inside moved by up to the amplitude."""
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
    """The same mesh with its points and elements in another order; and old element of each new one."""
    new = random.permutation(len(mesh.points))  # of each old point
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
