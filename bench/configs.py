#!/usr/bin/env python3
"""Runs the configs of the project and prints a Markdown table of their reports.

    bench/configs.py build/bin/camber            every config in configs/ with its own options
    bench/configs.py build/bin/camber --paper    the cases of the paper, repaired in three ways, with the figures of the paper

Length reductions and curvatures are means over the volume edges, before and after correction. Seconds are those of all stages.
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
REINSERT = ('stages=["elevate",{"reinsert":{"curve":{"objective":"energy","background_mesh":"straight"},'
            '"relax":{"min_scaled_jacobian":1e-9,"target":0.01}}}]')
WAYS = {"Camber": (), "by θ-relaxation": ("stages/relax/method=backtracking",), "by cavities, `reinsert`": (REINSERT,)}
# The paper's tables: vertices, edges, tetrahedra, corrected, length reduction, preserved, smallest scaled Jacobian, seconds
PAPER = {"paper-spheres-coarse": ("270", "1 552", "1 145", "36", "0.0190 → 0.0178", "94 %", "", "0.023"),
         "paper-spheres-fine": ("3 577", "23 058", "18 517", "627", "0.0093 → 0.0032", "34 %", "", "0.89"),
         "paper-layer-single": ("2 095", "12 182", "9 120", "276", "0.0258 → 0.0192", "74 %", "", "0.26"),
         "paper-layer-double": ("9 372", "63 081", "–", "1 029", "0.0492 → 0.0445", "90 %", "1e-9 over all its cases", "1.56")}
TITLES = ("config", "elements", "length reduction", "preserved", "largest", "mean curvature", "invalid before", "relaxed edges",
          "longer than straight", "smallest scaled Jacobian", "distance to the geometry, straight → curved", "s")
TITLES_OF_PAPER = ("case", "by", "vertices", "edges", "tetrahedra", "corrected", "length reduction", "preserved", "smallest scaled Jacobian", "s")


def report_of(camber, config, settings=()):
    """Returns the report of one run. Exit code 1 means that elements are not certified valid."""
    with tempfile.TemporaryDirectory() as folder:
        words = [camber, "run", ROOT / "configs" / f"{config}.json", "--threads", 2, "--set", 'output={"report": "report.json"}',
                 *(word for setting in settings for word in ("--set", setting))]
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, cwd=folder, check=False)
        if done.returncode not in (0, 1):
            sys.exit(f"configs.py: {config}: {done.stderr}")
        return json.loads(Path(folder, "report.json").read_text(encoding="utf-8"))


def grouped(number):
    return f"{number:,}".replace(",", " ")


def seconds(report):
    return f"{sum(stage['seconds'] for stage in report['stages']):.2g}"


def not_good(validity):
    """Number of elements that are invalid, undecided or below the bound."""
    return validity["invalid"] + validity["undecided"] + validity["below_bound"]


def reductions(report):
    """Returns the mean length reductions before and after correction."""
    return [report["curve"][when]["mean_length_reduction"] for when in ("before_correction", "after_correction")]


def preserved(report, decimals):
    before, after = reductions(report)
    return f"{100 * after / before:.{decimals}f} %" if before else ""


def row(config, report):
    """Returns the cells of one config."""
    before, after = reductions(report)
    curve, relax, boundary = report["curve"], report.get("relax", {}), report["boundary"]
    invalid = not_good(report.get("validity_before_correction", report["validity"]))
    relaxed = f"{relax.get('relaxed_volume_edges', 0)} inside, {relax.get('relaxed_surface_edges', 0)} on the surface"
    return [config, grouped(report["mesh"]["elements"]), f"{before:.5f} → {after:.5f}", preserved(report, 2),
            f"{curve['before_correction']['largest_length_reduction']:.3f}", f"{curve['before_correction']['mean_curvature']:.3f}",
            invalid, relaxed, curve["after_correction"]["longer_edges"], f"{report['validity']['min_scaled_jacobian']:.2g}",
            f"{boundary['largest_distance_straight']:.2g} → {boundary['largest_distance']:.2g}", seconds(report)]


def rows_of_paper(camber, case):
    """Yields the row of the paper and one row for each way of correction."""
    yield [case, "the paper", *PAPER[case]]
    for way, settings in WAYS.items():
        report = report_of(camber, case, settings)
        before, after = reductions(report)
        mesh, first = report["mesh"], not settings
        counts = [grouped(mesh["vertices"]), grouped(report["curve"]["edges"]), grouped(mesh["elements"]),
                  grouped(report["relax"]["corrected_elements"])] if first else [""] * 4
        yield ["", way, *counts, f"{before:.4f} → {after:.4f}" if first else f"→ {after:.4f}", preserved(report, 0),
               f"{report['validity']['min_scaled_jacobian']:.2g}", seconds(report)]


def line(cells):
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber", type=lambda path: str(Path(path).resolve()), help="the program")
    parser.add_argument("--paper", action="store_true", help="the paper's cases")
    options = parser.parse_args()
    titles = TITLES_OF_PAPER if options.paper else TITLES
    line(titles)
    line(["---"] * len(titles))
    if options.paper:
        for case in PAPER:
            for cells in rows_of_paper(options.camber, case):
                line(cells)
        return
    for config in sorted(path.stem for path in (ROOT / "configs").glob("*.json") if path.stem != "schema"):
        line(row(config, report_of(options.camber, config)))


if __name__ == "__main__":
    main()
