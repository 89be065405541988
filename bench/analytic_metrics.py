"""Analytic metrics, and the edge lengths and qualities of meshes in them. This module shares no code with any remesher."""
import struct

import numpy as np

DIMENSION, END, SOL_AT_VERTICES, TENSOR = 3, 54, 62, 3  # GMF keywords
SLIM, LONG = 2 ** -0.5, 2 ** 0.5
GAUSS = np.polynomial.legendre.leggauss(5)
PIECES = 6  # pieces of an edge with five Gauss points each: a layer may be thinner than an edge is long


def around_axis(x, centre=(0, 0)):
    """Returns the distance r from the axis, (n,), and the radial, tangential and axial rows, (n, D, D)."""
    beside = x[:, :2] - np.array(centre)
    r = np.hypot(*beside.T)
    radial = np.where(r[:, None] > 0, beside / np.maximum(r, 1e-300)[:, None], [1.0, 0.0])
    rows = np.zeros((len(x), x.shape[1], x.shape[1]))
    rows[:, 0, :2] = radial
    rows[:, 1, :2] = np.stack([-radial[:, 1], radial[:, 0]], 1)
    if x.shape[1] == 3:
        rows[:, 2, 2] = 1
    return r, rows


def linear(x, scale=1.0):
    """Returns UGAWG's linear: (rows, sizes along them)."""
    sizes = np.full((len(x), 3), 0.1)
    sizes[:, 2] = 0.001 + 2 * 0.099 * abs(x[:, 2] - 0.5)
    return np.broadcast_to(np.eye(3), (len(x), 3, 3)), scale * sizes


def polar_1(x, scale=1.0):
    """Returns UGAWG's polar-1."""
    r, rows = around_axis(x)
    sizes = np.full((len(x), 3), 0.1)
    sizes[:, 0] = 0.001 + 2 * 0.099 * abs(r - 0.5)
    return rows, scale * sizes


def slanted(x, scale=1.0):
    """Returns sizes of 1e-5 across an oblique plane through the middle: anisotropy 10^4."""
    normal = np.array([1.0, 2.0, 3.0]) / 14 ** 0.5
    first = np.cross(normal, [1, 0, 0])
    first /= np.linalg.norm(first)
    sizes = np.full((len(x), 3), 0.1)
    sizes[:, 2] = 1e-5 + 2 * (0.1 - 1e-5) * np.minimum(abs((x - 0.5) @ normal), 0.5)
    return np.broadcast_to(np.array([first, np.cross(normal, first), normal]), (len(x), 3, 3)), scale * sizes


def circle(x, scale=1.0):
    """Returns a 2D layer of sizes 0.0005 across and 0.02 along a circle of radius 0.3 at the centre of the square, 0.1 far away."""
    r, rows = around_axis(x, (0.5, 0.5))
    away = np.minimum(abs(r - 0.3) / 0.1, 1)
    sizes = np.stack([np.minimum(0.0005 + 2 * 0.0995 * abs(r - 0.3), 0.1), 0.1 * away + 0.02 * (1 - away)], 1)
    return rows, scale * sizes


def tensors(field, x):
    rows, sizes = field(x)
    return np.einsum("nki,nk,nkj->nij", rows, sizes ** -2.0, rows)


def write_solution(path, metrics):
    """Writes the tensors at the vertices to a .solb file (binary GMF of version 2)."""
    dimension = metrics.shape[1]
    lower = [(i, j) for i in range(dimension) for j in range(i + 1)]
    rows = np.stack([metrics[:, i, j] for i, j in lower], 1).astype("<f8")
    end_of_dimension = 5 * 4
    end_of_rows = end_of_dimension + 5 * 4 + rows.nbytes
    with open(path, "wb") as file:
        file.write(struct.pack("<10i", 1, 2, DIMENSION, end_of_dimension, dimension, SOL_AT_VERTICES, end_of_rows, len(rows), 1, TENSOR))
        file.write(rows.tobytes())
        file.write(struct.pack("<2i", END, 0))


def lengths(field, a, b, offsets=0.0):
    """Returns lengths of edges, straight or parabolas with the given offsets of their nodes from the chords."""
    along = b - a
    sum_of = np.zeros(len(a))
    for piece in range(PIECES):
        for place, weight in zip(*GAUSS):
            t = (piece + (place + 1) / 2) / PIECES
            rows, sizes = field(a + t * along + 4 * t * (1 - t) * offsets)
            tangent = along + 4 * (1 - 2 * t) * offsets
            sum_of += weight / 2 / PIECES * np.sqrt((np.einsum("nki,ni->nk", rows, tangent) / sizes) ** 2 @ np.ones(a.shape[1]))
    return sum_of


def mean_ratios(values, axes, corners):
    """Returns mean ratios of straight elements with corners (n, D + 1, D), in metrics given by eigenvalues and axes: 1 for a regular element."""
    dimension = corners.shape[2]
    volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / (2 if dimension == 2 else 6)
    squares = np.zeros(len(corners))
    for i in range(dimension + 1):
        for j in range(i):
            side = np.einsum("nik,ni->nk", axes, corners[:, i] - corners[:, j])
            squares += (side ** 2 * np.exp(values)).sum(1)
    size = (np.exp(values.sum(1) / 2) * abs(volumes)) ** (2 / dimension)
    return (4 * 3 ** 0.5 if dimension == 2 else 36 / 3 ** (1 / 3)) * np.sign(volumes) * size / squares


def inner_points(dimension):
    """Returns barycentric coordinates of a rule with equal weights that is exact for quadratics."""
    near, far = ((5 + 3 * 5 ** 0.5) / 20, (5 - 5 ** 0.5) / 20) if dimension == 3 else (2 / 3, 1 / 6)
    return np.full((dimension + 1, dimension + 1), far) + np.eye(dimension + 1) * (near - far)


def qualities(field, x, nodes, edges):
    """Returns the mean ratio of each element (1 if regular) in the log-Euclidean mean of the metrics at its vertices. The quality of an
    element with edge nodes is 1 over the mean of 1/q of its tangent elements, or 0 if one of them is inverted."""
    dimension = x.shape[1]
    elements = nodes[:, :dimension + 1]
    rows, sizes = field(x[:elements.max() + 1])
    logs = np.einsum("nki,nk,nkj->nij", rows, -2 * np.log(sizes), rows)
    values, axes = np.linalg.eigh(logs[elements].mean(1))
    if nodes.shape[1] == dimension + 1:
        return mean_ratios(values, axes, x[elements])
    distortion = np.zeros(len(nodes))
    for xi in inner_points(dimension):
        corners = x[elements].copy()  # straight element with the same Jacobian
        for i, j, node in edges:
            offset = x[nodes[:, node]] - (x[nodes[:, i]] + x[nodes[:, j]]) / 2
            corners[:, i] += 4 * xi[j] * offset
            corners[:, j] += 4 * xi[i] * offset
        ratio = mean_ratios(values, axes, corners)
        distortion += np.where(ratio > 0, 1 / np.where(ratio > 0, ratio, 1), np.inf) / (dimension + 1)
    return 1 / distortion


def judged(field, x, nodes, edges=()):
    """Returns {elements, unit, least, mean, shortest, longest}. `nodes` has the vertices of each element, in degree 2 followed by its edge
    nodes. `edges` has the local edges (vertex, vertex, node). Vertices come first among the points."""
    dimension = x.shape[1]
    if not edges or nodes.shape[1] == dimension + 1:
        edges = [(i, j, i) for i in range(dimension + 1) for j in range(i)]
    rows = np.concatenate([nodes[:, edge] for edge in edges])
    rows[:, :2].sort(axis=1)
    a, b, node = (x[of] for of in rows[np.unique(rows[:, :2], axis=0, return_index=True)[1]].T)
    offsets = node - (a + b) / 2 if nodes.shape[1] > dimension + 1 else 0.0
    long, quality = lengths(field, a, b, offsets), qualities(field, x, nodes, edges)
    return {"elements": len(nodes), "unit": ((long >= SLIM) & (long <= LONG)).mean(), "least": quality.min(), "mean": quality.mean(),
            "shortest": long.min(), "longest": long.max()}
