"""Tests of check_includes.py."""
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

    def test_a_name_without_its_header_is_reported(self):
        self.assertEqual(self.names("module;\n#include <array>\nmodule m;\nstd::vector<int> v;\n"), [(4, "std::vector")])

    def test_a_call_in_a_template_is_reported(self):
        text = "template <class V> void f(V v) { std::visit([](auto) {}, v); }\n"
        self.assertEqual(self.names(text), [(1, "std::visit")])
        self.assertEqual(self.names("#include <variant>\n" + text), [])

    def test_a_structured_binding_of_edge_ends_requires_array(self):
        text = "void f(auto& m) { const auto& [a, b] = m.edges.vertices[0]; }\n"
        self.assertEqual(self.names(text), [(1, "a structured binding of ends")])
        self.assertEqual(self.names("#include <array>\n" + text), [])

    def test_a_member_of_std_ranges_requires_its_own_header(self):
        self.assertEqual(self.names("#include <ranges>\nauto s = std::ranges::sort;\n"), [(2, "std::ranges::sort")])

    def test_a_macro_without_its_header_is_reported(self):
        self.assertEqual(self.names("int e = errno;\n"), [(1, "errno")])

    def test_an_unknown_standard_name_is_reported(self):
        self.assertEqual(self.names("std::flat_map<int, int> m;\n"), [(1, "std::flat_map")])

    def test_names_in_comments_and_literals_are_ignored(self):
        self.assertEqual(self.names("// std::vector\n/* std::map */\nauto s = \"std::set errno\";\n"), [])

    def test_headers_included_by_project_headers_count(self):
        self.assertEqual(self.names('#include "ours.hpp"\nstd::vector<int> v;\n', ours="#include <vector>\n"), [])


if __name__ == "__main__":
    unittest.main()
