"""What the verbs do with their keywords."""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Callable, Mapping
from typing import Any, TypeVar, cast

import numpy as np

from . import _camber
from .exceptions import UsageError
from .mesh import Mesh
from .metric import of as metrics_of
from .result import Made, made_of, mesh_of
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


def _split(options: dict[str, Any], *subjects: str) -> tuple[list[Any], Any, dict[str, Any]]:
    options = dict(options)
    return [options.pop(name) for name in subjects], options.pop("progress"), options


def _pipeline(verb: str, options: dict[str, Any]) -> Made:
    (mesh,), progress, rest = _split(options, "mesh")
    words = words_of(verb, mesh, rest)
    words.words += ["-o", "memory:mesh"]
    return made_of(_camber.run_words(words.words, *words.values(), words.mesh._handle, progress))


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
    return made_of(_camber.adapt_words(words.words, *words.values(), words.mesh._handle, solver_of(solve), progress))


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
    """References and verdicts (0 valid, 1 invalid, 2 undecided) as whole numbers."""
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
