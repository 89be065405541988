#!/usr/bin/env python3
"""Prints a Markdown table of time and memory of `camber curve` by number of elements.

    bench/scale.py build/bin/camber [--elements 1e5,1e6,5e6,2e7] [--threads 2]

The meshes are shells with ten layers (`camber generate shell --structure prisms`), curved with the defaults: natural metric, curved
back mesh, certificate and repair included. Peaks are those of the process.
"""
import argparse
import json
import subprocess
import tempfile
from pathlib import Path

STAGES = ("prepare", "elevate", "surface", "extension", "metric", "curve", "validate", "measure")
LAYERS = ("--set", "inner_layer/count=10", "--set", "inner_layer/first_height=0.002")


def report_of(camber, elements, threads):
    """Returns the report of curving one shell."""
    with tempfile.TemporaryDirectory() as folder:
        def run(*words):
            subprocess.run([camber, *map(str, words), "--quiet"], cwd=folder, check=True)
        run("generate", "shell", "--structure", "prisms", *LAYERS, "--elements", elements, "-o", "g.meshb")
        run("curve", "g.meshb", "-o", "o.meshb", "--report", "r.json", "--threads", threads)
        return json.loads(Path(folder, "r.json").read_text(encoding="utf-8"))


def row(report):
    """Returns the cells of one mesh."""
    seconds, elements = {}, report["mesh"]["elements"]
    for stage in report["stages"]:
        seconds[stage["stage"]] = seconds.get(stage["stage"], 0) + stage["seconds"]
    peak = max(stage["peak_bytes"] for stage in report["stages"])
    files = seconds.get("read", 0) + seconds.get("write", 0)
    return [f"{elements:,}".replace(",", " "), f"{report['validity']['min_scaled_jacobian']:.2f}",
            *(f"{seconds.get(stage, 0):.2f}" for stage in STAGES), f"{files:.2f}", f"{sum(seconds.values()):.1f}",
            f"{peak / 2**20:.0f}", f"{peak / elements:.0f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber", type=lambda path: str(Path(path).resolve()))
    parser.add_argument("--elements", default="1e5,1e6,5e6,2e7", help="comma-separated (%(default)s)")
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    titles = ["tetrahedra", "smallest scaled Jacobian", *(f"{stage}, s" for stage in STAGES), "files, s", "all, s", "peak, MiB", "bytes a tetrahedron"]
    print("| " + " | ".join(titles) + " |\n" + "|---" * len(titles) + "|")
    for elements in options.elements.split(","):
        print("| " + " | ".join(row(report_of(options.camber, elements, options.threads))) + " |", flush=True)


if __name__ == "__main__":
    main()
