"""Results do not depend on the unit of length within the allowed range; beyond it every command gives the same error.

    python3 tests/pipelines/test_scales.py build/bin/camber [unittest arguments]
"""
import json
import sys
import unittest

from program import Folder, report_of

import numpy as np
from made_meshes import elevated, lattice
from sample_meshes import binary_file, cube, solution_file

WITHIN = (2.0 ** -192, 2.0 ** -100, 2.0 ** 100, 2.0 ** 198)  # 2e-58, 8e-31, 1e30, 4e59
TINY, DISTANT = ("tiny_elements", "is smaller than 1e-60"), ("distant_vertices", "is more than 1e60 away from the origin")
BEYOND = {2.0 ** -210: TINY, 1e-300: TINY, 2.0 ** 210: DISTANT, 1e300: DISTANT}
VERDICTS = ("valid", "invalid", "undecided")


def crumpled(dim):
    """A lattice with nodes displaced so far that elements are invalid."""
    return elevated(lattice(dim, 3), np.random.default_rng(3), 0.45)


class Scales(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def write(self, name, text):
        (self.folder.path / name).write_bytes(text if isinstance(text, bytes) else text.encode())

    def found(self, name):
        """Exit code of `check`, and all its counts."""
        done = self.folder.camber("check", name, "--json")
        report = json.loads(done.stdout)
        soundness = {key: n for key, n in report["soundness"].items() if isinstance(n, int)}
        return done.returncode, {key: report[key] for key in VERDICTS}, soundness

    def curved(self, scale, *arguments):
        """Results of `curve` for the scaled cube, and of `check` for its output."""
        mesh = cube(3)
        mesh.points = mesh.points * scale
        inner = np.arange(len(mesh.points)) % 7 == 0
        mesh.points[inner] *= 1.0 + 2.0 ** -5
        self.write("in.meshb", binary_file(mesh, 2))
        done = self.folder.camber("curve", "in.meshb", "-o", "out.meshb", "--report", "r.json", *arguments)
        if done.returncode > 1:
            return done.returncode, done.stderr
        validity = report_of(self.folder.path / "r.json")["validity"]
        return done.returncode, {key: validity[key] for key in ("invalid", "undecided")}, self.found("out.meshb")

    def write_metric(self, scale):
        """Writes sizes of 0.1 along x and 0.3 along the others, times the scale."""
        thin, wide = (0.1 * scale) ** -2, (0.3 * scale) ** -2
        self.write("m.solb", solution_file(np.tile([thin, 0, wide, 0, 0, wide], (len(cube(3).points), 1)), 3, 3))

    def repaired(self, dim, scale):
        mesh = crumpled(dim)
        mesh.points = mesh.points * scale
        self.write("broken.mesh", mesh.text())
        before = self.found("broken.mesh")
        done = self.folder.camber("repair", "broken.mesh", "-o", "mended.mesh")
        return before, done.returncode, done.stderr if done.returncode > 1 else self.found("mended.mesh")

    # Guards against results that depend on the unit of length: lost ridges below 1e-27, rejected elements at 1e77.
    def test_curve_gives_the_same_result_at_every_length_scale(self):
        for arguments in ((), ("--metric", "m.solb")):
            self.write_metric(1.0)
            whole = self.curved(1.0, *arguments)
            self.assertEqual(whole[0], 0, whole)
            for scale in WITHIN:
                with self.subTest(arguments=arguments, scale=scale):
                    self.write_metric(scale)
                    self.assertEqual(self.curved(scale, *arguments), whole)

    def test_repair_and_check_give_the_same_result_at_every_length_scale(self):
        for dim in (2, 3):
            whole = self.repaired(dim, 1.0)
            self.assertGreater(whole[0][1]["invalid"], 0)
            self.assertEqual(whole[1], 0, whole)
            for scale in WITHIN:
                with self.subTest(dim=dim, scale=scale):
                    self.assertEqual(self.repaired(dim, scale / 4), whole)

    # Guards against lengths beyond the range that one command accepts and another rejects.
    def test_lengths_outside_the_range_are_rejected(self):
        for scale, (defect, says) in BEYOND.items():
            with self.subTest(scale=scale):
                code, error = self.curved(scale)
                self.assertEqual((code, says in error), (3, True), error)
                before, code, error = self.repaired(3, scale)
                self.assertEqual((code, says in error), (3, True), error)
                for code, _, soundness in (before, self.found("in.meshb")):
                    self.assertEqual(code, 1)
                    self.assertGreater(soundness[defect], 0)
                self.assertEqual(self.folder.camber("info", "in.meshb").returncode, 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
