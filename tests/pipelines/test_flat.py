"""Flat meshes (triangles with equal z in a file of dimension 3) give the results of the same mesh in 2D and are written
in 3D.

    python3 tests/pipelines/test_flat.py build/bin/camber [unittest arguments]
"""
import copy
import json
import shutil
import subprocess
import sys
import unittest

from program import CONFIGS, Folder, report_of

import gmf  # noqa: E402  (program puts the oracle on the path)
import numpy as np
import vtu
from sample_meshes import ascii_file, binary_file, elevate, linear_mesh, solution_file

NOTE = "camber: note: the mesh is flat (z = {}): read as 2D, and written with its z"


def flat(mesh, z=0.0):
    """The 2D mesh in a file of dimension 3."""
    out = copy.deepcopy(mesh)
    out.dim, out.points = 3, np.column_stack([mesh.points, np.full(len(mesh.points), z)])
    for name in ("Normals", "Tangents"):
        if name in out.lists:
            ints, reals = out.lists[name]
            out.lists[name] = ints, np.column_stack([reals, np.zeros(len(reals))])
    return out


def clockwise(mesh):
    out = copy.deepcopy(mesh)
    for name, order in (("Triangles", [1, 0, 2]), ("TrianglesP2", [1, 0, 2, 3, 5, 4])):
        if name in out.cells:
            out.cells[name].nodes = out.cells[name].nodes[:, order]
    return out


def without_edges(mesh):
    out = copy.deepcopy(mesh)
    for name in ("Edges", "EdgesP2"):
        out.cells.pop(name, None)
    return out


def listed(*numbers):
    return np.asarray(numbers, np.int64).reshape(-1, 1), np.empty((len(numbers), 0))


class Flat(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return self.folder.path / name

    def write(self, name, mesh):
        self.path(name).write_bytes(binary_file(mesh, 2) if name.endswith("b") else ascii_file(mesh))

    def run_camber(self, *arguments, codes=(0,)):
        done = self.folder.camber(*arguments)
        self.assertIn(done.returncode, codes, done.stdout + done.stderr)
        return done

    def annulus(self):
        """The straight mesh of configs/annulus-2d.json, with layers at its inner circle."""
        self.run_camber("run", CONFIGS / "annulus-2d.json", "--set", "stages=[]", "--set", "output/mesh=annulus.mesh",
                        "--set", "output/report=annulus.json")
        return gmf.read(self.path("annulus.mesh"))

    def broken(self):
        """The curved annulus with displaced inner nodes."""
        self.write("straight.mesh", self.annulus())
        self.run_camber("curve", "straight.mesh", "-o", "curved.mesh")
        mesh = gmf.read(self.path("curved.mesh"))
        random, moved_nodes = np.random.default_rng(3), set(mesh.cells["EdgesP2"].nodes.flat)
        for row in mesh.cells["TrianglesP2"].nodes:
            for a, b, node in gmf.LOCAL_EDGES[2]:
                if row[node] not in moved_nodes:
                    chord = np.linalg.norm(mesh.points[row[b]] - mesh.points[row[a]])
                    mesh.points[row[node]] += 0.3 * chord * random.uniform(-1, 1, 2)
                    moved_nodes.add(row[node])
        return mesh

    def same_but_for_z(self, plane, space, z=0.0):
        """Checks that two files contain the same mesh, the second with z."""
        a, b = gmf.read(self.path(plane)), gmf.read(self.path(space))
        self.assertEqual((a.dim, b.dim), (2, 3))
        np.testing.assert_array_equal(b.points[:, :2], a.points)
        np.testing.assert_array_equal(b.points[:, 2], z)
        np.testing.assert_array_equal(b.point_refs, a.point_refs)
        self.assertEqual(sorted(a.cells), sorted(b.cells))
        for name, cells in a.cells.items():
            np.testing.assert_array_equal(b.cells[name].nodes, cells.nodes)
            np.testing.assert_array_equal(b.cells[name].refs, cells.refs)
        self.assertEqual(sorted(a.lists), sorted(b.lists))
        for name, (ints, reals) in a.lists.items():
            np.testing.assert_array_equal(b.lists[name][0], ints)
            np.testing.assert_array_equal(b.lists[name][1][:, :reals.shape[1]], reals)
        return b

    def both(self, verb, mesh, *arguments, z=0.0, codes=(0,), ending="mesh"):
        """Runs the verb on the 2D mesh and on the flat one: equal results, reports and messages except for the note."""
        runs = []
        for name, file_mesh in (("plane", mesh), ("space", flat(mesh, z))):
            self.write(f"{name}.{ending}", file_mesh)
            done = self.run_camber(verb, f"{name}.{ending}", "-o", f"{name}-out.{ending}", "--report", f"{name}.json",
                                   *arguments, codes=codes)
            runs.append((done, report_of(self.path(f"{name}.json"))))
        (plane, figures), (space, same) = runs
        note = [line for line in space.stderr.splitlines() if line not in plane.stderr.splitlines()]
        self.assertEqual(len(note), 1, space.stderr)
        self.assertTrue(note[0].startswith(NOTE.format(f"{z:g}")), note[0])
        self.assertEqual(plane.returncode, space.returncode)
        for report in (figures, same):
            for varies in ("times", "stages", "notices", "config"):
                report.pop(varies, None)
            for file in ("mesh", "metric"):
                report["input"].pop(file)
            report.get("curve", {}).pop("edges_per_second", None)
        self.assertEqual(figures, same)
        self.same_but_for_z(f"plane-out.{ending}", f"space-out.{ending}", z)
        return figures

    # ---------------------------------------------------------------- the verbs

    # Guards against flat triangles curved as a surface.
    def test_curve_treats_a_flat_mesh_as_the_2d_mesh(self):
        mesh = self.annulus()
        for z, ending in ((0.0, "mesh"), (2.5, "meshb")):
            figures = self.both("curve", mesh, z=z, ending=ending)
            self.assertEqual((figures["mesh"]["dimension"], figures["mesh"]["degree"]), (2, 2))
            self.assertGreater(figures["boundary"]["surface_edges"], 0)

    def test_run_treats_a_flat_mesh_as_the_2d_mesh(self):
        mesh = self.annulus()
        for name, file_mesh in (("plane", mesh), ("space", flat(mesh, -1.25))):
            self.write(f"{name}.mesh", file_mesh)
            self.path(f"{name}.json").write_text(json.dumps(
                {"input": {"mesh": f"{name}.mesh"}, "stages": ["elevate", "reinsert"],
                 "metric_operations": [{"gradation": {}}],
                 "geometry": {"analytic": [{"references": [1], "sphere": {"radius": 3}}]},
                 "output": {"mesh": f"{name}-out.mesh"}}))
            self.run_camber("run", f"{name}.json")
        self.same_but_for_z("plane-out.mesh", "space-out.mesh", -1.25)
        self.assertIn("2D, P1", self.run_camber("run", "space.json", "--dry-run").stdout)

    def test_output_fields_of_a_flat_mesh_equal_those_in_2d(self):
        mesh = self.annulus()
        self.both("curve", mesh, "--vtu", "fields.vtu")
        of_space = self.path("fields.vtu").read_bytes()
        self.run_camber("curve", "plane.mesh", "-o", "plane-out.vtu")
        self.assertEqual(self.path("plane-out.vtu").read_bytes(), of_space)
        self.write("high.mesh", flat(mesh, 3.0))
        self.run_camber("curve", "high.mesh", "-o", "high.vtu")
        low, high = vtu.read(self.path("fields.vtu")), vtu.read(self.path("high.vtu"))
        np.testing.assert_array_equal(high.points, low.points + [0, 0, 3])
        for one, other in ((low.point_data, high.point_data), (low.cell_data, high.cell_data)):
            self.assertEqual(sorted(one), sorted(other))
            for name in one:
                np.testing.assert_array_equal(one[name], other[name])
        self.assertIn("metric", low.point_data)

    # Guards against the report "0 invalid" of 0 elements for flat triangles.
    def test_check_reports_the_same_for_a_flat_mesh_as_in_2d(self):
        straight, curved = self.annulus(), self.broken()
        for mesh, code in ((straight, 0), (curved, 1), (without_edges(straight), 0), (clockwise(straight), 1)):
            results = []
            for name, file_mesh in (("plane.mesh", mesh), ("space.mesh", flat(mesh))):
                self.write(name, file_mesh)
                done = self.run_camber("check", name, "--json", "--elements", codes=(code,))
                results.append(json.loads(done.stdout))
                del results[-1]["file"]
            plane, space = results
            self.assertEqual(len(space["notices"]), len(plane["notices"]) + 1)
            self.assertEqual(plane | {"notices": []}, space | {"notices": []})
            self.assertEqual(space["elements"], len(mesh.cells[next(n for n in mesh.cells if "Triangles" in n)].nodes))

    def test_repair_treats_a_flat_mesh_as_the_2d_mesh(self):
        mesh = self.broken()
        for z in (0.0, 2.5):
            figures = self.both("repair", mesh, z=z)
            self.assertGreater(figures["relax"]["corrected_elements"], 0)
            self.assertEqual(figures["validity"]["invalid"], 0)

    def test_info_reports_the_plane_of_a_flat_mesh(self):
        self.write("space.mesh", flat(self.annulus(), 2.5))
        reported = json.loads(self.run_camber("info", "space.mesh", "--json").stdout)
        self.assertEqual((reported["dimension"], reported["written_in_dimension"], reported["z"]), (2, 3, 2.5))
        self.assertEqual(len(reported["notices"]), 1)
        self.assertNotIn("written_in_dimension", json.loads(self.run_camber("info", "annulus.mesh", "--json").stdout))

    def test_convert_preserves_flat_meshes_and_accepts_2d_and_3d_metrics(self):
        """Canonical files are unchanged after conversions, and a solution may be in 2D or 3D."""
        mesh = self.annulus()
        self.write("plane.mesh", mesh)
        self.write("space.mesh", flat(mesh))
        self.run_camber("convert", "space.mesh", "-o", "binary.meshb")
        self.run_camber("convert", "binary.meshb", "-o", "text.mesh")
        self.run_camber("convert", "text.mesh", "-o", "again.meshb")
        self.assertEqual(self.path("again.meshb").read_bytes(), self.path("binary.meshb").read_bytes())
        self.same_but_for_z("plane.mesh", "text.mesh")
        rows = np.random.default_rng(1).uniform(1, 2, (len(mesh.points), 6)) + [3, 0, 3, 0, 0, 3]
        self.path("six.solb").write_bytes(solution_file(rows, 3, 3))
        self.path("three.solb").write_bytes(solution_file(rows[:, :3], 3, 2))
        metrics = {}
        for grid, input_name, solution in (("a.vtu", "plane", "three"), ("b.vtu", "space", "three"), ("c.vtu", "space", "six")):
            self.run_camber("convert", f"{input_name}.mesh", "-o", grid, "--metric", f"{solution}.solb", "--elevate")
            metrics[grid] = vtu.read(self.path(grid)).point_data["metric"][:len(rows)]
        self.assertEqual(self.path("a.vtu").read_bytes(), self.path("b.vtu").read_bytes())
        np.testing.assert_array_equal(metrics["c.vtu"], rows[:, [0, 2, 5, 1, 4, 3]])

    # ---------------------------------------------------------------- contents of files

    # Guards against unlisted boundary edges of a flat mesh that stay straight.
    def test_missing_boundary_edges_are_added_and_curved(self):
        """Missing edges are added, noted, and curved like listed ones."""
        mesh = without_edges(self.annulus())
        figures = self.both("curve", mesh)
        out = gmf.read(self.path("space-out.mesh"))
        rows = out.cells["EdgesP2"].nodes
        self.assertEqual(figures["mesh"]["facets"], len(rows))
        bows = np.linalg.norm(out.points[rows[:, 2]] - out.points[rows[:, :2]].mean(axis=1), axis=1)
        self.assertTrue((bows > 0).all())
        radii = np.linalg.norm(out.points[rows[:, 2]][:, :2], axis=1)
        self.assertLess(np.minimum(abs(radii - 1), abs(radii - 3)).max(), 2e-3)
        error_output = self.folder.camber("curve", "space.mesh", "-o", "again.mesh").stderr
        self.assertIn(f"but no boundary is listed (the first: triangle ", error_output)
        self.assertIn(f"added {len(rows)} edges of reference 1", error_output)

    def test_repair_preserves_unlisted_boundary_edges_of_a_curved_mesh(self):
        """Unlisted edges are boundary, which repair preserves bit for bit."""
        mesh = self.broken()
        rows = mesh.cells["EdgesP2"].nodes
        figures = self.both("repair", without_edges(mesh))
        self.assertEqual(figures["input_boundary"]["moved_nodes"], 0)
        out = gmf.read(self.path("space-out.mesh"))
        stored = lambda points, nodes: sorted(tuple(points[node][:2]) for node in nodes[:, 2])
        self.assertEqual(stored(out.points, out.cells["EdgesP2"].nodes), stored(mesh.points, rows))

    def test_missing_edges_of_one_boundary_get_their_own_reference(self):
        mesh = self.annulus()
        edges = mesh.cells["Edges"]
        edges.nodes, edges.refs = edges.nodes[edges.refs == 1], edges.refs[edges.refs == 1]
        self.both("curve", mesh)
        self.assertEqual(sorted(set(gmf.read(self.path("space-out.mesh")).cells["EdgesP2"].refs)), [1, 2])

    def test_clockwise_triangles_are_reoriented(self):
        """All triangles are reoriented and noted; the nodes equal those of the counterclockwise mesh."""
        mesh = self.annulus()
        self.both("curve", mesh)
        right = gmf.read(self.path("space-out.mesh"))
        self.both("curve", clockwise(mesh))
        error_output = self.folder.camber("curve", "space.mesh", "-o", "again.mesh").stderr
        self.assertIn("triangles are numbered the wrong way round (the first: triangle 1): turned", error_output)
        turned = gmf.read(self.path("space-out.mesh"))
        corners = turned.points[turned.cells["TrianglesP2"].nodes[:, :3]]
        sides = corners[:, 1:] - corners[:, :1]
        self.assertTrue((np.cross(sides[:, 0, :2], sides[:, 1, :2]) > 0).all())
        np.testing.assert_array_equal(turned.points, right.points)

    def test_a_curved_flat_mesh_is_treated_as_in_2d(self):
        """Also for clockwise triangles."""
        mesh = self.broken()
        stages = ("--set", 'stages=["curve", "validate", "relax", "commit"]')
        self.both("curve", mesh, *stages)
        self.both("repair", clockwise(mesh))

    def test_required_entities_ridges_and_normals_are_preserved(self):
        mesh = self.annulus()
        mesh.lists |= {"Corners": listed(1), "RequiredVertices": listed(2, 5), "Ridges": listed(1, 3),
                       "RequiredEdges": listed(4), "RequiredTriangles": listed(7, 9)}
        of = np.unique(mesh.cells["Edges"].nodes)[:4]
        outwards = mesh.points[of] / np.linalg.norm(mesh.points[of], axis=1, keepdims=True)
        mesh.lists |= {"Normals": (np.empty((len(of), 0), np.int64), outwards),
                       "NormalAtVertices": (np.column_stack([of + 1, np.arange(len(of)) + 1]), np.empty((len(of), 0)))}
        self.both("curve", mesh)
        out = gmf.read(self.path("space-out.mesh"))
        for name in mesh.lists:
            self.assertIn(name, out.lists)

    def test_normals_to_the_plane_are_preserved_and_have_no_effect(self):
        """(0, 0, 1) has no meaning in 2D: the result is that without normals, and the table is preserved."""
        mesh = self.annulus()
        self.both("curve", mesh)
        space = flat(mesh)
        n = len(mesh.points)
        space.lists["Normals"] = np.empty((1, 0), np.int64), np.array([[0.0, 0, 1]])
        space.lists["NormalAtVertices"] = np.array([[v + 1, 1] for v in range(n)]), np.empty((n, 0))
        self.write("normals.mesh", space)
        self.run_camber("curve", "normals.mesh", "-o", "normals-out.mesh")
        out = gmf.read(self.path("normals-out.mesh"))
        np.testing.assert_array_equal(out.points, gmf.read(self.path("space-out.mesh")).points)
        for name in ("Normals", "NormalAtVertices"):
            for stored, expected in zip(out.lists[name], space.lists[name]):
                np.testing.assert_array_equal(stored, expected)

    def test_an_unused_vertex_outside_the_plane_is_preserved(self):
        """For example the centre of an arc."""
        mesh = self.annulus()
        mesh.points = np.vstack([mesh.points, [0, 0]])
        mesh.point_refs = np.append(mesh.point_refs, 0)
        space = flat(mesh)
        space.points[-1] = (0, 0, 7)
        self.write("space.mesh", space)
        error_output = self.run_camber("curve", "space.mesh", "-o", "out.mesh").stderr
        self.assertIn(NOTE.format(0), error_output)
        out = gmf.read(self.path("out.mesh"))
        np.testing.assert_array_equal(out.points[len(mesh.points) - 1], (0, 0, 7))
        np.testing.assert_array_equal(np.delete(out.points, len(mesh.points) - 1, axis=0)[:, 2], 0)

    # ---------------------------------------------------------------- metrics

    def test_metrics_in_2d_and_3d_files_give_the_same_mesh(self):
        """Only the part of a 3D metric in the plane counts; 2D metrics and sizes are accepted too."""
        mesh = self.annulus()
        self.write("plane.mesh", mesh)
        self.write("space.mesh", flat(mesh))
        n = len(mesh.points)
        random = np.random.default_rng(5)
        tensors = random.uniform(0, 1, (n, 6)) + np.array([20, 0, 5, 0, 0, 3])
        sizes = random.uniform(0.1, 1, (n, 1))
        for kind, in_space, in_plane in ((3, tensors, tensors[:, :3]), (1, sizes, sizes)):
            self.path("plane.solb").write_bytes(solution_file(in_plane, kind, 2))
            self.path("space.solb").write_bytes(solution_file(in_space, kind, 3))
            self.run_camber("curve", "plane.mesh", "-o", "plane-out.mesh", "--metric", "plane.solb")
            for metric in ("plane.solb", "space.solb"):
                self.run_camber("curve", "space.mesh", "-o", "space-out.mesh", "--metric", metric)
                self.same_but_for_z("plane-out.mesh", "space-out.mesh")
                self.run_camber("curve", "space.mesh", "-o", "both.mesh", "--set",
                                f'metric_operations=[{{"intersect": {{"file": "{metric}"}}}}]')
                self.run_camber("curve", "plane.mesh", "-o", "plane-both.mesh", "--set",
                                'metric_operations=[{"intersect": {"file": "plane.solb"}}]')
                self.same_but_for_z("plane-both.mesh", "both.mesh")
        refused = self.folder.camber("curve", "plane.mesh", "-o", "out.mesh", "--metric", "space.solb")
        self.assertEqual(refused.returncode, 3)
        self.assertIn("is in 3D, the mesh in 2D", refused.stderr)

    # ---------------------------------------------------------------- Gmsh

    @unittest.skipUnless(shutil.which("gmsh"), "no gmsh here")
    def test_flat_meshes_of_gmsh_are_read_and_written(self):
        """A disc in an annulus from Gmsh, of degree 1 and 2; Gmsh reads the output."""
        self.path("disc.geo").write_text(
            "Point(1) = {0, 0, 0, 0.3};\n"
            + "".join(f"Point({5 * r + k + 2}) = {{{x * (r + 1)}, {y * (r + 1)}, 0, 0.3}};\n"
                      for r in (0, 1) for k, (x, y) in enumerate(((1, 0), (0, 1), (-1, 0), (0, -1))))
            + "".join(f"Circle({4 * r + k + 1}) = {{{5 * r + k + 2}, 1, {5 * r + (k + 1) % 4 + 2}}};\n"
                      for r in (0, 1) for k in range(4))
            + "Curve Loop(1) = {1, 2, 3, 4};\nCurve Loop(2) = {5, 6, 7, 8};\n"
              "Plane Surface(1) = {1};\nPlane Surface(2) = {2, 1};\n")

        def gmsh(*arguments):
            done = subprocess.run(["gmsh", *arguments], cwd=self.folder.path, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

        for order, verb in ((1, "curve"), (2, "repair")):
            gmsh("-2", "-order", str(order), "disc.geo", "-format", "mesh", "-o", "disc.mesh")
            error_output = self.run_camber(verb, "disc.mesh", "-o", "out.mesh").stderr
            self.assertIn(NOTE.format(0), error_output)
            gmsh("-save", "out.mesh", "-format", "msh22", "-o", "back.msh")
            rows = self.path("back.msh").read_text().partition("$Elements\n")[2].splitlines()[1:]
            kinds = [row.split()[1] for row in rows if len(row.split()) > 3]
            out = gmf.read(self.path("out.mesh"))
            self.assertEqual((kinds.count("8"), kinds.count("9")),
                             tuple(len(out.cells[name].nodes) for name in ("EdgesP2", "TrianglesP2")))

    # ---------------------------------------------------------------- option --flat surface

    def test_option_flat_surface_keeps_a_surface_in_3d(self):
        """A surface in 3D has no elements; no edge is added and no note printed."""
        mesh = without_edges(self.annulus())
        self.write("space.mesh", flat(mesh))
        self.path("run.json").write_text(json.dumps({"input": {"mesh": "space.mesh", "flat": "surface"},
                                                     "output": {"mesh": "run.mesh", "report": "run-report.json"}}))
        done = self.run_camber("curve", "space.mesh", "-o", "out.mesh", "--report", "report.json", "--flat", "surface")
        ran = self.run_camber("run", "run.json")
        self.assertEqual((done.stderr, ran.stderr), ("", ""))
        self.assertEqual(self.path("out.mesh").read_bytes(), self.path("run.mesh").read_bytes())
        for name in ("report.json", "run-report.json"):
            figures = report_of(self.path(name))["mesh"]
            self.assertEqual((figures["dimension"], figures["elements"], figures["facets"]),
                             (3, 0, len(mesh.cells["Triangles"].nodes)))
        out = gmf.read(self.path("out.mesh"))
        self.assertEqual(list(out.cells), ["TrianglesP2"])
        np.testing.assert_array_equal(out.points[:, 2], 0)
        self.assertIn("valid triangles", self.run_camber("check", "space.mesh", "--flat", "surface",
                                                                        codes=(0, 1)).stdout)
        self.run_camber("repair", "out.mesh", "-o", "repaired.mesh", "--flat", "surface")
        self.assertEqual(self.path("repaired.mesh").read_bytes(), self.path("out.mesh").read_bytes())
        self.assertIn("flat=surface", self.run_camber("curve", "space.mesh", "-o", "out.mesh", "--flat", "surface",
                                                      "--dry-run").stdout)

    def test_a_mesh_that_is_not_flat_stays_a_surface(self):
        mesh = linear_mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [])
        mesh.cells = {"Triangles": linear_mesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]]).cells["Triangles"]}
        for z, notes in ((0.1, 0), (1e-17, 1)):
            mesh.points[3][2] = z
            for name, file_mesh in (("in.mesh", mesh), ("p2.mesh", elevate(mesh))):
                self.write(name, file_mesh)
                reported = json.loads(self.run_camber("info", name, "--json").stdout)
                self.assertEqual((reported["dimension"], reported["tetrahedra"], len(reported["notices"])), (3, 0, notes))
                self.assertEqual("nearly flat" in str(reported["notices"]), notes == 1)

    def test_the_output_does_not_depend_on_the_number_of_threads(self):
        self.write("space.mesh", flat(self.annulus(), 0.1))
        results = set()
        for threads in (1, 3):
            self.run_camber("curve", "space.mesh", "-o", "out.meshb", "--threads", threads)
            results.add(self.path("out.meshb").read_bytes())
        self.assertEqual(len(results), 1)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
