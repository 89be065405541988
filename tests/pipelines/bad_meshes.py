"""Files for the cases of bad_input.py: sound meshes and changes of them.

Meshes are written by the oracle's writer, which shares no code with the program.
"""
import json
import struct

import program  # noqa: F401  (puts the oracle on the path)
import numpy as np
from gmf import Cells
from sample_meshes import ascii_file, binary_file, cube, elevate, linear_mesh, solution_file


# ---------------------------------------------------------------- meshes

def block():
    """A cube of 48 tetrahedra, every boundary triangle listed: 27 vertices, 48 triangles."""
    return cube(2)


def square():
    """Two triangles in 2D."""
    return linear_mesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]], [[0, 1], [1, 2], [2, 3], [3, 0]],
                       facet_refs=[1, 2, 3, 4])


def flat_square():
    """The square in a file of dimension 3, as written by programs without a 2D format."""
    mesh = square()
    mesh.dim, mesh.points = 3, np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    return mesh


def elements(mesh):
    return mesh.cells["Tetrahedra" if mesh.dim == 3 else "Triangles"]


def facets(mesh):
    return mesh.cells["Triangles" if mesh.dim == 3 else "Edges"]


def appended(cells, row, ref):
    cells.nodes = np.vstack([cells.nodes, [row]])
    cells.refs = np.append(cells.refs, ref)


def without(cells, keep):
    cells.nodes, cells.refs = cells.nodes[keep], cells.refs[keep]


def with_points(mesh, points):
    mesh.points = np.vstack([mesh.points, points])
    mesh.point_refs = np.append(mesh.point_refs, np.zeros(len(points), np.int64))


def changed(make, change):
    """The ASCII file of a mesh with replaced words."""
    def files():
        mesh = make()
        change(mesh)
        return {"in.mesh": ascii_file(mesh)}
    return files


def text(*edits, make=block):
    """The ASCII file of a mesh with words replaced."""
    def files():
        data = ascii_file(make()).decode()
        for old, new in edits:
            assert old in data, old
            data = data.replace(old, new, 1)
        return {"in.mesh": data.encode()}
    return files


def binary(change, version=2):
    return lambda: {"in.meshb": change(binary_file(block(), version))}


def cut(data, marker, after):
    return data[:data.index(marker) + after]


def keyword_at(data, code):
    """Position of the header of a block in a binary file of version 2."""
    at = 8
    while struct.unpack_from("<i", data, at)[0] != code:
        at = struct.unpack_from("<i", data, at + 4)[0]
    return at


def with_count(data, code, count):
    at = keyword_at(data, code) + 8
    return data[:at] + struct.pack("<i", count) + data[at + 4:]


def small_binary(count):
    """A file of version 4, less than a kilobyte, that announces `count` vertices."""
    out = bytearray(struct.pack("<ii", 1, 4))
    out += struct.pack("<iqi", 3, len(out) + 16, 3)
    body = struct.pack("<q", count) + b"\0" * 512
    out += struct.pack("<iq", 4, len(out) + 12 + len(body)) + body
    return bytes(out + struct.pack("<i", 54))


# ---------------------------------------------------------------- changes

def swapped(rows):
    def change(mesh):
        e = elements(mesh)
        e.nodes[rows] = e.nodes[rows][:, [1, 0, *range(2, mesh.dim + 1)]]
    return change


def centre_out(mesh):
    """Moves the inner vertex beyond the boundary: some elements are inverted."""
    mesh.points[13] = (1.4, 0.5, 0.5)


def onto_face(mesh):
    """Moves the inner vertex onto the boundary: an element has no volume."""
    mesh.points[13] = (0.4, 0.5, 0)


def two_materials(mesh):
    e = elements(mesh)
    e.refs = np.where(mesh.points[e.nodes].mean(axis=1)[:, 0] < 0.5, 1, 2)


def listed_interface(mesh):
    two_materials(mesh)
    inner_face(mesh, 9)


def inner_face(mesh, ref=9):
    """Lists the faces in the plane x = 1/2."""
    faces = np.sort(elements(mesh).nodes[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1)
    for face in np.unique(faces, axis=0):
        if (mesh.points[face][:, 0] == 0.5).all():
            appended(facets(mesh), face, ref)


def cut_open(listed):
    """The cube cut at x = 1/2, with separate vertices on both sides: a slit if the sides are listed."""
    def change(mesh):
        e, f = elements(mesh), facets(mesh)
        if listed:
            inner_face(mesh)
        on = np.flatnonzero(mesh.points[:, 0] == 0.5)
        twin = np.arange(len(mesh.points))
        twin[on] = len(mesh.points) + np.arange(len(on))
        with_points(mesh, mesh.points[on])
        if listed:
            sides = f.nodes[f.refs == 9]
            for row in sides:
                appended(f, twin[row], 10)
        right = mesh.points[e.nodes].mean(axis=1)[:, 0] > 0.5
        e.nodes[right] = twin[e.nodes[right]]
        right = mesh.points[f.nodes].mean(axis=1)[:, 0] > 0.5
        f.nodes[right] = twin[f.nodes[right]]
    return change


def hanging(mesh):
    """A third triangle beside the square with a hanging vertex in the middle of its long side."""
    with_points(mesh, [[2, 0.5], [1, 0.5]])
    appended(elements(mesh), [1, 4, 5], 1)
    appended(elements(mesh), [5, 4, 2], 1)
    f = facets(mesh)
    without(f, f.refs != 2)
    appended(f, [1, 4], 5)
    appended(f, [4, 2], 5)


def hanging_in_space():
    """A tetrahedron with three others on one face, around a vertex that it does not have."""
    mesh = linear_mesh([[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3], [0, 0, -3], [1, 1, 0]],
                       [[0, 1, 2, 3], [0, 5, 1, 4], [1, 5, 2, 4], [2, 5, 0, 4]])
    del mesh.cells["Triangles"]
    return mesh


def pair_at_corner():
    """Two triangles in 2D that share a vertex."""
    return linear_mesh([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]], [[0, 1, 2], [0, 3, 4]],
                       [[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0]])


def pair_at_edge():
    return linear_mesh([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]],
                       [[0, 2, 3, 1], [0, 4, 5, 1]],
                       [[0, 2, 3], [2, 3, 1], [0, 2, 1], [0, 3, 1], [0, 4, 5], [4, 5, 1], [0, 4, 1], [0, 5, 1]])


def pair_at_vertex():
    return linear_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]],
                       [[0, 1, 2, 3], [0, 5, 4, 6]],
                       [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2], [4, 5, 6], [0, 5, 6], [0, 4, 6], [0, 4, 5]])


def nested_bodies():
    """The block and a small block inside its elements."""
    mesh, other = block(), block()
    number = len(mesh.points)
    with_points(mesh, 0.13 + 0.2 * other.points)
    for mine, its in ((elements(mesh), elements(other)), (facets(mesh), facets(other))):
        mine.nodes = np.vstack([mine.nodes, its.nodes + number])
        mine.refs = np.append(mine.refs, its.refs)
    return mesh


def three_on_a_face():
    return linear_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1], [1, 1, 1]],
                       [[0, 1, 2, 3], [0, 2, 1, 4], [0, 1, 2, 5]])


def surface_only():
    mesh = block()
    del mesh.cells["Tetrahedra"]
    f = mesh.cells["Triangles"]
    f.nodes = f.nodes - (f.nodes > 13)
    mesh.points, mesh.point_refs = np.delete(mesh.points, 13, axis=0), mesh.point_refs[1:]
    return mesh


def duplicated_surface():
    """A surface with duplicated vertices along a seam."""
    mesh = surface_only()
    f = mesh.cells["Triangles"]
    right = f.refs == 2
    on = np.unique(f.nodes[right])
    twin = np.arange(len(mesh.points))
    twin[on] = len(mesh.points) + np.arange(len(on))
    f.nodes[right] = twin[f.nodes[right]]
    with_points(mesh, mesh.points[on])
    return mesh


def one_tetrahedron():
    return linear_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]],
                       [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])


def one_triangle():
    return linear_mesh([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], [[0, 1], [1, 2], [2, 0]])


def plain(make):
    return lambda: {"in.mesh": ascii_file(make())}


def quadratic(change=lambda mesh: None, change_nodes=lambda mesh: None):
    def files():
        mesh = block()
        change(mesh)
        mesh = elevate(mesh)
        change_nodes(mesh)
        return {"in.mesh": ascii_file(mesh),
                "p2.json": json.dumps({"input": {"mesh": "in.mesh"}, "stages": ["validate"],
                                       "output": {"mesh": "out.mesh"}}).encode()}
    return files


def mixed_degrees():
    """A quadratic mesh with one element listed as straight."""
    files = quadratic()()
    mesh = elevate(block())
    curved = mesh.cells["TetrahedraP2"]
    mesh.cells["Tetrahedra"] = Cells(curved.nodes[:1, :4], curved.refs[:1])
    without(curved, slice(1, None))
    return files | {"in.mesh": ascii_file(mesh)}


def with_block(name, row):
    return text(("End", f"{name}\n1\n{row}\nEnd"))


# ---------------------------------------------------------------- metrics and configs

IDENTITY = [1.0, 0, 1, 0, 0, 1]


def metric(rows=27, row=IDENTITY, at=None, dim=3, kind=3):
    """The block with a metric of `rows` rows: `row` at all vertices or at one."""
    def files():
        values = np.array([row if at is None or i + 1 == at else IDENTITY for i in range(rows)], float)
        return plain(block)() | {"m.solb": solution_file(values, kind, dim)}
    return files


def flat_metric():
    return plain(flat_square)() | {"m.solb": solution_file(np.array([IDENTITY] * 4, float), 3, 3)}


def metric_text(word):
    rows = "\n".join(["1 0 1 0 0 1"] * 26 + [f"1 0 {word} 0 0 1"])
    return lambda: {"in.mesh": ascii_file(block()),
                    "m.sol": f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n27\n1 3\n{rows}\nEnd\n".encode()}


def config(**change):
    base = {"input": {"mesh": "in.mesh"}, "output": {"mesh": "out.mesh"}}
    return lambda: {"in.mesh": ascii_file(block()), "run.json": json.dumps(base | change).encode()}
