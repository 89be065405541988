"""`camber check --field`: interpolation errors against an independent evaluation in numpy (own quadrature, own basis,
closed-form gradients), and rejected fields.

    python3 tests/pipelines/test_field.py build/bin/camber [unittest arguments]
"""
import itertools
import json
import unittest

import numpy as np

from made_meshes import LOCAL_EDGES, elevated, lattice
from program import Folder

FRONT = "tanh((sqrt(x^2+y^2+0.5)-1.3)/0.2) + 0.1*x*y"


def front(x):
    r = np.sqrt(x[0] ** 2 + x[1] ** 2 + 0.5)
    return np.tanh((r - 1.3) / 0.2) + 0.1 * x[0] * x[1]


def front_gradient(x):
    r = np.sqrt(x[0] ** 2 + x[1] ** 2 + 0.5)
    slope = (1 - np.tanh((r - 1.3) / 0.2) ** 2) / 0.2 / r
    gradient = np.zeros_like(x)
    gradient[0], gradient[1] = slope * x[0] + 0.1 * x[1], slope * x[1] + 0.1 * x[0]
    return gradient


def rule(dim, n=14):
    """Barycentric points and weights of a simplex: Gauss–Legendre on a cube, folded onto the simplex."""
    t, w = np.polynomial.legendre.leggauss(n)
    t, w = (t + 1) / 2, w / 2
    points, weights = [], []
    for at in itertools.product(range(n), repeat=dim):
        rest, weight, coordinates = 1.0, 1.0, []
        for level, i in enumerate(at):
            coordinates.append(rest * t[i])
            weight *= w[i] * (1 - t[i]) ** (dim - 1 - level)
            rest *= 1 - t[i]
        points.append([rest, *coordinates])
        weights.append(weight)
    return np.array(points), np.array(weights)


def basis(dim, xi):
    """Quadratic Lagrange functions (nodes × points) and their derivatives by barycentric coordinates."""
    n = len(LOCAL_EDGES[:dim * (dim + 1) // 2])
    values, slopes = np.zeros((dim + 1 + n, len(xi))), np.zeros((dim + 1 + n, dim + 1, len(xi)))
    for i in range(dim + 1):
        values[i], slopes[i, i] = xi[:, i] * (2 * xi[:, i] - 1), 4 * xi[:, i] - 1
    for e, (i, j) in enumerate(LOCAL_EDGES[:n]):
        values[dim + 1 + e] = 4 * xi[:, i] * xi[:, j]
        slopes[dim + 1 + e, i], slopes[dim + 1 + e, j] = 4 * xi[:, j], 4 * xi[:, i]
    return values, slopes


def errors(mesh, variant):
    """(L2, H1) error of the interpolant; variant `linear`, `straight` or `curved`."""
    dim = mesh.dim
    xi, weights = rule(dim)
    shape, barycentric_slopes = basis(dim, xi)
    slopes = barycentric_slopes[:, 1:] - barycentric_slopes[:, :1]
    l2 = h1 = 0.0
    for element in mesh.elements:
        nodes = mesh.points[list(element)]
        if variant != "curved":
            for e, (i, j) in enumerate(LOCAL_EDGES[:dim * (dim + 1) // 2]):
                nodes[dim + 1 + e] = (nodes[i] + nodes[j]) / 2
        u = front(nodes.T)
        if variant == "linear":
            for e, (i, j) in enumerate(LOCAL_EDGES[:dim * (dim + 1) // 2]):
                u[dim + 1 + e] = (u[i] + u[j]) / 2
        x = np.einsum("nc,np->cp", nodes, shape)
        jacobian = np.einsum("nc,nap->pca", nodes, slopes)  # column a: by ξ_a
        measure = weights * np.abs(np.linalg.det(jacobian))
        gradient = np.linalg.solve(np.swapaxes(jacobian, 1, 2), np.einsum("n,nap->pa", u, slopes)[..., None])[..., 0]
        l2 += np.sum(measure * (front(x) - u @ shape) ** 2)
        h1 += np.sum(measure * np.sum((front_gradient(x) - gradient.T) ** 2, axis=0))
    return np.sqrt(l2), np.sqrt(h1)


def bow(mesh, amplitude):
    """Moves mid nodes of the side x = 0 outwards."""
    vertices = {v for element in mesh.elements for v in element[:mesh.dim + 1]}
    for node in {v for element in mesh.elements for v in element} - vertices:
        if mesh.points[node, 0] == 0:
            mesh.points[node, 0] -= amplitude


class Field(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def check(self, mesh, *fields, as_json=True, more=()):
        (self.folder.path / "m.mesh").write_text(mesh.text())
        arguments = [part for text in fields for part in ("--field", text)]
        return self.folder.camber("check", "m.mesh", *arguments, *(["--json"] if as_json else []), *more)

    def test_interpolation_errors_match_an_independent_evaluation(self):
        for dim, n, amplitude in ((2, 3, 0.08), (3, 2, 0.05)):
            mesh = elevated(lattice(dim, n), np.random.default_rng(3), amplitude)
            done = self.check(mesh, FRONT)
            self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
            found = json.loads(done.stdout)["interpolation"][0]
            for variant in ("linear", "straight", "curved"):
                for norm, expected in zip(("l2", "h1"), errors(mesh, variant)):
                    self.assertLess(abs(found[variant][norm]["value"] / expected - 1), 5e-4, (dim, variant, norm))
            self.assertEqual(found["compared_with"], "straight")
            self.assertEqual(found["same_boundary"], found["straight"])
            for norm in ("l2", "h1"):
                self.assertAlmostEqual(found["ratio"][norm],
                                       found["straight"][norm]["value"] / found["curved"][norm]["value"])

    def test_a_curved_boundary_is_compared_with_straight_inner_edges(self):
        for dim, n, amplitude in ((2, 3, 0.08), (3, 2, 0.05)):
            mesh = elevated(lattice(dim, n), np.random.default_rng(3), amplitude)
            bow(mesh, 0.1)
            done = self.check(mesh, FRONT)
            self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
            found = json.loads(done.stdout)["interpolation"][0]
            inside = elevated(lattice(dim, n))
            bow(inside, 0.1)
            for variant, of in (("curved", mesh), ("same_boundary", inside)):
                for norm, expected in zip(("l2", "h1"), errors(of, "curved")):
                    self.assertLess(abs(found[variant][norm]["value"] / expected - 1), 5e-4, (dim, variant, norm))
            self.assertEqual(found["compared_with"], "same_boundary")
            for norm in ("l2", "h1"):
                self.assertAlmostEqual(found["ratio"][norm],
                                       found["same_boundary"][norm]["value"] / found["curved"][norm]["value"])
            self.assertAlmostEqual(found["volume"]["straight"], n ** dim)
            self.assertGreater(found["volume"]["curved"], n ** dim)
            text = self.check(mesh, FRONT, as_json=False).stdout
            self.assertIn("degree 2, same boundary, straight inner edges", text)
            self.assertIn("covers another domain", text)
            self.assertIn("(no inner edge is curved)", self.check(inside, FRONT, as_json=False).stdout)

    def test_inverted_elements_of_the_comparison_mesh_are_reported(self):
        mesh = elevated(lattice(2, 4))
        mesh.points[:, 0] -= 2  # a bump lifts the layers above: y -> y / 10 + 1 - x² / 4
        mesh.points[:, 1] = mesh.points[:, 1] / 10 + 1 - mesh.points[:, 0] ** 2 / 4
        found = json.loads(self.check(mesh, FRONT).stdout)["interpolation"][0]
        self.assertEqual((found["straight_inverted"], found["curved_inverted"]), (0, 0))
        self.assertGreater(found["same_boundary_inverted"], 0)
        self.assertIn(f"! {found['same_boundary_inverted']} elements are inverted (det J <= 0 at a point) if inner edges are",
                      self.check(mesh, FRONT, as_json=False).stdout)

    def test_bins_contain_every_element_and_the_whole_error(self):
        mesh = elevated(lattice(3, 2), np.random.default_rng(4), 0.08)
        found = json.loads(self.check(mesh, FRONT).stdout)["interpolation"][0]
        for bins in ("by_curvature", "by_scaled_jacobian", "by_boundary"):
            self.assertEqual(sum(b["elements"] for b in found[bins]), len(mesh.elements))
            for sides in ("straight", "same_boundary", "curved"):
                self.assertAlmostEqual(sum(b[sides] for b in found[bins]), 1)

    def test_check_without_a_field_reports_no_interpolation_error(self):
        mesh = elevated(lattice(2, 2))
        self.assertNotIn("interpolation", json.loads(self.check(mesh).stdout))
        self.assertNotIn("interpolant", self.check(mesh, as_json=False).stdout)

    def test_curved_and_straight_errors_are_equal_for_degree_1(self):
        done = self.check(lattice(2, 3), FRONT)
        found = json.loads(done.stdout)["interpolation"][0]
        self.assertEqual(found["curved"], found["straight"])
        self.assertEqual(found["ratio"], {"l2": 1.0, "h1": 1.0})
        text = self.check(lattice(2, 3), FRONT, as_json=False).stdout
        self.assertIn("degree 2, straight edges", text)
        self.assertNotIn("curved edges", text)

    def test_check_prints_a_table_for_each_field(self):
        done = self.check(elevated(lattice(2, 2), np.random.default_rng(1), 0.1), "x^3", "x", as_json=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("Error of the interpolant of x^3", done.stdout)
        self.assertIn("Error of the interpolant of x\n", done.stdout)
        self.assertIn("0 to rounding", done.stdout)

    def test_errors_include_invalid_elements_and_the_exit_code_stays_1(self):
        mesh = elevated(lattice(2, 3), np.random.default_rng(2), 0.6)
        done = self.check(mesh, FRONT)
        self.assertEqual(done.returncode, 1)
        self.assertGreater(json.loads(done.stdout)["interpolation"][0]["curved_inverted"], 0)
        self.assertIn("det J <= 0 at a quadrature point", self.check(mesh, FRONT, as_json=False).stdout)

    def test_errors_do_not_depend_on_the_number_of_threads(self):
        mesh = elevated(lattice(3, 3), np.random.default_rng(5), 0.08)
        outputs = {self.check(mesh, FRONT, more=("--threads", threads)).stdout for threads in (1, 2, 3)}
        self.assertEqual(len(outputs), 1)

    def test_a_bad_field_expression_is_rejected_with_its_position(self):
        mesh = elevated(lattice(2, 2))
        for field, words in (("sin(x", "at position"), ("x + q", 'at "q"'), ("z", 'at "z"'), ("x, y", "gives 2 values"),
                             ("1/x", "the field is inf at (0, "), ("log(x-1)", "the field is "), ("", "cannot be read")):
            done = self.check(mesh, field)
            self.assertEqual(done.returncode, 2, field)
            self.assertIn(words, done.stderr, field)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertEqual(done.stdout, "")


if __name__ == "__main__":
    unittest.main(argv=[__file__] + __import__("sys").argv[2:])
