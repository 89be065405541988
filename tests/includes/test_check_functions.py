"""The check for functions of the C library finds calls and addresses of them, and nothing else; no source of the program has one."""
import contextlib
import io
import tempfile
import unittest
from pathlib import Path

from check_functions import NAMES, main, refused


class Functions(unittest.TestCase):
    def found(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "unit.cpp"
            path.write_text(text)
            return refused(path)

    def test_each_function(self):
        for name in NAMES:
            for call in (f"std::{name}(x)", f"::{name}(x)", f"__builtin_{name}(x)", f"std::{name}f(x)"):
                with self.subTest(call):
                    self.assertEqual(len(self.found(f"double f(double x) {{\n return 1 + {call}; }}\n")), 1)

    def test_an_address(self):
        self.assertEqual(self.found("auto f = &std::exp;\n"), [(1, "std::exp")])

    def test_what_calls_the_library_by_itself(self):
        self.assertEqual(len(self.found("std::complex<double> z;\nstd::normal_distribution<double> d;\n")), 2)

    def test_what_is_exact(self):
        self.assertEqual(self.found("double f(double x) { return std::sqrt(std::fma(x, x, std::floor(x))) + std::ldexp(x, 2); }\n"), [])

    def test_our_own(self):
        self.assertEqual(self.found("double f(double x) { return exp(x) + camber::log(x) + s.exp(x); }  // not std::exp\n"), [])

    def test_the_program(self):
        with contextlib.redirect_stdout(io.StringIO()) as text:
            code = main([])
        self.assertEqual(code, 0, text.getvalue())


if __name__ == "__main__":
    unittest.main()
