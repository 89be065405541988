"""The C library, tested with a C compiler.

    python3 tests/c/test_c.py COMPILER LIBRARY PROGRAM [unittest arguments]
"""
import os
import subprocess
import sys
import tempfile
import unittest

COMPILER, LIBRARY, PROGRAM = sys.argv[1:4]
HERE = os.path.dirname(os.path.abspath(__file__))
SOURCE = os.path.join(HERE, "..", "..")


class InC(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def output_of(self, source, *words):
        program = os.path.join(self.folder, "program")
        subprocess.run([COMPILER, "-x", "c", "-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror",
                        "-I", os.path.join(SOURCE, "apps", "c", "include"), source, "-x", "none", LIBRARY, "-lm",
                        "-Wl,-rpath," + os.path.dirname(LIBRARY), "-o", program], check=True)
        done = subprocess.run([program, *words], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        return done.stdout

    def test_a_c_program_of_checks_reports_no_failure(self):
        self.assertEqual(self.output_of(os.path.join(HERE, "checks.c"), os.path.join(self.folder, "m.meshb")), "")

    def test_the_c_example_writes_a_valid_mesh(self):
        output = self.output_of(os.path.join(SOURCE, "examples", "c", "curve.c"))
        self.assertRegex(output, r"Camber \d.*: \d+ curved triangles, nodes up to 1\.000000 from the centre")
        checked = subprocess.run([PROGRAM, "check", os.path.join(self.folder, "disc.vtu")], capture_output=True, text=True)
        self.assertIn("yes: all", checked.stdout)

    def test_the_library_exports_only_names_with_its_prefix(self):
        names = subprocess.run(["nm", "-D", "--defined-only", LIBRARY], capture_output=True, text=True, check=True).stdout
        names = [line.split()[-1] for line in names.splitlines()]
        self.assertIn("camber_run", names)
        self.assertEqual([n for n in names if not n.startswith("camber_")], [])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
