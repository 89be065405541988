"""Pictures of meshes: pages in notebooks, 2D plots with matplotlib, 3D pictures with VTK, all with curved edges."""

from __future__ import annotations

import html
from itertools import combinations
from typing import Any

import numpy as np

from .exceptions import Error, UsageError
from .exchange import in_space
from .mesh import Mesh, mesh_of


#: Maximum number of elements for a page in a notebook; a page needs about 40 bytes for each boundary triangle.
IN_NOTEBOOK = 200_000


def in_notebook(mesh: Mesh, height: int = 520) -> str:
    """Return the page of `camber report` in a frame, or the text of `repr` if there is no page."""
    if len(mesh.elements) > IN_NOTEBOOK:
        return f"<pre>{html.escape(repr(mesh))}\nlarge for a notebook: Mesh.page() is its page</pre>"
    try:
        page = mesh.page()
    except Error as error:
        return f"<pre>{html.escape(repr(mesh))}\n{html.escape(str(error))}</pre>"
    return f'<iframe srcdoc="{html.escape(page)}" width="100%" height="{height}" style="border:0"></iframe>'


def plot(mesh: Any, **options: Any) -> Any:
    """Draw with `plot_2d` (returns matplotlib axes) or `picture_3d` (returns an array)."""
    of = mesh_of(mesh)
    return plot_2d(of, **options) if of.dimension == 2 else picture_3d(of, **options)


def edge_curves(mesh: Any, n: int = 8) -> np.ndarray:
    """Return (e, n + 1, D): points along each edge, on the curve x(t) = Σ φ_i(t) x_i."""
    of = mesh_of(mesh)
    if of.degree == 2:
        return _along(of.vertices[of.edges[:, 0]], of.vertices[of.edges[:, 1]], of.mid_nodes, n)
    pairs = [of.elements[:, [i, j]] for i, j in combinations(range(of.elements.shape[1]), 2)]
    ends = of.vertices[np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)]
    return _along(ends[:, 0], ends[:, 1], 0.5 * (ends[:, 0] + ends[:, 1]), n)


def _along(a: np.ndarray, b: np.ndarray, middle: np.ndarray, n: int) -> np.ndarray:
    t = np.linspace(0, 1, n + 1)
    shapes = np.stack([(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)])
    return np.einsum("it,ied->etd", shapes, np.stack([a, b, middle]))


#: Faces of a tetrahedron in VTK's order: corners, then nodes of edges.
_FACES = ((0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 3, 2, 7, 9, 6))


def _drawn(of: Mesh) -> np.ndarray:
    """Return (m, 3) or (m, 6): rows of points of the drawn triangles (those of the mesh, else the boundary of its elements)."""
    for name in ("triangle6", "triangle"):
        if name in of.cells:
            return of.cells[name].astype(np.int64)
    for name in ("tetra10", "tetra"):
        if name in of.cells:
            size = 6 if name == "tetra10" else 3
            faces = np.concatenate([of.cells[name][:, face[:size]] for face in _FACES]).astype(np.int64)
            _, first, count = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
            return faces[first[count == 1]]
    raise UsageError("has no triangles to draw", "mesh")


def subdivided(mesh: Any, n: int, values: Any = None) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Divide quadratic triangles into n² flat ones: points (p, D), triangles (q, 3), values at the points (p,).

    values: at the vertices (v,) or at the nodes (n,).
    """
    of = mesh_of(mesh)
    rows = _drawn(of)
    values = None if values is None else _checked(values, of)
    if rows.shape[1] == 3:
        return np.array(of.points), rows, values
    grid = [(i, j) for i in range(n + 1) for j in range(n + 1 - i)]
    number = {place: k for k, place in enumerate(grid)}
    r, s = np.array(grid, float).T / n
    o = 1 - r - s
    shapes = np.stack([o * (2 * o - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * o * r, 4 * r * s, 4 * s * o])
    small = [(number[i, j], number[i + 1, j], number[i, j + 1]) for i, j in grid if i + j < n]
    small += [(number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]) for i, j in grid if i + j < n - 1]
    points = np.einsum("kp,mkd->mpd", shapes, of.points[rows]).reshape(-1, of.dimension)
    offsets = np.arange(len(rows))[:, None, None] * len(grid)
    triangles = (offsets + np.array(small)[None]).reshape(-1, 3)
    if values is None:
        return points, triangles, None
    if len(values) == len(of.points):
        return points, triangles, np.einsum("kp,mk->mp", shapes, values[rows]).ravel()
    return points, triangles, np.einsum("kp,mk->mp", np.stack([o, r, s]), values[rows[:, :3]]).ravel()


def _checked(values: Any, of: Mesh) -> np.ndarray:
    array = np.asarray(values, float)
    if array.ndim != 1 or len(array) not in (len(of.vertices), len(of.points)):
        wanted = f"({len(of.vertices)},), a row a vertex"
        wanted += f", or ({len(of.points)},), a row a node" if of.degree == 2 else ""
        raise UsageError(f"has the shape {array.shape}", "values", remedy="give " + wanted)
    return array


def plot_2d(
    mesh: Any, values: np.ndarray | None = None, *, ax: Any = None, n: int = 8, cmap: str = "viridis", **lines: Any
) -> Any:
    """Draw a 2D mesh with its curved edges, and optionally a field, with matplotlib; returns the axes.

    values: (v,) at the vertices or (n,) at the nodes. n: line segments for each edge. lines: options of LineCollection.
    """
    from matplotlib import pyplot
    from matplotlib.collections import LineCollection

    of = mesh_of(mesh)
    if of.dimension != 2:
        raise UsageError("is in 3D", "mesh", remedy="camber.plots.picture_3d draws it")
    ax = pyplot.gca() if ax is None else ax
    if values is not None:
        points, triangles, colours = subdivided(of, n, values)
        drawn = ax.tripcolor(points[:, 0], points[:, 1], triangles, colours, shading="gouraud", cmap=cmap)
        ax.figure.colorbar(drawn, ax=ax)
    style = {"linewidths": 0.6, "colors": "0.2"} | lines
    ax.add_collection(LineCollection(edge_curves(of, n), **style))
    ax.autoscale_view()
    ax.set_aspect("equal")
    return ax


def surface(mesh: Any, values: np.ndarray | None = None, n: int = 4) -> Any:
    """Return the faces as a vtkPolyData, quadratic ones as n² flat triangles; values at vertices or nodes become scalars."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    points, triangles, colours = subdivided(mesh, n, values)
    data = vtkPolyData()
    data.SetPoints(_vtk_points(in_space(points)))
    data.SetPolys(_vtk_cells(triangles))
    if colours is not None:
        data.GetPointData().SetScalars(numpy_to_vtk(colours, deep=True))
    return data


def edge_lines(mesh: Any, n: int = 8) -> Any:
    """Return the curved edges of the faces as a vtkPolyData of lines of n segments."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    curves = _face_curves(mesh_of(mesh), n)
    count, length, _ = curves.shape
    data = vtkPolyData()
    data.SetPoints(_vtk_points(in_space(curves.reshape(count * length, -1))))
    data.SetLines(_vtk_cells(np.arange(count * length).reshape(count, length)))
    return data


def picture_3d(
    mesh: Any,
    values: np.ndarray | None = None,
    *,
    n: int = 4,
    size: tuple[int, int] = (900, 700),
    view: tuple[float, float, float] = (1.0, -1.6, 0.9),
) -> np.ndarray:
    """Return (height, width, 3) bytes: faces and edges of a 3D mesh in direction `view`, drawn by VTK without a window.

    Debian's VTK needs an X server even without a window; raises UsageError if there is none.
    """
    import os

    if "DISPLAY" not in os.environ:
        raise UsageError(
            "VTK draws on an X server, and there is none",
            "DISPLAY",
            remedy="run it by xvfb-run, look at Mesh.page(), or use camber picture",
        )
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401

    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(_faces_actor(surface(mesh, values, n)))
    renderer.AddActor(_edges_actor(edge_lines(mesh, 2 * n)))
    camera = renderer.GetActiveCamera()
    camera.SetPosition(*view)
    camera.SetViewUp(0, 0, 1)
    renderer.ResetCamera()
    camera.Zoom(1.5)
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.Update()
    image = grab.GetOutput()
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[::-1, :, :3].copy()


def _vtk_points(points: np.ndarray) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints

    made = vtkPoints()
    made.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    return made


def _vtk_cells(rows: np.ndarray) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    made = vtkCellArray()
    offsets = np.arange(0, rows.size + 1, rows.shape[1], dtype=np.int64)
    connectivity = np.ascontiguousarray(rows.ravel(), np.int64)
    made.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(connectivity, deep=True))
    return made


def _faces_actor(data: Any) -> Any:
    from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    normals = vtkPolyDataNormals()
    normals.SetInputData(data)
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(normals.GetOutputPort())
    if data.GetPointData().GetScalars() is not None:
        mapper.SetLookupTable(_viridis(*data.GetPointData().GetScalars().GetRange()))
        mapper.UseLookupTableScalarRangeOn()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.55, 0.68, 0.82)
    return actor


def _viridis(low: float, high: float) -> Any:
    """Return matplotlib's colour map of this name, from five of its colours."""
    from vtkmodules.vtkRenderingCore import vtkColorTransferFunction

    colours = vtkColorTransferFunction()
    of = ((0.27, 0.0, 0.33), (0.23, 0.32, 0.55), (0.13, 0.57, 0.55), (0.37, 0.79, 0.38), (0.99, 0.91, 0.14))
    for share, rgb in zip(np.linspace(low, high, len(of)), of):
        colours.AddRGBPoint(float(share), *rgb)
    return colours


def _edges_actor(data: Any) -> Any:
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0, -4)
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.1, 0.15, 0.2)
    actor.GetProperty().SetLineWidth(1.2)
    return actor


def _face_curves(of: Mesh, n: int) -> np.ndarray:
    rows = _drawn(of)
    sides = [(0, 1), (1, 2), (2, 0)]
    ends = np.concatenate([rows[:, side] for side in sides])
    _, first = np.unique(np.sort(ends, axis=1), axis=0, return_index=True)
    a, b = of.points[ends[first, 0]], of.points[ends[first, 1]]
    if rows.shape[1] == 3:
        return np.stack([a, b], axis=1)
    return _along(a, b, of.points[np.concatenate([rows[:, 3 + k] for k in range(3)])[first]], n)
