"""`camber remesh` and its passes as stages: preserved entities, and reports that agree with `check`.

    python3 tests/pipelines/test_remeshing.py build/bin/camber [unittest arguments]
"""
import itertools
import json
import math
import os
import re
import sys
import unittest

import numpy as np

from made_meshes import lattice
from program import CONFIGS, SANITIZED, Folder, report_of

import gmf  # of the oracle
from sample_meshes import solution_file

NAMES = {1: "Edges", 2: "Triangles", 3: "Tetrahedra"}
INTERFACE = 9


def measure(simplex):
    """Length, area or volume of a simplex."""
    sides = simplex[1:] - simplex[0]
    return math.sqrt(max(0.0, np.linalg.det(sides @ sides.T))) / math.factorial(len(sides))


def measures(points, rows, references):
    """{reference: sum of the measures of its simplices}."""
    sums = {}
    for row, reference in zip(rows, references):
        sums[reference] = sums.get(reference, 0.0) + measure(points[list(row)])
    return sums


def two_materials(dim, n):
    """[0, n]^dim with materials 1 and 2 on both sides of the interface x = n/2; each side of the box has a
    reference."""
    mesh = lattice(dim, n)
    middle = [mesh.points[list(e)].mean(axis=0)[0] for e in mesh.elements]
    mesh.element_references = [1 if x < n / 2 else 2 for x in middle]
    inner = {tuple(sorted(face)): face for element in mesh.elements for face in itertools.combinations(element, dim)
             if all(mesh.points[v][0] == n / 2 for v in face)}
    mesh.facet_references = []
    for facet in mesh.facets:
        at = mesh.points[list(facet)]
        axis = next(a for a in range(dim) if len(set(at[:, a])) == 1)
        mesh.facet_references.append(1 + 2 * axis + (at[0, axis] > 0))
    mesh.facets += list(inner.values())
    mesh.facet_references += [INTERFACE] * len(inner)
    return mesh


def cells(mesh, dim):
    block = mesh.cells.get(NAMES[dim]) or mesh.cells[NAMES[dim] + "P2"]
    return [tuple(map(int, row)) for row in block.nodes], [int(r) for r in block.refs]


class Remesh(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def camber(self, *arguments, code=0):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def write_two_materials(self, dim, n):
        mesh = two_materials(dim, n)
        (self.folder.path / "in.mesh").write_text(mesh.text())
        return mesh

    def read(self, name="out.mesh"):
        return gmf.read(self.folder.path / name)

    def run_stages(self, stages, size, code=0):
        config = {"input": {"mesh": "in.mesh"}, "metric": {"constant": {"sizes": [size]}}, "stages": stages,
                  "output": {"mesh": "out.mesh", "report": "r.json"}}
        (self.folder.path / "c.json").write_text(json.dumps(config))
        done = self.camber("run", "c.json", code=code)
        return report_of(self.folder.path / "r.json") if code == 0 else done

    def assert_preserved(self, before, after, dim):
        """Checks that measures of materials, interfaces and sides are unchanged and elements positive."""
        for k, rows, references in ((dim, before.elements, before.element_references),
                                    (dim - 1, before.facets, before.facet_references)):
            now_rows, now_references = cells(after, k)
            expected, found = measures(before.points, rows, references), measures(after.points, now_rows, now_references)
            self.assertEqual(expected.keys(), found.keys())
            for reference, value in expected.items():
                self.assertAlmostEqual(found[reference], value, delta=1e-9 * value)
        for element in cells(after, dim)[0]:
            corners = after.points[list(element)]
            self.assertGreater(np.linalg.det(corners[1:] - corners[0]), 0)

    def test_remesh_reaches_unit_edges_and_preserves_materials(self):
        for dim, n, size, unit in ((2, 2, 0.2, 0.9), (3, 2, 0.5 if not SANITIZED else 0.8, 0.8)):
            before = self.write_two_materials(dim, n)
            done = self.camber("remesh", "in.mesh", "--metric", f'{{"constant": {{"sizes": [{size}]}}}}', "-o",
                               "out.mesh", "--output-metric", "out.sol", "--report", "r.json", "--threads", "2")
            self.assertIn("edges of unit length", done.stdout)
            after = self.read()
            self.assert_preserved(before, after, dim)
            self.assertGreater(len(after.points), 2 * len(before.points))
            report = report_of(self.folder.path / "r.json")
            reported = report["remesh"]["after"]
            self.assertGreater(reported["unit_edges"], unit * reported["edges"])
            self.assertGreater(reported["min_quality"], 0.1)
            checked = json.loads(self.camber("check", "out.mesh", "--json", "--metric", "out.sol").stdout)
            self.assertTrue(checked["soundness"]["sound"])
            for key, value in checked["unit_mesh"].items():
                if key != "metric":
                    self.assertAlmostEqual(reported[key], value, delta=1e-9 * abs(value) + 1e-12, msg=key)
            # one series for the input and one for the output
            lengths = report["histograms"]["edge_length"]
            self.assertEqual(sum(lengths["input"]), report["remesh"]["before"]["edges"])
            self.assertEqual(lengths["remeshed"], checked["histograms"]["edge_length"]["count"])
            # accepted and rejected operations
            passes = {p["pass"]: p for p in report["remesh"]["passes"]}
            self.assertEqual(set(passes), {"collapse", "split", "swap", "smooth", "improve"})
            self.assertGreater(passes["split"]["accepted"], 0)
            for p in passes.values():
                self.assertEqual(p["proposals"], p["accepted"] + sum(p["rejected"].values()), p)
            # the bytes do not depend on the number of threads
            written = (self.folder.path / "out.mesh").read_bytes()
            self.camber("remesh", "in.mesh", "--metric", f'{{"constant": {{"sizes": [{size}]}}}}', "-o", "out.mesh",
                        "--threads", "1")
            self.assertEqual(written, (self.folder.path / "out.mesh").read_bytes())

    def test_remesh_by_blocks_reaches_unit_edges_and_preserves_materials(self):
        for dim, n, size, block in ((2, 2, 0.2, 100), (3, 2, 0.5 if not SANITIZED else 0.8, 200)):
            before = self.write_two_materials(dim, n)
            requested = ("remesh", "in.mesh", "--metric", str(size), "-o", "out.mesh", "--blocks", str(block))
            self.camber(*requested, "--threads", "2", "--report", "r.json")
            self.assert_preserved(before, self.read(), dim)
            reported = report_of(self.folder.path / "r.json")["remesh"]
            self.assertGreater(reported["after"]["unit_edges"], 0.8 * reported["after"]["edges"])
            self.assertGreater(reported["after"]["min_quality"], 0.1)
            self.assertEqual({p["pass"] for p in reported["passes"]}, {"collapse", "split", "swap", "smooth", "improve"})
            checked = json.loads(self.camber("check", "out.mesh", "--json").stdout)
            self.assertTrue(checked["soundness"]["sound"])
            written = (self.folder.path / "out.mesh").read_bytes()
            self.camber(*requested, "--threads", "1")
            self.assertEqual(written, (self.folder.path / "out.mesh").read_bytes())
            self.run_stages([{"remesh": {"blocks": block}}], size)  # the option of the stage gives the same
            self.assertEqual(written, (self.folder.path / "out.mesh").read_bytes())

    def test_a_curved_mesh_is_not_remeshed_by_blocks(self):
        self.write_two_materials(3, 2)
        self.camber("convert", "in.mesh", "--elevate", "-o", "curved.mesh")
        done = self.camber("remesh", "curved.mesh", "--metric", "0.5", "-o", "out.mesh", "--blocks", "100", code=3)
        self.assertRegex(done.stderr, "a curved mesh cannot be remeshed by blocks .*--straighten")
        self.assertNotIn("out.mesh", self.folder.files())

    def test_single_passes_are_stages_of_a_config(self):
        before = self.write_two_materials(3, 2)
        split = self.run_stages(["split"], 0.8)
        finer = self.read()
        self.assert_preserved(before, finer, 3)
        self.assertGreater(split["mesh"]["vertices"], len(before.points))
        self.assertEqual([p["pass"] for p in split["remesh"]["passes"]], ["split"])
        os.replace(self.folder.path / "out.mesh", self.folder.path / "in.mesh")
        collapse = self.run_stages(["collapse"], 3.0)
        self.assert_preserved(before, self.read(), 3)
        self.assertLess(collapse["mesh"]["vertices"], split["mesh"]["vertices"])
        again = self.run_stages(["swap", "smooth", "swap"], 0.8)
        self.assert_preserved(before, self.read(), 3)
        self.assertEqual([p["pass"] for p in again["remesh"]["passes"]], ["swap", "smooth"])  # repeated passes share a row
        self.assertGreaterEqual(again["remesh"]["after"]["min_quality"], again["remesh"]["before"]["min_quality"])

    def test_a_remeshed_mesh_is_curved_onto_the_same_geometry(self):
        self.camber("run", CONFIGS / "remesh.json", *(["--set", "stages/remesh/rounds=1"] if SANITIZED else []))
        report = report_of(self.folder.path / "out" / "remesh.report.json")
        self.assertEqual(report["validity"]["invalid"], 0)
        self.assertTrue(report["committed"])
        self.assertGreater(report["mesh"]["vertices"], 2 * report["input"]["vertices"])
        mesh = self.read("out/remesh.meshb")
        facets = mesh.cells["TrianglesP2"]
        for reference, radius in ((1, 2.0), (2, 1.0)):
            rows = facets.nodes[facets.refs == reference]
            vertices, nodes = (np.linalg.norm(mesh.points[np.unique(r)], axis=1) for r in (rows[:, :3], rows[:, 3:]))
            np.testing.assert_allclose(vertices, radius, rtol=1e-9)
            # except for nodes that `relax` moved for validity
            relaxed = np.count_nonzero(abs(nodes - radius) > 1e-9 * radius)
            self.assertLessEqual(relaxed, report["relax"]["relaxed_surface_edges"])

    def test_ridges_between_facets_of_one_reference_are_remeshed(self):
        """Ridges found by their angle are split and collapsed like those between references."""
        for dim, n in ((2, 3), (3, 2)):
            before = lattice(dim, n)  # all sides have reference 1
            (self.folder.path / "in.mesh").write_text(before.text())
            for size in (0.45, 1.4):
                report = self.run_stages(["remesh"], size)
                after = self.read()
                self.assert_preserved(before, after, dim)
                reported = report["remesh"]["after"]
                self.assertGreater(reported["unit_edges"], 0.75 * reported["edges"])
                self.assertLess(reported["longest"], 2.2)
                edges = {tuple(sorted(e)) for row in cells(after, dim - 1)[0] for e in itertools.combinations(row, 2)}
                sizes = [np.linalg.norm(after.points[a] - after.points[b]) for a, b in edges
                         if dim == 3 and sum(after.points[a] == after.points[b]) == 2]
                if size < 1 and dim == 3:
                    self.assertLess(max(sizes), 0.7)  # also along the edges of the box
                os.replace(self.folder.path / "out.mesh", self.folder.path / "in.mesh")

    def test_an_empty_mesh_and_a_curved_standalone_surface_are_rejected(self):
        nothing = lattice(3, 1)
        nothing.elements, nothing.element_references, nothing.facets, nothing.facet_references = [], [], [], []
        (self.folder.path / "in.mesh").write_text(nothing.text())
        self.run_stages(["remesh"], 0.5, code=3)
        self.assertNotIn("out.mesh", self.folder.files())
        self.surface("in.mesh", 2)
        self.camber("convert", "in.mesh", "--elevate", "-o", "curved.mesh")
        done = self.camber("remesh", "curved.mesh", "--metric", "0.5", "-o", "out.mesh", code=3)
        self.assertRegex(done.stderr, "a curved standalone surface mesh cannot be remeshed directly .*camber convert --straighten")
        self.camber("convert", "curved.mesh", "--straighten", "-o", "straight.mesh")
        self.camber("remesh", "straight.mesh", "--metric", "0.5", "-o", "out.mesh", "--geometry",
                    '{"mesh": "curved.mesh"}')

    def surface(self, name, n):
        """The surface of [0, n]^3 with a reference for each side."""
        mesh = two_materials(3, n)
        sides = [i for i, r in enumerate(mesh.facet_references) if r != INTERFACE]
        mesh.facets = [mesh.facets[i] for i in sides]
        mesh.facet_references = [mesh.facet_references[i] for i in sides]
        mesh.elements, mesh.element_references = [], []
        (self.folder.path / name).write_text(mesh.text())
        return mesh

    def test_a_standalone_surface_is_remeshed_and_its_area_preserved(self):
        before = self.surface("in.mesh", 2)
        area = measures(before.points, before.facets, before.facet_references)
        self.camber("convert", "in.mesh", "-o", "in.stl")  # without references: ridges are found by angle
        for name, size in (("in.mesh", 0.3), ("in.mesh", 5), ("in.stl", 0.3)):
            self.camber("remesh", name, "--metric", str(size), "-o", "out.mesh", "--report", "r.json")
            after = self.read()
            self.assertNotIn("Tetrahedra", after.cells)
            now = measures(after.points, *cells(after, 2))
            if name == "in.mesh":
                self.assertEqual(now.keys(), area.keys())
                for reference, value in area.items():
                    self.assertAlmostEqual(now[reference], value, delta=1e-9)
            self.assertAlmostEqual(sum(now.values()), 24, delta=1e-9)
            reported = report_of(self.folder.path / "r.json")["remesh"]["after"]
            if size < 1:
                self.assertGreater(reported["unit_edges"], 0.97 * reported["edges"])
                self.assertGreater(reported["min_quality"], 0.4)
            else:
                self.assertEqual(len(cells(after, 2)[0]), 12)  # nothing is left to collapse
            self.camber("check", "out.mesh")

    def test_a_standalone_surface_with_a_thin_band_has_the_requested_triangle_count(self):
        """A band a hundred times thinner than its surroundings. The number of triangles follows the complexity, which
        grows as the band gets thinner, since logarithms of sizes are linear in each input triangle."""
        mesh = self.surface("in.mesh", 4)
        for thin in (0.2, 0.02):
            sizes = [(1.2, 1.2, thin + abs(p[2] - 2)) for p in mesh.points]
            lower = np.array([[x ** -2, 0, y ** -2, 0, 0, z ** -2] for x, y, z in sizes])
            (self.folder.path / "m.solb").write_bytes(solution_file(lower, 3, 3))
            self.camber("remesh", "in.mesh", "--metric", "m.solb", "-o", "out.mesh", "--report", "r.json")
            report = report_of(self.folder.path / "r.json")
            requested = report["metric"]["complexity"] * 4 / math.sqrt(3)
            made = len(cells(self.read(), 2)[0])
            self.assertLess(max(requested / made, made / requested), 1.25)
            reported = report["remesh"]["after"]
            self.assertGreater(reported["unit_edges"], 0.97 * reported["edges"])

    def test_a_standalone_surface_meets_a_chord_error(self):
        self.camber("generate", "shell", "-o", "shell.mesh")
        mesh = self.read("shell.mesh")
        rows, references = cells(mesh, 2)
        sphere = [row for row, reference in zip(rows, references) if reference == 1]
        (self.folder.path / "in.mesh").write_text(
            "MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n%s\nTriangles\n%d\n%s\nEnd\n" % (
                len(mesh.points), "\n".join("%.17g %.17g %.17g 0" % tuple(p) for p in mesh.points),
                len(sphere), "\n".join("%d %d %d 1" % tuple(v + 1 for v in row) for row in sphere)))
        radius = np.linalg.norm(mesh.points[sphere[0][0]])
        self.camber("remesh", "in.mesh", "--metric", "1", "--geometry-error", "0.002", "-o", "out.mesh", "--geometry",
                    json.dumps({"analytic": [{"references": [1], "sphere": {"radius": radius}}]}))
        after = self.read()
        middles = after.points[np.array(cells(after, 2)[0])].mean(axis=1)
        self.assertLess(radius - np.linalg.norm(middles, axis=1).min(), 2.5 * 0.002)
        self.assertGreater(len(middles), len(sphere))

    def shell(self, dim, degree, *more):
        """Writes in.mesh, a shell between spheres of radii 1 and 5 (2D: circles of radii 1 and 2) with mid nodes on the
        chords."""
        shape, outer = {2: ("annulus", 2), 3: ("shell", 5)}[dim]
        sets = ["--set", "outer_radius=2"] if dim == 2 else []
        self.camber("generate", shape, *sets, *more, "-o", "straight.mesh")
        self.camber("convert", "straight.mesh", *(["--elevate"] if degree == 2 else []), "-o", "in.mesh")
        of_reference = {}
        rows, references = cells(self.read("straight.mesh"), dim - 1)
        points = self.read("straight.mesh").points
        for row, reference in zip(rows, references):
            of_reference[reference] = 1 if np.linalg.norm(points[row[0]]) < 1.5 else outer
        geometry = json.dumps({"analytic": [{"references": [r], "sphere": {"radius": radius}}
                                            for r, radius in sorted(of_reference.items())]})
        return geometry, of_reference

    def off_spheres(self, name, dim, of_reference):
        """The largest distances of boundary vertices and of boundary mid nodes from their spheres."""
        mesh = self.read(name)
        rows, references = cells(mesh, dim - 1)
        off = [[abs(np.linalg.norm(mesh.points[v]) - of_reference[r]) for v in row] for row, r in zip(rows, references)]
        return max(max(o[:dim]) for o in off), max([max(o[dim:]) for o in off if len(o) > dim], default=0)

    def distances(self, name, *geometry):
        """The larger distance of both directions, measured by the program."""
        measured = json.loads(self.camber("geometry", name, *geometry, "--json").stdout)
        return max(measured["distances"][way]["largest"] for way in ("to_geometry", "to_boundary"))

    def test_the_default_bound_keeps_a_coarse_boundary_near_its_geometry(self):
        """The default bound is 1 % of the diagonal of the bounding box. Sizes: the diameter of the body, and a hundred
        times as much."""
        for dim, degree in ((2, 1), (2, 2), (3, 1), (3, 2)):
            geometry, of_reference = self.shell(dim, degree, "--elements", 1000 if dim == 2 else 8000)
            outer = max(of_reference.values())
            bound = 0.01 * 2 * outer * math.sqrt(dim)
            for size in (2 * outer, 200 * outer):
                words = ("remesh", "in.mesh", "--metric", str(size), "--geometry", geometry, "--report", "r.json")
                done = self.camber(*words, "-o", "out.mesh")
                self.assertLess(self.distances("out.mesh", "--geometry", geometry), 1.1 * bound, (dim, degree, size))
                acting = report_of(self.folder.path / "r.json")["remesh"]["geometry_bound"]
                self.assertGreater(acting["limited_facets"], 3)
                self.assertIn("boundary facets are finer than the metric requests", done.stderr)
                done = self.camber(*words, "-o", "free.mesh", "--geometry-error", "none")
                self.assertGreater(self.distances("free.mesh", "--geometry", geometry),
                                   (2 if degree == 1 else 1.3) * self.distances("out.mesh", "--geometry", geometry))
                self.assertNotIn("geometry_bound", report_of(self.folder.path / "r.json")["remesh"])
                self.assertNotIn("finer than the metric", done.stderr)

    def test_a_coarse_interface_stays_near_its_geometry(self):
        self.camber("generate", str(CONFIGS / "coated-sphere.json"), "-o", "in.mesh")
        first = ("--geometry", json.dumps({"mesh": "in.mesh"}))
        for more, low, high in (((), 0, 0.12), (("--geometry-error", "none"), 0.25, 3)):
            self.camber("remesh", "in.mesh", "--metric", "100", *more, "-o", "out.mesh")
            far = self.distances("out.mesh", *first)
            self.assertLess(low, far)
            self.assertLess(far, high)

    def test_plane_boundaries_have_no_default_bound(self):
        for dim in (2, 3):
            self.write_two_materials(dim, 6)
            for more in ((), ("--geometry-error", "none")):
                self.camber("remesh", "in.mesh", "--metric", "100", *more, "-o", f"out{len(more)}.mesh")
            self.assertEqual((self.folder.path / "out0.mesh").read_bytes(),
                             (self.folder.path / "out2.mesh").read_bytes())

    def test_a_geometry_error_is_met_in_both_directions(self):
        for dim, degree, errors in ((2, 1, (0.02, 0.001)), (2, 2, (0.001, 1e-5)), (3, 1, (0.05,)), (3, 2, (0.02,))):
            geometry, of_reference = self.shell(dim, degree)
            for error in errors:
                done = self.camber("remesh", "in.mesh", "--metric", "1", "--geometry-error", str(error), "--geometry",
                                   geometry, "-o", "out.mesh", "--report", "r.json")
                reported = report_of(self.folder.path / "r.json")["boundary"]
                reached = reported["geometry_error"]
                self.assertEqual((reached["required"], reached["facets_beyond_bound"]), (error, 0))
                self.assertLessEqual(reached["reached"], error)
                self.assertRegex(done.stdout, "distance bound +.* required, .* reached")
                measured = json.loads(self.camber("geometry", "out.mesh", "--geometry", geometry, "--json").stdout)
                largest = max(measured["distances"][way]["largest"] for way in ("to_geometry", "to_boundary"))
                self.assertAlmostEqual(largest, reached["reached"], delta=1e-6 * error)
                vertices, nodes = self.off_spheres("out.mesh", dim, of_reference)
                self.assertLess(max(vertices, nodes), 1e-9)
                self.assertEqual(reported["vertex_deviation"]["beyond_tolerance"], 0)
                self.assertAlmostEqual(reported["vertex_deviation"]["largest"], vertices, delta=1e-12)

    def test_a_geometry_error_is_met_for_the_surrogate(self):
        self.shell(3, 1)
        self.camber("remesh", "in.mesh", "--metric", "1", "--geometry-error", "0.05", "-o", "out.mesh", "--report",
                    "r.json")
        reached = report_of(self.folder.path / "r.json")["boundary"]["geometry_error"]
        self.assertLessEqual(reached["reached"], 0.05)
        self.assertGreater(reached["reached"], 0.005)

    def test_a_geometry_error_that_is_not_met_is_reported_with_its_place(self):
        """Required boundary edges are not split."""
        for degree in (1, 2):
            geometry, _ = self.shell(2, degree)
            text = (self.folder.path / "in.mesh").read_text()
            count = len(cells(self.read("in.mesh"), 1)[0])
            required = "RequiredEdges\n%d\n%s\n" % (count, "\n".join(str(e + 1) for e in range(count)))
            (self.folder.path / "in.mesh").write_text(text.replace("\nEnd", "\n" + required + "End"))
            done = self.camber("remesh", "in.mesh", "--metric", "1", "--geometry-error", "1e-4", "--geometry", geometry,
                               "-o", "out.mesh", "--report", "r.json", code=1)
            reported = report_of(self.folder.path / "r.json")["boundary"]["geometry_error"]
            self.assertGreater(reported["reached"], 1e-3)
            self.assertGreater(reported["facets_beyond_bound"], 5)
            self.assertRegex(done.stderr, r"the boundary is .* from its geometry, and 0.0001 is required: \d+ facets are "
                                          r"farther, the farthest is facet %d at \(" % reported["facet"])
            mesh = self.read()
            row = cells(mesh, 1)[0][reported["facet"] - 1]
            ends = mesh.points[list(row[:2])]
            self.assertLess(np.linalg.norm(ends.mean(axis=0) - reported["point"]), np.linalg.norm(ends[1] - ends[0]))

    def test_mid_nodes_on_chords_are_moved_onto_the_geometry(self):
        for dim in (2, 3):
            geometry, of_reference = self.shell(dim, 2)
            self.assertGreater(self.off_spheres("in.mesh", dim, of_reference)[1], 1e-3)
            for rounds in (0, 2):
                done = self.camber("remesh", "in.mesh", "--geometry", geometry, "--rounds", str(rounds), "-o",
                                   "out.mesh", "--report", "r.json")
                self.assertRegex(done.stderr, "mid nodes of the boundary were off the geometry, by up to .* moved onto it")
                vertices, nodes = self.off_spheres("out.mesh", dim, of_reference)
                self.assertLess(max(vertices, nodes), 1e-9)
                reported = report_of(self.folder.path / "r.json")["boundary"]["node_deviation"]
                self.assertEqual(reported["beyond_tolerance"], 0)
                self.assertAlmostEqual(reported["largest"], nodes, delta=1e-12)
            # Nodes on the geometry are not moved.
            before = self.read().points
            done = self.camber("remesh", "out.mesh", "--geometry", geometry, "--rounds", "0", "-o", "again.mesh")
            self.assertNotIn("moved onto it", done.stderr)
            self.assertEqual(sorted(map(tuple, before)), sorted(map(tuple, self.read("again.mesh").points)))

    # Guards against metrics that request more elements than the memory holds.
    def test_metrics_that_need_too_much_memory_are_rejected_before_any_pass(self):
        """The error comes before any pass, with figures; `--dry-run` prints the same."""
        for dim in (2, 3):
            self.write_two_materials(dim, 1)
            (self.folder.path / "out.mesh").unlink(missing_ok=True)
            tiny = {"longest": 1e-4, "shortest": 0} if dim == 3 else {"longest": 1e-6, "shortest": 0}
            for stages, size in ((["remesh"], 1e-9), (["remesh"], 1e-4 if dim == 3 else 1e-6), ([{"split": tiny}], 1),
                                 (["collapse", {"remesh": {"split": tiny}}], 1), (["elevate", "split"], 1e-9),
                                 (["swap", "split", "elevate", "curve"], 1e-9)):
                done = self.run_stages(stages, size, code=4)
                self.assertRegex(done.stderr, "the metric requires about .* (triangles|tetrahedra), which need about .* GiB of "
                                              "memory, but .* allows .* GiB .make it coarser: .* larger split/longest")
                self.assertEqual(self.camber("run", "c.json", "--dry-run", code=4).stderr, done.stderr)
                self.assertNotIn("out.mesh", self.folder.files())
            # Passes that add no elements are accepted, and splits stop at half of `shortest`.
            self.run_stages(["collapse"], 1e-9)
            self.run_stages([{"split": {"longest": 1e-6}}], 1)
            self.run_stages(["remesh"], 0.4)
            text = self.camber("run", "c.json", "--dry-run").stdout
            self.assertRegex(text, "metric requires +about [0-9.e+]+ (triangles|tetrahedra)")
            requested = float(re.search(r"metric requires +about ([0-9.e+]+)", text)[1])
            made = report_of(self.folder.path / "r.json")["mesh"]["elements"]
            self.assertLess(max(requested / made, made / requested), 2.5)

    # Guards against tensors of anisotropy 1e16 that are raised without a note.
    def test_extreme_metrics_end_with_a_message(self):
        """Anisotropy of 1e16, jumps of 1e4 between neighbours, and spikes of 1e8."""
        random = np.random.default_rng(1)
        for dim in (2, 3):
            mesh = lattice(dim, 3)
            n = len(mesh.points)
            (self.folder.path / "in.mesh").write_text(mesh.text())
            sizes = {"anisotropy": np.ones((n, dim)), "jumps": np.ones((n, dim)), "spike": np.ones((n, dim))}
            sizes["anisotropy"][:, 0] = 1e-16
            sizes["jumps"][random.random(n) < 0.5] = 1e-4
            sizes["spike"][n // 2] = 1e-8
            for name, rows in sizes.items():
                frames = np.linalg.qr(random.normal(size=(n, dim, dim)))[0]
                tensors = np.einsum("vij,vj,vkj->vik", frames, rows ** -2.0, frames)
                lower = np.array([[m[i, j] for i in range(dim) for j in range(i + 1)] for m in tensors])
                (self.folder.path / "m.solb").write_bytes(solution_file(lower, 3, dim))
                flat = "tensors of m.solb are flat to the rounding of their numbers"
                for verb in (["check", "in.mesh"], ["curve", "in.mesh", "-o", "out.mesh"],
                             ["curve", "in.mesh", "-o", "out.mesh", "--set", "stages/curve/objective=energy"]):
                    done = self.camber(*verb, "--metric", "m.solb")
                    self.assertEqual(flat in done.stderr, name == "anisotropy", done.stderr)
                if name != "jumps" or dim == 3:  # 10^8 triangles may fit into memory
                    done = self.camber("remesh", "in.mesh", "--metric", "m.solb", "-o", "out.mesh", code=4)
                    self.assertIn("the metric requires about", done.stderr)

    def test_a_wrong_order_of_stages_is_rejected(self):
        self.write_two_materials(3, 1)
        done = self.run_stages(["elevate", "curve", "remesh"], 0.5, code=2)
        self.assertRegex(done.stderr, '/stages/2: stage "remesh" changes the mesh, but planned positions .*add "commit" before')
        done = self.run_stages(["remesh", "elevate", "elevate"], 0.5, code=2)
        self.assertRegex(done.stderr, "/stages/2: the mesh is quadratic already")
        self.assertNotIn("out.mesh", self.folder.files())

    def test_remeshed_curved_meshes_are_quadratic_and_valid(self):
        """A box with straight nodes, and one on its surrogate."""
        self.write_two_materials(3, 2)
        self.camber("convert", "in.mesh", "-o", "p2.mesh", "--elevate")
        self.camber("remesh", "p2.mesh", "-o", "out.mesh", "--set", "metric/constant/sizes=[0.7]")
        found = json.loads(self.camber("check", "out.mesh", "--json").stdout)
        self.assertEqual((found["degree"], found["invalid"], found["crossings"]["crossing"]), (2, 0, 0))
        self.run_stages(["elevate", "curve", "validate", "relax", "commit", "remesh", "validate"], 0.6)
        report = report_of(self.folder.path / "r.json")
        self.assertEqual(report["mesh"]["degree"], 2)
        self.assertEqual(report["validity"]["invalid"], 0)
        self.assertGreater(report["remesh"]["after"]["unit_edges"] / report["remesh"]["after"]["edges"], 0.9)

    @unittest.skipIf(SANITIZED, "tests/adapt goes through these passes")
    def test_smoothing_moves_nodes_and_reinsert_restores_their_targets(self):
        """Smoothing by distortion improves elements and moves nodes off their targets; `reinsert` restores these, and
        more passes may follow."""
        curve = ["elevate", "curve", "validate", "relax", "commit"]
        shell = "shell.meshb", "--set", "inner_size=0.7", "--set", "outer_size=1.5"
        self.assertEqual(self.folder.camber("generate", "shell", "-o", *shell).returncode, 0)

        def passes(stages, curve=curve):
            config = {"input": {"mesh": "shell.meshb"}, "metric": "natural", "stages": [*curve, *stages],
                      "output": {"mesh": "out.meshb", "report": "r.json"}}
            (self.folder.path / "c.json").write_text(json.dumps(config))
            self.camber("run", "c.json")
            report = report_of(self.folder.path / "r.json")
            self.assertEqual(report["validity"]["invalid"], 0)
            return report["remesh"], {p["pass"]: p for p in report["remesh"]["passes"]} | {"reinsert": report.get("reinsert")}
        smooth = {"target_quality": 1, "sweeps": 3}
        by_objective, reported = passes([{"smooth": smooth}])
        self.assertEqual(reported["smooth"]["moved_nodes"], 0)
        by_distortion, reported = passes([{"smooth": smooth | {"nodes": "distortion"}}])
        self.assertGreater(reported["smooth"]["moved_nodes"], 0)
        self.assertGreater(by_distortion["after"]["mean_quality"], by_objective["after"]["mean_quality"])
        self.assertGreaterEqual(by_distortion["after"]["min_quality"], by_objective["after"]["min_quality"])
        back, reported = passes([{"smooth": smooth | {"nodes": "distortion"}}, "reinsert", "swap"])
        self.assertGreater(reported["reinsert"]["patches"], 0)
        self.assertIn("swap", reported)
        self.assertLess(back["after"]["mean_quality"], by_distortion["after"]["mean_quality"])
        # options of reinsert apply after passes: edges are shorter by energy than by accuracy
        lengths = []
        for options in ({"curve": {"objective": "energy"}}, {}, {"curve": {"background_mesh": "straight"}}):
            passes(["swap", {"reinsert": options}])
            lengths.append(report_of(self.folder.path / "r.json")["curve"]["after_correction"]["mean_length_reduction"])
        self.assertGreater(lengths[0], lengths[1])
        self.assertNotEqual(lengths[2], lengths[1])
        config = {"input": {"mesh": "shell.meshb"}, "stages": ["elevate", {"reinsert": {"relax": {"theta": 0.3}}}], "output": {}}
        (self.folder.path / "c.json").write_text(json.dumps(config))
        self.assertIn("relax/theta is an option of repair", self.camber("run", "c.json", code=2).stderr)

    def test_a_coarse_remeshed_curved_mesh_is_quadratic_and_valid(self):
        self.write_two_materials(3, 1)
        self.camber("convert", "in.mesh", "-o", "p2.mesh", "--elevate")
        self.camber("remesh", "p2.mesh", "--metric", '{"constant": {"sizes": [0.5]}}', "-o", "out.mesh", "--report", "out.json")
        report = json.loads((self.folder.path / "out.json").read_text())
        self.assertEqual(report["mesh"]["degree"], 2)
        self.assertEqual([report["validity"][bad] for bad in ("invalid", "undecided")], [0, 0])

    def test_the_curved_boundary_of_the_input_is_the_geometry(self):
        """The curves of the input are not determined by the vertices; every new boundary vertex and node lies on
        them."""
        self.camber("generate", "annulus", "-o", "ring.mesh", "--elements", "60")
        self.camber("curve", "ring.mesh", "-o", "round.mesh")
        mesh = self.read("round.mesh")
        lines = (self.folder.path / "round.mesh").read_text().split("\n")
        first = lines.index("Vertices") + 2
        for a, b, m in cells(mesh, 1)[0]:  # bowed 1.5 times as much as a circle, so that it is smooth at no vertex
            lines[first + m] = " ".join(map(repr, map(float, 1.5 * mesh.points[m] - 0.25 * (mesh.points[a] + mesh.points[b])))) + " 0"
        (self.folder.path / "curved.mesh").write_text("\n".join(lines))
        self.camber("remesh", "curved.mesh", "-o", "out.mesh", "--metric", '{"constant": {"sizes": [0.3]}}')
        was, now = self.read("curved.mesh"), self.read("out.mesh")
        edges = {r: [was.points[list(row)] for row, of in zip(*cells(was, 1)) if of == r] for r in (1, 2)}
        self.assertGreater(len(now.points), 2 * len(was.points))

        def off(p, curves):
            """Distance of p from the intersection of its ray with a curve: a quadratic equation in t."""
            def across(q):
                return q[0] * p[1] - q[1] * p[0]
            gaps = []
            for a, b, m in curves:
                second, first = 2 * a + 2 * b - 4 * m, 4 * m - 3 * a - b
                for t in np.roots([across(second), across(first), across(a)]):
                    if abs(t.imag) < 1e-12 and -1e-9 < t.real < 1 + 1e-9:
                        q = a + t.real * first + t.real**2 * second
                        if q @ p > 0:
                            gaps.append(np.linalg.norm(q - p))
            return min(gaps)
        rows, references = cells(now, 1)
        farthest = max(off(now.points[v], edges[r]) for row, r in zip(rows, references) for v in row)
        self.assertLess(farthest, 1e-9)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
