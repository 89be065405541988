#!/usr/bin/env python3
"""Cost of a bound on the scaled Jacobian: the loss of length reduction by θ-relaxation (paper), single edges, cavities and extension.

    bench/repair_bounds.py build/bin/camber configs/paper-spheres-coarse.json layer.meshb steep:1.4
    bench/repair_bounds.py build/bin/camber steep:1.6 --bounds 0.05 --ways backtracking cavity

Each CASE is a configuration, a mesh, or steep:G: generated layers of growth G around a sphere (the first height is a tenth of
the sagitta of the wall); steep:thin has growth 1.6 and anisotropy 10^4. Prints a Markdown table, a line per case and bound:
elements below the bound before repair; then for each way the loss of mean length reduction as a share of the loss by θ-relaxation,
the minimum scaled Jacobian, relaxed surface edges, elements that remain below the bound, and seconds of the stage.
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

STEEP = {  # layers: first height, growth, count
    "1.4": (0.0026, 1.4, 10),
    "1.6": (0.0026, 1.6, 8),
    "thin": (4.6e-5, 1.6, 17),
}


def steep(name):
    """Layers whose first height is below the sagitta of the wall facets."""
    first, growth, count = STEEP[name]
    layer = {"count": count, "first_height": first, "growth": growth}
    return {"input": {"generate": {"shell": {"inner_size": 0.46, "outer_size": 1.75, "inner_layer": layer}}},
            "stages": ["elevate", {"curve": {"objective": "energy"}}, {"validate": {}}, {"relax": {}}, "commit"], "output": {}}


def name_of(case):
    return case if case.startswith("steep:") else Path(case).stem


def command(camber, case, folder, report):
    """Returns the arguments of the program for a case without settings."""
    mesh = folder / "out.meshb"
    if case.endswith(".json") or case.startswith("steep:"):
        config = Path(case)
        if case.startswith("steep:"):
            config = folder / "steep.json"
            config.write_text(json.dumps(steep(case.removeprefix("steep:"))))
        return [camber, "run", config, "--set", f"output/mesh={mesh}", "--set", f"output/report={report}"]
    return [camber, "curve", case, "-o", mesh, "--report", report]


def repaired(camber, case, bound, way, folder):
    """Returns the report of one run. Exit code 1 means elements below the bound."""
    report = folder / "report.json"
    call = [*command(camber, case, folder, report), "--set", "stages/curve/objective=energy"]
    for key, value in {"validate/min_scaled_jacobian": bound, "relax/min_scaled_jacobian": bound,
                       "relax/method": way}.items():
        call += ["--set", f"stages/{key}={value}"]
    done = subprocess.run([str(x) for x in call], capture_output=True, text=True)
    if done.returncode not in (0, 1) or not report.exists():
        sys.exit(f"repair_bounds.py: {' '.join(map(str, call))} failed: {done.stderr}")
    return json.loads(report.read_text())


def not_good(validity):
    """Returns the number of elements that are invalid, undecided or below the bound."""
    return validity["invalid"] + validity["undecided"] + validity["below_bound"]


def figures(report):
    curve, validity, relax = report["curve"], report["validity"], report["relax"]
    lost = curve["before_correction"]["mean_length_reduction"] - curve["after_correction"]["mean_length_reduction"]
    left = not_good(validity)
    seconds = sum(s["seconds"] for s in report["stages"] if s["stage"] == "relax")
    before = report["validity_before_correction"]
    return {"lost": lost, "min": validity["min_scaled_jacobian"], "surface": relax["relaxed_surface_edges"], "left": left,
            "seconds": seconds, "vertices": relax["moved_vertices"], "before": not_good(before)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber", help="the program")
    parser.add_argument("cases", nargs="+", metavar="CASE")
    parser.add_argument("--bounds", nargs="+", default=["0", "0.05", "0.2", "0.5"])
    parser.add_argument("--ways", nargs="+", default=["backtracking", "edge", "cavity", "extension"])
    arguments = parser.parse_args()
    print("| case | bound | below it | " + " | ".join(
        f"{way}: lost (of backtracking's), smallest, surface edges, left, time" for way in arguments.ways) + " |")
    print("|---" * (3 + len(arguments.ways)) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for case in arguments.cases:
            for bound in arguments.bounds:
                found = {way: figures(repaired(arguments.camber, case, bound, way, Path(folder)))
                         for way in arguments.ways}
                theirs = found.get("backtracking", {}).get("lost")
                cells = []
                for f in found.values():
                    share = f"{100 * f['lost'] / theirs:.1f} %" if theirs else "–"
                    moved = f", {f['vertices']} vertices" if f["vertices"] else ""
                    cells.append(f"{f['lost']:.2g} ({share}), {f['min']:.2g}, {f['surface']}, {f['left']}, "
                                 f"{f['seconds']:.2f} s{moved}")
                below = next(iter(found.values()))["before"]
                print(f"| {name_of(case)} | {bound} | {below} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
