"""`camber generate`: every shape in every format, by name, JSON or config; element counts; repeatable bytes.

    python3 tests/pipelines/test_generate.py build/bin/camber [unittest arguments]
"""
import json
import signal
import subprocess
import sys
import unittest

from program import CAMBER, CONFIGS, SANITIZED, Folder

SMALL = {"shell": ("--elements", "2000"), "annulus": ("--elements", "200"), "box": (), "rectangle": (),
         "bump": ("--set", "floor_layer/count=3")}
LAYERS = ("--structure", "prisms", "--set", "inner_layer/count=8", "--set", "inner_layer/first_height=0.005")


class Generate(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def camber(self, *arguments):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def generate(self, *arguments, output="out.meshb"):
        """The bytes of the mesh, and the completed process."""
        done = self.camber("generate", *arguments, "-o", output)
        return (self.folder.path / output).read_bytes(), done

    def info(self, name="out.meshb"):
        return json.loads(self.camber("info", name, "--json").stdout)

    def elements(self, name="out.meshb"):
        found = self.info(name)
        return found["tetrahedra" if found["dimension"] == 3 else "triangles"]

    def fails(self, code, message, *arguments):
        before = self.folder.files()
        done = self.folder.camber("generate", *arguments)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertIn(message, done.stderr)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
        self.assertEqual(self.folder.files(), before)

    def test_every_shape_is_a_sound_and_valid_mesh(self):
        for shape, arguments in SMALL.items():
            with self.subTest(shape):
                self.generate(shape, *arguments)
                checked = json.loads(self.camber("check", "out.meshb", "--json").stdout)
                self.assertTrue(checked["soundness"]["sound"])
                self.assertEqual((checked["degree"], checked["invalid"]), (1, 0))
                self.assertGreater(checked["min_scaled_jacobian"], 0)
                self.assertIn(f"camber generate {shape}", self.camber("generate", "--help").stdout)

    def test_generate_writes_every_format(self):
        for ending in ("mesh", "meshb", "msh", "vtu", "mfem", "cgns"):
            for shape in ("box", "rectangle"):
                with self.subTest(ending=ending, shape=shape):
                    _, done = self.generate(shape, output=f"out.{ending}")
                    self.assertIn(f"wrote out.{ending}", done.stdout)
                    self.assertEqual(self.elements(f"out.{ending}"), {"box": 384, "rectangle": 32}[shape])
        self.assertTrue(self.generate("box", "--format", "mfem", output="out.mesh")[0].startswith(b"MFEM"))

    def test_a_shape_by_name_json_file_or_config_gives_the_same_mesh(self):
        expected, _ = self.generate("shell", "--set", "inner_size=0.9", "--set", "inner_layer/count=2")
        text = '{"shell": {"inner_size": 0.9, "inner_layer": {"count": 2}}}'
        (self.folder.path / "shape.json").write_text(text)
        (self.folder.path / "config.json").write_text(f'{{"input": {{"generate": {text}}}, "metric": "natural"}}')
        for argument in (text, "shape.json", "config.json"):
            self.assertEqual(self.generate(argument)[0], expected, argument)
        self.assertNotEqual(self.generate("config.json", "--set", "seed=2")[0], expected)

    def test_generated_meshes_do_not_depend_on_the_number_of_threads(self):
        for shape, arguments in {**SMALL, "shell": (*LAYERS, "--elements", "30000")}.items():
            made = [self.generate(shape, *arguments, "--threads", str(n))[0] for n in (1, 2, 3)]
            self.assertTrue(made[0] == made[1] == made[2], shape)

    def test_the_printed_config_generates_the_same_mesh(self):
        for shape, arguments in SMALL.items():
            with self.subTest(shape):
                expected, _ = self.generate(shape, *arguments)
                printed = self.camber("generate", shape, *arguments, "-o", "run.meshb", "--print-config").stdout
                (self.folder.path / "printed.json").write_text(printed)
                self.camber("run", "printed.json")
                self.assertEqual((self.folder.path / "run.meshb").read_bytes(), expected)

    def test_the_element_count_is_within_a_fifth_of_the_requested_one(self):
        for shape, options in (("box", ()), ("rectangle", ()), ("bump", SMALL["bump"]), ("annulus", ()),
                               ("annulus", ("--structure", "prisms")), ("shell", ("--structure", "prisms")),
                               ("shell", LAYERS)):
            for count in (30000,) if SANITIZED else (30000, 100000):
                with self.subTest(shape=shape, options=options, count=count):
                    _, done = self.generate(shape, *options, "--elements", str(count))
                    self.assertLess(abs(self.elements() / count - 1), 0.2)
                    self.assertEqual(done.stderr, "")
        self.generate("shell", "--elements", "5000")
        self.assertLess(abs(self.elements() / 5000 - 1), 0.2)

    def test_curve_accepts_a_graded_and_warped_rectangle(self):
        self.generate("rectangle", "--set", "grading=[1, 20]", "--set", "warp=0.04", "--elements", "500")
        self.camber("curve", "out.meshb", "-o", "curved.meshb")

    def test_wrong_arguments_are_rejected_and_write_no_file(self):
        for code, message, arguments in (
                (2, 'unknown word "shel" (did you mean "shell"?)', ("shel", "-o", "o.mesh")),
                (2, '--set: /shell/inner_siz: unknown key (did you mean "inner_size"?)',
                 ("shell", "-o", "o.mesh", "--set", "inner_siz=3")),
                (2, "--set: /shell/inner_size", ("shell", "-o", "o.mesh", "--set", "inner_size=-3")),
                (2, "PATH=VALUE", ("shell", "-o", "o.mesh", "--set", "inner_size")),
                (2, "box: --structure is for shell and annulus", ("box", "-o", "o.mesh", "--structure", "prisms")),
                (2, "elements are closest to 5 (", ("shell", "-o", "o.mesh", *LAYERS, "--elements", "5")),
                (2, "--elements", ("box", "-o", "o.mesh", "--elements", "0")),
                (2, "no format known for this ending", ("box", "-o", "o.ply")),
                (2, "too many", ("shell", "-o", "o.mesh", "--structure", "prisms", "--set", "inner_size=1e-9")),  # guards against an internal error
                (2, "high above low", ("box", "-o", "o.mesh", "--set", "high=[-1, 1, 1]")),
                (3, "absent.json", ("absent.json", "-o", "o.mesh")),
                (3, "its folder /dev/null is a file", ("box", "-o", "/dev/null/o.mesh"))):
            with self.subTest(" ".join(arguments)):
                self.fails(code, message, *arguments)
        (self.folder.path / "reads.json").write_text('{"input": {"mesh": "a.mesh"}}')
        self.fails(2, "reads.json: /input: the config reads a mesh instead of generating one", "reads.json", "-o", "o.mesh")
        self.fails(2, "-o is the same file as the config", "reads.json", "-o", "reads.json")
        for config in sorted(CONFIGS.glob("*.json")):
            if "generate" in json.loads(config.read_text()).get("input", {}):
                self.camber("generate", str(config), "-o", "o.mesh", "--print-config")

    def test_an_interrupt_ends_generate_and_leaves_no_file(self):
        process = subprocess.Popen([CAMBER, "generate", "shell", *LAYERS, "--elements", "5e7", "-o", "o.meshb"],
                                   cwd=self.folder.name, stderr=subprocess.PIPE, text=True)
        try:
            process.wait(3 if SANITIZED else 0.3)  # until it runs
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(60), 130)
        self.assertIn("stopped", process.stderr.read())
        process.stderr.close()
        self.assertEqual(self.folder.files(), [])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
