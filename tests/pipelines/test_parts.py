"""Partitioned meshes for solvers: `camber convert --partition`."""
import os
import sys
import unittest

from program import Folder


class Partition(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.camber("generate", "shell", "-o", "shell.meshb")
        self.camber("curve", "shell.meshb", "-o", "curved.meshb")
        probe = self.folder.camber("convert", "shell.meshb", "-o", "probe.stl", "--partition", 2)
        if "without which Camber was built" in probe.stderr and os.environ.get("CAMBER_NO_SKIP") != "1":
            self.skipTest("Camber was built without Scotch")
        for file in self.folder.path.glob("probe*"):
            file.unlink()

    def camber(self, *arguments):
        run = self.folder.camber(*arguments)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run

    def bytes_of(self, name):
        return (self.folder.path / name).read_bytes()

    def counts(self, name):
        return [line.split() for line in self.camber("info", name).stdout.splitlines()
                if line.split()[:1] in (["vertices"], ["tetrahedra"], ["triangles"])]

    def test_pieces_of_a_pvtu_file_are_joined_to_the_mesh(self):
        run = self.camber("convert", "curved.meshb", "-o", "parts.pvtu", "--partition", 3)
        for name in ("parts.1.vtu", "parts.2.vtu", "parts.3.vtu", "parts.pvtu"):
            self.assertIn(f"wrote {name}", run.stdout)
        self.assertEqual(self.counts("parts.pvtu"), self.counts("curved.meshb"))
        back = self.camber("convert", "parts.pvtu", "-o", "back.vtu")
        self.assertIn("3 pieces were joined into one mesh", back.stderr)
        self.assertNotIn("same places", back.stderr)
        self.camber("check", "parts.pvtu")

    def test_flat_meshes_and_surfaces_are_partitioned(self):
        self.camber("generate", "rectangle", "-o", "flat.msh")
        self.camber("convert", "shell.meshb", "-o", "surface.stl")
        for name, triangles in (("flat.msh", self.counts("flat.msh")[1]), ("surface.stl", self.counts("surface.stl")[1])):
            for output, pieces in (("parts.pvtu", "vtu"), ("parts.msh", "msh")):
                self.camber("convert", name, "-o", output, "--partition", 3)
                self.assertIn(triangles, self.counts(output))
                inside = [int(self.counts(f"parts.{p}.{pieces}")[1][1]) for p in (1, 2, 3)]
                self.assertEqual(sum(inside), int(triangles[1].replace(" ", "")))
        self.camber("curve", "flat.msh", "-o", "curved.pvtu", "--partition", 2)

    def test_msh_output_has_parts_and_the_whole_mesh(self):
        self.camber("convert", "curved.meshb", "-o", "parts.msh", "--partition", 2)
        self.assertEqual(self.folder.files(),
                         ["curved.meshb", "parts.1.msh", "parts.2.msh", "parts.msh", "shell.meshb"])
        self.assertIn("partition", self.camber("info", "parts.msh").stdout)
        self.assertIn("GlobalNodeId", self.camber("info", "parts.2.msh").stdout)
        self.assertEqual(self.counts("parts.msh"), self.counts("curved.meshb"))

    def test_curve_writes_parts_with_and_without_blocks(self):
        for more in ((), ("--blocks", 300)):
            self.camber("curve", "shell.meshb", "-o", "parts.pvtu", "--partition", 3, *more)
            self.assertEqual(self.counts("parts.pvtu"), self.counts("curved.meshb"))
        for arguments, message in ((("-o", "parts.pvtu"), "give the number: --partition N"),
                                (("-o", "-", "--format", "vtu", "--partition", 2), "parts are several")):
            run = self.folder.camber("curve", "shell.meshb", *arguments)
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertIn(message, run.stderr)

    def test_parts_do_not_depend_on_the_number_of_threads(self):
        for name in ("a", "b"):
            self.camber("convert", "shell.meshb", "-o", f"{name}.meshb", "--partition", 4, "--threads", 1 + (name == "b"))
        for part in range(1, 5):
            self.assertEqual(self.bytes_of(f"a.{part}.meshb"), self.bytes_of(f"b.{part}.meshb"))
        self.assertEqual(self.bytes_of("a.meshb"), self.bytes_of("shell.meshb"))

    def test_wrong_partition_arguments_are_rejected(self):
        for arguments, message in ((("-o", "parts.pvtu"), "give the number: --partition N"),
                                (("-o", "-", "--format", "vtu", "--partition", 2), "parts are several"),
                                (("-o", "parts.vtu", "--partition", 100000), "has no 100000 parts")):
            run = self.folder.camber("convert", "shell.meshb", *arguments)
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertIn(message, run.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
