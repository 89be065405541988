"""A mesh made by several ranks, each some of its rows: the bytes are those that one process writes."""
from on_ranks import OnRanks, main

SHAPES = (
    ("shell", "--structure", "prisms", "--elements", 1e5, "--set", "inner_layer/count=3", "--set", "inner_layer/material=2"),
    ("box", "--elements", 3e4, "--set", "warp=0.03", "--set", "grading=[1,4,9]"),
    ("annulus", "--structure", "prisms", "--set", "outer_layer/count=1"),
    ("rectangle", "--elements", 2000),
)


class Generate(OnRanks):
    def test_any_number_of_ranks_writes_the_same_bytes(self):
        for shape in SHAPES:
            self.camber("generate", *shape, "-o", "one.meshb")
            for ranks in (2, 3):
                run = self.on_ranks(ranks, "generate", *shape, "-o", "ranks.meshb")
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertEqual(self.bytes_of("one.meshb"), self.bytes_of("ranks.meshb"), (shape, ranks))

    def test_more_ranks_than_rows(self):
        self.camber("generate", "box", "--set", "cells=[3,3,2]", "-o", "one.meshb")
        run = self.on_ranks(4, "generate", "box", "--set", "cells=[3,3,2]", "-o", "ranks.meshb")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(self.bytes_of("one.meshb"), self.bytes_of("ranks.meshb"))

    def test_what_is_made_as_a_whole_is_refused(self):
        for shape, output in ((("shell",), "no.meshb"), (("bump",), "no.meshb"), (("box",), "no.vtu")):
            run = self.on_ranks(2, "generate", *shape, "-o", output)
            self.assertEqual(run.returncode, 3, run.stderr)
            self.assertEqual(run.stderr.count("camber: "), 1, run.stderr)
            self.assertFalse((self.folder / output).exists())
        run = self.on_ranks(2, "generate", "box", "-o", "nowhere/no.meshb")
        self.assertEqual(run.returncode, 3, run.stderr)


if __name__ == "__main__":
    main()
