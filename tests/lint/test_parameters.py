"""The check for long parameter lists: it finds each kind of function, counts parameters and nothing else, and none in the program."""
import contextlib
import io
import unittest

from parameters import excessive, main

SEVEN = "int a, int b, int c, int d, int e, int f, int g"


class Parameters(unittest.TestCase):
    def found(self, text):
        return [(name, count) for _, name, count in excessive(text)]

    def test_each_kind_of_function(self):
        for text, name in ((f"int f({SEVEN});", "f"),
                           (f"namespace {{\ntemplate <int D>\n[[nodiscard]] static std::vector<int> f({SEVEN}) {{ return {{}}; }}\n}}", "f"),
                           (f"export namespace a::b {{ void f({SEVEN}) noexcept; }}", "f"),
                           (f"struct S {{ virtual void f({SEVEN}) const = 0; }};", "f"),
                           (f"struct S {{ private: explicit S({SEVEN}) : a_(a), b_{{b}}, c_(c) {{}} }};", "S"),
                           (f"template <class T> T S<T>::f({SEVEN}) {{ return {{}}; }}", "f"),
                           (f"struct S {{ int operator()({SEVEN}) const {{ return 1; }} }};", "operator()"),
                           (f"template <class T> requires (sizeof(T) > 4) void f({SEVEN}) {{}}", "f"),
                           (f"auto f({SEVEN}) -> std::pair<int, int>;", "f"),
                           (f"CAMBER_MACRO(2)\nint f({SEVEN});", "f"),
                           (f"int x = g(1, 2);\nint y{{3}};\nint f({SEVEN});", "f"),
                           (f"void g() {{ struct S {{ void f({SEVEN}) {{}} }}; }}", "f"),
                           (f"void g() {{ const auto f = [&]({SEVEN}) {{ return a; }}; }}", "lambda"),
                           (f"void g() {{ use([a, b]<class T>({SEVEN}) mutable {{}}); }}", "lambda"),
                           ("int f(int, int, int, int, int, int, int);", "f")):
            with self.subTest(text):
                self.assertEqual(self.found(text), [(name, 7)])

    def test_commas_that_separate_no_parameters(self):
        for parameters in ("std::map<int, int> a, std::array<std::pair<int, int>, 3> b, int c, int d, int e, int f",
                           "int a, S b = {1, 2, 3}, S c = g(4, 5), S d = S<1, 2>{}, int e, int f",
                           "int (*a)(int, int, int), std::function<void(int, int)> b, int c, int d, int e, int f",
                           "int a /* b, c */, int d,  // e, f\nchar g = ',', const char* h = \"i, j\", int k, int l",
                           "const std::array<int, (N > 3 ? 1 : 2)>& a, int b, int c, int d, int e, bool f = 1 < 2",
                           "int (&a)[3], int b, int c, int d, int e, int f"):
            with self.subTest(parameters):
                self.assertEqual(self.found(f"void f({parameters});"), [])
                self.assertEqual(self.found(f"void f({parameters}, int last);"), [("f", 7)])

    def test_calls_are_no_functions(self):
        self.assertEqual(self.found("void f() { g(1, 2, 3, 4, 5, 6, 7); S s(a, b, c, d, e, f, g); T{1, 2, 3, 4, 5, 6, 7}; }"), [])
        self.assertEqual(self.found("const int x = g(1, 2, 3, 4, 5, 6, 7);\nstruct S { int y = g(1, 2, 3, 4, 5, 6, 7); };"), [])
        self.assertEqual(self.found("S::S() : a_(1, 2, 3, 4, 5, 6, 7) { x[i](1, 2, 3, 4, 5, 6, 7); }"), [])
        self.assertEqual(self.found("#define F(a, b, c, d, e, f, g) \\\n    h(a, b, c, d, e, f, g)\n// int f(int, int, int, int, int, int, int);"), [])

    def test_lines_are_those_of_the_names(self):
        self.assertEqual(excessive(f"int a;\n\n[[nodiscard]] int\nf({SEVEN.replace(' c', chr(10) + 'c')});"), [(4, "f", 7)])

    def test_the_program_has_no_long_parameter_lists(self):
        with contextlib.redirect_stdout(io.StringIO()) as text:
            code = main()
        self.assertEqual(code, 0, text.getvalue())


if __name__ == "__main__":
    unittest.main()
