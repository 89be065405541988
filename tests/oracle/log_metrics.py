"""Log-metrics at the vertices of a linear mesh, as full symmetric matrices (n, d, d).

Natural metrics come from the singular values of J_ref J^-1, never from the entries of the metric.
"""
import numpy as np

from conformity import corner_rows

# Order in which a GMF symmetric tensor is stored: xx, xy, yy, xz, yz, zz.
STORED = {2: [(0, 0), (0, 1), (1, 1)], 3: [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]}


def regular_simplex(k):
    """Edge vectors (columns) from vertex 0 of the regular simplex of edge length 1."""
    gram = np.full((k, k), 0.5) + 0.5 * np.eye(k)
    return np.linalg.cholesky(gram).T


def element_log_metrics(points, elements):
    """(log of the metric in which each element is regular and unit, volumes).
    M = A^T A with A = J_ref J^-1, so log M = V diag(2 log s) V^T for A = U diag(s) V^T."""
    k = points.shape[1]
    jacobian = np.swapaxes(points[elements[:, 1:]] - points[elements[:, :1]], 1, 2)
    _, s, vt = np.linalg.svd(regular_simplex(k) @ np.linalg.inv(jacobian))
    logs = np.einsum("eki,ek,ekj->eij", vt, 2 * np.log(s), vt)
    return logs, abs(np.linalg.det(jacobian))


def natural(mesh):
    """Volume-weighted log-Euclidean mean over the ball of each vertex; identity where there is none."""
    elements, _ = corner_rows(mesh, mesh.dim)
    logs, volumes = element_log_metrics(mesh.points, elements)
    total = np.zeros((len(mesh.points), mesh.dim, mesh.dim))
    weight = np.zeros(len(mesh.points))
    for corner in elements.T:
        np.add.at(total, corner, logs * volumes[:, None, None])
        np.add.at(weight, corner, volumes)
    return total / np.where(weight > 0, weight, 1)[:, None, None]


def from_field(solution, dim):
    """Log-metrics of a field: symmetric tensors, or scalar sizes h (M = I / h^2).
    Eigenvalues within rounding of zero are floored; returns (logs, number of floored tensors)."""
    kind, values = solution.fields[0]
    if kind == 1:
        return -2 * np.log(values)[:, :, None] * np.eye(dim), 0
    if kind != 3:
        raise ValueError(f"a metric is a scalar or a symmetric tensor, not a field of type {kind}")
    tensors = np.empty((len(values), dim, dim))
    for column, (i, j) in enumerate(STORED[dim]):
        tensors[:, i, j] = tensors[:, j, i] = values[:, column]
    eigenvalues, vectors = np.linalg.eigh(tensors)
    rounding = np.finfo(np.float32 if solution.version == 1 else float).eps
    floor = 8 * rounding * eigenvalues[:, -1:]
    if (eigenvalues < -floor).any() or (eigenvalues[:, -1] <= 0).any():
        raise ValueError("the metric is not positive definite")
    logs = np.log(np.maximum(eigenvalues, floor))
    return (np.einsum("nik,nk,njk->nij", vectors, logs, vectors),
            int((eigenvalues < floor).any(axis=1).sum()))


def speeds(logs, vectors):
    """sqrt(v^T exp(L) v) as sqrt(sum e^l (r.v)^2): no cancellation at any anisotropy."""
    eigenvalues, frames = np.linalg.eigh(logs)
    along = np.einsum("...ik,...i->...k", frames, vectors)
    return np.sqrt((np.exp(eigenvalues) * along ** 2).sum(axis=-1))
