#!/usr/bin/env python3
"""Tests of the program with CAD models: a shell, an annulus, a capsule and a plate with a hole."""
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import capsule
import plate

PROGRAM = sys.argv.pop(1)
HERE = pathlib.Path(__file__).parent
MODEL = HERE / "shell.brep"  # between spheres of radii 1 and 5, written by OpenCASCADE
PLATE = HERE / "plate.brep"  # [-1, 1]² × [0, 0.5] with a hole of radius 0.5 along z: see plate.py
HOLE = plate.HOLE
ANNULUS = HERE / "annulus.brep"  # a plane face between circles of radii 1 and 2
CAPSULE = HERE / "capsule.brep"  # a cylinder of radius 1 up to z = 2 with a ball on top; its mesh has one reference


def camber(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)


class Program(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        made = camber("generate", "shell", "-o", cls.path / "shell.mesh")
        assert made.returncode == 0, made.stderr

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def curve(self, *arguments):
        report = self.path / "report.json"
        done = camber("curve", self.path / "shell.mesh", "-o", self.path / "curved.meshb", "--report", report,
                      "--threads", "1", *arguments)
        return done, json.loads(report.read_text()) if done.returncode == 0 else None

    def test_curve_puts_boundary_nodes_on_the_model(self):
        done, report = self.curve("--cad", MODEL)
        self.assertEqual(done.returncode, 0, done.stderr)
        cad = report["boundary"]["cad"]
        self.assertEqual((cad["faces"], cad["matched_faces"]), (2, 2))
        self.assertEqual(cad["ambiguous_facets"] + cad["ambiguous_edges"] + cad["ambiguous_vertices"], 0)
        self.assertLess(cad["largest_vertex_distance"], 1e-12)
        self.assertLess(cad["largest_node_distance"], 1e-12)
        self.assertEqual(report["validity"]["invalid"], 0)
        self.assertIn("distance from the CAD model", done.stdout)

    def plane(self, geometry):
        mesh, config, report = (self.path / name for name in ("annulus.mesh", "plane.json", "plane.report.json"))
        self.assertEqual(camber("generate", "annulus", "--set", "outer_radius=2", "-o", mesh).returncode, 0)
        config.write_text(json.dumps({"input": {"mesh": str(mesh)}, "metric": "natural", "geometry": geometry,
                                      "output": {"mesh": str(self.path / "plane.mesh"), "report": str(report)}}))
        done = camber("run", config)
        self.assertEqual(done.returncode, 0, done.stderr)
        written = json.loads(report.read_text())
        self.assertEqual(written["validity"]["invalid"], 0)
        return written

    def test_2d_mesh_takes_its_geometry_from_a_plane_model(self):
        report = self.plane({"cad": {"file": str(ANNULUS)}})
        cad = report["boundary"]["cad"]
        self.assertEqual([cad[key] for key in ("faces", "matched_faces", "edges", "matched_edges")], [1, 1, 2, 2])
        self.assertLess(cad["largest_vertex_distance"], 1e-14)
        self.assertLess(cad["largest_node_distance"], 1e-14)
        self.assertLess(report["boundary"]["largest_distance"], 0.1 * report["boundary"]["largest_distance_straight"])
        done = camber("geometry", self.path / "plane.mesh", "--cad", ANNULUS, "--json")
        patches = json.loads(done.stdout)["patches"]
        self.assertEqual(sorted({edge for patch in patches for edge in patch["cad_edges"]}), [1, 2])

    def test_plane_model_is_combined_with_an_analytic_circle(self):
        outer = {"references": [1], "sphere": {"centre": [0, 0], "radius": 2}}
        whole = self.plane({"cad": {"file": str(ANNULUS)}})
        mixed = self.plane({"cad": {"file": str(ANNULUS), "analytic": [outer]}})
        self.assertGreater(mixed["boundary"]["cad"]["analytic_facets"], 0)
        self.assertEqual(mixed["boundary"]["cad"]["matched_edges"], 1)
        for key in ("largest_distance_straight", "largest_distance"):
            self.assertAlmostEqual(mixed["boundary"][key], whole["boundary"][key], delta=1e-12)

    def test_config_gives_the_same_mesh_as_the_options(self):
        _, report = self.curve("--cad", MODEL)
        config = self.path / "pipeline.json"
        (self.path / "model.brep").write_bytes(MODEL.read_bytes())
        config.write_text(json.dumps({
            "input": {"mesh": "shell.mesh"}, "geometry": {"cad": {"file": "model.brep", "unit": "mm"}},
            "output": {"mesh": str(self.path / "again.meshb")}}))
        done = camber("run", config)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.path / "again.meshb").read_bytes(), (self.path / "curved.meshb").read_bytes())

    def test_curving_by_blocks_rejects_vertex_moves(self):
        done, _ = self.curve("--cad", MODEL, "--cad-vertices", "move", "--blocks", "500")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("moving vertices onto the CAD model is not supported when curving by blocks", done.stderr)

    def test_blocks_measure_the_boundary_like_the_whole_mesh(self):
        whole, blocks = (self.curve("--cad", MODEL, *by)[1]["boundary"] for by in ((), ("--blocks", "500")))
        for key in ("node_deviation", "vertex_deviation"):
            self.assertEqual((whole[key]["measured"], whole[key]["beyond_tolerance"]), (blocks[key]["measured"], blocks[key]["beyond_tolerance"]))

    def test_remeshing_meets_the_geometry_error_on_a_dome(self):
        """A cylinder with a ball on top; `camber geometry` confirms the reported error."""
        out, report = self.path / "dome.mesh", self.path / "dome.json"
        for error in (0.02, 0.004):
            done = camber("remesh", HERE / "capsule.mesh", "--cad", CAPSULE, "--geometry-error", error, "-o", out,
                          "--report", report)
            self.assertEqual(done.returncode, 0, done.stderr)
            boundary = json.loads(report.read_text())["boundary"]
            self.assertLessEqual(boundary["geometry_error"]["reached"], error)
            self.assertLess(boundary["cad"]["largest_vertex_distance"], 1e-9)
            self.assertEqual(boundary["vertex_deviation"]["beyond_tolerance"], 0)
            distances = json.loads(camber("geometry", out, "--cad", CAPSULE, "--json").stdout)["distances"]
            for direction in ("to_geometry", "to_boundary"):
                self.assertLessEqual(distances[direction]["largest"], error)

    def test_output_does_not_depend_on_the_number_of_threads(self):
        for threads in (1, 3):
            done = camber("curve", self.path / "shell.mesh", "-o", self.path / f"{threads}.meshb", "--cad", MODEL,
                          "--threads", threads)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.path / "1.meshb").read_bytes(), (self.path / "3.meshb").read_bytes())

    def test_remesh_puts_new_vertices_on_the_model(self):
        out = self.path / "remeshed.mesh"
        done = camber("remesh", self.path / "shell.mesh", "-o", out, "--cad", MODEL, "--rounds", "2", "--metric",
                      '{"constant": {"sizes": [0.9]}}')
        self.assertEqual(done.returncode, 0, done.stderr)
        words = out.read_text().split()
        at = words.index("Vertices") + 2
        count = int(words[at - 1])
        points = [tuple(map(float, words[at + 4 * i:at + 4 * i + 3])) for i in range(count)]
        at = words.index("Triangles") + 2
        on_boundary = {int(words[at + 4 * i + k]) for i in range(int(words[at - 1])) for k in range(3)}
        self.assertGreater(len(on_boundary), 300)
        for v in on_boundary:
            r = math.hypot(*points[v - 1])
            self.assertLess(min(abs(r - 1), abs(r - 5)), 1e-12)

    def displaced_nodes(self):
        """Writes the curved shell with every third node of its spheres displaced; returns the file and the nodes."""
        curved = self.path / "curved.mesh"
        done = camber("curve", self.path / "shell.mesh", "-o", curved, "--cad", MODEL)
        self.assertEqual(done.returncode, 0, done.stderr)
        words = curved.read_text().split()
        at = words.index("TrianglesP2") + 2
        nodes = {int(words[at + 7 * i + k]) for i in range(int(words[at - 1])) for k in (3, 4, 5)}
        at = words.index("Vertices") + 2
        for v in sorted(nodes)[::3]:
            for k in range(3):
                words[at + 4 * (v - 1) + k] = repr(float(words[at + 4 * (v - 1) + k]) * 1.02)
        displaced = self.path / "displaced.mesh"
        displaced.write_text(" ".join(words) + "\n")
        return displaced, nodes

    def test_repair_puts_nodes_onto_the_model(self):
        displaced, nodes = self.displaced_nodes()
        out, report = self.path / "repaired.mesh", self.path / "repair.json"
        done = camber("repair", displaced, "-o", out, "--cad", MODEL, "--report", report)
        self.assertEqual(done.returncode, 0, done.stderr)
        result = json.loads(report.read_text())
        self.assertLess(result["boundary"]["cad"]["largest_node_distance"], 1e-12)
        self.assertEqual(result["validity"]["invalid"], 0)
        self.assertEqual(result["relax"]["relaxed_surface_edges"], 0)
        words = out.read_text().split()
        at = words.index("Vertices") + 2
        for v in nodes:
            r = math.hypot(*map(float, words[at + 4 * (v - 1):at + 4 * (v - 1) + 3]))
            self.assertLess(min(abs(r - 1), abs(r - 5)), 1e-12)
        again = self.path / "again.mesh"
        self.assertEqual(camber("repair", out, "-o", again, "--cad", MODEL).returncode, 0)
        self.assertEqual(out.read_bytes(), again.read_bytes())

    def test_remesh_keeps_smooth_edges_of_the_model(self):
        out = self.path / "capsule.mesh"
        done = camber("remesh", HERE / "capsule.mesh", "-o", out, "--cad", CAPSULE, "--rounds", "2", "--metric",
                      '{"constant": {"sizes": [0.4]}}')
        self.assertEqual(done.returncode, 0, done.stderr)
        words = out.read_text().split()
        rows = lambda name, width: [words[words.index(name) + 2 + width * i:][:width]
                                    for i in range(int(words[words.index(name) + 1]))]
        points = [tuple(map(float, row[:3])) for row in rows("Vertices", 4)]
        on = {v for v, p in enumerate(points, 1) if abs(p[2] - 2) < 1e-12 and abs(math.hypot(*p[:2]) - 1) < 1e-12}
        facets = [tuple(map(int, row[:3])) for row in rows("Triangles", 4)]
        edges = {frozenset(pair) for a, b, c in facets for pair in ((a, b), (b, c), (c, a)) if on.issuperset(pair)}
        self.assertGreater(len(on), 12)
        self.assertEqual(len(edges), len(on))  # the edges form a closed circle
        for facet in facets:  # each facet is on one side of the circle
            heights = [points[v - 1][2] - 2 for v in facet if v not in on]
            self.assertTrue(all(z > 0 for z in heights) or all(z < 0 for z in heights))

    def test_facets_across_a_smooth_edge_join_its_faces(self):
        report = self.path / "joined.json"
        curve = lambda mesh: camber("curve", mesh, "-o", self.path / "joined.mesh", "--cad", CAPSULE, "--report", report)
        done = curve(HERE / "capsule.mesh")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("virtual_faces", json.loads(report.read_text())["boundary"]["cad"])
        mesh = self.path / "across.mesh"
        mesh.write_text(capsule.across_circle())
        done = curve(mesh)
        self.assertEqual(done.returncode, 0, done.stderr)
        cad = json.loads(report.read_text())["boundary"]["cad"]
        self.assertEqual([len(faces) for faces in cad["virtual_faces"]], [2])
        self.assertEqual(cad["ambiguous_edges"] + cad["ambiguous_vertices"], 0)
        self.assertLess(cad["largest_vertex_distance"], 1e-9)
        self.assertLess(cad["largest_node_distance"], 1e-9)
        self.assertNotIn("facets_across_ridges", cad)
        done = camber("geometry", mesh, "--cad", CAPSULE, "--json")
        self.assertEqual(json.loads(done.stdout)["cad"]["virtual_faces"], cad["virtual_faces"])

    def plate(self, off=0.0):
        """Writes the plate's mesh with boundary vertices displaced by up to `off` in each coordinate."""
        points, tetrahedra, triangles = plate.plate()
        numbers, boundary = random.Random(1), {v for t in triangles for v in t[:3]}
        points = [tuple(c + (numbers.uniform(-off, off) if v in boundary else 0) for c in p) for v, p in enumerate(points)]
        path = self.path / f"plate-{off}.mesh"
        path.write_text(plate.text(points, tetrahedra, triangles))
        return path

    def curve_plate(self, *arguments, mesh=None, out="plate-p2.mesh"):
        report = self.path / "plate.json"
        done = camber("curve", mesh or self.plate(), "-o", self.path / out, "--report", report, "--threads", "1",
                      *arguments)
        return done, json.loads(report.read_text()) if done.returncode == 0 else None

    def nodes_of(self, path, reference):
        """Returns the nodes of the facets of a reference."""
        words = path.read_text().split()
        at = words.index("Vertices") + 2
        point = lambda v: tuple(map(float, words[at + 4 * (v - 1):at + 4 * v - 1]))
        first = words.index("TrianglesP2") + 2
        rows = [words[first + 7 * i:first + 7 * i + 7] for i in range(int(words[first - 1]))]
        return [point(int(v)) for row in rows if row[6] == str(reference) for v in row[:6]]

    def assert_on_plate(self, path):
        for x, y, z in self.nodes_of(path, 7):
            self.assertLess(abs(math.hypot(x, y) - 0.5), 1e-14)
        for reference, axis, value in ((1, 0, -1), (2, 0, 1), (3, 1, -1), (4, 1, 1), (5, 2, 0), (6, 2, 0.5)):
            for p in self.nodes_of(path, reference):
                self.assertLess(abs(p[axis] - value), 1e-14)

    def test_analytic_hole_is_combined_with_the_model(self):
        done, report = self.curve_plate("--cad", PLATE, "--geometry", json.dumps({"analytic": [HOLE]}), "--set",
                                        "output/distances=both")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_on_plate(self.path / "plate-p2.mesh")
        cad = report["boundary"]["cad"]
        self.assertEqual([cad[k] for k in ("facets", "analytic_facets", "surrogate_facets", "matched_faces")],
                         [192, 64, 0, 6])
        self.assertIn("distance from the geometry", done.stdout)
        entities = report["boundary"]["distances"]["entities"]
        self.assertEqual(sum(e["kind"] == "face" for e in entities), 6)
        self.assertEqual([e["number"] for e in entities if e["kind"] == "surface"], [1])
        rims = [e["side_geometries"] for e in entities if "side_geometries" in e]
        self.assertEqual(len(rims), 2)
        for surface, face in rims:
            self.assertEqual((surface, face[:5]), ("surface 1", "face "))
        self.assertIn(f"CAD model {PLATE}, analytic surfaces", done.stdout)
        # The CAD model alone gives the same mesh up to rounding.
        self.curve_plate("--cad", PLATE, out="whole.mesh")
        for reference in range(1, 8):
            for p, q in zip(self.nodes_of(self.path / "plate-p2.mesh", reference),
                            self.nodes_of(self.path / "whole.mesh", reference)):
                self.assertLess(math.dist(p, q), 1e-14)

    def test_references_select_model_analytic_surface_or_surrogate(self):
        geometry = {"cad": {"file": str(PLATE), "references": [7, 5], "analytic": [
            {"references": [6], "plane": {"point": [0, 0, 0.5], "normal": [0, 0, 1]}}]}}
        done, report = self.curve_plate("--geometry", json.dumps(geometry), "--set", "output/distances=both")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_on_plate(self.path / "plate-p2.mesh")
        cad = report["boundary"]["cad"]
        self.assertEqual([cad[k] for k in ("facets", "analytic_facets", "surrogate_facets", "matched_faces")],
                         [128, 64, 64, 2])
        self.assertIn(f"CAD model {PLATE}, analytic surfaces, surrogate", done.stdout)
        self.assertEqual({e["kind"] for e in report["boundary"]["distances"]["entities"]} - {"curve", "edge", "ridge"},
                         {"face", "surface", "patch"})

    # Guards against accepted CAD models that lack a face of the mesh.
    def test_surrogate_continues_the_model_within_a_hole(self):
        """Where both meet, the surrogate has the normals of the model."""
        points, tetrahedra, triangles = plate.plate(n=6, layers=3)
        split = [(*t[:3], 8 if t[3] == 7 and sum(points[v][0] - points[v][1] for v in t[:3]) > 0 else t[3]) for t in triangles]
        mesh = self.path / "parts.mesh"
        mesh.write_text(plate.text(points, tetrahedra, split))
        def off(geometry):
            done, _ = self.curve_plate("--geometry", json.dumps(geometry), mesh=mesh)
            self.assertEqual(done.returncode, 0, done.stderr)
            nodes = self.nodes_of(self.path / "plate-p2.mesh", 8)
            return max(abs(math.hypot(x, y) - 0.5) for x, y, _ in nodes)
        alone, beside = off("surrogate"), off({"cad": {"file": str(PLATE), "references": list(range(1, 8))}})
        self.assertLess(beside, 0.4 * alone)

    def sheet(self, across, name, is_required=True):
        """Writes the plate's mesh with facets of reference 50 at the inner faces selected by `across(points)`."""
        points, tetrahedra, triangles = plate.plate(rings=4)
        faces = {}
        for t in tetrahedra:
            for left_out in range(4):
                face = t[:left_out] + t[left_out + 1:]
                faces.setdefault(tuple(sorted(face)), []).append(face)
        inner = [(*f[0], 50) for f in faces.values() if len(f) == 2 and across([points[v] for v in f[0]])]
        self.assertGreater(len(inner), 4)
        numbers = range(len(triangles) + 1, len(triangles) + len(inner) + 1)
        required = f"RequiredTriangles\n{len(inner)}\n" + "".join(f"{n}\n" for n in numbers) if is_required else ""
        path = self.path / name
        path.write_text(plate.text(points, tetrahedra, triangles + inner).replace("End", required + "End"))
        return path, inner, points

    def test_sheets_within_one_material_have_no_cad_geometry(self):
        """A sheet that ends inside and one that meets the model's faces, curved, remeshed and adapted."""
        sheets = {"inside": lambda p: all(abs(z - 0.25) < 1e-9 and 0.51 < max(abs(x), abs(y)) < 0.88 for x, y, z in p),
                  "across": lambda p: all(abs(z - 0.25) < 1e-9 for x, y, z in p)}
        for name, across in sheets.items():
            # Required facets keep the nodes of their edges, also at the hole.
            mesh, inner, points = self.sheet(across, f"{name}.mesh", is_required=name == "inside")
            done, report = self.curve_plate("--cad", PLATE, mesh=mesh)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("reference 50: the facets lie within one material and not on the CAD model", done.stderr)
            cad = report["boundary"]["cad"]
            self.assertEqual((cad["references_within_materials"], cad["surrogate_facets"]), ([50], len(inner)))
            self.assert_on_plate(self.path / "plate-p2.mesh")
            self.assertEqual(report["validity"]["invalid"], 0)
            places = {tuple(points[v]) for t in inner for v in t[:3]}
            for verb in (("remesh", "--metric", "0.3", "--geometry-error", "0.05"),
                         ("adapt", "--field", "tanh((x-0.7)/0.3)", "--complexity", "60", "--cycles", "1")):
                out = self.path / f"{name}-{verb[0]}.mesh"
                done = camber(verb[0], mesh, "--cad", PLATE, "-o", out, *verb[1:])
                self.assertIn(done.returncode, (0, 1), done.stderr)
                self.assertIn("reference 50", done.stderr)
                checked = json.loads(camber("check", out, "--json").stdout)
                self.assertEqual(checked["invalid"], 0)
                words = out.read_text().split()
                at = words.index("Vertices") + 2
                written = {tuple(map(float, words[at + 4 * v:at + 4 * v + 3])) for v in range(int(words[at - 1]))}
                if name == "inside":
                    self.assertLessEqual(places, written)

    def test_boundaries_and_interfaces_off_the_model_are_rejected(self):
        """A wall that the model lacks, and an interface between two materials."""
        points, tetrahedra, triangles = plate.plate(rings=4)
        mesh = self.path / "wall.mesh"
        mesh.write_text(plate.text([(x, y, z * (1.4 if z > 0.4 else 1)) for x, y, z in points], tetrahedra, triangles))
        done, _ = self.curve_plate("--cad", PLATE, mesh=mesh)
        self.assertEqual(done.returncode, 3)
        self.assertIn("do not lie on it", done.stderr)
        _, inner, _ = self.sheet(lambda p: all(abs(z - 0.25) < 1e-9 for x, y, z in p), "unused.mesh")
        text = plate.text(points, tetrahedra, triangles + inner).split("Tetrahedra\n")
        rows = text[1].split("\n")
        for i, t in enumerate(tetrahedra, 1):
            if sum(points[v][2] for v in t) > 1:
                rows[i] = rows[i].rsplit(" ", 1)[0] + " 2"
        mesh.write_text(text[0] + "Tetrahedra\n" + "\n".join(rows))
        done, _ = self.curve_plate("--cad", PLATE, mesh=mesh)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("triangles in the sample do not lie on it", done.stderr)

    def test_lines_within_one_material_have_no_cad_geometry(self):
        """An arc of edges within an annulus, away from the circles of the model."""
        mesh, lines = self.path / "lines.mesh", self.path / "lines-p2.mesh"
        finer = ("--set", "inner_size=0.25", "--set", "outer_size=0.25")
        self.assertEqual(camber("generate", "annulus", "--set", "outer_radius=2", *finer, "-o", mesh).returncode, 0)
        words = mesh.read_text().split()
        at, triangles = words.index("Vertices") + 2, words.index("Triangles") + 2
        place = lambda v: [float(c) for c in words[at + 3 * (v - 1):at + 3 * v - 1]]
        sides = {}
        for t in range(int(words[triangles - 1])):
            a, b, c = map(int, words[triangles + 4 * t:triangles + 4 * t + 3])
            for side in ((a, b), (b, c), (c, a)):
                sides.setdefault(tuple(sorted(side)), 0)
        inner = [s for s in sides if all(1.2 < math.hypot(*place(v)) < 1.8 and place(v)[0] > 0 for v in s)][:4]
        self.assertEqual(len(inner), 4)
        edges = words.index("Edges") + 1
        count = int(words[edges])
        rows = words[edges + 1:edges + 1 + 3 * count] + [str(w) for s in inner for w in (*s, 50)]
        words[edges:edges + 1 + 3 * count] = [str(count + 4), *rows, "RequiredEdges", "4", *(str(count + 1 + i) for i in range(4))]
        mesh.write_text(" ".join(words) + "\n")
        done = camber("curve", mesh, "--cad", ANNULUS, "-o", lines)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("reference 50: the facets lie within one material", done.stderr)
        for verb in (("adapt", "--field", "tanh((y-0.5)/0.1)", "--complexity", "80", "--cycles", "2"),
                     ("remesh", "--metric", "0.3")):
            done = camber(verb[0], mesh, "--cad", ANNULUS, "-o", lines, *verb[1:])
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("reference 50", done.stderr)
        done = camber("geometry", mesh, "--cad", ANNULUS, "--json")
        self.assertEqual(json.loads(done.stdout)["cad"]["references_within_materials"], [50])

    def test_layers_that_end_at_plane_walls_are_valid(self):
        """The first layer is a seventh of the wall's sagitta, so nodes in the planes must move with the inner ones."""
        mesh = self.path / "layers.mesh"
        mesh.write_text(plate.text(*plate.plate(rings=12, growth=1.5)))
        for objective in ("accuracy", "shape"):
            done, report = self.curve_plate("--cad", PLATE, "--objective", objective, mesh=mesh, out="layers-p2.mesh")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(report["validity_before_correction"]["invalid"], 0, objective)
            self.assertGreater(report["validity_before_correction"]["min_scaled_jacobian"], 0.1, objective)
            self.assert_on_plate(self.path / "layers-p2.mesh")

    def test_vertices_are_moved_onto_the_model(self):
        mesh = self.plate(off=2e-3)
        for beside in ([], [HOLE]):
            geometry = {"file": str(PLATE), "vertices": "move", "analytic": beside}
            done, report = self.curve_plate("--geometry", json.dumps({"cad": geometry}), mesh=mesh)
            self.assertEqual(done.returncode, 0, done.stderr)
            cad = report["boundary"]["cad"]
            self.assertGreater(cad["moved_vertices"], 100)
            self.assertEqual(cad["partly_moved_vertices"], 0)
            self.assertLess(cad["largest_vertex_move"], 4e-3)
            self.assertLess(cad["largest_vertex_distance"], 1e-12)
            self.assertEqual(report["validity"]["invalid"], 0)
        done, report = self.curve_plate("--cad", PLATE, mesh=mesh)
        self.assertNotIn("moved_vertices", report["boundary"]["cad"])
        self.assertGreater(report["boundary"]["cad"]["largest_vertex_distance"], 1e-3)
        # The same for a mesh of degree 2.
        out = self.path / "repaired-plate.mesh"
        done = camber("repair", self.path / "plate-p2.mesh", "-o", out, "--geometry",
                      json.dumps({"cad": {"file": str(PLATE), "vertices": "move"}}))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_on_plate(out)

    def test_mesh_with_another_hole_radius_is_rejected_or_moved(self):
        for radius, fits in ((0.5, True), (0.495, True), (0.48, False), (0.55, False), (0.6, False)):
            with self.subTest(radius=radius):
                mesh = self.path / f"hole-{radius}.mesh"
                mesh.write_text(plate.text(*plate.plate(radius=radius)))
                done, report = self.curve_plate("--cad", PLATE, mesh=mesh)
                self.assertEqual(done.returncode, 0 if fits else 3, done.stderr)
                if not fits:
                    self.assertRegex(done.stderr, r"vertex \d+: is 0\.\d+ away from CAD face \d+, [\d.]+ % of the shortest boundary edge")
                    self.assertRegex(done.stderr, r"48 of the 48 vertices of the mesh on CAD face \d+ are off by more than 5 %")
                    self.assertIn("--cad-vertices move", done.stderr)
                    self.assertEqual(len(done.stderr.strip().splitlines()), 1)
                    measured = camber("geometry", mesh, "--cad", PLATE)
                    self.assertEqual(measured.returncode, 0, measured.stderr)
                    self.assertIn("does not fit the CAD model", measured.stderr)
                done, report = self.curve_plate("--cad", PLATE, "--cad-vertices", "move", mesh=mesh)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(report["validity"]["invalid"], 0)
                self.assertEqual(report["boundary"]["cad"]["moved_vertices"] > 0, radius != 0.5)
                self.assertLess(report["boundary"]["cad"]["largest_vertex_distance"], 1e-12)
                self.assert_on_plate(self.path / "plate-p2.mesh")

    def test_2d_mesh_of_another_radius_is_rejected_or_moved(self):
        mesh, out = self.path / "wide.mesh", self.path / "wide-p2.mesh"
        self.assertEqual(camber("generate", "annulus", "--set", "outer_radius=2.4", "-o", mesh).returncode, 0)
        done = camber("curve", mesh, "-o", out, "--cad", ANNULUS)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertRegex(done.stderr, r"away from CAD edge \d, .* vertices of the mesh on CAD edge \d are off by more than 5 %")
        self.assertIn("--cad-vertices move", done.stderr)
        done = camber("curve", mesh, "-o", out, "--cad", ANNULUS, "--cad-vertices", "move", "--report", self.path / "wide.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        report = json.loads((self.path / "wide.json").read_text())
        self.assertGreater(report["boundary"]["cad"]["moved_vertices"], 0)
        self.assertLess(report["boundary"]["cad"]["largest_vertex_distance"], 1e-12)
        self.assertEqual(report["validity"]["invalid"], 0)

    def test_invalid_references_are_rejected(self):
        def check_rejected(cad, message, code=2):
            done, _ = self.curve_plate("--geometry", json.dumps({"cad": {"file": str(PLATE)} | cad}))
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(message, done.stderr)
        check_rejected({"references": [7, 7]}, "/geometry/cad/references/1: reference 7 is named twice")
        check_rejected({"references": [7, 9]}, "no boundary triangle of the mesh has reference 9")
        check_rejected({"references": [7], "analytic": [HOLE]}, "reference 7 also has an analytic surface")
        check_rejected({"analytic": [HOLE, HOLE]}, "/geometry/cad/analytic/1")
        check_rejected({"analytic": [HOLE | {"references": list(range(1, 8))}]}, "/geometry/cad/analytic/0", 3)
        check_rejected({"references": [5, 7], "unit": "m"}, "give that as the unit", 3)
        check_rejected({"references": [5, 7], "unit": "um"}, "give that as the unit", 3)

    def error_of(self, code, *arguments):
        done, _ = self.curve(*arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def test_invalid_cad_files_and_options_are_rejected(self):
        self.assertIn("give that as the unit", self.error_of(3, "--cad", MODEL, "--cad-unit", "m"))
        self.assertIn("cannot be opened", self.error_of(3, "--cad", self.path / "none.step"))
        self.assertIn("no CAD format", self.error_of(2, "--cad", self.path / "shell.mesh"))
        self.assertIn("give one of them", self.error_of(2, "--cad", MODEL, "--geometry", "straight"))
        self.assertIn("give --cad too", self.error_of(2, "--cad-unit", "mm"))
        self.assertIn("give --cad too", self.error_of(2, "--cad-vertices", "move"))
        broken = self.path / "broken.brep"
        broken.write_bytes(MODEL.read_bytes()[:700])
        self.assertIn("broken", self.error_of(3, "--cad", broken))

    def test_unit_of_the_mesh_is_found_from_its_boundary(self):
        """The model is in millimetres; meshes scaled by 1 and 1e-3 are in mm and m."""
        lines = (self.path / "shell.mesh").read_text().split("\n")
        first = lines.index("Vertices") + 2
        for scale, unit in ((1, "mm"), (1e-3, "m"), (0.5, None)):
            scaled = list(lines)
            for i in range(first, first + int(lines[first - 1])):
                *point, reference = lines[i].split()
                scaled[i] = " ".join([*(repr(scale * float(x)) for x in point), reference])
            mesh, report = self.path / "scaled.mesh", self.path / "scaled.json"
            mesh.write_text("\n".join(scaled))
            done = camber("curve", mesh, "-o", self.path / "scaled.meshb", "--report", report, "--cad", MODEL)
            inspected = camber("geometry", mesh, "--cad", MODEL, "--json")
            if unit is None:
                self.assertEqual((done.returncode, inspected.returncode), (3, 3))
                self.assertIn("If the file's unit is not the mesh's, give the mesh's unit", done.stderr)
                continue
            self.assertEqual((done.returncode, inspected.returncode), (0, 0), done.stderr + inspected.stderr)
            for cad in (json.loads(report.read_text())["boundary"]["cad"], json.loads(inspected.stdout)["cad"]):
                self.assertEqual((cad["unit"], cad["unit_found"]), (unit, scale != 1))
                self.assertLess(cad["largest_vertex_distance"], 1e-12)
            row = "m, detected from the boundary; the CAD file is in mm"
            self.assertEqual(row in done.stdout, scale != 1)
            # The requested unit is used even if another one fits.
            self.assertIn("give that as the unit" if scale != 1 else "",
                          camber("curve", mesh, "-o", self.path / "x.meshb", "--cad", MODEL, "--cad-unit", "file").stderr)

    # Guards against damaged model edges that move vertices by several times the size of the part.
    def test_model_with_a_displaced_edge_is_rejected(self):
        """All faces fit, but the edge between two of them is displaced by 11 along its line."""
        self.path.joinpath("plate.mesh").write_text(plate.text(*plate.plate()))
        moved = self.path / "moved.brep"
        text = PLATE.read_text()
        self.assertIn("1 -1 -1 0 -0 1 0 ", text)
        moved.write_text(text.replace("1 -1 -1 0 -0 1 0 ", "1 -1 -12 0 -0 1 0 ", 1))
        done = camber("curve", self.path / "plate.mesh", "-o", self.path / "plate-p2.mesh", "--cad", moved)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("from the CAD edges between their CAD faces", done.stderr)

    def test_2d_mesh_requires_a_plane_model(self):
        flat = self.path / "flat.mesh"
        self.assertEqual(camber("generate", "annulus", "-o", flat).returncode, 0)
        done = camber("curve", flat, "-o", self.path / "flat-p2.mesh", "--cad", MODEL)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("in one plane z = constant", done.stderr)


if __name__ == "__main__":
    unittest.main()
