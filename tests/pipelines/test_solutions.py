"""Metrics from solutions, meshes for them, and the transfer of solutions: `camber metric`, `remesh`, `transfer`.

    python3 tests/pipelines/test_solutions.py build/bin/camber [unittest arguments]
"""
import json
import re
import sys
import unittest

from program import Folder, SANITIZED

import gmf  # noqa: E402  (program puts the oracle on the path)
import numpy as np


def front(points):
    return np.tanh((np.hypot(points[:, 0], points[:, 1]) - 0.5) / 0.05)


def quadratic(points):
    return points[:, 0] ** 2 - 3 * points[:, 0] * points[:, 1] + 2 * points[:, 1]


class Solutions(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        cells = 12 if SANITIZED else 30
        self.camber("generate", "rectangle", "-o", "a.meshb", "--set", f"cells=[{cells},{cells}]")
        self.camber("convert", "a.meshb", "-o", "a2.meshb", "--elevate")

    def camber(self, *words, code=0):
        done = self.folder.camber(*words)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def write(self, name, mesh, function):
        values = np.atleast_2d(function(self.points(mesh)).T).T
        rows = "\n".join(" ".join(repr(float(x)) for x in row) for row in values)
        kind = {1: 1, 2: 2}[values.shape[1]]
        (self.folder.path / name).write_text(
            f"MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n{len(values)}\n1 {kind}\n{rows}\nEnd\n")

    def points(self, mesh):
        return gmf.read(self.folder.path / mesh).points

    def values(self, name):
        return gmf.read(self.folder.path / name).fields[0][1]

    def number(self, text, row):
        return float(re.search(rf"^  {row} +([0-9.e+-]+)", text, re.M)[1])

    def test_a_mesh_adapted_to_a_front_has_the_requested_element_count(self):
        for mesh, degree in (("a.meshb", 1), ("a2.meshb", 2)):
            self.write("u.sol", mesh, front)
            output = self.camber("metric", mesh, "--solution", "u.sol", "-o", "m.sol", "--elements", 1000, "--gradation", 2)
            requested, reached = self.number(output, "complexity requested"), self.number(output, "complexity")
            self.assertLess(abs(reached / requested - 1), 0.01)
            self.assertEqual(len(self.values("m.sol")), len(self.points(mesh)))
            self.camber("remesh", mesh, "--metric", "m.sol", "--geometry", "straight", "-o", f"b{degree}.meshb")
            made = gmf.read(self.folder.path / f"b{degree}.meshb")
            cells = made.cells["Triangles" if degree == 1 else "TrianglesP2"].nodes
            self.assertLess(abs(len(cells) / 1000 - 1), 0.35, degree)
            self.camber("transfer", mesh, f"b{degree}.meshb", "--solution", "u.sol", "-o", "v.sol")
            off = np.abs(self.values("v.sol")[:, 0] - front(made.points))
            self.assertLess(off.max(), 0.5 if SANITIZED else 0.15)

    def test_the_metric_does_not_depend_on_the_unit_of_the_solution(self):
        rows = []
        for unit in (1, 2.0 ** 660, 2.0 ** -660):
            self.write("u.sol", "a2.meshb", lambda p, unit=unit: front(p) * unit)
            self.camber("metric", "a2.meshb", "--solution", "u.sol", "-o", "m.sol", "--elements", 800)
            rows.append(self.values("m.sol"))
        self.assertTrue((rows[0] == rows[1]).all() and (rows[0] == rows[2]).all())

    def test_quadratics_are_transferred_exactly_and_give_no_metric_of_degree_2(self):
        self.write("u.sol", "a2.meshb", quadratic)
        output = self.camber("metric", "a2.meshb", "--solution", "u.sol", "-o", "m.sol", code=2)
        self.assertIn("nothing to adapt to", output)
        self.camber("metric", "a2.meshb", "--solution", "u.sol", "-o", "m.sol", "--degree", 1, "--elements", 400)
        self.camber("remesh", "a2.meshb", "--metric", "m.sol", "--geometry", "straight", "-o", "b.meshb")
        for method in ("interpolate", "conserve"):
            self.camber("transfer", "a2.meshb", "b.meshb", "--solution", "u.sol", "-o", "v.sol", "--method", method)
            off = np.abs(self.values("v.sol")[:, 0] - quadratic(self.points("b.meshb")))
            self.assertLess(off.max(), 1e-12, method)

    def test_transfer_to_the_same_mesh_preserves_fields_bit_for_bit(self):
        self.write("u.sol", "a2.meshb", lambda p: np.stack([front(p), quadratic(p)], 1))
        for method in ("interpolate", "conserve"):
            self.camber("transfer", "a2.meshb", "a2.meshb", "--solution", "u.sol", "-o", "v.sol", "--method", method)
            self.assertTrue((self.values("v.sol") == self.values("u.sol")).all())

    def test_fields_of_a_mesh_file_are_selected_by_name(self):
        self.write("u.sol", "a2.meshb", front)
        self.camber("convert", "a2.meshb", "-o", "u.vtu", "--metric", "u.sol")
        one = self.camber("metric", "u.vtu", "--solution", "u.vtu", "--fields", "size", "-o", "m.vtu")
        other = self.camber("metric", "a2.meshb", "--solution", "u.sol", "-o", "m.sol")
        self.assertEqual(self.number(one, "complexity"), self.number(other, "complexity"))
        self.assertIn('"metric"', self.camber("info", "m.vtu"))

    def test_max_anisotropy_raises_the_default_limit_of_1e5(self):
        """The requested anisotropy exceeds the default limit for derivatives."""
        self.camber("generate", "rectangle", "-o", "s.meshb", "--set", "cells=[16,16]", "--set", "high=[1,1e-6]")
        self.write("u.sol", "s.meshb", lambda p: np.tanh((p[:, 1] / 1e-6 - 0.5) / 0.2) + np.sin(3 * p[:, 0]))
        anisotropy = [self.number(self.camber("metric", "s.meshb", "--solution", "u.sol", "-o", "m.sol", "--elements", 800,
                                              "--max-anisotropy", bound), "largest anisotropy") for bound in (0, 1e8)]
        self.assertLessEqual(anisotropy[0], 1.001e5)
        self.assertGreater(anisotropy[1], 1e6)

    def test_sizes_by_reference_are_fixed_parts_of_the_complexity(self):
        self.write("u.sol", "a.meshb", front)
        output = self.camber("metric", "a.meshb", "--solution", "u.sol", "-o", "m.sol", "--size", "1=0.01", "--elements", 5000)
        self.assertGreater(self.number(output, "of fixed metrics"), 10)
        tensors = self.values("m.sol")
        self.assertGreaterEqual(np.minimum(tensors[:, 0], tensors[:, 2]).max(), 0.99e4)

    def test_remesh_with_a_solution_equals_metric_remesh_and_transfer(self):
        """The files equal those of metric, remesh and transfer in sequence."""
        for mesh in ("a.meshb", "a2.meshb"):
            self.write("u.sol", mesh, front)
            options = ("--complexity", 300, "--gradation", 2, "--size", "1,3=0.03")
            self.camber("metric", mesh, "--solution", "u.sol", "-o", "m.sol", *options)
            self.camber("remesh", mesh, "--metric", "m.sol", "-o", "b.mesh", "--geometry", "straight")
            self.camber("transfer", mesh, "b.mesh", "--solution", "u.sol", "-o", "v.sol", "--method", "conserve")
            output = self.camber("remesh", mesh, "--solution", "u.sol", "--metric", "solution", *options, "--transfer", "conserve",
                               "-o", "c.mesh", "--output-solution", "w.sol", "--geometry", "straight")
            self.assertIn("wrote w.sol", output)
            for one, other in (("b.mesh", "c.mesh"), ("v.sol", "w.sol")):
                self.assertEqual((self.folder.path / one).read_bytes(), (self.folder.path / other).read_bytes(), other)

    def test_metrics_are_read_from_every_format_that_stores_them(self):
        for mesh in ("a.meshb", "a2.meshb"):
            self.write("u.sol", mesh, front)
            made = []
            for file in ("m.sol", "m.solb", "m.vtu", "m.msh"):
                self.camber("metric", mesh, "--solution", "u.sol", "-o", file, "--complexity", 200)
                self.camber("remesh", mesh, "--metric", file, "-o", "b.mesh", "--output-metric", "n.sol")
                self.assertIn("unit", self.camber("check", mesh, "--metric", file))
                made.append((self.folder.path / "b.mesh").read_bytes())
            self.assertEqual(made, made[:1] * 4)
            output = self.camber("metric", mesh, "--solution", "u.sol", "-o", "m.cgns", code=2)
            self.assertIn("cannot store tensors", output)
            self.assertFalse((self.folder.path / "m.cgns").exists())
        self.camber("convert", "a.meshb", "-o", "plain.vtu")
        self.assertIn("no metric", self.camber("remesh", "a.meshb", "--metric", "plain.vtu", "-o", "b.mesh", code=3))

    def test_a_field_that_is_named_twice_is_transferred_once(self):
        self.write("u.sol", "a2.meshb", front)
        self.camber("remesh", "a2.meshb", "--solution", "u.sol", "--fields", "field_1,field_1", "--metric", 0.1, "-o", "b.meshb",
                    "--output-solution", "v.sol")
        self.assertEqual(self.values("v.sol").shape[1], 1)

    def test_fields_of_the_input_are_transferred_if_the_output_stores_fields(self):
        self.write("u.sol", "a.meshb", lambda p: np.stack([front(p), quadratic(p)], 1))
        self.camber("convert", "a.meshb", "-o", "u.vtu", "--metric", "u.sol")
        self.assertIn("fields transferred", self.camber("remesh", "u.vtu", "--metric", 0.1, "-o", "v.vtu"))
        self.assertIn('"field_1"', self.camber("info", "v.vtu"))
        self.assertIn("field_1", self.camber("curve", "u.vtu", "-o", "w.msh"))
        self.assertIn('"field_1"', self.camber("info", "w.msh"))
        output = self.camber("remesh", "u.vtu", "--metric", 0.1, "-o", "v.meshb")
        self.assertIn("not written", output)
        self.assertNotIn("fields transferred", output)

    def test_fields_of_a_standalone_surface_are_dropped_with_a_note(self):
        points = [(x, y, 0.1 * (x * x + y * y)) for y in range(4) for x in range(4)]
        cells = [t for y in range(3) for x in range(3) for a in [4 * y + x + 1]
                 for t in ((a, a + 1, a + 5), (a, a + 5, a + 4))]
        text = "\n".join(["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(points)), *(f"{x} {y} {z} 0" for x, y, z in points),
                          "Triangles", str(len(cells)), *(f"{a} {b} {c} 1" for a, b, c in cells), "End\n"])
        (self.folder.path / "s.mesh").write_text(text)
        rows = "\n".join(str(x) for x, _, _ in points)
        (self.folder.path / "s.sol").write_text(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(points)}\n1 1\n{rows}\nEnd\n")
        self.camber("convert", "s.mesh", "-o", "s.vtu", "--metric", "s.sol")
        self.assertIn("1 fields of the file were omitted", self.camber("curve", "s.vtu", "-o", "t.vtu"))
        self.assertIn("without tetrahedra", self.camber("metric", "s.mesh", "--solution", "s.sol", "-o", "m.sol", code=3))

    def test_a_config_combines_solution_metric_sizes_and_transfer(self):
        self.write("u.sol", "a2.meshb", front)
        self.write("h.sol", "a2.meshb", lambda p: 0.02 + p[:, 0])
        config = {"input": {"mesh": "a2.meshb"}, "solution": {"file": "u.sol", "fields": ["field_1"]},
                  "metric": {"solution": {"elements": 1500, "gradation": 2, "norm": 0, "intersect": ["h.sol"]}},
                  "metric_operations": [{"intersect": {"sizes": [{"references": [2], "size": 0.05}]}},
                                        {"intersect": {"geometry": {"chord_error": 0.001}}}],
                  "stages": ["remesh"],
                  "output": {"mesh": "b.mesh", "vtu": "b.vtu", "solution": "v.solb", "metric": "m.sol", "report": "r.json"}}
        (self.folder.path / "c.json").write_text(json.dumps(config))
        self.camber("run", "c.json", "--dry-run")
        self.camber("run", "c.json")
        report = json.loads((self.folder.path / "r.json").read_text())
        self.assertLess(abs(report["solution_metric"]["complexity"] / report["solution_metric"]["requested_complexity"] - 1), 0.01)
        self.assertEqual(report["transfer"]["fields"], ["field_1"])
        made = gmf.read(self.folder.path / "b.mesh").points
        tensors, left = self.values("m.sol"), made[:, 0] == 0
        self.assertGreater(left.sum(), 20)
        self.assertGreater(0.02 ** 2 * np.minimum(tensors[left, 0], tensors[left, 2]).min(), 0.9)

    def test_wrong_solution_arguments_are_rejected_with_their_place(self):
        self.write("u.sol", "a.meshb", front)
        self.write("constant.sol", "a.meshb", lambda p: 0 * p[:, 0] + 7)
        cases = ((("metric", "a.meshb", "--solution", "constant.sol", "-o", "m.sol"), 2, "nothing to adapt to"),
                 (("metric", "a2.meshb", "--solution", "none.sol", "-o", "m.sol"), 3, "none.sol"),
                 (("metric", "a.meshb", "--solution", "u.sol", "-o", "m.sol", "--degree", 2), 2, "third derivatives"),
                 (("metric", "a.meshb", "--solution", "u.sol", "-o", "m.mesh"), 2, "cannot store fields"),
                 (("metric", "a.meshb", "--solution", "u.sol", "-o", "m.sol", "--fields", "mach"), 2, "field_1"),
                 (("metric", "a.meshb", "--solution", "u.sol", "-o", "m.sol", "--size", "9=1"), 2, "reference 9"),
                 (("metric", "a.meshb", "--solution", "u.sol", "-o", "m.sol", "--size", "wall"), 2, "--size wall"),
                 (("metric", "a.meshb", "--solution", "u.sol", "-o", "m.sol", "--intersect", "a2.sol"), 3, "a2.sol"),
                 (("remesh", "a.meshb", "--metric", "solution", "-o", "b.meshb"), 2, "/solution: there is no solution"),
                 (("remesh", "a.meshb", "--solution", "constant.sol", "--metric", "solution", "-o", "b.meshb"), 2, "nothing to adapt to"),
                 (("remesh", "a.meshb", "--solution", "u.sol", "--output-solution", "u.mesh", "-o", "b.meshb"), 2, "cannot store fields"),
                 (("remesh", "a.meshb", "--solution", "u.sol", "--output-solution", "u.sol", "-o", "b.meshb"), 2, "u.sol"),
                 (("transfer", "a.meshb", "a2.meshb", "--solution", "u.sol", "-o", "u.sol"), 2, "u.sol"))
        for words, code, text in cases:
            self.assertIn(text, self.camber(*words, code=code), words)
        self.assertNotIn("m.sol", self.folder.files())


class KnownSolutions(unittest.TestCase):
    """Inner nodes placed for the best interpolation of a known solution."""
    WALL, SMOOTH = "exp(-(sqrt(x^2+y^2)-1)/0.3)", "(x/4)^3"

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.run_camber("generate", "annulus", "-o", "ring.mesh", "--set", "inner_size=0.25", "--set", "outer_size=0.4")

    def run_camber(self, *words, code=0):
        done = self.folder.camber(*words)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def errors(self, mesh, *fields):
        output = self.run_camber("check", mesh, "--json", *(word for field in fields for word in ("--field", field)))
        return np.array([one["curved"]["l2"]["value"] for one in json.loads(output)["interpolation"]])

    def test_objective_solution_reduces_the_interpolation_error(self):
        self.run_camber("curve", "ring.mesh", "-o", "shape.mesh", "--objective", "shape")
        by_shape = self.errors("shape.mesh", self.WALL, self.SMOOTH)
        for i, field in enumerate((self.WALL, self.SMOOTH)):
            self.run_camber("curve", "ring.mesh", "-o", f"{i}.mesh", "--solution", field)
        wall, smooth = self.errors("0.mesh", self.WALL, self.SMOOTH), self.errors("1.mesh", self.WALL, self.SMOOTH)
        self.assertLess(wall[0], 0.7 * by_shape[0])
        self.assertLess(smooth[1], 0.9 * by_shape[1])

    def test_a_config_gives_the_mesh_of_the_verb_for_any_number_of_threads(self):
        self.run_camber("curve", "ring.mesh", "-o", "verb.mesh", "--solution", self.WALL, "--threads", 2)
        config = {"input": {"mesh": "ring.mesh"}, "solution": {"expression": self.WALL}, "threads": 1, "output": {"mesh": "config.mesh"},
                  "stages": ["elevate", {"curve": {"objective": "solution"}}, "validate", "relax", "commit"]}
        (self.folder.path / "run.json").write_text(json.dumps(config))
        self.run_camber("run", "run.json")
        self.assertEqual((self.folder.path / "verb.mesh").read_bytes(), (self.folder.path / "config.mesh").read_bytes())

    def test_objective_solution_requires_a_solution(self):
        self.assertIn("solution", self.run_camber("curve", "ring.mesh", "-o", "out.mesh", "--objective", "solution", code=2))
        self.assertIn("x+", self.run_camber("curve", "ring.mesh", "-o", "out.mesh", "--solution", "x+", code=2))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
