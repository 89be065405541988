"""camber repair: deliberately broken curved meshes become valid with an unchanged boundary.

    python3 tests/pipelines/test_repair.py build/bin/camber [unittest arguments]
"""
import json
import subprocess
import sys
import unittest

from program import ROOT, SANITIZED, Folder, report_of

import gmf  # noqa: E402  (program puts the oracle on the path)
import numpy as np
from sample_meshes import ascii_file, binary_file, cube, elevate, linear_mesh

ENDS = {2: [(0, 1), (1, 2), (2, 0)], 3: [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]}


def names(mesh):
    return ("TrianglesP2", "EdgesP2") if mesh.dim == 2 else ("TetrahedraP2", "TrianglesP2")


def boundary_nodes(mesh):
    return np.unique(mesh.cells[names(mesh)[1]].nodes)


def mid_nodes(mesh):
    """{mid node: the ends of its edge}"""
    rows = mesh.cells[names(mesh)[0]].nodes
    return {int(row[mesh.dim + 1 + i]): (int(row[a]), int(row[b])) for row in rows
            for i, (a, b) in enumerate(ENDS[mesh.dim])}


def boundary_places(mesh):
    """Node coordinates of the boundary facets, independent of order and numbering."""
    return sorted(sorted(map(tuple, mesh.points[row])) for row in mesh.cells[names(mesh)[1]].nodes)


def throw_volume_nodes(mesh, share, seed=1):
    """Displaces volume nodes by up to `share` chord lengths per coordinate."""
    random = np.random.default_rng(seed)
    boundary = set(boundary_nodes(mesh).tolist())
    for node, (a, b) in sorted(mid_nodes(mesh).items()):
        if node not in boundary:
            chord = np.linalg.norm(mesh.points[b] - mesh.points[a])
            mesh.points[node] += share * chord * random.uniform(-1, 1, mesh.dim)


def bulge(mesh, depth):
    """Moves mid nodes inside the side x = 0 inwards by `depth` edge lengths."""
    boundary = set(boundary_nodes(mesh).tolist())
    for node, (a, b) in mid_nodes(mesh).items():
        y = mesh.points[node][1:]
        if node in boundary and mesh.points[node][0] == 0 and (y > 0).all() and (y < 1).all():
            mesh.points[node][0] += depth * np.linalg.norm(mesh.points[b] - mesh.points[a])


def square(n):
    """n² squares of two triangles each."""
    number = lambda i, j: i * (n + 1) + j
    points = [[i / n, j / n] for i in range(n + 1) for j in range(n + 1)]
    triangles = [t for i in range(n) for j in range(n) for t in (
        [number(i, j), number(i + 1, j), number(i + 1, j + 1)], [number(i, j), number(i + 1, j + 1), number(i, j + 1)])]
    sides = [[number(i, 0), number(i + 1, 0)] for i in range(n)] + [[number(n, i), number(n, i + 1)] for i in range(n)] \
        + [[number(i + 1, n), number(i, n)] for i in range(n)] + [[number(0, i + 1), number(0, i)] for i in range(n)]
    return linear_mesh(points, triangles, sides)


class Repair(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def write(self, mesh, name="in.meshb"):
        data = binary_file(mesh, 2) if name.endswith("b") else ascii_file(mesh)
        (self.folder.path / name).write_bytes(data)

    def repair(self, *arguments, code=0, name="in.meshb"):
        done = self.folder.camber("repair", name, "-o", "out.meshb", "--report", "report.json", *arguments)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done, report_of(self.folder.path / "report.json")

    def invalid_before(self, name="in.meshb"):
        return json.loads(self.folder.camber("check", name, "--json").stdout)["invalid"]

    def result(self):
        return gmf.read(str(self.folder.path / "out.meshb"))

    def check_repaired(self, mesh, at_least, *arguments):
        """Checks that at least `at_least` invalid elements become valid, also by the oracle, and that the boundary is
        unchanged."""
        self.write(mesh)
        self.assertGreaterEqual(self.invalid_before(), at_least)
        _, report = self.repair(*arguments)
        oracle = subprocess.run([sys.executable, ROOT / "tests" / "oracle" / "check_p2.py",
                                 self.folder.path / "out.meshb"], capture_output=True, text=True)
        self.assertEqual(oracle.returncode, 0, oracle.stdout + oracle.stderr)
        self.assertEqual(boundary_places(self.result()), boundary_places(mesh))
        self.assertEqual(report["input_boundary"]["moved_nodes"], 0)
        self.assertEqual(report["remaining_elements"], [])
        self.assertGreater(report["validity"]["min_scaled_jacobian"], 0)
        self.assertGreaterEqual(report["relax"]["corrected_elements"], at_least)
        return report

    def test_repair_makes_a_cube_with_displaced_nodes_valid(self):
        for seed, share in ((1, 0.3), (2, 0.6)):
            mesh = elevate(cube(3))
            throw_volume_nodes(mesh, share, seed)
            self.check_repaired(mesh, 60)

    def test_repair_makes_a_square_with_displaced_nodes_valid(self):
        mesh = elevate(square(8))
        throw_volume_nodes(mesh, 0.6)
        self.check_repaired(mesh, 60)

    def test_repair_makes_a_cube_with_a_bulged_side_valid(self):
        mesh = elevate(cube(3))
        bulge(mesh, 0.3)
        self.check_repaired(mesh, 3)

    def test_repair_makes_a_square_with_a_bulged_side_valid(self):
        mesh = elevate(square(6))
        bulge(mesh, 0.35)
        self.check_repaired(mesh, 3)

    def test_segment_and_backtracking_repair_preserve_the_boundary(self):
        for repair, share in (("segment", 0.6), ("backtracking", 0.6)):
            mesh = elevate(cube(2))
            throw_volume_nodes(mesh, share)
            self.check_repaired(mesh, 3, "--set", f"stages/relax/method={repair}")

    def test_repair_does_not_change_a_valid_mesh(self):
        mesh = elevate(cube(2))
        throw_volume_nodes(mesh, 0.05)
        self.write(mesh)
        self.assertEqual(self.invalid_before(), 0)
        self.repair()
        self.folder.camber("convert", "in.meshb", "-o", "same.meshb")
        self.assertEqual((self.folder.path / "out.meshb").read_bytes(), (self.folder.path / "same.meshb").read_bytes())

    def test_an_unreachable_bound_leaves_a_valid_mesh_valid(self):
        mesh, bound = (elevate(square(2)), 0.99) if SANITIZED else (elevate(cube(2)), 0.8)
        throw_volume_nodes(mesh, 0.3)
        bulge(mesh, 0.25)
        self.write(mesh)
        self.repair()
        (self.folder.path / "in.meshb").write_bytes((self.folder.path / "out.meshb").read_bytes())
        _, report = self.repair("--min-scaled-jacobian", bound, code=1)
        self.assertEqual(report["validity"]["bound"], bound)
        checked = json.loads(self.folder.camber("check", "out.meshb", "--json").stdout)
        self.assertEqual(checked["invalid"] + checked["undecided"], 0)

    def test_repair_does_not_depend_on_the_number_of_threads(self):
        mesh = elevate(cube(3))
        throw_volume_nodes(mesh, 0.5)
        bulge(mesh, 0.2)
        self.write(mesh)
        results = set()
        for threads in (1, 3):
            self.repair("--threads", threads)
            results.add((self.folder.path / "out.meshb").read_bytes())
        self.assertEqual(len(results), 1)

    def kinked(self):
        """A cube with a boundary edge that leaves its corner (1, 0, 0) backwards. The elements at this vertex (number
        19) have only boundary edges there and stay inverted for any volume nodes."""
        mesh = elevate(cube(2))
        node = next(n for n, ends in mid_nodes(mesh).items() if set(ends) == {9, 18})
        self.assertEqual(tuple(mesh.points[18]), (1, 0, 0))
        mesh.points[node] = 0.8 * mesh.points[18] + 0.2 * mesh.points[9]
        return mesh

    def test_elements_that_the_boundary_makes_invalid_are_listed(self):
        mesh = self.kinked()
        self.write(mesh)
        done, report = self.repair(code=1)
        remaining = report["remaining_elements"]
        self.assertEqual([r["element"] for r in remaining], report["invalid_elements"])
        self.assertGreater(len(remaining), 0)
        for entry in remaining:
            self.assertRegex(entry["reason"], "the boundary alone makes its scaled Jacobian -0.2 at vertex 19$")
            self.assertIn(f"! tetrahedron {entry['element']}: the boundary alone", done.stdout)
        self.assertIn("not certified valid", done.stderr)
        self.assertEqual(boundary_places(self.result()), boundary_places(mesh))
        tolerance = report["input_boundary"]["sufficient_tolerance"]
        self.assertIn(f"remedy: --boundary-tolerance {tolerance:g} (tried", done.stderr)
        self.assertIn("--cad MODEL", done.stderr)
        self.repair("--boundary-tolerance", tolerance)

    def test_elements_inverted_by_their_vertices_get_the_suggestion_to_remesh(self):
        straight = square(3)
        straight.points[5] += 5  # an inner vertex, moved outside
        self.write(elevate(straight))
        done, _ = self.repair("--set", "stages/1/relax/vertices=keep", code=1)
        self.assertIn("`camber remesh`, which replaces elements that are inverted when straight", done.stderr)
        self.assertNotIn("--cad", done.stderr)

    def test_elements_below_the_recommended_bound_are_a_note_and_no_failure(self):
        mesh = self.kinked()
        node = next(n for n, ends in mid_nodes(mesh).items() if set(ends) == {9, 18})
        mesh.points[node] = 0.73 * mesh.points[18] + 0.27 * mesh.points[9]  # gives scaled Jacobians of 0.08
        self.write(mesh)
        done, report = self.repair()
        self.assertGreater(len(report["elements_below_bound"]), 0)
        self.assertIn("below the recommended scaled Jacobian 0.1", done.stderr)
        self.assertIn("(this is no error; --min-scaled-jacobian 0.1 makes it one; to raise them, set "
                      "--boundary-tolerance or --cad)", done.stderr)
        self.repair("--min-scaled-jacobian", 0.1, code=1)

    def test_curve_raises_scaled_jacobians_to_the_target(self):
        """On thin layers, except with a metric or a target of 0."""
        layers = ("--set", "inner_layer/count=10", "--set", "inner_layer/first_height=0.0026", "--set", "inner_layer/growth=1.4")
        self.folder.camber("generate", "shell", *layers, "--set", "inner_size=0.46", "--set", "outer_size=1.75", "-o", "s.mesh")

        def smallest(*options):
            done = self.folder.camber("curve", "s.mesh", *options, "-o", "out.meshb", "--report", "report.json")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            return report_of(self.folder.path / "report.json")["validity"]

        default = smallest()
        self.assertGreaterEqual(default["min_scaled_jacobian"], 0.59)
        self.assertEqual(default["bound"], 0.1)
        self.assertGreaterEqual(smallest("--min-scaled-jacobian", 0.2)["min_scaled_jacobian"], 0.59)
        self.assertGreaterEqual(smallest("--set", "stages/relax/target=0.7")["min_scaled_jacobian"], 0.69)
        self.assertLess(smallest("--set", "stages/relax/target=0")["min_scaled_jacobian"], 0.3)
        self.assertLess(smallest("--metric", 0.5)["min_scaled_jacobian"], 0.3)

    def test_boundary_tolerance_limits_the_moves_of_boundary_nodes(self):
        """The node is 0.1 from the vertex and must be a quarter of its edge away: a move of 0.025."""
        mesh = self.kinked()
        self.write(mesh)
        _, report = self.repair("--boundary-tolerance", 0.01, code=1)
        self.assertEqual(report["input_boundary"]["moved_nodes"], 0)
        _, report = self.repair("--boundary-tolerance", 0.1)
        input_boundary = report["input_boundary"]
        self.assertEqual(input_boundary["tolerance"], 0.1)
        self.assertGreaterEqual(input_boundary["moved_nodes"], 1)
        self.assertLessEqual(input_boundary["largest_shift"], 0.1)
        self.assertGreaterEqual(input_boundary["largest_shift"], 0.025)
        was = mesh.points[boundary_nodes(mesh)]
        out = self.result()
        now = out.points[boundary_nodes(out)]
        off = [np.linalg.norm(was - p, axis=1).min() for p in now]
        self.assertLessEqual(max(off), 0.1)
        self.assertAlmostEqual(max(off), input_boundary["largest_shift"], delta=1e-12)

    def test_nodes_of_folded_plane_sides_slide_in_their_planes(self):
        """A thin layer at x = 0 whose boundary bulges through it, also at the sides, where boundary triangles are
        folded. Nodes slide within the plane sides; the bulged boundary is unchanged."""
        straight = cube(3)
        straight.points[:, 0] = np.interp(straight.points[:, 0], [0, 1 / 3, 2 / 3, 1], [0, 0.04, 0.5, 1])
        mesh = elevate(straight)
        wall = [n for n, (a, b) in mid_nodes(mesh).items() if mesh.points[a][0] == 0 and mesh.points[b][0] == 0]
        mesh.points[wall, 0] = 0.06
        self.write(mesh)
        done, report = self.repair(code=1)
        self.assertIn("its boundary triangle is folded", done.stdout)
        self.assertEqual(boundary_places(self.result()), boundary_places(mesh))
        _, report = self.repair("--boundary-tolerance", 0.2)
        self.assertGreater(report["input_boundary"]["moved_nodes"], 0)
        self.assertLessEqual(report["input_boundary"]["largest_shift"], 0.2)
        out = self.result()
        was, now = ({tuple(p) for p in m.points[boundary_nodes(m)]} for m in (mesh, out))
        self.assertLessEqual({tuple(p) for p in mesh.points[wall]}, now)
        for p in now - was:
            self.assertLess(min(abs(c) for c in (p[1], 1 - p[1], p[2], 1 - p[2], 1 - p[0])), 1e-12, p)

    def test_elements_inverted_by_boundary_vertices_are_listed(self):
        """A corner moved within its side across the diagonal inverts an element of boundary faces only."""
        straight = cube(1)
        corner = next(i for i, p in enumerate(straight.points) if tuple(p) == (1, 0, 0))
        straight.points[corner][:2] = 0.4, 0.6
        mesh = elevate(straight)
        self.write(mesh)
        done, report = self.repair(code=1)
        self.assertIn("its vertices alone make it flat or inverted", done.stdout)
        self.assertGreater(len(report["remaining_elements"]), 0)
        self.assertEqual(boundary_places(self.result()), boundary_places(mesh))

    def test_repair_moves_an_inner_vertex_of_inverted_elements(self):
        """The middle of the side x = 0 lies beyond the inner vertex, which repair moves."""
        straight = cube(2)
        side = next(i for i, p in enumerate(straight.points) if tuple(p) == (0, 0.5, 0.5))
        straight.points[side][0] = 0.6
        mesh = elevate(straight)
        self.write(mesh)
        _, report = self.repair()
        self.assertEqual(report["relax"]["moved_vertices"], 1)
        self.assertEqual(boundary_places(self.result()), boundary_places(mesh))

    # Guards against endless repair of elements that cannot be repaired.
    def test_the_effort_limit_leaves_unrepaired_elements_listed(self):
        """Elements that are not repaired within the effort are listed with that reason; the plan of a run prints the
        limit."""
        mesh = elevate(cube(2))
        bulge(mesh, 0.3)
        self.write(mesh)
        bound = ("--min-scaled-jacobian", 0.3)
        self.assertEqual(self.repair(*bound)[1]["relax"]["unrepaired_elements"], 0)
        done, report = self.repair(*bound, "--set", "stages/relax/effort=0", code=1)
        self.assertGreater(report["relax"]["unrepaired_elements"], 0)
        self.assertEqual(len(report["remaining_elements"]), report["relax"]["unrepaired_elements"])
        for entry in report["remaining_elements"]:
            self.assertIn("(option effort)", entry["reason"])
        plan = self.folder.camber("repair", "in.meshb", "-o", "plan.meshb", "--dry-run").stdout
        self.assertIn("repair ends after", plan)
        self.assertIn("for each element below the bound", plan)

    def test_repair_rejects_straight_meshes(self):
        self.write(cube(1), "straight.mesh")
        done = self.folder.camber("repair", "straight.mesh", "-o", "out.meshb")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("straight.mesh: the mesh has degree 1", done.stderr)
        self.assertIn("camber curve", done.stderr)
        self.assertNotIn("out.meshb", self.folder.files())

    def test_run_accepts_the_printed_config_of_repair(self):
        mesh = elevate(cube(2))
        throw_volume_nodes(mesh, 0.6)
        self.write(mesh)
        text = self.folder.camber("repair", "in.meshb", "-o", "out.meshb", "--boundary-tolerance", 0.5,
                                  "--min-scaled-jacobian", 0.01, "--print-config").stdout
        stages = json.loads(text)["stages"]
        self.assertEqual([s if isinstance(s, str) else next(iter(s)) for s in stages],
                         ["validate", "relax", "commit"])
        self.assertEqual(stages[1]["relax"]["boundary_tolerance"], 0.5)
        self.assertEqual(stages[1]["relax"]["min_scaled_jacobian"], 0.01)
        self.assertNotIn("out.meshb", self.folder.files())
        (self.folder.path / "printed.json").write_text(text)
        self.assertEqual(self.folder.camber("run", "printed.json").returncode, 0)
        self.assertGreaterEqual(json.loads(self.folder.camber("check", "out.meshb", "--json").stdout)
                                ["min_scaled_jacobian"], 0.01)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
