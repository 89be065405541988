"""The check for missing imports between interface units finds what is missing, and nothing else."""
import tempfile
import unittest
from pathlib import Path

from check_imports import missing

TYPES = "export module camber.low:types;\nexport namespace camber {\nstruct Length {};\nint twice(int x);\n}\n"
LOW = "export module camber.low;\nexport import :types;\n"


class MissingImports(unittest.TestCase):
    def names(self, *texts):
        with tempfile.TemporaryDirectory() as folder:
            paths = [Path(folder) / f"{i}.cppm" for i in range(len(texts))]
            for path, text in zip(paths, texts):
                path.write_text(text)
            return [(path.name, line, name) for path, line, name, _ in missing(paths)]

    def test_a_type_of_another_partition(self):
        more = "export module camber.low:more;\n{}export namespace camber {{\nLength f();\n}}\n"
        self.assertEqual(self.names(LOW, TYPES, more.format("")), [("2.cppm", 3, "Length")])
        self.assertEqual(self.names(LOW, TYPES, more.format("import :types;\n")), [])

    def test_what_an_imported_partition_imports_is_seen(self):
        between = "export module camber.low:between;\nimport :types;\n"
        more = "export module camber.low:more;\nimport :between;\ninline int f() { return twice(1); }\n"
        self.assertEqual(self.names(LOW, TYPES, between, more), [])

    def test_a_function_of_another_module_that_a_neighbour_imports(self):
        high = "export module camber.high;\nimport camber.low;\n"
        more = "export module camber.high:more;\ninline int f() { return twice(1); }\n"
        self.assertEqual(self.names(LOW, TYPES, high, more), [("3.cppm", 2, "twice")])

    def test_members_parameters_and_comments_are_no_names_of_others(self):
        more = "export module camber.low:more;\n// twice(1)\nint f(auto x, auto twice) { return x.twice(1) + twice(2); }\n"
        self.assertEqual(self.names(LOW, TYPES, more), [])


if __name__ == "__main__":
    unittest.main()
