"""Analytic surfaces: combined with the surrogate, and rejected where they do not fit the mesh.

    python3 tests/pipelines/test_geometry.py build/bin/camber [unittest arguments]
"""
import json
import sys
import unittest

import made_meshes
from program import Folder, report_of

import gmf  # noqa: E402  (program puts the oracle on the path)
import numpy as np
import vtu

SHAPES = {"shell": {"shell": {"inner_radius": 1, "outer_radius": 5, "inner_size": 0.6, "outer_size": 2}},
          "annulus": {"annulus": {"inner_radius": 1, "outer_radius": 5, "inner_size": 0.4, "outer_size": 2}}}
OUTER, INNER = 1, 2


def sphere(radius, references=(OUTER,), **more):
    return {"references": list(references), "sphere": {"radius": radius, **more}}


class Geometry(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def config(self, shape, surfaces, **output):
        text = json.dumps({"input": {"generate": SHAPES[shape]}, "metric": "natural", "geometry": surfaces,
                           "stages": ["elevate", "curve", "validate", "relax", "commit"], "output": output})
        (self.folder.path / "run.json").write_text(text)
        return "run.json"

    def camber(self, *arguments):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def off_sphere(self, name, reference, radius):
        """Largest distance of the mid nodes of facets with a reference from a sphere around the origin."""
        mesh = gmf.read(self.folder.path / name)
        cells = mesh.cells["TrianglesP2" if mesh.dim == 3 else "EdgesP2"]
        nodes = cells.nodes[cells.refs == reference][:, mesh.dim:].ravel()
        return np.abs(np.linalg.norm(mesh.points[nodes], axis=1) - radius).max()

    # Guards against straight facets of references without an analytic surface.
    def test_references_without_an_analytic_surface_use_the_surrogate(self):
        for shape in SHAPES:
            off, largest = {}, {}
            for name, geometry in (("straight", "straight"), ("surrogate", "surrogate"),
                                   ("mixed", {"analytic": [sphere(5)]})):
                self.camber("run", self.config(shape, geometry, mesh=f"{name}.meshb", report=f"{name}.json"))
                off[name] = {r: self.off_sphere(f"{name}.meshb", r, radius) for r, radius in ((OUTER, 5), (INNER, 1))}
                largest[name] = report_of(self.folder.path / f"{name}.json")["boundary"]["largest_distance"]
            with self.subTest(shape=shape):
                self.assertEqual(off["mixed"][INNER], off["surrogate"][INNER])
                self.assertLess(off["mixed"][INNER], 0.1 * off["straight"][INNER])
                self.assertLess(off["mixed"][OUTER], 1e-14)
                self.assertLess(largest["mixed"], 1.5 * largest["surrogate"])

    def test_the_surface_metric_uses_analytic_and_surrogate_normals(self):
        metrics = {}
        for name, geometry in (("surrogate", "surrogate"), ("mixed", {"analytic": [sphere(5)]}),
                               ("analytic", {"analytic": [sphere(5), sphere(1, [INNER])]})):
            self.camber("run", self.config("shell", geometry, vtu="run.vtu", report="run.report.json"), "--set",
                        'metric={"surface": {"tangent_size": 0.5, "normal_size": 0.3}}')
            vertices = report_of(self.folder.path / "run.report.json")["mesh"]["vertices"]
            grid = vtu.read(self.folder.path / "run.vtu")
            metrics[name] = grid.point_data["metric"][:vertices]
            radius = np.linalg.norm(grid.points[:vertices], axis=1)
            distances = grid.point_data["distance_to_geometry"]
            self.assertLess(distances[~np.isnan(distances)].max(), 1e-12)
        for other, on in (("analytic", abs(radius - 5) < 1e-9), ("surrogate", abs(radius - 1) < 1e-9)):
            self.assertGreater(on.sum(), 20)
            np.testing.assert_array_equal(metrics["mixed"][on], metrics[other][on])
        self.assertTrue((metrics["surrogate"] != metrics["analytic"]).any())

    # Guards against nodes that slide off a curve within a smooth face.
    def test_nodes_of_a_listed_curve_in_a_plane_face_stay_on_it(self):
        """A square and a line on a plane face: a field that slides nodes within the face leaves those of the curve."""
        mesh = made_meshes.lattice(3, 4)
        number = {tuple(p): i + 1 for i, p in enumerate(mesh.points.astype(int).tolist())}
        corners = [(1, 1), (1, 2), (1, 3), (2, 3), (3, 3), (3, 2), (3, 1), (2, 1)]
        curve = [(*corners[i - 1], 4) for i in range(9)], [(i, 2, 2) for i in range(5)]
        rows = [f"{number[a]} {number[b]} 9" for line in curve for a, b in zip(line, line[1:])]
        text = mesh.text().replace("End\n", f"Edges {len(rows)}\n" + "\n".join(rows) + "\nEnd\n")
        (self.folder.path / "in.mesh").write_text(text)
        self.camber("curve", "in.mesh", "--metric", '{"field": {"polar-1": {}}}', "-o", "out.meshb")
        out = gmf.read(self.folder.path / "out.meshb")
        edges = out.cells["EdgesP2"]
        a, b, node = (out.points[edges.nodes[edges.refs == 9][:, i]] for i in range(3))
        self.assertEqual(len(node), len(rows))
        np.testing.assert_array_equal(node, (a + b) / 2)
        facets = out.cells["TrianglesP2"].nodes
        moved = [np.linalg.norm(out.points[facets[:, 3 + i]] - (out.points[facets[:, i]] + out.points[facets[:, (i + 1) % 3]]) / 2, axis=1)
                 for i in range(3)]
        self.assertGreater(np.max(moved), 1e-3)  # other nodes slide

    def refused(self, code, surfaces, *figures):
        """Expects the exit code of `run` and of `curve`, one line with place and figures, and no new file."""
        geometry = {"analytic": surfaces}
        files = self.folder.files()
        for arguments in (("run", "run.json", "--set", f"geometry={json.dumps(geometry)}"),
                          ("curve", "plain.meshb", "-o", "curved.meshb", "--geometry", json.dumps(geometry))):
            done = self.folder.camber(*arguments)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
            for part in ("/geometry/analytic", *figures):
                self.assertIn(part, done.stderr)
            self.assertEqual(self.folder.files(), files)

    # Guards against analytic surfaces that do not fit the mesh: moved vertices with exit code 0, or minutes of work.
    def test_analytic_surfaces_that_do_not_fit_the_mesh_are_rejected(self):
        self.config("shell", "straight", mesh="run.meshb", report="run-report.json")
        self.camber("run", "run.json", "--set", "stages=[]", "--set", "output/mesh=plain.meshb",
                    "--set", "output/report=")
        points = gmf.read(self.folder.path / "plain.meshb").points
        on_sphere = {n for n, p in enumerate(points, 1) if abs(np.linalg.norm(p) - 5) < 1e-9}
        for what, code, surfaces, figures in (
                ("too small", 3, [sphere(4)], ("analytic/0: vertex ", "is 1 away from the sphere of reference 1")),
                ("the second too large", 3, [sphere(5), sphere(2, [INNER])],
                 ("analytic/1: vertex ", "is 1 away from the sphere of reference 2")),
                ("no such reference", 2, [sphere(5), sphere(5, [7])], ("analytic/1: ", "has reference 7", "it has 1, 2")),
                ("two for one", 2, [sphere(5), sphere(1, [INNER, OUTER])],
                 ("analytic/1: reference 1 is assigned to two surfaces",)),
                ("too large", 2, [sphere(1e300)], ("reference 1", "the radius of its sphere, 1e+300", "at most 1e8")),
                ("beside", 3, [sphere(5, centre=[40, 0, 0])], ("vertex ", "away from the sphere of reference 1")),
                ("a plane", 3, [{"references": [OUTER], "plane": {"point": [5, 0, 0], "normal": [1, 0, 0]}}],
                 ("vertex ", "away from the plane of reference 1"))):
            with self.subTest(what):
                self.refused(code, surfaces, *figures)
        # The farthest vertex by its number in the file.
        message = self.folder.camber("run", "run.json", "--set",
                                  f"geometry={json.dumps({'analytic': [sphere(5, centre=[40, 0, 0])]})}").stderr
        named = int(message.split("vertex ")[1].split(":")[0])
        self.assertIn(named, on_sphere)
        self.assertEqual(named, 1 + max(range(len(points)), key=lambda v: abs(
            np.linalg.norm(points[v] - [40, 0, 0]) - 5) if v + 1 in on_sphere else -1))

    # Guards against unreported vertices off their analytic surface.
    def test_vertices_off_their_analytic_surface_are_reported(self):
        """Vertices may be off by up to a tenth of their edges and are not moved; number and largest distance are
        reported."""
        off = 0.01
        for shape in SHAPES:
            self.config(shape, "straight", mesh="plain.mesh")
            self.camber("run", "run.json", "--set", "stages=[]")
            mesh = gmf.read(self.folder.path / "plain.mesh")
            outer = np.flatnonzero(np.abs(np.linalg.norm(mesh.points[:, :mesh.dim], axis=1) - 5) < 1e-9)[:3]
            lines = (self.folder.path / "plain.mesh").read_text().splitlines()
            first = next(n for n, line in enumerate(lines) if line.split()[:1] == ["Vertices"]) + 1
            first += 0 if len(lines[first - 1].split()) == 2 else 1
            for k, v in enumerate(outer, 1):
                moved = mesh.points[v][:mesh.dim] * (1 + k * off / 5)
                lines[first + v] = " ".join(repr(float(x)) for x in moved) + " " + lines[first + v].split()[-1]
            (self.folder.path / "off.mesh").write_text("\n".join(lines) + "\n")
            geometry = json.dumps({"analytic": [sphere(5)]})
            for name, count in (("plain.mesh", 0), ("off.mesh", 3)):
                done = self.camber("curve", name, "-o", "out.mesh", "--geometry", geometry, "--report", "r.json")
                reported = report_of(self.folder.path / "r.json")
                self.assertEqual(reported["boundary"]["vertices_off_surfaces"], count)
                if count > 0:
                    self.assertAlmostEqual(reported["boundary"]["largest_vertex_distance"], count * off, delta=1e-9)
                note = "3 vertices are not on the analytic surface of their reference, by up to 0.03"
                self.assertEqual(note in done.stderr, count > 0)
                self.assertEqual(note in " ".join(reported["notices"]), count > 0)
                self.assertEqual("vertices off analytic surfaces    3, by up to 0.03" in done.stdout, count > 0)

    def test_boundary_nodes_by_length_and_accuracy_stay_on_their_surfaces(self):
        """The nodes lie on the surfaces, do not depend on threads, and are reported."""
        both = {"analytic": [sphere(5), sphere(1, [INNER])]}
        for shape in SHAPES:
            for by in ("length", "accuracy"):
                with self.subTest(shape=shape, by=by):
                    self.config(shape, both, mesh="placed.meshb", report="placed.json")
                    written = []
                    for threads in ("1", "3"):
                        self.camber("run", "run.json", "--threads", threads, "--set", f"stages/curve/boundary_nodes={by}")
                        written.append((self.folder.path / "placed.meshb").read_bytes())
                    self.assertEqual(*written)
                    self.assertLess(self.off_sphere("placed.meshb", OUTER, 5), 1e-12)
                    self.assertLess(self.off_sphere("placed.meshb", INNER, 1), 1e-12)
                    reported = report_of(self.folder.path / "placed.json")["boundary"]["nodes"]
                    self.assertEqual(reported["criterion"], by)
                    self.assertEqual(reported["edges"], sum(reported[k] for k in ("moved", "no_improvement", "off_geometry", "too_far", "limited_by_elements")))
                    # On a circle the projected middle is the closest point already.
                    if by == "length":
                        self.assertGreater(reported["moved"], 0)
                        self.assertGreater(reported["mean_reduction"], 0)
                    self.assertEqual(reported["off_geometry"], 0)

    def test_the_boundary_of_another_mesh_is_accepted_as_geometry(self):
        """The own boundary gives the surrogate; a finer mesh is closer to the spheres; another body is rejected."""
        def generate(name, size, outer=5):
            self.camber("generate", "shell", "-o", name, "--set", f"inner_size={size}", "--set", f"outer_size={4 * size}",
                        "--set", f"outer_radius={outer}")

        def curve(name, geometry):
            self.camber("curve", "coarse.meshb", "-o", f"{name}.meshb", "--geometry", geometry, "--report", f"{name}.json")
            return self.off_sphere(f"{name}.meshb", OUTER, 5)

        generate("coarse.meshb", 0.6)
        generate("fine.meshb", 0.3)
        generate("small.meshb", 0.5, outer=3)
        own = curve("own", '"surrogate"')
        self.assertAlmostEqual(curve("itself", '{"mesh": "coarse.meshb"}'), own, delta=1e-12)
        self.assertLess(curve("finer", '{"mesh": "fine.meshb"}'), 0.5 * own)
        self.assertEqual(report_of(self.folder.path / "finer.json")["boundary"]["geometry"], "mesh")
        self.camber("generate", "annulus", "-o", "flat.mesh")
        for other, code, message in (("small.meshb", 3, "away from the boundary of the geometry's mesh"),
                                  ("flat.mesh", 2, "is a mesh in 2D"), ("absent.mesh", 3, "absent.mesh")):
            done = self.folder.camber("curve", "coarse.meshb", "-o", "no.meshb", "--geometry",
                                      json.dumps({"mesh": other}))
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(message, done.stderr)
            self.assertFalse((self.folder.path / "no.meshb").exists())

    # Guards against a boundary that drifts because each run takes its own facets as geometry.
    def test_repeated_remeshing_does_not_move_the_boundary_off_its_geometry(self):
        """The geometry is smooth through vertices and nodes, as reported; alternatively that of the first mesh."""
        self.camber("generate", "shell", "-o", "shell.meshb", "--set", "inner_size=0.5", "--set", "outer_size=1",
                    "--set", "outer_radius=2")
        self.camber("curve", "shell.meshb", "-o", "0.meshb")
        at_first = self.off_sphere("0.meshb", OUTER, 2)

        def remesh(before, after, size, *geometry):
            self.camber("remesh", before, "-o", after, "--report", "r.json", "--metric",
                        json.dumps({"expression": {"size": f"{size}*sqrt(x^2+y^2+z^2)"}}), *geometry)
            self.assertLess(self.off_sphere(after, OUTER, 2), 1.5 * at_first)
            return report_of(self.folder.path / "r.json")["boundary"]

        self.assertNotIn("curved_patches", remesh("0.meshb", "1.meshb", 0.4))  # the nodes of curve lie on the surrogate
        reported = remesh("1.meshb", "2.meshb", 0.5)["curved_patches"]
        self.assertEqual((reported["smooth"], reported["as_read"]), (2, 0))
        self.assertLess(reported["largest_angle"], 5)
        self.assertEqual(remesh("1.meshb", "2.meshb", 0.5, "--geometry", '{"mesh": "0.meshb"}')["geometry"], "mesh")

    def test_boundary_nodes_by_length_require_a_metric(self):
        self.config("shell", "surrogate")
        done = self.folder.camber("run", "run.json", "--set", "stages/curve/boundary_nodes=length",
                                  "--set", "stages/curve/objective=shape")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("no metric", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
