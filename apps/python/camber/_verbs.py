"""Pipelines from a config, like `camber run`, and the verbs with their keywords as a dict."""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Callable, Mapping
from typing import Any, TypeVar, cast

import numpy as np

from . import _camber
from .exceptions import UsageError
from .files import read
from .mesh import Made, Mesh, made_of, mesh_of
from .metric import of as metrics_of
from .words import Words, fields_in, plain, solver_of, words_of

#: Keywords of earlier versions and their successors.
_RENAMED = {"cad_seconds": "cad_timeout", "settled": "convergence_tolerance"}

Verb = TypeVar("Verb", bound=Callable[..., Any])


def with_new_names(verb: Verb) -> Verb:
    """Returns the verb with errors for old keywords that state the new ones."""

    @functools.wraps(verb)
    def checked(*values: Any, **keywords: Any) -> Any:
        for old, new in _RENAMED.items():
            if old in keywords:
                raise UsageError(f"was renamed to {new}", old, remedy=f"write {new}")
        return verb(*values, **keywords)

    return cast(Verb, checked)


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
    """Run a pipeline with its adaptation cycles (docs/pipelines.md; schema: configs/schema.json).

    config: the pipeline as a dict, or the path of its file. File names in it are relative to the working directory.
    mesh: replaces the config's input.
    metric: (v,) or (v, D, D) at the vertices; replaces the config's metric.
    solution: an array or {name: array} at the vertices or nodes; replaces the config's file.
    solve: replaces the solver command of a config with "adapt": see `adapt`.
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
    values = _camber.InMemory(meshes, metrics, solutions)
    return made_of(_camber.run_config(text, values, handle, solver_of(solve), progress))


def _input_of(config: Mapping[str, Any]) -> Mesh:
    given = config.get("input", {})
    if "mesh" not in given:
        raise UsageError("arrays are of a mesh", "mesh", remedy="give it, or a config whose input is a file")
    return read(given["mesh"], flat=given.get("flat", "plane"))


def elevate(mesh: Any, *, threads: int = 0, progress: _Progress | None = None) -> Made:
    """Elevate degree 1 to 2: each edge gets a node at its midpoint; positions do not change."""
    return run({"stages": ["elevate"], "threads": threads}, mesh, progress=progress)


def validate(mesh: Any, *, min_scaled_jacobian: float = 0.0, threads: int = 0, progress: _Progress | None = None) -> Made:
    """Certify for each element of a quadratic mesh that det J is above the bound everywhere, or that it is not (`report`)."""
    stage = {"validate": {"min_scaled_jacobian": min_scaled_jacobian}}
    return run({"stages": [stage], "threads": threads}, mesh, progress=progress)


def errors(mesh: Any, field: str, *, progress: _Progress | None = None) -> dict[str, Any]:
    """Return interpolation errors in L2 and H1 of an expression of x, y and z, with their location: for degree 1 and 2 with
    straight edges, and on the mesh itself (`camber check --field`, docs/report.md)."""
    return check({"mesh": mesh, "field": field, "metric": None, "progress": progress})["interpolation"][0]


def _split(options: dict[str, Any], *subjects: str) -> tuple[list[Any], Any, dict[str, Any]]:
    options = dict(options)
    return [options.pop(name) for name in subjects], options.pop("progress"), options


def _pipeline(verb: str, options: dict[str, Any]) -> Made:
    (mesh,), progress, rest = _split(options, "mesh")
    words = words_of(verb, mesh, rest)
    words.words += ["-o", "memory:mesh"]
    return made_of(_camber.run_words(words.words, words.values(), words.mesh._handle, progress))


def curve(options: dict[str, Any]) -> Made:
    return _pipeline("curve", options)


def remesh(options: dict[str, Any]) -> Made:
    return _pipeline("remesh", options)


def repair(options: dict[str, Any]) -> Made:
    return _pipeline("repair", options)


def adapt(options: dict[str, Any]) -> Made:
    (mesh, solve), progress, rest = _split(options, "mesh", "solve")
    if rest.get("complexity") is not None and np.ndim(rest["complexity"]) > 0:
        rest["complexity"] = ",".join(repr(float(c)) for c in rest["complexity"])
    words = words_of("adapt", mesh, rest)
    words.words += ["-o", "memory:mesh"]
    if solve is not None:
        words.words += ["--solve=memory:solver {mesh} {solution}"]
    return made_of(_camber.adapt_words(words.words, words.values(), words.mesh._handle, solver_of(solve), progress))


def check(options: dict[str, Any]) -> dict[str, Any]:
    (mesh, metric), progress, rest = _split(options, "mesh", "metric")
    if isinstance(rest.get("field"), str):
        rest["field"] = [rest["field"]]
    words = words_of("check", mesh, rest)
    if isinstance(metric, (str, os.PathLike, Mapping)):
        metric = metrics_of(words.mesh, metric if isinstance(metric, Mapping) else {"file": os.fspath(metric)})
    if metric is not None and np.ndim(metric) == 0:
        metric = np.full(len(words.mesh.vertices), float(metric))
    rows = None if metric is None else np.asarray(metric)
    raw = _camber.check(words.words, words.mesh._handle, rows, progress)
    return {**json.loads(raw["report"]), "table": raw["table"], "element_verdicts": _columns(raw["elements"]), "success": raw["success"]}


def _columns(raw: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Convert references and verdicts (0 valid, 1 invalid, 2 undecided) to integers."""
    whole = {"reference": np.int32, "verdict": np.int8, "straight_inverted": bool}
    return {name: values.astype(whole.get(name, float)) for name, values in raw.items()}


def geometry(options: dict[str, Any]) -> dict[str, Any]:
    (mesh,), progress, rest = _split(options, "mesh")
    words = words_of("geometry", mesh, rest)
    return json.loads(_camber.geometry(words.words, words.mesh._handle, words.meshes, progress))


def transfer(options: dict[str, Any]) -> dict[str, np.ndarray]:
    (old, new, solution), progress, rest = _split(options, "old_mesh", "new_mesh", "solution")
    words = Words(["transfer", "memory:old", "memory:new", "--solution=memory:solution", "-o", "memory:out.sol"])
    for name, value in rest.items():
        words.add(name, value)
    return _camber.transfer(words.words, mesh_of(old)._handle, mesh_of(new)._handle, fields_in(solution), progress)


def generate(options: dict[str, Any]) -> Mesh:
    (shape,), progress, rest = _split(options, "shape")
    words = Words(["generate", shape if isinstance(shape, str) else json.dumps(shape, default=plain), "-o", "memory:mesh.meshb"])
    for name, value in rest.items():
        words.add(name, value)
    return Mesh._of(_camber.generate(words.words, progress))
