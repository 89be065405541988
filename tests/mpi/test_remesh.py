"""Remeshing on several ranks in the program: the same bytes as on one, each rank with its blocks alone."""
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

CAMBER, CAMBER_MPI, MPIRUN = (str(Path(name).resolve()) for name in sys.argv[1:4])


class Remesh(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_line(self, *line, code=0):
        run = subprocess.run(list(map(str, line)), cwd=self.folder, capture_output=True, text=True, timeout=100)
        self.assertEqual(run.returncode, code, run.stderr)
        return run

    def on_ranks(self, ranks, *arguments, code=0):
        return self.run_line(MPIRUN, "-n", ranks, CAMBER_MPI, *arguments, code=code)

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    def report(self, name):
        report = json.loads((self.folder / name).read_text())["remesh"]
        for passed in report["passes"]:
            passed["seconds"] = 0
        for means in report["before"], report["after"]:
            means["mean_length"], means["mean_quality"] = round(means["mean_length"], 9), round(means["mean_quality"], 9)
        return report

    def test_any_number_of_ranks_writes_the_same_bytes(self):
        for shape, size, block in ((("box", "--elements", 600), 0.17, 800), (("rectangle", "--elements", 300), 0.03, 700)):
            self.run_line(CAMBER, "generate", *shape, "-o", "in.meshb")
            asked = "remesh", "in.meshb", "--metric", size, "--blocks", block
            self.run_line(CAMBER, *asked, "-o", "one.meshb", "--report", "one.json")
            for ranks in (2, 3):
                with self.subTest(shape=shape[0], ranks=ranks):
                    run = self.on_ranks(ranks, *asked, "-o", "ranks.meshb", "--report", "ranks.json")
                    self.assertEqual(run.stdout.count("edges of unit length"), 1)
                    self.assertEqual(self.bytes_of("one.meshb"), self.bytes_of("ranks.meshb"))
                    self.assertEqual(self.report("one.json"), self.report("ranks.json"))
        self.assertEqual([p.name for p in self.folder.iterdir() if "part" in p.name], [])

    def test_what_is_not_rows_alone_is_written_as_a_whole(self):
        self.run_line(CAMBER, "generate", "rectangle", "--elements", 300, "-o", "in.meshb")
        asked = "remesh", "in.meshb", "--metric", 0.05, "--blocks", 300
        self.run_line(CAMBER, *asked, "-o", "one.mesh", "--output-metric", "one.solb")
        self.on_ranks(2, *asked, "-o", "ranks.mesh", "--output-metric", "ranks.solb")
        self.assertEqual(self.bytes_of("one.mesh"), self.bytes_of("ranks.mesh"))
        self.assertEqual(self.bytes_of("one.solb"), self.bytes_of("ranks.solb"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
