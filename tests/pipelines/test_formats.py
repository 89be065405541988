"""VTU files against an independent reader and the GMF file of the same mesh; conversions in both directions.

    python3 tests/pipelines/test_formats.py build/bin/camber [unittest arguments]
"""
import json
import sys
import unittest
from xml.etree import ElementTree

import numpy as np

from program import CONFIGS, Folder

import gmf
import sample_meshes as samples
import vtu

SHAPES = {"shell": {"shell": {"inner_size": 0.8, "outer_size": 2.5}},
          "annulus": {"annulus": {"inner_layer": {"count": 3, "first_height": 0.05, "growth": 1.3}}},
          "box": {"box": {"low": [0, 0, 0], "high": [1, 2, 3], "cells": [2, 2, 2]}}}
CELL_TYPES = {"linear": (3, 5, 10), "quadratic": (21, 22, 24), "lagrange": (68, 69, 71)}


def cells_of(mesh):
    """(dimension, nodes, reference) of all cells in the order of a VTU file: elements, facets, feature edges."""
    for k in range(mesh.dim, 0, -1):
        for name, (dimension, _) in gmf.CELLS.items():
            if dimension == k and name in mesh.cells:
                cells = mesh.cells[name]
                yield from ((k, n, r) for n, r in zip(cells.nodes, cells.refs))


class Formats(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return self.folder.path / name

    def run_camber(self, *arguments):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def info(self, name):
        return json.loads(self.run_camber("info", "--json", name).stdout)

    def curved(self, shape, output, stages=("elevate", "curve", "validate", "relax", "commit"), **more):
        config = {"input": {"generate": SHAPES[shape]}, "stages": list(stages), "output": output, **more}
        self.path("run.json").write_text(json.dumps(config))
        return self.run_camber("run", "run.json")

    def same_mesh(self, grid, mesh, kind):
        """Checks that points, cells, types, references and dimensions of a VTU file equal those of the GMF file bit for
        bit."""
        cells = list(cells_of(mesh))
        self.assertEqual(len(grid.points), len(mesh.points))
        np.testing.assert_array_equal(grid.points[:, mesh.dim:], 0)
        self.assertEqual(len(grid.cells), len(cells))
        for row, t, (k, nodes, _) in zip(grid.cells, grid.types, cells):
            self.assertEqual(t, CELL_TYPES[kind][k - 1])
            # Node numbers may differ: coordinates in the same order, so that each mid node is on its edge.
            np.testing.assert_array_equal(grid.points[row][:, :mesh.dim], mesh.points[nodes])
            np.testing.assert_array_equal(grid.point_data["reference"][row], mesh.point_refs[nodes])
        np.testing.assert_array_equal(grid.cell_data["dimension"], [k for k, _, _ in cells])
        np.testing.assert_array_equal(grid.cell_data["reference"], [r for _, _, r in cells])

    def test_vtu_and_gmf_files_of_curved_meshes_are_equal(self):
        for shape in SHAPES:
            for kind in ("quadratic", "lagrange"):
                self.curved(shape, {"mesh": "m.meshb", "vtu": "m.vtu", "vtu_cells": kind})
                self.same_mesh(vtu.read(self.path("m.vtu")), gmf.read(self.path("m.meshb")), kind)
                self.run_camber("convert", "m.meshb", "-o", "c.vtu", "--cells", kind)
                self.same_mesh(vtu.read(self.path("c.vtu")), gmf.read(self.path("m.meshb")), kind)

    def test_vtu_stores_each_mid_node_once_and_near_its_edge(self):
        self.curved("shell", {"mesh": "m.vtu"})
        grid = vtu.read(self.path("m.vtu"))
        self.assertEqual(len(np.unique(grid.points, axis=0)), len(grid.points))
        ends = {}
        for row, t in zip(grid.cells, grid.types):
            k = vtu.CELLS[int(t)][0]
            for a, b, mid in gmf.LOCAL_EDGES[k]:
                edge = tuple(sorted((row[a], row[b])))
                self.assertEqual(ends.setdefault(edge, row[mid]), row[mid])
                chord = grid.points[row[b]] - grid.points[row[a]]
                along = (grid.points[row[mid]] - grid.points[row[a]]) @ chord / (chord @ chord)
                self.assertTrue(0.2 < along < 0.8, along)

    def test_straight_surface_and_empty_meshes_are_written_to_vtu(self):
        self.curved("shell", {"mesh": "s.mesh"}, stages=())
        self.run_camber("convert", "s.mesh", "-o", "s.vtu")
        self.same_mesh(vtu.read(self.path("s.vtu")), gmf.read(self.path("s.mesh")), "linear")
        self.run_camber("convert", "s.mesh", "-o", "e.vtu", "--elevate")
        self.run_camber("convert", "s.mesh", "-o", "e.meshb", "--elevate")
        self.same_mesh(vtu.read(self.path("e.vtu")), gmf.read(self.path("e.meshb")), "quadratic")
        shell = gmf.read(self.path("s.mesh"))
        del shell.cells["Tetrahedra"]
        for mesh, name in ((shell, "surface"), (samples.elevate(shell), "curved-surface")):
            self.path(name + ".mesh").write_bytes(samples.ascii_file(mesh))
            self.run_camber("convert", name + ".mesh", "-o", name + ".vtu")
            self.run_camber("convert", name + ".mesh", "-o", name + ".meshb")
            kind = "quadratic" if name.startswith("curved") else "linear"
            self.same_mesh(vtu.read(self.path(name + ".vtu")), gmf.read(self.path(name + ".meshb")), kind)
        # The metric of a mesh without elements is defined at its vertices.
        self.run_camber("curve", "surface.mesh", "-o", "run.mesh", "--vtu", "run.vtu")
        self.assertTrue(np.isfinite(vtu.read(self.path("run.vtu")).point_data["metric"]).all())
        self.path("empty.mesh").write_text("MeshVersionFormatted 2\nDimension 3\nVertices\n0\nEnd\n")
        self.run_camber("convert", "empty.mesh", "-o", "empty.vtu")
        empty = vtu.read(self.path("empty.vtu"))
        self.assertEqual((len(empty.points), len(empty.cells)), (0, 0))

    def test_vtu_fields_of_a_run_match_its_report(self):
        sphere = [{"references": [1], "sphere": {"centre": [0, 0, 0], "radius": 5}},
                  {"references": [2], "sphere": {"centre": [0, 0, 0], "radius": 1}}]
        self.curved("shell", {"mesh": "m.meshb", "vtu": "m.vtu", "report": "r.json"}, geometry={"analytic": sphere})
        grid, report = vtu.read(self.path("m.vtu")), json.loads(self.path("r.json").read_text())
        nodes, cells = grid.point_data, grid.cell_data
        vertices = report["mesh"]["vertices"]
        elements = cells["dimension"] == 3
        self.assertAlmostEqual(cells["scaled_jacobian"][elements].min(),
                               report["validity"]["min_scaled_jacobian"], places=6)
        self.assertTrue(np.isnan(cells["scaled_jacobian"][~elements]).all())
        self.assertEqual(set(cells["verdict"][elements]), {0})
        kinds = nodes["node_kind"]
        self.assertEqual((kinds[vertices:] == 1).sum(), report["boundary"]["surface_edges"])
        volume = np.flatnonzero(kinds == 0)
        volume = volume[volume >= vertices]
        after = report["curve"]["after_correction"]
        self.assertAlmostEqual(nodes["length_reduction"][volume].mean(), after["mean_length_reduction"], places=12)
        self.assertAlmostEqual(nodes["curvature"][volume].max(), after["largest_curvature"], places=12)
        self.assertEqual(set(nodes["edge_change"][:vertices]), {-1})
        # Distances, curvatures and metrics recomputed from the points.
        boundary = kinds > 0
        radius = np.linalg.norm(grid.points, axis=1)
        np.testing.assert_allclose(nodes["distance_to_geometry"][boundary],
                                   np.minimum(abs(radius - 5), abs(radius - 1))[boundary], atol=1e-12)
        self.assertTrue(np.isnan(nodes["distance_to_geometry"][~boundary]).all())
        self.assertEqual(grid.components["metric"], ["XX", "YY", "ZZ", "XY", "YZ", "XZ"])
        xx, yy, zz, xy, yz, xz = nodes["metric"].T
        tensors = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
        self.assertGreater(np.linalg.eigvalsh(tensors).min(), 0)
        for row in (grid.cells[i] for i in np.flatnonzero(elements)):
            for a, b, mid in gmf.LOCAL_EDGES[3]:
                offset = grid.points[row[mid]] - (grid.points[row[a]] + grid.points[row[b]]) / 2
                chord = np.linalg.norm(grid.points[row[b]] - grid.points[row[a]])
                self.assertAlmostEqual(nodes["curvature"][row[mid]], np.linalg.norm(offset) / chord, places=12)

    def test_convert_writes_a_metric_file_to_vtu(self):
        self.curved("shell", {"mesh": "s.meshb"}, stages=())
        mesh = gmf.read(self.path("s.meshb"))
        random = np.random.default_rng(1)
        tensors = random.uniform(-0.2, 0.2, (len(mesh.points), 6)) + np.array([1, 0, 2, 0, 0, 3])
        self.path("s.solb").write_bytes(samples.solution_file(tensors, 3, 3))
        self.run_camber("convert", "s.meshb", "-o", "s.vtu", "--metric", "s.solb")
        found = vtu.read(self.path("s.vtu")).point_data["metric"]
        np.testing.assert_array_equal(found, tensors[:, [0, 2, 5, 1, 4, 3]])
        self.run_camber("convert", "s.meshb", "-o", "e.vtu", "--metric", "s.solb", "--elevate")
        grid = vtu.read(self.path("e.vtu"))

        def logarithm(row):
            xx, yy, zz, xy, yz, xz = row
            values, vectors = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            return vectors @ np.diag(np.log(values)) @ vectors.T

        for row in grid.cells[:20]:
            a, b, mid = (row[i] for i in gmf.LOCAL_EDGES[3][0])
            a, b, mid = (logarithm(grid.point_data["metric"][n]) for n in (a, b, mid))
            np.testing.assert_allclose(mid, (a + b) / 2, atol=1e-12)

    def test_conversions_forth_and_back_give_the_same_bytes(self):
        for stages in ((), ("elevate", "curve", "validate", "relax", "commit")):
            for shape in SHAPES:
                self.curved(shape, {"mesh": "a.meshb"}, stages=stages)
                self.run_camber("convert", "a.meshb", "-o", "b.mesh")
                self.run_camber("convert", "b.mesh", "-o", "out/c.meshb")
                self.assertEqual(self.path("a.meshb").read_bytes(), self.path("out/c.meshb").read_bytes())
                self.run_camber("convert", "a.meshb", "-o", "d.vtu")
                self.run_camber("convert", "d.vtu", "-o", "e.vtu")
                self.assertEqual(self.path("d.vtu").read_bytes(), self.path("e.vtu").read_bytes())
        self.path("a.solb").write_bytes(samples.solution_file(np.random.default_rng(2).random((7, 6)), 3, 3))
        self.run_camber("convert", "a.solb", "-o", "b.sol")
        self.run_camber("convert", "b.sol", "-o", "c.solb")
        np.testing.assert_array_equal(gmf.read(self.path("a.solb")).fields[0][1],
                                      gmf.read(self.path("c.solb")).fields[0][1])

    def test_convert_notes_entities_that_the_format_cannot_store(self):
        self.curved("box", {"mesh": "b.mesh"}, stages=())
        mesh = gmf.read(self.path("b.mesh"))
        mesh.lists["Corners"] = (np.array([[1], [2]]), np.empty((2, 0)))
        self.path("c.mesh").write_bytes(samples.ascii_file(mesh))
        reported = self.run_camber("convert", "c.mesh", "-o", "c.vtu").stderr
        self.assertIn("note: VTU has no place for 2 corners", reported)
        self.assertEqual(self.run_camber("convert", "c.mesh", "-o", "d.meshb").stderr, "")

    def test_fields_with_unusual_names_are_read_back(self):
        names = ["", " ", "u", " u", "a/b", "reference", "entity", "METADATA", "x" * 40]
        values = "".join(f"{n} {n}.5\n" for n in (1, 2, 3))
        fields = "".join(f'$NodeData\n1\n"{name}"\n1\n0\n3\n0\n1\n3\n{values}$EndNodeData\n' for name in names)
        self.path("in.msh").write_text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
                                       "$EndNodes\n$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n" + fields)
        for ending in ("msh", "vtu", "vtk") + (("cgns",) if self.knows_cgns() else ()):
            for verb in ("convert", "curve"):
                done = self.run_camber(verb, "in.msh", "-o", f"out.{ending}")
                with self.subTest(ending=ending, verb=verb):
                    self.assertGreaterEqual(len(self.info(f"out.{ending}")["fields"]), len(names))
                    self.assertEqual("names of fields" in done.stderr, ending != "msh", done.stderr)

    def knows_cgns(self):
        return "the CGNS library cannot be loaded" not in self.folder.camber("convert", "in.msh", "-o", "probe.cgns").stderr

    def test_a_format_name_selects_the_output_format(self):
        self.curved("box", {"mesh": "b.meshb"}, stages=())
        for name, ending in (("gmf-ascii", "mesh"), ("gmf-binary", "meshb"), ("vtu", "vtu")):
            self.run_camber("convert", "b.meshb", "-o", "named." + ending)
            self.run_camber("convert", "b.meshb", "-o", "any-name", "--format", name)
            self.assertEqual(self.path("any-name").read_bytes(), self.path("named." + ending).read_bytes())
        # The input format is detected from the content.
        self.run_camber("convert", "b.meshb", "-o", "any-name", "--format", "gmf-binary")
        self.run_camber("convert", "any-name", "-o", "again.mesh")
        self.assertEqual(self.path("again.mesh").read_bytes(), self.path("named.mesh").read_bytes())

    def test_info_describes_a_solution_file(self):
        self.path("s.sol").write_text("MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n1\n2 3 1\n1 0 1 0.5\nEnd\n")
        reported = json.loads(self.run_camber("info", "s.sol", "--json").stdout)
        self.assertEqual(reported, {"dimension": 2, "vertices": 1, "fields": ["symmetric tensor", "scalar"], "notices": []})

    def test_output_metric_is_the_metric_after_its_operations(self):
        for shape, dimension in (("box", 3), ("annulus", 2)):
            done = self.curved(shape, {"mesh": "m.meshb", "metric": "m.sol"}, metric={"constant": {"sizes": [0.5]}},
                               metric_operations=[{"bound": {"min_size": 2}}])
            self.assertIn("wrote m.sol", done.stdout)
            words = self.path("m.sol").read_text().split()
            at = words.index("SolAtVertices")
            self.assertEqual(int(words[at + 1]), self.info("m.meshb")["vertices"])
            width = dimension * (dimension + 1) // 2
            rows = np.array(words[at + 4:-1], dtype=float).reshape(-1, width)
            diagonal = [0, 2, 5][:dimension]
            np.testing.assert_allclose(rows[:, diagonal], 0.25, rtol=1e-12)
            np.testing.assert_allclose(np.delete(rows, diagonal, axis=1), 0, atol=1e-15)
            self.curved(shape, {"mesh": "m.meshb", "metric": "m.vtu"}, metric={"constant": {"sizes": [0.5]}},
                        metric_operations=[{"bound": {"min_size": 2}}])
            values = vtu.read(self.path("m.vtu")).point_data["metric"]
            np.testing.assert_allclose(values[:, :dimension], 0.25, rtol=1e-12)

    def test_wrong_conversions_are_rejected_and_write_no_file(self):
        self.curved("annulus", {"mesh": "a.mesh"}, stages=())
        self.curved("annulus", {"mesh": "p2.mesh"})
        self.run_camber("convert", "a.mesh", "-o", "a.vtu")
        self.path("few.sol").write_text("MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n1\n1 1\n1\nEnd\n")
        for code, message, arguments in (
                (2, "no format known for this ending (use .mesh, .meshb", ("a.mesh", "-o", "a.ply")),
                (2, "--cells is for .vtu", ("a.mesh", "-o", "b.meshb", "--cells", "lagrange")),
                (2, "known: gmf-ascii, gmf-binary", ("a.mesh", "-o", "b.meshb", "--format", "ply")),
                (2, "use gmf-ascii or gmf-binary", ("few.sol", "-o", "b.sol", "--format", "vtu")),
                (2, "--metric is for", ("a.mesh", "-o", "b.vtu", "--format", "gmf-ascii", "--metric", "few.sol")),
                (2, "use .sol or .solb", ("few.sol", "-o", "few.vtu")),
                (2, "quadratic already", ("p2.mesh", "-o", "b.mesh", "--elevate")),
                (2, "straight already", ("a.mesh", "-o", "b.mesh", "--straighten")),
                (3, "few.sol: has 1 rows", ("a.mesh", "-o", "b.vtu", "--metric", "few.sol")),
                (3, "absent.mesh", ("absent.mesh", "-o", "b.vtu")),
                (2, "a.mesh: the mesh has no fields at its nodes", ("a.mesh", "-o", "b.sol"))):
            before = self.folder.files()
            done = self.folder.camber("convert", *arguments)
            self.assertEqual(done.returncode, code, (arguments, done.stderr))
            self.assertIn(message, done.stderr)
            self.assertEqual(self.folder.files(), before)
        done = self.folder.camber("curve", "a.mesh", "-o", "b.mesh", "--vtu", "b.vtk")
        self.assertEqual((done.returncode, "must end in .vtu" in done.stderr), (2, True), done.stderr)

    def test_histograms_match_the_report_and_plot_draws_them_again(self):
        self.curved("shell", {"mesh": "m.meshb", "report": "r.json", "plots": "plots"})
        report = json.loads(self.path("r.json").read_text())
        histograms = report["histograms"]
        self.assertEqual(set(histograms), {"length_reduction", "riemannian_length", "curvature", "scaled_jacobian"})
        for key, histogram in histograms.items():
            things = report["mesh"]["elements"] if key == "scaled_jacobian" else report["curve"]["volume_edges"]
            for series in histogram["mean"]:
                self.assertEqual(len(histogram[series]), len(histogram["edges"]) + 1)
                self.assertEqual(sum(histogram[series]) + histogram["not_a_number"][series], things)
                self.assertLessEqual(histogram["min"][series], histogram["mean"][series])
                self.assertLessEqual(histogram["mean"][series], histogram["max"][series])
        for when in ("before", "after"):
            self.assertEqual(histograms["curvature"]["max"][when],
                             report["curve"][when + "_correction"]["largest_curvature"])
            self.assertAlmostEqual(histograms["length_reduction"]["mean"][when],
                                   report["curve"][when + "_correction"]["mean_length_reduction"], places=12)
        self.assertEqual({f for f in self.folder.files() if f.startswith("plots")},
                         {f"plots/{key}.svg" for key in histograms})
        self.run_camber("plot", "r.json", "-o", "again")
        for key in histograms:
            text = self.path(f"again/{key}.svg").read_text()
            self.assertEqual(text, self.path(f"plots/{key}.svg").read_text())
            self.assertTrue(ElementTree.fromstring(text).tag.endswith("svg"))
        self.run_camber("plot", "r.json", "-o", "all.svg")
        self.assertIn("before correction", self.run_camber("run", "run.json", "--histogram").stdout)
        self.assertIn("Scaled Jacobian", self.run_camber("check", "m.meshb").stdout)
        self.assertEqual(self.folder.camber("plot", "run.json", "-o", "p").returncode, 3)

    def test_dry_run_writes_nothing(self):
        self.curved("box", {"mesh": "b.meshb"}, stages=())
        before = self.folder.files()
        done = self.run_camber("curve", "b.meshb", "-o", "new/c.vtu", "--report", "r.json", "--dry-run", "--set",
                               "stages/relax/theta=0.5")
        for words in ("tetrahedra", "relax theta=0.5", "peak memory", "new/c.vtu: its folder new does not exist"):
            self.assertIn(words, done.stdout)
        self.assertEqual(self.folder.files(), before)
        self.assertFalse(self.path("new").exists())
        done = self.run_camber("curve", "b.meshb", "-o", "c.mesh", "--min-scaled-jacobian", "0.3", "--dry-run")
        self.assertEqual(done.stdout.count("min_scaled_jacobian=0.3"), 1, done.stdout)
        self.assertEqual(self.folder.camber("curve", "absent.mesh", "-o", "c.mesh", "--dry-run").returncode, 3)
        self.assertEqual(self.folder.camber("curve", "b.meshb", "-o", "c.ply", "--dry-run").returncode, 2)

    def test_vtu_files_do_not_depend_on_the_number_of_threads(self):
        files = []
        for threads in (1, 3):
            self.run_camber("run", CONFIGS / "spheres.json", "--set", "output/vtu=v.vtu", "--threads", threads)
            files.append(self.path("v.vtu").read_bytes())
        self.assertEqual(files[0], files[1])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
