"""Output does not depend on the processor, although the C library selects functions by it.

    python3 tests/pipelines/test_processors.py build/bin/camber [unittest arguments]

A C library that does not know the tunable ignores it; these tests then compare a run with itself. The last test checks that the program
imports no function that the library selects by the processor.
"""
import os
import shutil
import subprocess
import sys
import unittest

from program import CAMBER, ROOT, Folder

sys.path.insert(0, str(ROOT / "tests" / "includes"))
from check_functions import NAMES  # noqa: E402

# Names of glibc since 2.33, and before.
WITHOUT = "glibc.cpu.hwcaps=" + ",".join(f"-{name}{suffix}" for name in ("FMA", "FMA4", "AVX2") for suffix in ("", "_Usable"))
FIELD = "tanh((sqrt(x^2 + y^2 + z^2) - 2)/0.2) + exp(-x)*cos(3*y) + log(9 + z) + atan2(y, 9 + x)^3"


class Processors(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def run_with(self, tunables, name, *arguments):
        environment = {**os.environ, "GLIBC_TUNABLES": tunables}
        done = self.folder.camber(*arguments, "-o", name, env=environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return (self.folder.path / name).read_bytes()

    def same(self, *arguments):
        here, there = self.run_with("", "here.meshb", *arguments), self.run_with(WITHOUT, "there.meshb", *arguments)
        self.assertTrue(here == there, f"{arguments[0]} writes other bytes on another processor")
        return self.folder.path / "here.meshb"

    def shell(self):
        return self.same("generate", "shell", "--elements", "2000").rename(self.folder.path / "shell.meshb")

    def test_curving_gives_the_same_bytes_without_fma_and_avx2(self):
        self.same("curve", self.shell())

    def test_remeshing_gives_the_same_bytes_without_fma_and_avx2(self):
        self.same("remesh", self.shell(), "--metric", "0.6")

    def test_remeshing_a_curved_mesh_gives_the_same_bytes_without_fma_and_avx2(self):
        self.same("remesh", self.same("curve", self.shell()).rename(self.folder.path / "curved.meshb"), "--metric", "0.9")

    def test_adaptation_gives_the_same_bytes_without_fma_and_avx2(self):
        self.same("adapt", self.shell(), "--field", FIELD, "--complexity", "300", "--cycles", "2")

    @unittest.skipUnless(shutil.which("nm"), "no nm here")
    def test_the_program_imports_no_processor_dependent_function(self):
        done = subprocess.run(["nm", "--dynamic", "--undefined-only", "--format=posix", CAMBER], capture_output=True, text=True, check=True)
        names = {line.split()[0].split("@")[0] for line in done.stdout.splitlines()}
        self.assertEqual(sorted(names & {name + suffix for name in NAMES for suffix in ("", "f", "l")}), [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
