"""camber.metric: properties of operations on metrics."""
import unittest

import numpy as np

import shared
from shared import camber, shell, square


def sizes(metric):
    return 1 / np.sqrt(np.linalg.eigvalsh(metric))


class Metrics(unittest.TestCase):
    def test_the_natural_metric_of_a_regular_tetrahedron_is_isotropic(self):
        h = np.array([[1, 0, 0], [0.5, np.sqrt(3) / 2, 0], [0.5, np.sqrt(3) / 6, np.sqrt(2 / 3)]])
        mesh = camber.Mesh(np.vstack([[0, 0, 0], 0.1 * h]), {"tetra": [[0, 1, 2, 3]]})
        np.testing.assert_allclose(camber.metric.natural(mesh), np.tile(100 * np.eye(3), (4, 1, 1)), rtol=1e-9, atol=1e-9)

    def test_an_intersection_bounds_both_metrics(self):
        mesh = square()
        rng = np.random.default_rng(1)
        first, second = (self.random(rng, len(mesh.vertices)) for _ in range(2))
        both = camber.metric.intersect(mesh, first, second)
        for metric in (first, second):
            self.assertGreater(np.linalg.eigvalsh(both - metric).min() / np.abs(metric).max(), -1e-10)

    @staticmethod
    def random(rng, n):
        rows = rng.normal(size=(n, 2, 2))
        return np.einsum("nij,nkj->nik", rows, rows) + np.eye(2)

    def test_gradation_limits_the_growth_of_sizes(self):
        mesh = square()
        steep = np.where(mesh.points[:, 0] < 0.1, 0.01, 1.0)
        graded = camber.metric.gradation(mesh, steep, 1.5)
        self.assertLess(sizes(graded).max(), 1.0 + 1e-12)
        self.assertLess(np.sort(sizes(graded).max(axis=1))[len(graded) // 2], 0.9)

    def test_bound_limits_sizes(self):
        mesh = square()
        steep = np.where(mesh.points[:, 0] < 0.1, 0.01, 1.0)
        bounded = sizes(camber.metric.bound(mesh, steep, min_size=0.1, max_size=0.5))
        self.assertGreaterEqual(bounded.min(), 0.1 * (1 - 1e-12))
        self.assertLessEqual(bounded.max(), 0.5 * (1 + 1e-12))

    def test_complexity_scales_a_metric_to_the_target(self):
        mesh = square()
        made = camber.metric.complexity(mesh, 0.1, 500)
        area = 1.0
        np.testing.assert_allclose(np.sqrt(np.linalg.det(made)).mean() * area, 500, rtol=1e-9)

    def test_a_metric_from_a_solution_is_positive_and_within_intersected_sizes(self):
        mesh = shell()
        u = np.tanh((mesh.points[:, 0] - 0.3) / 0.1)
        metric = camber.metric.from_solution(mesh, u, complexity=300)
        self.assertEqual(metric.shape, (len(mesh.vertices), 3, 3))
        self.assertGreater(np.linalg.eigvalsh(metric).min(), 0)
        wide = camber.metric.from_solution(mesh, u, complexity=300, intersect=0 * u + 0.2)
        self.assertLessEqual(sizes(wide).max(), 0.2 * (1 + 1e-9))

    def test_the_hessian_of_a_quadratic_is_exact(self):
        mesh = camber.elevate(square()).mesh
        x, y = mesh.points.T
        for field, points in ((x**2 + 3 * x * y - y**2, mesh), (lambda p: p, None)):
            if points is None:
                continue
            found = camber.metric.hessian(points, field)
            np.testing.assert_allclose(found, np.tile([[2.0, 3.0], [3.0, -2.0]], (len(found), 1, 1)), atol=1e-8)

    def test_asymmetry_by_rounding_is_accepted_and_larger_asymmetry_rejected(self):
        mesh = square()
        rng = np.random.default_rng(2)
        turns, _ = np.linalg.qr(rng.normal(size=(len(mesh.vertices), 2, 2)))
        wide = np.einsum("nij,j,nkj->nik", turns, [1e-4, 1e4], turns)
        made = camber.metric.bound(mesh, np.linalg.inv(wide))
        np.testing.assert_allclose(sizes(made).max(), 1e2, rtol=1e-6)
        wide[3, 0, 1] += 1
        with self.assertRaisesRegex(camber.InputError, "metric: row 3: is not symmetric"):
            camber.metric.bound(mesh, wide)

    def test_metrics_of_a_wrong_shape_are_rejected(self):
        mesh = square()
        with self.assertRaisesRegex(camber.InputError, "metric: has the shape"):
            camber.metric.gradation(mesh, np.ones((len(mesh.vertices), 5)), 1.5)


if __name__ == "__main__":
    shared.main()
