"""`camber check --field`: errors of interpolants against a second evaluation in numpy that shares no code (its own rule,
its own basis, gradients in closed form), and what is said of a field that cannot be taken.

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
    """Barycentric points and weights of a simplex: Gauss–Legendre on a cube that is folded onto it."""
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
    """Lagrange functions of degree 2 (nodes × points), and their derivatives by the barycentric coordinates."""
    n = len(LOCAL_EDGES[:dim * (dim + 1) // 2])
    values, slopes = np.zeros((dim + 1 + n, len(xi))), np.zeros((dim + 1 + n, dim + 1, len(xi)))
    for i in range(dim + 1):
        values[i], slopes[i, i] = xi[:, i] * (2 * xi[:, i] - 1), 4 * xi[:, i] - 1
    for e, (i, j) in enumerate(LOCAL_EDGES[:n]):
        values[dim + 1 + e] = 4 * xi[:, i] * xi[:, j]
        slopes[dim + 1 + e, i], slopes[dim + 1 + e, j] = 4 * xi[:, j], 4 * xi[:, i]
    return values, slopes


def errors(mesh, variant):
    """(L2, H1) of the interpolant's error: `linear`, `straight` or `curved`."""
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
    """Nodes of the side x = 0 moved outwards, those of its edges' middles."""
    vertices = {v for element in mesh.elements for v in element[:mesh.dim + 1]}
    for node in {v for element in mesh.elements for v in element} - vertices:
        if mesh.points[node, 0] == 0:
            mesh.points[node, 0] -= amplitude


class Field(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def check(self, mesh, *fields, json_wanted=True, more=()):
        (self.folder.path / "m.mesh").write_text(mesh.text())
        arguments = [part for text in fields for part in ("--field", text)]
        return self.folder.camber("check", "m.mesh", *arguments, *(["--json"] if json_wanted else []), *more)

    def test_errors_are_those_of_a_second_evaluation(self):
        for dim, n, amplitude in ((2, 3, 0.08), (3, 2, 0.05)):
            mesh = elevated(lattice(dim, n), np.random.default_rng(3), amplitude)
            done = self.check(mesh, FRONT)
            self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
            found = json.loads(done.stdout)["interpolation"][0]
            for variant in ("linear", "straight", "curved"):
                for norm, wanted in zip(("l2", "h1"), errors(mesh, variant)):
                    self.assertLess(abs(found[variant][norm]["value"] / wanted - 1), 5e-4, (dim, variant, norm))
            self.assertEqual(found["compared_with"], "straight")
            self.assertEqual(found["same_boundary"], found["straight"])
            for norm in ("l2", "h1"):
                self.assertAlmostEqual(found["ratio"][norm],
                                       found["straight"][norm]["value"] / found["curved"][norm]["value"])

    def test_curved_walls_are_compared_with_the_same_walls(self):
        for dim, n, amplitude in ((2, 3, 0.08), (3, 2, 0.05)):
            mesh = elevated(lattice(dim, n), np.random.default_rng(3), amplitude)
            bow(mesh, 0.1)
            done = self.check(mesh, FRONT)
            self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
            found = json.loads(done.stdout)["interpolation"][0]
            inside = elevated(lattice(dim, n))
            bow(inside, 0.1)
            for variant, of in (("curved", mesh), ("same_boundary", inside)):
                for norm, wanted in zip(("l2", "h1"), errors(of, "curved")):
                    self.assertLess(abs(found[variant][norm]["value"] / wanted - 1), 5e-4, (dim, variant, norm))
            self.assertEqual(found["compared_with"], "same_boundary")
            for norm in ("l2", "h1"):
                self.assertAlmostEqual(found["ratio"][norm],
                                       found["same_boundary"][norm]["value"] / found["curved"][norm]["value"])
            self.assertAlmostEqual(found["volume"]["straight"], n ** dim)
            self.assertGreater(found["volume"]["curved"], n ** dim)
            text = self.check(mesh, FRONT, json_wanted=False).stdout
            self.assertIn("degree 2, same boundary, straight inner edges", text)
            self.assertIn("cover another domain", text)
            self.assertIn("(no inner edge is curved)", self.check(inside, FRONT, json_wanted=False).stdout)

    def test_inverted_elements_of_the_comparison_are_told(self):
        mesh = elevated(lattice(2, 4))
        mesh.points[:, 0] -= 2  # a bump that lifts the layers above it: y -> y / 10 + 1 - x² / 4
        mesh.points[:, 1] = mesh.points[:, 1] / 10 + 1 - mesh.points[:, 0] ** 2 / 4
        found = json.loads(self.check(mesh, FRONT).stdout)["interpolation"][0]
        self.assertEqual((found["straight_inverted"], found["curved_inverted"]), (0, 0))
        self.assertGreater(found["same_boundary_inverted"], 0)
        self.assertIn(f"! {found['same_boundary_inverted']} elements are inverted (det J <= 0 at a point) where inner edges are",
                      self.check(mesh, FRONT, json_wanted=False).stdout)

    def test_bins_hold_every_element_and_all_of_the_error(self):
        mesh = elevated(lattice(3, 2), np.random.default_rng(4), 0.08)
        found = json.loads(self.check(mesh, FRONT).stdout)["interpolation"][0]
        for bins in ("by_curvature", "by_scaled_jacobian", "by_boundary"):
            self.assertEqual(sum(b["elements"] for b in found[bins]), len(mesh.elements))
            for sides in ("straight", "same_boundary", "curved"):
                self.assertAlmostEqual(sum(b[sides] for b in found[bins]), 1)

    def test_without_a_field_nothing_is_said_of_fields(self):
        mesh = elevated(lattice(2, 2))
        self.assertNotIn("interpolation", json.loads(self.check(mesh).stdout))
        self.assertNotIn("interpolant", self.check(mesh, json_wanted=False).stdout)

    def test_of_degree_one_curved_is_straight(self):
        done = self.check(lattice(2, 3), FRONT)
        found = json.loads(done.stdout)["interpolation"][0]
        self.assertEqual(found["curved"], found["straight"])
        self.assertEqual(found["ratio"], {"l2": 1.0, "h1": 1.0})
        text = self.check(lattice(2, 3), FRONT, json_wanted=False).stdout
        self.assertIn("degree 2, straight edges", text)
        self.assertNotIn("as it is", text)

    def test_several_fields_and_a_table(self):
        done = self.check(elevated(lattice(2, 2), np.random.default_rng(1), 0.1), "x^3", "x", json_wanted=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("Error of the interpolant of x^3", done.stdout)
        self.assertIn("Error of the interpolant of x\n", done.stdout)
        self.assertIn("0 to rounding", done.stdout)

    def test_invalid_elements_are_judged_too_and_the_exit_code_stays(self):
        mesh = elevated(lattice(2, 3), np.random.default_rng(2), 0.6)
        done = self.check(mesh, FRONT)
        self.assertEqual(done.returncode, 1)
        self.assertGreater(json.loads(done.stdout)["interpolation"][0]["curved_inverted"], 0)
        self.assertIn("det J <= 0 at a point of the quadrature", self.check(mesh, FRONT, json_wanted=False).stdout)

    def test_the_same_bytes_for_any_number_of_threads(self):
        mesh = elevated(lattice(3, 3), np.random.default_rng(5), 0.08)
        outputs = {self.check(mesh, FRONT, more=("--threads", threads)).stdout for threads in (1, 2, 3)}
        self.assertEqual(len(outputs), 1)

    def test_what_cannot_be_taken_is_said_with_its_place(self):
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
