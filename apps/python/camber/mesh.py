"""Meshes as arrays, and results of verbs."""

from __future__ import annotations

import json
import logging
import sys
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from . import _camber
from .exceptions import InputError, NotCertified, UsageError, in_python

_log = logging.getLogger("camber")

#: Number of nodes by meshio's name of the cell type.
NODES = {"line": 2, "triangle": 3, "tetra": 4, "line3": 3, "triangle6": 6, "tetra10": 10}
DIMENSIONS = {"line": 1, "triangle": 2, "tetra": 3, "line3": 1, "triangle6": 2, "tetra10": 3}


class Mesh:
    """An immutable mesh of triangles or tetrahedra, of degree 1 or 2. Verbs return new meshes.

    points : (n, 2) or (n, 3) floats: the vertices and, for degree 2, the nodes of edges, in any order. A read-only array
        (`array.flags.writeable = False`) is shared; others are copied once.
    cells : {type: (m, k) ints} by meshio's names "triangle", "tetra", "line" or "triangle6", "tetra10", "line3". Nodes are
        rows of points, from 0, in VTK's order. Cells of the points' dimension are elements, those of one dimension less
        are facets of the boundary or of interfaces; lines in 3D are feature edges.
    references : {type: (m,) ints}: materials of elements, surfaces of facets; also "vertex". Default: 0.
    names : {(dimension, reference): name}, Gmsh's physical groups.
    fields : {name: (n,), (n, D) or (n, D, D) floats} at the points, for `write` and for verbs that transfer fields.
    flat : meaning of triangles that all have the same z: "plane", a 2D mesh, which is written with its z again;
        "surface", a surface in space.

    Raises InputError for an invalid shape or node.
    """

    def __init__(
        self,
        points: Any,
        cells: Mapping[str, Any],
        references: Mapping[str, Any] | None = None,
        names: Mapping[tuple[int, int], str] | None = None,
        fields: Mapping[str, Any] | None = None,
        flat: Literal["plane", "surface"] = "plane",
    ) -> None:
        points = _floats(points)
        if flat not in ("plane", "surface"):
            raise UsageError(f'is "{flat}"', "flat", remedy='give "plane" or "surface"')
        given = _blocks(cells)
        for name in given:
            if name in DIMENSIONS and DIMENSIONS[name] > points.shape[1]:
                raise InputError(f"are of dimension {DIMENSIONS[name]}, the points of {points.shape[1]}", name)
        nodes = {name: _nodes(name, rows, len(points)) for name, rows in given.items()}
        refs = {name: _references(name, rows, nodes, len(points)) for name, rows in (references or {}).items()}
        handle = _camber.Mesh.from_arrays(points, nodes, refs, _groups(names or {}), flat == "plane")
        self._handle = handle
        if fields:
            here = {str(name): self._in_order(np.asarray(values), len(points)) for name, values in fields.items()}
            self._handle = handle.with_fields(here)
        _tell(self)

    def _in_order(self, values: np.ndarray, points: int) -> np.ndarray:
        """Reorder rows of input points to rows of mesh points. A node without an input point gets the mean of its edge's
        ends. Vectors of a flat mesh lose their z."""
        if values.ndim == 2 and values.shape[1] == 3 and self.dimension == 2:
            values = values[:, :2]
        if self.degree == 1 or len(values) != points:
            return values
        rows = self.node_rows
        ordered = values[rows]
        if (rows < 0).any():
            lacking = np.flatnonzero(rows < 0)
            ordered[lacking] = 0.5 * ordered[self.edges[lacking - len(self.vertices)]].sum(axis=1)
        return ordered

    @classmethod
    def _of(cls, handle: _camber.Mesh) -> Mesh:
        mesh = cls.__new__(cls)
        mesh._handle = handle
        return mesh

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self._handle.dimension

    @property
    def degree(self) -> int:
        """1: straight; 2: each edge has a node on its curve."""
        return self._handle.degree

    @cached_property
    def points(self) -> np.ndarray:
        """(n, D): vertices, then for degree 2 the nodes of `edges`. Read-only; for degree 1 a view of the mesh."""
        return self._handle.points

    @cached_property
    def vertices(self) -> np.ndarray:
        """(v, D): the corners of elements. Read-only view."""
        return self._handle.vertices

    @cached_property
    def mid_nodes(self) -> np.ndarray | None:
        """(e, D): for degree 2 the node of each edge, on its curve. Read-only view."""
        return self._handle.mid_nodes

    @cached_property
    def node_rows(self) -> np.ndarray:
        """(n,): input row of each of `points`, -1: none. It differs from 0, 1, 2 … if the vertices of a quadratic input were
        not first: `u[mesh.node_rows]` converts a field of the input."""
        return self._handle.given_rows

    @cached_property
    def edges(self) -> np.ndarray | None:
        """(e, 2): for degree 2 the ends of each edge, the lower first. Read-only."""
        return self._handle.edges

    @cached_property
    def cells(self) -> Mapping[str, np.ndarray]:
        """{type: (m, k)}: rows of `points` for each cell, in VTK's order; elements first. Read-only."""
        return MappingProxyType(self._handle.cells)

    @cached_property
    def corners(self) -> Mapping[str, np.ndarray]:
        """{type: (m, d + 1)}: rows of `vertices` for each cell. Read-only view."""
        return MappingProxyType(self._handle.corners)

    @cached_property
    def references(self) -> Mapping[str, np.ndarray]:
        """{type: (m,)}: the reference of each cell and, as "vertex", of each vertex. Read-only view."""
        return MappingProxyType(self._handle.references)

    @cached_property
    def names(self) -> Mapping[tuple[int, int], str]:
        """{(dimension, reference): name}. Simplices in several groups have the name of the first group."""
        return MappingProxyType({(d, r): name for d, r, name in reversed(self._handle.groups)})

    @cached_property
    def fields(self) -> Mapping[str, np.ndarray]:
        """{name: values} from the file or transferred by verbs; one row for each vertex, or for each node of degree 2."""
        return MappingProxyType(self._handle.fields())

    @property
    def z(self) -> float | None:
        """Height of a 2D mesh that was flat in space, else None."""
        return self._handle.z

    @property
    def notices(self) -> list[str]:
        """Messages from reading."""
        return [in_python(notice) for notice in self._handle.notices]

    @property
    def elements(self) -> np.ndarray:
        """(m, D + 1): rows of `vertices` for each element, or each triangle of a surface in space."""
        for kind in ("tetra10", "tetra", "triangle6", "triangle"):
            if kind in self.corners:
                return self.corners[kind]
        return np.empty((0, self.dimension + 1), np.uint32)

    def with_fields(self, fields: Mapping[str, Any] | None = None, /, **more: Any) -> Mesh:
        """Return the mesh with only these fields, {name: (n,), (n, D) or (n, D, D)}."""
        given = {**(fields or {}), **more}
        return Mesh._of(self._handle.with_fields({str(name): np.asarray(v) for name, v in given.items()}))

    def write(self, path: Any, format: str = "") -> None:
        """Write to a file, in the named format or that of the ending, with the fields if the format supports them."""
        from .files import write

        write(path, self, format=format)

    def page(self, title: str = "mesh") -> str:
        """Return the HTML page of `camber report`: interactive 3D view, the worst elements, the numbers."""
        return _camber.page(self._handle, dict(self.fields), title, None)

    def _repr_html_(self) -> str:
        from .plots import in_notebook

        return in_notebook(self)

    def plot(self, **options: Any) -> Any:
        """Draw the mesh: see `camber.plots.plot`."""
        from .plots import plot

        return plot(self, **options)

    def __reduce__(self) -> Any:
        return Mesh._of, (self._handle,)

    def __copy__(self) -> Mesh:
        return self

    def __deepcopy__(self, memo: Any) -> Mesh:
        return self

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Mesh) and self._handle == other._handle

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        cells = ", ".join(f"{len(rows)} {name}" for name, rows in self.corners.items())
        return f"<camber.Mesh in {self.dimension}D, degree {self.degree}: {len(self.vertices)} vertices, {cells}>"


def _floats(points: Any) -> np.ndarray:
    array = np.asarray(points)
    if array.dtype != np.float64 or not array.flags.c_contiguous:
        array = np.ascontiguousarray(array, np.float64)
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise InputError(f"has the shape {array.shape}", "points", remedy="give (n, 2) or (n, 3)")
    return array


def _tell(mesh: Mesh) -> None:
    for notice in mesh.notices:
        _log.info("%s", notice)


def _blocks(cells: Any) -> dict[str, Any]:
    """Return {type: rows} from a mapping or meshio's list of blocks."""
    if isinstance(cells, Mapping):
        return dict(cells)
    joined: dict[str, list[np.ndarray]] = {}
    for block in cells:
        name, rows = (block.type, block.data) if hasattr(block, "type") else block
        joined.setdefault(name, []).append(np.asarray(rows))
    return {name: np.concatenate(rows) for name, rows in joined.items()}


def _groups(names: Mapping[tuple[int, int], str]) -> list[tuple[int, int, str]]:
    try:
        return [(int(d), int(r), str(name)) for (d, r), name in names.items()]
    except (TypeError, ValueError):
        raise InputError("are no {(dimension, reference): name}", "names") from None


def _references(name: str, rows: Any, cells: Mapping[str, np.ndarray], points: int) -> np.ndarray:
    if name != "vertex" and name not in cells:
        raise InputError("has references, and no cells", name)
    array = np.asarray(rows)
    if array.dtype.kind not in "iu" or array.ndim != 1:
        raise InputError(
            f"has references of {array.dtype} and shape {array.shape}", name, remedy="give (m,) whole numbers; names go into names"
        )
    if array.size and (array.min() < -(2**31) or array.max() >= 2**31):
        raise InputError("has a reference beyond 32 bits", name)
    if name == "vertex" and len(array) < points:
        array = _of_vertices(array, cells, points)
    return array.astype(np.int32, copy=False)


def _of_vertices(array: np.ndarray, cells: Mapping[str, np.ndarray], points: int) -> np.ndarray:
    """Extend references of the vertices of a quadratic mesh to all points; requires that the vertices come first."""
    corners = [rows[:, : DIMENSIONS[name] + 1].max(initial=0) for name, rows in cells.items()]
    if not any(NODES[name] > DIMENSIONS[name] + 1 for name in cells) or max(corners, default=0) >= len(array):
        raise InputError(f"are {len(array)} references of {points} points", "vertex", remedy="give one a point")
    return np.pad(array, (0, points - len(array)))


def _nodes(name: str, rows: Any, points: int) -> np.ndarray:
    if name not in NODES:
        raise InputError("is no type of cells that Camber knows", name, remedy="they are " + ", ".join(NODES))
    try:
        array = np.asarray(rows)
    except ValueError:
        raise InputError("has rows of several lengths", name, remedy=f"give (m, {NODES[name]})") from None
    if array.size == 0:
        return np.empty((0, NODES[name]), np.uint32)
    if array.ndim != 2 or array.shape[1] != NODES[name]:
        raise InputError(f"has the shape {array.shape}", name, remedy=f"give (m, {NODES[name]})")
    if array.dtype.kind not in "iu":
        raise InputError(f"are of {array.dtype} and no whole numbers", name)
    if array.dtype == np.uint32:
        return array
    wrong = (array < 0) | (array >= points)
    if wrong.any():
        row = int(np.argwhere(wrong.any(axis=1))[0, 0])
        raise InputError(f"has a node that is none of the {points} points", name, f"row {row}", "nodes count from 0")
    return array.astype(np.uint32)


@dataclass(frozen=True, eq=False)
class Made:
    """A mesh made by a verb, with its report. Verbs accept it in place of a mesh."""

    mesh: Mesh
    report: dict[str, Any] = field(repr=False)  #: content of `--report`: docs/report.md
    metric: np.ndarray | None = field(repr=False)  #: (v,) or (v, D, D) at the vertices, if the verb made one
    solution: dict[str, np.ndarray] = field(repr=False)  #: transferred fields, on this mesh
    success: bool = True  #: True if the mesh meets the request; otherwise see report["misses"]
    cycles: list[dict[str, Any]] = field(default_factory=list, repr=False)  #: of `adapt`: one row a cycle
    reason: str = ""  #: of `adapt`: reason for an early end

    def __getattr__(self, name: str) -> Any:
        if name == "holds":
            raise AttributeError("holds was renamed to success")
        raise AttributeError(f"{type(self).__name__} has no attribute {name}")

    def _repr_html_(self) -> str:
        return self.mesh._repr_html_()

    def plot(self, **options: Any) -> Any:
        """Draw the mesh: see `camber.plots.plot`."""
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
    """Return the stack level of the first caller outside of this package, for `warnings`."""
    level, frame = 2, sys._getframe(2)
    while frame is not None and frame.f_globals.get("__name__", "").split(".")[0] == "camber":
        level, frame = level + 1, frame.f_back
    return level


def mesh_of(mesh: Any) -> Mesh:
    """Return the mesh of a verb's argument."""
    if isinstance(mesh, Made):
        return mesh.mesh
    if isinstance(mesh, Mesh):
        return mesh
    from .exchange import from_others

    return from_others(mesh)
