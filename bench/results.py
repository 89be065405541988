"""Runs the commands behind docs/results.md and keeps what their reports say in docs/results.json.

    /usr/bin/python3 bench/results.py build/bin/camber MESHES                     # all tables: a quarter of an hour
    /usr/bin/python3 bench/results.py build/bin/camber MESHES --only shape paper  # these anew, the others as they are
    python3 bench/result_pages.py                                                 # then: writes them into the pages

MESHES is a folder with the meshes that docs/results.md describes; what needs none of them runs without. Each table is of
the defaults but for the settings that its command names. Values are plain numbers by table, row and column.
"""
import argparse
import ast
import datetime
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import repair_bounds

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results.json"
ORACLE = ROOT / "tests" / "oracle"
MESHES = ["spheres-coarse", "spheres-fine", "layer-single", "layer-double", "cube-cylinder", "polar-100k"]
PAPER = ["paper-spheres-coarse", "paper-spheres-fine", "paper-layer-single", "paper-layer-double"]
PAPERS = {"stages/curve/objective": "energy", "stages/curve/back_mesh": "straight",  # the paper's way, as far as ours has it
          "stages/validate/min_scaled_jacobian": "1e-9", "stages/relax/min_scaled_jacobian": "1e-9",
          "stages/relax/target": "0.01", "stages/relax/repair": "cavity"}
ENERGY = [f"{key}={value}" for key, value in PAPERS.items()]
WAYS = {"default": ENERGY, "relax": [*ENERGY, "stages/relax/repair=relax"],
        "segment": [*ENERGY, "stages/relax/repair=segment"],
        "reinsert": ['stages=["elevate",{"reinsert":{"curve":{"objective":"energy","back_mesh":"straight"},'
                     '"relax":{"repair":"cavity","min_scaled_jacobian":1e-9,"target":0.01}}}]']}


class Program:
    """Camber, on cases that are the name of a config or of a mesh in the folder."""

    def __init__(self, camber, meshes, threads):
        self.camber, self.meshes, self.threads = camber, meshes, threads

    def arguments(self, case, folder):
        outputs = {"mesh": str(folder / "out.meshb"), "report": str(folder / "report.json")}
        config = ROOT / "configs" / f"{case}.json"
        if case not in MESHES:
            return ["run", config, "--set", "output=" + json.dumps(outputs)]
        arguments = ["curve", self.meshes / f"{case}.meshb", "-o", outputs["mesh"], "--report", outputs["report"]]
        metric = self.meshes / f"{case}.solb"
        return arguments + (["--metric", metric] if metric.exists() else [])

    def report(self, case, settings=()):
        """The report of one run."""
        return self.run(case, settings, lambda folder: json.loads((folder / "report.json").read_text()))

    def run(self, case, settings, look):
        """What `look` finds in the folder of a run; exit code 1 is a mesh with elements that are not certified valid."""
        with tempfile.TemporaryDirectory() as folder:
            call = [self.camber, *self.arguments(case, Path(folder)), "--threads", self.threads]
            for setting in settings:
                call += ["--set", setting]
            done = subprocess.run([str(x) for x in call], capture_output=True, text=True, cwd=folder)
            if done.returncode not in (0, 1):
                sys.exit(f"results.py: {' '.join(map(str, call))} failed: {done.stderr}")
            print(f"results.py: {case} {' '.join(settings)}", file=sys.stderr, flush=True)
            return look(Path(folder))


def figures(report):
    """What the tables show of a run."""
    curve, validity = report.get("curve", {}), report["validity"]
    before, after = curve.get("before_correction", {}), curve.get("after_correction", {})
    row = {"vertices": report["mesh"]["vertices"], "elements": report["mesh"]["elements"],
           "edges": curve.get("edges"), "volume_edges": curve.get("volume_edges"),
           "gain_before": before.get("mean_gain"), "gain": after.get("mean_gain"),
           "largest_gain": before.get("largest_gain"), "curvature": before.get("mean_curvature"),
           "longer": after.get("longer_edges"),
           "left": repair_bounds.not_good(validity), "smallest": validity["min_scaled_jacobian"],
           "anisotropy": report.get("metric", {}).get("largest_anisotropy"),
           "seconds": sum(stage["seconds"] for stage in report["stages"]),
           "megabytes": max(stage["peak_bytes"] for stage in report["stages"]) / 1e6}
    if row["gain_before"]:
        row["kept"] = 100 * row["gain"] / row["gain_before"]
        row["lost"] = 100 - row["kept"]
    if "validity_before_correction" in report:
        bad = report["validity_before_correction"]
        row |= {"invalid_before": repair_bounds.not_good(bad), "smallest_before": bad["min_scaled_jacobian"]}
    if "relax" in report:
        row |= {key: report["relax"][key] for key in ("corrected_elements", "relaxed_volume_edges",
                                                      "relaxed_surface_edges", "moved_vertices")}
    if "reinsert" in report:
        row |= {key: report["reinsert"][key] for key in ("patches", "turns")}
    boundary = report.get("boundary", {})
    row |= {"distance": boundary.get("largest_distance"), "straight_distance": boundary.get("largest_distance_straight")}
    return {key: value for key, value in row.items() if value is not None}


def by_case(cases, settings=()):
    return lambda program: {case: figures(program.report(case, settings)) for case in cases}


def by_way(cases, ways):
    return lambda program: {case + " " + way: figures(program.report(case, WAYS[way])) for case in cases for way in ways}


def starts(program):
    """Gains before correction; the correction is the quickest, since it does not matter."""
    quick = WAYS["relax"]
    ends = {"energy": ["stages/curve/length_tolerance=0"], "length": []}
    return {f"{case} {end}": figures(program.report(case, [*quick, *more]))
            for case in MESHES[:4] for end, more in ends.items()}


def repair(program):
    """The table of bench/repair_bounds.py."""
    cases = [program.meshes / f"{MESHES[i]}.meshb" for i in range(2)]
    cases += [ROOT / "configs" / f"{name}.json" for name in PAPER[:2]]
    cases += [program.meshes / f"{name}.meshb" for name in ("layer-single", "layer-double")] + ["steep:1.4", "steep:1.6"]
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        for case in map(str, cases):
            for bound in ("0", "0.05", "0.2", "0.5"):
                name = case if case.startswith("steep:") else Path(case).stem
                for way in ("relax", "edge", "cavity", "extension"):
                    report = repair_bounds.repaired(program.camber, case, bound, way, Path(folder))
                    rows[f"{name} {bound} {way}"] = repair_bounds.figures(report)
                print(f"results.py: {name} {bound}", file=sys.stderr, flush=True)
    return rows


def distances(program):
    """Of the boundary from the exact spheres, which the program does not know, sampled by the oracle."""
    rows = {}
    for case in MESHES[:4]:
        def look(folder):
            check = [ORACLE / "check_p2.py", folder / "out.meshb", "--planes", "--sphere", "1,5", "--sphere", "2,1"]
            found = subprocess.run([sys.executable, *check], capture_output=True, text=True).stdout
            return next(line for line in found.splitlines() if line.startswith("spheres: "))
        for sphere in ast.literal_eval(program.run(case, ENERGY, look).removeprefix("spheres: ")):
            rows[f"{case} {sphere['radius']:g}"] = {key: sphere[key] for key in ("cells", "straight", "curved", "ratio")}
    return rows


CURVE = "camber curve MESH.meshb -o out.meshb --report report.json"
BY_ENERGY = CURVE + "".join(f" --set {setting}" for setting in ENERGY)
RUN = "camber run configs/NAME.json --set output/report=report.json"
TABLES = {  # name: what it is of, the command, and who measures it
    "configs": ("the defaults of each config", RUN, by_case(sorted(p.stem for p in (ROOT / "configs").glob("*.json")
                                                                   if p.stem != "schema"))),
    "curving": ("the objective energy in the straight field, else the defaults; polar-100k with --metric polar-100k.solb", BY_ENERGY,
                by_case(MESHES, ENERGY)),
    "shape": ("the objective shape, else the defaults", CURVE + " --set stages/curve/objective=shape",
              by_case(MESHES[:5], ["stages/curve/objective=shape"])),
    "relaxation": ("the objective energy in the straight field and stages/relax/repair=relax and =segment, which are not the defaults",
                   BY_ENERGY + " --set stages/relax/repair=WAY",
                   by_way([*MESHES, "paper-spheres-coarse"], ["relax", "segment"])),
    "reinsert": ("the stage reinsert by the objective energy in the straight field, which are not the defaults", CURVE + f" --set '{WAYS['reinsert'][0]}'",
                 by_case([*MESHES, "coated-sphere"], WAYS["reinsert"])),
    "paper": ("the objective energy in the straight field, which the configs name, and two other ways", RUN, by_way(PAPER, ["default", "relax", "reinsert"])),
    "starts": ("the objective energy in the straight field, gains before correction, with stages/curve/length_tolerance=0 and with its default",
               BY_ENERGY, starts),
    "distances": ("the objective energy in the straight field, else the defaults; the surrogate is made from the mesh alone",
                  BY_ENERGY + "; python3 tests/oracle/check_p2.py out.meshb --planes --sphere 1,5 --sphere 2,1", distances),
    "repair": ("the objective energy, stages/relax/repair=WAY, bounds by stages/validate and relax/min_scaled_jacobian",
               "python3 bench/repair_bounds.py build/bin/camber CASE …", repair),
}


def rounded(value):
    """Six digits: more than a page quotes, and less than a number of rounding errors would change."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def measured(name, program):
    of, command, measure = TABLES[name]
    rows = {row: {key: rounded(x) for key, x in found.items()} for row, found in measure(program).items()}
    return {"of": of, "command": command, "made": datetime.date.today().isoformat(), "threads": program.threads,
            "rows": rows}


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
