"""Ranks read and write their rows of a mesh. No files remain if a rank fails or is killed."""
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

    def test_ranks_write_one_complete_file(self):
        for ranks in (1, 3):
            self.assertEqual(self.on_ranks(ranks, "copy").returncode, 0)
            self.assertEqual((self.path / "in.meshb").read_bytes(), (self.path / "out.meshb").read_bytes())
            self.assertEqual(self.files(), ["in.meshb", "out.meshb"])

    def test_failing_rank_ends_all_ranks_with_one_message(self):
        run = self.on_ranks(3, "failing")
        self.assertEqual(run.returncode, 3)
        self.assertEqual(run.stderr.count("camber: in.meshb: is damaged"), 1, run.stderr)
        self.assertEqual(self.files(), ["in.meshb"])

    def test_killed_rank_ends_all_ranks_without_partial_files(self):
        run = self.on_ranks(3, "killed")
        self.assertNotEqual(run.returncode, 0)
        self.assertEqual(self.files(), ["in.meshb"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
