"""`camber adapt` and its configs: cycles with a test solver, their folders and errors.

    python3 tests/pipelines/test_adapt.py build/bin/camber [unittest arguments]
"""
import json
import signal
import subprocess
import sys
import time
import unittest

import numpy as np

from program import CAMBER, ROOT, SANITIZED, Folder, report_of

import gmf  # of the oracle

FIELD = "tanh((sqrt(x^2+y^2)-0.5)/0.05)"
# Solver that writes the exact solution at all points of the mesh file.
SOLVER = """
import sys
import numpy as np
sys.path.insert(0, {oracle!r})
import gmf
mesh, solution = sys.argv[1:3]
points = gmf.read(mesh).points
x, y = points[:, 0], points[:, 1]
u = np.tanh((np.hypot(x, y) - 0.5) / 0.05)
with open(solution, "w") as out:
    out.write(f"MeshVersionFormatted 2\\nDimension {{points.shape[1]}}\\nSolAtVertices\\n{{len(u)}}\\n1 1\\n")
    out.writelines(f"{{v!r}}\\n" for v in u.tolist())
    out.write("End\\n")
print("solved", len(u))
"""


class Adapting(Folder):
    """A folder with a mesh of a square and a solver."""

    def __init__(self, cells=6):
        super().__init__()
        (self.path / "solver.py").write_text(SOLVER.format(oracle=str(ROOT / "tests" / "oracle")))
        assert self.camber("generate", "rectangle", "-o", "r.mesh", "--set", f"cells=[{cells},{cells}]").returncode == 0

    def __enter__(self):
        return self

    def solver(self, more=""):
        return f"{sys.executable} solver.py {{mesh}} {{solution}}{more}"

    def adapt(self, *more, mesh="r.mesh", output="n.meshb", complexity="40", **options):
        return self.camber("adapt", mesh, "-o", output, "--complexity", complexity, *more, **options)

    def rows(self, folder):
        return json.loads((self.path / folder / "cycles.json").read_text())["cycles"]

    def check(self, mesh, *more):
        done = self.camber("check", mesh, "--json", *more)
        return json.loads(done.stdout)


class Cycles(unittest.TestCase):
    def test_adapt_reduces_the_error_of_a_field_in_2d_for_degrees_1_and_2(self):
        with Adapting() as folder:
            for degree in (1, 2):
                done = folder.adapt("--field", FIELD, "--degree", degree, "--folder", f"d{degree}", "--cycles", 5)
                self.assertEqual(done.returncode, 0, done.stderr)
                rows = folder.rows(f"d{degree}")
                errors = [row["interpolation_error"]["l2"] for row in rows]
                self.assertLess(errors[-1], errors[0] / (20 if degree == 2 else 2))
                checked = folder.check("n.meshb", "--field", FIELD)
                self.assertEqual(checked["degree"], degree)
                self.assertEqual(checked["invalid"] if degree == 2 else 0, 0)
                self.assertIn("cycle", done.stdout)
            self.assertNotIn(".camber-cycles", " ".join(folder.files()))

    def test_cycles_report_the_interpolation_errors_of_check(self):
        with Adapting() as folder:
            self.assertEqual(folder.adapt("--field", FIELD, "--folder", "c", "--cycles", 2).returncode, 0)
            reported = folder.rows("c")[-1]["interpolation_error"]
            found = folder.check("n.meshb", "--field", FIELD)["interpolation"][0]
            self.assertAlmostEqual(reported["l2"] / found["curved"]["l2"]["value"], 1, delta=3e-3)
            self.assertAlmostEqual(reported["h1"] / found["curved"]["h1"]["value"], 1, delta=3e-3)

    @unittest.skipIf(SANITIZED, "the same paths as in 2D")
    def test_straight_meshes_report_errors_of_quadratic_interpolants_for_metric_degree_2(self):
        with Adapting() as folder:
            done = folder.adapt("--field", FIELD, "--degree", 1, "--set", "metric/solution/degree=2", "--folder", "c",
                                "--cycles", 3, "--convergence-tolerance", 0, "--result", "last")
            self.assertEqual(done.returncode, 0, done.stderr)
            reported = folder.rows("c")[-1]["interpolation_error"]
            self.assertEqual(folder.camber("convert", "n.meshb", "--elevate", "-o", "two.meshb").returncode, 0)
            checked = folder.check("two.meshb", "--field", FIELD)["interpolation"][0]["curved"]
            for key in ("l2", "h1"):
                self.assertAlmostEqual(reported[key] / checked[key]["value"], 1, delta=1e-2)

    def test_adapt_in_3d_writes_no_invalid_tetrahedra(self):
        with Adapting() as folder:
            folder.camber("generate", "box", "-o", "b.meshb", "--set", "cells=[3,3,3]")
            done = folder.camber("adapt", "b.meshb", "--field", "tanh((x+y+z-1.5)/0.3)", "--complexity", 30, "-o",
                                 "n.meshb", "--cycles", 2, "--folder", "c")
            self.assertEqual(done.returncode, 0, done.stderr)
            checked = json.loads(folder.camber("check", "n.meshb", "--json").stdout)
            self.assertEqual(checked["invalid"], 0)

    def test_adapt_accepts_a_metric_instead_of_a_solution(self):
        with Adapting() as folder:
            done = folder.adapt("--metric", "0.2", "--degree", 1, "--cycles", 2)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((folder.path / "n.meshb").exists())

    def test_a_solution_file_is_transferred_and_allows_one_cycle_only(self):
        with Adapting() as folder:
            subprocess.run([sys.executable, "solver.py", "r.mesh", "u.sol"], cwd=folder.name, check=True, capture_output=True)
            done = folder.adapt("--solution", "u.sol", "--degree", 1, "--output-solution", "v.sol")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((folder.path / "v.sol").exists())
            more = folder.adapt("--solution", "u.sol", "--cycles", 2)
            self.assertEqual(more.returncode, 2)
            self.assertIn("first mesh only", more.stderr)


S_FRONT = "tanh((y-0.5-0.25*tanh(6*(x-0.5)))/0.01)"


class Errors(unittest.TestCase):
    def test_errors_at_an_oblique_front_stay_at_those_of_aligned_meshes(self):
        """Nodes must not slide across the front. The bounds are the errors of structured meshes aligned with it."""
        with Adapting(cells=16) as folder:
            done = folder.adapt("--field", S_FRONT, "--folder", "c", "--cycles", 7, "--convergence-tolerance", 0, complexity="600")
            self.assertEqual(done.returncode, 0, done.stderr)
            for row in folder.rows("c")[5:]:
                size = row["unknowns"] / 3000
                self.assertLess(row["interpolation_error"]["l2"] * size ** 1.5, 1.2e-5)
                self.assertLess(row["interpolation_error"]["h1"] * size, 4.2e-2)

    def test_errors_at_a_layer_in_one_material_do_not_jump_between_cycles(self):
        """The interface must get the sizes of the finer side."""
        with Adapting(cells=10) as folder:
            mesh = gmf.read(folder.path / "r.mesh")
            lines = (folder.path / "r.mesh").read_text().split("\n")
            first = lines.index("Triangles") + 2
            vertices = {1: set(), 2: set()}  # vertices of each material
            for k in range(int(lines[first - 1])):
                row = [int(v) for v in lines[first + k].split()[:3]]
                material = 1 if np.mean([mesh.points[v - 1][0] for v in row]) < 0.5 else 2
                vertices[material].update(row)
                lines[first + k] = " ".join(map(str, [*row, material]))
            first = lines.index("Vertices") + 2
            for v in vertices[1] & vertices[2]:
                lines[first + v - 1] = " ".join(["0.5", *lines[first + v - 1].split()[1:]])
            (folder.path / "two.mesh").write_text("\n".join(lines))
            layer = "x<0.5 ? sin(3*x)*cos(2*y) : sin(3*x)*cos(2*y)+1-exp(-(x-0.5)*(1+y)/0.01)"
            done = folder.adapt("--field", layer, "--folder", "c", "--cycles", 10, "--convergence-tolerance", 0, mesh="two.mesh",
                                complexity="300")
            self.assertEqual(done.returncode, 0, done.stderr)
            errors = [row["interpolation_error"]["l2"] for row in folder.rows("c")[4:]]
            self.assertLess(max(errors), 5 * np.median(errors))
            self.assertLess(np.median(errors), 8e-6)

    def test_the_expected_error_scales_with_the_unit_of_the_solution(self):
        for unit in (1, 3, 1e-9, 1e9):
            with Adapting(cells=12) as folder:
                solver = (folder.path / "solver.py").read_text().replace("u = np", f"u = {unit} * np")
                (folder.path / "solver.py").write_text(solver)
                done = folder.adapt("--solve", folder.solver(), "--field", f"{unit}*{FIELD}", "--mesh-file", "m.mesh",
                                    "--cycles", 5, "--convergence-tolerance", 0, complexity="150")
                self.assertEqual(done.returncode, 0, done.stderr)
                for row in folder.rows("n.cycles")[4:]:
                    share = row["expected_error"] / row["interpolation_error"]["l2"]
                    self.assertTrue(1 / 1.5 < share < 1.5, (unit, share))

    def test_the_result_is_the_mesh_with_the_least_error(self):
        with Adapting(cells=10) as folder:
            for result in ("best", "last"):
                done = folder.adapt("--field", S_FRONT, "--folder", result, "--cycles", 8, "--convergence-tolerance", 0, "--result",
                                    result, "--report", f"{result}.json", complexity="60,120",
                                    output=f"{result}.meshb")
                self.assertEqual(done.returncode, 0, done.stderr)
                rows = folder.rows(result)
                errors = [row["interpolation_error"]["l2"] for row in rows]
                cycle = 2 + int(np.argmin(errors[2:])) if result == "best" else 8
                self.assertEqual("the result is the mesh of cycle" in done.stderr, cycle < 8)
                stored = folder.path / result / f"cycle-{cycle:03}"
                self.assertEqual((folder.path / f"{result}.meshb").read_bytes(), (stored / "mesh.meshb").read_bytes())
                self.assertEqual((folder.path / f"{result}.json").read_text(), (stored / "report.json").read_text())

    def test_cycles_end_when_the_error_stops_falling(self):
        with Adapting(cells=10) as folder:
            done = folder.adapt("--field", S_FRONT, "--folder", "c", "--cycles", 30, complexity="100")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("converged: the minimum error", done.stdout)
            errors = [row["interpolation_error"]["l2"] for row in folder.rows("c")]
            self.assertLess(len(errors), 25)
            self.assertGreater(min(errors[1:]), 0.9 * min(errors[1:-2]))

    def test_resuming_after_the_best_cycle_returns_its_mesh(self):
        with Adapting() as folder:
            solve = ("--solve", folder.solver(), "--field", FIELD, "--mesh-file", "m.mesh", "--convergence-tolerance", 0)
            self.assertEqual(folder.adapt(*solve, "--cycles", 6).returncode, 0)
            whole = (folder.path / "n.meshb").read_bytes()
            (folder.path / "n.meshb").unlink()
            self.assertEqual(folder.adapt(*solve, "--cycles", 6, "--from", 5).returncode, 0)
            self.assertEqual((folder.path / "n.meshb").read_bytes(), whole)

    def test_norm_h1_equals_norm_2_of_gradients_and_rejects_error_of_values(self):
        with Adapting() as folder:
            configs = [folder.adapt("--field", FIELD, "--print-config", *norm).stdout
                       for norm in (("--norm", "H1"), ("--norm", 2, "--error-of", "gradients"))]
            self.assertEqual(*configs)
            self.assertIn("gradients", configs[0])
            both = folder.adapt("--field", FIELD, "--norm", "H1", "--error-of", "values")
            self.assertEqual(both.returncode, 2)
            self.assertIn("remove --error-of values", both.stderr)
            wrong = folder.adapt("--field", FIELD, "--norm", "H2")
            self.assertEqual(wrong.returncode, 2)
            self.assertIn("--norm", wrong.stderr)


LAYER = "exp(-(sqrt(x^2+y^2)-1)/0.05)"
CIRCLES = json.dumps({"analytic": [{"references": [2], "sphere": {"radius": 1}},
                                   {"references": [1], "sphere": {"radius": 2}}]})


class CurvedWalls(unittest.TestCase):
    def ring(self, folder):
        folder.camber("generate", "annulus", "--elements", 200, "--set", "outer_radius=2", "-o", "ring.mesh")

    def wall(self, folder, mesh):
        """The largest distance of samples on the inner circle's edges from radius 1."""
        read = gmf.read(folder.path / mesh)
        edges = read.cells["EdgesP2" if "EdgesP2" in read.cells else "Edges"]
        t = np.linspace(0, 1, 21)
        farthest = 0
        for nodes in edges.nodes[edges.refs == 2]:
            shape = [(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)] if len(nodes) == 3 else [1 - t, t]
            points = sum(np.outer(s, read.points[v]) for s, v in zip(shape, nodes))
            farthest = max(farthest, abs(np.hypot(points[:, 0], points[:, 1]) - 1).max())
        return farthest

    def adapt(self, folder, name, *more, field=LAYER):
        done = folder.adapt("--field", field, "--geometry", CIRCLES, "--folder", name, "--cycles", 5, "--convergence-tolerance", 0,
                            "--result", "last", *more, mesh="ring.mesh", output=f"{name}.mesh", complexity="300")
        self.assertEqual(done.returncode, 0, done.stderr)
        return done, folder.rows(name)

    def test_the_expected_error_bounds_the_distance_of_a_boundary_to_its_geometry(self):
        with Adapting() as folder:
            self.ring(folder)
            for degree in (1, 2):
                done, bounded = self.adapt(folder, f"b{degree}", "--degree", degree)
                _, free = self.adapt(folder, f"f{degree}", "--degree", degree, "--geometry-error", 10)
                self.assertIn("distance, bound", done.stdout)
                for row in bounded[2:]:
                    distance = row["boundary_distance"]
                    self.assertEqual(distance["origin"], "expected_error")
                    self.assertLess(distance["reached"], 2 * distance["bound"])
                self.assertEqual(free[-1]["boundary_distance"]["origin"], "config")
                # The distance bound is error / sqrt(g L Δu): normal derivative g = 1/0.05 = 20, length L = 2π, change Δu = 1 of u.
                before = bounded[-2]
                error = before.get("expected_error", before["interpolation_error"]["l2"])
                wall = self.wall(folder, f"b{degree}.mesh")
                self.assertLess(wall, 2 * error / np.sqrt(20 * 2 * np.pi))
                self.assertLess(wall, 0.8 * self.wall(folder, f"f{degree}.mesh"))
                self.assertLess(bounded[-1]["elements"], 1.15 * free[-1]["elements"])
                self.assertLess(bounded[-1]["interpolation_error"]["l2"], 1.3 * free[-1]["interpolation_error"]["l2"])

    def test_distance_bounds_do_not_depend_on_the_unit_of_the_solution(self):
        with Adapting() as folder:
            self.ring(folder)
            meshes = []
            for i, unit in enumerate((1, 2.0**30, 2.0**-30)):
                _, rows = self.adapt(folder, f"u{i}", field=f"{unit!r}*{LAYER}")
                meshes.append([row["boundary_distance"]["bound"] for row in rows[2:]])
            self.assertEqual(*meshes[:2])
            self.assertEqual(*meshes[1:])

    def test_plane_boundaries_have_zero_distance_and_no_note(self):
        with Adapting() as folder:
            done = folder.adapt("--field", FIELD, "--folder", "c", "--cycles", 3)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("from its geometry", done.stderr)
            for row in folder.rows("c")[2:]:
                self.assertLess(row["boundary_distance"]["reached"], 1e-14)
                self.assertGreater(row["boundary_distance"]["bound"], 0)

    def test_a_distance_bound_that_is_not_met_is_a_note(self):
        """Required boundary edges are not split."""
        with Adapting() as folder:
            self.ring(folder)
            text = (folder.path / "ring.mesh").read_text()
            count = int(text.split("\nEdges\n")[1].split()[0])
            required = f"RequiredEdges\n{count}\n" + "\n".join(str(e + 1) for e in range(count))
            (folder.path / "ring.mesh").write_text(text.replace("\nEnd", f"\n{required}\nEnd"))
            done, rows = self.adapt(folder, "c")
            self.assertGreater(rows[-1]["boundary_distance"]["reached"], rows[-1]["boundary_distance"]["bound"])
            self.assertIn("from its geometry", done.stderr)
            self.assertNotIn("misses", rows[-1])


class Solvers(unittest.TestCase):
    def test_adapt_runs_the_solver_on_every_mesh_and_stores_all_files(self):
        with Adapting() as folder:
            done = folder.adapt("--solve", folder.solver(), "--field", FIELD, "--cycles", 2, "--mesh-file", "mesh.mesh",
                                "--output-solution", "v.sol", "--report", "r.json", complexity="30,50")
            self.assertEqual(done.returncode, 0, done.stderr)
            rows = folder.rows("n.cycles")
            self.assertEqual([row["complexity_target"] for row in rows], [0, 30, 50])
            for k, row in enumerate(rows):
                here = folder.path / "n.cycles" / f"cycle-{k:03}"
                self.assertEqual((here / "solver.txt").read_text().split()[0], "solved")
                self.assertTrue((here / "view.vtu").exists())
                for key in ("l2", "h1"):  # the test solver writes the interpolant
                    self.assertAlmostEqual(row["solution_error"][key] / row["interpolation_error"][key], 1, delta=3e-3)
            self.assertTrue((folder.path / "n.cycles" / "cycle-002" / "guess.sol").exists())
            self.assertIn("cycle-002/view.vtu", (folder.path / "n.cycles" / "series.pvd").read_text())
            self.assertEqual(report_of(folder.path / "r.json")["input"]["degree"], 2)
            nodes = len(gmf.read(folder.path / "n.cycles" / "cycle-002" / "mesh.mesh").points)
            self.assertEqual(rows[-1]["unknowns"], nodes)
            self.assertIn(f"\n{nodes}\n", (folder.path / "v.sol").read_text())

    def test_vtu_output_contains_the_last_solution(self):
        with Adapting() as folder:
            done = folder.adapt("--solve", folder.solver(), "--cycles", 1, "--mesh-file", "m.mesh", output="n.vtu")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("field_1", (folder.path / "n.vtu").read_bytes().decode("latin-1"))

    def test_solver_failures_are_reported_with_their_last_output(self):
        cases = [("import sys; print('no convergence'); sys.exit(7)", "exit code 7: no convergence"),
                 ("pass", "was not written by the solver of cycle 0"),
                 ("import os; os.abort()", "abort"),
                 ("import time; time.sleep(60)", "took more than 0.5 s"),
                 ("import sys; open(sys.argv[2], 'w').write('nonsense')", "solution.sol")]
        with Adapting() as folder:
            for program, reported in cases:
                (folder.path / "bad.py").write_text(program)
                done = folder.adapt("--solve", f"{sys.executable} bad.py {{mesh}} {{solution}}", "--timeout", 0.5,
                                    "--folder", f"c{len(reported)}")
                self.assertEqual(done.returncode, 3, (program, done.stderr))
                self.assertIn(reported, done.stderr)
                self.assertFalse((folder.path / f"c{len(reported)}" / "cycle-000").exists())

    def test_adapt_does_not_run_the_solver_on_an_invalid_mesh(self):
        with Adapting() as folder:
            folder.camber("convert", "r.mesh", "--elevate", "-o", "q.mesh")
            lines = (folder.path / "q.mesh").read_text().split("\n")
            first = lines.index("Vertices") + 2
            last = first + int(lines[first - 1]) - 1  # a mid node
            x, y, reference = lines[last].split()
            lines[last] = f"{float(x) + 0.3} {float(y) + 0.3} {reference}"
            (folder.path / "q.mesh").write_text("\n".join(lines))
            done = folder.adapt("--solve", folder.solver(), "--mesh-file", "m.mesh", mesh="q.mesh")
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn("camber repair", done.stderr)
            self.assertFalse((folder.path / "n.cycles" / "cycle-000" / "solver.txt").exists())

    def test_a_cycle_with_invalid_elements_is_repeated_with_a_smaller_step(self):
        """The metric leaves invalid elements at a coarse boundary; the config has no stage that repairs them."""
        with Adapting() as folder:
            folder.camber("generate", "annulus", "-o", "a.mesh", "--elements", 200, "--set", "outer_radius=5")
            reported = folder.adapt("--field", "exp(-(sqrt(x^2+y^2)-1)/0.02)", "--cycles", 3, "--print-config", mesh="a.mesh")
            config = json.loads(reported.stdout)
            config["stages"] = ["elevate", "remesh", {"curve": {"objective": "length"}}, "validate"]
            config["adapt"]["complexity"] = [80]
            config["adapt"]["folder"] = "c"
            (folder.path / "c.json").write_text(json.dumps(config))
            done = folder.camber("run", "c.json")
            self.assertIn("are not certified valid; the cycle is repeated at", done.stderr)
            rows = folder.rows("c")
            self.assertTrue(any(0 < row["complexity"] < 0.95 * 80 for row in rows))
            stored = [(folder.path / "c" / f"cycle-{row['cycle']:03}" / "mesh.meshb").read_bytes() for row in rows if row.get("valid", True)]
            self.assertIn((folder.path / "n.meshb").read_bytes(), stored)

    def test_a_bad_solver_command_is_rejected_before_the_first_cycle(self):
        with Adapting() as folder:
            for command, reported in (("flow {mesh}", "has no {solution}"), ("flow {solution}", "has no {mesh}"),
                                  ("/no/such/solver {mesh} {solution}", "cannot be started")):
                done = folder.adapt("--solve", command)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn(reported, done.stderr)


# Solver that writes the exact solution on straight quadratic elements: rows at the vertices, then one per edge.
QUADRATIC_SOLVER = """
import sys
import numpy as np
sys.path.insert(0, {oracle!r})
import gmf
mesh, solution, order = sys.argv[1:4]
read = gmf.read(mesh)
points = read.points
cells = read.cells["Tetrahedra" if points.shape[1] == 3 else "Triangles"].nodes
corners = cells.shape[1]
ends = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)][:3 if corners == 3 else 6]
named = np.sort(np.stack([cells[:, e] for e in ends], 1).reshape(-1, 2), 1)
edges, first, of_cells = np.unique(named, axis=0, return_index=True, return_inverse=True)
nodes = np.vstack([points, points[edges].mean(1)])
u = np.tanh((np.sqrt((nodes ** 2).sum(1)) - 0.5) / 0.1)
if order == "elements":
    u[len(points):] = u[len(points) + np.argsort(first)]
if order == "random":
    u[len(points):] = np.random.default_rng(1).permutation(u[len(points):])
if order == "all":
    u = np.random.default_rng(1).permutation(u)
if order == "vertices":
    u = u[:len(points)]
with open(solution, "w") as out:
    if solution.endswith(".sol"):
        out.write(f"MeshVersionFormatted 2\\nDimension {{points.shape[1]}}\\nSolAtVertices\\n{{len(u)}}\\n1 1\\n")
        out.writelines(f"{{v!r}}\\n" for v in u.tolist())
        out.write("End\\n")
    else:
        text = lambda rows: "\\n".join(" ".join(map(repr, row)) for row in rows)
        kind, flat = (22, np.zeros((len(nodes), 1))) if corners == 3 else (24, np.zeros((len(nodes), 0)))
        quadratic = np.hstack([cells, len(points) + of_cells.reshape(len(cells), -1)])
        array = lambda type, name, rows, n=1: (
            f'<DataArray type="{{type}}" Name="{{name}}" NumberOfComponents="{{n}}" format="ascii">{{text(rows)}}</DataArray>')
        out.write(f'<VTKFile type="UnstructuredGrid" version="0.1"><UnstructuredGrid>'
                  f'<Piece NumberOfPoints="{{len(nodes)}}" NumberOfCells="{{len(cells)}}"><Points>'
                  + array("Float64", "Points", np.hstack([nodes, flat]).tolist(), 3) + "</Points><Cells>"
                  + array("Int64", "connectivity", quadratic.tolist())
                  + array("Int64", "offsets", [[quadratic.shape[1] * (i + 1)] for i in range(len(cells))])
                  + array("UInt8", "types", [[kind]] * len(cells)) + "</Cells><PointData>"
                  + array("Float64", "u", [[v] for v in u.tolist()])
                  + "</PointData></Piece></UnstructuredGrid></VTKFile>")
"""
ROUND_FRONT = {2: "tanh((sqrt(x^2+y^2)-0.5)/0.1)", 3: "tanh((sqrt(x^2+y^2+z^2)-0.5)/0.1)"}


class StraightLoops(unittest.TestCase):
    """Straight meshes with a solver of degree 1 or 2."""

    def loop(self, folder, *more, order="edges", solution="solution.sol", settled=0, **options):
        (folder.path / "quadratic.py").write_text(QUADRATIC_SOLVER.format(oracle=str(ROOT / "tests" / "oracle")))
        return folder.adapt("--degree", 1, "--solve", f"{sys.executable} quadratic.py {{mesh}} {{solution}} {order}",
                            "--solution-file", solution, "--mesh-file", "mesh.mesh", "--convergence-tolerance", settled, *more, **options)

    def degree_of_metric(self, folder, way, cycle):
        return report_of(folder.path / way / f"cycle-{cycle:03}" / "report.json")["solution_metric"]["degree"]

    def test_the_metric_has_the_degree_of_the_solution(self):
        for dimension, complexity, cycles in ((2, "150", 3), (3, "150", 2)):
            with self.subTest(dimension), Adapting(cells=10) as folder:
                if dimension == 3:
                    folder.camber("generate", "box", "-o", "r.mesh", "--set", "cells=[5,5,5]")
                meshes, last = {}, {}
                for way, order, solution in (("sol", "edges", "u.sol"), ("vtu", "edges", "u.vtu"),
                                             ("linear", "vertices", "u.sol")):
                    done = self.loop(folder, "--folder", way, "--cycles", cycles, "--field", ROUND_FRONT[dimension],
                                     order=order, solution=solution, complexity=complexity)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    self.assertEqual(self.degree_of_metric(folder, way, cycles), 1 if way == "linear" else 2)
                    meshes[way], last[way] = (folder.path / "n.meshb").read_bytes(), folder.rows(way)[-1]
                    checked = folder.check("n.meshb")
                    self.assertEqual((checked["degree"], checked["invalid"]), (1, 0))
                # Equal values in different file formats give equal meshes.
                self.assertEqual(meshes["sol"], meshes["vtu"])
                self.assertLess(last["sol"]["solution_error"]["l2"], 0.5 * last["linear"]["solution_error"]["l2"])

    def test_the_expected_error_estimates_the_error_of_the_solution(self):
        with Adapting(cells=10) as folder:
            for order in ("edges", "vertices"):
                done = self.loop(folder, "--folder", order, "--cycles", 5, "--field", ROUND_FRONT[2], order=order,
                                 complexity="200")
                self.assertEqual(done.returncode, 0, done.stderr)
                for row in folder.rows(order)[3:]:
                    ratio = row["expected_error"] / row["solution_error"]["l2"]
                    self.assertTrue(1 / 1.5 < ratio < 1.5, (order, row))

    def test_cycles_without_an_exact_solution_end_by_the_expected_error(self):
        with Adapting(cells=10) as folder:
            done = self.loop(folder, "--folder", "c", "--cycles", 15, settled=0.1, complexity="150")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("converged: the minimum error is", done.stdout)
            best = min(folder.rows("c")[1:], key=lambda row: row["expected_error"])
            self.assertEqual(gmf.read(folder.path / "n.meshb").points.tolist(),
                             gmf.read(folder.path / "c" / f"cycle-{best['cycle']:03}" / "mesh.mesh").points.tolist())

    def test_the_initial_guess_has_one_row_per_node_of_the_solution(self):
        with Adapting() as folder:
            for order in ("edges", "vertices"):
                self.assertEqual(self.loop(folder, "--folder", order, "--cycles", 1, order=order).returncode, 0)
                here = folder.path / order / "cycle-001"
                rows = [int((here / name).read_text().split()[5]) for name in ("guess.sol", "solution.sol")]
                self.assertEqual(*rows)

    def test_other_node_orders_of_the_solution_are_rejected_or_noted(self):
        reported = {"elements": (3, "in the order in which these edges"), "random": (3, "are in another order"),
                "all": (0, "as unrelated as in a random order")}
        with Adapting(cells=20) as folder:
            for order, (code, text) in reported.items():
                done = self.loop(folder, "--cycles", 1, "--folder", f"c{order}", order=order, complexity="100")
                self.assertEqual(done.returncode, code, (order, done.stderr))
                self.assertIn(text, done.stderr)
                self.assertIn("docs/formats.md", done.stderr)
            done = self.loop(folder, "--cycles", 1, "--folder", "c", complexity="100")
            self.assertEqual((done.returncode, "order" in done.stderr), (0, False), done.stderr)

    def test_a_wrong_number_of_solution_rows_is_rejected_with_both_valid_numbers(self):
        with Adapting() as folder:
            (folder.path / "u.sol").write_text("MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n3\n1 1\n1\n2\n3\nEnd\n")
            done = folder.camber("metric", "r.mesh", "--solution", "u.sol", "--complexity", 50, "-o", "m.sol")
            self.assertEqual(done.returncode, 3)
            self.assertIn("u.sol: has 3 rows, but the mesh has 49 vertices, or 169 nodes in degree 2", done.stderr)


class MovingFronts(unittest.TestCase):
    def test_meshes_coarsen_behind_a_moving_front_and_refine_at_it(self):
        with Adapting() as folder:
            (folder.path / "moving.py").write_text((folder.path / "solver.py").read_text().replace(
                "- 0.5)", "- 0.3 - 0.08 * int(sys.argv[3]))"))
            done = folder.adapt("--solve", f"{sys.executable} moving.py {{mesh}} {{solution}} {{cycle}}", "--convergence-tolerance", 0,
                                "--cycles", 6, "--mesh-file", "m.mesh", complexity="120")
            self.assertEqual(done.returncode, 0, done.stderr)

            def near(cycle, radius):
                """Number of nodes within 0.03 of the circle, relative to its radius."""
                points = gmf.read(folder.path / "n.cycles" / f"cycle-{cycle:03}" / "m.mesh").points
                return int((abs(np.hypot(points[:, 0], points[:, 1]) - radius) < 0.03).sum()) / radius

            for cycle in (4, 5, 6):  # each mesh is adapted to the front of the previous cycle
                self.assertGreater(near(cycle, 0.3 + 0.08 * (cycle - 1)), 1.3 * near(cycle, 0.3 + 0.08 * (cycle - 3)))
            sizes = [row["elements"] for row in folder.rows("n.cycles")[2:]]
            self.assertLess(max(sizes), 1.3 * min(sizes))


class Resuming(unittest.TestCase):
    def test_resumed_cycles_write_the_same_bytes_as_uninterrupted_ones(self):
        with Adapting() as folder:
            whole = folder.adapt("--solve", folder.solver(), "--cycles", 3, "--mesh-file", "m.mesh", "--convergence-tolerance", 0)
            self.assertEqual(whole.returncode, 0, whole.stderr)
            last = (folder.path / "n.meshb").read_bytes()
            again = folder.adapt("--solve", folder.solver(), "--cycles", 3, "--mesh-file", "m.mesh", "--convergence-tolerance", 0)
            self.assertEqual(again.returncode, 2)
            self.assertIn("--from 3", again.stderr)
            done = folder.adapt("--solve", folder.solver(), "--cycles", 3, "--mesh-file", "m.mesh", "--convergence-tolerance", 0,
                                "--from", 1)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual((folder.path / "n.meshb").read_bytes(), last)
            self.assertEqual(len(folder.rows("n.cycles")), 4)
            over = folder.adapt("--solve", folder.solver(), "--cycles", 3, "--from", 3)
            self.assertEqual(over.returncode, 2)
            self.assertIn("no cycles remain", over.stderr)
            self.assertEqual(len(folder.rows("n.cycles")), 4)
            none = folder.adapt("--solve", folder.solver(), "--cycles", 12, "--from", 9)
            self.assertEqual(none.returncode, 2)
            self.assertIn("cycle 9 to continue after does not exist", none.stderr)

    def test_an_interrupt_leaves_the_last_complete_cycle(self):
        with Adapting() as folder:
            (folder.path / "slow.py").write_text("import os, sys, time\nif sys.argv[3] == '2': time.sleep(60)\n"
                                                 "os.execv(sys.executable, [sys.executable, 'solver.py', *sys.argv[1:]])\n")
            command = f"{sys.executable} slow.py {{mesh}} {{solution}} {{cycle}}"
            running = subprocess.Popen([CAMBER, "adapt", "r.mesh", "-o", "n.meshb", "--complexity", "40", "--mesh-file",
                                        "m.mesh", "--solve", command], cwd=folder.name, stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE, text=True)
            part = folder.path / "n.cycles" / "cycle-002.part" / "solver.txt"
            until = time.time() + 120
            while not part.exists() and time.time() < until:
                time.sleep(0.02)
            running.send_signal(signal.SIGINT)
            _, error_output = running.communicate(timeout=60)
            self.assertEqual(running.returncode, 130)
            self.assertIn("cycles 0 to 1 are complete", error_output)
            self.assertEqual(len(folder.rows("n.cycles")), 2)
            stored = folder.path / "n.cycles" / "cycle-001" / "m.mesh"
            self.assertEqual(folder.check("n.meshb")["elements"], folder.check(stored)["elements"])


class Configs(unittest.TestCase):
    def config(self, folder):
        (folder.path / "a.json").write_text(json.dumps({
            "input": {"generate": {"rectangle": {"cells": [6, 6]}}}, "metric": {"solution": {}},
            "stages": ["elevate", "remesh", {"curve": {"objective": "solution"}}, "validate", "relax", "commit"],
            "adapt": {"cycles": 2, "complexity": [30, 40], "folder": "c", "mesh": "m.mesh", "exact": FIELD,
                      "solve": [sys.executable, "solver.py", "{mesh}", "{solution}"]},
            "output": {"mesh": "n.meshb"}}))

    def test_a_config_runs_commands_with_allow_commands_only(self):
        with Adapting() as folder:
            self.config(folder)
            refused = folder.camber("run", "a.json")
            self.assertEqual(refused.returncode, 2)
            self.assertIn("--allow-commands", refused.stderr)
            done = folder.camber("run", "a.json", "--allow-commands")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(len(folder.rows("c")), 3)

    def test_the_printed_config_writes_the_same_mesh(self):
        with Adapting() as folder:
            first = folder.adapt("--field", FIELD, "--cycles", 2, "--print-config")
            (folder.path / "p.json").write_text(first.stdout)
            self.assertEqual(folder.camber("run", "p.json", "--set", "output/mesh=p.meshb").returncode, 0)
            self.assertEqual(folder.adapt("--field", FIELD, "--cycles", 2).returncode, 0)
            self.assertEqual((folder.path / "p.meshb").read_bytes(), (folder.path / "n.meshb").read_bytes())

    def test_set_changes_options_of_stages_and_rejects_adapt_options(self):
        with Adapting() as folder:
            done = folder.adapt("--field", FIELD, "--print-config", "--set", "stages/curve/objective=shape", "--set",
                                "metric/solution/norm=4", "--max-size", 0.3)
            config = json.loads(done.stdout)
            self.assertEqual(config["stages"][2]["curve"]["objective"], "shape")
            self.assertEqual((config["metric"]["solution"]["norm"], config["metric"]["solution"]["max_size"]), (4, 0.3))
            refused = folder.adapt("--field", FIELD, "--set", "adapt/cycles=3")
            self.assertEqual(refused.returncode, 2)

    def test_a_dry_run_writes_no_files(self):
        with Adapting() as folder:
            before = folder.files()
            done = folder.adapt("--field", FIELD, "--dry-run")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("at most 8 such cycles", done.stdout)
            self.assertEqual(folder.files(), before)

    def test_a_dry_run_does_not_start_the_solver(self):
        with Adapting() as folder:
            before = folder.files()
            done = folder.adapt("--solve", folder.solver(), "--dry-run")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("after the solver", done.stdout)
            self.assertEqual(folder.files(), before)

    def test_adapt_rejects_an_output_equal_to_the_input(self):
        with Adapting() as folder:
            done = folder.adapt("--field", FIELD, output="r.mesh")
            self.assertEqual(done.returncode, 2)
            self.assertIn("same file", done.stderr)

    def test_adapt_rejects_a_call_without_an_adaptation_target(self):
        with Adapting() as folder:
            done = folder.adapt()
            self.assertEqual(done.returncode, 2)
            self.assertIn("--solution, --metric, --solve or --field", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
