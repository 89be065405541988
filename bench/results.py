"""Runs the commands behind docs/results.md and keeps what their reports say in docs/results.json.

    /usr/bin/python3 bench/results.py build/bin/camber MESHES                     # all tables: half an hour, most of it for curvature
    /usr/bin/python3 bench/results.py build/bin/camber MESHES --only shape paper  # these anew, the others as they are
    python3 bench/result_pages.py                                                 # then: writes them into the pages

MESHES is a folder with the meshes that docs/results.md describes; what needs none of them runs without. Each table is of
the defaults but for the settings that its command names, and pages show the command that is called here. Values are plain numbers by
table, row and column.
"""
import argparse
import ast
import datetime
import json
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import curvature
import repair_bounds

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results.json"
ORACLE = ROOT / "tests" / "oracle"
MESHES = ["spheres-coarse", "spheres-fine", "layer-single", "layer-double", "cube-cylinder", "polar-100k"]
WITH_METRIC = {"polar-100k"}  # by NAME.solb
SPHERES = {"spheres-coarse": {1: 5, 2: 1}, "spheres-fine": {1: 5, 2: 1},  # radius by reference
           "layer-single": {1: 1, 2: 5}, "layer-double": {1: 1, 2: 5}}
PAPER = ["paper-spheres-coarse", "paper-spheres-fine", "paper-layer-single", "paper-layer-double"]
PAPERS = {"stages/curve/objective": "energy", "stages/curve/back_mesh": "straight",  # the paper's way, as far as ours has it
          "stages/validate/min_scaled_jacobian": "1e-9", "stages/relax/min_scaled_jacobian": "1e-9",
          "stages/relax/target": "0.01", "stages/relax/repair": "cavity"}


REINSERT = ('stages=["elevate",{"reinsert":{"curve":{"objective":"energy","back_mesh":"straight"},'
            '"relax":{"min_scaled_jacobian":1e-9,"target":0.01}}}]')


def settings(options):
    return tuple(f"{key}={value}" for key, value in options.items())


ENERGY = settings(PAPERS)


def way(name, of_config):
    """The settings of a way to correct; the configs of the paper's cases name the paper's by themselves."""
    if name == "reinsert":
        return (REINSERT,)
    own = {} if name == "default" else {"stages/relax/repair": name}
    return settings(own if of_config else PAPERS | own)


@dataclass(frozen=True)
class Run:
    """One run of the program: what the table's command line shows is what is called."""
    case: str  # of a mesh of the folder, or of a config
    settings: tuple = ()
    of_config: bool = False

    def words(self, files=lambda name: name):
        """The arguments; `files` tells where a file of this name is."""
        if self.of_config:
            words = ["run", files(f"configs/{self.case}.json")]
        else:
            words = ["curve", files(f"{self.case}.meshb"), "-o", "out.meshb"]
            words += ["--metric", files(f"{self.case}.solb")] if self.case in WITH_METRIC else []
        return words + [part for setting in self.settings for part in ("--set", setting)]

    def shown(self):
        return "camber " + " ".join(map(shlex.quote, self.words()))


class Program:
    """Camber, and the folder of the meshes."""

    def __init__(self, camber, meshes, threads):
        self.camber, self.meshes, self.threads = camber, meshes, threads

    def file(self, name):
        return ROOT / name if name.startswith("configs/") else self.meshes / name

    def report(self, run):
        """The report of one run."""
        return self.run(run, lambda folder: json.loads((folder / "report.json").read_text()))

    def run(self, run, look):
        """What `look` finds in the folder of a run; exit code 1 is a mesh with elements that are not certified valid."""
        with tempfile.TemporaryDirectory() as folder:
            outputs = json.dumps({"mesh": "out.meshb", "report": "report.json"})
            call = [self.camber, *run.words(self.file), "--threads", self.threads]
            call += ["--set", "output=" + outputs] if run.of_config else ["--report", "report.json"]
            done = subprocess.run([str(x) for x in call], capture_output=True, text=True, cwd=folder)
            if done.returncode not in (0, 1):
                sys.exit(f"results.py: {' '.join(map(str, call))} failed: {done.stderr}")
            print(f"results.py: {run.shown()}", file=sys.stderr, flush=True)
            return look(Path(folder))


def figures(report):
    """What the tables show of a run."""
    curve, validity = report.get("curve", {}), report["validity"]
    before, after = curve.get("before_correction", {}), curve.get("after_correction", {})
    row = {"vertices": report["mesh"]["vertices"], "elements": report["mesh"]["elements"],
           "edges": curve.get("edges"), "volume_edges": curve.get("volume_edges"),
           "reduction_before": before.get("mean_length_reduction"), "reduction": after.get("mean_length_reduction"),
           "largest_reduction": before.get("largest_length_reduction"), "curvature": before.get("mean_curvature"),
           "longer": after.get("longer_edges"),
           "left": repair_bounds.not_good(validity), "smallest": validity["min_scaled_jacobian"],
           "anisotropy": report.get("metric", {}).get("largest_anisotropy"),
           "seconds": sum(stage["seconds"] for stage in report["stages"]),
           "megabytes": max(stage["peak_bytes"] for stage in report["stages"]) / 1e6}
    if row["reduction_before"]:
        row["kept"] = 100 * row["reduction"] / row["reduction_before"]
        row["lost"] = 100 - row["kept"]
    if "validity_before_correction" in report:
        bad = report["validity_before_correction"]
        row |= {"invalid_before": repair_bounds.not_good(bad), "smallest_before": bad["min_scaled_jacobian"]}
    if "relax" in report:
        row |= {key: report["relax"][key] for key in ("corrected_elements", "relaxed_volume_edges",
                                                      "relaxed_surface_edges", "moved_vertices")}
    if "reinsert" in report:
        row |= {key: report["reinsert"][key] for key in ("patches", "sweeps")}
    boundary = report.get("boundary", {})
    row |= {"distance": boundary.get("largest_distance"), "straight_distance": boundary.get("largest_distance_straight")}
    return {key: value for key, value in row.items() if value is not None}


def of_reports(runs):
    """The figures of each row's run."""
    return lambda program, rows: {row: figures(program.report(runs[row])) for row in rows}


def repair(program, rows):
    """The table of bench/repair_bounds.py."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for row in rows:
            name, bound, way = row.rsplit(" ", 2)
            case = next(case for case in REPAIRED if repair_bounds.name_of(case) == name)
            case = case if case.startswith("steep:") else str(program.file(case))
            found[row] = repair_bounds.figures(repair_bounds.repaired(program.camber, case, bound, way, Path(folder)))
            print(f"results.py: {row}", file=sys.stderr, flush=True)
    return found


def distances(runs):
    """Of the boundary from the exact spheres, which the program does not know, sampled by the oracle."""
    def measure(program, rows):
        found = {}
        for row in rows:
            case, radius = row.rsplit(" ", 1)
            reference = next(key for key, value in SPHERES[case].items() if f"{value:g}" == radius)

            def look(folder):
                check = [ORACLE / "check_p2.py", folder / "out.meshb", "--planes", "--sphere", f"{reference},{radius}"]
                told = subprocess.run([sys.executable, *check], capture_output=True, text=True).stdout
                return next(line for line in told.splitlines() if line.startswith("spheres: "))
            sphere = ast.literal_eval(program.run(runs[row], look).removeprefix("spheres: "))[0]
            found[row] = {key: sphere[key] for key in ("cells", "straight", "curved", "ratio")}
        return found
    return measure


def curves(program, rows):
    """L2 and H1 errors of fields, interpolated and solved, by bench/curvature.py, and what each mesh took."""
    found, bench = {}, curvature.Bench(program.camber, program.meshes, program.threads)
    for row in rows:
        name, way = row.split(", ")
        found[row] = curvature.figures(bench, name, way)
        print(f"results.py: curvature of {row}", file=sys.stderr, flush=True)
    return found


def lines_of(runs):
    """A command line for each way of the rows, of the first case that goes it."""
    ways = {}
    for run in runs.values():
        ways.setdefault((run.settings, run.of_config, run.case in WITH_METRIC), run.shown())
    return "\n".join(ways.values())


@dataclass(frozen=True)
class Table:
    of: str  # what it is of, where that is not the defaults
    command: str
    rows: tuple
    measure: object  # of a program and rows: {row: {column: value}}


def by_runs(of, runs, measure=None, more=""):
    return Table(of, lines_of(runs) + more, tuple(runs), (measure or of_reports)(runs))


def by_case(cases, options=(), of_config=False):
    return {case: Run(case, tuple(options), of_config) for case in cases}


def by_way(cases, ways, of_config=False):
    return {f"{case} {name}": Run(case, way(name, of_config), of_config) for case in cases for name in ways}


ALL_CONFIGS = sorted(path.stem for path in (ROOT / "configs").glob("*.json") if path.stem != "schema")
REPAIRED = [*(f"{name}.meshb" for name in MESHES[:2]), *(f"configs/{name}.json" for name in PAPER[:2]),
            *(f"{name}.meshb" for name in MESHES[2:4]), "steep:1.4", "steep:1.6"]
TABLES = {
    "configs": by_runs("the defaults of each config", by_case(ALL_CONFIGS, of_config=True)),
    "curving": by_runs("the objective energy in the straight field, repaired by cavities", by_case(MESHES, ENERGY)),
    "shape": by_runs("the objective shape, else the defaults", by_case(MESHES[:5], ["stages/curve/objective=shape"])),
    "relaxation": by_runs("the objective energy in the straight field, stages/relax/repair=relax and =segment",
                          by_way(MESHES, ["relax", "segment"]) | by_way(PAPER[:1], ["relax", "segment"], of_config=True)),
    "reinsert": by_runs("the stage reinsert by the objective energy in the straight field",
                        by_case(MESHES, [REINSERT]) | by_case(["coated-sphere"], [REINSERT], of_config=True)),
    "paper": by_runs("the objective energy in the straight field, which the configs name, and two other ways",
                     by_way(PAPER, ["default", "relax", "reinsert"], of_config=True)),
    "starts": by_runs("the objective energy in the straight field, length reductions before correction (so the quickest is taken), with "
                      "stages/curve/length_tolerance=0 and with its default",
                      {f"{case} {end}": Run(case, (*way("relax", False), *more)) for case in MESHES[:4]
                       for end, more in {"energy": ["stages/curve/length_tolerance=0"], "length": []}.items()}),
    "distances": by_runs("the objective energy in the straight field; the surrogate is made from the mesh alone",
                         {f"{case} {radius:g}": Run(case, ENERGY) for case, spheres in SPHERES.items()
                          for radius in sorted(spheres.values(), reverse=True)}, distances,
                         "\npython3 tests/oracle/check_p2.py out.meshb --planes --sphere REFERENCE,RADIUS"),
    "repair": Table("the objective energy, stages/relax/repair=WAY, bounds by stages/validate and relax/min_scaled_jacobian",
                    "python3 bench/repair_bounds.py build/bin/camber " + " ".join(REPAIRED),
                    tuple(f"{repair_bounds.name_of(case)} {bound} {way}" for case in REPAIRED
                          for bound in ("0", "0.05", "0.2", "0.5") for way in ("relax", "edge", "cavity", "extension")), repair),
    "curvature": Table("errors of fields by shape and other ways, else the defaults; metric and solution: of each field",
                       "/usr/bin/python3 bench/curvature.py build/bin/camber MESHES --meshes " + ",".join(curvature.SHOWN),
                       tuple(f"{name}, {way}" for name in curvature.SHOWN for way in curvature.ways_of(name)),
                       curves),
}


def rounded(value):
    """Six digits: more than a page quotes, and less than a number of rounding errors would change."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def measured(name, program, rows=None):
    """A table, or some rows of it, measured now."""
    table = TABLES[name]
    found = table.measure(program, rows or table.rows)
    return {"of": table.of, "command": table.command, "made": datetime.date.today().isoformat(), "threads": program.threads,
            "rows": {row: {key: rounded(x) for key, x in one.items()} for row, one in found.items()}}


def as_text(tables):
    """JSON with one line a row."""
    def lines(things, indent, write):
        return ",\n".join(f"{' ' * indent}{json.dumps(key, ensure_ascii=False)}: {write(x)}" for key, x in things.items())

    def table(one):
        rest = lines({key: x for key, x in one.items() if key != "rows"}, 2, lambda x: json.dumps(x, ensure_ascii=False))
        return "{\n" + rest + ',\n  "rows": {\n' + lines(one["rows"], 3, json.dumps) + "}}"
    return "{\n" + lines(tables, 1, table) + "}\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber", type=lambda path: str(Path(path).resolve()), help="the program")
    parser.add_argument("meshes", type=lambda path: Path(path).resolve(), help="folder of the meshes")
    parser.add_argument("--only", nargs="+", choices=TABLES, default=list(TABLES))
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--output", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    program = Program(arguments.camber, arguments.meshes, arguments.threads)
    for name in arguments.only:
        all_tables = json.loads(arguments.output.read_text()) if arguments.output.exists() else {}
        all_tables[name] = measured(name, program)
        arguments.output.write_text(as_text({key: all_tables[key] for key in TABLES if key in all_tables}))


if __name__ == "__main__":
    main()
