"""Boundaries do not cross in the output of any verb; crossings give exit code 1.

    python3 tests/pipelines/test_walls.py build/bin/camber [unittest arguments]
"""
import json
import sys
import unittest

import numpy as np

from made_meshes import Mesh, ball_in_shell, block_beside_ball, elevated, lattice
from program import SANITIZED, Folder, report_of


class Walls(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()

    def run_on(self, mesh, *arguments, name="in.mesh"):
        """Runs the verb and returns the process, its report, and the result of `check`."""
        (self.folder.path / name).write_text(mesh.text())
        verb, *rest = arguments
        done = self.folder.camber(verb, name, "-o", "out.mesh", "--report", "r.json", *rest)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        checked = self.folder.camber("check", "out.mesh", "--json")
        return done, report_of(self.folder.path / "r.json"), json.loads(checked.stdout)

    def test_remesh_keeps_a_thin_gap_open(self):
        for dim, n, gap, size in ((2, 6, 0.02, 0.6), (2, 8, 0.005, 0.4), (3, 3, 0.03, 0.7)):
            with self.subTest(dim=dim, gap=gap):
                done, report, checked = self.run_on(ball_in_shell(dim, n, gap), "remesh", "--metric", size)
                self.assertEqual(checked["crossings"]["crossing"], 0)
                self.assertEqual((done.returncode, report["boundary"]["crossing_pairs"]), (0, 0))
                rejected = [p["rejected"].get("crossing", 0) for p in report["remesh"]["passes"]]
                self.assertGreater(sum(rejected), 0)  # otherwise the guard is not tested

    def test_remesh_by_blocks_reports_crossing_boundaries(self):
        done, report, checked = self.run_on(ball_in_shell(2, 8, 0.02), "remesh", "--metric", "0.5", "--blocks", "100")
        crossing = checked["crossings"]["crossing"]
        self.assertEqual(report["boundary"]["crossing_pairs"], crossing)
        self.assertEqual(done.returncode, 1 if crossing else 0)

    def test_curve_moves_boundary_nodes_back_until_no_boundaries_cross(self):
        for dim, n, share, size in ((2, 2, 0.3, 0.1), (2, 3, 0.6, 0.2), (3, 2, 0.3, 0.1), (3, 3, 0.6, 0.2)):
            mesh = block_beside_ball(dim, n, share, size)
            relaxations = []
            for blocks in ((), ("--blocks", 20)):
                with self.subTest(dim=dim, n=n, blocks=blocks):
                    done, report, checked = self.run_on(mesh, "curve", *blocks)
                    self.assertEqual((checked["crossings"]["crossing"], checked["invalid"]), (0, 0))
                    self.assertEqual(report["boundary"]["crossing_pairs"], 0)
                    relaxed = report["boundary"]["relaxed_for_crossing"]
                    self.assertIn("boundary nodes moved back", done.stdout)
                    # Few nodes near the block are moved, not as far as their chords.
                    self.assertLess(relaxed["nodes"], 8 if dim == 2 else 16)
                    self.assertGreater(relaxed["largest_distance"], 0)
                    # The moved nodes are reported as off the geometry.
                    deviation = report["boundary"]["node_deviation"]
                    self.assertEqual((done.returncode, deviation["beyond_tolerance"]), (1, relaxed["nodes"]))
                    self.assertIn("cause: crossing", done.stderr)
                    self.assertIn(report["misses"][0], done.stderr)
                    near = np.linalg.norm(mesh.points - np.array(relaxed["point"]), axis=1)
                    self.assertLess(near[-2**dim:].min(), 0.6)
                    relaxations.append((relaxed["nodes"], round(relaxed["largest_distance"], 9)))
            self.assertEqual(relaxations[0], relaxations[1])

    def test_crossing_boundaries_of_straight_input_are_reported(self):
        for dim in (2, 3):
            for share in (-0.5, -1):
                mesh = block_beside_ball(dim, 2, share, 0.2)
                cycles = () if SANITIZED else (("adapt", "--field", "x*x", "--complexity", 60, "--cycles", 1, "--degree", 1),)
                for verb in (("curve",), ("curve", "--blocks", 20), ("remesh", "--metric", "0.5"), *cycles):
                    with self.subTest(dim=dim, verb=verb):
                        done, report, checked = self.run_on(mesh, *verb)
                        crossing = checked["crossings"]["crossing"]
                        self.assertEqual(report["boundary"]["crossing_pairs"], crossing)
                        if verb[0] == "curve":  # other verbs may remove crossing elements
                            self.assertGreater(crossing, 0)
                        self.assertEqual(done.returncode != 0, crossing + checked["overlaps"]["overlapping"] > 0)
                        self.assertEqual("through each other" in done.stderr, crossing > 0)
                        if verb[0] != "adapt":  # adapt starts from the previous cycle
                            self.assertEqual("crossed already in the input" in done.stderr, crossing > 0)

    def test_repair_reports_crossing_boundaries(self):
        for dim in (2, 3):
            one = lattice(dim, 2)
            number = len(one.points)
            for gap, bow, code in ((0.1, 0.15, 1), (0.1, 0.05, 0)):
                away = np.array([2 + gap, 0.13, 0.07][:dim])
                mesh = elevated(Mesh(np.concatenate([one.points, one.points + away]),
                                     one.elements + [tuple(v + number for v in e) for e in one.elements],
                                     one.facets + [tuple(v + number for v in f) for f in one.facets]))
                for node in {n for f in mesh.facets[:len(one.facets)] for n in f[dim:]}:
                    if mesh.points[node][0] == 2 and all(0 < x < 2 for x in mesh.points[node][1:]):
                        mesh.points[node][0] += bow
                done, report, checked = self.run_on(mesh, "repair")
                self.assertEqual((done.returncode, report["boundary"]["crossing_pairs"] > 0), (code, code == 1))
                self.assertEqual(report["boundary"]["crossing_pairs"], checked["crossings"]["crossing"])
                self.assertEqual("pass" in done.stderr and "through each other" in done.stderr, code == 1)

    @unittest.skipIf(SANITIZED, "takes minutes")
    def test_quadratic_cycles_complete_beside_a_thin_gap(self):
        for dim, n, share in ((2, 3, 0.3), (3, 2, 0.3)):
            done, report, checked = self.run_on(block_beside_ball(dim, n, share), "adapt", "--field", "sin(2*x)*cos(y)",
                                                "--complexity", 60, "--degree", 2, "--cycles", 3)
            self.assertEqual(report["boundary"]["crossing_pairs"], checked["crossings"]["crossing"])
            self.assertEqual(checked["invalid"], 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
