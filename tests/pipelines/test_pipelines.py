"""Runs the configs of the project: figures against golden ones, meshes against the oracle, equal bytes for any number
of threads.

    python3 tests/pipelines/test_pipelines.py build/bin/camber [unittest arguments]

A golden file that is missing fails. After a change that is meant to alter figures, look at the new report and write the
new figures into golden.json by hand.
"""
import json
import subprocess
import sys
import unittest
from pathlib import Path

from program import CONFIGS, ROOT, SANITIZED, Folder, report_of

import gmf  # noqa: E402  (program puts the oracle on the path)
from sample_meshes import binary_file

GOLDEN = json.loads((Path(__file__).parent / "golden.json").read_text())
# Relative tolerances. Other counts are exact; these may change with the last bit.
TOLERANCE = {"mean_length_reduction": 0.01, "largest_length_reduction": 0.02, "mean_curvature": 0.01, "largest_distance": 0.05,
             "corrected_elements": 0.2, "relaxed_volume_edges": 0.2, "relaxed_surface_edges": 0.5,
             "length_reduction_lost": 0.2}


def figures(report):
    """The figures in golden.json."""
    before, relax = report["curve"]["before_correction"], report["relax"]
    return {"vertices": report["mesh"]["vertices"], "elements": report["mesh"]["elements"],
            "edges": report["curve"]["edges"], "mean_length_reduction": before["mean_length_reduction"],
            "largest_length_reduction": before["largest_length_reduction"], "mean_curvature": before["mean_curvature"],
            "corrected_elements": relax["corrected_elements"],
            "relaxed_volume_edges": relax["relaxed_volume_edges"],
            "relaxed_surface_edges": relax["relaxed_surface_edges"],
            "length_reduction_lost": before["mean_length_reduction"] - report["curve"]["after_correction"]["mean_length_reduction"],
            "largest_distance": report["boundary"]["largest_distance"]}


class Configs(unittest.TestCase):
    runs = {}  # (config, arguments) → folder of the run, so that none is repeated

    def folder_of(self, name, *arguments):
        """The folder of the run of a config, with outputs in out/. Runs use two threads by default."""
        arguments = arguments if "--threads" in arguments else (*arguments, "--threads", "2")
        if (name, *arguments) not in self.runs:
            folder = Folder()
            self.addClassCleanup(folder.cleanup)
            done = folder.camber("run", CONFIGS / f"{name}.json", *arguments)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.runs[name, *arguments] = folder.path
        return self.runs[name, *arguments]

    def report_of(self, name, *arguments):
        return report_of(self.folder_of(name, *arguments) / "out" / f"{name}.report.json")

    def check_golden(self, name, report):
        self.assertIn(name, GOLDEN, f"golden.json has no {name}: {json.dumps(figures(report))}")
        for key, value in figures(report).items():
            expected = GOLDEN[name][key]
            slack = TOLERANCE.get(key, 0) * abs(expected) + 1e-12 + (2 if key in TOLERANCE and isinstance(expected, int) else 0)
            self.assertAlmostEqual(value, expected, delta=slack, msg=f"{name}: {key}")

    def check_promises(self, name, report):
        after = report["curve"]["after_correction"]
        self.assertEqual(report["validity"]["invalid"] + report["validity"]["undecided"], 0, name)
        self.assertGreater(report["validity"]["min_scaled_jacobian"], 0)
        self.assertTrue(report["committed"])
        self.assertEqual(report["curve"]["not_located"], 0)
        if name.startswith("paper-"):  # objective energy; accuracy does not shorten every edge
            self.assertGreater(after["mean_length_reduction"], 0)
            self.assertGreaterEqual(after["mean_length_reduction"], 0.9 * report["curve"]["before_correction"]["mean_length_reduction"])
            self.assertEqual(report["curve"]["before_correction"]["longer_edges"], 0)

    def check_oracle(self, mesh, *arguments):
        done = subprocess.run([sys.executable, ROOT / "tests" / "oracle" / "check_p2.py", mesh, *arguments],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def run_and_check(self, name, mesh, *oracle_arguments):
        report = self.report_of(name)
        self.check_promises(name, report)
        self.check_oracle(self.folder_of(name) / "out" / mesh, *oracle_arguments)
        self.check_golden(name, report)

    def test_config_spheres_matches_golden_figures_and_the_oracle(self):
        self.run_and_check("spheres", "spheres.meshb", "--sphere", "1,5", "--sphere", "2,1")

    @unittest.skipIf(SANITIZED, "too slow with sanitizers")
    def test_spheres_squeezed_by_1e6_become_valid_by_moving_surface_nodes(self):
        """Anisotropy 10^6 and a nearly folded boundary at the rim: some elements need moves of surface nodes, which are
        counted."""
        folder = Folder()
        with folder:
            folder.camber("run", CONFIGS / "spheres.json", "--set", "stages=[]", "--set", "output/mesh=in.meshb")
            mesh = gmf.read(folder.path / "in.meshb")
            mesh.points[:, 2] *= 1e-6
            (folder.path / "in.meshb").write_bytes(binary_file(mesh, 2))
            written = set()
            for threads in (1, 2):
                done = folder.camber("curve", "in.meshb", "-o", "out.meshb", "--report", "r.json", "--threads", threads)
                self.assertEqual(done.returncode, 1, done.stderr)
                self.assertIn("cause: validity", done.stderr)
                written.add((folder.path / "out.meshb").read_bytes())
            report = report_of(folder.path / "r.json")
        self.assertEqual(len(written), 1)
        self.assertEqual(report["validity"]["invalid"] + report["validity"]["undecided"], 0)
        self.assertGreater(report["validity_before_correction"]["invalid"], 50)
        self.assertGreater(report["relax"]["relaxed_surface_edges"], 0)
        self.assertLess(report["relax"]["relaxed_surface_edges"], 60)
        off = report["boundary"]["node_deviation"]["beyond_tolerance"]  # others moved along the geometry or by less than the tolerance
        self.assertTrue(0 < off <= report["relax"]["relaxed_surface_edges"])
        self.assertEqual(report["boundary"]["vertex_deviation"]["beyond_tolerance"], 0)

    @unittest.skipIf(SANITIZED, "too slow with sanitizers")
    def test_config_spheres_fine_matches_golden_figures_and_the_oracle(self):
        self.run_and_check("spheres-fine", "spheres-fine.meshb", "--sphere", "1,5", "--sphere", "2,1")

    @unittest.skipIf(SANITIZED, "covered by paper-layer-single (stages) and polar-2d (gradation)")
    def test_config_paper_spheres_coarse_matches_golden_figures_and_the_oracle(self):
        """Paper §4.1: thin along the normals of the boundary, extended inwards by gradation."""
        name = "paper-spheres-coarse"
        self.run_and_check(name, name + ".meshb", "--sphere", "1,5", "--sphere", "2,1")
        metric = self.report_of(name)["metric"]
        self.assertLessEqual(metric["largest_anisotropy"], 10.001)
        gradation, = metric["gradations"]
        self.assertTrue(gradation["converged"])
        self.assertGreater(gradation["sweeps"], 1)

    def test_config_paper_layer_single_matches_golden_figures_and_the_oracle(self):
        name = "paper-layer-single"
        self.run_and_check(name, name + ".meshb", "--sphere", "1,5", "--sphere", "2,1")

    @unittest.skipIf(SANITIZED, "too slow with sanitizers")
    def test_larger_configs_of_the_paper_match_golden_figures(self):
        """The two larger sphere cases of the paper. The oracle would take a minute for each and is not run."""
        for name in ("paper-spheres-fine", "paper-layer-double"):
            report = self.report_of(name)
            self.check_promises(name, report)
            self.check_golden(name, report)

    def test_config_coated_sphere_matches_golden_figures_and_the_oracle(self):
        """Two materials, cavity by cavity: the interface is a sphere like the boundaries."""
        radius = 1 + 0.03 * (1 + 1.3 + 1.3 ** 2 + 1.3 ** 3)
        self.run_and_check("coated-sphere", "coated-sphere.meshb", "--sphere", "1,3", "--sphere", "2,1",
                           "--sphere", f"3,{radius}")
        report = self.report_of("coated-sphere")
        self.assertEqual(report["boundary"]["patches"], 3)
        self.assertEqual(report["boundary"]["ridge_edges"], 0)
        if SANITIZED:
            return
        whole = self.report_of("coated-sphere", "--set", 'stages=["elevate", "curve", "validate", "relax", "commit"]')
        self.assertAlmostEqual(report["curve"]["after_correction"]["mean_length_reduction"],
                               whole["curve"]["after_correction"]["mean_length_reduction"],
                               delta=0.01 * whole["curve"]["after_correction"]["mean_length_reduction"])

    @unittest.skipIf(SANITIZED, "covered by spheres (stages) and coated-sphere (mesh)")
    def test_config_layers_matches_golden_figures_and_the_oracle(self):
        self.run_and_check("layers", "layers.meshb", "--sphere", "1,5", "--sphere", "2,1")

    def test_config_annulus_2d_matches_golden_figures_and_the_oracle(self):
        self.run_and_check("annulus-2d", "annulus-2d.mesh", "--sphere", "1,3", "--sphere", "2,1")

    def test_config_bump_2d_matches_golden_figures_and_the_oracle(self):
        self.run_and_check("bump-2d", "bump-2d.mesh", "--planes")

    def test_config_polar_2d_matches_golden_figures_and_writes_every_output(self):
        """An analytic metric field with bounds and gradation, and every kind of output."""
        self.run_and_check("polar-2d", "polar-2d.meshb", "--planes")
        written = {p.name for p in (self.folder_of("polar-2d") / "out").rglob("*") if p.is_file()}
        self.assertEqual(written, {"polar-2d.meshb", "polar-2d.vtu", "polar-2d.report.json", "length_reduction.svg",
                                   "riemannian_length.svg", "curvature.svg", "scaled_jacobian.svg"})

    def test_a_repeated_stage_is_an_error_at_its_place_in_the_config(self):
        folder = Folder()
        with folder:
            # Guards against an error that names the mesh file.
            done = folder.camber("run", CONFIGS / "annulus-2d.json", "--set", 'stages=["elevate", "elevate"]')
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("/stages/1", done.stderr)
        self.assertIn("an earlier stage is \"elevate\"", done.stderr)

    def test_every_config_is_tested(self):
        names = {p.stem for p in CONFIGS.glob("*.json")} - {"schema", "remesh"}  # remesh is tested by test_remeshing.py
        self.assertEqual(names, set(GOLDEN))

    def test_meshes_of_configs_do_not_depend_on_the_number_of_threads(self):
        for name in ("annulus-2d",) if SANITIZED else ("layers", "annulus-2d", "paper-spheres-coarse", "coated-sphere"):
            bytes_of = []
            for threads in (1, 2, 5):
                mesh, = (self.folder_of(name, "--threads", str(threads)) / "out").glob("*.mesh*")
                bytes_of.append(mesh.read_bytes())
            self.assertEqual(bytes_of[0], bytes_of[1])
            self.assertEqual(bytes_of[0], bytes_of[2])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
