"""`camber geometry`: boundary entities, suspicious places, distances in both directions, and errors.

    python3 tests/pipelines/test_geometry_command.py build/bin/camber [unittest arguments]
"""
import json
import math
import sys
import unittest

import numpy as np

from made_meshes import Mesh, elevated, lattice
from program import ROOT, Folder, report_of
from test_report import documented, holds, leaves, pattern

import vtu  # of the oracle

CAD_MODEL = ROOT / "tests" / "cad" / "shell.brep"
SPHERES = json.dumps({"analytic": [{"references": [1], "sphere": {"radius": 5}},
                                   {"references": [2], "sphere": {"radius": 1}}]})


def surface(points, facets, references=()):
    mesh = Mesh(points, [], facets)
    mesh.facet_references = list(references) or [1] * len(facets)
    return mesh


def cone(n, height):
    angles = 2 * math.pi * np.arange(n) / n
    points = [(0, 0, height)] + [(math.cos(a), math.sin(a), 0) for a in angles]
    return surface(points, [(0, 1 + i, 1 + (i + 1) % n) for i in range(n)])


def distance_to_curved(points, mesh, n):
    """Minimum distance of each point to a lattice with n subdivisions on the quadratic facets."""
    lattice_points = []
    for facet in mesh.facets:
        a, b, c, ab, bc, ca = mesh.points[list(facet)]
        for i in range(n + 1):
            for j in range(n + 1 - i):
                u, v = i / n, j / n
                w = 1 - u - v
                lattice_points.append(u * (2 * u - 1) * a + v * (2 * v - 1) * b + w * (2 * w - 1) * c +
                                      4 * u * v * ab + 4 * v * w * bc + 4 * w * u * ca)
    all_points = np.array(lattice_points)
    return np.array([np.sqrt(((all_points - p) ** 2).sum(1).min()) for p in points])


class GeometryCommand(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def write(self, mesh, name="m.mesh"):
        (self.folder.path / name).write_text(mesh if isinstance(mesh, str) else mesh.text())
        return name

    def camber(self, *arguments, code=0):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        return done

    def report(self, mesh, *arguments):
        name = mesh if isinstance(mesh, str) else self.write(mesh)
        return json.loads(self.camber("geometry", name, "--json", *arguments).stdout)

    def reads_cad(self):
        done = self.folder.camber("geometry", self.write(lattice(3, 1), "cube.mesh"), "--cad", CAD_MODEL)
        return "reads no CAD files" not in done.stderr

    def test_a_cube_has_6_patches_12_ridges_and_8_corners(self):
        found = self.report(lattice(3, 2))
        self.assertEqual((len(found["patches"]), len(found["ridges"]), len(found["corners"])), (6, 12, 8))
        self.assertEqual(sum(p["facets"] for p in found["patches"]), 48)
        for patch in found["patches"]:
            self.assertTrue(patch["flat"])
            self.assertAlmostEqual(patch["area"], 4)
        for ridge in found["ridges"]:
            self.assertAlmostEqual(ridge["length"], 2)
            self.assertAlmostEqual(ridge["min_turn"], 90)
            self.assertAlmostEqual(ridge["largest_turn"], 90)
        self.assertEqual(found["interface_facets"], 0)
        self.assertEqual([found[k]["count"] for k in ("open_edges", "non_manifold_edges")], [0, 0])
        self.assertEqual([s["count"] for s in found["suspicious"].values()], [0] * len(found["suspicious"]))
        self.assertEqual(found["distances"]["to_geometry"]["largest"], 0)
        corners = {tuple(c["point"]) for c in found["corners"]}
        self.assertEqual(corners, {(x, y, z) for x in (0, 2) for y in (0, 2) for z in (0, 2)})
        text = self.camber("geometry", "m.mesh").stdout
        for words in ("patches", "ridges", "corners", "suspicious places", "none", "surrogate through the mesh's vertices"):
            self.assertIn(words, text)

    def test_geometry_reports_misoriented_facets(self):
        mesh = cone(12, 0.2)
        self.assertEqual(self.report(mesh)["misoriented_facets"]["count"], 0)
        a, b, c = mesh.facets[3]
        mesh.facets[3] = (a, c, b)
        found = self.report(mesh)
        self.assertEqual(found["misoriented_facets"]["count"], 2)
        for at in found["misoriented_facets"]["first"]:
            self.assertIn(4, at["facets"])
        self.assertEqual(found["open_edges"]["count"], 12)
        self.assertIn("misoriented facets", self.camber("geometry", "m.mesh").stdout)

    def test_the_tip_and_the_near_ridges_of_a_cone_are_reported(self):
        found = self.report(cone(24, 2))
        tip = found["suspicious"]["tip"]
        self.assertEqual((tip["count"], tip["worst"][0]["vertices"], tip["worst"][0]["point"]), (1, [1], [0, 0, 2]))
        self.assertAlmostEqual(tip["worst"][0]["value"], math.degrees(math.atan2(2, 1)), delta=1)
        turn = math.degrees(2 * math.asin(math.sin(math.pi / 24) * 2 / math.hypot(1, 2)))  # approximate dihedral angle
        near = self.report("m.mesh", "--ridge-angle", f"{1.1 * turn:.3f}")["suspicious"]["near_ridge"]
        self.assertEqual(near["count"], 24)
        self.assertEqual(len(near["worst"]), 10)
        for place in near["worst"]:
            self.assertEqual(len(place["vertices"]), 2)
            self.assertLess(abs(place["value"] - turn), 1)
        self.assertEqual(len(self.report("m.mesh", "--ridge-angle", f"{1.1 * turn:.3f}", "--worst", "3")
                             ["suspicious"]["near_ridge"]["worst"]), 3)

    def test_geometry_reports_knife_edges(self):
        wedge = surface([(0, 0, 0), (1, 0, 0), (0.5, 1, 0.1), (0.5, 1, -0.1)], [(0, 1, 2), (1, 0, 3)])
        knife = self.report(wedge)["suspicious"]["knife_edge"]
        self.assertEqual((knife["count"], sorted(knife["worst"][0]["vertices"])), (1, [1, 2]))
        self.assertAlmostEqual(knife["worst"][0]["value"], 180 - 2 * math.degrees(math.atan2(0.1, 1)), places=6)

    def test_distances_match_those_of_dense_samples(self):
        """Distances of a curved sphere, computed independently."""
        self.camber("generate", "shell", "-o", "s.mesh")
        self.camber("curve", "s.mesh", "-o", "c.mesh", "--geometry", SPHERES)
        found = self.report("c.mesh", "--geometry", SPHERES)
        mesh = vtu_boundary(self.folder, "c.mesh")
        random = np.random.default_rng(3)
        for entity, radius in ((0, 5), (1, 1)):
            reported = found["distances"]["entities"][entity]
            self.assertEqual(reported["kind"], "surface")
            self.assertEqual(reported["references"], [entity + 1])
            directions = random.normal(size=(60, 3))
            points = radius * directions / np.linalg.norm(directions, axis=1)[:, None]
            dense = distance_to_curved(points, mesh, 24)
            spacing = 0.6 * radius / 24
            largest = reported["to_boundary"]["largest"]
            self.assertLess(dense.max(), 1.05 * largest + spacing)
            for way in ("to_geometry", "to_boundary"):
                at = reported[way]
                self.assertAlmostEqual(math.dist(at["from"], at["to"]), at["largest"], delta=1e-9)
                self.assertGreaterEqual(at["largest"], at["mean"])
                on_sphere = at["to" if way == "to_geometry" else "from"]
                self.assertAlmostEqual(np.linalg.norm(on_sphere), radius, delta=1e-9)
            self.assertAlmostEqual(largest, reported["to_geometry"]["largest"], delta=0.1 * largest)

    def test_the_vtu_file_contains_distances_and_patches(self):
        self.camber("generate", "shell", "-o", "s.mesh")
        found = self.report("s.mesh", "--geometry", SPHERES, "-o", "out/d.vtu")
        grid = vtu.read(self.folder.path / "out/d.vtu")
        elements = found["elements"]
        for name, way in (("distance_to_geometry", "to_geometry"), ("distance_to_boundary", "to_boundary")):
            values = np.asarray(grid.cell_data[name])
            self.assertTrue(np.isnan(values[:elements]).all())
            facets = values[elements:elements + found["facets"]]
            self.assertEqual(facets.max(), found["distances"][way]["largest"])
            self.assertEqual(facets.argmax() + 1, found["distances"][way]["facet"])
        patches = np.asarray(grid.cell_data["patch"])[elements:]
        for patch in found["patches"]:
            self.assertEqual((patches == patch["patch"] - 1).sum(), patch["facets"])

    def test_option_surface_writes_points_and_normals_of_the_geometry(self):
        self.camber("generate", "shell", "-o", "s.mesh")
        done = self.camber("geometry", "s.mesh", "--geometry", SPHERES, "--surface", "smooth.vtu", "-o", "d.vtu")
        self.assertIn("wrote smooth.vtu", done.stdout)
        found = self.report("s.mesh", "--geometry", SPHERES)
        exact = vtu.read(self.folder.path / "smooth.vtu")
        radius = np.linalg.norm(exact.points, axis=1)
        np.testing.assert_allclose(np.minimum(abs(radius - 1), abs(radius - 5)), 0, atol=1e-12)
        normals = np.asarray(exact.point_data["normal"]).reshape(-1, 3)
        np.testing.assert_allclose(abs((normals * exact.points).sum(1)) / radius, 1, atol=1e-12)
        facets = np.asarray(exact.cell_data["facet"])
        self.assertEqual(len(facets), 36 * found["facets"])
        np.testing.assert_array_equal(np.bincount(facets)[1:], 36)
        # The surrogate interpolates the vertices of the mesh and is close to the spheres.
        self.camber("geometry", "s.mesh", "--surface", "own.vtu")
        own = vtu.read(self.folder.path / "own.vtu")
        radius = np.linalg.norm(own.points, axis=1)
        self.assertLess(np.minimum(abs(radius - 1), abs(radius - 5)).max(), 0.02)
        normals = np.asarray(own.point_data["normal"]).reshape(-1, 3)
        self.assertGreater((abs((normals * own.points).sum(1)) / radius).min(), 0.98)  # smaller at creases along edges
        flat = self.write(lattice(2, 1), "flat.mesh")
        self.camber("geometry", flat, "--surface", "flat.vtu")
        self.assertEqual(len(vtu.read(self.folder.path / "flat.vtu").cell_data["facet"]), 6 * 4)
        self.refused(2, "viewers", "s.mesh", "--surface", "out.mesh")
        self.refused(2, "d.vtu", "s.mesh", "--surface", "d.vtu", "-o", "d.vtu")

    def test_distances_to_a_cad_model_are_reported_for_each_face(self):
        if not self.reads_cad():
            self.skipTest("built without OpenCASCADE")
        self.camber("generate", "shell", "-o", "s.mesh")
        self.camber("curve", "s.mesh", "-o", "c.mesh", "--cad", CAD_MODEL, "--report", "r.json", "--set",
                    "output/distances=both")
        found = self.report("c.mesh", "--cad", CAD_MODEL)
        self.assertIn("shell.brep", found["geometry"])
        by_kind = {}
        for entity in found["distances"]["entities"]:
            by_kind.setdefault(entity["kind"], []).append(entity)
        self.assertEqual([e["number"] for e in by_kind["face"]], [1, 2])
        for face in by_kind["face"]:
            self.assertGreater(face["to_boundary"]["samples"], 200)
            self.assertLess(face["to_boundary"]["largest"], 0.01)
            self.assertAlmostEqual(face["to_boundary"]["largest"], face["to_geometry"]["largest"],
                                   delta=0.2 * face["to_geometry"]["largest"])
        self.assertEqual(sorted(f for p in found["patches"] for f in p["cad_faces"]), [1, 2])
        self.assertEqual(found["suspicious"]["ambiguous_facet"]["count"], 0)
        # The report of the run contains the same distances.
        reported = report_of(self.folder.path / "r.json")["boundary"]["distances"]
        self.assertEqual(reported, found["distances"])

    def test_geometry_accepts_2d_and_flat_meshes(self):
        found = self.report(lattice(2, 3))
        self.assertEqual((len(found["patches"]), len(found["corners"]), found["ridges"]), (4, 4, []))
        self.assertEqual([e["kind"] for e in found["distances"]["entities"]], ["curve"] * 4)
        square = lattice(2, 2)
        square = surface(np.c_[square.points, np.full(len(square.points), 0.5)], square.elements)
        name = self.write(square, "flat.mesh")
        self.assertEqual(self.report(name)["dimension"], 2)
        self.assertEqual(self.report(name, "--flat", "surface")["dimension"], 3)
        self.camber("geometry", name, "-o", "flat.vtu")
        grid = vtu.read(self.folder.path / "flat.vtu")
        self.assertEqual(set(np.asarray(grid.points)[:, 2]), {0.5})

    def test_a_boundary_that_is_not_listed_is_derived_and_noted(self):
        mesh = lattice(3, 1)
        mesh.facets, mesh.facet_references = [], []
        found = self.report(mesh)
        self.assertFalse(found["boundary_is_listed"])
        self.assertEqual(len(found["patches"]), 6)
        self.assertRegex(self.camber("geometry", "m.mesh").stderr, "lists no boundary")

    def test_interface_facets_are_counted_and_form_a_patch(self):
        mesh = lattice(3, 2)
        centre = mesh.points[[list(e) for e in mesh.elements]].mean(1)
        mesh.element_references = [1 if c[0] < 1 else 2 for c in centre]
        inside = {}
        for e, reference in zip(mesh.elements, mesh.element_references):
            for i in range(4):
                face = tuple(v for k, v in enumerate(e) if k != i)
                inside.setdefault(tuple(sorted(face)), []).append((reference, face))
        between = [both[0][1] for both in inside.values() if len(both) == 2 and both[0][0] != both[1][0]]
        mesh.facets = list(mesh.facets) + between
        mesh.facet_references = [1] * (len(mesh.facets) - len(between)) + [9] * len(between)
        found = self.report(mesh)
        self.assertEqual(found["interface_facets"], len(between))
        patch = next(p for p in found["patches"] if p["references"] == [9])
        self.assertEqual((patch["facets"], patch["interface_facets"]), (8, 8))
        self.assertEqual(found["non_manifold_edges"]["count"], 8)

    def test_the_report_does_not_depend_on_the_number_of_threads(self):
        self.camber("generate", "shell", "-o", "s.mesh")
        one, three = (self.camber("geometry", "s.mesh", "--json", "--threads", n).stdout for n in (1, 3))
        self.assertEqual(one, three)

    def test_documented_and_written_keys_of_the_report_agree(self):
        self.camber("generate", "shell", "-o", "s.mesh")
        hinged = surface([(0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0.5, -1, 0.1), (0.5, 0, 1)], [(0, 1, 2), (1, 0, 3), (0, 1, 4)])
        turned = surface([(0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0.5, -1, 0.7)], [(0, 1, 2), (0, 1, 3)])
        objects = [self.report(m) for m in (lattice(3, 1), cone(24, 2), hinged, turned, lattice(2, 2))]
        objects.append(self.report("s.mesh", "--geometry", SPHERES))
        written_keys = {leaf for one in objects for leaf in leaves(one)}
        keys = {key for key in documented("geometry --json") if not key.startswith("histograms.")}
        if self.reads_cad():
            written_keys |= leaves(self.report("s.mesh", "--cad", CAD_MODEL))
            self.camber("generate", "annulus", "--set", "outer_radius=2", "-o", "a.mesh")
            written_keys |= leaves(self.report("a.mesh", "--cad", CAD_MODEL.parent / "annulus.brep"))
        else:
            keys = {key for key in keys if "cad" not in key and "ambiguous" not in key}
        for path in sorted(written_keys):
            known = any(holds(key, path) or pattern(key.split("[]")[0]).match(path) for key in keys)
            self.assertTrue(known, f"docs/report.md does not know {path}")
        for key in sorted(keys):
            self.assertTrue(any(pattern(key).match(path) for path in written_keys), f"docs/report.md has {key}, which nothing writes")

    def refused(self, code, words, *arguments):
        done = self.folder.camber("geometry", *arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertRegex(done.stderr, words)
        self.assertEqual(done.stdout, "")

    def test_bad_arguments_and_files_are_rejected(self):
        name = self.write(lattice(3, 1))
        self.refused(3, "cannot be read", "absent.mesh")
        self.refused(2, "viewers", name, "-o", "out.mesh")
        self.refused(2, "is also|same|input", name, "-o", name)
        self.refused(2, "--cad", name, "--cad", "m.step", "--geometry", "surrogate")
        self.refused(2, "no model is specified", name, "--cad-unit", "mm")
        self.refused(2, "no boundary triangle", name, "--geometry", SPHERES)
        self.refused(2, "ridge", name, "--ridge-angle", "0")
        self.write("MeshVersionFormatted 2\nDimension 3\nVertices 1\n0 0", "broken.mesh")
        self.refused(3, "broken.mesh", "broken.mesh")
        flat = self.write(lattice(2, 1), "flat.mesh")
        if self.reads_cad():
            self.refused(3, "one plane", flat, "--cad", CAD_MODEL)


def vtu_boundary(folder, name):
    """The curved facets of a file, read by the oracle."""
    import gmf
    mesh = gmf.read(folder.path / name)
    return Mesh(mesh.points, [], [tuple(row) for row in mesh.cells["TrianglesP2"].nodes], degree=2)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
