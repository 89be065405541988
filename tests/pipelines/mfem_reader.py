"""Reader of "MFEM mesh v1.0", written from the format definition; it shares no code with the library.

The degrees of freedom of an H1 field of order 2 on simplices are the vertices, then the edges. Edges are numbered as a loop over the
elements meets them, in each element in the order of its local edges: 01 12 20 of a triangle, 01 02 03 12 13 23 of a tetrahedron.
"""
from dataclasses import dataclass

import numpy as np

VERTICES = {1: 2, 2: 3, 4: 4}                      # by geometry: segment, triangle, tetrahedron
EDGES = {1: [(0, 1)], 2: [(0, 1), (1, 2), (2, 0)], 4: [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]}
DIMENSION = {1: 1, 2: 2, 4: 3}
COLLECTIONS = {"H1_2D_P1": 1, "H1_3D_P1": 1, "H1_2D_P2": 2, "H1_3D_P2": 2, "Linear": 1, "Quadratic": 2}


@dataclass
class Simplex:
    attribute: int
    geometry: int
    vertices: list
    corners: np.ndarray         # coordinates
    mid_nodes: dict             # (local vertex, local vertex) -> coordinates of the mid node; empty without nodes of order 2


@dataclass
class Mesh:
    dimension: int
    vertices: int
    elements: list
    boundary: list
    nodes: np.ndarray           # one row per degree of freedom


class Words:
    def __init__(self, text):
        lines = text.split("\n")
        assert lines[0] == "MFEM mesh v1.0", lines[0]
        self.words = [word for line in lines[1:] for word in line.split("#")[0].split()]
        self.at = 0

    def next(self):
        self.at += 1
        return self.words[self.at - 1]

    def expect(self, word):
        found = self.next()
        assert found == word, (found, word)

    def integer(self):
        return int(self.next())

    def reals(self, rows, columns):
        values = [float(self.next()) for _ in range(rows * columns)]
        return np.array(values)

    def at_end(self):
        return self.at == len(self.words)


def read_rows(words, title):
    words.expect(title)
    rows = []
    for _ in range(words.integer()):
        attribute, geometry = words.integer(), words.integer()
        assert attribute > 0, attribute
        rows.append((attribute, geometry, [words.integer() for _ in range(VERTICES[geometry])]))
    return rows


def number_edges(elements):
    numbers = {}
    for _, geometry, vertices in elements:
        for a, b in EDGES[geometry]:
            numbers.setdefault(frozenset((vertices[a], vertices[b])), len(numbers))
    return numbers


def read(path):
    with open(path) as file:
        words = Words(file.read())
    words.expect("dimension")
    dimension = words.integer()
    elements, boundary = read_rows(words, "elements"), read_rows(words, "boundary")
    assert {DIMENSION[g] for _, g, _ in elements} <= {dimension} and {DIMENSION[g] for _, g, _ in boundary} <= {dimension - 1}
    words.expect("vertices")
    count = words.integer()
    edges, order = {}, 1
    word = words.next()
    if word == "nodes":
        words.expect("FiniteElementSpace")
        words.expect("FiniteElementCollection:")
        order = COLLECTIONS[words.next()]
        words.expect("VDim:")
        columns = words.integer()
        words.expect("Ordering:")
        by_node = words.integer() == 1
        if order == 2:
            edges = number_edges(elements)
        values = words.reals(count + len(edges), columns)
        nodes = values.reshape(-1, columns) if by_node else values.reshape(columns, -1).T
    else:
        columns = int(word)
        nodes = words.reals(count, columns).reshape(-1, columns)
    assert words.at_end()

    def simplex(row):
        attribute, geometry, vertices = row
        mids = {}
        if order == 2:
            for a, b in EDGES[geometry]:
                mids[a, b] = nodes[count + edges[frozenset((vertices[a], vertices[b]))]]
        return Simplex(attribute, geometry, vertices, nodes[vertices], mids)
    return Mesh(dimension, count, [simplex(row) for row in elements], [simplex(row) for row in boundary], nodes)
