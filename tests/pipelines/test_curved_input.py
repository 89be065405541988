"""Curved input of `curve`: the boundary is preserved, and the nodes are initial values of the search.

    python3 tests/pipelines/test_curved_input.py build/bin/camber [unittest arguments]
"""
import json
import sys
import unittest

from made_meshes import elevated, lattice
from program import CONFIGS, Folder, report_of

import gmf  # noqa: E402  (program puts the oracle on the path)
import numpy as np
from sample_meshes import ascii_file


class CurvedInput(unittest.TestCase):
    """The shell of configs/spheres.json, curved."""

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        done = self.folder.camber("run", CONFIGS / "spheres.json", "--set", "output/mesh=first.meshb", "--set",
                                  "output/report=first.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.gain = report_of(self.folder.path / "first.json")["curve"]["after_correction"]["mean_length_reduction"]
        self.first = gmf.read(self.folder.path / "first.meshb")
        self.surface = np.unique(self.first.cells["TrianglesP2"].nodes[:, 3:])

    def curve(self, name, *sets, codes=(0,), **config):
        """Runs curve, validate, relax and commit, and returns mesh and report."""
        whole = {"input": {"mesh": name}, "stages": ["curve", "validate", "relax", "commit"],
                 "output": {"mesh": "out.meshb", "report": "r.json"}, **config}
        (self.folder.path / "c.json").write_text(json.dumps(whole))
        done = self.folder.camber("run", "c.json", *sets)
        self.assertIn(done.returncode, codes, done.stdout + done.stderr)
        return gmf.read(self.folder.path / "out.meshb"), report_of(self.folder.path / "r.json")

    def bulged(self, share):
        """Moves boundary nodes outwards by a share of their distance to the centre."""
        self.first.points[self.surface] *= 1 + share
        (self.folder.path / "bulged.mesh").write_bytes(ascii_file(self.first))
        return self.first.points[self.surface]

    # Guards against boundary nodes of a curved input replaced by surrogate nodes.
    def test_boundary_nodes_of_a_curved_input_are_preserved(self):
        places = self.bulged(0.01)
        out, report = self.curve("bulged.mesh", codes=(0, 1))
        np.testing.assert_array_equal(out.points[self.surface], places)
        notice = f"{len(self.surface)} boundary edges have the nodes of the input"
        self.assertIn(notice, report["notices"])

    def test_analytic_surfaces_override_the_boundary_nodes_of_the_input(self):
        self.bulged(0.01)
        analytic = [{"references": [1], "sphere": {"radius": 5}}, {"references": [2], "sphere": {"radius": 1}}]
        out, report = self.curve("bulged.mesh", geometry={"analytic": analytic})
        radii = np.linalg.norm(out.points[self.surface], axis=1)
        self.assertLess(np.minimum(abs(radii - 1), abs(radii - 5)).max(), 1e-12)
        self.assertFalse([n for n in report["notices"] if "have the nodes of the input" in n])

    def test_curving_a_curved_mesh_keeps_its_length_reduction(self):
        _, again = self.curve("first.meshb")
        self.assertGreaterEqual(again["curve"]["after_correction"]["mean_length_reduction"], self.gain - 1e-6)
        self.assertIn("the nodes of the input are ignored", " ".join(again["notices"]))

    def test_curving_a_curved_mesh_again_gives_the_same_bytes(self):
        # The back mesh follows the boundary, not the nodes in the volume.
        self.curve("first.meshb")
        self.assertEqual((self.folder.path / "out.meshb").read_bytes(), (self.folder.path / "first.meshb").read_bytes())


class BentLayers(unittest.TestCase):
    """Thin quadratic layers bent so much that some straight elements are inverted although all curved ones are
    valid."""

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def bent(self):
        mesh = elevated(lattice(2, 3))
        angle, radius = 0.6 * (mesh.points[:, 0] + mesh.points[:, 1] / 2), 1 + 0.02 * mesh.points[:, 1]
        mesh.points = np.stack([radius * np.sin(angle), radius * np.cos(angle)], 1)
        (self.folder.path / "bent.mesh").write_text(mesh.text())
        return mesh

    def validity(self, *arguments, codes=(0,)):
        done = self.folder.camber(*arguments, "--set", "output/report=r.json", "--set", "threads=1")
        self.assertIn(done.returncode, codes, done.stdout + done.stderr)
        return report_of(self.folder.path / "r.json")["validity"]

    def expect_valid(self, objective, repair="extension", **config):
        stages = [{"curve": {"objective": objective}}, "validate", {"relax": {"method": repair}}, "commit"]
        whole = {"input": {"mesh": "bent.mesh"}, "stages": stages, "output": {"mesh": "out.mesh"}, **config}
        (self.folder.path / "c.json").write_text(json.dumps(whole))
        with self.subTest(objective=objective, repair=repair):
            validity = self.validity("run", "c.json")
            self.assertEqual((validity["invalid"], validity["undecided"]), (0, 0))
            self.assertGreater(validity["straight_inverted"], 0)

    def test_curve_keeps_bent_layers_valid_for_every_objective_and_repair(self):
        self.bent()
        for objective in ("accuracy", "length", "shape"):
            self.expect_valid(objective)
        for repair in ("cavity", "edge", "segment", "backtracking"):
            self.expect_valid("shape", repair)
        self.expect_valid("solution", solution={"expression": "tanh((x-0.5)/0.01)"})

    def test_repair_adds_no_invalid_element_to_bent_layers(self):
        spoilt = self.bent()
        vertices = 16  # mid nodes have the following indices
        spoilt.points[vertices:] += np.random.default_rng(1).uniform(-0.01, 0.01, spoilt.points[vertices:].shape)
        (self.folder.path / "bent.mesh").write_text(spoilt.text())
        (self.folder.path / "c.json").write_text(json.dumps(
            {"input": {"mesh": "bent.mesh"}, "stages": ["validate"], "output": {"mesh": "out.mesh"}}))
        before = self.validity("run", "c.json", codes=(0, 1))
        self.assertGreater(before["invalid"], 0)
        for repair in ("extension", "cavity", "edge", "segment", "backtracking"):
            with self.subTest(repair=repair):
                after = self.validity("repair", "bent.mesh", "-o", "out.mesh", "--set", f"stages/relax/method={repair}",
                                      codes=(0, 1))
                self.assertLessEqual(after["invalid"] + after["undecided"], before["invalid"] + before["undecided"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
