"""Exchange of meshes with meshio and VTK; with PyVista and scikit-fem by stubs of their documented interfaces."""
import sys
import types
import unittest

import numpy as np

import shared
from shared import arrays, camber, shell, square


def named(mesh):
    return camber.Mesh(mesh.points, mesh.cells, mesh.references, {(mesh.dimension, 0): "domain"},
                       {"u": mesh.points[:, 0], "v": mesh.points})


def need(test, *modules):
    import importlib
    import os

    for name in modules:
        try:
            importlib.import_module(name)
        except ImportError:
            if os.environ.get("CAMBER_NO_SKIP"):
                raise
            test.skipTest(f"{name} is not installed")


class Meshio(unittest.TestCase):
    def test_meshes_converted_to_meshio_and_back_are_equal(self):
        need(self, "meshio")
        for mesh in (named(square()), named(shell()), camber.curve(shell()).mesh, camber.curve(square()).mesh):
            other = camber.to_meshio(mesh)
            again = camber.from_meshio(other)
            left, right = arrays(again), arrays(mesh)
            left[3].pop("vertex"), right[3].pop("vertex")
            self.assertEqual(left, right)
            self.assertEqual(camber.check(other)["valid"], camber.check(mesh)["valid"])
            for name, values in mesh.fields.items():
                np.testing.assert_array_equal(again.fields[name], values)

    def test_physical_groups_of_gmsh_become_references_and_names(self):
        need(self, "meshio")
        import meshio

        points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
        other = meshio.Mesh(points, [("line", [[0, 1]]), ("triangle", [[0, 1, 2]]), ("triangle", [[1, 3, 2]])],
                            cell_data={"gmsh:physical": [[7], [3], [4]]},
                            field_data={"wall": np.array([7, 1]), "air": np.array([3, 2])})
        mesh = camber.from_meshio(other)
        self.assertEqual(mesh.dimension, 2)
        self.assertEqual(mesh.references["triangle"].tolist(), [3, 4])
        self.assertEqual(mesh.names, {(1, 7): "wall", (2, 3): "air"})
        with self.assertRaisesRegex(camber.InputError, "quad: is a type of cells that Camber does not hold"):
            camber.from_meshio(meshio.Mesh(points, [("quad", [[0, 1, 3, 2]])]))


class Vtk(unittest.TestCase):
    def test_meshes_converted_to_vtk_and_back_are_equal(self):
        need(self, "vtkmodules")
        for mesh in (named(shell()), camber.curve(shell()).mesh, camber.curve(square()).mesh):
            grid = camber.to_vtk(mesh)
            self.assertEqual(grid.GetNumberOfPoints(), len(mesh.points))
            again = camber.from_vtk(grid)
            self.assertEqual(again.corners.keys(), mesh.corners.keys())
            np.testing.assert_array_equal(again.points, mesh.points)
            for name, rows in mesh.cells.items():
                np.testing.assert_array_equal(again.cells[name], rows)
                np.testing.assert_array_equal(again.references[name], mesh.references[name])

    def test_vtk_computes_a_positive_area_of_a_curved_mesh(self):
        need(self, "vtkmodules")
        from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
        from vtkmodules.util.numpy_support import vtk_to_numpy

        mesh = camber.curve(camber.generate("annulus", set={"inner_size": 0.3, "outer_size": 0.3})).mesh
        size = vtkCellSizeFilter()
        size.SetInputData(camber.to_vtk(mesh))
        size.Update()
        areas = vtk_to_numpy(size.GetOutput().GetCellData().GetArray("Area"))
        self.assertGreater(areas.sum(), 0)

    def test_to_pyvista_passes_the_grid_to_wrap(self):
        need(self, "vtkmodules")
        pyvista = types.ModuleType("pyvista")
        pyvista.wrap = lambda grid: ("wrapped", grid)
        sys.modules["pyvista"] = pyvista
        try:
            self.assertEqual(camber.to_pyvista(shell())[0], "wrapped")
        finally:
            del sys.modules["pyvista"]


class ScikitFem(unittest.TestCase):
    """Mesh classes of scikit-fem take doflocs (D, n) and t (nodes of an element, m): vertices first, edges as (0, 1),
    (1, 2), (0, 2)."""

    def test_to_skfem_passes_arrays_in_the_documented_order(self):
        class Made:
            def __init__(self, p, t):
                self.p, self.t = p, t
                pairs = np.sort(np.concatenate([t[[0, 1]], t[[1, 2]], t[[0, 2]]], axis=1), axis=0)
                self.facets = np.unique(pairs, axis=1)
                self.subdomains = self.boundaries = None

            def with_subdomains(self, subdomains):
                self.subdomains = subdomains
                return self

            def with_boundaries(self, boundaries):
                self.boundaries = boundaries
                return self

        skfem = types.ModuleType("skfem")
        skfem.MeshTri2 = Made
        sys.modules["skfem"] = skfem
        try:
            mesh = camber.curve(square(3)).mesh
            material = int(mesh.references["triangle6"][0])
            mesh = camber.Mesh(mesh.points, mesh.cells, mesh.references, {(2, material): "domain", (1, 1): "side"})
            made = camber.to_skfem(mesh)
        finally:
            del sys.modules["skfem"]
        self.assertEqual(made.p.shape, (2, len(mesh.points)))
        self.assertEqual(made.t.shape, (6, len(mesh.elements)))
        self.assertEqual(made.subdomains["domain"].tolist(), list(range(len(mesh.elements))))
        ends = np.sort(made.facets[:, made.boundaries["side"]].T, axis=1)
        rows = mesh.corners["line3"][mesh.references["line3"] == 1]
        self.assertGreater(len(rows), 0)
        self.assertEqual(sorted(map(tuple, ends.tolist())), sorted(map(tuple, np.sort(rows, axis=1).tolist())))


class Dolfinx(unittest.TestCase):
    def test_dolfinx_integrates_the_curved_volume_and_has_all_tags(self):
        try:
            import dolfinx  # noqa: F401
        except ImportError:
            self.skipTest("dolfinx is not installed")  # package python3-dolfinx of Debian, 1 GB
        import ufl
        from dolfinx import fem

        made = camber.curve(shell())
        mesh, cells, facets = camber.to_dolfinx(made)
        exact = 4 / 3 * np.pi * (2**3 - 1)
        volume = fem.assemble_scalar(fem.form(1.0 * ufl.dx(mesh)))
        self.assertLess(abs(volume - exact), 0.02 * exact)
        self.assertEqual(len(cells.values), len(made.mesh.elements))
        self.assertEqual(len(facets.values), len(made.mesh.cells["triangle6"]))


if __name__ == "__main__":
    shared.main()
