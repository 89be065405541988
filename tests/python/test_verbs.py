"""The verbs: equal bytes, errors, progress, signals, the adaptation loop."""
import os
import signal
import tempfile
import unittest
import warnings

import numpy as np

import shared
from shared import camber, program, shell, square


def bytes_of(mesh, folder, name):
    path = os.path.join(folder, name)
    mesh.write(path)
    with open(path, "rb") as file:
        return file.read()


class SameBytes(unittest.TestCase):
    """Results equal those of the program byte for byte."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def same(self, made, *words):
        program(*words, "-o", self.path("program.meshb"), "--quiet")
        with open(self.path("program.meshb"), "rb") as file:
            self.assertEqual(bytes_of(made, self.folder.name, "python.meshb"), file.read())

    def input_file(self, mesh, name):
        mesh.write(self.path(name))
        return self.path(name)

    def test_curve_gives_the_bytes_of_the_program(self):
        mesh = shell()
        input_file = self.input_file(mesh, "shell.meshb")
        self.same(camber.curve(mesh).mesh, "curve", input_file)
        geometry = {"analytic": [{"references": [1], "sphere": {"radius": 0.5}}]}
        made = camber.curve(mesh, objective="energy", set={"stages/relax/target": 0.2}, threads=1)
        self.same(made.mesh, "curve", input_file, "--objective", "energy", "--set", "stages/relax/target=0.2")
        self.assertTrue(made.success)
        self.assertEqual(made.report["mesh"]["degree"], 2)
        del geometry

    def test_remesh_with_an_array_of_sizes_gives_the_bytes_of_the_program(self):
        mesh = square()
        sizes = 0.05 + 0.2 * mesh.points[:, 0]
        input_file = self.input_file(mesh, "square.meshb")
        tensors = np.einsum("n,ij->nij", sizes**-2, np.eye(2))
        text = "MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n%d\n1 1\n%s\nEnd\n" % (
            len(sizes), "\n".join(repr(float(h)) for h in sizes))
        with open(self.path("sizes.sol"), "w") as file:
            file.write(text)
        made = camber.remesh(mesh, metric=sizes)
        self.same(made.mesh, "remesh", input_file, "--metric", self.path("sizes.sol"))
        self.assertEqual(made.metric.shape, (len(made.mesh.vertices), 2, 2))
        again = camber.remesh(mesh, metric=tensors)
        self.assertAlmostEqual(len(again.mesh.elements), len(made.mesh.elements), delta=0.05 * len(made.mesh.elements))

    def test_generate_and_read_give_the_mesh_of_the_program(self):
        program("generate", "shell", "-o", self.path("s.meshb"), "--elements", 500, "--quiet")
        mesh = camber.generate("shell", elements=500)
        self.assertEqual(camber.read(self.path("s.meshb")), mesh)

    def test_run_gives_the_same_mesh_for_a_config_with_and_without_input(self):
        config = {"input": {"generate": {"shell": {"outer_radius": 2, "inner_size": 0.6, "outer_size": 0.9}}},
                  "stages": ["elevate", {"curve": {"objective": "length"}}, "validate", "relax", "commit"]}
        made = camber.run(config)
        self.assertEqual(made.mesh, camber.run({"stages": config["stages"]}, shell()).mesh)

    def test_check_returns_verdicts_errors_and_the_table(self):
        mesh = camber.curve(shell()).mesh
        found = camber.check(mesh, field="tanh((x-0.5)/0.1)")
        self.assertTrue(found["success"])
        self.assertEqual(found["element_verdicts"]["min_scaled_jacobian"].shape, (len(mesh.elements),))
        self.assertEqual(found["interpolation"][0], camber.errors(mesh, "tanh((x-0.5)/0.1)"))
        self.assertIn("certified valid", found["table"])

    def test_repair_gives_the_bytes_of_the_program_and_a_valid_mesh(self):
        mesh = camber.curve(shell()).mesh
        points, first = np.array(mesh.points), len(mesh.vertices)
        inner = np.setdiff1d(np.arange(first, len(points)), mesh.cells["triangle6"][:, 3:])
        points[inner[::20]] += 0.3
        broken = camber.Mesh(points, mesh.cells, mesh.references)
        self.assertFalse(camber.check(broken)["success"])
        made = camber.repair(broken)
        self.assertTrue(made.success and camber.check(made)["success"])
        self.same(made.mesh, "repair", self.input_file(broken, "broken.meshb"))

    def test_geometry_finds_the_patches_of_a_shell(self):
        mesh = camber.curve(shell()).mesh
        self.assertEqual(len(camber.geometry(mesh)["patches"]), 2)

    def test_transfer_is_exact_for_linear_fields(self):
        coarse = square(4)
        fine = square(16)
        brought = camber.transfer(coarse, fine, 2 * coarse.points[:, 0] - coarse.points[:, 1])
        np.testing.assert_allclose(brought["u"], 2 * fine.points[:, 0] - fine.points[:, 1], atol=1e-12)

    def test_remesh_transfers_fields(self):
        mesh = square().with_fields(u=square().points[:, 0] * 3)
        made = camber.remesh(mesh, metric=0.07)
        np.testing.assert_allclose(made.solution["u"], 3 * made.mesh.points[:, 0], atol=1e-10)
        np.testing.assert_array_equal(made.mesh.fields["u"], made.solution["u"])

    def test_remesh_accepts_a_mesh_as_geometry(self):
        first = camber.curve(shell()).mesh
        made = camber.remesh(first, metric=0.7, geometry=first)
        self.assertTrue(made.success)
        radii = np.linalg.norm(made.mesh.points, axis=1)
        self.assertLess(radii.max(), 2.01)


class Errors(unittest.TestCase):
    def test_errors_state_place_and_remedy_in_terms_of_python(self):
        mesh = square()
        with self.assertRaises(camber.UsageError) as caught:
            camber.curve(mesh, objective="lenght")
        self.assertIn("objective", caught.exception.where)
        self.assertNotIn("--", str(caught.exception))
        self.assertIn("length", caught.exception.remedy)
        with self.assertRaisesRegex(ValueError, "gradation"):
            camber.remesh(mesh, metric=0.1, gradation=0.5)
        with self.assertRaisesRegex(camber.InputError, r"metric.*\(7\)|7 rows"):
            camber.remesh(mesh, metric=np.ones(7))
        with self.assertRaisesRegex(camber.Error, "nowhere.mesh"):
            camber.read("nowhere.mesh")
        with self.assertRaises(TypeError):
            camber.curve(mesh, objectve="length")
        with self.assertRaisesRegex(camber.UsageError, "a str is no mesh"):
            camber.curve("wing.meshb")

    def test_an_uncertified_result_is_a_warning_at_the_line_of_the_caller(self):
        points = np.array([[0.0, 0], [1, 0], [0, 1], [0.5, 0.6], [0.5, 0.5], [0, 0.5]])
        bad = camber.Mesh(points, {"triangle6": [[0, 1, 2, 3, 4, 5]]})
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            made = camber.validate(bad)
        self.assertFalse(made.success)
        self.assertEqual([w.category for w in caught], [camber.NotCertified])
        self.assertEqual(os.path.basename(caught[0].filename), "test_verbs.py")


class Progress(unittest.TestCase):
    def test_progress_reports_shares_between_0_and_1(self):
        reported = []
        camber.remesh(shell(), metric=0.25, progress=lambda stage, share: reported.append((stage, share)))
        self.assertTrue(reported)
        self.assertTrue(all(0 <= share <= 1 for _, share in reported))

    def test_progress_that_returns_false_stops_the_run(self):
        with self.assertRaises(camber.Stopped):
            camber.remesh(shell(), metric=0.06, progress=lambda stage, share: False)

    def test_progress_that_returns_numpy_false_stops_the_run(self):
        with self.assertRaises(camber.Stopped):
            camber.remesh(shell(), metric=0.06, progress=lambda stage, share: np.bool_(False))

    def test_an_exception_in_progress_is_raised(self):
        def progress(stage, share):
            raise KeyError(stage)

        self.assertRaises(KeyError, camber.remesh, shell(), metric=0.1, progress=progress)

    def test_an_interrupt_raises_keyboard_interrupt(self):
        signal.signal(signal.SIGALRM, signal.default_int_handler)
        mesh = shell()
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        self.assertRaises(KeyboardInterrupt, camber.remesh, mesh, metric=0.06)


class Renames(unittest.TestCase):
    def test_old_keywords_are_errors_that_state_the_new_names(self):
        for verb, old, new in ((camber.curve, "cad_seconds", "cad_timeout"), (camber.adapt, "settled", "convergence_tolerance")):
            with self.assertRaisesRegex(camber.UsageError, f"{old}: was renamed to {new}"):
                verb(shell(), **{old: 1})

    def test_old_attributes_are_errors_that_state_the_new_names(self):
        with self.assertRaisesRegex(AttributeError, "holds was renamed to success"):
            camber.elevate(shell()).holds


class Adapting(unittest.TestCase):
    def test_adapt_calls_a_python_solver_in_each_cycle(self):
        def solve(mesh, guess, cycle):
            calls.append((cycle, len(mesh.points), set(guess)))
            x, y = mesh.points.T
            return np.tanh((x + y - 1) / 0.05)

        calls = []
        made = camber.adapt(square(), solve=solve, complexity=[100, 200], cycles=3, convergence_tolerance=0)
        self.assertEqual([s[0] for s in calls], [0, 1, 2, 3])
        self.assertEqual(calls[0][2], set())
        self.assertEqual(calls[1][2], {"u"})
        self.assertTrue(made.success)
        self.assertEqual(made.mesh.degree, 2)
        self.assertEqual([row["cycle"] for row in made.cycles], [0, 1, 2, 3])
        x, y = made.mesh.points.T
        np.testing.assert_array_equal(made.solution["u"], np.tanh((x + y - 1) / 0.05))

    def test_adapt_accepts_a_quadratic_solution_on_straight_meshes(self):
        def solve(mesh, guess, cycle):
            quadratic = camber.elevate(mesh).mesh
            if cycle > 0:
                self.assertEqual(len(guess["u"]), len(quadratic.points))
            x, y = quadratic.points.T
            return np.tanh((x + y - 1) / 0.1)

        made = camber.adapt(square(), solve=solve, complexity=100, cycles=3, convergence_tolerance=0, degree=1)
        self.assertEqual(made.mesh.degree, 1)
        self.assertEqual(made.report["solution_metric"]["degree"], 2)
        self.assertGreater(made.cycles[-1]["expected_error"], 0)
        self.assertEqual(len(made.solution["u"]), len(camber.elevate(made.mesh).mesh.points))
        for wrong in (3, len(square().points) + 1):
            with self.assertRaises(camber.Error):
                camber.adapt(square(), solve=lambda mesh, guess, cycle: np.zeros(wrong), complexity=100, degree=1)

    def test_adapt_to_an_expression_gives_the_mesh_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            input_file, out = os.path.join(folder, "s.meshb"), os.path.join(folder, "o.meshb")
            square().write(input_file)
            program("adapt", input_file, "--field", "tanh((x-0.5)/0.05)", "--complexity", "100,150", "--cycles", 2, "-o", out,
                    "--quiet")
            made = camber.adapt(square(), field="tanh((x-0.5)/0.05)", complexity=[100, 150], cycles=2)
            self.assertEqual(camber.read(out).points.tolist(), made.mesh.points.tolist())

    def test_run_of_a_config_with_cycles_gives_the_mesh_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            input_file, out, config = (os.path.join(folder, name) for name in ("s.meshb", "o.meshb", "c.json"))
            square().write(input_file)
            words = ("adapt", input_file, "--field", "tanh(9*x)", "--complexity", "60,80", "--cycles", 2, "-o", out)
            with open(config, "w") as file:
                file.write(program(*words, "--print-config").stdout)
            program(*words, "--quiet")
            by_program = camber.read(out)
            os.remove(out)
            made = camber.run(config)
            self.assertEqual([row["cycle"] for row in made.cycles], [0, 1, 2])
            self.assertEqual(made.mesh.points.tolist(), by_program.points.tolist())
            self.assertEqual(camber.read(out).points.tolist(), by_program.points.tolist())

    def test_an_exception_in_the_solver_is_raised(self):
        def solve(mesh, guess, cycle):
            raise ZeroDivisionError("in the solver")

        self.assertRaisesRegex(ZeroDivisionError, "in the solver", camber.adapt, square(), solve=solve)


if __name__ == "__main__":
    shared.main()
