"""The check for missing imports and headers finds what is missing, and nothing else."""
import tempfile
import unittest
from pathlib import Path

from check_imports import missing, twice

TYPES = "export module camber.low:types;\nexport namespace camber {\nstruct Length {};\nint twice(int x);\n}\n"
LOW = "export module camber.low;\nexport import :types;\n"


class MissingImports(unittest.TestCase):
    def names(self, *texts):
        with tempfile.TemporaryDirectory() as folder:
            paths = [Path(folder) / f"{i}.{'cppm' if text.startswith('export ') else 'cpp'}" for i, text in enumerate(texts)]
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

    def test_an_implementation_unit_sees_the_interface_and_what_it_imports_itself(self):
        high = "export module camber.high;\n"
        helper = "export module camber.high:helper;\nint helped();\n"
        unit = "module camber.high;\n{}int f() {{ return twice(1) + helped(); }}\n"
        self.assertEqual(self.names(LOW, TYPES, high, helper, unit.format("import :helper;\n"), unit.format("import camber.low;\n")),
                         [("4.cpp", 3, "twice"), ("5.cpp", 3, "helped")])
        self.assertEqual(self.names(LOW, TYPES, high + "import camber.low;\nimport :helper;\n", helper, unit.format("")), [])

    def test_a_name_that_two_partitions_define(self):
        one = "module camber.low:{};\nnamespace camber{} {{\ninline constexpr double most = {};\ninline double f(double x) {{ return x; }}\n}}\n"
        with tempfile.TemporaryDirectory() as folder:
            def names(*texts):
                paths = [Path(folder) / f"{i}.cppm" for i in range(len(texts))]
                for path, text in zip(paths, texts):
                    path.write_text(text)
                return [(name, [path.name for path in of]) for name, of in twice(paths)]
            self.assertEqual(names(one.format("a", "", 3), one.format("b", "", 4)), [("most", ["0.cppm", "1.cppm"])])
            self.assertEqual(names(one.format("a", "", 3), one.format("b", "::other", 4)), [])

    def test_a_library_whose_header_a_neighbour_includes(self):
        unit = "module;\n{}module camber.low;\nauto f() {{ return fmt::format(\"\"); }}\n"
        self.assertEqual(self.names(LOW, TYPES, unit.format("#include <fmt/format.h>\n"), unit.format("")), [("3.cpp", 3, "fmt")])


if __name__ == "__main__":
    unittest.main()
