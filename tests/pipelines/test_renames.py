"""Names of earlier versions: CHANGELOG.md lists them, and their use is an error that states the new name.

    python3 tests/pipelines/test_renames.py build/bin/camber [unittest arguments]
"""
import json
import re
import unittest

from made_meshes import lattice
from program import ROOT, Folder

TABLE = ROOT / "apps" / "camber" / "config" / "renames.cppm"
STAGES = ["elevate", "curve", "validate", "relax", "commit", "collapse", "split", "swap", "smooth", "improve", "remesh"]
CONFIG = {"input": {"mesh": "wing.mesh"}, "metric": {"sizes": [{"references": [1], "size": 1}]},
          "geometry": {"cad": {"file": "wing.step"}}, "stages": [{stage: {}} for stage in STAGES], "adapt": {"cycles": 2}}


def table_of_program():
    """{kind: {(old, new)}}."""
    table = {}
    for kind, old, new in re.findall(r'\{NameKind::(\w+), "([^"]+)", "([^"]+)"\}', TABLE.read_text()):
        table.setdefault(kind, set()).add((old, new))
    return table


def table_of_page(title):
    """(old, new) of the table under that heading of CHANGELOG.md."""
    section = (ROOT / "CHANGELOG.md").read_text().split(f"#### {title}\n")[1].split("\n#")[0]
    return [(old, new) for old, new in re.findall(r"^\| `([^`]+)` \| `([^`]+)` \|$", section, flags=re.M)]


def last(path):
    """The last word of a path; an option without its dashes."""
    return re.split(r"[/.= ]", path)[-1].removeprefix("--")


class Renames(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        (self.folder.path / "wing.mesh").write_text(lattice(3, 1).text())
        (self.folder.path / "all.json").write_text(json.dumps(CONFIG))

    def error(self, *arguments):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, 2, (arguments, done.stdout, done.stderr))
        return done.stderr

    def test_the_changelog_lists_all_renamed_names_of_the_program(self):
        table = table_of_program()
        for kind, title in (("key", "Options of configs"), ("value", "Values of options"), ("argument", "Options of the command line")):
            listed = {(last(old), last(new)) for old, new in table_of_page(title)}
            self.assertEqual(listed, table[kind], title)
        listed = {(last(old), last(new)) for old, new in table_of_page("Keys of reports")}
        self.assertLessEqual(table["report_key"], listed)

    def test_old_options_and_values_are_errors_that_state_the_new_names(self):
        for old, new in table_of_page("Options of configs"):
            self.assertIn(f'"{last(old)}" was renamed to "{last(new)}"', self.error("run", "all.json", "--set", f"{old}=1"))
            self.assertNotIn("renamed", self.folder.camber("run", "all.json", "--set", f"{new}=1").stderr)
        for old, new in table_of_page("Values of options"):
            self.assertIn(f'"{last(old)}" was renamed to "{last(new)}"', self.error("run", "all.json", "--set", old))
            plan = self.folder.camber("run", "all.json", "--set", new, "--print-config")
            self.assertEqual(plan.returncode, 0, plan.stderr)

    def test_old_stages_are_errors_that_state_the_new_names(self):
        for stage in ("mend", {"mend": {}}):
            (self.folder.path / "old.json").write_text(json.dumps(CONFIG | {"stages": [stage]}))
            self.assertIn('"mend" was renamed to "improve"', self.error("run", "old.json"))

    def test_old_arguments_are_errors_that_state_the_new_names(self):
        for old, new in table_of_page("Options of the command line"):
            verb, option = old.removeprefix("camber ").split()
            self.assertIn(f"was renamed to {new}", self.error(verb, "wing.mesh", "-o", "out.mesh", option, "1"))
            self.assertIn(f'was renamed to "{new}"', self.error("explain", option))

    def test_explain_states_the_new_names_of_report_keys(self):
        """An old key that is also another term is explained as that term."""
        stated = 0
        for old, new in table_of_program()["report_key"]:
            done = self.folder.camber("explain", old)
            if done.returncode != 0:
                self.assertRegex(done.stderr, rf'was renamed to .*"{new}"')
                stated += 1
        self.assertGreater(stated, 40)

    def test_reports_of_other_formats_are_rejected(self):
        for number, remedy in ((4, "CHANGELOG.md"), (99, "the version of Camber that wrote it")):
            (self.folder.path / "report.json").write_text(json.dumps({"format": number, "histograms": {}}))
            for words in (("plot", "report.json", "-o", "plots"), ("report", "report.json", "-o", "out.html")):
                done = self.folder.camber(*words)
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertRegex(done.stderr, rf"report.json: has the report format {number}; this version reads format \d+ \(.*{remedy}")


if __name__ == "__main__":
    import sys
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
