"""Metrics: (v, D, D) arrays with a symmetric positive definite matrix at each vertex. Edges of the requested size have
length 1 in the metric: eigenvalues are 1/size². Arrays of sizes, (v,), are isotropic metrics.

    M = camber.metric.from_solution(mesh, u, complexity=5000)
    M = camber.metric.gradation(mesh, M, 1.5)
    finer = camber.remesh(mesh, metric=M)
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from . import _camber
from .exceptions import UsageError, in_python
from .mesh import _log, mesh_of
from .words import NOT_KEYWORDS, Words, fields_in, plain


def of(mesh: Any, metric: Any = "natural", operations: Sequence[Mapping[str, Any]] = (), **config: Any) -> np.ndarray:
    """Compute a metric at the vertices from a source and operations, which are applied in this order.

    metric: an array, a size, or a source as in a config: "natural", {"field": {…}}, {"file": …}.
    operations: [{"gradation": {"ratio": 1.5}}, {"complexity": {"target": 5000}}, {"intersect": …}, …]; "intersect"
        takes an array at the vertices too (docs/pipelines.md).
    config: other parts of the config: geometry, features, threads.
    """
    on = mesh_of(mesh)
    metrics: dict[str, Any] = {}

    def source(value: Any) -> Any:
        if np.ndim(value) > 0 and not isinstance(value, (str, Mapping)):
            name = f"memory:metric{len(metrics) or ''}.sol"
            metrics[name] = np.asarray(value)
            return {"file": name}
        if isinstance(value, (int, float, np.number, np.ndarray)):
            return {"constant": {"sizes": [float(value)]}}
        return value

    done = [
        {"intersect": source(step["intersect"])} if "intersect" in step else dict(step) for step in operations
    ]
    text = json.dumps(
        {"input": {"mesh": "memory:mesh"}, "metric": source(metric), "metric_operations": done, "stages": [], **config},
        default=plain,
    )
    made = _camber.metric_json(text, _camber.InMemory({"memory:mesh": on._handle}, metrics, {}), on._handle, None)
    return _told(made)


def natural(mesh: Any) -> np.ndarray:
    """Return the mesh's natural metric: all edges of an element have length 1 (paper §1.2.1), averaged at vertices."""
    return of(mesh)


def constant(mesh: Any, size: float) -> np.ndarray:
    """Return a metric of constant size (model units)."""
    return of(mesh, float(size))


def intersect(mesh: Any, first: Any, *others: Any) -> np.ndarray:
    """Return the largest sizes that all metrics allow; arrays, or sources of `of`."""
    return of(mesh, first, [{"intersect": other} for other in others])


def gradation(mesh: Any, metric: Any, ratio: float) -> np.ndarray:
    """Reduce sizes until those of adjacent edges differ at most by this ratio."""
    return of(mesh, metric, [{"gradation": {"ratio": float(ratio)}}])


def bound(
    mesh: Any,
    metric: Any,
    min_size: float | None = None,
    max_size: float | None = None,
    max_anisotropy: float | None = None,
) -> np.ndarray:
    """Limit sizes (model units) and their ratio at a point."""
    given = {"min_size": min_size, "max_size": max_size, "max_anisotropy": max_anisotropy}
    return of(mesh, metric, [{"bound": {name: float(v) for name, v in given.items() if v is not None}}])


def complexity(mesh: Any, metric: Any, target: float) -> np.ndarray:
    """Scale to a complexity ∫ √det M; it gives about 12 times as many tetrahedra, or 2.6 times as many triangles."""
    return of(mesh, metric, [{"complexity": {"target": float(target)}}])


def from_solution(mesh: Any, solution: Any, **options: Any) -> np.ndarray:
    """Return the metric with the minimum interpolation error of a solution, for a number of elements or a complexity.

    solution: an array or {name: array} at the vertices or nodes of the mesh.
    options: options of `camber metric` as keywords: complexity, elements, vertices, error_of, norm, degree, gradation,
        min_size, max_size, max_anisotropy, size, geometry_error, intersect (an array) …
    """
    on = mesh_of(mesh)
    words = Words(["metric", "memory:mesh", "--solution=memory:solution.sol", "-o", "memory:metric.sol"], on)
    words.meshes["memory:mesh"] = on._handle
    words.solutions["memory:solution.sol"] = fields_in(solution)
    for name, value in options.items():
        if name in NOT_KEYWORDS:
            raise UsageError("is no option here", name)
        words.add(name, value)
    return _told(_camber.metric_words(words.words, words.values(), on._handle, None))


def hessian(mesh: Any, solution: Any) -> np.ndarray:
    """Recover the second derivatives of a scalar field at the vertices: (v, D, D), symmetric, possibly indefinite.

    Polynomials are fitted to the values around each vertex, one-sided at material interfaces
    (docs/algorithms/recovery.md).
    """
    on = mesh_of(mesh)
    fields = fields_in(solution)
    if len(fields) != 1:
        raise UsageError("is more than one field", "solution", remedy="give one array")
    return _camber.hessian(on._handle, fields)


def _told(made: Mapping[str, Any]) -> np.ndarray:
    for notice in made["notices"]:
        _log.info("%s", in_python(notice))
    return made["metric"]
