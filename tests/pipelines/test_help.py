"""Help, explanations, answers to options of other programs, and the flags --force and --verbose.

    python3 tests/pipelines/test_help.py build/bin/camber [unittest arguments]
"""
import json
import re
import sys
import unittest

from made_meshes import lattice
from program import Folder

GROUPS = ["Input", "Geometry", "Metric", "Quality", "Output", "Run"]


def titles(text):
    return [line[:-1] for line in text.splitlines() if re.fullmatch(r"[A-Z][a-z]+:", line)]


def options(text):
    """The long options in a help text."""
    lines = [line for line in text.splitlines() if re.match(r"  -", line)]
    return {name for line in lines for name in re.findall(r"(?:^  |,)(--[a-z-]+)", line)}


class Messages(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.write("wing.mesh", lattice(3, 1).text())

    def write(self, name, text):
        (self.folder.path / name).write_text(text)

    def camber(self, *arguments, code=0):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        return done


class Help(Messages):
    def setUp(self):
        super().setUp()
        listed = self.camber("--help").stdout.split("Subcommands:")[1]
        self.verbs = re.findall(r"^  ([a-z]+)  ", listed, flags=re.M)

    def test_every_option_is_in_a_group(self):
        self.assertIn("curve", self.verbs)
        for verb in self.verbs:
            shown = titles(self.camber(verb, "--help-all").stdout)
            self.assertEqual([title for title in shown if title not in ("Positionals", *GROUPS)], [], verb)
            self.assertEqual(sorted(shown, key=["Positionals", *GROUPS].index), shown, verb)
        self.assertEqual(titles(self.camber("curve", "--help").stdout), ["Positionals", *GROUPS])

    def test_help_lists_common_options_and_help_all_lists_every_option(self):
        for verb in self.verbs:
            common, every = self.camber(verb, "--help").stdout, self.camber(verb, "--help-all").stdout
            self.assertLessEqual(options(common), options(every), verb)
            is_complete = options(common) == options(every)
            self.assertEqual(f"camber {verb} --help-all" in common, not is_complete, verb)
        self.assertLess(len(options(self.camber("curve", "--help").stdout)), 25)
        self.assertIn("--cad-memory", options(self.camber("curve", "--help-all").stdout))
        self.assertNotIn("--cad-memory", options(self.camber("curve", "--help").stdout))

    def test_command_help_prints_the_help_of_verbs_and_options(self):
        self.assertEqual(self.camber("help").stdout, self.camber("--help").stdout)
        for verb in self.verbs:
            self.assertEqual(self.camber("help", verb).stdout, self.camber(verb, "--help").stdout, verb)
        self.assertIn("--geometry-error", self.camber("help", "geometry-error").stdout)
        self.assertIn('(did you mean "curve"?)', self.camber("help", "curv", code=2).stderr)

    def test_explain_describes_each_option_and_each_listed_word(self):
        for verb in self.verbs:
            for option in options(self.camber(verb, "--help-all").stdout) - {"--help", "--help-all"}:
                text = self.camber("explain", option).stdout
                self.assertTrue(text.startswith(f"{option}, an option of camber "), option)
                self.assertIn(verb, text)
                self.assertIn(text, self.camber("explain", option[2:]).stdout)
        listed = self.camber("explain").stdout
        groups = re.findall(r"^([A-Z][^:]*):\n((?:  .*\n)+)", listed, flags=re.M)
        for title in ("Stages", "Metrics", "Geometries", "Geometry options", "Words of the tables"):
            self.assertIn(title, [name for name, _ in groups])
        for _, words in groups:
            for word in " ".join(words.split()).split(", "):
                self.assertTrue(self.camber("explain", word).stdout.lower().startswith(word.lower()), word)

    def test_explain_describes_the_row_titles_of_summaries(self):
        summary = self.camber("curve", "wing.mesh", "-o", "out.mesh").stdout
        full = self.camber("curve", "wing.mesh", "-o", "out.mesh", "--verbose").stdout
        for text, rows in ((summary, ("valid", "smallest scaled Jacobian", "distance from the surrogate")),
                           (full, ("mean length reduction", "complexity", "min scaled jacobian", "moved vertices"))):
            for row in rows:
                self.assertIn(row, text)
                self.assertIn("\n\n  ", self.camber("explain", row).stdout)
        self.assertIn("did you mean", self.camber("explain", "complexty", code=2).stderr)


class OtherPrograms(Messages):
    def answer(self, *arguments):
        return self.camber(*arguments, code=2).stderr.strip()

    def test_options_of_gmsh_and_mmg_are_answered_with_the_option_of_camber(self):
        for option, remedy in (("-hausd", "--geometry-error"), ("--hausd", "--geometry-error"), ("--hausd=0.1", "--geometry-error"),
                               ("-hsiz", "remesh --metric"), ("-hmax", "max_size"), ("-hmin", "min_size"),
                               ("-hgrad", "--gradation"), ("-ar", "ridge_angle"), ("-nr", "ridge_angle=180"),
                               ("-optim", "remesh"), ("--optimize", "repair"), ("-optimize_ho", "repair"),
                               ("-clmax", "remesh --metric"), ("-clscale", "--complexity"), ("-order", "degree 2"),
                               ("--order", "degree 2"), ("--degree", "degree 2"), ("-nt", "--threads"), ("-v", "--verbose"),
                               ("-m", "--memory"), ("-sol", "--metric"), ("-out", "-o FILE"), ("-part", "--partition"), ("-bgm", "--metric FILE"), ("--overwrite", "--force"), ("-3", "leave it out")):
            with self.subTest(option):
                answer = self.answer("curve", "wing.mesh", "-o", "out.mesh", option, "3")
                self.assertTrue(answer.startswith(f"camber: {option}: is "), answer)
                self.assertIn(remedy, answer)
                self.assertEqual(self.folder.files(), ["wing.mesh"])

    def test_an_unknown_option_gets_at_most_three_suggestions(self):
        answer = self.answer("curve", "wing.mesh", "-o", "out.mesh", "--cat-units")
        self.assertIn("did you mean", answer)
        self.assertLessEqual(answer.count('"'), 6)
        self.assertIn("see camber curve --help-all", self.answer("curve", "wing.mesh", "-o", "out.mesh", "--xyzzy"))
        self.assertIn("it is an option of camber curve", self.answer("remesh", "wing.mesh", "-o", "out.mesh", "--memory", "2G"))

    def test_settings_that_answers_suggest_are_accepted(self):
        for setting in ('metric_operations=[{"bound": {"max_size": 0.1}}]', "features/ridge_angle=180"):
            self.camber("remesh", "wing.mesh", "-o", "out.mesh", "--set", setting, "--print-config")


class Files(Messages):
    def test_an_output_replaces_the_input_with_force_only(self):
        before = (self.folder.path / "wing.mesh").read_bytes()
        (self.folder.path / "link.mesh").symlink_to("wing.mesh")
        self.write("run.json", json.dumps({"input": {"mesh": "wing.mesh"}, "output": {"mesh": "wing.mesh"}}))
        for words in (("curve", "wing.mesh", "-o", "wing.mesh"), ("curve", "wing.mesh", "-o", "link.mesh"),
                      ("remesh", "wing.mesh", "-o", "./wing.mesh"), ("convert", "wing.mesh", "-o", "wing.mesh", "--elevate"),
                      ("run", "run.json")):
            with self.subTest(words):
                refused = self.camber(*words, code=2).stderr
                self.assertIn("is the same file as ", refused)
                self.assertIn("(name another output, or replace the input with --force)", refused)
                self.assertEqual((self.folder.path / "wing.mesh").read_bytes(), before)
        self.camber("run", "run.json", "--force")
        self.assertNotEqual((self.folder.path / "wing.mesh").read_bytes(), before)
        self.camber("repair", "wing.mesh", "-o", "wing.mesh", code=2)
        self.camber("repair", "wing.mesh", "-o", "wing.mesh", "--force")

    def test_adapt_never_replaces_its_input(self):
        done = self.camber("adapt", "wing.mesh", "-o", "wing.mesh", "--metric", "0.5", code=2)
        self.assertIn("inputs are not overwritten", done.stderr)

    def test_run_rejects_a_mesh_and_suggests_a_command(self):
        done = self.camber("run", "wing.mesh", code=2)
        self.assertIn("wing.mesh: is a mesh, but run requires a config in JSON", done.stderr)
        self.assertIn("camber curve", done.stderr)
        self.write("wing.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n")
        self.assertIn("is a mesh", self.camber("run", "wing.msh", code=2).stderr)

    def test_json_errors_do_not_quote_the_parser(self):
        for text in ("$x", "{'a': 1}", '{"a": tru}', '{"a": 1,}', '{"a" 1}', "[1, 2"):
            self.write("run.json", text)
            done = self.camber("run", "run.json", code=2)
            self.assertIn("syntax error", done.stderr)
            self.assertNotIn("last read", done.stderr)

    def test_messages_quote_folder_names_with_blanks(self):
        done = self.camber("curve", "wing.mesh", "-o", "my results/out.mesh", code=3)
        self.assertIn("(create it: mkdir -p 'my results')", done.stderr)

    def test_metric_options_are_rejected_where_no_metric_is_used(self):
        curve = ("curve", "wing.mesh", "-o", "out.mesh")
        for words in (("--size", "1=0.1"), ("--gradation", "2"), ("--complexity", "100"), ("--geometry-error", "0.1")):
            for objective in (("--objective", "shape"), ("--solution", "x*y")):
                done = self.camber(*curve, *words, *objective, code=2)
                self.assertIn(f"{words[0]}: has no effect", done.stderr)
                self.assertIn("camber remesh", done.stderr)
        self.camber(*curve, "--objective", "shape", "--geometry-error", "none")

    def test_format_notes_are_printed_with_verbose_only(self):
        text = lattice(3, 1).text().replace("End\n", "Corners\n2\n1\n2\nEnd\n")
        self.write("corners.mesh", text)
        curve = ("curve", "corners.mesh", "-o", "out.msh", "--report", "report.json")
        self.assertNotIn("has no place for 2 corners", self.camber(*curve).stderr)
        self.assertIn("note: MSH has no place for 2 corners", self.camber(*curve, "--verbose").stderr)
        self.assertIn("MSH has no place for 2 corners", json.loads((self.folder.path / "report.json").read_text())["notices"])
        self.assertIn("--quiet", self.camber(*curve, "--verbose", "--quiet", code=2).stderr)

    def test_format_notes_of_cycles_are_printed_with_verbose_only(self):
        self.camber("generate", "annulus", "-o", "ring.msh", "--elements", 60)
        adapt = ("adapt", "ring.msh", "--solution", "tanh(x)", "--cycles", 1, "-o")
        self.assertNotIn("GMF has no place for", self.camber(*adapt, "out.mesh").stderr)
        self.assertIn("note: GMF has no place for", self.camber(*adapt, "again.mesh", "--verbose").stderr)

    def test_lost_group_names_are_always_noted(self):
        self.camber("convert", "wing.mesh", "-o", "in.msh", "--format", "msh2-ascii")
        path = self.folder.path / "in.msh"
        path.write_text(path.read_text().replace("$Nodes", '$PhysicalNames\n1\n3 1 "steel"\n$EndPhysicalNames\n$Nodes', 1))
        self.assertIn("names of references", self.camber("curve", "in.msh", "-o", "out.mesh").stderr)


class Remedies(Messages):
    def test_no_error_suggests_the_command_that_failed(self):
        files = {"abaqus.inp": "*HEADING\n*NODE\n1, 0, 0, 0\n", "part.step": "ISO-10303-21;\n", "salome.med": "\x89HDF\r\n\x1a\n",
                 "text.txt": "hello\n", "empty.mesh": "", "cut.mesh": "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0",
                 "bad.msh": "$MeshFormat\n9.9 0 8\n$EndMeshFormat\n", "old.vtk": "# vtk DataFile Version 1.0\nx\nASCII\n",
                 "u.sol": "MeshVersionFormatted 2\nDimension 3\nSolAtVertices 1\n1 1\n1\nEnd\n", "quads.su2": "NDIME= 5\n"}
        for name, text in files.items():
            self.write(name, text)
        verbs = {"info": (), "check": (), "curve": ("-o", "o.mesh"), "remesh": ("-o", "o.mesh"), "repair": ("-o", "o.mesh"),
                 "convert": ("-o", "o.msh"), "report": ("-o", "o.html"), "picture": ("-o", "o.png"), "geometry": ()}
        for verb, more in verbs.items():
            for name in files:
                done = self.folder.camber(verb, name, *more)
                advice = re.sub(r"see camber \w+ --help(-all)?", "", done.stderr)
                self.assertNotRegex(advice, rf"camber {verb}(?! --| [A-Z]+ )", f"{verb} {name}")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
