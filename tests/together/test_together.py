"""The text of a module's interface units says what they say one by one."""
import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "cmake"))
import together  # noqa: E402

UNITS = {
    "shapes": "export module camber.shapes;\nimport :inner;\nexport import :outer;\n",
    "outer": "module;\n#include <array>\n#include <vector>\nexport module camber.shapes:outer;\nimport camber.core;\nimport :inner;\n"
             "export namespace camber {\nint outer();\n}\n",
    "inner": "module;\n#include <array>\nexport module camber.shapes:inner;\nimport camber.core;\n"
             "#define CAMBER_ONE 1\nexport namespace camber {\nint inner();\n}\n",
    "far": "module;\n#include \"far.hpp\"\nmodule camber.shapes:far;\nimport :outer;\nimport :inner;\nnamespace camber {\nint far();\n}\n",
    "unit.cpp": "module camber.shapes;\nimport :inner;\nimport :far;\nint camber::outer() { return far(); }\n",
}


class Together(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name).resolve()
        (self.folder / "far.hpp").write_text("")
        for name, text in UNITS.items():
            self.path(name).write_text(text)
        self.beside = [self.path(name) for name in ("shapes", "outer", "inner", "far")]

    def path(self, name):
        return self.folder / (name if "." in name else f"{name}.cppm")

    def written(self, *names, code=0, install=()):
        out = self.folder / "text"
        with contextlib.redirect_stderr(io.StringIO()):
            self.assertEqual(together.write(out, [self.path(name) for name in names], self.beside, list(install)), code)
        return out.read_text() if out.exists() else ""

    def lines(self, *names):
        """Without what is told of places."""
        return [line for line in self.written(*names).splitlines() if line and not line.startswith(("#line", "//"))]

    def test_partitions_go_behind_what_they_import_and_export_what_the_module_exports(self):
        self.assertEqual(self.lines("shapes", "outer", "inner"), [
            "module;", "#include <array>", "#include <vector>", "export module camber.shapes;", "import camber.core;", "#define CAMBER_ONE 1",
            "namespace camber {", "int inner();", "}", "#undef CAMBER_ONE", "export namespace camber {", "int outer();", "}"])

    def test_each_line_is_told_where_it_is_from(self):
        self.written("shapes", "outer", "inner")
        text = self.folder / "text"
        places = dict(zip(text.read_text().splitlines(), together.places(text)))
        self.assertEqual(places["int outer();"], (self.path("outer"), 8))
        self.assertEqual(places["int inner();"], (self.path("inner"), 7))
        self.assertEqual(set(together.members(text)), {self.path(name) for name in ("shapes", "outer", "inner")})

    def test_a_partition_that_the_module_does_not_reach_imports_it(self):
        self.assertEqual(self.lines("far"), [
            "module;", f'#include "{self.folder}/far.hpp"', "module camber.shapes:far;", "import camber.shapes;",
            "namespace camber {", "int far();", "}"])

    def test_an_implementation_unit_imports_only_what_is_left_alone(self):
        self.assertEqual(self.lines("unit.cpp"), ["module;", "module camber.shapes;", "import :far;", "int camber::outer() { return far(); }"])

    def test_what_is_installed_names_no_folder(self):
        installed = self.folder / "installed"
        self.written("shapes", "outer", "inner", install=[installed])
        self.assertIn('#line 6 "camber/shapes/outer.cppm"', installed.read_text())
        self.assertNotIn(str(self.folder), installed.read_text())

    def test_what_is_installed_includes_no_header_of_ours(self):
        self.path("inner").write_text(UNITS["inner"].replace("<array>", '"far.hpp"'))
        with self.assertRaises(SystemExit):
            self.written("shapes", "outer", "inner", install=[self.folder / "installed"])

    def test_who_goes_together_anew_touches_the_stamp(self):
        self.path("shapes").write_text(UNITS["shapes"] + "import :far;\n")
        self.written("shapes", "outer", "inner", code=1)
        self.assertTrue((self.folder / "stamp").exists())
        self.written("far", code=1)

    def test_units_of_no_module_go_together_unless_a_header_is_in_the_way_of_who_does_not_include_it(self):
        self.path("waves.hpp").write_text("#pragma once\ninline constexpr double depth = 9;\nint waves();\n")
        self.path("one.cpp").write_text('#include "waves.hpp"\nimport camber.core;\nTEST_CASE("one") { waves(); }\n')
        texts = {}
        for name, line in {"neither": "int two = 2;", "shadowed": "int depth = 2;", "overloaded": "static int waves(int);"}.items():
            body = line if name == "overloaded" else f'TEST_CASE("two") {{\n    {line}\n}}'
            self.path("two.cpp").write_text(f"import camber.io;\n{body}\n")
            units = [together.read_source(self.path(unit)) for unit in ("one.cpp", "two.cpp")]
            texts[name] = len(together.texts_of(units, together.key_of, 100))
        self.assertEqual(texts, {"neither": 1, "shadowed": 2, "overloaded": 2})

    def test_partitions_that_import_each_other_are_an_error(self):
        self.path("inner").write_text(UNITS["inner"].replace("import camber.core;", "import :outer;"))
        with self.assertRaises(SystemExit):
            self.written("shapes", "outer", "inner")


if __name__ == "__main__":
    unittest.main()
