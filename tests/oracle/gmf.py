"""Reader of GMF meshes and fields (.mesh, .meshb, .sol, .solb) for the oracle.

It shares no code with the library.  Format: the table of keywords and node orders in the project's
format notes; ASCII, and binary versions 1 to 4 in both byte orders.  Indices are 0-based once read.
P2 rows come out in one canonical order (Vizir's), as Lagrange nodes, for every order in the file.
"""
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gmf_source import END, SOLUTION, AsciiSource, BinarySource, GmfError

# Barycentric exponents of the nodes of a P2 simplex with k + 1 vertices, in Vizir's default order.
CANONICAL = {
    1: [(2, 0), (0, 2), (1, 1)],
    2: [(2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 1, 0), (0, 1, 1), (1, 0, 1)],
    3: [(2, 0, 0, 0), (0, 2, 0, 0), (0, 0, 2, 0), (0, 0, 0, 2), (1, 1, 0, 0), (0, 1, 1, 0),
        (1, 0, 1, 0), (1, 0, 0, 1), (0, 1, 0, 1), (0, 0, 1, 1)],
}
# Local (end, end, mid node) of every edge of a P2 simplex in that order.
LOCAL_EDGES = {k: [tuple(v for v in range(k + 1) if e[v]) + (n,)
                   for n, e in enumerate(exps) if n > k] for k, exps in CANONICAL.items()}

CELLS = {"Edges": (1, 1), "Triangles": (2, 1), "Tetrahedra": (3, 1),
         "EdgesP2": (1, 2), "TrianglesP2": (2, 2), "TetrahedraP2": (3, 2)}  # name -> (k, degree)
ORDERINGS = {"EdgesP2Ordering": "EdgesP2", "TrianglesP2Ordering": "TrianglesP2",
             "TetrahedraP2Ordering": "TetrahedraP2"}
UNSUPPORTED = {"Quadrilaterals": 5, "Prisms": 7, "Hexahedra": 9, "Pyramids": 6}  # integers per row
VALUES = ("Dimension", "BezierBasis")  # a value and no count


def row_pattern(name, dim):
    """One character per column: i an integer, r a real; None if the keyword is unknown."""
    if name in CELLS:
        k, degree = CELLS[name]
        return "i" * (len(CANONICAL[k]) if degree == 2 else k + 1) + "i"
    if name in UNSUPPORTED:
        return "i" * UNSUPPORTED[name]
    return {"Vertices": "r" * dim + "i", "Normals": "r" * dim, "Tangents": "r" * dim,
            "Corners": "i", "Ridges": "i", "RequiredVertices": "i", "RequiredEdges": "i",
            "RequiredTriangles": "i", "RequiredTetrahedra": "i", "NormalAtVertices": "ii", "TangentAtVertices": "ii",
            "VerticesOnGeometricVertices": "ii", "VerticesOnGeometricEdges": "iirr",
            "VerticesOnGeometricTriangles": "iirrr", "EdgesP2Ordering": "i",
            "TrianglesP2Ordering": "iii", "TetrahedraP2Ordering": "iiii"}.get(name)


@dataclass
class Cells:
    """Simplices of one keyword: node indices (0-based, canonical order) and references."""
    nodes: np.ndarray
    refs: np.ndarray


@dataclass
class Gmf:
    """Content of a file."""
    version: int
    dim: int = 0
    bezier: bool = False
    points: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    point_refs: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    cells: dict = field(default_factory=dict)       # name -> Cells
    lists: dict = field(default_factory=dict)       # name -> (integers, reals), integers as stored
    fields: list = field(default_factory=list)      # (type, values) of SolAtVertices
    skipped: list = field(default_factory=list)     # unknown keywords


def field_width(kind, dim):
    """Numbers of a field type: 1 scalar, 2 vector, 3 symmetric tensor, 4 full tensor."""
    return {1: 1, 2: dim, 3: dim * (dim + 1) // 2, 4: dim * dim}[kind]


def read_solution(source, mesh):
    count, = source.integers(1)
    number, = source.integers(1, short=True)
    kinds = source.integers(number, short=True)
    widths = [field_width(kind, mesh.dim) for kind in kinds]
    values = source.rows("r" * sum(widths), count)[1]
    ends = np.cumsum([0] + widths)
    mesh.fields = [(kind, values[:, a:b]) for kind, a, b in zip(kinds, ends, ends[1:])]


def read_block(source, name, mesh):
    """Reads the block of the current keyword into the mesh; skips it if the keyword is unknown."""
    pattern = row_pattern(name, mesh.dim)
    if name in VALUES:
        value, = source.count_and_value(1)
        mesh.dim, mesh.bezier = (value, mesh.bezier) if name == "Dimension" else (mesh.dim, value == 1)
    elif name == SOLUTION:
        read_solution(source, mesh)
    elif pattern is None:
        mesh.skipped.append(name)
        source.skip()
        return
    else:
        count, = source.integers(1)
        if name in UNSUPPORTED and count:
            raise GmfError(f"{count} {name}: simplices only")
        ints, reals = source.rows(pattern, count)
        if name == "Vertices":
            mesh.points, mesh.point_refs = reals, ints[:, 0]
        elif name in CELLS:
            mesh.cells[name] = Cells(ints[:, :-1] - 1, ints[:, -1])
        else:
            mesh.lists[name] = (ints, reals)
    source.close_block(name)


def apply_orderings(mesh):
    """Permutes P2 rows into the canonical order, according to the Ordering blocks of the file."""
    for ordering, name in ORDERINGS.items():
        if ordering not in mesh.lists or name not in mesh.cells:
            continue
        k = CELLS[name][0]
        exponents = mesh.lists.pop(ordering)[0]
        if k == 1:
            exponents = np.column_stack([exponents[:, 0], 2 - exponents[:, 0]])
        rows = [tuple(int(i) for i in row) for row in exponents]
        if sorted(rows) != sorted(CANONICAL[k]):
            raise GmfError(f"{ordering}: not a permutation of the P2 nodes")
        mesh.cells[name].nodes = mesh.cells[name].nodes[:, [rows.index(e) for e in CANONICAL[k]]]


def edge_triples(mesh, names=("EdgesP2", "TrianglesP2", "TetrahedraP2")):
    """All (end, end, mid node) of the P2 cells with sorted ends, one row for each cell and edge."""
    parts = [np.empty((0, 3), np.int64)]
    for name in names:
        if name in mesh.cells:
            local = np.array(LOCAL_EDGES[CELLS[name][0]])
            parts.append(mesh.cells[name].nodes[:, local].reshape(-1, 3))
    triples = np.concatenate(parts)
    triples[:, :2].sort(axis=1)
    return triples


def control_points_to_nodes(mesh):
    """BezierBasis: P^l = (P20 + 2 P11 + P02) / 4, each mid node once."""
    triples = edge_triples(mesh)
    first = np.unique(triples[:, 2], return_index=True)[1]
    a, b, mid = triples[first].T
    mesh.points = mesh.points.copy()
    mesh.points[mid] = (mesh.points[a] + 2 * mesh.points[mid] + mesh.points[b]) / 4


def check_indices(mesh):
    for name, cells in mesh.cells.items():
        if len(cells.nodes) and (cells.nodes.min() < 0 or cells.nodes.max() >= len(mesh.points)):
            raise GmfError(f"{name}: a vertex index is outside 1..{len(mesh.points)}")


def read(path):
    """Reads a mesh or a field; raises GmfError if the file violates the format."""
    data = Path(path).read_bytes()
    binary = data[:4] in (b"\1\0\0\0", b"\0\0\0\1")
    source = BinarySource(data) if binary else AsciiSource(data)
    mesh = Gmf(source.version)
    while (name := source.keyword()) != END:
        if mesh.dim not in (2, 3) and name != "Dimension":
            raise GmfError(f"{name} before a Dimension of 2 or 3")
        read_block(source, name, mesh)
    check_indices(mesh)
    apply_orderings(mesh)
    if mesh.bezier:
        control_points_to_nodes(mesh)
    return mesh
