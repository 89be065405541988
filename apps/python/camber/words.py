"""Keyword arguments as words of the command line, and what they name that is in memory."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .mesh import Mesh
from .result import Made, mesh_of


@dataclass
class Words:
    """A verb's words, and the values in memory that they name."""

    words: list[str]
    mesh: Mesh | None = None
    meshes: dict[str, Any] = field(default_factory=dict)
    metrics: dict[str, Any] = field(default_factory=dict)
    solutions: dict[str, Any] = field(default_factory=dict)

    def values(self) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        return self.meshes, self.metrics, self.solutions

    def add(self, name: str, value: Any) -> None:
        option = "--" + name.replace("_", "-")
        if value is None or value is False:
            return
        if value is True:
            self.words.append(option)
            return
        for text in self.texts(name, value):
            self.words.append(f"{option}={text}")

    def texts(self, name: str, value: Any) -> list[str]:
        if name in _IN_MEMORY:
            known = _IN_MEMORY[name](self, value)
            if known is not None:
                return [known]
        if name == "size" and isinstance(value, Mapping):
            return [f"{reference}={size!r}" for reference, size in value.items()]
        if name == "set" and isinstance(value, Mapping):
            return [f"{path}={_json(v)}" for path, v in value.items()]
        if isinstance(value, Mapping):
            return [json.dumps(value)]
        if isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str):
            return [_text(v) for v in value]
        return [_text(value)]


def words_of(verb: str, mesh: Any, options: Mapping[str, Any]) -> Words:
    """Words of a verb from a mesh to another one."""
    of = mesh_of(mesh)
    words = Words([verb, "memory:mesh"], of, {"memory:mesh": of._handle})
    for name, value in options.items():
        words.add(name, value)
    return words


def _text(value: Any) -> str:
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return str(value)


def _json(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def _metric(words: Words, value: Any) -> str | None:
    if isinstance(value, np.ndarray) and value.ndim > 0:
        words.metrics["memory:metric.sol"] = value
        return "memory:metric.sol"
    return None


def fields_in(value: Any) -> dict[str, np.ndarray]:
    """{name: array} of that, or of one array, which is called u."""
    if isinstance(value, Mapping):
        return {str(name): np.asarray(field, float) for name, field in value.items()}
    return {"u": np.asarray(value, float)}


def _solution(words: Words, value: Any) -> str | None:
    if isinstance(value, str):
        return None
    words.solutions["memory:solution.sol"] = fields_in(value)
    return "memory:solution.sol"


def _geometry(words: Words, value: Any) -> str | None:
    if isinstance(value, (Mesh, Made)):
        words.meshes["memory:geometry"] = mesh_of(value)._handle
        return json.dumps({"mesh": "memory:geometry"})
    return None


def _intersect(words: Words, value: Any) -> str | None:
    if not isinstance(value, np.ndarray):
        return None
    words.metrics["memory:intersect.sol"] = value
    return "memory:intersect.sol"


_IN_MEMORY = {"metric": _metric, "solution": _solution, "geometry": _geometry, "intersect": _intersect}
