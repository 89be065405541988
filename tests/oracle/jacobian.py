"""Validity of P2 simplices from the Bernstein coefficients of det J, by interpolation.

det J has degree k on a P2 simplex of dimension k (2: 6 coefficients, 3: 20).  It is evaluated at the
lattice points of that degree and turned into Bernstein form by inverting the collocation matrix (not
by the product formula for coefficients).  Children of the red subdivision (4 or 8) follow from the
same matrices.  All matrices are exact rationals; elements that doubles cannot decide, by a forward
error bound, are decided again in rational arithmetic on the stored numbers.
Bernstein bounds: Johnen, Remacle, Geuzaine, "Geometrical validity of curvilinear finite elements", 2013.
"""
from fractions import Fraction
from functools import lru_cache
from itertools import product
from math import factorial, prod

import numpy as np

from gmf import CANONICAL

VALID, UNDECIDED, INVALID = 1, 0, -1
CHUNK = 16384
EPS = np.finfo(float).eps


def lattice(k):
    """Multi-indices of sum k on a simplex of dimension k, its k + 1 corners first."""
    every = [a for a in product(range(k, -1, -1), repeat=k + 1) if sum(a) == k]
    corners = [tuple(k * (i == j) for j in range(k + 1)) for i in range(k + 1)]
    return corners + [a for a in every if a not in corners]


def bernstein_rows(k, points):
    """B_a(p) of degree k for barycentric points p (rows) and a in lattice(k) (columns)."""
    return np.array([[Fraction(factorial(k), prod(map(factorial, a)))
                      * prod(x ** n for x, n in zip(p, a)) for a in lattice(k)] for p in points])


def invert(matrix):
    """Gauss-Jordan in rational arithmetic."""
    n = len(matrix)
    work = np.concatenate([matrix, np.array([[Fraction(i == j) for j in range(n)]
                                             for i in range(n)])], axis=1)
    for c in range(n):
        pivot = next(r for r in range(c, n) if work[r, c] != 0)
        work[[c, pivot]] = work[[pivot, c]]
        work[c] = work[c] / work[c, c]
        for r in range(n):
            if r != c and work[r, c] != 0:
                work[r] = work[r] - work[r, c] * work[c]
    return work[:, n:]


def shape_gradient(k, point):
    """d/dxi_a - d/dxi_0, a = 1..k, of the P2 Lagrange functions at a barycentric point."""
    rows = []
    for exps in CANONICAL[k]:
        on = [i for i in range(k + 1) if exps[i]]
        raw = [Fraction(0)] * (k + 1)
        if len(on) == 1:
            raw[on[0]] = 4 * point[on[0]] - 1
        else:
            raw[on[0]], raw[on[1]] = 4 * point[on[1]], 4 * point[on[0]]
        rows.append([raw[a] - raw[0] for a in range(1, k + 1)])
    return rows


def child_corners(k):
    """Barycentric corners of the children of the red subdivision."""
    v = [tuple(Fraction(i == j) for j in range(k + 1)) for i in range(k + 1)]
    mid = {(i, j): tuple((a + b) / 2 for a, b in zip(v[i], v[j]))
           for i in range(k + 1) for j in range(k + 1)}
    corner = [[v[i]] + [mid[i, j] for j in range(k + 1) if j != i] for i in range(k + 1)]
    if k == 2:
        return corner + [[mid[0, 1], mid[1, 2], mid[0, 2]]]
    ring = [mid[0, 1], mid[1, 2], mid[2, 3], mid[0, 3]]  # around the diagonal m02, m13
    return corner + [[mid[0, 2], mid[1, 3], ring[i], ring[(i + 1) % 4]] for i in range(4)]


@lru_cache(None)
def tables(k, exact):
    """(gradients at the lattice, values -> coefficients, coefficients -> those of the children)."""
    points = [tuple(Fraction(n, k) for n in a) for a in lattice(k)]
    gradients = np.array([shape_gradient(k, p) for p in points])
    to_coefficients = invert(bernstein_rows(k, points))
    children = []
    for corners in child_corners(k):
        inside = [tuple(sum(w * c[i] for w, c in zip(p, corners)) for i in range(k + 1))
                  for p in points]
        children.append(to_coefficients.dot(bernstein_rows(k, inside)))
    out = gradients, to_coefficients, np.array(children)
    return out if exact else tuple(m.astype(float) for m in out)


def determinant(m):
    """det of (..., k, k) arrays, k = 2 or 3, of floats or rationals."""
    if m.shape[-1] == 2:
        return m[..., 0, 0] * m[..., 1, 1] - m[..., 0, 1] * m[..., 1, 0]
    return sum(m[..., 0, i] * (m[..., 1, j] * m[..., 2, l] - m[..., 1, l] * m[..., 2, j])
               for i, j, l in ((0, 1, 2), (1, 2, 0), (2, 0, 1)))


def permanent(m):
    """The permanent of m (all signs plus): for |m| it bounds the determinant and its rounding."""
    if m.shape[-1] == 2:
        return m[..., 0, 0] * m[..., 1, 1] + m[..., 0, 1] * m[..., 1, 0]
    return sum(m[..., 0, i] * (m[..., 1, j] * m[..., 2, l] + m[..., 1, l] * m[..., 2, j])
               for i, j, l in ((0, 1, 2), (1, 2, 0), (2, 0, 1)))


def coefficients(nodes):
    """Bernstein coefficients (n, m) of det J for Lagrange nodes (n, nodes, k), and the scale of
    their rounding: |error| <= 64 EPS scale (11-term columns, triple products, one more product)."""
    k = nodes.shape[2]
    gradients, to_coefficients, _ = tables(k, False)
    offsets = nodes - nodes[:, :1]
    jacobians = np.einsum("gna,end->egda", gradients, offsets, optimize=True)
    bound = permanent(np.einsum("gna,end->egda", abs(gradients), abs(offsets), optimize=True))
    scale = (bound @ abs(to_coefficients).T).max(axis=1)
    return determinant(jacobians) @ to_coefficients.T, scale


def exact_coefficients(nodes):
    """The coefficients of one element (nodes, k), as rationals."""
    k = nodes.shape[1]
    gradients, to_coefficients, _ = tables(k, True)
    rational = np.array([[Fraction(float(x)) for x in row] for row in nodes])
    offsets = rational - rational[0]
    values = [determinant(offsets.T.dot(g)) for g in gradients]
    return to_coefficients.dot(np.array(values))


def subdivide(leaves, k, exact=False):
    """Coefficients of all children, (8 n or 4 n, m), children of a leaf together."""
    children = tables(k, exact)[2]
    if exact:
        return np.array([child.dot(leaf) for leaf in leaves for child in children])
    return np.einsum("cij,nj->nci", children, leaves, optimize=True).reshape(-1, leaves.shape[1])


def decide(coefs, scale, k, depth=8, most=400000):
    """Verdict of each element in doubles; UNDECIDED also where rounding leaves the sign open."""
    verdict = np.full(len(coefs), VALID, np.int8)
    leaves, owner = coefs, np.arange(len(coefs))
    for level in range(depth + 1):
        error = ((64 + 16 * level) * EPS * scale)[owner, None]
        verdict[owner[(leaves[:, :k + 1] < -error).any(axis=1)]] = INVALID
        open_ = ~(leaves > error).all(axis=1) & (verdict[owner] != INVALID)
        leaves, owner = leaves[open_], owner[open_]
        if not len(leaves) or level == depth or len(leaves) * 2 ** k > most:
            break
        leaves, owner = subdivide(leaves, k), np.repeat(owner, 2 ** k)
    verdict[owner] = UNDECIDED
    return verdict


def decide_exactly(nodes, depth=16, most=512):
    """Verdict of one element in rational arithmetic; UNDECIDED at the depth or leaf limit."""
    k = nodes.shape[1]
    leaves = exact_coefficients(nodes)[None, :]
    for level in range(depth + 1):
        if (leaves[:, :k + 1] <= 0).any():
            return INVALID
        leaves = leaves[(leaves <= 0).any(axis=1)]
        if not len(leaves):
            return VALID
        if level == depth or len(leaves) > most:
            return UNDECIDED
        leaves = subdivide(leaves, k, exact=True)


def straight_signs(corners):
    """Sign of det of the straight elements (n, k + 1, k), exact, and the determinants."""
    edges = corners[:, 1:] - corners[:, :1]
    det, error = determinant(edges), 16 * EPS * permanent(abs(edges))
    sign = np.sign(det).astype(int)
    for e in np.flatnonzero(abs(det) <= error):
        p = np.array([[Fraction(float(x)) for x in row] for row in corners[e]])
        exact = determinant(p[1:] - p[0])
        sign[e] = (exact > 0) - (exact < 0)
    return sign, det


class SmallestRatio:
    """Branch and bound for the smallest det J / |straight det|, to a tolerance (absolute below 1,
    relative above).  `upper` is a value that is attained, `lower` a bound."""

    def __init__(self, tolerance=1e-3, depth=30):
        self.tolerance, self.depth = tolerance, depth
        self.upper, self.lower, self.element = np.inf, np.inf, -1

    def slack(self):
        return 0.5 * self.tolerance * max(1.0, abs(self.upper)) if self.element >= 0 else 0.0

    def add(self, ratios, ids, k):
        """Takes the coefficients (n, m) of more elements, already divided."""
        leaves, owner = ratios, ids
        for _ in range(self.depth):
            if not len(leaves):
                return
            corner = leaves[:, :k + 1].min(axis=1)
            if corner.min() < self.upper:
                self.upper, self.element = float(corner.min()), int(owner[corner.argmin()])
            low = leaves.min(axis=1)
            keep = low < self.upper - self.slack()
            if (~keep).any():
                self.lower = min(self.lower, float(low[~keep].min()))
            leaves, owner = subdivide(leaves[keep], k), np.repeat(owner[keep], 2 ** k)
        self.lower = min(self.lower, float(leaves.min()))


def examine(points, rows):
    """Verdicts and minima of P2 elements given by rows of node indices; a dictionary.
    Elements with a coordinate that is not finite are invalid, of straight sign 0."""
    k = points.shape[1]
    verdict, sign = np.full(len(rows), INVALID, np.int8), np.zeros(len(rows), int)
    smallest, rational = SmallestRatio(), 0
    finite = np.flatnonzero(np.isfinite(points).all(axis=1)[rows].all(axis=1))
    for start in range(0, len(finite), CHUNK):
        ids = finite[start:start + CHUNK]
        nodes = points[rows[ids]]
        coefs, scale = coefficients(nodes)
        verdict[ids] = decide(coefs, scale, k)
        for e in ids[verdict[ids] == UNDECIDED]:
            verdict[e], rational = decide_exactly(points[rows[e]]), rational + 1
        sign[ids], det = straight_signs(nodes[:, :k + 1])
        full = sign[ids] != 0
        smallest.add(coefs[full] / abs(det[full, None]), ids[full], k)
    return {"verdict": verdict, "straight_sign": sign, "decided_in_rationals": rational,
            "smallest": smallest}
