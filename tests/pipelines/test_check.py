"""`camber check`: properties against the oracle, and defects reported with their numbers.

    python3 tests/pipelines/test_check.py build/bin/camber [unittest arguments]
"""
import copy
import csv
import io
import json
import re
import subprocess
import sys
import unittest
from fractions import Fraction

import numpy as np

from made_meshes import Mesh, elevated, joined, lattice, moved, permuted, with_boundary
from program import CAMBER, Folder

import gmf  # of the oracle
import jacobian

WORD = {jacobian.INVALID: "invalid", jacobian.UNDECIDED: "undecided"}


def verdicts(mesh):
    out = jacobian.examine(mesh.points, np.array(mesh.elements))
    return [WORD.get(v, "valid") for v in out["verdict"]]


def scaled_jacobian(mesh, element, barycentric):
    """det J / |det straight| of an element from its Bernstein coefficients by the oracle; elements count from 0."""
    nodes = mesh.points[list(mesh.elements[element])]
    k = mesh.dim
    values = jacobian.coefficients(nodes[None])[0][0]
    straight = np.linalg.det(nodes[1:k + 1] - nodes[0])
    return float(jacobian.bernstein_rows(k, [barycentric])[0] @ values / abs(straight))


def exact_jacobian(mesh, element, weights):
    """det J at w/Σw and the determinant of the straight element as fractions, from derivatives of the shape
    functions."""
    k = mesh.dim
    nodes = [[Fraction(float(x)) for x in mesh.points[v]] for v in mesh.elements[element]]
    xi = [w / sum(weights) for w in weights]
    edges = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)][:k * (k + 1) // 2]

    def slope(i, c):  # along barycentric coordinate i
        return (4 * xi[i] - 1) * nodes[i][c] + sum(
            4 * xi[b if a == i else a] * nodes[k + 1 + e][c] for e, (a, b) in enumerate(edges) if i in (a, b))

    def det(m):
        if len(m) == 2:
            return m[0][0] * m[1][1] - m[0][1] * m[1][0]
        return sum((-1) ** j * m[0][j] * det([row[:j] + row[j + 1:] for row in m[1:]]) for j in range(3))

    curved = [[slope(i, c) - slope(0, c) for c in range(k)] for i in range(1, k + 1)]
    return det(curved), det([[nodes[i][c] - nodes[0][c] for c in range(k)] for i in range(1, k + 1)])


class Check(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.random = np.random.default_rng(20)

    def write(self, mesh, name="m.mesh"):
        (self.folder.path / name).write_text(mesh if isinstance(mesh, str) else mesh.text())
        return name

    def check(self, mesh, *arguments, code=None):
        done = self.folder.camber("check", self.write(mesh), *arguments)
        if code is not None:
            self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        return done

    def report(self, mesh, *arguments, code=None):
        return json.loads(self.check(mesh, "--json", *arguments, code=code).stdout)

    def test_straight_lengths_and_qualities_in_a_constant_metric_match_numpy(self):
        """Reference values: Euclidean ones of the mesh transformed to the identity metric."""
        for dim, n in ((2, 4), (3, 2)):
            mesh = lattice(dim, n)
            root = self.random.normal(size=(dim, dim)) + 3 * np.eye(dim)  # M = rootT root
            tensor = root.T @ root
            row = " ".join(repr(float(tensor[i, j])) for i in range(dim) for j in range(i + 1))
            solution = f"MeshVersionFormatted 2\nDimension {dim}\nSolAtVertices\n{len(mesh.points)}\n1 3\n"
            (self.folder.path / "m.sol").write_text(solution + (row + "\n") * len(mesh.points) + "End\n")
            found = self.report(mesh, "--metric", "m.sol", code=0)
            reported = found["unit_mesh"]
            points = mesh.points @ root.T
            pairs = {tuple(sorted((e[i], e[j]))) for e in mesh.elements for i in range(dim + 1) for j in range(i)}
            lengths = np.array([np.linalg.norm(points[a] - points[b]) for a, b in pairs])
            self.assertEqual(reported["metric"], "m.sol")
            self.assertEqual(reported["edges"], len(pairs))
            unit = np.count_nonzero((lengths >= 0.5 ** 0.5) & (lengths <= 2 ** 0.5))
            self.assertEqual(reported["unit_edges"], unit)
            self.assertEqual(reported["unit_edges"] + reported["short_edges"] + reported["long_edges"], len(pairs))
            for key, value in (("shortest", lengths.min()), ("longest", lengths.max()), ("mean_length", lengths.mean())):
                self.assertAlmostEqual(reported[key], value, delta=1e-9 * value)
            qualities = []
            for element in mesh.elements:
                corners = points[list(element)]
                volume = abs(np.linalg.det(corners[1:] - corners[0])) / (2 if dim == 2 else 6)
                squares = sum(np.sum((corners[i] - corners[j]) ** 2) for i in range(dim + 1) for j in range(i))
                qualities.append(4 * 3 ** 0.5 * volume / squares if dim == 2 else 12 * (3 * volume) ** (2 / 3) / squares)
            self.assertAlmostEqual(reported["min_quality"], min(qualities), delta=1e-9)
            self.assertAlmostEqual(reported["mean_quality"], np.mean(qualities), delta=1e-9)
            self.assertEqual(sum(found["histograms"]["edge_length"]["count"]), len(pairs))
            self.assertEqual(sum(found["histograms"]["metric_quality"]["count"]), len(mesh.elements))
            self.assertIn("edges of unit length", self.check(mesh, "--metric", "m.sol", code=0).stdout)
        other = self.folder.camber("check", self.write(lattice(3, 1)), "--metric", "m.sol")
        self.assertEqual(other.returncode, 3)
        self.assertRegex(other.stderr, "^camber: m.sol: has 27 rows, the mesh 8 vertices")

    def test_curved_lengths_and_qualities_in_a_constant_metric_match_numpy(self):
        """Reference values: Euclidean ones of the transformed curves and elements."""
        for dim, n in ((2, 3), (3, 2)):
            mesh = elevated(lattice(dim, n), self.random, 0.06)
            root = self.random.normal(size=(dim, dim)) + 3 * np.eye(dim)
            tensor = root.T @ root
            row = " ".join(repr(float(tensor[i, j])) for i in range(dim) for j in range(i + 1))
            vertices = 1 + max(v for e in mesh.elements for v in e[:dim + 1])
            solution = f"MeshVersionFormatted 2\nDimension {dim}\nSolAtVertices\n{vertices}\n1 3\n"
            (self.folder.path / "m.sol").write_text(solution + (row + "\n") * vertices + "End\n")
            found = self.report(mesh, "--metric", "m.sol", "--worst", "3")
            reported = found["curved_unit_mesh"]
            sign = np.sign(np.linalg.det(root))  # a reflection inverts elements
            points = mesh.points @ root.T
            local = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)][:3 * (dim - 1)]
            curves = {tuple(sorted((e[i], e[j]))): e[dim + 1 + k] for e in mesh.elements for k, (i, j) in enumerate(local)}
            t = (np.arange(2000) + 0.5)[:, None] / 2000
            speed = lambda a, m, b: np.linalg.norm((4 * t - 3) * a + 4 * (1 - 2 * t) * m + (4 * t - 1) * b, axis=1)
            lengths = np.array([speed(points[a], points[m], points[b]).mean() for (a, b), m in curves.items()])
            self.assertEqual(reported["edges"], len(curves))
            self.assertEqual(reported["unit_edges"], np.count_nonzero((lengths >= 0.5 ** 0.5) & (lengths <= 2 ** 0.5)))
            for key, value in (("shortest", lengths.min()), ("longest", lengths.max()), ("mean_length", lengths.mean())):
                self.assertAlmostEqual(reported[key], value, delta=1e-3 * value)  # quadrature with three points
            regular = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0.75 ** 0.5, 0], [0.5, 0.75 ** 0.5 / 3, (2 / 3) ** 0.5]])
            regular = regular[:dim + 1, :dim]
            slopes = np.vstack([-np.ones(dim), np.eye(dim)]) @ np.linalg.inv((regular[1:] - regular[0]).T)

            def quality(element, at):
                gradients = [(4 * at[i] - 1) * slopes[i] for i in range(dim + 1)]
                gradients += [4 * (at[i] * slopes[j] + at[j] * slopes[i]) for i, j in local]
                a = points[list(element)].T @ np.array(gradients)
                det = sign * np.linalg.det(a)
                return np.sign(det) * dim * abs(det) ** (2 / dim) / (a ** 2).sum()

            corners = np.eye(dim + 1)
            rule = [(w, 1 / 20) for w in corners] + [((1 - w) / 2, 2 / 15) for w in corners] + [(np.full(3, 1 / 3), 9 / 20)]
            if dim == 3:
                rule = [(w, 1 / 40) for w in corners] + [((1 - w) / 3, 9 / 40) for w in corners]
            qualities, least = [], []
            for element in mesh.elements:
                at = [quality(element, xi) for xi, _ in rule]
                least.append(min(at))
                qualities.append(1 / sum(w / q for q, (_, w) in zip(at, rule)) if min(at) > 0 else 0)
            self.assertGreater(min(least), 0)
            self.assertAlmostEqual(reported["mean_quality"], np.mean(qualities), delta=1e-9)
            self.assertEqual([w["element"] for w in reported["worst"]], [int(e) + 1 for e in np.argsort(qualities)[:3]])
            for w in reported["worst"]:
                self.assertAlmostEqual(w["quality"], qualities[w["element"] - 1], delta=1e-9)
                samples = [quality(mesh.elements[w["element"] - 1], xi)
                           for xi in self.random.dirichlet(np.ones(dim + 1), 300)]
                self.assertLess(w["bound"], min(samples))
                self.assertLessEqual(w["bound"], w["least"])
                self.assertLessEqual(w["least"], least[w["element"] - 1] + 1e-9)
            self.assertLessEqual(reported["bound"], min(w["bound"] for w in reported["worst"]))
            self.assertLessEqual(reported["bound"], reported["lowest"]["least"])
            self.assertLessEqual(reported["lowest"]["least"], min(least) + 1e-9)
            self.assertEqual(sum(found["histograms"]["curved_edge_length"]["count"]), len(curves))
            self.assertEqual(sum(found["histograms"]["curved_metric_quality"]["count"]), len(mesh.elements))
            text = self.check(mesh, "--metric", "m.sol").stdout
            self.assertIn("along the curves", text)
            # Values of elevated straight meshes equal the straight ones.
            found = self.report(elevated(lattice(dim, n)), "--metric", "m.sol", code=0)
            for key, value in found["unit_mesh"].items():
                if key not in ("metric", "worst_element"):
                    self.assertAlmostEqual(found["curved_unit_mesh"][key], value, delta=1e-12)
            self.assertNotIn("curved_unit_mesh", self.report(lattice(dim, n), "--metric", "m.sol", code=0))

    def two_bodies(self, dim, gap, bow, listed=True):
        """Two quadratic cubes (squares) side by side along x. Mid nodes on the facing side of the first are moved by
        `bow` towards the second. All elements stay valid."""
        one = lattice(dim, 2)
        number = len(one.points)
        away = np.array([2 + gap, 0.13, 0.07][:dim])  # shifted, so that rims do not touch
        both = Mesh(np.concatenate([one.points, one.points + away]),
                    one.elements + [tuple(v + number for v in e) for e in one.elements],
                    one.facets + [tuple(v + number for v in f) for f in one.facets])
        mesh = elevated(both)
        mesh.facet_references = [7] * len(one.facets) + [8] * len(one.facets)
        ends = both.points
        for facet in mesh.facets[:len(one.facets)]:
            corners, nodes = facet[:dim], facet[dim:]
            if all(ends[v][0] == 2 for v in corners):
                for node in nodes:
                    if all(0 < x < 2 for x in mesh.points[node][1:]):
                        mesh.points[node][0] = 2 + bow
        if not listed:
            mesh.facets, mesh.facet_references = [], []
        return mesh, len(one.facets)

    def test_check_reports_crossing_boundaries_of_valid_elements(self):
        for dim in (2, 3):
            for listed in (True, False):
                mesh, facets = self.two_bodies(dim, gap=0.1, bow=0.15, listed=listed)
                found = self.report(mesh, code=1)
                self.assertEqual((found["invalid"], found["undecided"]), (0, 0))
                self.assertTrue(found["soundness"]["sound"])
                self.assertFalse(found["all_good"])
                crossings = found["crossings"]
                self.assertEqual((crossings["facets"], crossings["undecided"]), (2 * facets, 0))
                self.assertEqual(crossings["crossing"], len(crossings["found"]))
                self.assertGreater(crossings["crossing"], 0)
                for pair in crossings["found"]:
                    self.assertEqual(pair["verdict"], "crossing")
                    self.assertFalse(pair["also_when_straight"])
                    self.assertTrue(all(all(1.99 < mesh.points[v - 1][0] < 2.11 for v in side)
                                        for side in pair["vertices"]), pair)
                    if listed:
                        self.assertEqual(pair["references"], [7, 8])
                        self.assertEqual([sorted(mesh.facets[f - 1][:dim]) for f in pair["facets"]],
                                         [sorted(v - 1 for v in side) for side in pair["vertices"]])
                    else:
                        self.assertEqual(pair["facets"], [0, 0])
                text = self.check(mesh, code=1).stdout
                self.assertIn("pass through each other: only when curved", text)
            for gap, bow in ((0.1, 0.05), (0.25, 0.15)):
                clear = self.report(self.two_bodies(dim, gap, bow)[0], code=0)["crossings"]
                self.assertEqual((clear["crossing"], clear["undecided"], clear["found"]), (0, 0, []))

    def test_check_distinguishes_crossing_and_touching_boundaries_of_straight_meshes(self):
        for dim in (2, 3):
            one = lattice(dim, 1)
            for move, verdict in (([0.5, 0.3, 0.2], "crossing"), ([1, 0.3, 0.2], "touching")):
                number = len(one.points)
                both = Mesh(np.concatenate([one.points, one.points + move[:dim]]),
                            one.elements + [tuple(v + number for v in e) for e in one.elements],
                            one.facets + [tuple(v + number for v in f) for f in one.facets])
                code = 1 if verdict == "crossing" else 0  # touching is reported and allowed, since slits touch
                found = self.report(both, code=code)["crossings"]
                self.assertTrue(any(pair["verdict"] == verdict and pair["also_when_straight"] for pair in found["found"]))
                self.assertEqual((found["undecided"], found["truncated"]), (0, 0))
                self.assertIn("repair the straight mesh" if verdict == "crossing" else "touch: contact",
                              self.check(both, code=code).stdout)

    def overlapping_bodies(self, dim):
        """Named pairs of bodies that overlap without crossing boundaries."""
        body, inner = lattice(dim, 3), lattice(dim, 2)
        yield "half inside, sides in common planes", joined(body, moved(body, [1.53] + [0] * (dim - 1)))
        yield "inside", joined(body, moved(inner, [1.13] * dim, 0.2))
        yield "inside, with a common side", joined(body, moved(inner, [0] + [1.13] * (dim - 1), 0.2))
        yield "twice", joined(lattice(dim, 1), lattice(dim, 1))  # coincident inner vertices are an error

    def separate_bodies(self, dim):
        body = lattice(dim, 3)
        centre = [e for e in body.elements if (abs(body.points[list(e)] - 1.5) < 1).all()]
        hollow = with_boundary(Mesh(body.points, [e for e in body.elements if e not in centre], []))
        yield "apart", joined(body, moved(body, [3.5, 0.31, 0.17][:dim]))
        yield "in a cavity, with a gap", joined(hollow, moved(lattice(dim, 2), [1.2] * dim, 0.3))
        yield "with matching sides", joined(body, moved(body, [3] + [0] * (dim - 1)))
        yield "with sides that do not match", joined(body, moved(body, [3, 0.31, 0.17][:dim]))
        filling = lattice(dim, 2)
        filling.points = 1 + (filling.points / 2) ** 1.3  # no common node positions with the other body
        yield "filling a cavity", joined(hollow, filling)

    def variants(self, mesh, may_be_bare, may_be_bent):
        """The mesh in its order, permuted, without facets, elevated, and elevated and bent."""
        yield "straight", mesh
        yield "permuted", permuted(mesh, self.random)[0]
        yield "degree 2", elevated(mesh)
        if may_be_bare:
            bare = copy.copy(mesh)
            bare.facets = bare.facet_references = []
            yield "without facets", bare
        if may_be_bent:
            bent = elevated(mesh)
            bent.points = bent.points + 0.1 * np.sin(bent.points[:, ::-1])
            yield "bent", bent

    def test_check_reports_overlapping_elements(self):
        for dim in (2, 3):
            for name, mesh in self.overlapping_bodies(dim):
                # Bent non-matching sides cross, and vertices on unlisted sides are an error: these variants are omitted.
                for variant, each in self.variants(mesh, name == "inside", name in ("inside", "twice")):
                    with self.subTest(name, dim=dim, variant=variant):
                        self.check_overlap(each, is_bent=variant == "bent")

    def check_overlap(self, mesh, is_bent):
        found = self.report(mesh, code=1)
        self.assertTrue(found["soundness"]["sound"])
        self.assertFalse(found["all_good"])
        self.assertEqual(found["crossings"]["crossing"], 0)
        overlaps = found["overlaps"]
        self.assertTrue(overlaps["examined"])
        self.assertEqual(overlaps["undecided"], 0)
        self.assertGreater(overlaps["overlapping"], 0)
        self.assertGreater(len(overlaps["found"]), 0)
        for pair in overlaps["found"]:
            first, second = pair["elements"]
            self.assertLess(first, second)
            self.assertEqual(pair["references"], [mesh.element_references[e - 1] for e in (first, second)])
            for element in (first, second):
                corners = mesh.points[list(mesh.elements[element - 1][:mesh.dim + 1])]
                weights = np.linalg.solve((corners[1:] - corners[0]).T, np.array(pair["point"]) - corners[0])
                self.assertGreater(min(1 - weights.sum(), weights.min()), -0.2 if is_bent else -1e-9)
        first = overlaps["found"][0]["elements"]
        kind = "triangles" if mesh.dim == 2 else "tetrahedra"
        self.assertTrue(found["answer"].startswith(f"NO: elements overlap: {kind} {first[0]} and {first[1]} overlap at ("))
        self.assertIn("! overlaps", self.check(mesh, code=1).stdout)

    def test_bodies_that_touch_or_lie_in_cavities_do_not_overlap(self):
        for dim in (2, 3):
            for name, mesh in self.separate_bodies(dim):
                is_apart = name in ("apart", "in a cavity, with a gap")
                for variant, each in self.variants(mesh, is_apart, is_apart or name == "with matching sides"):
                    with self.subTest(name, dim=dim, variant=variant):
                        overlaps = self.report(each, code=0)["overlaps"]
                        self.assertEqual((overlaps["examined"], overlaps["undecided"], overlaps["overlapping"]),
                                         (True, 0, 0))
                        self.assertEqual(overlaps["found"], [])

    def test_check_reports_elements_that_are_only_misoriented(self):
        for dim in (2, 3):
            for name, mesh in (("straight", lattice(dim, 2)), ("quadratic", elevated(lattice(dim, 2)))):
                for count in (1, len(mesh.elements)):
                    with self.subTest(name, dim=dim, count=count):
                        straight = with_boundary(lattice(dim, 2))
                        for e in range(count):
                            straight.elements[e] = straight.elements[e][1::-1] + straight.elements[e][2:]
                        answer = self.report(straight if name == "straight" else elevated(straight), code=1)["answer"]
                        self.assertIn(f"{count} of {len(mesh.elements)} elements", answer)
                        self.assertIn("oriented the wrong way round, and valid otherwise", answer)
                        self.assertNotIn("repair the straight mesh", answer)
        tangled = with_boundary(lattice(2, 3))
        tangled.elements[0] = tangled.elements[0][1::-1] + tangled.elements[0][2:]
        tangled.points[5] = tangled.points[5] + 2.5  # an inner vertex: its elements are inverted in any orientation
        self.assertNotIn("valid otherwise", self.report(tangled, code=1)["answer"])

    def test_overlaps_are_found_despite_missing_facets_and_reversed_elements(self):
        """Missing facets are added and reversed elements reoriented first."""
        mesh = joined(lattice(3, 3), moved(lattice(3, 2), [1.13] * 3, 0.2))
        mesh.facets, mesh.facet_references = mesh.facets[:-5], mesh.facet_references[:-5]
        mesh.elements[7] = mesh.elements[7][1::-1] + mesh.elements[7][2:]
        found = self.report(mesh, code=1)
        self.assertGreater(found["soundness"]["missing_facets"], 0)
        self.assertEqual(found["soundness"]["reversed_elements"], 1)
        self.assertEqual(found["overlaps"]["overlapping"], 1)

    def test_runs_on_overlapping_elements_exit_with_code_1(self):
        for dim in (2, 3):
            for mesh, code in ((joined(lattice(dim, 3), moved(lattice(dim, 2), [1.13] * dim, 0.2)), 1),
                               (joined(lattice(dim, 3), moved(lattice(dim, 2), [4] + [0] * (dim - 1), 0.2)), 0)):
                name = self.write(mesh)
                for verb in (("curve",), ("remesh", "--metric", "0.7")):
                    done = self.folder.camber(verb[0], name, "-o", "out.mesh", "--report", "r.json", *verb[1:])
                    self.assertEqual(done.returncode, code, done.stderr)
                    report = json.loads((self.folder.path / "r.json").read_text())
                    self.assertEqual("overlaps" in report, code == 1)
                    self.assertEqual("elements overlap in 1 place, one at (" in done.stderr, code == 1)
                    self.assertEqual(self.folder.camber("check", "out.mesh").returncode, code)

    def test_verdicts_and_witnesses_equal_those_of_the_oracle(self):
        for dim, n, amplitude in ((2, 4, 0.4), (3, 2, 0.35)):
            mesh = elevated(lattice(dim, n), self.random, amplitude)
            expected = verdicts(mesh)
            self.assertGreater(expected.count("invalid"), 2)
            self.assertGreater(expected.count("valid"), 2)
            found = self.report(mesh, "--elements", "--worst", "1000", code=1)
            self.assertEqual(found["element_verdicts"]["verdict"], expected)
            self.assertEqual(found["invalid_elements"], [i + 1 for i, w in enumerate(expected) if w == "invalid"])
            self.assertEqual((found["valid"], found["invalid"], found["undecided"]),
                             tuple(expected.count(w) for w in ("valid", "invalid", "undecided")))
            self.assertEqual(sum(found["histograms"]["scaled_jacobian"]["count"]), len(mesh.elements))
            self.assertEqual([w["element"] for w in found["worst"]], sorted(
                (w["element"] for w in found["worst"]),
                key=lambda e: next((v["verdict"] == "valid", v["min_scaled_jacobian"], e) for v in found["worst"]
                                   if v["element"] == e)))
            for worst in found["worst"]:
                element = worst["element"] - 1
                self.assertEqual(worst["verdict"], expected[element])
                self.assertEqual(worst["vertices"], [v + 1 for v in mesh.elements[element][:dim + 1]])
                witness = worst["witness"]
                value = scaled_jacobian(mesh, element, witness["barycentric"])
                self.assertAlmostEqual(value, witness["scaled_jacobian"], delta=1e-9)
                self.assertEqual(value <= 0, worst["verdict"] == "invalid")
                # The witness is near the minimum: the certified bound is just below.
                self.assertLessEqual(worst["min_scaled_jacobian"], value)
                self.assertLess(value - worst["min_scaled_jacobian"], 4e-3 * max(1, abs(value)))

    # Guards against printed points of invalid elements with det J > 0.
    def test_printed_witnesses_of_invalid_elements_have_no_positive_det_j(self):
        """Evaluates det J at the printed digits of the text and of --json, in fractions of the numbers in the file."""
        for dim, n, amplitude, scale in ((2, 3, 0.4, 1.0), (3, 1, 0.4, 1e-40), (3, 1, 0.3, 1e40)):
            mesh = elevated(lattice(dim, n), self.random, amplitude)
            mesh.points = mesh.points * scale
            # Barely invalid elements: a node at the limit where det J vanishes at a vertex.
            first = mesh.elements[0]
            mid, a, b = first[dim + 1], first[0], first[1]
            mesh.points[mid] = mesh.points[a] + 0.25 * (mesh.points[b] - mesh.points[a])
            found = self.report(mesh, "--worst", "100", code=1)
            failing = [w for w in found["worst"] if w["verdict"] == "invalid"]
            self.assertEqual(len(failing), found["invalid"])
            self.assertGreater(len(failing), 0)
            lines = self.check(mesh, "--worst", "100").stdout.splitlines()
            for worst in failing:
                element = worst["element"] - 1
                row = next(line for line in lines if re.match(rf" +{worst['element']} +\S+ +invalid ", line))
                printed = [Fraction(x) for x in re.search(r"\(([^)]*)\);", row)[1].split(", ")]
                for weights in (printed, [Fraction(x) for x in worst["witness"]["barycentric"]]):
                    value, straight = exact_jacobian(mesh, element, weights)
                    self.assertLessEqual(value, 0)
                    if straight != 0:
                        reported = Fraction(worst["witness"]["scaled_jacobian"])
                        self.assertGreaterEqual(reported, value / abs(straight))
                        self.assertLessEqual(reported, 0)
                least = float(row.split()[3])
                self.assertLessEqual(least, worst["min_scaled_jacobian"])

    # Guards against a negative smallest scaled Jacobian together with "0 invalid".
    def test_the_bound_of_a_valid_element_with_det_j_near_zero_is_positive(self):
        """det J almost vanishes inside the element, and a required bound is not met."""
        straight = elevated(Mesh([[0, 0], [1, 0], [0, 1]], [(0, 1, 2)], [(0, 1), (1, 2), (2, 0)]))
        tested = 0
        while tested < 2:
            mesh, moves = copy.deepcopy(straight), self.random.normal(size=(3, 2))

            def bent(size):
                mesh.points[3:] = straight.points[3:] + size * moves
                return mesh

            low, high = 0.0, 4.0
            for _ in range(24):
                middle = (low + high) / 2
                low, high = (middle, high) if verdicts(bent(middle)) == ["valid"] else (low, middle)
            bent(low * (1 - 1e-4))
            if min(scaled_jacobian(mesh, 0, corner) for corner in np.eye(3)) < 0.1:
                continue
            tested += 1
            for bound, verdict in (("0", "valid"), ("0.1", "invalid")):
                found = self.report(mesh, "--min-scaled-jacobian", bound)
                self.assertEqual(found[verdict], 1)
                self.assertGreater(found["min_scaled_jacobian"], 0)
                self.assertLess(found["min_scaled_jacobian"], 1e-2)
                self.assertGreater(found["worst"][0]["min_scaled_jacobian"], 0)

    def test_worst_limits_the_list_of_worst_elements(self):
        mesh = elevated(lattice(3, 2), self.random, 0.2)
        all_of_them = self.report(mesh, "--worst", "1000")["worst"]
        few = self.report(mesh, "--worst", "4")["worst"]
        self.assertEqual(few, all_of_them[:4])
        self.assertEqual(self.report(mesh, "--worst", "0")["worst"], [])
        self.assertEqual(len(self.report(mesh)["worst"]), 10)

    def test_check_reports_one_broken_element_by_its_number(self):
        mesh = elevated(lattice(3, 2), self.random, 0.02)
        self.check(mesh, code=0)
        element = 17
        mid = mesh.elements[element][9]
        mesh.points[mid] += 3 * (mesh.points[mesh.elements[element][0]] - mesh.points[mid])
        around = [i + 1 for i, row in enumerate(mesh.elements) if mid in row[4:]]
        found = self.report(mesh, code=1)
        self.assertIn(element + 1, found["invalid_elements"])
        self.assertLessEqual(set(found["invalid_elements"]), set(around))
        self.assertIn(found["worst"][0]["element"], around)
        self.assertIn("of the straight element's", found["worst"][0]["reason"])
        text = self.check(mesh).stdout
        self.assertRegex(text, rf"\n +{found['worst'][0]['element']} +1 +invalid ")
        self.assertRegex(text, r"invalid elements +" + str(found["invalid"]))
        self.assertIn("Scaled Jacobian", text)
        self.assertNotIn("Scaled Jacobian", self.check(mesh, "--no-histogram").stdout)

    def test_results_do_not_depend_on_the_order_of_the_file(self):
        for dim in (2, 3):
            mesh = elevated(lattice(dim, 2), self.random, 0.3)
            other, order = permuted(mesh, self.random)
            one, two = self.report(mesh), self.report(other, "--worst", "5")
            for key in ("valid", "invalid", "undecided", "min_scaled_jacobian", "vertices", "nodes", "histograms"):
                self.assertEqual(one[key], two[key], key)
            self.assertEqual(one["soundness"], two["soundness"])
            self.assertEqual(one["invalid_elements"], sorted(order[e - 1] + 1 for e in two["invalid_elements"]))
            for worst in two["worst"]:  # numbers of the file: mid nodes are among the vertices
                self.assertEqual(worst["vertices"], [v + 1 for v in other.elements[worst["element"] - 1][:dim + 1]])

    def test_vertices_are_reported_by_the_numbers_of_the_file(self):
        mesh, _ = permuted(elevated(lattice(2, 2)), self.random)
        mesh.points = np.vstack([mesh.points[:3], [[9, 9]], mesh.points[3:]])  # an unused vertex
        shift = lambda rows: [tuple(v + (v >= 3) for v in row) for row in rows]
        mesh.elements, mesh.facets = shift(mesh.elements), shift(mesh.facets)
        found = self.report(mesh, code=0)["soundness"]
        self.assertEqual(found["first"], {"unused_vertices": [4]})
        self.assertEqual(found["findings"]["unused_vertices"]["count"], 1)
        self.assertEqual(found["findings"]["unused_vertices"]["text"], "vertex 4 belongs to no entity")

    def test_check_reports_coincident_nodes(self):
        mesh = elevated(lattice(2, 2))
        moved, vertex = mesh.elements[0][3], mesh.elements[5][2]
        mesh.points[moved] = mesh.points[vertex]
        found = self.report(mesh, code=1)["soundness"]
        self.assertEqual(found["first"]["coincident_nodes"], [moved + 1, vertex + 1])
        self.assertFalse(found["sound"])
        self.assertIn(f"! nodes         node {moved + 1} has the same position as node {vertex + 1}", self.check(mesh).stdout)

    def test_nodes_on_both_sides_of_a_slit_are_not_coincident_nodes(self):
        # Two triangles with coincident edges; the boundary is listed on both sides.
        mesh = elevated(Mesh([[0, 0], [1, 0], [0, 1], [1, 0], [0, 1], [1, 1]], [(0, 1, 2), (3, 5, 4)],
                             [(0, 1), (1, 2), (2, 0), (3, 5), (5, 4), (4, 3)]))
        found = self.report(mesh, code=0)["soundness"]
        self.assertEqual(found["first"], {"slit_vertices": [4, 2]})

    def test_check_reports_elements_with_two_facets_on_one_smooth_boundary(self):
        points = [[0, 0, 0], [1, 0, 0], [0.5, 1, -0.05], [0.5, -1, -0.05]]
        element, facets = (0, 2, 1, 3), [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]
        mesh = Mesh(points, [element], facets)
        found = self.report(mesh, code=0)
        self.assertEqual(found["wall_elements"], [1])
        self.assertIn("needs a swap", found["worst"][0]["reason"])
        self.assertIn("- walls         tetrahedron 1 has two triangles on one smooth boundary", self.check(mesh).stdout)
        self.assertEqual(self.report(mesh, "--ridge-angle", "4")["wall_elements"], [])
        mesh.facet_references = [1, 2, 3, 4]  # a separate reference for each facet
        self.assertEqual(self.report(mesh)["wall_elements"], [])
        flat = Mesh([[0, 0], [1, 0], [0.5, 0.05]], [(0, 1, 2)], [(0, 1), (1, 2), (2, 0)])
        found = self.report(elevated(flat), code=0)
        self.assertEqual(found["wall_elements"], [1])
        self.assertIn("two edges on one smooth wall (at vertex 3)", found["worst"][0]["reason"])

    def test_check_accepts_standalone_surfaces_and_open_curves(self):
        corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
        for degree in (1, 2):
            closed = Mesh(corners, [], faces)
            closed = elevated(closed) if degree == 2 else closed
            text = self.check(closed, code=0).stdout
            self.assertIn("triangles, no volume", text)
            self.assertIn("the boundary is closed", text)
            found = self.report(closed, code=0)
            self.assertEqual((found["elements"], found["facets"], found["degree"]), (0, 4, degree))
            self.assertAlmostEqual(found["min_scaled_jacobian"], 1, places=6)
            self.assertEqual((found["valid"], found["invalid"]), (4, 0))
            self.assertEqual(self.report(closed, "--elements")["element_verdicts"]["verdict"], ["valid"] * 4)
            closed.facets = closed.facets[:3]
            closed.facet_references = [1] * 3
            found = self.report(closed, code=0)["soundness"]
            self.assertEqual(found["open_edges"], 3)
        open_curve = Mesh([[0, 0], [1, 0], [1, 1]], [], [(0, 1), (1, 2)])
        self.assertEqual(self.report(open_curve, code=0)["soundness"]["first"]["open_edges"][0], 1)

    def test_check_reports_quality_and_volume_of_straight_elements(self):
        for dim in (2, 3):
            mesh = lattice(dim, 2)
            found = self.report(mesh, "--elements", code=0)
            columns = found["element_verdicts"]
            self.assertEqual(set(columns), {"reference", "verdict", "quality", "volume"})
            self.assertAlmostEqual(sum(columns["volume"]), 2 ** dim)
            for e, row in enumerate(mesh.elements):
                p = mesh.points[list(row)]
                volume = np.linalg.det(p[1:] - p[0]) / (2 if dim == 2 else 6)
                squares = sum(((p[i] - p[j]) ** 2).sum() for i in range(dim + 1) for j in range(i))
                ratio = 4 * 3 ** 0.5 * volume / squares if dim == 2 else 12 * (3 * volume) ** (2 / 3) / squares
                self.assertAlmostEqual(columns["quality"][e], ratio, places=6)
            self.assertEqual(sum(found["histograms"]["quality"]["count"]), len(mesh.elements))
            self.assertIn("Quality", self.check(mesh).stdout)
        equilateral = Mesh([[0, 0], [1, 0], [0.5, 0.75 ** 0.5]], [(0, 1, 2)], [(0, 1), (1, 2), (2, 0)])
        self.assertAlmostEqual(self.report(equilateral)["worst"][0]["quality"], 1, places=6)

    def test_check_reports_flat_and_inverted_elements(self):
        points = [[0, 0], [1, 0], [0, 1], [1, 1], [0.5, 0.5]]
        mesh = Mesh(points, [(0, 1, 2), (1, 3, 2), (1, 4, 2)], [])
        for degree in (1, 2):
            found = self.report(mesh if degree == 1 else elevated(mesh), "--elements", code=1)
            self.assertIn(3, found["straight_inverted_elements"])
            self.assertEqual(found["worst"][0]["element"], 3)
            self.assertIn("flat", found["worst"][0]["reason"])
            if degree == 2:
                self.assertIsNone(found["element_verdicts"]["min_scaled_jacobian"][2])
        inverted = lattice(3, 1)
        a, b, *rest = inverted.elements[2]
        inverted.elements[2] = (b, a, *rest)
        for degree in (1, 2):
            found = self.report(inverted if degree == 1 else elevated(inverted), code=1)
            self.assertEqual((found["invalid_elements"], found["straight_inverted_elements"]), ([3], [3]))
            self.assertEqual(found["straight_inverted"], 1)
            self.assertIn("inverted", found["worst"][0]["reason"])

    def test_elements_prints_a_row_for_each_element(self):
        mesh = elevated(lattice(3, 2), self.random, 0.3)
        done = self.check(mesh, "--elements", code=1)
        rows = list(csv.DictReader(io.StringIO(done.stdout)))
        self.assertEqual([int(r["element"]) for r in rows], list(range(1, len(mesh.elements) + 1)))
        self.assertEqual([r["verdict"] for r in rows], verdicts(mesh))
        columns = self.report(mesh, "--elements")["element_verdicts"]
        self.assertEqual([float(r["min_scaled_jacobian"]) for r in rows], columns["min_scaled_jacobian"])
        self.assertEqual(self.report(mesh).get("element_verdicts"), None)

    def test_a_closed_pipe_is_no_error(self):
        name = self.write(elevated(lattice(3, 6)))
        with subprocess.Popen([CAMBER, "check", name, "--elements"], cwd=self.folder.path, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE) as run:
            run.stdout.readline()
            run.stdout.close()
            self.assertEqual(run.stderr.read(), b"")
            self.assertEqual(run.wait(), 0)

    def test_a_full_standard_output_is_an_error(self):
        name = self.write(elevated(lattice(3, 6)))
        with open("/dev/full", "w", encoding="ascii") as full:
            done = subprocess.run([CAMBER, "check", name], cwd=self.folder.path, stdout=full, stderr=subprocess.PIPE,
                                  text=True, check=False)
        self.assertEqual(done.returncode, 3)
        self.assertIn("standard output: cannot be written", done.stderr)

    def test_min_scaled_jacobian_changes_verdicts_and_rejects_bad_values(self):
        mesh = elevated(lattice(2, 3), self.random, 0.05)
        smallest = self.report(mesh, code=0)["min_scaled_jacobian"]
        self.assertLess(smallest, 1)
        self.assertEqual(self.report(mesh, "--min-scaled-jacobian", smallest - 1e-3, code=0)["invalid"], 0)
        found = self.report(mesh, "--min-scaled-jacobian", smallest + 3e-3, code=1)
        self.assertGreater(found["invalid"], 0)
        self.assertIn("below the bound", found["worst"][0]["reason"])
        for value in ("1", "-0.1", "nan", "much"):
            self.assertEqual(self.check(mesh, "--min-scaled-jacobian", value).returncode, 2, value)

    def test_check_prints_every_soundness_category_of_a_sound_mesh(self):
        text = self.check(elevated(lattice(3, 1)), code=0).stdout
        for concern in ("conformity", "orientation", "nodes", "boundary", "closure", "walls"):
            self.assertRegex(text, rf"\n    {concern} +good: ")

    def test_the_report_does_not_depend_on_the_number_of_threads(self):
        mesh = elevated(lattice(3, 3), self.random, 0.2)
        self.assertEqual(*(self.check(mesh, "--json", "--elements", "--threads", n).stdout for n in (1, 2)))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
