"""Partition of a distributed mesh for a solver: balanced parts that contain each cell once and join to the whole mesh."""
import sys
from pathlib import Path

import numpy

from on_ranks import OnRanks, main
sys.path.append(str(Path(__file__).resolve().parent.parent / "oracle"))
import gmf  # noqa: E402

PARTS = 5


class Partition(OnRanks):
    def cells(self, name):
        """Returns a sorted list of (positions of nodes, reference) for each kind of cell."""
        mesh = gmf.read(self.folder / name)
        places = [tuple(point) for point in numpy.array(mesh.points).tolist()]
        return {kind: sorted((tuple(sorted(places[v] for v in cell)), int(reference))
                             for cell, reference in zip(cells.nodes.tolist(), cells.refs.tolist()))
                for kind, cells in mesh.cells.items()}

    def in_parts(self, ranks, parts, *arguments):
        """Runs a command that writes parts.pvtu, joins the parts and returns their cells."""
        run = self.on_ranks(ranks, *arguments, "-o", "parts.pvtu", "--partition", parts)
        if "PT-Scotch" in run.stderr:
            self.skipTest("Camber was built without PT-Scotch")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.camber("convert", "parts.pvtu", "-o", "joined.meshb")
        return self.cells("joined.meshb")

    def test_parts_are_balanced_and_form_the_whole_mesh(self):
        for kind, shape in (("Tetrahedra", ("box", "--set", "cells=[8,8,8]")), ("Triangles", ("rectangle", "--set", "cells=[20,20]"))):
            self.camber("generate", *shape, "-o", "whole.meshb")
            joined = self.in_parts(3, PARTS, "convert", "whole.meshb")
            sizes = []
            for part in range(1, PARTS + 1):
                self.camber("convert", f"parts.{part}.vtu", "-o", "part.meshb")
                sizes.append(len(self.cells("part.meshb")[kind]))
            mean = sum(sizes) / PARTS
            self.assertLess(max(sizes) / mean, 1.06, sizes)
            self.assertGreater(min(sizes) / mean, 0.94, sizes)
            self.assertEqual(joined, self.cells("whole.meshb"))

    def test_parts_of_a_quadratic_mesh_form_the_whole_mesh(self):
        for shape in (("shell", "--set", "inner_size=0.5"), ("annulus", "--elements", 300)):
            self.camber("generate", *shape, "-o", "straight.meshb")
            self.camber("curve", "straight.meshb", "-o", "whole.meshb")
            self.assertEqual(self.in_parts(3, PARTS, "convert", "whole.meshb"), self.cells("whole.meshb"))

    def test_curve_and_remesh_write_their_output_in_parts(self):
        """The parts form the mesh of the single output file, and no other files are written."""
        self.camber("generate", "annulus", "--elements", 300, "-o", "in.meshb")
        for verb in (("curve", "in.meshb", "--blocks", 60), ("remesh", "in.meshb", "--metric", 0.1, "--blocks", 200)):
            self.camber(*verb, "-o", "whole.meshb")
            before = {p.name for p in self.folder.iterdir()}
            joined = self.in_parts(3, 2, *verb)
            self.assertEqual({p.name for p in self.folder.iterdir()} - before,
                             {"parts.pvtu", "parts.1.vtu", "parts.2.vtu", "joined.meshb"})
            self.assertEqual(joined, self.cells("whole.meshb"))
            for path in self.folder.glob("parts.*"):
                path.unlink()
            (self.folder / "joined.meshb").unlink()

    def test_more_ranks_than_parts_write_all_parts(self):
        self.camber("generate", "box", "-o", "whole.meshb")
        self.assertEqual(self.in_parts(4, 2, "convert", "whole.meshb"), self.cells("whole.meshb"))

    def test_unsupported_partition_arguments_are_rejected(self):
        self.camber("generate", "box", "-o", "whole.meshb")
        for arguments in (("-o", "no.vtu"), ("-o", "no.vtu", "--partition", 2), ("-o", "no.pvtu", "--partition", 2, "--elevate")):
            run = self.on_ranks(2, "convert", "whole.meshb", *arguments)
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertEqual(run.stderr.count("camber: "), 1, run.stderr)
        run = self.on_ranks(2, "curve", "whole.meshb", "-o", "no.vtu", "--partition", 2)
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertIn(".pvtu in parts (--partition)", run.stderr)


if __name__ == "__main__":
    main()
