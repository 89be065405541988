"""What verbs give back."""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .exceptions import NotCertified, in_python
from .mesh import Mesh, _log


@dataclass(frozen=True, eq=False)
class Made:
    """A mesh that was made, and what is known of how. Verbs take it where they take a mesh."""

    mesh: Mesh
    report: dict[str, Any] = field(repr=False)  #: the figures of `--report`: docs/report.md
    metric: np.ndarray | None = field(repr=False)  #: (v,) or (v, D, D): at the vertices, where one was made
    solution: dict[str, np.ndarray] = field(repr=False)  #: the fields that went along, on this mesh
    success: bool = True  #: whether the mesh is the requested one; if not, report["misses"] says why
    cycles: list[dict[str, Any]] = field(default_factory=list, repr=False)  #: of `adapt`: a row a cycle
    reason: str = ""  #: of `adapt`: why it ended before its number of cycles

    def __getattr__(self, name: str) -> Any:
        if name == "holds":
            raise AttributeError("holds was renamed to success")
        raise AttributeError(f"{type(self).__name__} has no attribute {name}")

    def _repr_html_(self) -> str:
        return self.mesh._repr_html_()

    def plot(self, **options: Any) -> Any:
        """Draw its mesh: `camber.plots.plot`."""
        return self.mesh.plot(**options)


def made_of(raw: Mapping[str, Any]) -> Made:
    for notice in raw["notices"]:
        _log.info("%s", in_python(notice))
    report = json.loads(raw["report"])
    if not raw["success"]:
        warnings.warn("; ".join(report["misses"]), NotCertified, stacklevel=_outside())
    solution = raw["solution"]
    cycles = json.loads(raw["cycles"]) if "cycles" in raw else []
    return Made(
        Mesh._of(raw["mesh"]),
        report,
        raw["metric"],
        solution,
        raw["success"],
        cycles["cycles"] if isinstance(cycles, dict) and "cycles" in cycles else cycles,
        in_python(raw.get("reason", "")),
    )


def _outside() -> int:
    """How many frames up, for `warnings`, the caller is who is not this package."""
    level, frame = 2, sys._getframe(2)
    while frame is not None and frame.f_globals.get("__name__", "").split(".")[0] == "camber":
        level, frame = level + 1, frame.f_back
    return level


def mesh_of(mesh: Any) -> Mesh:
    """The mesh of what a verb was given."""
    if isinstance(mesh, Made):
        return mesh.mesh
    if isinstance(mesh, Mesh):
        return mesh
    from .exchange import from_others

    return from_others(mesh)
