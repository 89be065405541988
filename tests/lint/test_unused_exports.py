"""The check for unused exports: it finds unused names and no used ones in small sources, and none in the program."""
import contextlib
import io
import tempfile
import unittest
from pathlib import Path

from unused_exports import main, unused

INTERFACE = """export module camber.a:b;
import camber.core;
export namespace camber {
template <int D>
[[nodiscard]] Outcome<Vec<D>> placed(const Mesh<D>& mesh, double share = 0.5);
inline constexpr double share = 1e-9;
struct Box {
    double low = 0;
    [[nodiscard]] bool is_empty() const { return low > 0; }
    static constexpr int sides = 4;
  private:
    void grow();
};
}
"""
BODY = """module camber.a;
namespace camber {
template <int D>
Outcome<Vec<D>> placed(const Mesh<D>& mesh, double share) { return placed(mesh, share / 2); }
#define CAMBER_INSTANTIATE(D) \\
    template Outcome<Vec<D>> placed<D>(const Mesh<D>&, double);
CAMBER_INSTANTIATE(2)
}
"""
ALL = {"placed": "nothing", "share": "nothing", "Box": "nothing", "Box::is_empty": "nothing", "Box::sides": "nothing"}


class UnusedExports(unittest.TestCase):
    def found(self, **sources):
        with tempfile.TemporaryDirectory() as folder:
            for path, text in {"modules/a/b.cppm": INTERFACE, "modules/a/b.cpp": BODY, **sources}.items():
                (Path(folder) / path).parent.mkdir(parents=True, exist_ok=True)
                (Path(folder) / path).write_text(text)
            return {row[2]: row[4] for row in unused(Path(folder))}

    def test_declarations_instantiations_and_own_bodies_are_no_uses(self):
        self.assertEqual(self.found(), ALL)

    def test_comments_imports_and_local_variables_are_no_uses(self):
        text = "import camber.a:share;  // placed(Box)\nint main() { const double share = 1; return share > 2; }\n"
        self.assertEqual(self.found(**{"apps/camber/main.cpp": text}), ALL)

    def test_the_program_uses_a_name(self):
        text = "int main() { Box box; return box.is_empty() + placed<2>({}, 1); }\n"
        self.assertEqual(self.found(**{"apps/camber/main.cpp": text}), {"share": "nothing", "Box::sides": "nothing"})

    def test_unused_functions_use_nothing(self):
        text = "namespace { double forgotten() { return share + Box::sides; } }\nint main() {}\n"
        self.assertEqual(self.found(**{"apps/camber/main.cpp": text}), ALL)

    def test_callers_are_listed(self):
        sources = {"tests/a/box.cpp": "CHECK(Box{}.is_empty());", "bench/box.cpp": "Box{};", "modules/a/example.cpp": "int main() { Box{}; }"}
        self.assertEqual(self.found(**sources), {**ALL, "Box": "tests bench examples", "Box::is_empty": "tests"})

    def test_the_program_has_no_unused_exports(self):
        with contextlib.redirect_stdout(io.StringIO()) as text:
            code = main([])
        self.assertEqual(code, 0, text.getvalue())


if __name__ == "__main__":
    unittest.main()
