"""Meshes as arrays: views that share memory, arrays as input, rejected input."""
import copy
import gc
import os
import pickle
import sys
import tempfile
import unittest

import numpy as np

import shared
from shared import arrays, camber, shell, square, two_tetrahedra


class Views(unittest.TestCase):
    def test_views_are_read_only_and_keep_the_mesh_alive(self):
        mesh = shell()
        points, corners, references = mesh.points, mesh.corners["tetra"], mesh.references["tetra"]
        before = points.copy(), corners.copy()
        for view in (points, corners, references):
            self.assertFalse(view.flags.writeable)
            self.assertRaises(ValueError, view.__setitem__, 0, 0)
            self.assertRaises(ValueError, view.setflags, write=True)
        del mesh
        gc.collect()
        [np.ones(len(points) * 3) for _ in range(10)]
        np.testing.assert_array_equal(points, before[0])
        np.testing.assert_array_equal(corners, before[1])

    def test_views_share_memory_with_the_mesh(self):
        mesh = shell()
        self.assertTrue(np.shares_memory(mesh.points, mesh.vertices))
        self.assertIs(mesh.points, mesh.points)
        other = mesh.with_fields(u=np.zeros(len(mesh.vertices)))
        self.assertTrue(np.shares_memory(mesh.points, other.points))

    def test_quadratic_cells_have_the_node_order_of_vtk(self):
        mesh = camber.elevate(shell()).mesh
        rows = mesh.cells["tetra10"]
        points = mesh.points
        self.assertEqual(len(points), len(mesh.vertices) + len(mesh.edges))
        for k, (a, b) in enumerate([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]):
            middle = 0.5 * (points[rows[:, a]] + points[rows[:, b]])
            np.testing.assert_allclose(points[rows[:, 4 + k]], middle, rtol=0, atol=1e-15)


class Arrays(unittest.TestCase):
    def test_read_only_arrays_are_shared_and_writable_ones_copied(self):
        points, cells = two_tetrahedra()
        copied = camber.Mesh(points, {"tetra": cells})
        self.assertFalse(np.shares_memory(copied.points, points))
        points.flags.writeable = False
        mesh = camber.Mesh(points, {"tetra": cells})
        self.assertTrue(np.shares_memory(mesh.points, points))
        address, count = points.ctypes.data, sys.getrefcount(points)
        del mesh
        gc.collect()
        self.assertEqual(sys.getrefcount(points), count - 1)
        shared_mesh = camber.Mesh(points, {"tetra": cells})
        del points
        gc.collect()
        self.assertEqual(shared_mesh.points.ctypes.data, address)
        self.assertEqual(shared_mesh.points[4].tolist(), [1, 1, 1])

    def test_a_read_only_view_of_a_writable_array_is_copied(self):
        points, cells = two_tetrahedra()
        view = points[:]
        view.flags.writeable = False
        mesh = camber.Mesh(view, {"tetra": cells})
        points[0] = 7
        self.assertEqual(mesh.points[0].tolist(), [0, 0, 0])

    def test_a_mesh_made_of_the_arrays_of_a_mesh_is_equal(self):
        for mesh in (shell(), square(), camber.elevate(shell()).mesh, camber.curve(shell()).mesh):
            again = camber.Mesh(mesh.points, mesh.cells, mesh.references, mesh.names)
            self.assertEqual(arrays(again), arrays(mesh))

    def test_names_references_and_fields_are_stored_and_written(self):
        points, cells = two_tetrahedra()
        mesh = camber.Mesh(points, {"tetra": cells, "triangle": [[0, 1, 2]]}, {"tetra": [4, 5], "triangle": [9]},
                           {(3, 4): "air", (2, 9): "wall"}, {"u": np.arange(5.0), "v": np.ones((5, 3))})
        self.assertEqual(mesh.references["tetra"].tolist(), [4, 5])
        self.assertEqual(mesh.names, {(3, 4): "air", (2, 9): "wall"})
        self.assertEqual(mesh.fields["u"].tolist(), [0, 1, 2, 3, 4])
        self.assertEqual(mesh.fields["v"].shape, (5, 3))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "m.vtu")
            mesh.write(path)
            read = camber.read(path)
            np.testing.assert_array_equal(read.fields["u"], mesh.fields["u"])
            np.testing.assert_array_equal(read.corners["tetra"], mesh.corners["tetra"])

    def test_fields_follow_the_reordering_of_nodes(self):
        for mesh in (camber.curve(square(3)).mesh, camber.curve(shell()).mesh):
            order = np.random.default_rng(3).permutation(len(mesh.points))
            place = np.argsort(order)
            points = mesh.points[order]
            cells = {name: place[rows] for name, rows in mesh.cells.items()}
            again = camber.Mesh(points, cells, fields={"x": points[:, 0], "p": points})
            np.testing.assert_array_equal(again.fields["x"], again.points[:, 0])
            np.testing.assert_array_equal(again.fields["p"], again.points)
            np.testing.assert_array_equal(points[again.node_rows], again.points)

    def test_meshes_are_pickled_and_copied(self):
        for mesh in (square().with_fields(u=square().points[:, 0]), camber.curve(shell()).mesh,
                     camber.Mesh(np.array([[0.0, 0, 2], [1, 0, 2], [0, 1, 2]]), {"triangle": [[0, 1, 2]]},
                                 names={(2, 0): "plate"})):
            again = pickle.loads(pickle.dumps(mesh))
            self.assertEqual(again, mesh)
            self.assertEqual((again.names, again.z), (mesh.names, mesh.z))
            self.assertIs(copy.deepcopy(mesh), mesh)

    def test_a_mesh_is_immutable(self):
        mesh = camber.curve(square(3)).mesh
        for part in (mesh.cells, mesh.corners, mesh.references, mesh.names, mesh.fields):
            with self.assertRaises(TypeError):
                part["x"] = None
        self.assertRaises(ValueError, mesh.points.setflags, write=True)

    def test_flat_meshes_in_3d_are_2d_meshes_with_z(self):
        points = np.array([[0.0, 0, 2], [1, 0, 2], [0, 1, 2]])
        mesh = camber.Mesh(points, {"triangle": [[0, 1, 2]]})
        self.assertEqual((mesh.dimension, mesh.z), (2, 2.0))
        surface = camber.Mesh(points, {"triangle": [[0, 1, 2]]}, flat="surface")
        self.assertEqual((surface.dimension, surface.z), (3, None))
        self.assertEqual(surface.elements.tolist(), [[0, 1, 2]])

    def test_invalid_arrays_are_rejected_with_their_place(self):
        points, cells = two_tetrahedra()
        nan = points.copy()
        nan[3, 1] = np.nan
        for wrong, message in [
            (lambda: camber.Mesh(points, {"tetra": cells + 2}), "tetra: row 0: has a node that is none of the 5 points"),
            (lambda: camber.Mesh(points, {"tetra": [[0, 1, 2, 2]]}), "tetra: row 0: has a node twice"),
            (lambda: camber.Mesh(points, {"tetra": cells.astype(np.uint32) + np.uint32(9)}), "tetra: row 0: has a node"),
            (lambda: camber.Mesh(nan, {"tetra": cells}), "points: row 3: has a coordinate that is not finite"),
            (lambda: camber.Mesh(points[:, :1], {"tetra": cells}), r"points: has the shape \(5, 1\)"),
            (lambda: camber.Mesh(points, {"hexahedron": cells}), "hexahedron: is no type of cells"),
            (lambda: camber.Mesh(points, {"tetra": cells[:, :3]}), r"tetra: has the shape \(2, 3\)"),
            (lambda: camber.Mesh(points, {"tetra": cells}, {"tetra": [1]}), "1 references of 2 cells"),
            (lambda: camber.Mesh(points, {"tetra": cells}, fields={"u": np.zeros(4)}), r"u: has the shape \(4\)"),
            (lambda: camber.Mesh(points, {"tetra": cells}, fields={"u": ["a"] * 5}), "u: is not an array of numbers"),
            (lambda: camber.Mesh(points[:, :2], {"tetra": cells}), "tetra: are of dimension 3, the points of 2"),
            (lambda: camber.Mesh(points, {"tetra": cells}, {"tetras": [1, 2]}), "tetras: has references, and no cells"),
            (lambda: camber.Mesh(points, {"tetra": cells}, {"tetra": [1.5, 2]}), "give .m,. whole numbers"),
            (lambda: camber.Mesh(points, {"tetra": cells}, {"tetra": ["air", "sea"]}), "names go into names"),
            (lambda: camber.Mesh(points, {"tetra": cells}, {"tetra": [2**40, 1]}), "beyond 32 bits"),
            (lambda: camber.Mesh(points, {"tetra": cells}, {"vertex": [7]}), "vertex: are 1 references of 5 points"),
            (lambda: camber.Mesh(points, {"tetra": cells}, names={"wall": 1}), "names: are no"),
        ]:
            with self.assertRaisesRegex(camber.InputError, message):
                wrong()

    def test_an_empty_mesh_is_printed_and_not_curved(self):
        mesh = camber.Mesh(np.empty((0, 3)), {})
        self.assertEqual(repr(mesh), "<camber.Mesh in 3D, degree 1: 0 vertices, >")
        self.assertEqual(mesh.points.shape, (0, 3))
        self.assertRaises(camber.Error, camber.curve, mesh)


if __name__ == "__main__":
    shared.main()
