"""The check for missing standard headers finds what is missing, and nothing else."""
import tempfile
import unittest
from pathlib import Path

from check_includes import missing


class MissingIncludes(unittest.TestCase):
    def names(self, text, **others):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in others.items():
                (Path(folder) / f"{name}.hpp").write_text(content)
            path = Path(folder) / "unit.cpp"
            path.write_text(text)
            return [(line, name) for line, name, _ in missing(path)]

    def test_a_name_without_its_header(self):
        self.assertEqual(self.names("module;\n#include <array>\nmodule m;\nstd::vector<int> v;\n"), [(4, "std::vector")])

    def test_a_call_in_a_template(self):
        text = "template <class V> void f(V v) { std::visit([](auto) {}, v); }\n"
        self.assertEqual(self.names(text), [(1, "std::visit")])
        self.assertEqual(self.names("#include <variant>\n" + text), [])

    def test_the_ends_of_an_edge_taken_apart(self):
        text = "void f(auto& m) { const auto& [a, b] = m.edges.vertices[0]; }\n"
        self.assertEqual(self.names(text), [(1, "a structured binding of ends")])
        self.assertEqual(self.names("#include <array>\n" + text), [])

    def test_a_member_of_a_namespace_of_many_headers(self):
        self.assertEqual(self.names("#include <ranges>\nauto s = std::ranges::sort;\n"), [(2, "std::ranges::sort")])

    def test_a_macro(self):
        self.assertEqual(self.names("int e = errno;\n"), [(1, "errno")])

    def test_a_name_that_is_not_known(self):
        self.assertEqual(self.names("std::flat_map<int, int> m;\n"), [(1, "std::flat_map")])

    def test_comments_and_literals_name_nothing(self):
        self.assertEqual(self.names("// std::vector\n/* std::map */\nauto s = \"std::set errno\";\n"), [])

    def test_a_header_of_ours_brings_its_own(self):
        self.assertEqual(self.names('#include "ours.hpp"\nstd::vector<int> v;\n', ours="#include <vector>\n"), [])


if __name__ == "__main__":
    unittest.main()
