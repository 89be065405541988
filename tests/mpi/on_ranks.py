"""Base class of the tests of `camber-mpi`: the programs, a folder for each test, and runs on several ranks."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

CAMBER, PROGRAM, MPIRUN = (str(Path(name).resolve()) for name in sys.argv[1:4])


class OnRanks(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_line(self, *line):
        return subprocess.run(list(map(str, line)), cwd=self.folder, capture_output=True, text=True, timeout=100)

    def camber(self, *arguments):
        """Runs the serial program and checks that it succeeds."""
        run = self.run_line(CAMBER, *arguments)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run

    def on_ranks(self, ranks, *arguments):
        return self.run_line(MPIRUN, "-n", ranks, PROGRAM, *arguments)

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()


def main():
    unittest.main(module="__main__", argv=sys.argv[:1])
