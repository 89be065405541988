"""Metrics that have a formula, and how near to unit a straight mesh is in one: a judge that shares no code with any remesher."""
import struct

import numpy as np

DIMENSION, END, SOL_AT_VERTICES, TENSOR = 3, 54, 62, 3  # words of GMF
SLIM, LONG = 2 ** -0.5, 2 ** 0.5
GAUSS = np.polynomial.legendre.leggauss(5)
PIECES = 6  # of an edge, each with five Gauss points: a layer may be thinner than an edge is long


def around_axis(x, centre=(0, 0)):
    """(distance r from the axis, the rows radial, tangential, axial), (n,), (n, D, D)."""
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
    """UGAWG's linear: (rows, sizes along them)."""
    sizes = np.full((len(x), 3), 0.1)
    sizes[:, 2] = 0.001 + 2 * 0.099 * abs(x[:, 2] - 0.5)
    return np.broadcast_to(np.eye(3), (len(x), 3, 3)), scale * sizes


def polar_1(x, scale=1.0):
    """UGAWG's polar-1."""
    r, rows = around_axis(x)
    sizes = np.full((len(x), 3), 0.1)
    sizes[:, 0] = 0.001 + 2 * 0.099 * abs(r - 0.5)
    return rows, scale * sizes


def slanted(x, scale=1.0):
    """Thin, 1e-5, across a plane through the middle that no axis lies in: anisotropy 10^4."""
    normal = np.array([1.0, 2.0, 3.0]) / 14 ** 0.5
    first = np.cross(normal, [1, 0, 0])
    first /= np.linalg.norm(first)
    sizes = np.full((len(x), 3), 0.1)
    sizes[:, 2] = 1e-5 + 2 * (0.1 - 1e-5) * np.minimum(abs((x - 0.5) @ normal), 0.5)
    return np.broadcast_to(np.array([first, np.cross(normal, first), normal]), (len(x), 3, 3)), scale * sizes


def circle(x, scale=1.0):
    """2D: a layer of 0.0005 around the circle of radius 0.3 about the square's centre, 0.02 along it, 0.1 far away."""
    r, rows = around_axis(x, (0.5, 0.5))
    away = np.minimum(abs(r - 0.3) / 0.1, 1)
    sizes = np.stack([np.minimum(0.0005 + 2 * 0.0995 * abs(r - 0.3), 0.1), 0.1 * away + 0.02 * (1 - away)], 1)
    return rows, scale * sizes


def tensors(field, x):
    rows, sizes = field(x)
    return np.einsum("nki,nk,nkj->nij", rows, sizes ** -2.0, rows)


def write_solution(path, metrics):
    """A .solb, binary GMF of version 2, of the tensors at the vertices."""
    dimension = metrics.shape[1]
    lower = [(i, j) for i in range(dimension) for j in range(i + 1)]
    rows = np.stack([metrics[:, i, j] for i, j in lower], 1).astype("<f8")
    end_of_dimension = 5 * 4
    end_of_rows = end_of_dimension + 5 * 4 + rows.nbytes
    with open(path, "wb") as file:
        file.write(struct.pack("<10i", 1, 2, DIMENSION, end_of_dimension, dimension, SOL_AT_VERTICES, end_of_rows, len(rows), 1, TENSOR))
        file.write(rows.tobytes())
        file.write(struct.pack("<2i", END, 0))


def lengths(field, a, b):
    """Of straight edges, along them."""
    along = b - a
    sum_of = np.zeros(len(a))
    for piece in range(PIECES):
        for place, weight in zip(*GAUSS):
            rows, sizes = field(a + (piece + (place + 1) / 2) / PIECES * along)
            sum_of += weight / 2 / PIECES * np.sqrt((np.einsum("nki,ni->nk", rows, along) / sizes) ** 2 @ np.ones(a.shape[1]))
    return sum_of


def qualities(field, x, elements):
    """The mean ratio of each element, 1 for a regular one, in the exponential of the mean of its vertices' log metrics."""
    dimension = x.shape[1]
    rows, sizes = field(x)
    logs = np.einsum("nki,nk,nkj->nij", rows, -2 * np.log(sizes), rows)
    values, axes = np.linalg.eigh(logs[elements].mean(1))
    volumes = np.linalg.det(x[elements[:, 1:]] - x[elements[:, :1]]) / (2 if dimension == 2 else 6)
    squares = np.zeros(len(elements))
    for i in range(dimension + 1):
        for j in range(i):
            side = np.einsum("nik,ni->nk", axes, x[elements[:, i]] - x[elements[:, j]])
            squares += (side ** 2 * np.exp(values)).sum(1)
    size = (np.exp(values.sum(1) / 2) * abs(volumes)) ** (2 / dimension)
    return (4 * 3 ** 0.5 if dimension == 2 else 36 / 3 ** (1 / 3)) * np.sign(volumes) * size / squares


def judged(field, x, elements):
    """How near to unit: {elements, unit, least, mean, shortest, longest}."""
    pairs = np.concatenate([elements[:, [i, j]] for i in range(elements.shape[1]) for j in range(i)])
    edges = np.unique(np.sort(pairs, axis=1), axis=0)
    long, quality = lengths(field, x[edges[:, 0]], x[edges[:, 1]]), qualities(field, x, elements)
    return {"elements": len(elements), "unit": ((long >= SLIM) & (long <= LONG)).mean(), "least": quality.min(), "mean": quality.mean(),
            "shortest": long.min(), "longest": long.max()}
