"""Tests of check_functions.py; no source of the program has a finding."""
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

    def test_calls_of_each_function_are_found(self):
        for name in NAMES:
            for call in (f"std::{name}(x)", f"::{name}(x)", f"__builtin_{name}(x)", f"std::{name}f(x)"):
                with self.subTest(call):
                    self.assertEqual(len(self.found(f"double f(double x) {{\n return 1 + {call}; }}\n")), 1)

    def test_the_address_of_a_function_is_found(self):
        self.assertEqual(self.found("auto f = &std::exp;\n"), [(1, "std::exp")])

    def test_standard_types_that_call_the_functions_are_found(self):
        self.assertEqual(len(self.found("std::complex<double> z;\nstd::normal_distribution<double> d;\n")), 2)

    def test_exact_functions_are_accepted(self):
        self.assertEqual(self.found("double f(double x) { return std::sqrt(std::fma(x, x, std::floor(x))) + std::ldexp(x, 2); }\n"), [])

    def test_functions_of_camber_are_accepted(self):
        self.assertEqual(self.found("double f(double x) { return exp(x) + camber::log(x) + s.exp(x); }  // not std::exp\n"), [])

    def test_sources_of_the_program_call_no_such_function(self):
        with contextlib.redirect_stdout(io.StringIO()) as text:
            code = main([])
        self.assertEqual(code, 0, text.getvalue())


if __name__ == "__main__":
    unittest.main()
