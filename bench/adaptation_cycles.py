#!/usr/bin/env python3
"""Errors over many cycles of `camber adapt --field`, and the expected error compared with the true one.

    bench/adaptation_cycles.py build/bin/camber                                all cases, curved and straight
    bench/adaptation_cycles.py build/bin/camber --cases 'S;end' --ways curved --cycles 12
    bench/adaptation_cycles.py build/bin/camber --more cases.json              with additional cases, for example with --cad
    bench/adaptation_cycles.py build/bin/camber --options='--gradation 0'      with options for all cases
    bench/adaptation_cycles.py build/bin/camber --json all.json                writes the rows of all cycles

Ways: curved; straight (`--degree 1 --set metric/solution/degree=2`). Errors of both are those of interpolants of degree 2. "Random" cases have
parameters by their number. "S x 1e9" is the case S with its values multiplied by 1e9. "wall, far" is the case wall without a limit of the distance
from the circle. cases.json: {NAME: {"mesh": FILE, "field": EXPRESSION, "options": [WORD, …]}}.

Columns: unknowns, L2 and H1 error of the mesh with the minimum expected error (without expected errors: the minimum L2 error);
the ratio of maximum and minimum L2 and H1 error of the cycles from `--from` on (default 8); for the same cycles the minimum and maximum ratio of
expected and true error, the minimum quality and share of unit edges; the seconds of all cycles. "n not certified": number of cycles that were
repeated with a smaller step or omitted.
"""
import argparse
import json
import os
import random
import tempfile

from program import Program

SQUARE = ("rectangle", "--set", "cells=[20,20]")
RING = ("annulus", "--elements", 1500, "--set", "outer_radius=2")
CIRCLES = {"analytic": [{"references": [2], "sphere": {"radius": 1}}, {"references": [1], "sphere": {"radius": 2}}]}
S = "tanh((y-0.5-0.25*tanh(6*(x-0.5)))/0.004)"
D2 = "((x-0.5)^2+(y-0.5)^2)"
FIELDS = {"S": S,
          "cross": "tanh((y-0.3-0.4*x^2)/0.006)+0.7*tanh((x-0.35-0.2*sin(3*y))/0.006)",
          "spiral": f"(1-exp(-{D2}^2/0.0004))*tanh(sin(14*sqrt({D2}+1e-12)-2*atan((y-0.5)/(x-0.5+sqrt({D2}+1e-12))))/0.15)",
          "end": "tanh((y-0.5-0.2*sin(4*x))/0.005)*(1-tanh((x-0.6)/0.05))/2",
          "thickness x 100": "tanh((y-0.5-0.15*sin(6*x))/(0.0006*100^x))",
          "r^0.6": "((x-0.371)^2+(y-0.413)^2+1e-18)^0.3",
          "smooth": "sin(7*x+2*y^2)*cos(4*y)",
          "S x 1e-9": f"1e-9*{S}",
          "S x 1e9": f"1e9*{S}"}
WAYS = {"curved": (), "straight": ("--degree", 1, "--set", "metric/solution/degree=2")}


def random_field(seed):
    """Returns a front along a wave or a circle, a layer at a side, a peak and a smooth part, with parameters by the seed."""
    dice = random.Random(seed)
    number = lambda low, high: f"{dice.uniform(low, high):.4g}"
    width = f"{10 ** dice.uniform(-2.7, -1.5):.3g}"
    wave = f"tanh((y-{number(0.3, 0.7)}-{number(0.05, 0.25)}*sin({number(2, 9)}*x+{number(0, 6)}))/{width})"
    circle = f"tanh((sqrt((x-{number(-0.3, 0.3)})^2+(y-{number(-0.3, 0.3)})^2)-{number(0.6, 0.9)})/{width})"
    layer = f"exp(-x/{10 ** dice.uniform(-2.5, -1.5):.3g})"
    peak = f"exp(-((x-{number(0.2, 0.8)})^2+(y-{number(0.2, 0.8)})^2)/{number(0.001, 0.01)})"
    smooth = f"{number(0.1, 1)}*sin({number(2, 8)}*x+{number(2, 8)}*y)"
    return "+".join(dice.sample([wave, circle, layer, peak, smooth], 3))


def own_cases():
    cases = {name: {"mesh": SQUARE, "field": field, "options": []} for name, field in FIELDS.items()}
    cases["wall"] = {"mesh": RING, "field": "exp(-(sqrt(x^2+y^2)-1)/(0.0015*(1+4*(x+1)^2)))", "options": ["--geometry", json.dumps(CIRCLES)]}
    cases["wall, far"] = cases["wall"] | {"options": [*cases["wall"]["options"], "--geometry-error", 10]}
    return cases | {f"random {seed}": {"mesh": SQUARE, "field": random_field(seed), "options": []} for seed in range(1, 6)}


def measured(camber, case, way, arguments, folder):
    """Returns the rows of all cycles and the notices of a smaller step."""
    mesh = case["mesh"]
    if not isinstance(mesh, str):
        camber("generate", *mesh, "-o", f"{folder}/begin.meshb")
        mesh = f"{folder}/begin.meshb"
    printed = camber("adapt", mesh, "-o", f"{folder}/made.meshb", "--folder", f"{folder}/cycles", "--field", case["field"], "--complexity",
                     f"{arguments.complexity / 2:g},{arguments.complexity:g}", "--cycles", arguments.cycles, "--convergence-tolerance", 0, "--threads", arguments.threads,
                     *case["options"], *arguments.options.split(), *WAYS[way])
    with open(f"{folder}/cycles/cycles.json", encoding="utf-8") as file:
        return json.load(file)["cycles"], printed.count("not certified")


def ratio(values):
    return f"{max(values) / min(values):.2f}" if values and min(values) > 0 else "-"


def line(name, way, rows, arguments):
    error = lambda row, which: row["interpolation_error"][which]
    late = [row for row in rows if row["cycle"] >= arguments.first] or rows[-1:]
    judged = [row for row in late if "expected_error" in row]
    best = min(judged or late, key=lambda row: row.get("expected_error", error(row, "l2")))
    shares = [row["expected_error"] / error(row, "l2") for row in judged if error(row, "l2") > 0]
    expected = f"{min(shares):.2f} to {max(shares):.2f}" if shares else "-"
    seconds = sum(row["seconds"] for row in rows)
    return (f"| {name} | {way} | {best['unknowns']} | {error(best, 'l2'):.1e}, {error(best, 'h1'):.2g} | "
            f"{ratio([error(row, 'l2') for row in late])}, {ratio([error(row, 'h1') for row in late])} | {expected} | "
            f"{min(row['min_quality'] for row in late):.3f} | {100 * min(row['unit_edges'] for row in late):.1f} | {seconds:.1f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("--cases", help="semicolon-separated names")
    parser.add_argument("--more", metavar="FILE", help="file with additional cases (JSON)")
    parser.add_argument("--ways", default=",".join(WAYS))
    parser.add_argument("--complexity", type=float, default=600)
    parser.add_argument("--cycles", type=int, default=20)
    parser.add_argument("--from", dest="first", type=int, default=8)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--options", default="", help="options of `camber adapt` in all cases")
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    cases = own_cases()
    if arguments.more:
        with open(arguments.more, encoding="utf-8") as file:
            cases |= {name: {"options": []} | case for name, case in json.load(file).items()}
    names = arguments.cases.split(";") if arguments.cases else list(cases)
    for name in names:
        if name not in cases:
            parser.error(f"unknown case '{name}'; known are {', '.join(cases)}")
    camber, every = Program(os.path.abspath(arguments.camber)), {}
    print(f"| case | way | unknowns | L2, H1 | largest/smallest of cycles {arguments.first} to {arguments.cycles}: L2, H1 | expected/true L2 | quality | unit edges, % | s |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in names:
        for way in arguments.ways.split(","):
            with tempfile.TemporaryDirectory() as folder:
                rows, again = measured(camber, cases[name], way, arguments, folder)
            every[f"{name}, {way}"] = rows
            print(line(name, way, rows, arguments) + (f" {again} not certified" if again else ""), flush=True)
    if arguments.json:
        with open(arguments.json, "w", encoding="utf-8") as file:
            json.dump(every, file, indent=1)


if __name__ == "__main__":
    main()
