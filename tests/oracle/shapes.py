"""Geometric checks of a curved boundary: planes stay planes, spheres are approximated.

Boundary cells are the P2 triangles in 3D and the P2 edges in 2D; both go through the same code.
"""
from itertools import product

import numpy as np

from gmf import CANONICAL

RELATIVE = 1e-12
SAMPLES = 20


def boundary_cells(mesh):
    return mesh.cells.get("TrianglesP2" if mesh.dim == 3 else "EdgesP2")


def same_bits_on(column):
    """All numbers of a column have the same bits."""
    bits = np.ascontiguousarray(column).view(np.int64)
    return bool((bits == bits[0]).all())


def plane_of(points):
    """(centre, unit normal, extent) of the best plane (line in 2D), by singular vectors."""
    centre = points.mean(axis=0)
    offsets = points - centre
    return centre, np.linalg.svd(offsets, full_matrices=False)[2][-1], abs(offsets).max()


def planes(mesh):
    """Checks that mid nodes of coplanar straight cells lie on their plane, for axis-aligned planes bit for bit."""
    cells, problems, figures = boundary_cells(mesh), [], {}
    # 4-byte reals cannot hold a skew plane better than their rounding
    relative = RELATIVE if mesh.version > 1 else 1e-6
    for ref in np.unique(cells.refs) if cells is not None else []:
        nodes = cells.nodes[cells.refs == ref]
        corners = mesh.points[np.unique(nodes[:, :mesh.dim])]
        if len(corners) <= mesh.dim - 1:
            continue
        centre, normal, extent = plane_of(corners)
        if abs((corners - centre) @ normal).max() > relative * extent:
            continue
        mids = mesh.points[np.unique(nodes[:, mesh.dim:])]
        off = abs((mids - centre) @ normal).max() / extent
        axes = [a for a in range(mesh.dim) if same_bits_on(corners[:, a])]
        figures[int(ref)] = {"cells": len(nodes), "largest_relative_distance": float(off),
                             "constant_axes": ["xyz"[a] for a in axes]}
        if off > relative:
            problems.append(f"plane of reference {ref}: a mid node is {off:.3g} of its extent off")
        for a in axes:
            wrong = int((np.ascontiguousarray(mids[:, a]).view(np.int64)
                         != corners[:1, a].copy().view(np.int64)).sum())
            if wrong:
                problems.append(f"plane of reference {ref}: {wrong} mid nodes do not have the "
                                f"plane's {'xyz'[a]} = {corners[0, a]!r} to the bit")
    return figures, problems


def sample_weights(k, n=SAMPLES):
    """Weights of the corners, and of the P2 nodes, at the lattice points of n subdivisions."""
    points = np.array([p for p in product(range(n + 1), repeat=k + 1) if sum(p) == n]) / n
    quadratic = [p * (2 * p - 1) for p in points.T]
    quadratic += [4 * points[:, i] * points[:, j]
                  for i, j in [np.flatnonzero(e) for e in CANONICAL[k][k + 1:]]]
    return points, np.array(quadratic).T


def sphere(mesh, ref, radius, centre):
    """Largest distance to a sphere (circle in 2D) of the straight and of the curved cells."""
    cells = boundary_cells(mesh)
    chosen = cells.refs == ref if cells is not None else np.zeros(0, bool)
    if not chosen.any():
        return {"reference": ref, "cells": 0}, [f"no boundary cells of reference {ref}"]
    nodes = mesh.points[cells.nodes[chosen]] - np.asarray(centre, float)[:mesh.dim]
    linear, quadratic = sample_weights(mesh.dim - 1)

    def distance(weights, control):
        norms = np.linalg.norm(np.einsum("sn,end->esd", weights, control, optimize=True), axis=2)
        return float(abs(norms - radius).max())

    straight, curved = distance(linear, nodes[:, :mesh.dim]), distance(quadratic, nodes)
    ratio = straight / curved if curved else None  # None: exact
    figures = {"reference": ref, "radius": radius, "cells": int(chosen.sum()),
               "straight": straight, "curved": curved, "ratio": ratio}
    problems = [] if curved <= straight else [
        f"sphere of reference {ref}: the curved cells are farther off than the straight ones"]
    return figures, problems
