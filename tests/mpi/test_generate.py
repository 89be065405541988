"""Ranks generate the rows of a mesh and write the same bytes as one process."""
from on_ranks import OnRanks, main

SHAPES = (
    ("shell", "--structure", "prisms", "--elements", 1e5, "--set", "inner_layer/count=3", "--set", "inner_layer/material=2"),
    ("box", "--elements", 3e4, "--set", "warp=0.03", "--set", "grading=[1,4,9]"),
    ("annulus", "--structure", "prisms", "--set", "outer_layer/count=1"),
    ("rectangle", "--elements", 2000),
)


class Generate(OnRanks):
    def test_generated_mesh_does_not_depend_on_number_of_ranks(self):
        for shape in SHAPES:
            self.camber("generate", *shape, "-o", "one.meshb")
            for ranks in (2, 3):
                run = self.on_ranks(ranks, "generate", *shape, "-o", "ranks.meshb")
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertEqual(self.bytes_of("one.meshb"), self.bytes_of("ranks.meshb"), (shape, ranks))

    def test_more_ranks_than_rows_write_the_same_mesh(self):
        self.camber("generate", "box", "--set", "cells=[3,3,2]", "-o", "one.meshb")
        run = self.on_ranks(4, "generate", "box", "--set", "cells=[3,3,2]", "-o", "ranks.meshb")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(self.bytes_of("one.meshb"), self.bytes_of("ranks.meshb"))

    def test_shapes_and_formats_without_row_support_are_rejected(self):
        for shape, output in ((("shell",), "no.meshb"), (("bump",), "no.meshb"), (("box",), "no.vtu")):
            run = self.on_ranks(2, "generate", *shape, "-o", output)
            self.assertEqual(run.returncode, 3, run.stderr)
            self.assertEqual(run.stderr.count("camber: "), 1, run.stderr)
            self.assertFalse((self.folder / output).exists())

    def test_missing_output_folder_is_an_error(self):
        run = self.on_ranks(2, "generate", "box", "-o", "nowhere/no.meshb")
        self.assertEqual(run.returncode, 3, run.stderr)


if __name__ == "__main__":
    main()
