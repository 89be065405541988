"""camber repair: curved meshes broken on purpose, by the oracle's writer, become valid with their boundary as it was.

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
    """{node of an edge: its ends}"""
    rows = mesh.cells[names(mesh)[0]].nodes
    return {int(row[mesh.dim + 1 + i]): (int(row[a]), int(row[b])) for row in rows
            for i, (a, b) in enumerate(ENDS[mesh.dim])}


def boundary_places(mesh):
    """Where each boundary facet's nodes are, whatever their order and numbers."""
    return sorted(sorted(map(tuple, mesh.points[row])) for row in mesh.cells[names(mesh)[1]].nodes)


def throw_volume_nodes(mesh, share, seed=1):
    """Nodes of volume edges anywhere in a box of so many chord lengths about their places."""
    random = np.random.default_rng(seed)
    given = set(boundary_nodes(mesh).tolist())
    for node, (a, b) in sorted(mid_nodes(mesh).items()):
        if node not in given:
            chord = np.linalg.norm(mesh.points[b] - mesh.points[a])
            mesh.points[node] += share * chord * random.uniform(-1, 1, mesh.dim)


def bulge(mesh, depth):
    """The nodes of edges within the side x = 0 go inwards, by so many edge lengths."""
    given = set(boundary_nodes(mesh).tolist())
    for node, (a, b) in mid_nodes(mesh).items():
        y = mesh.points[node][1:]
        if node in given and mesh.points[node][0] == 0 and (y > 0).all() and (y < 1).all():
            mesh.points[node][0] += depth * np.linalg.norm(mesh.points[b] - mesh.points[a])


def square(n):
    """n² squares of two triangles."""
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

    def mended(self, mesh, at_least, *arguments):
        """It had so many invalid elements, has none, says the oracle too, and the boundary is where it was."""
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

    def test_thrown_nodes(self):
        for seed, share in ((1, 0.3), (2, 0.6)):
            mesh = elevate(cube(3))
            throw_volume_nodes(mesh, share, seed)
            self.mended(mesh, 60)

    def test_thrown_nodes_in_the_plane(self):
        mesh = elevate(square(8))
        throw_volume_nodes(mesh, 0.6)
        self.mended(mesh, 60)

    def test_bulged_boundary(self):
        mesh = elevate(cube(3))
        bulge(mesh, 0.3)
        self.mended(mesh, 3)

    def test_bulged_boundary_in_the_plane(self):
        mesh = elevate(square(6))
        bulge(mesh, 0.35)
        self.mended(mesh, 3)

    def test_every_repair_keeps_the_boundary(self):
        for repair, share in (("segment", 0.6), ("backtracking", 0.6)):
            mesh = elevate(cube(2))
            throw_volume_nodes(mesh, share)
            self.mended(mesh, 3, "--set", f"stages/relax/method={repair}")

    def test_a_valid_mesh_stays_as_it_is(self):
        mesh = elevate(cube(2))
        throw_volume_nodes(mesh, 0.05)
        self.write(mesh)
        self.assertEqual(self.invalid_before(), 0)
        self.repair()
        self.folder.camber("convert", "in.meshb", "-o", "same.meshb")
        self.assertEqual((self.folder.path / "out.meshb").read_bytes(), (self.folder.path / "same.meshb").read_bytes())

    def test_a_bound_out_of_reach_leaves_a_valid_mesh_valid(self):
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

    def test_the_same_bytes_for_any_number_of_threads(self):
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
        """A cube at whose corner (1, 0, 0) a boundary edge leaves backwards: its elements there have boundary edges alone
        at that vertex (number 19), and are inverted whatever the volume's nodes do."""
        mesh = elevate(cube(2))
        node = next(n for n, ends in mid_nodes(mesh).items() if set(ends) == {9, 18})
        self.assertEqual(tuple(mesh.points[18]), (1, 0, 0))
        mesh.points[node] = 0.8 * mesh.points[18] + 0.2 * mesh.points[9]
        return mesh

    def test_what_the_boundary_forbids_is_listed(self):
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
        self.assertIn(f"what would help: --boundary-tolerance {tolerance:g} (tried", done.stderr)
        self.assertIn("--cad MODEL", done.stderr)
        self.repair("--boundary-tolerance", tolerance)

    def test_elements_that_vertices_alone_invert_are_left_to_remesh(self):
        straight = square(3)
        straight.points[5] += 5  # an inner vertex, now outside
        self.write(elevate(straight))
        done, _ = self.repair("--set", "stages/1/relax/vertices=keep", code=1)
        self.assertIn("`camber remesh`, which replaces elements that are inverted when straight", done.stderr)
        self.assertNotIn("--cad", done.stderr)

    def test_what_is_below_the_recommended_bound_is_no_failure_and_the_note_says_what_to_do(self):
        mesh = self.kinked()
        node = next(n for n, ends in mid_nodes(mesh).items() if set(ends) == {9, 18})
        mesh.points[node] = 0.73 * mesh.points[18] + 0.27 * mesh.points[9]  # scaled Jacobians of 0.08 there
        self.write(mesh)
        done, report = self.repair()
        self.assertGreater(len(report["elements_below_bound"]), 0)
        self.assertIn("below the recommended scaled Jacobian 0.1", done.stderr)
        self.assertIn("(no failure: --min-scaled-jacobian 0.1 would make it one; --boundary-tolerance or --cad gives it "
                      "room to raise them)", done.stderr)
        self.repair("--min-scaled-jacobian", 0.1, code=1)

    def test_curve_raises_elements_to_the_target(self):
        """On thin layers, unless there is a metric or the target is 0."""
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

    def test_boundary_tolerance(self):
        """The node is 0.1 from the vertex; it must be a quarter of its edge away, so move by 0.025."""
        mesh = self.kinked()
        self.write(mesh)
        _, report = self.repair("--boundary-tolerance", 0.01, code=1)
        self.assertEqual(report["input_boundary"]["moved_nodes"], 0)
        _, report = self.repair("--boundary-tolerance", 0.1)
        kept = report["input_boundary"]
        self.assertEqual(kept["tolerance"], 0.1)
        self.assertGreaterEqual(kept["moved_nodes"], 1)
        self.assertLessEqual(kept["largest_shift"], 0.1)
        self.assertGreaterEqual(kept["largest_shift"], 0.025)
        was = mesh.points[boundary_nodes(mesh)]
        out = self.result()
        now = out.points[boundary_nodes(out)]
        off = [np.linalg.norm(was - p, axis=1).min() for p in now]
        self.assertLessEqual(max(off), 0.1)
        self.assertAlmostEqual(max(off), kept["largest_shift"], delta=1e-12)

    def test_folded_sides_slide_in_their_planes(self):
        """A thin layer at x = 0 whose wall bulges through it, at the sides too, where the boundary's triangles are
        folded: mended by sliding nodes within the sides, which stay plane; the wall stays where it is."""
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

    def test_inverted_vertices_of_the_boundary_are_listed(self):
        """A corner moved in its side across the diagonal: an element on the wrong side of its face, all of it boundary."""
        straight = cube(1)
        corner = next(i for i, p in enumerate(straight.points) if tuple(p) == (1, 0, 0))
        straight.points[corner][:2] = 0.4, 0.6
        mesh = elevate(straight)
        self.write(mesh)
        done, report = self.repair(code=1)
        self.assertIn("its vertices alone make it flat or inverted", done.stdout)
        self.assertGreater(len(report["remaining_elements"]), 0)
        self.assertEqual(boundary_places(self.result()), boundary_places(mesh))

    def test_inverted_vertices_of_the_volume_move(self):
        """The middle of the side x = 0 beyond the inner vertex, which gets out of its way."""
        straight = cube(2)
        side = next(i for i, p in enumerate(straight.points) if tuple(p) == (0, 0.5, 0.5))
        straight.points[side][0] = 0.6
        mesh = elevate(straight)
        self.write(mesh)
        _, report = self.repair()
        self.assertEqual(report["relax"]["moved_vertices"], 1)
        self.assertEqual(boundary_places(self.result()), boundary_places(mesh))

    # Guards against repair without end of elements that cannot be repaired.
    def test_work_has_bounds(self):
        """What is not mended when the work is spent is listed with that reason; the plan of a run tells the limit."""
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

    def test_straight_meshes_are_refused(self):
        self.write(cube(1), "straight.mesh")
        done = self.folder.camber("repair", "straight.mesh", "-o", "out.meshb")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("straight.mesh: the mesh is of degree 1", done.stderr)
        self.assertIn("camber curve", done.stderr)
        self.assertNotIn("out.meshb", self.folder.files())

    def test_print_config_runs_as_it_is(self):
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
