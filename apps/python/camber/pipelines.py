"""Pipelines by their config: what `camber run` does."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from . import _camber
from .result import Made, made_of, mesh_of
from .words import fields_in

_Progress = Callable[[str, float], Any]


def run(
    config: Mapping[str, Any],
    mesh: Any = None,
    *,
    metric: np.ndarray | None = None,
    solution: Any = None,
    progress: _Progress | None = None,
) -> Made:
    """Run a pipeline (docs/pipelines.md; its schema: configs/schema.json).

    config: the pipeline as a dict. Its files are read and written where they are named.
    mesh: the input, in place of the config's.
    metric: (v,) or (v, D, D) at its vertices, in place of the config's.
    solution: an array or {name: array} at its vertices or nodes, in place of the config's file.
    """
    config = dict(config)
    meshes, metrics, solutions = {}, {}, {}
    on = None
    if mesh is not None:
        on = mesh_of(mesh)
        meshes["memory:mesh"] = on._handle
        config["input"] = {"mesh": "memory:mesh"}
    if metric is not None:
        metrics["memory:metric.sol"] = np.asarray(metric, float)
        config["metric"] = {"file": "memory:metric.sol"}
    if solution is not None:
        solutions["memory:solution.sol"] = fields_in(solution)
        config["solution"] = {**config.get("solution", {}), "file": "memory:solution.sol"}
    handle = on._handle if on is not None else None
    return made_of(_camber.run_config(json.dumps(config), meshes, metrics, solutions, handle, progress))


def elevate(mesh: Any, *, progress: _Progress | None = None) -> Made:
    """Degree 1 to 2: each edge gets a node at its middle, and nothing moves."""
    return run({"stages": ["elevate"]}, mesh, progress=progress)


def validate(mesh: Any, *, min_scaled_jacobian: float = 0.0, progress: _Progress | None = None) -> Made:
    """Certify each element of a mesh of degree 2: det J above the bound everywhere, or certainly not (`report`)."""
    stage = {"validate": {"min_scaled_jacobian": min_scaled_jacobian}}
    return run({"stages": [stage]}, mesh, progress=progress)


def errors(mesh: Any, field: str, *, progress: _Progress | None = None) -> dict[str, Any]:
    """Errors, in L2 and H1, of the interpolants of an expression of x, y and z: of degree 1 and 2 with straight edges,
    and on the mesh as it is, with where they sit (`camber check --field`, docs/report.md)."""
    from .verbs import check

    return check(mesh, field=field, progress=progress)["interpolation"][0]
