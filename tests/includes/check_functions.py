"""Checks that sources of the program take elementary functions from `core:tensors`. The C library selects its
implementation by the processor. Their last digits differ, and with them the bytes of meshes.

    python3 tests/includes/check_functions.py [FILE…]        all sources of modules/ and apps/ without FILE; exit code 1: some do not

Square roots, `fma`, rounding and the functions that decompose a number are exact and come from the library. Exception: modules/cad/occ,
since OpenCASCADE calls the library itself. muParser evaluates expressions of users with our functions (modules/fields/expression.cpp).
This check does not find calls without `std::` in a unit that does not import `camber.core`; tests/pipelines/test_processors.py finds them in
the program.
"""
import re
import sys
from pathlib import Path

from check_includes import NOISE, ROOT

EXCEPTIONS = ("modules/cad/occ/",)
NAMES = ("exp exp2 expm1 log log2 log10 log1p pow cbrt hypot sinh cosh tanh asinh acosh atanh sin cos tan asin acos atan atan2 sincos erf erfc "
         "tgamma lgamma").split()
CALL = re.compile(rf"(?:\bstd::|(?<![\w>])::|\b__builtin_)(?:{'|'.join(NAMES)})[fl]?\b")
OF_LIBRARY = re.compile(r"\bstd::(?:complex|polar|\w+_distribution)\b|#include <complex>|\bcomputeDirect\b")


def refused(path):
    """[(line, text)] of functions of the C or C++ library."""
    text = NOISE.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), path.read_text())
    return [(text.count("\n", 0, m.start()) + 1, m[0]) for pattern in (CALL, OF_LIBRARY) for m in pattern.finditer(text)]


def main(arguments):
    files = [Path(a).resolve() for a in arguments] or sorted(
        p for folder in ("modules", "apps") for p in (ROOT / folder).rglob("*") if p.suffix in (".cpp", ".cppm", ".hpp", ".h"))
    bad = 0
    for path in files:
        name = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else str(path)
        if name.startswith(EXCEPTIONS):
            continue
        for line, what in refused(path):
            bad += 1
            print(f"{name}:{line}: {what} has other last digits on other processors; use the function of camber.core (core:tensors)")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
