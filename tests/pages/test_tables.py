"""bench/tables.py on made-up pages, and the comments of the measured tables in docs/ and bench/results/.

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
    """One page with one command, which prints a file."""

    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.folder = Path(made.name)
        self.page, self.camber = self.folder / "page.md", self.folder / "build" / "bin" / "camber"
        self.camber.parent.mkdir(parents=True)
        self.camber.write_text("#!/bin/sh\ncat " + str(self.folder / "output.txt") + "\n")
        self.camber.chmod(0o755)

    def put(self, page_tables, output, head="```sh\ncamber adapt\n```\n", within="1.3"):
        """Writes a page with these tables behind one command, and what the command prints."""
        blocks = [f"<!-- measured t{k}: within {within}; 1 s -->\n" + (f"```text\n{table}```\n" if table is TEXT else table)
                  for k, table in enumerate(page_tables)]
        self.page.write_text("# Page\n\n" + head + "\nSome words.\n\n" + "\nMore words.\n\n".join(blocks) + "\nThe end.\n")
        (self.folder / "output.txt").write_text(output)

    def run_tables(self, *words):
        """The exit code and the output."""
        said = io.StringIO()
        with mock.patch.object(sys, "argv", ["tables.py", str(self.page), "--camber", str(self.camber), *words]):
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
                try:
                    tables.main()
                except SystemExit as end:
                    return (1 if isinstance(end.code, str) else end.code or 0), said.getvalue() + str(end.code)
        return 0, said.getvalue()

    def differs(self, old, new, expected):
        self.put([TABLE], TABLE.replace(old, new))
        code, said = self.run_tables()
        self.assertEqual(code, 1, said)
        self.assertIn(expected, said)

    def agrees(self, old, new):
        self.put([TABLE], TABLE.replace(old, new))
        code, said = self.run_tables()
        self.assertEqual(code, 0, said)

    def test_the_same_table_agrees(self):
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

    def test_seconds_are_reported_only(self):
        self.put([TABLE], TABLE.replace("| 1.0 |", "| 9.0 |").replace("3 s", "30 s"))
        code, said = self.run_tables()
        self.assertEqual(code, 0, said)
        self.assertIn("1 to 10 of the page's", said)

    def test_texts_keys_titles_and_rows_are_compared(self):
        self.differs("valid", "invalid", "'2.0e-3, valid', printed '2.0e-3, invalid'")
        self.differs("a-2", "a-1", "row 2: 'a-2', printed 'a-1'")
        self.differs("| error |", "| mistake |", "titles")
        self.differs("| a-2 | 0 | -0.05 (3 s) | 2.0 |\n", "", "4 lines, printed 3")

    def test_tables_of_one_command_come_in_their_order(self):
        self.put([TABLE, OTHER], f"words\n{TABLE}\n\n{OTHER}")
        self.assertEqual(self.run_tables()[0], 0)
        self.put([OTHER, TABLE], f"words\n{TABLE}\n\n{OTHER}")
        self.assertEqual(self.run_tables()[0], 1)
        self.put([TABLE, OTHER], TABLE)
        self.assertIn("the output has 1 tables, the page at least 2", self.run_tables()[1])

    def test_text_blocks_begin_with_the_same_line(self):
        self.put([TEXT], "words\n" + TEXT.replace("2 000", "2 100").replace("0.20", "9.00") + "\nmore\n")
        self.assertEqual(self.run_tables()[0], 0)
        self.put([TEXT], TEXT.replace("2 000", "3 000"))
        self.assertIn("2 000, printed 3 000", self.run_tables()[1])
        self.put([TEXT], "words\n")
        self.assertIn("no line 'cycle  elements  seconds'", self.run_tables()[1])

    def test_write_puts_the_new_tables_into_the_page(self):
        self.put([TABLE, TEXT, OTHER], TABLE.replace("1 000", "5 000") + "\n" + TEXT.replace("2 000", "7 000") + "\n" + OTHER.replace("0.5", "9.5"))
        before = self.page.read_text()
        self.run_tables("--write")
        after = before.replace("1 000 | 2", "5 000 | 2").replace("2 000", "7 000").replace("0.5 ", "9.5 ")
        self.assertEqual(self.page.read_text(), after)
        self.assertEqual(self.run_tables()[0], 0)

    def test_only_and_longest_choose_tables(self):
        self.put([TABLE, OTHER], TABLE + "\n" + OTHER.replace("0.5", "9.5"))
        self.assertEqual(self.run_tables("--only", "t0")[0], 0)
        self.assertEqual(self.run_tables("--only", "t1")[0], 1)
        self.assertEqual(self.run_tables("--longest", "0.5"), (0, "0"))
        self.assertEqual(self.run_tables("--only", "t7")[0], 2)

    def test_list_runs_nothing(self):
        self.put([TABLE], "nothing")
        code, said = self.run_tables("--list")
        self.assertEqual(code, 0)
        self.assertIn("| t0 |", said)
        self.assertIn("| 1.3 | 1 |  | `camber adapt` |", said)

    def test_a_command_that_fails_is_reported(self):
        self.put([TABLE], TABLE, head="```sh\necho no such mesh >&2; exit 3\n```\n")
        code, said = self.run_tables()
        self.assertEqual(code, 1)
        self.assertIn("exit code 3: no such mesh", said)

    def test_what_is_not_installed_is_not_run(self):
        self.put([TABLE], TABLE, head="```sh\nbuild/bin/absent\n```\n")
        code, said = self.run_tables()
        self.assertEqual((code, "not run, as there is no absent" in said), (0, True), said)

    def test_wrong_comments_are_reported_with_their_line(self):
        for head, within, expected in (("", "1.3", "no `sh` block above it"), ("```sh\ncamber\n```\n", "much", "not of the form")):
            self.put([TABLE], TABLE, head=head, within=within)
            code, said = self.run_tables()
            self.assertEqual(code, 1)
            self.assertRegex(said, rf"page.md: line \d+: {expected}")
        self.put(["No table.\n"], TABLE)
        self.assertIn("neither a table nor a `text` block", self.run_tables()[1])

    def test_commands_find_the_files_of_the_project(self):
        self.put([TABLE], TABLE, head="```sh\ntest -f bench/tables.py && test -f configs/spheres.json && build/bin/camber\n```\n")
        self.assertEqual(self.run_tables()[0], 0)


class Markers(unittest.TestCase):
    """The comments in the pages."""

    def all_tables(self):
        return [table for page in tables.pages() for table in tables.tables_of(page)]

    def test_names_are_unique(self):
        names = [table.name for table in self.all_tables()]
        self.assertEqual(len(names), len(set(names)), sorted(name for name in names if names.count(name) > 1))
        self.assertGreater(len(names), 10)

    def test_what_commands_call_is_there(self):
        for table in self.all_tables():
            programs, scripts = tables.programs_of(table.command)
            with self.subTest(table=table.name):
                self.assertTrue(programs or scripts or "camber " in table.command, table.command)
                for script in scripts:
                    self.assertTrue((ROOT / script).exists(), script)
                for program in programs:
                    sources = [ROOT / "bench" / f"{program.removeprefix('bench_')}.cpp", ROOT / "apps" / program, ROOT / "tests" / program.removeprefix("test_")]
                    self.assertTrue(any(source.exists() for source in sources), program)

    def test_commands_need_no_file_that_a_user_cannot_have(self):
        """A file that a command reads is the project's, or an earlier line of the command makes it."""
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

    def test_results_are_short(self):
        self.assertLessEqual(len((ROOT / "docs" / "results.md").read_text(encoding="utf-8").split()), 5000)


if __name__ == "__main__":
    unittest.main()
