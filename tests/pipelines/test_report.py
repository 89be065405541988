"""docs/report.md documents exactly the keys of reports and `check --json`; the report describes the run.

    python3 tests/pipelines/test_report.py build/bin/camber [unittest arguments]
"""
import json
import os
import re
import subprocess
import sys
import unittest

import report_page
from program import CAMBER, CONFIGS, ROOT, Folder, report_of

import gmf  # noqa: E402  (program puts the oracle on the path)
from bad_meshes import block, centre_out
from made_meshes import Mesh, block_beside_ball, joined, lattice, moved, scattered_square
from sample_meshes import ascii_file, cube, elevate, solution_file
import numpy as np

sys.path.insert(0, str(ROOT / "tests" / "cad"))
import capsule  # noqa: E402
import plate

CAD_MODEL = ROOT / "tests" / "cad" / "shell.brep"
PAGE = ROOT / "docs" / "report.md"
CODE = re.compile(r"`([^`]+)`")
ANY = re.compile(r"[A-Z]+")


def leaves(value, path=""):
    """Paths of all values that are no objects; of lists of objects those of the entries; `config` as a whole."""
    if isinstance(value, dict) and path != "config":
        return {leaf for key, part in value.items() for leaf in leaves(part, f"{path}.{key}" if path else key)}
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return {leaf for part in value for leaf in leaves(part, path + "[]")}
    return {path}


def documented(section):
    """The keys in the tables of one section of the page."""
    text = PAGE.read_text(encoding="utf-8")
    histograms = text[text.index("### Histograms"):text.index("## `check --json`")]
    begin = text.index(f"## `{section}`")
    end = text.find("\n## ", begin + 1)
    rows = [row for part in (text[begin:end], histograms) for row in part.splitlines() if row.startswith("| `")]
    return {key for row in rows for key in CODE.findall(row.split(" | ")[0])}


def pattern(key):
    """Regular expression of a documented key: a word in capitals stands for any key or part of it; KEY at the end
    includes the keys below."""
    end = r"[][\w.-]+$" if key.endswith(".KEY") else "$"
    return re.compile(r"[\w-]+".join(map(re.escape, ANY.split(key.removesuffix("KEY")))) + end)


def tagged(points, triangles):
    """A flat mesh as MSH 2.2 with element tags from 101 in the group sheet."""
    nodes = "".join(f"{i} {x} {y} 0\n" for i, (x, y) in enumerate(points, 1))
    elements = "".join(f"{i} 2 2 7 7 {a} {b} {c}\n" for i, (a, b, c) in enumerate(triangles, 101))
    return (f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"sheet\"\n$EndPhysicalNames\n$Nodes\n{len(points)}\n{nodes}$EndNodes\n"
            f"$Elements\n{len(triangles)}\n{elements}$EndElements\n").encode()


def holds(key, path):
    """An empty list is documented by the keys of its entries."""
    return pattern(key).match(path) or key.startswith(path + "[]")


class Report(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def run_camber(self, *arguments, codes=(0,)):
        done = self.folder.camber(*arguments)
        self.assertIn(done.returncode, codes, done.stdout + done.stderr)
        return done

    def write(self, name, data):
        (self.folder.path / name).write_bytes(data)

    def config(self, name, *settings, codes=(0,)):
        output = json.dumps({"mesh": "out.meshb", "report": "r.json"})
        arguments = [x for setting in settings for x in ("--set", setting)]
        self.run_camber("run", CONFIGS / f"{name}.json", "--set", f"output={output}", *arguments, codes=codes)
        return report_of(self.folder.path / "r.json")

    def reads_cad(self):
        """True if the program was built with OpenCASCADE."""
        self.write("in.mesh", ascii_file(cube(1)))
        done = self.folder.camber("curve", "in.mesh", "-o", "out.mesh", "--cad", CAD_MODEL)
        return "reads no CAD files" not in done.stderr

    def reports(self):
        """Reports of different verbs and stages, which together contain each key."""
        yield self.config("spheres", "threads=1")
        yield self.config("paper-spheres-coarse", 'stages=["elevate","reinsert"]')
        yield self.config("annulus-2d", "stages/curve/objective=shape")
        yield self.config("annulus-2d", "stages/curve/boundary_nodes=length",
                          'geometry={"analytic": [{"references": [1], "sphere": {"radius": 3}}]}')
        yield self.config("annulus-2d", 'stages=["remesh"]', 'metric={"constant": {"sizes": [0.5]}}')
        yield self.config("annulus-2d", 'stages=["remesh"]', 'metric={"constant": {"sizes": [0.5]}}',
                          'metric_operations=[{"intersect": {"geometry": {"chord_error": 0.01}}}]')
        self.run_camber("generate", "shell", "-o", "ball.mesh", "--set", "outer_radius=2", "--set", "inner_size=0.7", "--set", "outer_size=1.2")
        self.run_camber("curve", "ball.mesh", "-o", "round.mesh")
        for before, after in (("round.mesh", "once.mesh"), ("once.mesh", "twice.mesh")):
            self.run_camber("remesh", before, "-o", after, "--metric", '{"constant": {"sizes": [0.8]}}', "--report", "r.json")
        yield report_of(self.folder.path / "r.json")
        self.run_camber("curve", "ball.mesh", "-o", "blocks.meshb", "--blocks", "200", "--report", "r.json")
        yield report_of(self.folder.path / "r.json")
        self.write("cube.mesh", ascii_file(cube(2)))
        surface = cube(1)
        del surface.cells["Tetrahedra"]
        self.write("surface.mesh", ascii_file(surface))
        self.run_camber("curve", "surface.mesh", "-o", "out.meshb", "--report", "r.json")
        yield report_of(self.folder.path / "r.json")
        self.run_camber("curve", "cube.mesh", "-o", "out.meshb", "--report", "r.json", "--set", "output/distances=both")
        yield report_of(self.folder.path / "r.json")
        lattice_points = gmf.read(self.folder.path / "cube.mesh").points
        rows = "\n".join(repr(float(np.tanh(5 * p.sum()) + p[0] ** 3)) for p in lattice_points)
        self.write("u.sol", f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(lattice_points)}\n1 1\n{rows}\nEnd\n".encode())
        self.run_camber("remesh", "cube.mesh", "-o", "out.meshb", "--report", "r.json", "--solution", "u.sol", "--metric", "solution",
                        "--transfer", "conserve", "--output-solution", "v.sol")
        yield report_of(self.folder.path / "r.json")
        self.run_camber("curve", "ball.mesh", "-o", "out.meshb", "--report", "r.json", "--solution", "exp(-4*x)")
        yield report_of(self.folder.path / "r.json")
        self.write("scattered.mesh", scattered_square(224).text().encode())
        self.run_camber("curve", "scattered.mesh", "-o", "out.meshb", "--report", "r.json", "--set", 'stages=["elevate"]')
        yield report_of(self.folder.path / "r.json")
        if self.reads_cad():
            self.run_camber("generate", "shell", "-o", "shell.mesh")
            self.run_camber("curve", "shell.mesh", "-o", "out.meshb", "--report", "r.json", "--cad", CAD_MODEL)
            yield report_of(self.folder.path / "r.json")
            (self.folder.path / "plate.mesh").write_text(plate.text(*plate.plate()))
            cad = {"file": str(CAD_MODEL.parent / "plate.brep"), "vertices": "move", "analytic": [plate.HOLE]}
            self.run_camber("curve", "plate.mesh", "-o", "out.meshb", "--report", "r.json", "--geometry",
                            json.dumps({"cad": cad}), "--set", "output/distances=both")
            yield report_of(self.folder.path / "r.json")
            (self.folder.path / "capsule.mesh").write_text(capsule.across_circle())
            self.run_camber("curve", "capsule.mesh", "-o", "out.meshb", "--report", "r.json", "--cad", CAD_MODEL.parent / "capsule.brep")
            yield report_of(self.folder.path / "r.json")
            points, tetrahedra, triangles = plate.plate()
            faces = [t[:k] + t[k + 1:] for t in tetrahedra for k in range(4)]
            sheet = {tuple(sorted(f)): (*f, 50) for f in faces if {points[v][2] for v in f} == {0.25}}
            (self.folder.path / "sheet.mesh").write_text(plate.text(points, tetrahedra, triangles + list(sheet.values())))
            self.run_camber("curve", "sheet.mesh", "-o", "out.meshb", "--report", "r.json", "--cad", CAD_MODEL.parent / "plate.brep")
            yield report_of(self.folder.path / "r.json")
            points, tetrahedra, triangles = plate.plate()  # a vertex of the ridge x = y = -1 is moved along the side x = -1
            points = [(-1, -0.9, z) if (x, y) == (-1, -1) and 0 < z < 0.5 else (x, y, z) for x, y, z in points]
            (self.folder.path / "ridge.mesh").write_text(plate.text(points, tetrahedra, triangles))
            self.run_camber("curve", "ridge.mesh", "-o", "out.meshb", "--report", "r.json", "--cad", CAD_MODEL.parent / "plate.brep",
                            codes=(0, 1))
            yield report_of(self.folder.path / "r.json")
        for name, mesh in (("overlapping.mesh", joined(lattice(3, 3), moved(lattice(3, 2), [1.13] * 3, 0.2))),
                           ("close.mesh", block_beside_ball(3, 2, 0.3, 0.1)),
                           ("crossing.mesh", block_beside_ball(3, 2, -0.5, 0.2))):
            self.write(name, mesh.text().encode())
            self.run_camber("curve", name, "-o", "out.meshb", "--report", "r.json", codes=(1,))
            yield report_of(self.folder.path / "r.json")
        broken = elevate(block())
        centre_out(broken)
        self.write("broken.mesh", ascii_file(broken))
        self.run_camber("repair", "broken.mesh", "-o", "r.mesh", "--report", "r.json", "--set",
                        "stages/relax/vertices=keep", codes=(0, 1))
        yield report_of(self.folder.path / "r.json")
        self.run_camber("convert", "broken.mesh", "-o", "broken.msh")  # its elements have tags
        self.run_camber("repair", "broken.msh", "-o", "r.mesh", "--report", "r.json", "--set",
                        "stages/relax/vertices=keep", codes=(0, 1))
        yield report_of(self.folder.path / "r.json")

    def checks(self):
        straight = cube(1)
        straight.cells["Edges"] = gmf.Cells(np.array([[0, 1]]), np.array([7]))
        self.write("straight.mesh", ascii_file(straight))
        self.write("curved.mesh", ascii_file(elevate(cube(1))))
        broken = block()
        centre_out(broken)
        self.write("broken.mesh", ascii_file(broken))
        for name in ("straight.mesh", "curved.mesh", "broken.mesh", "out.meshb"):
            yield json.loads(self.run_camber("check", name, "--json", "--elements", codes=(0, 1)).stdout)
        one = lattice(3, 1)  # and another one that crosses it
        n = len(one.points)
        self.write("crossing.mesh", Mesh(np.concatenate([one.points, one.points + [0.5, 0.3, 0.2]]),
                                         one.elements + [tuple(v + n for v in e) for e in one.elements],
                                         one.facets + [tuple(v + n for v in f) for f in one.facets]).text().encode())
        yield json.loads(self.run_camber("check", "crossing.mesh", "--json", codes=(1,)).stdout)
        self.write("overlapping.mesh", joined(lattice(3, 3), moved(lattice(3, 2), [1.13] * 3, 0.2)).text().encode())
        yield json.loads(self.run_camber("check", "overlapping.mesh", "--json", codes=(1,)).stdout)
        self.write("wall.msh", tagged([(0, 0), (1, -0.1), (2, 0), (1, 1)], [(1, 2, 3), (1, 4, 3)]))
        self.write("twice.msh", tagged([(0, 0), (4, 0), (0, 4), (1, 1), (2, 1), (1, 2)], [(1, 2, 3), (4, 5, 6)]))
        for name in ("wall.msh", "twice.msh"):
            yield json.loads(self.run_camber("check", name, "--json", codes=(1,)).stdout)
        yield json.loads(self.run_camber("check", "curved.mesh", "--json", "--field", "exp(x)").stdout)
        n = len(straight.points)
        self.write("sizes.sol", f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{n}\n1 1\n{'0.5 ' * n}\nEnd\n".encode())
        for name in ("straight.mesh", "curved.mesh"):
            yield json.loads(self.run_camber("check", name, "--json", "--metric", "sizes.sol").stdout)

    def compare(self, section, objects):
        keys, written_keys = documented(section) - {"undecided_element_tags"}, set()  # no element of these meshes is undecided
        if not self.reads_cad():
            keys = {key for key in keys if not key.startswith("boundary.cad.")}
        self.assertGreater(len(keys), 20)
        for one in objects:
            written_keys |= leaves(one)
        for path in sorted(written_keys):
            self.assertTrue(any(holds(key, path) for key in keys), f"docs/report.md does not know {path}")
        for key in sorted(keys):
            self.assertTrue(any(pattern(key).match(path) for path in written_keys), f"docs/report.md has {key}, which nothing writes")

    # Guards against a memory peak that each stage resets.
    def test_the_reported_peak_memory_agrees_with_that_of_the_process(self):
        process = subprocess.Popen([CAMBER, "run", str(CONFIGS / "spheres.json"), "--set", 'output={"report": "r.json"}'],
                                   cwd=self.folder.name, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        peaks = [stage["peak_bytes"] for stage in report_of(self.folder.path / "r.json")["stages"]]
        self.assertEqual(peaks, sorted(peaks))
        self.assertLessEqual(peaks[-1], 1024 * usage.ru_maxrss)
        self.assertGreater(peaks[-1], 512 * usage.ru_maxrss)

    def test_documented_and_written_keys_of_reports_agree(self):
        self.compare("report.json", self.reports())

    def test_a_run_prints_a_short_summary_with_validity_first(self):
        self.run_camber("generate", "shell", "-o", "ball.mesh", "--elements", "500")
        for words in (("curve", "ball.mesh", "-o", "round.meshb", "--report", "r.json"),
                      ("repair", "round.meshb", "-o", "out.meshb"),
                      ("curve", "ball.mesh", "-o", "out.meshb", "--cad", CAD_MODEL, "--set", "output/distances=both")):
            if words[-1] != "output/distances=both" or self.reads_cad():
                done = self.run_camber(*words, codes=(0, 1, 3))
                lines = [line for line in done.stdout.splitlines() if line]
                self.assertLessEqual(len(lines), 12, done.stdout)
                if done.returncode != 3:
                    self.assertRegex(lines[0], "^  valid +yes: all|^  valid +NO: ")
                    self.assertTrue(all(len(line) < 130 for line in lines), done.stdout)

    def test_verbose_prints_each_key_of_the_report(self):
        self.run_camber("generate", "shell", "-o", "ball.mesh", "--elements", "500")
        done = self.run_camber("curve", "ball.mesh", "-o", "round.meshb", "--report", "r.json", "--verbose")
        titles = {line.strip().split("  ")[0] for line in done.stdout.splitlines()}
        hidden = {"format", "program", "input", "config", "units", "histograms", "notices", "misses", "stages"}
        for path in leaves({k: v for k, v in report_of(self.folder.path / "r.json").items() if k not in hidden}):
            for key in path.replace("[]", "").split("."):
                self.assertIn(key.replace("_", " "), titles)

    def test_docs_report_md_is_up_to_date(self):
        self.assertEqual(PAGE.read_text(encoding="utf-8"), report_page.page(CAMBER),
                         "python3 tests/pipelines/report_page.py build/bin/camber --write")

    def test_documented_and_written_keys_of_check_agree(self):
        self.config("spheres")
        self.compare("check --json", self.checks())

    def test_the_report_describes_program_input_and_threads(self):
        mesh = cube(2)
        self.write("in.mesh", ascii_file(mesh))
        sizes = np.full((len(mesh.points), 1), 0.5)
        self.write("in.solb", solution_file(sizes, 1, 3))
        self.run_camber("curve", "in.mesh", "-o", "out.mesh", "--metric", "in.solb", "--report", "r.json",
                        "--threads", "4096", "--set", "stages/curve/objective=length")
        report = report_of(self.folder.path / "r.json")
        self.assertEqual(report["format"], 5)
        version = self.run_camber("--version").stdout.strip()
        self.assertEqual(report["program"], {"name": "camber", "version": version})
        self.assertEqual(report["input"], {"mesh": "in.mesh", "metric": "in.solb", "dimension": 3, "degree": 1,
                                           "vertices": len(mesh.points), "elements": len(mesh.cells["Tetrahedra"].nodes),
                                           "facets": len(mesh.cells["Triangles"].nodes)})
        self.assertEqual(report["threads"], len(os.sched_getaffinity(0)))
        self.assertEqual(report["boundary"]["geometry"], "surrogate")

    def test_the_config_in_the_report_repeats_the_run(self):
        report = self.config("spheres", "threads=1")
        self.assertEqual((report["threads"], report["input"]["mesh"]), (1, None))
        first = (self.folder.path / "out.meshb").read_bytes()
        (self.folder.path / "again.json").write_text(json.dumps(report["config"]))
        printed = json.loads(self.run_camber("run", "again.json", "--print-config").stdout)
        self.assertEqual(printed, report["config"])
        self.run_camber("run", "again.json")
        self.assertEqual((self.folder.path / "out.meshb").read_bytes(), first)
        self.assertEqual(report_of(self.folder.path / "r.json")["config"], report["config"])


class Summary(unittest.TestCase):
    """The table of a run without --verbose."""

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def write(self, name, mesh):
        (self.folder.path / name).write_text(mesh.text())

    def table(self, *arguments, code=0):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return {line[2:36].strip(): line[36:] for line in done.stdout.splitlines() if line.startswith("  ")}

    def triangle(self, *points):
        return Mesh([(0, 0), (1, 0), (0, 1), *points], [tuple(range(3 + len(points)))], [], 2 if points else 1)

    def test_the_summary_uses_the_singular_for_one_element(self):
        self.write("one.mesh", self.triangle())
        self.assertEqual(self.table("curve", "one.mesh", "-o", "out.mesh")["valid"], "yes: 1 triangle")

    def test_elements_that_overlap_have_a_row(self):
        self.write("two.mesh", joined(lattice(3, 3), moved(lattice(3, 2), (1.13, 1.13, 1.13), 0.2)))
        table = self.table("curve", "two.mesh", "-o", "out.mesh", code=1)
        self.assertRegex(table["elements that overlap"], r"^in \d+ places?, one at \(1\.")

    def test_boundary_nodes_that_a_repair_moves_have_a_row(self):
        self.write("bad.mesh", self.triangle((0.5, 0.9), (0.5, 0.5), (0, 0.5)))
        table = self.table("repair", "bad.mesh", "-o", "out.mesh", "--boundary-tolerance", 1)
        self.assertRegex(table["boundary nodes moved by repair"], r"^3, by up to 0\.\d+ \(0\.\d+ of the edge\)$")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
