"""Pipelines by their config: what `camber run` does."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from . import _camber
from .exceptions import UsageError
from .files import read
from .mesh import Mesh
from .result import Made, made_of, mesh_of
from .words import fields_in, plain, solver_of

_Progress = Callable[[str, float], Any]


def run(
    config: Mapping[str, Any] | str | os.PathLike[str],
    mesh: Any = None,
    *,
    metric: Any = None,
    solution: Any = None,
    solve: Callable[[Mesh, Mapping[str, np.ndarray], int], Any] | None = None,
    progress: _Progress | None = None,
) -> Made:
    """Run a pipeline, its cycles too (docs/pipelines.md; its schema: configs/schema.json).

    config: the pipeline as a dict, or the path of its file. Its files are read and written where they are named, a
        file's relative to the working directory.
    mesh: the input, in place of the config's.
    metric: (v,) or (v, D, D) at its vertices, in place of the config's.
    solution: an array or {name: array} at its vertices or nodes, in place of the config's file.
    solve: for a config with "adapt", in place of its command: see `adapt`.
    """
    if not isinstance(config, Mapping):
        with open(config, encoding="utf-8") as file:
            config = json.load(file)
    config = dict(config)
    if mesh is None and (metric is not None or solution is not None):
        mesh = _input_of(config)
    meshes, metrics, solutions = {}, {}, {}
    on = None
    if mesh is not None:
        on = mesh_of(mesh)
        meshes["memory:mesh"] = on._handle
        config["input"] = {"mesh": "memory:mesh"}
    if metric is not None:
        metrics["memory:metric.sol"] = np.asarray(metric)
        config["metric"] = {"file": "memory:metric.sol"}
    if solution is not None:
        solutions["memory:solution.sol"] = fields_in(solution)
        config["solution"] = {**config.get("solution", {}), "file": "memory:solution.sol"}
    handle = on._handle if on is not None else None
    text = json.dumps(config, default=plain)
    return made_of(_camber.run_config(text, meshes, metrics, solutions, handle, solver_of(solve), progress))


def _input_of(config: Mapping[str, Any]) -> Mesh:
    given = config.get("input", {})
    if "mesh" not in given:
        raise UsageError("arrays are of a mesh", "mesh", remedy="give it, or a config whose input is a file")
    return read(given["mesh"], flat=given.get("flat", "plane"))


def elevate(mesh: Any, *, threads: int = 0, progress: _Progress | None = None) -> Made:
    """Degree 1 to 2: each edge gets a node at its middle, and nothing moves."""
    return run({"stages": ["elevate"], "threads": threads}, mesh, progress=progress)


def validate(mesh: Any, *, min_scaled_jacobian: float = 0.0, threads: int = 0, progress: _Progress | None = None) -> Made:
    """Certify each element of a mesh of degree 2: det J above the bound everywhere, or certainly not (`report`)."""
    stage = {"validate": {"min_scaled_jacobian": min_scaled_jacobian}}
    return run({"stages": [stage], "threads": threads}, mesh, progress=progress)


def errors(mesh: Any, field: str, *, progress: _Progress | None = None) -> dict[str, Any]:
    """Errors, in L2 and H1, of the interpolants of an expression of x, y and z: of degree 1 and 2 with straight edges,
    and on the mesh as it is, with where they sit (`camber check --field`, docs/report.md)."""
    from .verbs import check

    return check(mesh, field=field, progress=progress)["interpolation"][0]
