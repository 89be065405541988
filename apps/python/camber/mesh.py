"""Meshes as arrays, and what verbs give back."""

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

#: Nodes of a cell, by the name that meshio has for its type.
NODES = {"line": 2, "triangle": 3, "tetra": 4, "line3": 3, "triangle6": 6, "tetra10": 10}
DIMENSIONS = {"line": 1, "triangle": 2, "tetra": 3, "line3": 1, "triangle6": 2, "tetra10": 3}


class Mesh:
    """A mesh of triangles or tetrahedra, of degree 1 or 2. It never changes: verbs make others.

    points : (n, 2) or (n, 3) floats, the vertices, and of degree 2 the nodes of edges among them. An array that nobody
        can write to (`array.flags.writeable = False`) is shared; any other is copied once.
    cells : {type: (m, k) ints} by meshio's names, "triangle", "tetra", "line" or "triangle6", "tetra10", "line3";
        nodes count the points from 0 and are in VTK's order. Cells of the points' dimension are elements, those of one
        less facets of the boundary or of interfaces; lines in 3D are feature edges.
    references : {type: (m,) ints}, the materials of elements, the surfaces of facets; also "vertex". Default: 0.
    names : {(dimension, reference): name}, Gmsh's physical groups.
    fields : {name: (n,), (n, D) or (n, D, D) floats} at the points, for `write` and for verbs that carry fields.
    flat : "plane": triangles of one z are a mesh in 2D, and are written with their z again; "surface": one in space.

    Raises InputError: a shape or a node that is wrong.
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
        """Rows of the points that were given as rows of those that are here; a node that was not given has the mean of
        its edge's ends. Of a flat mesh vectors lose their z."""
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
        """1: straight. 2: each edge has a node, on its curve."""
        return self._handle.degree

    @cached_property
    def points(self) -> np.ndarray:
        """(n, D): vertices, then of degree 2 the nodes of `edges`. Read-only; of degree 1 the mesh's own memory."""
        return self._handle.points

    @cached_property
    def vertices(self) -> np.ndarray:
        """(v, D): the corners of elements, the mesh's own memory. Read-only."""
        return self._handle.vertices

    @cached_property
    def mid_nodes(self) -> np.ndarray | None:
        """(e, D): of degree 2 the node of each edge, on the curve; the mesh's own memory. Read-only."""
        return self._handle.mid_nodes

    @cached_property
    def node_rows(self) -> np.ndarray:
        """(n,): of each of `points` the row that it was given as, -1: of none. Others than 0, 1, 2 … where a mesh of degree
        2 was given with its vertices not first: `u[mesh.node_rows]` is then a field here."""
        return self._handle.given_rows

    @cached_property
    def edges(self) -> np.ndarray | None:
        """(e, 2): of degree 2 the ends of each edge, the lower first. Read-only."""
        return self._handle.edges

    @cached_property
    def cells(self) -> Mapping[str, np.ndarray]:
        """{type: (m, k)}: rows of `points` of each cell, in VTK's order; elements first. Read-only."""
        return MappingProxyType(self._handle.cells)

    @cached_property
    def corners(self) -> Mapping[str, np.ndarray]:
        """{type: (m, d + 1)}: rows of `vertices` of each cell, the mesh's own memory. Read-only."""
        return MappingProxyType(self._handle.corners)

    @cached_property
    def references(self) -> Mapping[str, np.ndarray]:
        """{type: (m,)}: the reference of each cell and, as "vertex", of each vertex; the mesh's own memory. Read-only."""
        return MappingProxyType(self._handle.references)

    @cached_property
    def names(self) -> Mapping[tuple[int, int], str]:
        """{(dimension, reference): name}. Simplices in several groups have the name of the first."""
        return MappingProxyType({(d, r): name for d, r, name in reversed(self._handle.groups)})

    @cached_property
    def fields(self) -> Mapping[str, np.ndarray]:
        """{name: values}: those of the file, or those that were carried along; a row a vertex, or a node of degree 2."""
        return MappingProxyType(self._handle.fields())

    @property
    def z(self) -> float | None:
        """Of a mesh in 2D that was a flat one in space: its height."""
        return self._handle.z

    @property
    def notices(self) -> list[str]:
        """What is worth knowing of how it was read."""
        return [in_python(notice) for notice in self._handle.notices]

    @property
    def elements(self) -> np.ndarray:
        """(m, D + 1): rows of `vertices` of each element; of a surface alone in space of each triangle."""
        for kind in ("tetra10", "tetra", "triangle6", "triangle"):
            if kind in self.corners:
                return self.corners[kind]
        return np.empty((0, self.dimension + 1), np.uint32)

    def with_fields(self, fields: Mapping[str, Any] | None = None, /, **more: Any) -> Mesh:
        """The same mesh with these fields, {name: (n,), (n, D) or (n, D, D)}, and no others."""
        given = {**(fields or {}), **more}
        return Mesh._of(self._handle.with_fields({str(name): np.asarray(v) for name, v in given.items()}))

    def write(self, path: Any, format: str = "") -> None:
        """Write to a file, in the format of its ending or of that name, with the fields where that has a place."""
        from .files import write

        write(path, self, format=format)

    def page(self, title: str = "mesh") -> str:
        """The HTML page of `camber report`: the mesh to be turned, cut and coloured, the worst elements, the numbers."""
        return _camber.page(self._handle, dict(self.fields), title, None)

    def _repr_html_(self) -> str:
        from .plots import in_notebook

        return in_notebook(self)

    def plot(self, **options: Any) -> Any:
        """Draw it: `camber.plots.plot`."""
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
    """{type: rows} of that, or of meshio's list of blocks."""
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
    """References of the vertices of a mesh of degree 2 whose vertices come first: its edges' nodes have none."""
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
