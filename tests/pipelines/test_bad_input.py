"""Runs all cases of bad input: exit code, one line on standard error, and no output file after a failure. docs/input.md
contains the printed messages and must equal them.

    python3 tests/pipelines/test_bad_input.py build/bin/camber [unittest arguments]
    python3 tests/pipelines/test_bad_input.py build/bin/camber --write      rewrite docs/input.md
"""
import json
import os
import re
import resource
import subprocess
import sys
import unittest

from bad_input import CASES
from program import CAMBER, ROOT, Folder

DOCUMENT = ROOT / "docs" / "input.md"
BEGIN, END = "<!-- made by tests/pipelines/test_bad_input.py --write -->\n", "<!-- end -->\n"
UNPRIVILEGED_USER = 65534


def filled(case):
    """A folder with the files of the case."""
    folder = Folder()
    for name, data in case.files().items():
        path = folder.path / name
        path.mkdir() if data is None else path.write_bytes(data)
    case.setup(folder.path)
    return folder


def skip_reason(case):
    """The reason why the case cannot be tested here, or ''."""
    if case.as_unprivileged_user and os.geteuid() == 0:
        probe = subprocess.run([CAMBER, "--version"], user=UNPRIVILEGED_USER, group=UNPRIVILEGED_USER, extra_groups=[], cwd="/",
                               capture_output=True)
        if probe.returncode != 0:
            return "nobody cannot run the program"
    return case.needs()


def started(case, folder, arguments):
    """Runs the case and returns the completed process."""
    if case.run:
        return case.run(folder)
    options = {}
    if case.limits:
        options["preexec_fn"] = lambda: [resource.setrlimit(kind, (n, n)) for kind, n in case.limits]
    if case.as_unprivileged_user and os.geteuid() == 0:
        options |= {"user": UNPRIVILEGED_USER, "group": UNPRIVILEGED_USER, "extra_groups": []}
        os.chmod(folder.path, 0o777)
    return folder.camber(*arguments, **options)


def line_of(case, done):
    """The message on standard error without the program name and without the stage if that varies."""
    text = done.stderr.strip()
    text = text.removeprefix("camber: ")
    if case.name == "Ctrl-C at any other time":
        text = re.sub(r"^\S+: stopped on request", "stopped on request", text)
    return re.sub(r"^\w+: not enough memory", "curve: not enough memory", text)


class BadInput(unittest.TestCase):
    """One test per case, added below."""

    def check_case(self, case):
        if reason := skip_reason(case):
            self.skipTest(f"{case.name}: {reason}")
        folder = filled(case)
        with folder:
            before = folder.files()
            done = started(case, folder, case.arguments)
            details = f"{case.group}, {case.name}: {done.returncode}\n{done.stderr}{done.stdout}"
            self.assertEqual(done.returncode, case.code, details)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1 if case.says else 0, details)
            self.assertIn(case.says, done.stderr, details)
            if case.code > 1:
                self.assertEqual(done.stdout, "", details)
                self.assertEqual(folder.files(), before, details)
            else:
                self.assertEqual(folder.files(), sorted([*before, "out.mesh"]), details)
                self.check_output(folder, case)
            if case.finds:
                self.check_finding(folder, case)
            OUTPUTS[id(case)] = line_of(case, done)

    def check_output(self, folder, case):
        """The output is sound and valid, unless the exit code says otherwise."""
        done = folder.camber("check", "out.mesh", "--json")
        soundness = json.loads(done.stdout)["soundness"]
        self.assertEqual(done.returncode, case.code, done.stdout)
        if case.code == 0:
            self.assertTrue(soundness["sound"], done.stdout)

    def check_finding(self, folder, case):
        """`check` counts the defect and repairs nothing."""
        done = folder.camber("check", "in.mesh", "--json")
        report = json.loads(done.stdout)
        self.assertGreater(report["soundness"][case.finds], 0, done.stdout)
        self.assertIn(case.finds, report["soundness"]["first"])
        self.assertEqual(done.returncode, 0 if report["soundness"]["sound"] and not report["invalid"] else 1)
        if case.does == "refused":
            self.assertEqual(done.returncode, 1)
        self.assertIn(" sound  ", folder.camber("check", "in.mesh").stdout)


OUTPUTS = {}


def add_tests():
    for number, case in enumerate(CASES):
        name = re.sub(r"\W+", "_", f"test_{number:03}_{case.group}_{case.name}").lower()
        setattr(BadInput, name, lambda self, case=case: self.check_case(case))


class Document(unittest.TestCase):
    """Runs after the cases, see `load_tests`."""

    def test_docs_input_md_equals_the_output_of_the_program(self):
        text = DOCUMENT.read_text()
        rows = dict(rows_of(text))
        tried = [case for case in CASES if id(case) in OUTPUTS]
        for case in tried:
            self.assertEqual(rows.get((case.group, case.name)), row(case, OUTPUTS[id(case)]),
                             "docs/input.md is not what the program does: --write")
        if len(tried) == len(CASES):
            self.assertEqual(len(rows), len(CASES), "docs/input.md has rows of cases that are no more: --write")


def row(case, line):
    cell = "`" + line.replace("|", "\\|") + "`" if line else "—"
    return f"| {case.name} | {case.does} | {case.code} | {cell} |"


def rows_of(text):
    """((group, name), row) of the tables in the document."""
    group = ""
    for line in text.partition(BEGIN)[2].partition(END)[0].splitlines():
        if line.startswith("### "):
            group = line[4:]
        elif line.startswith("| ") and not line.startswith("| given"):
            yield (group, line[2:].split(" | ")[0]), line


def tables(old):
    """The new tables; rows of cases that could not be tested are unchanged."""
    out, group = [], None
    for case in CASES:
        if case.group != group:
            group = case.group
            out += ["", f"### {group}", "", "| given | Camber | exit | it says |", "|---|---|---|---|"]
        out.append(row(case, OUTPUTS[id(case)]) if id(case) in OUTPUTS else old.get((group, case.name), ""))
    return "\n".join(out[1:]) + "\n\n"


def load_tests(loader, _tests, _pattern):
    suite = unittest.TestSuite()
    for kind in (BadInput, Document):
        suite.addTests(loader.loadTestsFromTestCase(kind))
    return suite


def write():
    """Runs all cases and rewrites the tables of the document."""
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(BadInput)
    result = unittest.TextTestRunner(verbosity=0).run(suite)
    text = DOCUMENT.read_text()
    head, _, rest = text.partition(BEGIN)
    DOCUMENT.write_text(head + BEGIN + tables(dict(rows_of(text))) + END + rest.partition(END)[2])
    return 0 if result.wasSuccessful() else 1


add_tests()
if __name__ == "__main__":
    if "--write" in sys.argv:
        sys.exit(write())
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
