"""Only `commit` changes the mesh: moves of relax take effect there.

    python3 tests/pipelines/test_commit.py build/bin/camber [unittest arguments]
"""
import json
import sys
import unittest

from program import Folder, report_of

import gmf  # noqa: E402  (program puts the oracle on the path)
import numpy as np
from bad_meshes import block, centre_out
from sample_meshes import ascii_file

ENDS = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]


def mean_ratios(mesh, name):
    """12 (3V)^(2/3) / Σ l², negative for inverted straight tetrahedra."""
    p = mesh.points[mesh.cells[name].nodes[:, :4]]
    volume = np.linalg.det(p[:, 1:] - p[:, :1]) / 6
    squares = sum(((p[:, a] - p[:, b]) ** 2).sum(axis=1) for a, b in ENDS)
    return np.sign(volume) * 12 * np.cbrt(3 * np.abs(volume)) ** 2 / squares


class Commit(unittest.TestCase):
    """A block of 48 tetrahedra with its inner vertex beyond the opposite face; repair moves it back."""

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.straight = block()
        centre_out(self.straight)
        self.write("in.mesh", self.straight)

    def write(self, name, mesh):
        (self.folder.path / name).write_bytes(ascii_file(mesh))

    def run_stages(self, stages, name="in.mesh", codes=(0,), **config):
        """Runs the stages and returns mesh and report."""
        whole = {"input": {"mesh": name}, "stages": stages, "geometry": "straight", **config,
                 "output": {"mesh": "out.mesh", "report": "r.json"}}
        (self.folder.path / "c.json").write_text(json.dumps(whole))
        done = self.folder.camber("run", "c.json")
        self.assertIn(done.returncode, codes, done.stdout + done.stderr)
        return gmf.read(self.folder.path / "out.mesh"), report_of(self.folder.path / "r.json")

    def vertices(self, mesh):
        return mesh.points[:len(self.straight.points)]

    # Guards against moves without the stage commit.
    def test_a_run_without_commit_moves_no_node(self):
        elevated, _ = self.run_stages(["elevate"])
        repaired, report = self.run_stages(["elevate", "curve", "validate", "relax"])
        self.assertEqual(report["relax"]["moved_vertices"], 1)
        self.assertTrue(any("not committed" in notice for notice in report["notices"]), report["notices"])
        np.testing.assert_array_equal(repaired.points, elevated.points)

    # Guards against a later curve stage that uses metric and chords from before the move.
    def test_a_later_curve_stage_uses_the_moved_vertices(self):
        first = ["elevate", "curve", "validate", "relax", "commit"]
        repaired, report = self.run_stages(first)
        self.assertEqual(report["relax"]["moved_vertices"], 1)
        again, _ = self.run_stages([*first, "curve", "validate", "commit"], codes=(0, 1))
        np.testing.assert_array_equal(self.vertices(again), self.vertices(repaired))
        moved = block()
        moved.points[:] = self.vertices(repaired)
        self.write("moved.mesh", moved)
        alone, _ = self.run_stages(["elevate", "curve", "validate", "commit"], "moved.mesh", codes=(0, 1))
        np.testing.assert_array_equal(again.points, alone.points)

    def write_metric(self, name, points):
        """Writes a metric with an affine logarithm at these points."""
        rows = "\n".join(f"{m!r} 0 {m!r} 0 0 {m!r}" for m in map(float, np.exp(2 * points[:, 0])))
        (self.folder.path / name).write_text(
            f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices {len(points)}\n1 3\n{rows}\nEnd\n")

    # Guards against metric rows that move with the vertices.
    def test_a_metric_file_is_not_transported_with_moved_vertices(self):
        """The rows belong to the vertices as read: a moved vertex gets the field at its new position."""
        self.write_metric("m.sol", self.straight.points)
        stages = ["elevate", "curve", "validate", "relax", "commit"]
        repaired, report = self.run_stages(stages, metric={"file": "m.sol"})
        self.assertEqual(report["relax"]["moved_vertices"], 1)
        _, again = self.run_stages([*stages, "curve", "validate", "commit"], codes=(0, 1), metric={"file": "m.sol"})
        moved = block()
        moved.points[:] = self.vertices(repaired)
        self.write("moved.mesh", moved)
        self.write_metric("moved.sol", moved.points)
        _, alone = self.run_stages(["elevate", "curve", "validate", "commit"], "moved.mesh", codes=(0, 1),
                                   metric={"file": "moved.sol"})
        self.assertAlmostEqual(again["metric"]["complexity"], alone["metric"]["complexity"], 6)

    # Guards against a repair that leaves a sliver.
    def test_repaired_elements_keep_a_minimum_mean_ratio(self):
        before = mean_ratios(self.straight, "Tetrahedra")
        repaired, report = self.run_stages(["elevate", "curve", "validate", "relax", "commit"])
        self.assertEqual(report["relax"]["moved_vertices"], 1)
        after = mean_ratios(repaired, "TetrahedraP2")
        sound = before > 0
        self.assertLess(sound.sum(), len(sound))
        self.assertTrue((after[sound] >= np.minimum(before[sound], 0.05)).all(), after)
        self.assertGreater(after.min(), 0.01)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
