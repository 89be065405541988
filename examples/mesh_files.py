"""Quadratic meshes and solutions as files, for solvers in Python: needs numpy alone.

Read are GMF in ASCII (.mesh) and "MFEM mesh v1.0" (.mfem), written is GMF's solution (.sol) with a row for each node in the
order of the mesh file. Nodes of a simplex: its vertices, then those of its edges in the order of EDGES.
"""
import numpy as np

EDGES = {2: [(0, 1), (1, 2), (2, 0)], 3: [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]}
MFEM_EDGES = {2: [(0, 1), (1, 2), (2, 0)], 3: [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]}


class Mesh:
    """Of degree 2. nodes (n, dimension); elements (m, 6 or 10) and facets (b, 3 or 6) of the boundary, with their references."""

    def __init__(self, nodes, elements, element_references, facets, facet_references):
        self.nodes, self.dimension = nodes, nodes.shape[1]
        self.elements, self.element_references = elements, element_references
        self.facets, self.facet_references = facets, facet_references

    def boundary_nodes(self):
        return np.unique(self.facets)


def read_mesh(path):
    with open(path, errors="replace") as file:
        text = file.read()
    if text.startswith("MFEM mesh"):
        return _read_mfem(text)
    if text.lstrip().startswith("MeshVersionFormatted"):
        return _read_gmf(text)
    raise SystemExit(path + ": neither GMF in ASCII (.mesh) nor MFEM (.mfem)")


def _read_gmf(text):
    # A block is a keyword, the number of its rows, and the rows; only Dimension has a value in place of the number.
    blocks, word = {}, None
    for token in text.split():
        if token[0].isalpha():
            word = blocks.setdefault(token, [])
        elif word is not None:
            word.append(token)
    dimension = int(blocks["Dimension"][0])
    if any(name.endswith("P2Ordering") for name in blocks):
        raise SystemExit("an order of nodes other than the default")
    elements, facets = ("TrianglesP2", "EdgesP2") if dimension == 2 else ("TetrahedraP2", "TrianglesP2")
    if elements not in blocks:
        raise SystemExit("the mesh is not of degree 2: no " + elements)

    def rows(name, kind, width):
        return np.array(blocks[name][1:], dtype=kind).reshape(-1, width)

    nodes = rows("Vertices", float, dimension + 1)[:, :dimension]
    cells = rows(elements, int, 7 if dimension == 2 else 11)
    sides = rows(facets, int, 4 if dimension == 2 else 7)
    return Mesh(nodes, cells[:, :-1] - 1, cells[:, -1], sides[:, :-1] - 1, sides[:, -1])


def _read_mfem(text):
    # Rows of elements and boundary: attribute, kind, vertices. Nodes are the vertices, then the edges, numbered as a walk through
    # the elements meets them.
    lines = [line.strip() for line in text.splitlines()]
    dimension = int(lines[lines.index("dimension") + 1])

    def rows(name):
        begin = lines.index(name) + 2
        return np.array([line.split() for line in lines[begin:begin + int(lines[begin - 1])]], dtype=int)

    begin = lines.index("nodes")
    header = lines[begin:begin + 6]
    if f"FiniteElementCollection: H1_{dimension}D_P2" not in header or "Ordering: 1" not in header:
        raise SystemExit("nodes are not H1 of order 2, by nodes")
    nodes = np.array(" ".join(lines[begin + 5:]).split(), dtype=float).reshape(-1, dimension)
    cells, sides = rows("elements"), rows("boundary")
    number, vertices = {}, int(lines[lines.index("vertices") + 1])
    for cell in cells[:, 2:].tolist():
        for a, b in MFEM_EDGES[dimension]:
            number.setdefault(frozenset((cell[a], cell[b])), vertices + len(number))

    def with_edges(simplices, edges):
        return np.array([simplex + [number[frozenset((simplex[a], simplex[b]))] for a, b in edges] for simplex in simplices.tolist()])

    facet_edges = EDGES[2] if dimension == 3 else [(0, 1)]
    return Mesh(nodes, with_edges(cells[:, 2:], EDGES[dimension]), cells[:, 0], with_edges(sides[:, 2:], facet_edges), sides[:, 0])


def write_solution(path, dimension, values):
    """One number (type 1) for each node."""
    with open(path, "w") as file:
        file.write(f"MeshVersionFormatted 2\nDimension {dimension}\nSolAtVertices\n{len(values)}\n1 1\n")
        file.writelines(f"{value:.17g}\n" for value in np.asarray(values).tolist())
        file.write("End\n")


def read_solution(path):
    """A solution that write_solution wrote."""
    with open(path) as file:
        words = file.read().split()
    begin = words.index("SolAtVertices")
    return np.array(words[begin + 4:begin + 4 + int(words[begin + 1])], dtype=float)
