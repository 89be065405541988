"""Self-tests of the second evaluation of the length reduction.  Run: python3 test_length_reduction.py."""
import tempfile
import unittest
from pathlib import Path

import numpy as np

import gmf
import length_reduction
import log_metrics
import sample_meshes as samples
from back_mesh import BackMesh


def shell():
    """A cube of 4^3 cells without its middle 2^3: not convex."""
    full = samples.cube(4)
    centres = full.points[full.cells["Tetrahedra"].nodes].mean(axis=1)
    keep = (abs(centres - 0.5) > 0.25).any(axis=1)
    return samples.linear_mesh(full.points, full.cells["Tetrahedra"].nodes[keep])


class Metrics(unittest.TestCase):
    def test_the_natural_metric_of_a_stretched_regular_simplex_is_exact(self):
        for k in (2, 3):
            points = np.vstack([np.zeros(k), log_metrics.regular_simplex(k).T])
            stretch = np.diag([1.0, 1e-3, 1e-6][:k])
            logs, _ = log_metrics.element_log_metrics(points @ stretch, np.arange(k + 1)[None])
            np.testing.assert_allclose(np.diag(logs[0]), -2 * np.log(np.diag(stretch)), rtol=1e-9, atol=1e-9)

    def test_tensors_are_read_in_the_order_of_gmf(self):
        field = gmf.Gmf(2, 3, fields=[(3, np.array([[4., 1, 5, 2, 3, 9]]))])
        logs, floored = log_metrics.from_field(field, 3)
        metric = np.array([[4., 1, 2], [1, 5, 3], [2, 3, 9]])
        v = np.array([[1., -2, 0.5]])
        self.assertEqual(floored, 0)
        self.assertAlmostEqual(log_metrics.speeds(logs, v)[0] ** 2, (v @ metric @ v.T)[0, 0])

    def test_a_scalar_field_is_a_size(self):
        field = gmf.Gmf(2, 2, fields=[(1, np.array([[0.5]]))])
        speed = log_metrics.speeds(log_metrics.from_field(field, 2)[0], np.array([[3., 4.]]))
        self.assertAlmostEqual(speed[0], 10)

    def test_an_indefinite_tensor_is_rejected(self):
        with self.assertRaises(ValueError):
            log_metrics.from_field(gmf.Gmf(2, 2, fields=[(3, np.array([[1., 0, -1]]))]), 2)


class Location(unittest.TestCase):
    def test_random_points_around_a_hole_are_located(self):
        mesh = shell()
        back = BackMesh(mesh, np.zeros((len(mesh.points), 3, 3)))
        random = np.random.default_rng(1)
        x = random.random((4000, 3))
        start = random.integers(0, len(back.elements), len(x))
        element, weights, found = back.locate(x, start)
        inside = (abs(x - 0.5) > 0.25).any(axis=1)
        np.testing.assert_array_equal(found, inside)
        where = np.einsum("nk,nkd->nd", weights, mesh.points[back.elements[element]])
        np.testing.assert_allclose(where[inside], x[inside], atol=1e-12)
        gap = np.linalg.norm(where - x, axis=1)[~inside]
        np.testing.assert_allclose(gap, (0.25 - abs(x - 0.5).max(axis=1))[~inside], atol=1e-12)


class Lengths(unittest.TestCase):
    def test_the_length_in_an_exponential_field_equals_the_closed_form(self):
        """log M = (a + b x) I: a straight edge along d has length |d| (e^(..)-e^(..)) / (b dx / 2)."""
        mesh = samples.cube(2)
        a, b = 0.3, 2.0
        logs = (a + b * mesh.points[:, :1])[:, :, None] * np.eye(3)
        ends = np.array([[[0.1, 0.2, 0.3], [0.9, 0.6, 0.7]]])
        found, outside = length_reduction.lengths(BackMesh(mesh, logs), np.array([0]), ends, ends.mean(axis=1))
        step = ends[0, 1] - ends[0, 0]
        low, high = (np.exp((a + b * x) / 2) for x in ends[0, :, 0])
        self.assertEqual(outside, 0)
        self.assertAlmostEqual(found[0], np.linalg.norm(step) * (high - low) / (b * step[0] / 2), places=12)

    def test_the_length_reduction_of_straight_and_bent_edges_is_exact(self):
        linear = samples.cube(3)
        mesh = samples.elevate(linear)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "unit.solb")
            path.write_bytes(samples.solution_file(np.ones((len(linear.points), 1)), 1, 3))
            figures = length_reduction.evaluate(linear, mesh, str(path))
            self.assertEqual((figures["mean_length_reduction"], figures["edges_longer_than_straight"]), (0, 0))
            triples, _ = length_reduction.volume_edges(mesh)
            # axis edges, face diagonals and body diagonals, less those on the boundary
            self.assertEqual(len(triples), 144 + 108 + 27 - 162)
            a, b, mid = triples[0]
            chord = np.linalg.norm(mesh.points[b] - mesh.points[a])
            mesh.points[mid] += 0.1 * chord * np.linalg.svd((mesh.points[b] - mesh.points[a])[None])[2][-1]
            figures = length_reduction.evaluate(linear, mesh, str(path), back=linear)
        self.assertEqual(figures["edges_longer_than_straight"], 1)
        self.assertAlmostEqual(figures["largest_curvature"], 0.1)
        # parabola of sagitta 0.1 on a unit chord: the integral of sqrt(1 + (0.8 s)^2), |s| <= 1/2
        arc = np.sqrt(1 + 0.16) / 2 + np.arcsinh(0.4) / 0.8
        self.assertAlmostEqual(figures["smallest_length_reduction"], 1 / arc - 1, places=9)


if __name__ == "__main__":
    unittest.main()
