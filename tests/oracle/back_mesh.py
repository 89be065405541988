"""Point location in a linear mesh, vectorised: visibility walk, then the closest boundary facet.

Points outside the mesh take the closest point found among the boundary facets whose centroids are
nearest (32 of them); their field is the one at that closest point.
"""
import numpy as np

from conformity import corner_rows, rows_as_keys

INSIDE = -1e-12
STEPS = 400
CANDIDATES = 32


def neighbours(elements, k):
    """Element across the facet opposite to each local vertex, -1 on the boundary."""
    local = [[i for i in range(k + 1) if i != skip] for skip in range(k + 1)]
    keys = rows_as_keys(np.sort(elements[:, local].reshape(-1, k), axis=1))
    order = np.argsort(keys, kind="stable")
    pair = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    out = np.full(elements.size, -1)
    out[order[pair]] = order[pair + 1] // (k + 1)
    out[order[pair + 1]] = order[pair] // (k + 1)
    return out.reshape(elements.shape)


def closest_on_simplex(corners, points):
    """Barycentric weights of the closest point of segments or triangles (n, k, d), k = 2 or 3:
    the projection where it is inside, else the best of the clamped sides."""
    k = corners.shape[1]
    edges = corners[:, 1:] - corners[:, :1]
    gram = np.einsum("nid,njd->nij", edges, edges)
    right = np.einsum("nid,nd->ni", edges, points - corners[:, 0])
    if k == 2:
        t = np.clip(right[:, 0] / gram[:, 0, 0], 0, 1)
        return np.column_stack([1 - t, t])
    inner = np.linalg.solve(gram, right[:, :, None])[:, :, 0]
    best = np.column_stack([1 - inner.sum(axis=1), inner])
    outside = (best < 0).any(axis=1)
    distance = np.where(outside, np.inf, 0)
    for a, b in ((0, 1), (1, 2), (0, 2)):
        weights = np.zeros_like(best)
        weights[:, [a, b]] = closest_on_simplex(corners[:, [a, b]], points)
        gap = np.linalg.norm(np.einsum("nk,nkd->nd", weights, corners) - points, axis=1)
        better = outside & (gap < distance)
        best[better], distance[better] = weights[better], gap[better]
    return best


class BackMesh:
    """A linear mesh with log-metrics at its vertices, interpolated linearly in each element."""

    def __init__(self, mesh, logs):
        self.k, self.points, self.logs = mesh.dim, mesh.points, logs
        self.elements, _ = corner_rows(mesh, mesh.dim)
        self.across = neighbours(self.elements, self.k)
        origin = self.points[self.elements[:, 0]]
        self.origin = origin
        self.inverse = np.linalg.inv(np.swapaxes(
            self.points[self.elements[:, 1:]] - origin[:, None], 1, 2))
        owner, opposite = np.nonzero(self.across < 0)
        keep = np.array([[i for i in range(self.k + 1) if i != s] for s in range(self.k + 1)])
        self.facet_owner, self.facet_local = owner, keep[opposite]
        self.facet_corners = self.points[self.elements[owner[:, None], self.facet_local]]

    def barycentric(self, element, x):
        rest = np.einsum("nij,nj->ni", self.inverse[element], x - self.origin[element])
        return np.column_stack([1 - rest.sum(axis=1), rest])

    def walk(self, x, start):
        """(element, barycentrics, found) of each point, walking from its start element."""
        element = start.copy()
        weights = np.empty((len(x), self.k + 1))
        found = np.zeros(len(x), bool)
        active = np.arange(len(x))
        random = np.random.default_rng(1)
        for step in range(STEPS):
            b = self.barycentric(element[active], x[active])
            weights[active] = b
            inside = b.min(axis=1) >= INSIDE
            found[active[inside]] = True
            active, b = active[~inside], b[~inside]
            across = self.across[element[active]]
            cost = np.where((b < INSIDE) & (across >= 0), b, np.inf)
            if step > 30:  # a fixed choice may cycle
                cost = np.where(np.isfinite(cost), random.random(cost.shape), np.inf)
            side = cost.argmin(axis=1)
            passable = np.isfinite(cost[np.arange(len(side)), side])
            active, side, across = active[passable], side[passable], across[passable]
            if not len(active):
                break
            element[active] = across[np.arange(len(side)), side]
        return element, weights, found

    def nearest_facets(self, x):
        """(element, barycentrics in it) of the closest point on the boundary, in chunks."""
        element = np.empty(len(x), int)
        weights = np.zeros((len(x), self.k + 1))
        centres = self.facet_corners.mean(axis=1)
        near = min(CANDIDATES, len(centres))
        for at in range(0, len(x), 2048):
            part = x[at:at + 2048]
            gap = (centres ** 2).sum(axis=1) - 2 * part @ centres.T
            facets = np.argpartition(gap, near - 1, axis=1)[:, :near]
            corners = self.facet_corners[facets.reshape(-1)]
            inner = closest_on_simplex(corners, np.repeat(part, near, axis=0))
            where = np.einsum("nk,nkd->nd", inner, corners).reshape(len(part), near, -1)
            best = np.linalg.norm(where - part[:, None], axis=2).argmin(axis=1)
            rows = np.arange(len(part))
            chosen = facets[rows, best]
            element[at:at + len(part)] = self.facet_owner[chosen]
            weights[(at + rows)[:, None], self.facet_local[chosen]] = \
                inner.reshape(len(part), near, -1)[rows, best]
        return element, weights

    def locate(self, x, start):
        """(element, barycentrics, inside): a second walk starts at the nearest boundary facet."""
        element, weights, found = self.walk(x, start)
        lost = np.flatnonzero(~found)
        if len(lost):
            facet_element, facet_weights = self.nearest_facets(x[lost])
            again, again_weights, again_found = self.walk(x[lost], facet_element)
            element[lost] = np.where(again_found, again, facet_element)
            weights[lost] = np.where(again_found[:, None], again_weights, facet_weights)
            found[lost] = again_found
        return element, weights, found

    def nearest_start(self, x):
        """An element at the vertex nearest to each point, to start a walk from."""
        at_vertex = np.full(len(self.points), -1)
        at_vertex[self.elements] = np.arange(len(self.elements))[:, None]
        used = np.flatnonzero(at_vertex >= 0)
        corners, out = self.points[used], np.empty(len(x), int)
        for at in range(0, len(x), 2048):
            gap = (corners ** 2).sum(axis=1) - 2 * x[at:at + 2048] @ corners.T
            out[at:at + 2048] = at_vertex[used[gap.argmin(axis=1)]]
        return out

    def log_metric(self, x, start):
        """Interpolated log-metric at points (n, d), and the number of points outside."""
        element, weights, found = self.locate(x, start)
        corner_logs = self.logs[self.elements[element]]
        return np.einsum("nk,nkij->nij", weights, corner_logs), int((~found).sum())
