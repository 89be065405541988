"""A metric at the nodes of a curved mesh: read, preserved through stages, and used on another mesh.

    python3 tests/pipelines/test_metric_mesh.py build/bin/camber [unittest arguments]
"""
import json
import sys
import unittest

from made_meshes import lattice
from program import CONFIGS, Folder, report_of

import gmf  # noqa: E402  (program puts the oracle on the path)
import numpy as np
from sample_meshes import solution_file


def rows_at(points):
    """Sizes proportional to the radius, half as large in one direction."""
    radii = np.linalg.norm(points, axis=1)
    along, across = 1 / (0.6 * radii) ** 2, 1 / (0.3 * radii) ** 2
    rows = np.zeros((len(points), 6))
    rows[:, 0], rows[:, 2], rows[:, 5] = along, along, across
    return rows


class MetricMesh(unittest.TestCase):
    """The curved shell of configs/spheres.json with a metric at all points."""

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        done = self.folder.camber("run", CONFIGS / "spheres.json", "--set", "output/mesh=first.meshb", "--set",
                                  "input/generate/shell/inner_size=0.4", "--set", "input/generate/shell/outer_size=1")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.points = gmf.read(self.folder.path / "first.meshb").points
        (self.folder.path / "m.solb").write_bytes(solution_file(rows_at(self.points), 3, 3))

    def run_config(self, codes=(0,), **config):
        (self.folder.path / "c.json").write_text(json.dumps(config))
        done = self.folder.camber("run", "c.json")
        self.assertIn(done.returncode, codes, done.stdout + done.stderr)
        return done

    def test_metrics_at_nodes_of_a_curved_mesh_are_read_and_written(self):
        self.run_config(input={"mesh": "first.meshb"}, metric={"file": "m.solb"},
                        stages=["curve", "validate", "relax", "commit"],
                        output={"mesh": "out.meshb", "metric": "out.solb", "report": "r.json"}, codes=(0, 1))
        out = gmf.read(self.folder.path / "out.meshb")
        rows = gmf.read(self.folder.path / "out.solb").fields[0][1]
        self.assertEqual(len(rows), len(out.points))
        off = np.abs(np.log(rows[:, [0, 2, 5]] / rows_at(out.points)[:, [0, 2, 5]])).max()
        self.assertLess(off, 0.1)  # interpolation error of form (4) on a coarse mesh
        self.assertGreater(report_of(self.folder.path / "r.json")["metric"]["complexity"], 0)

    def test_remeshing_a_curved_mesh_writes_a_metric_at_all_nodes(self):
        self.run_config(input={"mesh": "first.meshb"}, metric={"file": "m.solb"}, stages=[{"remesh": {"rounds": 1}}],
                        output={"mesh": "out.meshb", "metric": "out.solb"}, codes=(0, 1))
        out = gmf.read(self.folder.path / "out.meshb")
        rows = gmf.read(self.folder.path / "out.solb").fields[0][1]
        self.assertEqual(len(rows), len(out.points))
        off = np.abs(np.log(rows[:, [0, 2, 5]] / rows_at(out.points)[:, [0, 2, 5]])).max(axis=1)
        self.assertLess(np.median(off), 0.01)
        self.assertLess(off.max(), 0.1)

    def test_a_straight_mesh_is_remeshed_to_the_metric_of_a_curved_mesh(self):
        done = self.folder.camber("generate", "shell", "--elements", "300", "-o", "g.meshb")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.run_config(input={"mesh": "g.meshb"}, metric={"file": "m.solb"}, metric_mesh="first.meshb",
                        stages=["remesh"], output={"mesh": "out.meshb", "metric": "out.solb", "report": "r.json"},
                        codes=(0, 1))
        out = gmf.read(self.folder.path / "out.meshb")
        rows = gmf.read(self.folder.path / "out.solb").fields[0][1]
        radii = np.linalg.norm(out.points, axis=1)
        inside = (radii > 1.001) & (radii < 4.99)  # outside, the closest boundary point is used
        self.assertGreater(inside.sum(), 100)
        off = np.abs(np.log(rows[:, [0, 2, 5]] / rows_at(out.points)[:, [0, 2, 5]]))[inside].max(axis=1)
        self.assertLess(np.median(off), 0.01)
        self.assertLess(off.max(), 0.1)

    # Guards against a distant metric mesh that gives one boundary value to all vertices.
    def test_a_metric_mesh_outside_the_mesh_is_rejected(self):
        for dim in (2, 3):
            mesh = lattice(dim, 3)
            (self.folder.path / "in.mesh").write_text(mesh.text())
            sizes = "MeshVersionFormatted 2\nDimension %d\nSolAtVertices\n%d\n1 1\n%s\nEnd\n" % (
                dim, len(mesh.points), "1 " * len(mesh.points))
            (self.folder.path / "m.sol").write_text(sizes)
            for beside, stage, code in ((1000, "remesh", 3), (1000, "curve", 3), (0.02, "remesh", 0), (0, "remesh", 0)):
                other = lattice(dim, 3)
                other.points = other.points + beside
                (self.folder.path / "other.mesh").write_text(other.text())
                stages = [stage] if stage == "remesh" else ["elevate", "curve", "validate", "relax", "commit"]
                done = self.run_config(input={"mesh": "in.mesh"}, metric={"file": "m.sol"}, metric_mesh="other.mesh",
                                       stages=stages, output={"report": "r.json"}, codes=(code,))
                n, far = 4 ** dim, 1000 * dim ** 0.5
                message = f"/metric_mesh: is in another place than the mesh: {n} of its {n} vertices are outside, by up to {far:.4g}"
                self.assertEqual(message in done.stderr, code == 3, done.stderr)
                self.assertEqual("vertices are outside the metric's mesh, by up to 0.0" in done.stderr, beside == 0.02)

    def test_vertex_metrics_accept_files_with_rows_at_nodes_and_note_it(self):
        vertices = json.loads(self.folder.camber("check", "first.meshb", "--json").stdout)["vertices"]
        (self.folder.path / "v.solb").write_bytes(solution_file(rows_at(self.points)[:vertices], 3, 3))
        reported = [json.loads(self.folder.camber("check", "first.meshb", "--json", "--metric", name).stdout)
                for name in ("m.solb", "v.solb")]
        for key in ("unit_mesh", "curved_unit_mesh"):
            self.assertEqual(*({k: v for k, v in t[key].items() if k != "metric"} for t in reported))
        self.assertIn("m.solb has a metric at all nodes", " ".join(reported[0]["notices"]))
        # an operand, and the metric itself if there are operations
        for metric, operand, reported in ((None, "m.solb", True), ("m.solb", "v.solb", True), (None, "v.solb", False)):
            self.run_config(input={"mesh": "first.meshb"},
                            metric={"file": metric} if metric else {"constant": {"sizes": [0.5]}},
                            metric_operations=[{"intersect": {"file": operand}}],
                            stages=["curve", "validate", "relax", "commit"], output={"report": "r.json"}, codes=(0, 1))
            notices = " ".join(report_of(self.folder.path / "r.json")["notices"])
            self.assertEqual("m.solb has a metric at all nodes" in notices, reported)

    def test_wrong_row_counts_of_a_metric_are_rejected(self):
        (self.folder.path / "m.solb").write_bytes(solution_file(rows_at(self.points)[:-1], 3, 3))
        done = self.run_config(input={"mesh": "first.meshb"}, metric={"file": "m.solb"},
                               stages=["curve", "validate", "relax", "commit"], output={}, codes=(3,))
        self.assertIn("rows", done.stderr)
        done = self.run_config(input={"mesh": "first.meshb"}, metric_mesh="first.meshb",
                               stages=["curve", "validate", "relax", "commit"], output={}, codes=(2,))
        self.assertIn("/metric_mesh", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
