"""A mesh in random order is reordered internally and written in its input order.

    python3 tests/pipelines/test_order.py build/bin/camber [unittest arguments]
"""
import sys
import unittest

import numpy as np
from made_meshes import scattered_square
from program import Folder, report_of

import gmf  # noqa: E402  (program puts the oracle on the path)


class Order(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def curved(self, n):
        """A square of 2 n^2 triangles, the output of `camber curve`, and its report."""
        mesh = scattered_square(n)
        (self.folder.path / "in.mesh").write_text(mesh.text())
        done = self.folder.camber("curve", "in.mesh", "-o", "out.meshb", "--report", "r.json", "--set", 'stages=["elevate"]')
        self.assertEqual(done.returncode, 0, done.stderr)
        return mesh, gmf.read(self.folder.path / "out.meshb"), report_of(self.folder.path / "r.json")

    def test_a_large_scattered_mesh_is_reordered_and_written_in_its_input_order(self):
        mesh, out, report = self.curved(224)
        self.assertAlmostEqual(report["reordered"]["scatter"], 6 / 28, delta=0.005)
        self.assertIn("renumber", [stage["stage"] for stage in report["stages"]])
        vertices = len(mesh.points)
        np.testing.assert_array_equal(out.points[:vertices], mesh.points)
        for name, rows in (("TrianglesP2", mesh.elements), ("EdgesP2", mesh.facets)):
            nodes = out.cells[name].nodes
            np.testing.assert_array_equal(nodes[:, :rows.shape[1]], rows)
            ends = [(0, 1), (1, 2), (2, 0)][:nodes.shape[1] - rows.shape[1]]
            for column, (a, b) in enumerate(ends, rows.shape[1]):
                middle = (mesh.points[rows[:, a]] + mesh.points[rows[:, b]]) / 2
                np.testing.assert_array_equal(out.points[nodes[:, column]], middle)

    def test_a_small_mesh_is_not_reordered(self):
        _, _, report = self.curved(20)
        self.assertNotIn("reordered", report)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
