"""Self-tests of the GMF reader with files of an independent writer.  Run: python3 test_gmf.py."""
import tempfile
import unittest
from pathlib import Path

import numpy as np

import gmf
import sample_meshes as samples

ORDERS = {"EdgesP2": [(2, 0), (1, 1), (0, 2)],
          "TrianglesP2": [gmf.CANONICAL[2][i] for i in (0, 1, 2, 4, 5, 3)],
          "TetrahedraP2": [gmf.CANONICAL[3][i] for i in (9, 0, 3, 5, 1, 2, 8, 7, 4, 6)]}


def read_bytes(data, suffix=".meshb"):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "mesh" + suffix)
        path.write_bytes(data)
        return gmf.read(path)


def curved_cube():
    """A P2 cube with mid nodes off the middle by multiples of 1/64, exact in 4-byte reals."""
    mesh = samples.elevate(samples.cube(2))
    random = np.random.default_rng(3)
    mesh.points[27:] += random.integers(-4, 5, mesh.points[27:].shape) / 64
    mesh.point_refs = np.arange(len(mesh.points))
    mesh.cells["EdgesP2"] = gmf.Cells(mesh.cells["TrianglesP2"].nodes[:2][:, [0, 1, 3]], np.array([7, 8]))
    mesh.lists["Corners"] = (np.array([[1], [27]]), np.empty((2, 0)))
    mesh.lists["Ridges"] = (np.array([[2]]), np.empty((1, 0)))
    mesh.lists["Tangents"] = (np.empty((1, 0), int), np.array([[0.5, 0, 1]]))
    mesh.lists["VerticesOnGeometricTriangles"] = (np.array([[1, 4]]), np.array([[0.25, 0.5, 0]]))
    return mesh


class Files(unittest.TestCase):
    def same(self, a, b):
        np.testing.assert_array_equal(a.points, b.points)
        np.testing.assert_array_equal(a.point_refs, b.point_refs)
        self.assertEqual(set(a.cells), set(b.cells))
        for name in a.cells:
            np.testing.assert_array_equal(a.cells[name].nodes, b.cells[name].nodes)
            np.testing.assert_array_equal(a.cells[name].refs, b.cells[name].refs)
        for name in a.lists:
            for mine, theirs in zip(a.lists[name], b.lists[name]):
                np.testing.assert_array_equal(mine, theirs)

    def test_binary_files_of_all_versions_byte_orders_and_orderings_are_read(self):
        mesh = curved_cube()
        for version in (1, 2, 3, 4):
            for byte_order in "<>":
                for orders in ({}, ORDERS):
                    extra = [(777, b"12345")] if version > 1 else []
                    read = read_bytes(samples.binary_file(mesh, version, byte_order, orders, extra))
                    self.same(read, mesh)
                    self.assertEqual(read.version, version)
                    self.assertEqual(read.skipped, ["keyword 777"] * len(extra))

    def test_ascii_files_are_read(self):
        for orders in ({}, ORDERS):
            self.same(read_bytes(samples.ascii_file(curved_cube(), orders), ".mesh"), curved_cube())

    def test_linear_and_2d_meshes_are_read(self):
        flat = samples.linear_mesh([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], [[0, 1], [1, 2]])
        for mesh in (flat, samples.elevate(flat), samples.cube(1)):
            self.same(read_bytes(samples.binary_file(mesh, 4)), mesh)
            self.same(read_bytes(samples.ascii_file(mesh), ".mesh"), mesh)

    def test_bezier_control_points_are_converted_to_nodes(self):
        mesh = curved_cube()
        file = gmf.Gmf(2, 3, True, mesh.points.copy(), mesh.point_refs, mesh.cells)
        a, b, mid = np.unique(gmf.edge_triples(mesh), axis=0).T
        file.points[mid] = (4 * mesh.points[mid] - mesh.points[a] - mesh.points[b]) / 2
        for data in (samples.ascii_file(file), samples.binary_file(file, 4),
                     samples.binary_file(file, 2, ">", ORDERS)):
            np.testing.assert_array_equal(read_bytes(data).points, mesh.points)

    def test_bad_files_are_rejected(self):
        good = samples.binary_file(curved_cube(), 2)
        ten = b"MeshVersionFormatted 2 Dimension 3 Vertices 1 0 0 0 0 Tetrahedra 1 " + b"1 " * 11 + b"End"
        quad = b"MeshVersionFormatted 2 Dimension 3 Vertices 1 0 0 0 0 Quadrilaterals 1 1 1 1 1 0 End"
        outside = b"MeshVersionFormatted 2 Dimension 3 Vertices 1 0 0 0 0 Triangles 1 1 1 2 0 End"
        for data in (good[:300], good[:900], ten, quad, outside, b"hello", b"\1\0\0\0\x09\0\0\0"):
            with self.assertRaises(gmf.GmfError):
                read_bytes(data)

    def test_solution_files_are_read(self):
        tensors = np.arange(12.).reshape(2, 6)
        for version in (1, 2, 3, 4):
            (kind, values), = read_bytes(samples.solution_file(tensors, 3, 3, version), ".solb").fields
            self.assertEqual(kind, 3)
            np.testing.assert_array_equal(values, tensors)
        text = b"MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n2\n2 1 2\n1 2 3\n4 5 6\nEnd"
        (_, first), (_, second) = read_bytes(text, ".sol").fields
        np.testing.assert_array_equal(np.hstack([first, second]), [[1, 2, 3], [4, 5, 6]])


if __name__ == "__main__":
    unittest.main()
