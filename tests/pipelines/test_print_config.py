"""`camber run` with the config of --print-config writes the files of the verb, byte for byte.

    python3 tests/pipelines/test_print_config.py build/bin/camber [unittest arguments]

The verbs are those whose help has --print-config. Each of their options is in a case, so that a new option fails here until it has one.
Reports are compared without times and memory.
"""
import json
import re
import shlex
import shutil
import sys
import unittest

import numpy as np

from made_meshes import elevated, lattice
from program import ROOT, Folder
from test_adapt import SOLVER

CAD = ROOT / "tests" / "cad"
# Options that only print text, and options of `camber run`.
NOT_OF_RESULTS = {"help", "help-all", "quiet", "verbose", "dry-run", "print-config"}
OF_RUN = {"--force": 0, "--histogram": 0, "--allow-commands": 0, "--from": 1}
SOLVE = f"--solve '{sys.executable} solver.py {{mesh}} {{solution}}'"
SPHERE = """--geometry '{"analytic": [{"references": [1], "sphere": {"radius": 5}}]}'"""
PIPELINE = "--report r.json --vtu n.vtu --plots plots --page n.html"
CASES = {
    "curve": [
        f"shell.mesh -o n.meshb {PIPELINE}",
        "shell.mesh -o n.mesh --metric 0.5 --size 1=0.2 --gradation 1.5 --complexity 300 --objective energy --threads 1",
        "shell.mesh -o n.meshb --metric 0.4 --geometry-error 0.01 --objective length --geometry straight --report r.json",
        "shell.mesh -o n.msh --format msh-ascii --objective shape --geometry-tolerance 1e-4 --min-scaled-jacobian 0.2 --histogram",
        f"shell.mesh -o n.meshb {SPHERE} --set features/ridge_angle=50 --set stages/relax/max_corrections=4 --report r.json",
        "shell.mesh -o n.pvtu --partition 3",
        "shell.mesh -o n.meshb --blocks 3 --report r.json",
        "shell.mesh -o n.meshb --memory 1G",
        "shell.mesh -o n.meshb --geometry '{\"mesh\": \"first.mesh\"}' --report r.json",
        "plane.mesh -o plane.mesh --force --flat surface",
        "square.mesh -o n.meshb --metric '{\"field\": {\"polar-1\": {}}}'",
        "square.mesh -o n.meshb --solution 'tanh((x-y)/0.05)' --output-solution v.sol --transfer conserve --report r.json",
        "square.mesh -o n.vtu --solution u.vtu --fields size --metric solution --objective accuracy",
    ],
    "remesh": [
        f"box.mesh -o n.meshb --metric 0.6 --output-metric made.sol {PIPELINE}",
        "box.mesh -o n.meshb --metric m3.sol --size facets:1=0.4 --size elements:1=0.5 --rounds 2 --geometry-error none --histogram",
        "box.mesh -o n.meshb --geometry-error 0.02 --gradation 2 --complexity 20 --geometry-tolerance 1e-3",
        "box.mesh -o n.pvtu --metric 0.7 --partition 2",
        "box.mesh -o n.meshb --metric 0.6 --blocks 2",
        "box.mesh -o n.meshb --metric 0.6 --geometry straight --set stages/remesh/rounds=1 --threads 1 --report r.json",
        "curved.mesh -o n.msh --format msh-ascii --metric 1.2 --objective length --report r.json",
        "square.mesh -o square.mesh --force --metric solution --solution u.vtu --fields size --output-solution v.sol",
        "square.mesh -o n.vtu --metric 0.2 --solution 'tanh((x-y)/0.05)' --transfer conserve --report r.json",
        "plane.mesh -o n.mesh --flat surface --metric 0.7",
    ],
    "repair": [
        f"curved.mesh -o n.meshb {PIPELINE}",
        "curved.mesh -o n.mesh --boundary-tolerance 0.01 --min-scaled-jacobian 0.3 --threads 1 --histogram --report r.json",
        "curved.mesh -o curved.mesh --force --geometry-tolerance 1e-3 --set stages/relax/max_corrections=3",
        "curved.mesh -o n.vtu --solution c.sol --fields field_1 --output-solution v.sol --transfer interpolate",
        "curved.mesh -o n.msh --format msh-ascii --geometry straight --flat surface",
    ],
    "adapt": [
        f"square.mesh -o n.meshb --field 'tanh((x-y)/0.05)' --complexity 30,50 --cycles 2 {PIPELINE}",
        "square.mesh -o n.mesh --solution u.sol --fields field_1 --output-solution v.sol --transfer conserve --report r.json",
        "square.mesh -o n.meshb --solution 'tanh((x-y)/0.05)' --cycles 2 --norm H1 --min-size 0.01 --max-size 0.5 --max-anisotropy 20 "
        "--degree 1 --threads 1",
        "square.mesh -o n.meshb --solution u.vtu --error-of gradients --norm 1 --gradation 2 --geometry-error 0.01 --size 1=0.2 "
        "--geometry-tolerance 1e-3 --min-scaled-jacobian 0.1",
        "plane.mesh -o n.msh --format msh-ascii --metric 0.6 --cycles 1 --degree 1 --flat surface --geometry straight",
        f"square.mesh -o n.meshb {SOLVE} --cycles 2 --convergence-tolerance 0 --result last --timeout 100 --mesh-file m.mesh --solution-file s.sol "
        "--set features/ridge_angle=50",
        f"square.mesh -o n.meshb {SOLVE} --cycles 2 --folder kept --complexity 40",
        f"square.mesh -o n.meshb {SOLVE} --cycles 3 --convergence-tolerance 0 --folder kept --complexity 40 --from 1",
    ],
    "generate": [
        "shell -o n.meshb --set inner_size=0.5 --set inner_layer/count=2",
        "shell -o n.mesh --structure prisms --elements 500 --threads 1",
        "annulus -o n.msh --format msh-ascii --elements 200",
        "box -o n.mesh --set 'cells=[3, 2, 2]' --set 'high=[2, 1, 1]'",
        "'{\"rectangle\": {\"cells\": [5, 4], \"warp\": 0.04}}' -o n.vtu",
        "bump -o n.mesh",
        "config.json -o n.mesh",
    ],
    "run": [
        "config.json",
        "config.json --set stages/curve/objective=length --set input/generate/shell/inner_size=0.7 --threads 1 --histogram",
        "cycles.json --allow-commands",
        "cycles.json --allow-commands --from 1 --set adapt/cycles=3",
        "over.json --force",
    ],
}
CAD_CASES = {verb: [f"{mesh} -o n.meshb {more} --cad capsule.brep --cad-unit file --cad-vertices move --cad-timeout 60 --cad-memory 900 "
                    "--report r.json"]
             for verb, mesh, more in (("curve", "capsule.mesh", ""), ("remesh", "capsule.mesh", "--metric 0.5"),
                                      ("repair", "capsule-p2.mesh", ""), ("adapt", "capsule.mesh", "--metric 0.7 --cycles 1"))}
CONFIGS = {
    "config.json": {"input": {"generate": {"shell": {"inner_size": 0.6}}},
                    "output": {"mesh": "n.meshb", "vtu": "n.vtu", "report": "r.json", "plots": "plots"}},
    "cycles.json": {"input": {"mesh": "square.mesh"}, "output": {"mesh": "n.meshb"}, "stages": ["remesh"],
                    "metric": {"solution": {"complexity": 40}},
                    "adapt": {"cycles": 2, "convergence_tolerance": 0, "folder": "kept", "solve": [sys.executable, "solver.py", "{mesh}", "{solution}"]}},
    "over.json": {"input": {"mesh": "square.mesh"}, "output": {"mesh": "square.mesh"}},
}


def solution(dimension, values):
    return "\n".join(["MeshVersionFormatted 2", f"Dimension {dimension}", "SolAtVertices", str(len(values)), "1 1",
                      *(repr(float(v)) for v in values), "End", ""])


def in_space(text):
    """Converts the text of a 2D mesh file to 3D."""
    text = text.replace("Dimension 2", "Dimension 3")
    head, tail = text.split("Triangles")
    return re.sub(r" 0$", " 0.5 0", head, flags=re.M) + "Triangles" + tail


def write_inputs(folder):
    """Writes the meshes, solutions, metrics and configs that the cases name."""
    def generate(name, shape, *settings):
        done = folder.camber("generate", shape, "-o", name, *(word for s in settings for word in ("--set", s)))
        assert done.returncode == 0, done.stderr

    def write(name, text):
        (folder.path / name).write_text(text)

    generate("shell.mesh", "shell", "inner_size=0.6")
    generate("box.mesh", "box", "cells=[2, 2, 2]")
    generate("first.mesh", "shell", "inner_size=0.5")
    generate("square.mesh", "rectangle", "cells=[5, 5]")
    write("plane.mesh", in_space(lattice(2, 3).text()))
    write("c.sol", solution(3, np.arange(27) ** 2 / 100))
    write("curved.mesh", elevated(lattice(3, 2), np.random.default_rng(1), 0.12).text())
    write("m3.sol", solution(3, 0.6 + 0.1 * np.cos(np.arange(27))))
    vertices = int(re.search(r"Vertices\s+(\d+)", (folder.path / "square.mesh").read_text())[1])
    write("u.sol", solution(2, np.tanh(np.arange(vertices) / 7 - 2)))
    done = folder.camber("convert", "square.mesh", "-o", "u.vtu", "--metric", "u.sol")
    assert done.returncode == 0, done.stderr
    write("solver.py", SOLVER.format(oracle=str(ROOT / "tests" / "oracle")))
    for name in ("capsule.brep", "capsule.mesh"):
        shutil.copy(CAD / name, folder.path)
    done = folder.camber("convert", "capsule.mesh", "-o", "capsule-p2.mesh", "--elevate")
    assert done.returncode == 0, done.stderr
    for name, config in CONFIGS.items():
        write(name, json.dumps(config))


class Inputs(Folder):
    """A folder with a copy of the inputs."""

    made = None

    def __init__(self):
        super().__init__()
        if Inputs.made is None:
            Inputs.made = Folder()
            write_inputs(Inputs.made)
        shutil.copytree(Inputs.made.path, self.path, dirs_exist_ok=True)


def without_times(text):
    """Removes durations, memory and the command line of a page from a text."""
    text = re.sub(r"[\d.]+(?:e[+-]?\d+)? (?:1/s|s|ms|min|[kMG]?B|[KMG]iB)\b", "_", text)
    text = re.sub(r"^( +\d+ .*?)(?: +[\d.]+){1,2}$", r"\1 _", text, flags=re.M)  # rows of cycles end with seconds
    return re.sub(r">camber [^<]*<", "><", text)


def contents(path):
    """The content of a file without parts that differ between runs."""
    data = path.read_bytes()
    if path.suffix == ".json":
        text = json.dumps(without_costs(json.loads(data)), indent=1)
        return re.sub(r"\.camber-cycles-\w+", "", text)  # name of a temporary folder
    return without_times(data.decode()) if path.suffix == ".html" else data


def without_costs(value):
    if isinstance(value, dict):
        return {k: without_costs(v) for k, v in value.items() if k != "times" and not k.endswith(("second", "seconds", "bytes"))}
    return [without_costs(v) for v in value] if isinstance(value, list) else value


def split(case):
    """The words of a case, and those that `camber run` gets too."""
    words = shlex.split(case)
    of_run = [word for i, at in enumerate(words) if at in OF_RUN for word in words[i:i + 1 + OF_RUN[at]]]
    return words, of_run


def verbs(folder):
    """Options of each verb with --print-config, from the help."""
    listed = folder.camber("--help").stdout.split("Subcommands:")[1]
    found = {}
    for verb in re.findall(r"^  ([a-z]+)  ", listed, flags=re.M):
        lines = [line for line in folder.camber(verb, "--help-all").stdout.splitlines() if line.startswith("  -")]
        options = {name for line in lines for name in re.findall(r"(?:^  |,)--([a-z-]+)", line)}
        if "print-config" in options:
            found[verb] = options
    return found


class PrintedConfigs(unittest.TestCase):
    def inputs(self):
        folder = Inputs()
        self.addCleanup(folder.cleanup)
        return folder

    def check(self, verb, case):
        words, of_run = split(case)
        direct, printed = self.inputs(), self.inputs()
        if "--from" in of_run:  # resumes after existing cycles
            earlier = [word for word in words if word not in ("--from", "1")]
            for folder in (direct, printed):
                folder.camber(verb, *earlier)
        before = printed.files()
        config = printed.camber(verb, *words, "--print-config")
        self.assertEqual(config.returncode, 0, config.stderr)
        self.assertEqual(printed.files(), before)
        (printed.path / "printed.json").write_text(config.stdout)
        again = printed.camber("run", "printed.json", "--print-config")
        self.assertEqual(again.stdout, config.stdout)
        done = direct.camber(verb, *words)
        ran = printed.camber("run", "printed.json", *of_run, *(["--allow-commands"] if "--solve" in words else []))
        self.assertIn(done.returncode, (0, 1), done.stderr)
        if not {"--force", "--from"} & set(words):
            self.assertGreater(len(direct.files()), len(before), done.stderr)
        self.assertEqual(ran.returncode, done.returncode)
        if verb != "generate":  # it prints other notes and no table
            self.assertEqual(ran.stderr, done.stderr)
            self.assertEqual(without_times(ran.stdout), without_times(done.stdout))
        self.assertEqual([name for name in printed.files() if name != "printed.json"], direct.files())
        for name in direct.files():
            self.assertEqual(contents(printed.path / name), contents(direct.path / name), name)

    def cases(self, verb, cases):
        for case in cases:
            with self.subTest(f"camber {verb} {case}"):
                self.check(verb, case)

    def test_each_option_of_verbs_with_print_config_is_in_a_case(self):
        known = verbs(self.inputs())
        self.assertEqual(set(known), set(CASES))
        for verb, options in known.items():
            used = {word[2:] for case in CASES[verb] + CAD_CASES.get(verb, []) for word in shlex.split(case) if word.startswith("--")}
            self.assertEqual(options - used - NOT_OF_RESULTS - {"output"}, set(), verb)

    def test_inconsistent_arguments_are_rejected_like_an_inconsistent_config(self):
        field = "--solution x*y --fields a"
        for case in (f"curve shell.mesh -o n.meshb {field}", f"remesh square.mesh -o n.meshb --metric 0.3 {field}",
                     f"repair curved.mesh -o n.mesh {field}", f"adapt square.mesh -o n.meshb {field}"):
            for more in ([], ["--print-config"], ["--dry-run"]):
                with self.subTest(f"camber {case}", more=more):
                    folder = self.inputs()
                    before = folder.files()
                    done = folder.camber(*shlex.split(case), *more)
                    self.assertEqual((done.returncode, done.stdout), (2, ""))
                    self.assertIn('command line: /solution: "fields" selects fields of a file', done.stderr)
                    self.assertEqual(folder.files(), before)

    def test_printed_configs_of_curve_write_the_same_files(self):
        self.cases("curve", CASES["curve"])

    def test_printed_configs_of_remesh_write_the_same_files(self):
        self.cases("remesh", CASES["remesh"])

    def test_printed_configs_of_repair_write_the_same_files(self):
        self.cases("repair", CASES["repair"])

    def test_printed_configs_of_adapt_write_the_same_files(self):
        self.cases("adapt", CASES["adapt"])

    def test_printed_configs_of_generate_write_the_same_files(self):
        self.cases("generate", CASES["generate"])
        for case in CASES["generate"]:
            with self.subTest(case):
                words, folder = shlex.split(case), self.inputs()
                (folder.path / "printed.json").write_text(folder.camber("generate", *words, "--print-config").stdout)
                output = words[words.index("-o") + 1]
                formatted = words[words.index("--format"):][:2] if "--format" in words else []
                self.assertEqual(folder.camber("generate", *words).returncode, 0)
                self.assertEqual(folder.camber("generate", "printed.json", "-o", "again-" + output, *formatted).returncode, 0)
                self.assertEqual(contents(folder.path / output), contents(folder.path / ("again-" + output)))

    def test_printed_configs_of_run_write_the_same_files(self):
        self.cases("run", CASES["run"])

    def test_printed_configs_with_cad_models_write_the_same_files(self):
        if re.search("CAD models +missing", self.inputs().camber("--version", "--verbose").stdout):
            self.skipTest("the program was built without OpenCASCADE")
        for verb, cases in CAD_CASES.items():
            self.cases(verb, cases)


def tearDownModule():
    if Inputs.made:
        Inputs.made.cleanup()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
