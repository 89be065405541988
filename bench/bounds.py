#!/usr/bin/env python3
"""Cost of a bound on the scaled Jacobian with default options: elements below it, and interpolation errors after their repair.

    bench/bounds.py build/bin/camber
    bench/bounds.py build/bin/camber --meshes steep-thin --objective energy
    bench/bounds.py build/bin/camber --folder FOLDER --meshes layer-single

Cases and the folder are those of curvature.py. Prints a Markdown table with one line per case: elements below each bound before repair;
then for each bound the ratio straight/curved of L2 errors of the first fields of the case after repair, elements that remain below the bound,
and seconds of the stage relax.
"""
import argparse
import tempfile
from pathlib import Path

import curvature_cases
import repair_bounds
from curvature_measure import Bench

BOUNDS = (1e-9, 0.05, 0.1, 0.2)


def run(bench, name, objective, bound, folder):
    """Returns the report and the ratios of a case with a required bound."""
    words = [part for setting in (
        f"stages/curve/objective={objective}", f"stages/validate/min_scaled_jacobian={bound}",
        f"stages/relax/min_scaled_jacobian={bound}") for part in ("--set", setting)]
    report = bench.curved(name, words, folder / "out.meshb")
    fields = dict(list(bench.fields(name).items())[:3])
    check = bench.checked(folder / "out.meshb", fields)
    return report, [field["ratio"]["l2"] for field in check["interpolation"]]


def row(bench, name, objective):
    found, after = [], []
    for bound in BOUNDS:
        with tempfile.TemporaryDirectory() as folder:
            report, ratios = run(bench, name, objective, bound, Path(folder))
        found.append(str(repair_bounds.not_good(report["validity_before_correction"])))
        relax = next(s["seconds"] for s in report["stages"] if s["stage"] == "relax")
        after.append(f"{', '.join(f'{r:.2f}' for r in ratios)}; {repair_bounds.not_good(report['validity'])}; {relax:.2f} s")
    return [name, str(report["mesh"]["elements"]), ", ".join(found), *after]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("--folder", default=".", help="folder with meshes of other programs (%(default)s)")
    parser.add_argument("--meshes", default=",".join(name for name, case in curvature_cases.CASES.items() if case.shape),
                        help="comma-separated names (%(default)s)")
    parser.add_argument("--objective", default="accuracy", help="objective of the stage curve (%(default)s)")
    parser.add_argument("--threads", default=1)
    arguments = parser.parse_args()
    bench = Bench(arguments.camber, arguments.folder, arguments.threads)
    bounds = ", ".join(f"{b:g}" for b in BOUNDS)
    print(f"| mesh | elements | below {bounds} before repair | " +
          " | ".join(f"at {b:g}: L2 ratios; left; relax" for b in BOUNDS) + " |\n|" + "---|" * (3 + len(BOUNDS)))
    for name in arguments.meshes.split(","):
        if bench.is_there(name):
            print("| " + " | ".join(row(bench, name, arguments.objective)) + " |", flush=True)


if __name__ == "__main__":
    main()
