"""Tests of bench/tables.py on artificial pages, and of the comments of measured tables in docs/ and bench/results/.

    python3 tests/pages/test_tables.py [unittest arguments]
"""
import contextlib
import io
import re
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
import tables  # noqa: E402

TABLE = "| mesh | elements | error | s |\n|---|---|---|---|\n| a-1 | 1 000 | 2.0e-3, valid | 1.0 |\n| a-2 | 0 | -0.05 (3 s) | 2.0 |\n"
OTHER = "| way | L2 |\n|---|---|\n| one | 0.5 |\n"
TEXT = "  cycle  elements  seconds\n      1     1 000     0.10\n      2     2 000     0.20\n"


class Pages(unittest.TestCase):
    """A page with one command that prints a file."""

    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.folder = Path(made.name)
        self.page, self.camber = self.folder / "page.md", self.folder / "build" / "bin" / "camber"
        self.camber.parent.mkdir(parents=True)
        self.camber.write_text("#!/bin/sh\ncat " + str(self.folder / "output.txt") + "\n")
        self.camber.chmod(0o755)

    def put(self, page_tables, output, head="```sh\ncamber adapt\n```\n", within="1.3"):
        """Writes a page with these tables after one command, and the output of the command."""
        blocks = [f"<!-- measured t{k}: within {within}; 1 s -->\n" + (f"```text\n{table}```\n" if table is TEXT else table)
                  for k, table in enumerate(page_tables)]
        self.page.write_text("# Page\n\n" + head + "\nSome words.\n\n" + "\nMore words.\n\n".join(blocks) + "\nThe end.\n")
        (self.folder / "output.txt").write_text(output)

    def run_tables(self, *words):
        """Returns exit code and output."""
        output = io.StringIO()
        with mock.patch.object(sys, "argv", ["tables.py", str(self.page), "--camber", str(self.camber), *words]):
            with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
                try:
                    tables.main()
                except SystemExit as end:
                    return (1 if isinstance(end.code, str) else end.code or 0), output.getvalue() + str(end.code)
        return 0, output.getvalue()

    def differs(self, old, new, expected):
        self.put([TABLE], TABLE.replace(old, new))
        code, output = self.run_tables()
        self.assertEqual(code, 1, output)
        self.assertIn(expected, output)

    def agrees(self, old, new):
        self.put([TABLE], TABLE.replace(old, new))
        code, output = self.run_tables()
        self.assertEqual(code, 0, output)

    def test_an_equal_table_agrees(self):
        self.agrees("", "")

    def test_numbers_within_the_factor_agree(self):
        for old, new in (("1 000", "1 299"), ("1 000", "770"), ("2.0e-3", "2.5e-3"), ("-0.05", "-0.06"), ("-0.05", "−0.04")):
            self.agrees(old, new)

    def test_numbers_beyond_the_factor_differ(self):
        for old, new in (("1 000", "1 301"), ("2.0e-3", "2.7e-3"), ("-0.05", "0.05"), ("-0.05", "-0.07"), (" 0 ", " 1 ")):
            self.differs(old, new, f"{old.strip()}, printed {new.strip()}")

    def test_rounding_errors_agree(self):
        self.put([TABLE.replace("2.0e-3", "2.0e-16")], TABLE.replace("2.0e-3", "9.0e-15"))
        self.assertEqual(self.run_tables()[0], 0)

    def test_seconds_are_reported_and_not_compared(self):
        self.put([TABLE], TABLE.replace("| 1.0 |", "| 9.0 |").replace("3 s", "30 s"))
        code, output = self.run_tables()
        self.assertEqual(code, 0, output)
        self.assertIn("1 to 10 of the page's", output)

    def test_texts_keys_titles_and_rows_are_compared(self):
        self.differs("valid", "invalid", "'2.0e-3, valid', printed '2.0e-3, invalid'")
        self.differs("a-2", "a-1", "row 2: 'a-2', printed 'a-1'")
        self.differs("| error |", "| mistake |", "titles")
        self.differs("| a-2 | 0 | -0.05 (3 s) | 2.0 |\n", "", "4 lines, printed 3")

    def test_tables_of_one_command_are_compared_in_order(self):
        self.put([TABLE, OTHER], f"words\n{TABLE}\n\n{OTHER}")
        self.assertEqual(self.run_tables()[0], 0)
        self.put([OTHER, TABLE], f"words\n{TABLE}\n\n{OTHER}")
        self.assertEqual(self.run_tables()[0], 1)
        self.put([TABLE, OTHER], TABLE)
        self.assertIn("the output has 1 tables, the page at least 2", self.run_tables()[1])

    def test_text_blocks_are_found_by_their_first_line(self):
        self.put([TEXT], "words\n" + TEXT.replace("2 000", "2 100").replace("0.20", "9.00") + "\nmore\n")
        self.assertEqual(self.run_tables()[0], 0)
        self.put([TEXT], TEXT.replace("2 000", "3 000"))
        self.assertIn("2 000, printed 3 000", self.run_tables()[1])
        self.put([TEXT], "words\n")
        self.assertIn("no line 'cycle  elements  seconds'", self.run_tables()[1])

    def test_write_updates_the_tables_of_the_page(self):
        self.put([TABLE, TEXT, OTHER], TABLE.replace("1 000", "5 000") + "\n" + TEXT.replace("2 000", "7 000") + "\n" + OTHER.replace("0.5", "9.5"))
        before = self.page.read_text()
        self.run_tables("--write")
        after = before.replace("1 000 | 2", "5 000 | 2").replace("2 000", "7 000").replace("0.5 ", "9.5 ")
        self.assertEqual(self.page.read_text(), after)
        self.assertEqual(self.run_tables()[0], 0)

    def test_options_only_and_longest_select_tables(self):
        self.put([TABLE, OTHER], TABLE + "\n" + OTHER.replace("0.5", "9.5"))
        self.assertEqual(self.run_tables("--only", "t0")[0], 0)
        self.assertEqual(self.run_tables("--only", "t1")[0], 1)
        self.assertEqual(self.run_tables("--longest", "0.5"), (0, "0"))
        self.assertEqual(self.run_tables("--only", "t7")[0], 2)

    def test_list_runs_no_command(self):
        self.put([TABLE], "nothing")
        code, output = self.run_tables("--list")
        self.assertEqual(code, 0)
        self.assertIn("| t0 |", output)
        self.assertIn("| 1.3 | 1 |  | `camber adapt` |", output)

    def test_a_failed_command_is_reported(self):
        self.put([TABLE], TABLE, head="```sh\necho no such mesh >&2; exit 3\n```\n")
        code, output = self.run_tables()
        self.assertEqual(code, 1)
        self.assertIn("exit code 3: no such mesh", output)

    def test_a_command_with_a_missing_program_is_skipped_and_reported(self):
        self.put([TABLE], TABLE, head="```sh\nbuild/bin/absent\n```\n")
        code, output = self.run_tables()
        self.assertEqual((code, "not run, as there is no absent" in output), (0, True), output)

    def test_wrong_comments_are_reported_with_their_line(self):
        for head, within, expected in (("", "1.3", "no `sh` block above it"), ("```sh\ncamber\n```\n", "much", "not of the form")):
            self.put([TABLE], TABLE, head=head, within=within)
            code, output = self.run_tables()
            self.assertEqual(code, 1)
            self.assertRegex(output, rf"page.md: line \d+: {expected}")
        self.put(["No table.\n"], TABLE)
        self.assertIn("neither a table nor a `text` block", self.run_tables()[1])

    def test_commands_find_the_files_of_the_project(self):
        self.put([TABLE], TABLE, head="```sh\ntest -f bench/tables.py && test -f configs/spheres.json && build/bin/camber\n```\n")
        self.assertEqual(self.run_tables()[0], 0)


class Markers(unittest.TestCase):
    """The measured tables of the real pages."""

    def all_tables(self):
        return [table for page in tables.pages() for table in tables.tables_of(page)]

    def test_names_of_measured_tables_are_unique(self):
        names = [table.name for table in self.all_tables()]
        self.assertEqual(len(names), len(set(names)), sorted(name for name in names if names.count(name) > 1))
        self.assertGreater(len(names), 10)

    def test_programs_and_scripts_of_commands_exist(self):
        for table in self.all_tables():
            programs, scripts = tables.programs_of(table.command)
            with self.subTest(table=table.name):
                self.assertTrue(programs or scripts or "camber " in table.command, table.command)
                for script in scripts:
                    self.assertTrue((ROOT / script).exists(), script)
                for program in programs:
                    sources = [ROOT / "bench" / f"{program.removeprefix('bench_')}.cpp", ROOT / "apps" / program, ROOT / "tests" / program.removeprefix("test_")]
                    self.assertTrue(any(source.exists() for source in sources), program)

    def test_commands_read_only_files_of_the_project_or_earlier_outputs(self):
        """A file that a command reads belongs to the project or is written by an earlier line of the command."""
        for table in self.all_tables():
            made = set()
            for line in table.command.replace("\\\n", " ").splitlines():
                made |= set(re.findall(r"-o (\S+)", line)) | set(re.findall(r"^build/bin/.* (\S+)$", line))
                for file in re.findall(r"(?<![\w/={])[\w./-]+\.(?:meshb?|solb?|msh|step)\b", line):
                    self.assertTrue(file in made or (ROOT / file).exists(), f"{table.name}: {file}")

    def test_stored_tables_begin_with_their_command(self):
        for page in (ROOT / "bench" / "results").glob("*.md"):
            with self.subTest(page=page.name):
                self.assertTrue(page.read_text(encoding="utf-8").startswith("```sh\n"))
                self.assertTrue(tables.tables_of(page))

    def test_the_results_page_has_at_most_5000_words(self):
        self.assertLessEqual(len((ROOT / "docs" / "results.md").read_text(encoding="utf-8").split()), 5000)


if __name__ == "__main__":
    unittest.main()
