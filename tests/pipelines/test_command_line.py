"""The command line: verbs, messages, exit codes, and no output after a failure.

    python3 tests/pipelines/test_command_line.py build/bin/camber [unittest arguments]
"""
import json
import re
import signal
import subprocess
import sys
import time
import unittest

from program import CAMBER, CONFIGS, SANITIZED, Folder

CUBE = """MeshVersionFormatted 2
Dimension 3
Vertices 5
0 0 0 0
1 0 0 0
0 1 0 0
0 0 1 0
1 1 1 0
Tetrahedra 2
1 2 3 4 1
2 3 4 5 2
Triangles 6
1 3 2 1
1 2 4 1
1 4 3 1
2 3 5 2
3 4 5 2
2 5 4 2
End
"""

SIZES = "MeshVersionFormatted 2\nDimension 3\nSolAtVertices 5\n1 1\n" + "0.25\n" * 5 + "End\n"


class CommandLine(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.write("two.mesh", CUBE)

    def write(self, name, text):
        (self.folder.path / name).write_text(text)

    def camber(self, *arguments):
        return self.folder.camber(*arguments)

    def fails(self, code, message, *arguments):
        """Expects one line on standard error that contains `message`, no standard output and no new file."""
        before = self.folder.files()
        done = self.camber(*arguments)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        self.assertIn(message, done.stderr)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(self.folder.files(), before)

    def test_help_lists_every_verb_and_exit_codes(self):
        text = self.camber("--help").stdout
        for verb in ("run", "curve", "repair", "convert", "generate", "plot", "picture", "check", "info", "explain", "schema"):
            self.assertIn(verb, text)
            self.assertEqual(self.camber(verb, "--help").returncode, 0)
        self.assertIn("Exit codes", text)

    def test_verbose_version_lists_optional_parts(self):
        version = self.camber("--version").stdout
        self.assertRegex(version, r"^\d+\.\d+\.\d+\n$")
        for arguments in (("--version", "--verbose"), ("--verbose", "--version")):
            parts = self.camber(*arguments).stdout
            self.assertTrue(parts.startswith(version), parts)
            for name in ("partitions", "CGNS files", "compressed files", "CAD models", "pages"):
                self.assertRegex(parts, rf"\n{name} +\w")
            last = f"Missing parts: {parts.count('missing; ')}" if "missing; " in parts else "Nothing is missing."
            self.assertEqual(parts.splitlines()[-1], last)

    def test_curve_writes_a_quadratic_mesh_that_check_and_info_describe(self):
        done = self.camber("curve", "two.mesh", "-o", "out.meshb", "--report", "report.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("smallest scaled Jacobian", done.stdout)
        self.assertEqual(self.folder.files(), ["out.meshb", "report.json", "two.mesh"])
        checked = json.loads(self.camber("check", "out.meshb", "--json").stdout)
        self.assertEqual((checked["dimension"], checked["degree"], checked["elements"], checked["invalid"],
                          checked["undecided"]), (3, 2, 2, 0, 0))
        self.assertEqual((checked["vertices"], checked["nodes"]), (5, 14))
        self.assertEqual(checked["invalid_elements"], [])
        self.assertGreater(checked["min_scaled_jacobian"], 0.5)
        self.assertIn("tetrahedra", self.camber("info", "out.meshb").stdout)
        self.assertEqual(json.loads(self.camber("info", "out.meshb", "--json").stdout)["mid_nodes"], 9)

    def test_check_reports_an_inverted_element_of_a_straight_mesh(self):
        checked = json.loads(self.camber("check", "two.mesh", "--json").stdout)
        self.assertEqual((checked["degree"], checked["nodes"]), (1, 5))
        self.assertAlmostEqual(checked["min_scaled_jacobian"], 1, places=6)
        self.write("inverted.mesh", CUBE.replace("1 2 3 4 1", "1 3 2 4 1"))
        done = self.camber("check", "inverted.mesh", "--json")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(json.loads(done.stdout)["invalid_elements"], [1])

    def test_check_and_info_report_an_empty_mesh(self):
        self.write("empty.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices\n0\nEnd\n")
        done = self.camber("check", "empty.mesh")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("the mesh is empty", done.stdout)
        self.assertTrue(json.loads(self.camber("check", "empty.mesh", "--json").stdout)["soundness"]["empty"])
        done = self.camber("info", "empty.mesh")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, "empty +true")
        self.assertFalse(json.loads(self.camber("info", "two.mesh", "--json").stdout)["empty"])

    def test_run_accepts_the_output_of_print_config(self):
        text = self.camber("curve", "two.mesh", "-o", "out.mesh", "--set", "stages/curve/objective=length",
                           "--print-config").stdout
        config = json.loads(text)
        self.assertEqual(config["stages"][1]["curve"]["objective"], "length")
        self.write("printed.json", text)
        self.assertEqual(self.camber("run", "printed.json").returncode, 0)
        self.assertIn("out.mesh", self.folder.files())

    def test_option_objective_overrides_the_setting_of_the_stage(self):
        schema = json.loads(self.camber("schema").stdout)
        stage = next(s for s in schema["properties"]["stages"]["items"]["oneOf"] if "curve" in s.get("properties", {}))
        described = stage["properties"]["curve"]["properties"]["objective"]
        self.assertIn("--objective " + "|".join(described["enum"]), self.camber("curve", "--help").stdout)
        curve = ("curve", "two.mesh", "-o", "out.mesh", "--print-config")
        for word in described["enum"]:
            config = json.loads(self.camber(*curve, "--objective", word, "--set", "stages/curve/objective=length").stdout)
            self.assertEqual(config["stages"][1]["curve"]["objective"], word)
        self.fails(2, "--objective", *curve, "--objective", "weight")

    def test_configs_schema_json_equals_the_schema_of_the_program(self):
        text = self.camber("schema").stdout
        self.assertIn("properties", json.loads(text))
        self.assertEqual((CONFIGS / "schema.json").read_text(), text, "camber schema > configs/schema.json")

    def test_explain_describes_options_and_suggests_corrections(self):
        self.assertIn("objective", self.camber("explain", "curve").stdout)
        self.fails(2, "curve", "explain", "curv")
        self.assertIn("largest sizes that both allow", self.camber("explain", "intersect").stdout)
        self.assertIn(".solb file", self.camber("explain", "file").stdout)

    def test_wrong_configs_are_rejected_with_their_place(self):
        config = {"input": {"mesh": "two.mesh"}, "output": {"mesh": "out.mesh"}}
        self.write("unknown.json", json.dumps(config | {"metrik": "natural"}))
        self.fails(2, "/metrik: unknown key (did you mean \"metric\"?)", "run", "unknown.json")
        self.write("type.json", json.dumps(config | {"threads": "two"}))
        self.fails(2, "/threads", "run", "type.json")
        self.write("syntax.json", "{\n\"input\": }")
        self.fails(2, "line 2", "run", "syntax.json")
        self.fails(2, "absent.json", "run", "absent.json")
        self.write("order.json", json.dumps(config | {"stages": ["elevate", "relax"]}))
        self.fails(2, "/stages/1: stage \"relax\" needs \"curve\" before it", "run", "order.json")

    def test_wrong_usage_exits_with_code_2(self):
        for arguments in (("curve",), ("curve", "two.mesh"), ("fly",), ("run",), ("check", "two.mesh", "--jsn"),
                          ("curve", "two.mesh", "-o", "out.mesh", "--threads", "-3")):
            done = self.camber(*arguments)
            self.assertEqual(done.returncode, 2, arguments)
            self.assertNotEqual(done.stderr, "")
        self.fails(2, "no format known for this ending (use .mesh, .meshb", "curve", "two.mesh", "-o", "out.ply")

    def test_bad_mesh_files_exit_with_code_3(self):
        self.fails(3, "absent.mesh", "check", "absent.mesh")
        self.write("range.mesh", CUBE.replace("2 3 4 5 2", "2 3 4 6 2"))
        self.fails(3, "tetrahedron 2", "check", "range.mesh")
        self.write("cut.mesh", CUBE[:180])
        self.fails(3, "cut.mesh", "curve", "cut.mesh", "-o", "out.mesh")
        self.write("hexes.mesh", CUBE.replace("End", "Hexahedra 1\n1 2 3 4 5 1 2 3 0\nEnd"))
        self.fails(3, "exahedra", "check", "hexes.mesh")
        self.fails(3, "two.mesh/nowhere/deep.mesh: its folder two.mesh/nowhere is below a file", "curve", "two.mesh", "-o", "two.mesh/nowhere/deep.mesh")

    def test_bad_metric_files_exit_with_code_3(self):
        header = "MeshVersionFormatted 2\nDimension 3\nSolAtVertices {}\n1 3\n{}\nEnd\n"
        self.write("few.sol", header.format(2, "1 0 1 0 0 1\n" * 2))
        self.fails(3, "few.sol: has 2 rows, the mesh 5 vertices", "curve", "two.mesh", "-o", "o.mesh", "--metric",
                   "few.sol")
        self.write("negative.sol", header.format(5, "1 0 1 0 0 1\n" * 4 + "1 0 -1 0 0 1"))
        self.fails(3, "negative.sol: metric at vertex 5: is not positive definite", "curve", "two.mesh", "-o", "o.mesh",
                   "--metric", "negative.sol")

    def test_a_misspelt_metric_word_is_not_taken_as_a_file_name(self):
        self.fails(2, 'unknown word "natrual" (did you mean "natural"?)', "curve", "two.mesh", "-o", "o.mesh", "--metric",
                   "natrual")
        self.fails(2, "camber explain file", "curve", "two.mesh", "-o", "o.mesh", "--metric", "file")
        self.fails(3, "natrual.sol", "curve", "two.mesh", "-o", "o.mesh", "--metric", "natrual.sol")
        self.fails(3, "./natrual", "curve", "two.mesh", "-o", "o.mesh", "--metric", "./natrual")

    def test_a_scaled_jacobian_bound_of_1_is_rejected(self):
        for arguments in (("check", "two.mesh"), ("curve", "two.mesh", "-o", "o.mesh")):
            done = self.camber(*arguments, "--min-scaled-jacobian", "1")
            self.assertEqual(done.returncode, 2)
            self.assertIn("below 1", done.stderr)

    def test_a_constant_metric_leaves_edges_straight(self):
        for metric in ('{"constant": {"sizes": [0.5]}}', '{"constant": {"sizes": [0.5, 1, 2]}}',
                       '{"constant": {"tensor": [1, 0, 1, 0, 0, 4]}}'):
            done = self.camber("curve", "two.mesh", "-o", "o.mesh", "--metric", metric, "--report", "r.json")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertLess(abs(json.loads((self.folder.path / "r.json").read_text())
                                ["curve"]["before_correction"]["largest_length_reduction"]), 1e-12)

    def metric_report(self, metric, *operations):
        done = self.camber("curve", "two.mesh", "-o", "o.mesh", "--geometry", "straight", "--metric", json.dumps(metric),
                           "--set", "metric_operations=" + json.dumps(list(operations)), "--report", "r.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((self.folder.path / "r.json").read_text())["metric"]

    def test_complexity_of_constant_expression_and_field_metrics_is_as_expected(self):
        volume = 0.5  # volume of the two tetrahedra: 1/6 + 1/3
        constant = self.metric_report({"constant": {"sizes": [0.5]}})
        self.assertAlmostEqual(constant["complexity"], 8 * volume, places=9)
        for metric in ({"expression": {"size": "0.25 + 1/4"}}, {"expression": {"sizes": ["0.5", "1/2", "0.5 + 0*z"]}},
                       {"expression": {"tensor": ["4", "0", "2^2", "0", "0", "4"]}}):
            self.assertAlmostEqual(self.metric_report(metric)["complexity"], 8 * volume, places=9)
        for name in ("linear", "polar-1", "polar-2", "rotating", "spherical-shock"):
            options = {"spherical-shock": {"centre": [0, 0, 0]}, "linear": {"position": 0}}.get(name, {})
            self.assertGreater(self.metric_report({"field": {name: options}})["largest_anisotropy"], 1, name)
        thin = self.metric_report({"surface": {"tangent_size": 1, "normal_size": 0.1}})
        self.assertGreater(thin["complexity"], 1)  # every vertex is a corner: thin in two or three directions

    def test_metric_operations_change_complexity_and_anisotropy_as_requested(self):
        constant = {"constant": {"sizes": [0.5]}}
        self.assertAlmostEqual(self.metric_report(constant, {"complexity": {"target": 123}})["complexity"], 123, places=6)
        thin = {"constant": {"sizes": [0.01, 1, 1]}}
        self.assertAlmostEqual(self.metric_report(thin)["largest_anisotropy"], 100, places=6)
        self.assertAlmostEqual(self.metric_report(thin, {"bound": {"max_anisotropy": 5}})["largest_anisotropy"], 5,
                               places=6)
        crossed = self.metric_report(thin, {"intersect": {"constant": {"sizes": [1, 0.01, 1]}}})
        self.assertAlmostEqual(crossed["complexity"], 0.5 * 1e4, delta=1e-4)
        self.assertEqual(crossed["source"], "constant and constant")
        graded = self.metric_report({"expression": {"size": "x + y + z < 0.1 ? 0.01 : 10"}}, {"gradation": {"ratio": 1.2}})
        self.assertEqual(graded["gradations"], [{"sweeps": 2, "changed_vertices": 4, "converged": True}])

    def test_a_metric_is_intersected_with_a_file(self):
        self.write("sizes.sol", SIZES)
        both = self.metric_report({"constant": {"sizes": [0.5]}}, {"intersect": {"file": "sizes.sol"}})
        self.assertAlmostEqual(both["complexity"], 64 * 0.5, places=6)
        self.assertEqual(both["source"], "constant and sizes.sol")
        self.fails(3, "absent.sol", "curve", "two.mesh", "-o", "no.mesh", "--set",
                   'metric_operations=[{"intersect": {"file": "absent.sol"}}]')

    def test_wrong_metric_expressions_are_rejected_with_their_place(self):
        for message, metric in (('the expression "0.1*q" cannot be read at position 5, at "q"', {"size": "0.1*q"}),
                                ('vertex 2: the expression "0.5 - x" is -0.5 at (1, 0, 0)', {"size": "0.5 - x"}),
                                ("expected 3 expressions of sizes, got 2", {"sizes": ["1", "2"]})):
            self.fails(2, message, "curve", "two.mesh", "-o", "no.mesh", "--metric", json.dumps({"expression": metric}))
        self.fails(2, "/metric: the shock's point has 2 coordinates, the mesh 3", "curve", "two.mesh", "-o", "no.mesh",
                   "--metric", '{"field": {"planar-shock": {"point": [0, 0], "normal": [1, 0]}}}')
        self.fails(2, "/metric_operations/0/intersect/constant/sizes: expected 1 or 3 sizes", "curve", "two.mesh", "-o",
                   "no.mesh", "--set", 'metric_operations=[{"intersect": {"constant": {"sizes": [1, 2]}}}]')

    def test_an_analytic_sphere_reduces_the_distance_to_the_geometry(self):
        sphere = '{"analytic": [{"references": [1, 2], "sphere": {"centre": [0.5, 0.5, 0.5], "radius": 0.8660254037844386}}]}'
        done = self.camber("curve", "two.mesh", "-o", "o.mesh", "--geometry", sphere, "--report", "r.json")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        boundary = json.loads((self.folder.path / "r.json").read_text())["boundary"]
        self.assertLess(boundary["largest_distance"], boundary["largest_distance_straight"])

    def test_curve_accepts_settings_except_those_of_its_own_arguments(self):
        self.write("cube.mesh", CUBE)
        printed = self.camber("curve", "cube.mesh", "-o", "out.mesh", "--set", "geometry=straight", "--print-config")
        self.assertEqual(json.loads(printed.stdout)["geometry"], "straight")
        for setting in ("input/mesh=other.mesh", "output/mesh=other.mesh"):
            done = self.camber("curve", "cube.mesh", "-o", "out.mesh", "--set", setting)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("is set by an option of this verb", done.stderr)
        done = self.camber("curve", "cube.mesh", "-o", "out.mesh", "--min-scaled-jacobian", "0.2", "--set",
                           'stages=["elevate", "reinsert"]', "--print-config")
        self.assertIn('"min_scaled_jacobian": 0.2', done.stdout)

    # Guards against outputs that overwrite inputs or each other, also through links.
    def test_outputs_never_overwrite_inputs_or_each_other(self):
        self.write("m.sol", SIZES)
        for name in ("r.json", "old.vtu"):
            self.write(name, "old")
        (self.folder.path / "link.json").symlink_to("two.mesh")
        (self.folder.path / "link.vtu").symlink_to("m.sol")
        (self.folder.path / "here").symlink_to(".")
        (self.folder.path / "hard.json").hardlink_to(self.folder.path / "two.mesh")
        (self.folder.path / "plots").mkdir()
        (self.folder.path / "plots" / "curvature.svg").symlink_to("../two.mesh")
        self.write("run.json", json.dumps({"input": {"mesh": "two.mesh"}, "metric": {"file": "m.sol"}, "metric_operations":
                   [{"intersect": {"file": "m.sol"}}], "output": {"mesh": "o.mesh"}}))
        before = {path: (self.folder.path / path).read_bytes() for path in self.folder.files()}
        curve, run = ("curve", "two.mesh", "-o", "o.mesh"), ("run", "run.json", "--set")
        operand = 'metric_operations=[{"intersect": {"file": "m.sol"}}]'
        for message, arguments in (
                ("s.mesh: --report is the same file as -o ./s.mesh (give --report a separate file)",
                 ("curve", "two.mesh", "-o", "./s.mesh", "--report", "s.mesh")),
                ("same.mesh: --report is the same file as -o (", ("curve", "two.mesh", "-o", "same.mesh", "--report", "same.mesh")),
                ("two.mesh: --report is the same file as the input (inputs are not overwritten; give --report a",
                 (*curve, "--report", "two.mesh")),
                ("link.json: --report is the same file as the input two.mesh", (*curve, "--report", "link.json")),
                ("hard.json: --report is the same file as the input two.mesh", (*curve, "--report", "hard.json")),
                ("here/two.mesh: --report is the same file as the input", (*curve, "--report", "here/two.mesh")),
                ("here/o.mesh: --report is the same file as -o o.mesh", (*curve, "--report", "here/o.mesh")),
                ("--plots is the same file as the input two.mesh", (*curve, "--plots", "plots")),
                ("old.vtu: --vtu is the same file as -o", ("curve", "two.mesh", "-o", "old.vtu", "--vtu", "old.vtu")),
                ("m.sol: --report is the same file as --metric", (*curve, "--metric", "m.sol", "--report", "m.sol")),
                ("link.vtu: --vtu is the same file as --metric m.sol", (*curve, "--metric", "m.sol", "--vtu", "link.vtu")),
                ("m.sol: --report is the same file as /metric_operations/0/intersect/file",
                 (*curve, "--set", operand, "--report", "m.sol")),
                ("two.mesh: --report is the same file as the input",
                 ("repair", "two.mesh", "-o", "o.mesh", "--report", "two.mesh")),
                ("run.json: /output/report is the same file as the config", (*run, "output/report=run.json")),
                ("m.sol: /output/report is the same file as /metric/file", (*run, "output/report=m.sol")),
                ("o.mesh: /output/report is the same file as /output/mesh", (*run, "output/report=o.mesh")),
                ("m.sol: /output/metric is the same file as /metric/file", (*run, "output/metric=m.sol")),
                ("link.vtu: -o is the same file as --metric m.sol",
                 ("convert", "two.mesh", "-o", "link.vtu", "--metric", "m.sol")),
                ("m.sol: -o is the same file as the input", ("convert", "m.sol", "-o", "m.sol")),
                ("plots/curvature.svg: -o is the same file as the report two.mesh", ("plot", "two.mesh", "-o", "plots"))):
            with self.subTest(" ".join(arguments)):
                self.fails(2, message, *arguments)
                if arguments[0] in ("curve", "repair", "run"):
                    self.fails(2, message, *arguments, "--dry-run")
                self.assertEqual({path: (self.folder.path / path).read_bytes() for path in self.folder.files()}, before)

    def test_with_force_the_output_replaces_the_input(self):
        (self.folder.path / "link.mesh").symlink_to("two.mesh")
        done = self.camber("convert", "two.mesh", "-o", "two.mesh", "--elevate", "--force")
        self.assertEqual(done.returncode, 0, done.stderr)
        done = self.camber("repair", "two.mesh", "-o", "./link.mesh", "--report", "/dev/stdout", "--force")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((self.folder.path / "link.mesh").is_symlink())
        self.assertEqual(json.loads(self.camber("info", "two.mesh", "--json").stdout)["degree"], 2)

    # Guards against a failing second output that does not mention the first.
    def test_a_failed_output_reports_the_files_written_before(self):
        (self.folder.path / "r.json").symlink_to("/dev/full")
        (self.folder.path / "plots").mkdir()
        (self.folder.path / "plots" / "curvature.svg").symlink_to("/dev/full")
        curve = ("curve", "two.mesh", "-o", "o.mesh")
        for arguments, message in (((*curve, "--report", "r.json"),
                                    "r.json: cannot be written: No space left on device; written before: o.mesh ("),
                                   ((*curve, "--plots", "plots"), "plots/curvature.svg: cannot be written: No space left")):
            done = self.camber(*arguments)
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn(message, done.stderr)
            self.assertIn("written before: o.mesh", done.stderr)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertIn("o.mesh", self.folder.files())

    # Guards against commands that treat /dev/full and closed pipes differently.
    def test_all_verbs_report_a_failed_standard_output_alike(self):
        written = {"curve": "o.mesh", "repair": "p.mesh", "convert": "o.mesh", "plot": "plots"}
        verbs = (("convert", "two.mesh", "-o", "o.mesh", "--elevate"), ("repair", "o.mesh", "-o", "p.mesh"),
                 ("curve", "two.mesh", "-o", "o.mesh", "--report", "r.json"), ("plot", "r.json", "-o", "plots"),
                 ("curve", "two.mesh", "-o", "o.mesh", "--dry-run"), ("repair", "o.mesh", "-o", "p.mesh", "--print-config"),
                 ("check", "o.mesh"), ("check", "o.mesh", "--json"), ("check", "o.mesh", "--elements"), ("info", "o.mesh"),
                 ("info", "o.mesh", "--json"), ("explain",), ("explain", "curve"), ("schema",), ("--help",), ("--version",),
                 ("curve", "--help"))
        for verb in verbs:
            with self.subTest(" ".join(verb)):
                self.assertEqual(self.camber(*verb).returncode, 0)
                for redirection, reason in ((">/dev/full", "No space left on device"), (">&-", "Bad file descriptor")):
                    done = self.shell(f'"$@" {redirection}', *verb)
                    line = done.stderr.splitlines()[-1]
                    self.assertTrue(line.startswith(f"camber: standard output: cannot be written: {reason}"), line)
                    self.assertEqual(done.returncode, 3, line)
                    if verb[0] in written and not {"--dry-run", "--print-config", "--help"} & set(verb):
                        self.assertIn("; written before: ", line)
                        self.assertIn(written[verb[0]], line)
                # The reader closes before the first byte.
                done = self.shell('{ sleep 0.05; "$@"; echo $? >code; } | true', *verb)
                self.assertEqual((self.folder.path / "code").read_text(), "0\n", done.stderr)
                self.assertNotIn("standard output", done.stderr)

    def shell(self, script, *arguments):
        return subprocess.run(["sh", "-c", script, "sh", CAMBER, *arguments], cwd=self.folder.name, capture_output=True,
                              text=True, check=False)

    def test_a_closed_standard_output_does_not_corrupt_the_output_file(self):
        self.shell('"$@" >&- 2>&-', "curve", "two.mesh", "-o", "o.mesh")
        self.shell('"$@"', "curve", "two.mesh", "-o", "whole.mesh")
        self.assertEqual((self.folder.path / "o.mesh").read_bytes(), (self.folder.path / "whole.mesh").read_bytes())

    def test_a_failed_standard_error_does_not_change_the_exit_code(self):
        for redirection in ("2>/dev/full", "2>&-"):
            self.assertEqual(self.shell(f'"$@" {redirection}', "curve", "two.mesh", "-o", "o.mesh").returncode, 0)
            self.assertEqual(self.shell(f'"$@" {redirection}', "curve", "absent.mesh", "-o", "o.mesh").returncode, 3)

    def test_streams_are_read_and_written_like_files(self):
        self.shell('"$@"', "curve", "two.mesh", "-o", "whole.mesh")
        done = self.shell('"$@" <two.mesh >piped.mesh', "curve", "-", "-o", "-", "--format", "gmf-ascii")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("wrote standard output", done.stderr)
        self.assertEqual((self.folder.path / "piped.mesh").read_text(), (self.folder.path / "whole.mesh").read_text())
        done = self.shell('"$@" <two.mesh', "convert", "-", "-o", "-", "--format", "msh2-ascii", "--quiet")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertTrue(done.stdout.startswith("$MeshFormat\n2.2 0 8"))
        self.write("u.sol", SIZES)
        done = self.shell('"$@"', "transfer", "two.mesh", "two.mesh", "--solution", "u.sol", "-o", "-", "--format",
                          "gmf-ascii")
        self.assertTrue(done.stdout.startswith("MeshVersionFormatted"), done.stderr)
        report = self.shell('"$@"', "curve", "two.mesh", "-o", "o.mesh", "--report", "-")
        self.assertEqual(json.loads(report.stdout)["mesh"]["vertices"], 5)
        self.fails(2, "standard output: has no ending that determines the format", "convert", "two.mesh", "-o", "-")
        self.fails(2, "standard input: --solution and the input are both read from it", "metric", "-", "--solution", "-",
                   "-o", "m.sol")
        self.fails(2, "-o -: cycles read and write their files repeatedly", "adapt", "two.mesh", "-o", "-", "--metric", "0.3")

    def test_every_verb_that_writes_a_mesh_accepts_a_format_name(self):
        self.write("u.sol", SIZES)
        for verb in (("curve", "two.mesh"), ("remesh", "two.mesh"), ("adapt", "two.mesh", "--metric", "1"),
                     ("convert", "two.mesh"), ("generate", "box")):
            done = self.camber(*verb, "-o", "o.dat", "--format", "msh-ascii", "--quiet")
            self.assertEqual((done.returncode, done.stderr, done.stdout), (0, "", ""), verb)
            self.assertTrue((self.folder.path / "o.dat").read_text().startswith("$MeshFormat\n4.1 0 8"), verb)
        done = self.camber("transfer", "two.mesh", "two.mesh", "--solution", "u.sol", "-o", "v.dat", "--format", "vtu")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((self.folder.path / "v.dat").read_bytes().startswith(b"<?xml"))
        self.fails(2, 'did you mean "msh-ascii"?', "curve", "two.mesh", "-o", "p.msh", "--format", "msh-asci")

    def test_a_missing_output_folder_is_rejected_before_any_work(self):
        for arguments in (("curve", "two.mesh", "-o", "new/o.mesh"), ("convert", "two.mesh", "-o", "new/o.mesh"),
                          ("generate", "box", "-o", "new/o.mesh"), ("curve", "two.mesh", "-o", "o.mesh", "--report", "new/r"),
                          ("metric", "two.mesh", "--solution", "absent.sol", "-o", "new/o.sol"),
                          ("geometry", "two.mesh", "-o", "new/o.vtu")):
            self.fails(3, "its folder new does not exist (create it: mkdir -p new)", *arguments)
        self.fails(3, "its folder new does not exist", "curve", "two.mesh", "-o", "o.mesh", "--plots", "new/plots")

    def test_quiet_prints_failures_only(self):
        done = self.camber("curve", "two.mesh", "-o", "o.mesh", "--quiet")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        self.assertEqual(self.camber("check", "o.mesh", "--quiet").stdout, "")
        self.write("inverted.mesh", CUBE.replace("1 1 1 0", "0.2 0.2 0.2 0"))
        done = self.camber("curve", "inverted.mesh", "-o", "out.mesh", "--geometry", "straight", "--quiet")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("invalid: 2", done.stderr)
        self.assertEqual(self.camber("check", "inverted.mesh", "--quiet").returncode, 1)

    def test_check_prints_its_verdict_first(self):
        self.assertTrue(self.camber("check", "two.mesh").stdout.startswith(
            "yes: all 2 elements are certified valid, and the mesh is sound\ntwo.mesh\n"))
        self.write("inverted.mesh", CUBE.replace("1 1 1 0", "0.2 0.2 0.2 0"))
        self.assertTrue(self.camber("check", "inverted.mesh").stdout.startswith(
            "NO: 1 of 2 elements is inverted or flat: repair the straight mesh"))

    # Guards against a NUL character that truncates a path.
    def test_a_path_with_a_nul_character_is_rejected(self):
        for place, config in (("/output/report", {"output": {"mesh": "o.mesh", "report": "x\0y.json"}}),
                              ("/output/plots", {"output": {"mesh": "o.mesh", "plots": "x\0y"}}),
                              ("/metric/file", {"metric": {"file": "x\0y"}, "output": {"mesh": "o.mesh"}})):
            self.write("run.json", json.dumps({"input": {"mesh": "two.mesh"}} | config))
            self.fails(2, f'{place}: the path has a NUL character after "x', "run", "run.json")

    # Guards against a failure for output names of 251 bytes because of the temporary name.
    def test_output_names_of_up_to_255_bytes_are_written(self):
        for length in (251, 255):
            name = "n" * (length - 5) + ".mesh"
            done = self.camber("curve", "two.mesh", "-o", name)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(name, self.folder.files())

    def test_messages_stay_short_for_very_long_arguments(self):
        long = "x" * 100_000
        verbs = re.findall(r"^  ([a-z]+)  ", self.folder.camber("--help").stdout.split("Subcommands:")[1], flags=re.M)
        self.assertIn("remesh", verbs)
        for verb in verbs:
            text = self.folder.camber(verb, "--help-all").stdout
            options = re.findall(r"--([a-z-]+)(?= [A-Za-z]+[^a-z])", "\n".join(
                line for line in text.splitlines() if line.startswith("  -")))
            values = {"metric": ['{"' + long + '": 1}', '{"file": "' + long + '"}'], "geometry": ['{"' + long + '": 1}'],
                      "set": [long + "=1", "threads=" + long], "size": ["1=" + long]}
            for words in ([long], ["--" + long], *(["two.mesh", "-o", "o.mesh", "--" + option, value] for option in options
                                                   for value in [long, *values.get(option, [])])):
                with self.subTest(verb=verb, words=[word[:30] for word in words]):
                    done = self.folder.camber(verb, *words)
                    self.assertIn(done.returncode, (0, 1, 2, 3), done.stderr[:400])
                    self.assertLess(len(done.stderr), 6000)

    # Guards against a misspelt command without a suggestion.
    def test_misspelt_commands_and_options_get_a_suggestion(self):
        self.fails(2, 'camber: cuvre: is not a command (did you mean "curve"?)', "cuvre", "two.mesh", "-o", "o.mesh")
        self.fails(2, "camber: fly: is not a command (known: run, curve,", "fly")
        self.fails(2, 'camber: --jsn: is not an option of camber check (did you mean "--json"?)', "check", "two.mesh", "--jsn")
        self.fails(2, 'camber: --ouput=o.mesh: is not an option of camber curve (did you mean "--output"?)', "curve", "two.mesh", "--ouput=o.mesh")
        self.fails(2, 'did you mean "--boundary-tolerance"?', "repair", "two.mesh", "-o", "o.mesh", "--boundary", "0.1")
        self.fails(2, "camber: -o, --output: is missing (see camber curve --help)", "curve", "two.mesh")

    # Guards against malformed JSON used as a file name.
    def test_a_metric_argument_that_begins_as_json_is_parsed_as_json(self):
        curve = ("curve", "two.mesh", "-o", "o.mesh", "--metric")
        self.fails(2, "--metric: expected an object, got an array", *curve, "[1,2]")
        self.fails(2, "--metric: line 1, column 5: syntax error", *curve, "[1,2")
        self.fails(2, "--metric: line 1, column 2: syntax error", *curve, "{1,2}")
        self.write("[1,2].sol", SIZES)
        self.assertEqual(self.camber(*curve, "./[1,2].sol").returncode, 0)

    # Guards against badly wrapped help and repeated exit codes.
    def test_help_lines_fit_100_columns_and_only_the_main_help_lists_exit_codes(self):
        texts = {verb: self.camber(*verb.split(), "--help").stdout
                 for verb in ("", "run", "curve", "repair", "convert", "plot", "picture", "check", "info", "explain", "schema")}
        for verb, text in texts.items():
            self.assertLessEqual(max(map(len, text.splitlines())), 100, text)
            self.assertEqual(text.count("Exit codes"), 0 if verb else 1, verb)
        self.assertNotIn("--boundary-tolerance 1e-3", texts[""])
        self.assertIn("--boundary-tolerance 1e-3", texts["repair"])

    def test_a_sphere_without_a_centre_is_accepted(self):
        geometry = '{"analytic": [{"references": [1], "sphere": {"radius": 5}}]}'
        printed = self.camber("curve", "cube.mesh", "-o", "out.mesh", "--geometry", geometry, "--print-config")
        self.assertEqual(printed.returncode, 0, printed.stderr)
        self.assertEqual(json.loads(printed.stdout)["geometry"]["analytic"][0]["sphere"]["radius"], 5)

    def test_planned_nodes_that_are_not_committed_are_a_note(self):
        self.write("cube.mesh", CUBE)
        done = self.camber("curve", "cube.mesh", "-o", "out.mesh", "--set", 'stages=["elevate", "curve"]')
        self.assertIn("planned nodes were not committed", done.stderr)

    def test_curve_reorients_reversed_elements_and_notes_it(self):
        self.write("reversed.mesh", CUBE.replace("1 2 3 4 1", "1 3 2 4 1"))
        done = self.camber("curve", "reversed.mesh", "-o", "out.mesh", "--geometry", "straight")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("tetrahedron 1 is numbered the wrong way round: turned", done.stderr)
        self.assertEqual(self.camber("check", "out.mesh").returncode, 0)

    def test_inverted_input_exits_with_code_1_and_reports_the_element(self):
        self.write("inverted.mesh", CUBE.replace("1 1 1 0", "0.2 0.2 0.2 0"))
        done = self.camber("curve", "inverted.mesh", "-o", "out.mesh", "--geometry", "straight")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("invalid: 2", done.stderr)

    def test_an_interrupted_run_writes_no_output(self):
        run = subprocess.Popen([CAMBER, "run", CONFIGS / "spheres-fine.json", "--threads", "1"], cwd=self.folder.name,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(3 if SANITIZED else 0.5)  # until it runs
        run.send_signal(signal.SIGINT)
        _, error = run.communicate(timeout=60)
        self.assertEqual(run.returncode, 130, error)
        self.assertEqual([f for f in self.folder.files() if f.startswith("out/")], [])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
