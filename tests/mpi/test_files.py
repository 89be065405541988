"""A mesh that several ranks read and write, each its rows, and what is left where one of them fails or is killed."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

CAMBER, PROGRAM, MPIRUN = (str(Path(name).resolve()) for name in sys.argv[1:4])


class Files(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.path = Path(cls.folder.name)
        subprocess.run([CAMBER, "generate", "shell", "-o", "in.meshb", "--quiet"], cwd=cls.path, check=True)

    def on_ranks(self, ranks, how):
        return subprocess.run([MPIRUN, "-n", str(ranks), PROGRAM, how, "in.meshb", "out.meshb"], cwd=self.path,
                              capture_output=True, text=True, timeout=100)

    def files(self):
        return sorted(file.name for file in self.path.iterdir())

    def tearDown(self):
        (self.path / "out.meshb").unlink(missing_ok=True)

    def test_what_all_write_is_the_file(self):
        for ranks in (1, 3):
            self.assertEqual(self.on_ranks(ranks, "copy").returncode, 0)
            self.assertEqual((self.path / "in.meshb").read_bytes(), (self.path / "out.meshb").read_bytes())
            self.assertEqual(self.files(), ["in.meshb", "out.meshb"])

    def test_one_that_fails_ends_all_with_one_message(self):
        run = self.on_ranks(3, "failing")
        self.assertEqual(run.returncode, 3)
        self.assertEqual(run.stderr.count("camber: in.meshb: is damaged"), 1, run.stderr)
        self.assertEqual(self.files(), ["in.meshb"])

    def test_one_that_is_killed_ends_all_and_nothing_is_left(self):
        run = self.on_ranks(3, "killed")
        self.assertNotEqual(run.returncode, 0)
        self.assertEqual(self.files(), ["in.meshb"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
