#!/usr/bin/env python3
"""Errors of Poisson's solution on meshes adapted with a solver in the loop: a layer on a curved wall, exp(-(r - 1)/0.05) between two circles.

    bench/adaptation_solved.py build/bin/camber build/bin/poisson [--complexities 200,400,800,1600] [--json FILE]

Ways, all with elements of degree 2 and the metric of third derivatives:
    chords      straight everywhere, `camber adapt --degree 1` with the exact field (files of straight meshes have no edge nodes). The
                equations are solved on the meshes of the last cycles, with exact values at the chords, which a solver would not have
    walls       solved in each cycle; elements are straight inside and follow the wall (stage curve with the objective shape)
    curved      solved in each cycle; `camber adapt --solve`

A cell has the errors of the last cycle in L2 and H1, the minimum and maximum L2 error of the last three cycles, and the seconds of all cycles with
the solver. Rates and "fewer" are as in adaptation.py.
"""
import argparse
import json
import os
import tempfile
import time

from adaptation import ERRORS, LAST, SPHERES, cell, cycles_of, gains_of, rate, spread
from program import Program

FIELD = "exp(-(sqrt(x^2+y^2)-1)/0.05)"
ANNULUS = ("annulus", "--elements", 1000, "--set", "outer_radius=2")
WAYS = ("chords", "walls", "curved")


class Bench:
    def __init__(self, options):
        self.camber, self.poisson = Program(os.path.abspath(options.camber)), Program(os.path.abspath(options.poisson))
        self.cycles = options.cycles
        self.solve = [self.poisson.path, "{mesh}", "--field", FIELD, "--solution", "{solution}", "--threads", "1"]

    def config(self, complexity):
        """Returns the config of `camber adapt --solve` with straight inner edges."""
        return {"input": {"mesh": "first.meshb"}, "geometry": SPHERES, "metric": {"solution": {}}, "threads": 1,
                "stages": ["elevate", "remesh", {"curve": {"objective": "shape"}}, "validate", "relax", "commit"],
                "adapt": {"cycles": self.cycles, "complexity": [complexity], "convergence_tolerance": 0, "exact": FIELD, "solve": self.solve, "folder": "cycles"},
                "output": {"mesh": "last.meshb"}}

    def adapt(self, way, complexity):
        """Writes the cycles to cycles/."""
        if way == "walls":
            with open("config.json", "w", encoding="utf-8") as file:
                json.dump(self.config(complexity), file)
            self.camber("run", "config.json", "--allow-commands")
            return
        own = ("--degree", 1, "--set", "metric/solution/degree=2") if way == "chords" else ("--solve", " ".join(self.solve))
        self.camber("adapt", "first.meshb", "--field", FIELD, *own, "--complexity", complexity, "--cycles", self.cycles, "--convergence-tolerance", 0,
                    "--geometry", json.dumps(SPHERES), "--threads", 1, "--folder", "cycles", "-o", "last.meshb")

    def errors_by_cycle(self, way):
        """Yields the errors of the solutions, by cycle."""
        if way == "chords":
            for cycle in range(1, len(cycles_of("cycles"))):
                yield json.loads(self.poisson(f"cycles/cycle-{cycle:03}/mesh.meshb", "--field", FIELD, "--json", "--threads", 1))[0]
            return
        for row in cycles_of("cycles")[1:]:
            yield row.get("solution_error", {}) | {"unknowns": row["unknowns"]}

    def run(self, way, complexity):
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            self.camber("generate", *ANNULUS, "-o", "first.meshb")
            begin = time.perf_counter()
            self.adapt(way, complexity)
            seconds = time.perf_counter() - begin
            every = [row for row in self.errors_by_cycle(way) if "l2" in row]
            os.chdir("/")
        last = every[-LAST:]
        return ({key: last[-1][key] for key in ("unknowns", *ERRORS)} | spread(last)
                | {"complexity": complexity, "seconds": seconds, "invalid": 0, "missing": self.cycles - len(every)})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("poisson")
    parser.add_argument("--complexities", default="200,400,800,1600,3200", help="comma-separated (%(default)s)")
    parser.add_argument("--cycles", type=int, default=8, help="cycles of each run (%(default)s)")
    parser.add_argument("--json", help="also write all measurements to this file")
    options = parser.parse_args()
    bench = Bench(options)
    found = {way: [] for way in WAYS}
    target = options.json and os.path.abspath(options.json)
    print(f"| complexity | {' | '.join(WAYS)} |\n" + "|---" * (1 + len(WAYS)) + "|")
    for complexity in map(float, options.complexities.split(",")):
        for way in WAYS:
            found[way].append(bench.run(way, complexity))
        print(f"| {complexity:g} | {' | '.join(cell(found[way][-1]) for way in WAYS)} |", flush=True)
    if len(found["curved"]) > 1:
        print("\n| way | rates in L2, H1 | ratio of unknowns to curved: L2, H1 |\n|---|---|---|")
        for way, rows in found.items():
            gains = gains_of(rows, found["curved"]) if way != "curved" else ""
            print(f"| {way} | {', '.join(f'{rate(rows, error)[0]:.2f}' for error in ERRORS)} | {gains} |")
    if target:
        with open(target, "w", encoding="utf-8") as file:
            json.dump(found, file, indent=1)


if __name__ == "__main__":
    main()
