"""Meshes and files for the oracle's own tests: a tiny GMF writer, midpoint elevation, spheres."""
import numpy as np

from gmf import CANONICAL, CELLS, LOCAL_EDGES, ORDERINGS, Cells, Gmf, row_pattern
from gmf_source import CODES

NUMBER = {name: code for code, name in CODES.items()}


def blocks_of(mesh, orders):
    """(name, pattern, rows) of every block; `orders` maps P2 names to a file's exponents."""
    yield "Vertices", row_pattern("Vertices", mesh.dim), [
        list(map(float, p)) + [int(r)] for p, r in zip(mesh.points, mesh.point_refs)]
    for ordering, name in ORDERINGS.items():
        if name in orders:
            yield ordering, row_pattern(ordering, mesh.dim), [
                list(e[:1]) if name == "EdgesP2" else list(e) for e in orders[name]]
    for name, cells in mesh.cells.items():
        exps = CANONICAL[CELLS[name][0]]
        pick = [exps.index(e) for e in orders.get(name, exps)] if name.endswith("P2") else slice(None)
        yield name, row_pattern(name, mesh.dim), [
            [int(n) + 1 for n in row[pick]] + [int(r)] for row, r in zip(cells.nodes, cells.refs)]
    for name, (ints, reals) in mesh.lists.items():
        yield name, row_pattern(name, mesh.dim), [
            list(map(int, i)) + list(map(float, r)) for i, r in zip(ints, reals)]


def ascii_file(mesh, orders=None):
    lines = ["MeshVersionFormatted 2", "# a comment 1 2 3", f"Dimension {mesh.dim}"]
    if mesh.bezier:
        lines.append("BezierBasis 1")
    for name, _, rows in blocks_of(mesh, orders or {}):
        lines += [name, str(len(rows))] + [" ".join(map(repr, row)) for row in rows]
    return ("\n".join(lines) + "\nEnd\n").encode()


def binary_file(mesh, version, order="<", orders=None, extra=()):
    """`extra`: (code, bytes) blocks of unknown keywords, put first."""
    real = np.dtype(order + ("f4" if version == 1 else "f8"))
    whole = np.dtype(order + ("i8" if version == 4 else "i4"))
    place = np.dtype(order + ("i8" if version >= 3 else "i4"))
    short = np.dtype(order + "i4")
    out = bytearray(np.array([1, version], short).tobytes())

    def block(code, body):
        end = len(out) + 4 + place.itemsize + len(body)
        out.extend(np.array(code, short).tobytes() + np.array(end, place).tobytes() + body)

    block(3, np.array(mesh.dim, short).tobytes())
    for code, body in extra:
        block(code, body)
    if mesh.bezier:
        block(NUMBER["BezierBasis"], np.array(1, whole).tobytes())
    for name, pattern, rows in blocks_of(mesh, orders or {}):
        dtype = np.dtype([(f"c{i}", real if c == "r" else whole) for i, c in enumerate(pattern)])
        table = np.array([tuple(row) for row in rows], dtype)
        block(NUMBER[name], np.array(len(rows), whole).tobytes() + table.tobytes())
    out.extend(np.array([54, 0], short).tobytes())
    return bytes(out)


def solution_file(values, kind, dim, version=2):
    """Binary field of one type (1 scalar, 3 symmetric tensor) at the vertices."""
    whole = "<i8" if version == 4 else "<i4"
    place = "<i8" if version >= 3 else "<i4"
    real = "<f4" if version == 1 else "<f8"
    out = np.array([1, version, 3], "<i4").tobytes()
    out += np.array(len(out) + np.dtype(place).itemsize + 4, place).tobytes()
    out += np.array(dim, "<i4").tobytes()
    body = (np.array(len(values), whole).tobytes() + np.array([1, kind], "<i4").tobytes()
            + np.asarray(values, real).tobytes())
    out += np.array(62, "<i4").tobytes()
    out += np.array(len(out) + np.dtype(place).itemsize + len(body), place).tobytes() + body
    return out + np.array([54], "<i4").tobytes()


def linear_mesh(points, elements, facets=(), refs=None, facet_refs=None):
    """A Gmf value from corner rows (0-based)."""
    points = np.asarray(points, float)
    dim = points.shape[1]
    names = {2: ("Triangles", "Edges"), 3: ("Tetrahedra", "Triangles")}[dim]
    mesh = Gmf(2, dim, points=points, point_refs=np.zeros(len(points), np.int64))
    for name, rows, r in zip(names, (elements, facets), (refs, facet_refs)):
        rows = np.asarray(rows, np.int64).reshape(-1, CELLS[name][0] + 1)
        mesh.cells[name] = Cells(rows, np.asarray(r if r is not None else np.ones(len(rows)), np.int64))
    return mesh


def elevate(linear):
    """P2 mesh with the mid nodes in the middle of the straight edges, after the vertices."""
    all_ends = np.concatenate([np.sort(c.nodes[:, np.array(LOCAL_EDGES[CELLS[n][0]])[:, :2]], axis=2)
                               .reshape(-1, 2) for n, c in linear.cells.items()])
    ends, group = np.unique(all_ends, axis=0, return_inverse=True)
    mids = len(linear.points) + group.reshape(-1)
    out = Gmf(linear.version, linear.dim, lists=dict(linear.lists),
              points=np.concatenate([linear.points, linear.points[ends].mean(axis=1)]),
              point_refs=np.concatenate([linear.point_refs, np.zeros(len(ends), np.int64)]))
    at = 0
    for name, cells in linear.cells.items():
        per = len(LOCAL_EDGES[CELLS[name][0]])
        own = mids[at:at + per * len(cells.nodes)].reshape(-1, per)
        at += own.size
        out.cells[name + "P2"] = Cells(np.concatenate([cells.nodes, own], axis=1), cells.refs.copy())
    return out


def push_to_sphere(mesh, ref, radius):
    """Moves the mid nodes of the boundary cells of a reference radially onto a sphere about 0."""
    cells = mesh.cells["TrianglesP2" if mesh.dim == 3 else "EdgesP2"]
    mids = np.unique(cells.nodes[cells.refs == ref][:, mesh.dim:])
    mesh.points[mids] *= radius / np.linalg.norm(mesh.points[mids], axis=1, keepdims=True)


def cube(n):
    """n^3 cubes of 6 tetrahedra each, boundary triangles with the reference of their side 1..6."""
    grid = np.stack(np.meshgrid(*[np.arange(n + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    number = {tuple(p): i for i, p in enumerate(grid.tolist())}
    steps = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]
    tets = []
    for base in grid[(grid < n).all(axis=1)]:
        for path in steps:
            walk = [base.copy()]
            for axis in path:
                walk.append(walk[-1] + np.eye(3, dtype=int)[axis])
            ids = [number[tuple(p)] for p in walk]
            odd = path in steps[3:]
            tets.append([ids[0], ids[2], ids[1], ids[3]] if odd else ids)
    tets = np.array(tets)
    faces = np.sort(tets[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1)
    faces, uses = np.unique(faces, axis=0, return_counts=True)
    faces = faces[uses == 1]
    sides = [next(2 * a + (1 if (grid[f, a] == 0).all() else 2) for a in range(3)
                  if (grid[f, a] == 0).all() or (grid[f, a] == n).all()) for f in faces]
    return linear_mesh(grid / n, tets, faces, facet_refs=sides)
