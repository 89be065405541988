"""Conversion of keyword arguments to words of the command line, and the values in memory that they name."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import _camber
from .exceptions import UsageError
from .mesh import Mesh, mesh_of


@dataclass
class Words:
    """A verb's words, and the values in memory that they name."""

    words: list[str]
    mesh: Mesh | None = None
    meshes: dict[str, Any] = field(default_factory=dict)
    metrics: dict[str, Any] = field(default_factory=dict)
    solutions: dict[str, Any] = field(default_factory=dict)

    def values(self) -> _camber.InMemory:
        return _camber.InMemory(self.meshes, self.metrics, self.solutions)

    def add(self, name: str, value: Any) -> None:
        option = "--" + name.replace("_", "-")
        if value is None or (isinstance(value, (bool, np.bool_)) and not value):
            return
        if isinstance(value, (bool, np.bool_)) or (isinstance(value, str) and not value):
            raise UsageError(f"is {value!r}", name)
        for text in self.texts(name, value):
            self.words.append(f"{option}={text}")

    def texts(self, name: str, value: Any) -> list[str]:
        if name in _IN_MEMORY:
            known = _IN_MEMORY[name](self, value)
            if known is not None:
                return [known]
        if name == "size" and isinstance(value, Mapping):
            return [f"{reference}={float(size)!r}" for reference, size in value.items()]
        if name == "set" and isinstance(value, Mapping):
            return [f"{path}={_json(v)}" for path, v in value.items()]
        if isinstance(value, Mapping):
            return [json.dumps(value, default=plain)]
        if name in _LISTS and isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str):
            return [_text(v) for v in value]
        if np.ndim(value) > 0:
            raise UsageError(f"is a {type(value).__name__}, and one value is wanted", name)
        return [_text(value)]


def words_of(verb: str, mesh: Any, options: Mapping[str, Any]) -> Words:
    """Return the words of a verb from a mesh to another one."""
    of = mesh_of(mesh)
    words = Words([verb, "memory:mesh"], of, {"memory:mesh": of._handle})
    for name, value in options.items():
        words.add(name, value)
    return words


#: Keywords that take several values, one word each.
_LISTS = {"size", "set", "fields", "field", "intersect"}
#: Arguments of verbs that have another form in Python.
NOT_KEYWORDS = {"output", "format", "quiet", "flat", "help", "input", "solution"}


def plain(value: Any) -> Any:
    """Convert numpy numbers and arrays and paths for JSON."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"a {type(value).__name__} cannot be in a config")


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        value = value.item()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return str(value)


def _json(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, default=plain)


def _metric(words: Words, value: Any) -> str | None:
    if np.ndim(value) > 0 and not isinstance(value, (str, Mapping)):
        words.metrics["memory:metric.sol"] = np.asarray(value)
        return "memory:metric.sol"
    return None


def fields_in(value: Any) -> dict[str, np.ndarray]:
    """Return {name: array}; a single array gets the name u."""
    if isinstance(value, Mapping):
        return {str(name): np.asarray(field) for name, field in value.items()}
    return {"u": np.asarray(value)}


def _solution(words: Words, value: Any) -> str | None:
    if isinstance(value, (str, os.PathLike)):
        return None
    words.solutions["memory:solution.sol"] = fields_in(value)
    return "memory:solution.sol"


def _geometry(words: Words, value: Any) -> str | None:
    if not isinstance(value, (str, Mapping, os.PathLike)):
        words.meshes["memory:geometry"] = mesh_of(value)._handle
        return json.dumps({"mesh": "memory:geometry"})
    return None


def _intersect(words: Words, value: Any) -> str | None:
    if isinstance(value, (str, os.PathLike)):
        return None
    if np.ndim(value) == 0:
        value = np.full(len(words.mesh.vertices), float(value))
    words.metrics["memory:intersect.sol"] = np.asarray(value)
    return "memory:intersect.sol"


_IN_MEMORY = {"metric": _metric, "solution": _solution, "geometry": _geometry, "intersect": _intersect}


def solver_of(solve: Any) -> Any:
    """Wrap a solver for the extension; None stays None."""
    if solve is None:
        return None
    return lambda handle, guess, cycle: fields_in(solve(Mesh._of(handle), guess, cycle))
