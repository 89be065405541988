"""Combinatorial checks of a P2 mesh: one mid node per edge, a closed boundary, preserved input.

Each check returns (figures, problems): a dictionary for the report, and sentences on violations, without which
the check passes.  Indices in sentences count from 1, as in the file.
"""
import numpy as np

from gmf import CELLS, edge_triples

SHOWN = 5


def some(rows):
    """The first few of a list of indices or index tuples, from 1."""
    rows = np.asarray(rows)[:SHOWN] + 1
    return ", ".join("-".join(map(str, np.atleast_1d(r))) for r in rows)


def rows_as_keys(rows):
    """One comparable number for each row of small non-negative integers (index of the distinct row)."""
    return np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1)


def corner_rows(mesh, k):
    """Corners (n, k + 1) and references of the cells of dimension k, of degree 2, then 1."""
    found = [mesh.cells[n] for n in sorted(CELLS, key=lambda n: -CELLS[n][1])
             if CELLS[n][0] == k and n in mesh.cells]
    if not found:
        return np.empty((0, k + 1), np.int64), np.empty(0, np.int64)
    return (np.concatenate([c.nodes[:, :k + 1] for c in found]),
            np.concatenate([c.refs for c in found]))


def used_nodes(mesh):
    """Mask of the nodes used by any cell."""
    used = np.zeros(len(mesh.points), bool)
    for cells in mesh.cells.values():
        used[cells.nodes] = True
    return used


def mid_nodes(mesh, linear=None):
    """Checks that edges and mid nodes correspond one to one, that no mid node is a corner, and that no node is
    unused."""
    triples = np.unique(edge_triples(mesh), axis=0)
    pairs, edge_uses = np.unique(triples[:, :2], axis=0, return_counts=True)
    mids, mid_uses = np.unique(triples[:, 2], return_counts=True)
    corners = np.unique(np.concatenate([corner_rows(mesh, k)[0].reshape(-1) for k in (1, 2, 3)]))
    both = np.intersect1d(mids, corners)
    orphan = ~used_nodes(mesh)
    if linear is not None:
        known = min(len(linear.points), len(orphan))
        orphan[:known] &= used_nodes(linear)[:known]
    orphans = np.flatnonzero(orphan)
    problems = []
    if (edge_uses > 1).any():
        problems.append(f"{(edge_uses > 1).sum()} edges with several mid nodes: "
                        f"{some(pairs[edge_uses > 1])}")
    if (mid_uses > 1).any():
        problems.append(f"{(mid_uses > 1).sum()} mid nodes on several edges: "
                        f"{some(mids[mid_uses > 1])}")
    if (pairs[:, 0] == pairs[:, 1]).any():
        problems.append("an edge from a vertex to itself")
    if len(both):
        problems.append(f"{len(both)} mid nodes are corners: {some(both)}")
    if len(orphans):
        problems.append(f"{len(orphans)} nodes belong to no element: {some(orphans)}")
    return {"edges": len(pairs), "mid_nodes": len(mids), "orphans": len(orphans)}, problems


def domain_facets(mesh):
    """Facets of the elements: sorted vertices, number of elements, and whether the references of these differ."""
    k = mesh.dim
    elements, refs = corner_rows(mesh, k)
    local = np.array([[i for i in range(k + 1) if i != skip] for skip in range(k + 1)])
    facets = np.sort(elements[:, local].reshape(-1, k), axis=1)
    facets, group, count = np.unique(facets, axis=0, return_inverse=True, return_counts=True)
    owners = np.repeat(refs, k + 1)
    low, high = np.full(len(facets), np.iinfo(int).max), np.full(len(facets), np.iinfo(int).min)
    np.minimum.at(low, group.reshape(-1), owners)
    np.maximum.at(high, group.reshape(-1), owners)
    return facets, count, low != high


def boundary_defects(mesh):
    """Counts of the violations of a complete and closed boundary."""
    k = mesh.dim
    facets, count, interface = domain_facets(mesh)
    listed_facets = np.sort(corner_rows(mesh, k - 1)[0], axis=1)
    keys = rows_as_keys(np.concatenate([facets, listed_facets]))
    of_facet = np.full(keys.max(initial=0) + 1, -1)
    of_facet[keys[:len(facets)]] = np.arange(len(facets))
    facet = of_facet[keys[len(facets):]]
    listed = np.zeros(len(facets), bool)
    listed[facet[facet >= 0]] = True
    on_boundary = facet[(facet >= 0)]
    on_boundary = np.unique(on_boundary[count[on_boundary] == 1])
    ridges = np.sort(facets[on_boundary][:, [[i for i in range(k) if i != s] for s in range(k)]]
                     .reshape(-1, k - 1), axis=1)
    ridge_uses = np.unique(ridges, axis=0, return_counts=True)[1]
    return {
        "facets of one element that are not listed": int((~listed & (count == 1)).sum()),
        "facets of more than two elements": int((count > 2).sum()),
        "boundary cells that are no element's facet": int((facet < 0).sum()),
        "boundary cells listed twice": int((facet >= 0).sum() - listed.sum()),
        "inner boundary cells inside one reference":
            int((listed & (count == 2) & ~interface).sum()),
        "boundary ridges with an odd number of boundary cells": int((ridge_uses % 2).sum()),
    }, {"boundary_cells": int(len(listed_facets)), "domain_boundary_facets": int((count == 1).sum()),
        "inner_boundary_cells": int((listed & (count == 2)).sum())}


def boundary(mesh, linear=None):
    """Checks that the boundary is complete and closed; defects of the linear input are no problem."""
    defects, figures = boundary_defects(mesh)
    before = boundary_defects(linear)[0] if linear is not None else {}
    problems = [f"{n} {what}" for what, n in defects.items() if n and n != before.get(what)]
    figures["defects_of_the_input_too"] = {w: n for w, n in defects.items()
                                           if n and n == before.get(w)}
    return figures, problems


def same_bits(a, b):
    return a.shape == b.shape and np.ascontiguousarray(a).tobytes() == np.ascontiguousarray(b).tobytes()


def survival(mesh, linear):
    """Checks that vertices (bit for bit), elements, references and marked entities of the input are preserved in
    order."""
    problems = []
    n = len(linear.points)
    expected = linear.points
    if mesh.version == 1:  # 4-byte reals: the coordinates of the input rounded as in the file
        expected = expected.astype(np.float32).astype(float)
    if len(mesh.points) < n or not same_bits(mesh.points[:n], expected):
        moved = (np.flatnonzero((mesh.points[:n] != expected).any(axis=1))
                 if len(mesh.points) >= n and mesh.dim == linear.dim else [])
        problems.append(f"vertices of the input do not survive: {len(mesh.points)} nodes for {n}, "
                        f"moved {len(moved)}: {some(moved)}")
    elif not same_bits(mesh.point_refs[:n], linear.point_refs):
        problems.append("references of vertices differ")
    for name in ("Edges", "Triangles", "Tetrahedra"):
        problems += cells_survive(name, mesh, linear)
    dropped = []
    for name, rows in linear.lists.items():
        list_of_mesh = mesh.lists.get(name)
        if list_of_mesh is not None and np.array_equal(list_of_mesh[0], rows[0]) and np.array_equal(list_of_mesh[1], rows[1]):
            continue
        marks = name in ("Corners", "Ridges") or name.startswith("Required")
        if marks and len(rows[0]):
            problems.append(f"{name} differ: {len(rows[0])} in the input, "
                            f"{0 if list_of_mesh is None else len(list_of_mesh[0])} now")
        elif len(rows[0]):
            dropped.append(name)
    return {"input_vertices": n, "other_blocks_dropped_or_changed": dropped}, problems


def cells_survive(name, mesh, linear):
    """Checks that P2 cells have the corners and references of the input cells, in order."""
    k = CELLS[name][0]
    old, old_refs = corner_rows(linear, k)
    new, new_refs = corner_rows(mesh, k)
    if len(old) != len(new):
        return [f"{name}: {len(old)} in the input, {len(new)} now"]
    problems = []
    differ = np.flatnonzero((old != new).any(axis=1))
    if len(differ):
        problems.append(f"{name}: {len(differ)} with other vertices: {some(differ)}")
    differ = np.flatnonzero(old_refs != new_refs)
    if len(differ):
        problems.append(f"{name}: {len(differ)} with another reference: {some(differ)}")
    return problems
