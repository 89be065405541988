"""Conversion from and to meshes of Gmsh, meshio, PyVista, VTK, DOLFINx and scikit-fem, which are imported on use only."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from .exceptions import InputError, UsageError
from .mesh import DIMENSIONS, NODES, Mesh, _log, mesh_of

#: VTK's cell type numbers.
VTK_TYPES = {"line": 3, "triangle": 5, "tetra": 10, "line3": 21, "triangle6": 22, "tetra10": 24}
_OF_VTK = {number: name for name, number in VTK_TYPES.items()} | {1: "vertex", 2: "vertex"}
#: meshio's names of cell arrays in which programs store references.
_REFERENCES = ("reference", "gmsh:physical", "medit:ref", "cell_tags", "material")


def from_others(mesh: Any) -> Mesh:
    """Convert a mesh of meshio, PyVista or VTK, recognised by its attributes."""
    if hasattr(mesh, "GetCellTypesArray") or hasattr(mesh, "GetPolys"):
        return from_vtk(mesh)
    if hasattr(mesh, "cells") and hasattr(mesh, "point_data"):
        return from_meshio(mesh)
    raise UsageError(
        f"a {type(mesh).__name__} is no mesh",
        remedy="give a camber.Mesh, what a verb made, or a mesh of meshio's, PyVista's or VTK's",
    )


def _mesh_of_blocks(
    points: np.ndarray,
    blocks: Iterable[tuple[str, np.ndarray, np.ndarray | None]],
    names: Mapping[tuple[int, int], str] | None = None,
    fields: Mapping[str, np.ndarray] | None = None,
) -> Mesh:
    """Join blocks of the same type. Raises InputError for unsupported cell types."""
    cells: dict[str, list[np.ndarray]] = {}
    references: dict[str, list[np.ndarray]] = {}
    for name, rows, refs in blocks:
        if name in ("vertex", "point"):
            continue
        if name not in DIMENSIONS:
            raise InputError("is a type of cells that Camber does not hold", name, remedy="split them into simplices")
        cells.setdefault(name, []).append(np.asarray(rows))
        references.setdefault(name, []).append(
            np.zeros(len(rows), np.int32) if refs is None else _whole(name, refs)
        )
    has_tetrahedra = any(DIMENSIONS[name] == 3 for name in cells)
    if points.shape[1] == 3 and not has_tetrahedra and len(points) and np.all(points[:, 2] == 0.0):
        points = np.ascontiguousarray(points[:, :2])
    mesh = Mesh(
        points,
        {name: np.concatenate(rows) for name, rows in cells.items()},
        {name: np.concatenate(rows) for name, rows in references.items()},
        names,
    )
    kept: dict[str, np.ndarray] = {}
    for name, values in (fields or {}).items():
        if name.startswith(("gmsh:", "medit:")) or name in _REFERENCES:
            continue  # data of the file format, not a solution
        field = _of_plane(values, mesh.dimension)
        if field is None:
            _log.warning("the field %s is left out: %s of shape %s", name, values.dtype, values.shape)
        else:
            kept[name] = mesh._in_order(field, len(points))
    return mesh.with_fields(kept) if kept else mesh


def _whole(name: str, references: Any) -> np.ndarray:
    """Return integers; floats with integer values are accepted, since VTK programs write them."""
    array = np.asarray(references).ravel()
    if array.dtype.kind == "f" and np.all(array == np.round(array)):
        array = array.astype(np.int64)
    if array.dtype.kind not in "iu":
        raise InputError(f"has references of {array.dtype}", name, remedy="give whole numbers")
    return array


def _of_plane(values: np.ndarray, dimension: int) -> np.ndarray | None:
    values = np.asarray(values)
    if values.dtype.kind not in "fiu":
        return None
    if values.ndim == 1:
        return values.astype(float)
    if values.ndim == 2 and values.shape[1] in (1, dimension):
        return values.astype(float)
    if values.ndim == 2 and values.shape[1] == 3 and dimension == 2:
        return values[:, :2].astype(float)
    if values.ndim == 3 and values.shape[1:] == (dimension, dimension):
        return values.astype(float)
    if values.ndim == 2 and values.shape[1] == 9:
        return values.reshape(-1, 3, 3)[:, :dimension, :dimension].astype(float)
    if values.ndim == 2 and values.shape[1] == 4 and dimension == 2:
        return values.reshape(-1, 2, 2).astype(float)
    if values.ndim == 2 and values.shape[1] == 6 and dimension == 3:  # VTK's xx, yy, zz, xy, yz, xz
        return values[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3).astype(float)
    return None


# ---------------------------------------------------------------- meshio


def from_meshio(mesh: Any) -> Mesh:
    """Convert a meshio.Mesh: references from its cell data (gmsh:physical, medit:ref, reference), names from its field data."""
    data = next((mesh.cell_data[name] for name in _REFERENCES if name in mesh.cell_data), None)
    blocks = [
        (block.type, block.data, None if data is None else data[i]) for i, block in enumerate(mesh.cells)
    ]
    names = {(int(v[1]), int(v[0])): name for name, v in mesh.field_data.items() if np.size(v) == 2}
    return _mesh_of_blocks(np.asarray(mesh.points, float), blocks, names, mesh.point_data)


def to_meshio(mesh: Any) -> Any:
    """Return a meshio.Mesh with references as cell data `reference`, names as field data, and the fields."""
    import meshio

    of = mesh_of(mesh)
    return meshio.Mesh(
        of.points if of.z is None else in_space(of.points, of.z),
        [(name, rows.astype(np.int64)) for name, rows in of.cells.items()],
        point_data=_at_points(of),
        # Also under the names that meshio's writers for Gmsh and Medit expect.
        cell_data={
            key: [of.references[name] for name in of.cells]
            for key in ("reference", "gmsh:physical", "gmsh:geometrical", "medit:ref")
        },
        field_data={name: np.array([reference, d]) for (d, reference), name in of.names.items()},
    )


def _at_points(mesh: Mesh) -> dict[str, np.ndarray]:
    """Return fields with a row for each point; tensors are flattened."""
    out = {}
    for name, values in mesh.fields.items():
        if len(values) == len(mesh.points):
            out[name] = values.reshape(len(values), -1) if values.ndim == 3 else values
    return out


# ---------------------------------------------------------------- Gmsh

#: Gmsh's cell type numbers; the last two nodes of its quadratic tetrahedra are swapped.
_OF_GMSH = {1: "line", 2: "triangle", 4: "tetra", 8: "line3", 9: "triangle6", 11: "tetra10"}


def from_gmsh(model: Any) -> Mesh:
    """Convert the mesh of Gmsh's current model, `gmsh.model`. References are the tags of physical groups, or of entities
    in dimensions without groups. In other dimensions entities without a group are omitted, as in Gmsh."""
    tags, coordinates, _ = model.mesh.getNodes()
    row = np.full(int(tags.max()) + 1 if len(tags) else 1, -1, np.int64)
    blocks, used, names = [], np.zeros(len(tags), bool), {}
    row[tags.astype(np.int64)] = np.arange(len(tags))
    grouped = {d: bool(model.getPhysicalGroups(d)) for d in range(4)}
    for d, group in model.getPhysicalGroups():
        if name := model.getPhysicalName(d, group):
            names[d, int(group)] = name
    for d, entity in model.getEntities():
        groups = model.getPhysicalGroupsForEntity(d, entity)
        if d == 0 or (grouped[d] and len(groups) == 0):
            continue
        if len(groups) > 1:
            _log.warning("entity %d of dimension %d is in %d physical groups: the first is taken", entity, d, len(groups))
        reference = int(groups[0]) if len(groups) else entity
        for kind, _, nodes in zip(*model.mesh.getElements(d, entity)):
            name = _OF_GMSH.get(int(kind))
            if name is None:
                raise InputError(f"Gmsh's elements of type {kind} are not held", remedy="split them into simplices")
            rows = row[nodes.astype(np.int64)].reshape(-1, NODES[name])
            if name == "tetra10":
                rows = rows[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]
            used[rows.ravel()] = True
            blocks.append((name, rows, np.full(len(rows), reference, np.int32)))
    number = np.cumsum(used) - 1
    points = coordinates.reshape(-1, 3)[used]
    return _mesh_of_blocks(points, [(name, number[rows], refs) for name, rows, refs in blocks], names)


# ---------------------------------------------------------------- VTK, PyVista


def in_space(points: np.ndarray, z: float | None = None) -> np.ndarray:
    """Return points as (n, 3)."""
    if points.shape[1] == 3:
        return np.array(points)
    return np.column_stack([points, np.full(len(points), z or 0.0)])


def to_vtk(mesh: Any) -> Any:
    """Return a vtkUnstructuredGrid (quadratic cells for degree 2) with the fields as point data and cell data `reference`."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid

    of = mesh_of(mesh)
    cells = list(of.cells.items())
    connectivity = np.concatenate([rows.ravel() for _, rows in cells] or [np.empty(0)]).astype(np.int64)
    counts = np.concatenate([np.full(len(rows), rows.shape[1]) for _, rows in cells] or [np.empty(0, int)])
    types = np.concatenate([np.full(len(rows), VTK_TYPES[name]) for name, rows in cells] or [np.empty(0)])
    grid = vtkUnstructuredGrid()
    points = vtkPoints()
    points.SetData(numpy_to_vtk(in_space(of.points, of.z), deep=True))
    grid.SetPoints(points)
    array = vtkCellArray()
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    array.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(connectivity, deep=True))
    grid.SetCells(numpy_to_vtk(types.astype(np.uint8), deep=True), array)
    references = np.concatenate([of.references[name] for name, _ in cells] or [np.empty(0, np.int32)])
    _add_array(grid.GetCellData(), "reference", references)
    for name, values in _at_points(of).items():
        _add_array(grid.GetPointData(), name, values)
    return grid


def _add_array(data: Any, name: str, values: np.ndarray) -> None:
    from vtkmodules.util.numpy_support import numpy_to_vtk

    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    data.AddArray(array)


def from_vtk(grid: Any) -> Mesh:
    """Convert a vtkUnstructuredGrid or the triangles of a vtkPolyData (also PyVista's), with references from cell data."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    if hasattr(grid, "GetPolys"):
        return _of_polydata(grid)
    if grid.GetPoints() is None or grid.GetNumberOfCells() == 0:
        raise InputError("has no cells", "the grid")
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
    types = vtk_to_numpy(grid.GetCellTypesArray())
    offsets = vtk_to_numpy(grid.GetCells().GetOffsetsArray())
    connectivity = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    data = grid.GetCellData()
    found = next((data.GetArray(name) for name in _REFERENCES if data.HasArray(name)), None)
    references = None if found is None else vtk_to_numpy(found)
    blocks = []
    for number in np.unique(types):
        name = _OF_VTK.get(int(number), f"VTK's type {number}")
        which = np.flatnonzero(types == number)
        if name == "vertex":
            continue
        size = int(offsets[which[0] + 1] - offsets[which[0]])
        rows = connectivity[offsets[which][:, None] + np.arange(size)]
        blocks.append((name, rows, None if references is None else references[which]))
    return _mesh_of_blocks(points, blocks, fields=_point_data(grid))


def _point_data(grid: Any) -> dict[str, np.ndarray]:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    data = grid.GetPointData()
    arrays = [(data.GetArrayName(i), data.GetArray(i)) for i in range(data.GetNumberOfArrays())]
    return {name: vtk_to_numpy(array) for name, array in arrays if array is not None}


def _of_polydata(data: Any) -> Mesh:
    """Convert the triangles of a vtkPolyData or pyvista.PolyData."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    polygons = data.GetPolys()
    offsets = vtk_to_numpy(polygons.GetOffsetsArray())
    if data.GetPoints() is None or len(offsets) < 2:
        raise InputError("has no triangles", "the surface")
    if np.any(np.diff(offsets) != 3):
        raise InputError("has polygons that are no triangles", "the surface", remedy="vtkTriangleFilter splits them")
    triangles = vtk_to_numpy(polygons.GetConnectivityArray()).reshape(-1, 3)
    found = next((data.GetCellData().GetArray(n) for n in _REFERENCES if data.GetCellData().HasArray(n)), None)
    references = None if found is None or data.GetNumberOfCells() != len(triangles) else vtk_to_numpy(found)
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    return _mesh_of_blocks(points, [("triangle", triangles, references)], fields=_point_data(data))


def from_pyvista(grid: Any) -> Mesh:
    """Convert a pyvista.UnstructuredGrid or PolyData."""
    return from_vtk(grid)


def to_pyvista(mesh: Any) -> Any:
    """Return a pyvista.UnstructuredGrid: `camber.to_pyvista(mesh).plot(nonlinear_subdivision=3)` draws curved edges."""
    import pyvista

    return pyvista.wrap(to_vtk(mesh))


# ---------------------------------------------------------------- scikit-fem


def _elements_of(mesh: Mesh) -> str:
    """Return the type of a mesh's elements."""
    for name in mesh.cells:
        if DIMENSIONS[name] == mesh.dimension:
            return name
    raise UsageError("is a surface alone, without elements in the volume", "mesh")


def to_skfem(mesh: Any) -> Any:
    """Return a skfem.MeshTri, MeshTri2, MeshTet or MeshTet2, with named subdomains and boundaries."""
    import skfem

    of = mesh_of(mesh)
    d = of.dimension
    kind = {(2, 1): "MeshTri1", (2, 2): "MeshTri2", (3, 1): "MeshTet1", (3, 2): "MeshTet2"}[d, of.degree]
    element = _elements_of(of)
    made = getattr(skfem, kind)(of.points.T.copy(), of.cells[element].T.astype(np.int64))
    named = {r: name for (dim, r), name in of.names.items() if dim == d}
    subdomains = {name: np.flatnonzero(of.references[element] == r) for r, name in named.items()}
    if subdomains:
        made = made.with_subdomains(subdomains)
    boundaries = _boundaries(of, made)
    return made.with_boundaries(boundaries) if boundaries else made


def _boundaries(of: Mesh, made: Any) -> dict[str, np.ndarray]:
    """Return scikit-fem's facets by the name of their reference."""
    d = of.dimension
    facet = next((name for name in of.corners if DIMENSIONS[name] == d - 1), None)
    named = {r: name for (dim, r), name in of.names.items() if dim == d - 1}
    if facet is None or not named:
        return {}
    number = {tuple(sorted(rows)): i for i, rows in enumerate(made.facets.T.tolist())}
    rows = [number.get(tuple(sorted(vertices))) for vertices in of.corners[facet].tolist()]
    out: dict[str, list[int]] = {name: [] for name in named.values()}
    for row, reference in zip(rows, of.references[facet].tolist()):
        if row is not None and reference in named:
            out[named[reference]].append(row)
    return {name: np.array(found, np.int64) for name, found in out.items()}


# ---------------------------------------------------------------- DOLFINx


def to_dolfinx(mesh: Any, comm: Any = None) -> tuple[Any, Any, Any]:
    """Return a dolfinx.mesh.Mesh of the mesh's degree, and meshtags with the references of cells and facets.

    The mesh of rank 0 of comm is used (default: MPI.COMM_WORLD). Facet tags are None if there are no facets.
    """
    import dolfinx.mesh
    from mpi4py import MPI

    of = mesh_of(mesh)
    comm = MPI.COMM_WORLD if comm is None else comm
    element = _elements_of(of)
    facet = next((name for name in of.cells if DIMENSIONS[name] == of.dimension - 1), None)
    is_root = comm.rank == 0
    cells = _in_dolfinx_order(of.cells[element], element)
    points = of.points
    made = _create_dolfinx(
        comm, cells if is_root else cells[:0], points if is_root else points[:0], of.dimension, of.degree
    )
    cell_tags = _dolfinx_tags(made, of.dimension, cells, of.references[element], is_root)
    facet_tags = None
    if facet is not None:
        rows = _in_dolfinx_order(of.cells[facet], facet)
        facet_tags = _dolfinx_tags(made, of.dimension - 1, rows, of.references[facet], is_root)
    return made, cell_tags, facet_tags


_DOLFINX_CELLS = {1: "interval", 2: "triangle", 3: "tetrahedron"}


def _in_dolfinx_order(rows: np.ndarray, name: str) -> np.ndarray:
    import dolfinx.cpp

    cell = dolfinx.cpp.mesh.to_type(_DOLFINX_CELLS[DIMENSIONS[name]])
    order = dolfinx.cpp.io.perm_vtk(cell, rows.shape[1])
    return np.ascontiguousarray(rows[:, order].astype(np.int64))


def _create_dolfinx(comm: Any, cells: np.ndarray, points: np.ndarray, dimension: int, degree: int) -> Any:
    import inspect

    import dolfinx.mesh
    import ufl

    cell = _DOLFINX_CELLS[dimension]
    try:
        import basix.ufl

        element = basix.ufl.element("Lagrange", cell, degree, shape=(dimension,))
    except ImportError:  # before 0.7
        element = ufl.VectorElement("Lagrange", ufl.Cell(cell, geometric_dimension=dimension), degree)
    names = inspect.signature(dolfinx.mesh.create_mesh).parameters
    domain = {"domain": ufl.Mesh(element)} if "domain" in names else {"e": ufl.Mesh(element)}
    return dolfinx.mesh.create_mesh(comm, cells=cells, x=np.array(points), **domain)


def _dolfinx_tags(made: Any, dimension: int, rows: np.ndarray, references: np.ndarray, is_root: bool) -> Any:
    import dolfinx.cpp
    import dolfinx.graph
    import dolfinx.io
    import dolfinx.mesh

    rows, values = (rows, references) if is_root else (rows[:0], references[:0])
    values = np.array(values, np.int32)
    try:
        entities, values = dolfinx.io.distribute_entity_data(made, dimension, rows, values)
    except TypeError:  # before 0.7, which needs the C++ mesh
        entities, values = dolfinx.cpp.io.distribute_entity_data(made._mesh, dimension, rows, values)
    made.topology.create_connectivity(dimension, 0)
    try:
        adjacency = dolfinx.graph.adjacencylist(entities)
    except AttributeError:
        adjacency = dolfinx.cpp.graph.AdjacencyList_int32(entities)
    return dolfinx.mesh.meshtags_from_entities(made, dimension, adjacency, values.astype(np.int32))
