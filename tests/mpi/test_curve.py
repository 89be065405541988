"""Curving by blocks in the program: the same bytes on any number of ranks, and the mesh of curving without blocks."""
import json
import sys
from pathlib import Path

import numpy

from on_ranks import CAMBER, OnRanks, main
sys.path.append(str(Path(__file__).resolve().parent.parent / "oracle"))
import gmf  # noqa: E402

SHELL = ("shell", "--set", "outer_radius=2", "--set", "inner_size=0.25", "--set", "outer_size=0.5", "--set", "inner_layer/count=2")


class Curve(OnRanks):
    def setUp(self):
        super().setUp()
        self.camber("generate", *SHELL, "-o", "shell.meshb")

    def nodes(self, name):
        return numpy.array(gmf.read(self.folder / name).points)

    def test_curved_mesh_does_not_depend_on_number_of_ranks(self):
        self.camber("curve", "shell.meshb", "-o", "blocks.meshb", "--blocks", 1500, "--report", "blocks.json")
        for ranks in (2, 3):
            run = self.on_ranks(ranks, "curve", "shell.meshb", "-o", "ranks.meshb", "--blocks", 1500, "--report", "ranks.json")
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(self.bytes_of("blocks.meshb"), self.bytes_of("ranks.meshb"))
            report = json.loads((self.folder / "ranks.json").read_text())
            self.assertEqual(report["ranks"]["number"], ranks)
            self.assertGreater(report["blocks"]["number"], 2)
            self.assertGreater(max(report["ranks"]["sent_bytes"]), 0)
            self.assertEqual(report["validity"], json.loads((self.folder / "blocks.json").read_text())["validity"])

    def test_memory_limit_does_not_change_the_output(self):
        self.camber("generate", "shell", "--structure", "prisms", "--elements", 1e5, "--set", "inner_layer/count=3", "-o", "large.meshb")
        self.camber("curve", "large.meshb", "-o", "in-memory.meshb", "--blocks", 20000)
        self.camber("curve", "large.meshb", "-o", "within.meshb", "--blocks", 20000, "--memory", "80M")
        self.assertEqual(self.bytes_of("in-memory.meshb"), self.bytes_of("within.meshb"))
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["in-memory.meshb", "large.meshb", "shell.meshb", "within.meshb"])

    def test_curving_by_blocks_agrees_with_curving_of_the_whole_mesh(self):
        self.camber("curve", "shell.meshb", "-o", "blocks.meshb", "--blocks", 1500)
        self.camber("curve", "shell.meshb", "-o", "whole.meshb")
        blocks, whole = self.nodes("blocks.meshb"), self.nodes("whole.meshb")
        self.assertEqual(blocks.shape, whole.shape)
        self.assertLess(numpy.abs(blocks - whole).max(), 1e-12)

    def test_options_without_block_support_are_rejected(self):
        for arguments in (("--objective", "shape"), ("--gradation", "1.5"), ("--set", "stages/curve/boundary_nodes=length")):
            run = self.run_line(CAMBER, "curve", "shell.meshb", "-o", "no.meshb", "--blocks", 1500, *arguments)
            self.assertEqual(run.returncode, 3, (arguments, run.stderr))
            self.assertIn("by blocks", run.stderr)
        self.assertFalse((self.folder / "no.meshb").exists())


if __name__ == "__main__":
    main()
