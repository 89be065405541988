#!/usr/bin/env python3
"""Unknowns and errors of adapted meshes, linear, quadratic with straight elements and quadratic with curved ones (`camber adapt --field`).

    bench/adaptation.py build/bin/camber                                         2D, then 3D
    bench/adaptation.py build/bin/camber --fields circle,planar --complexities 200,400,800
    bench/adaptation.py build/bin/camber --fields 2D --json adaptation.json      with all measurements
    bench/adaptation.py build/bin/camber --set curved:stages/curve/min_jacobian=0.05

Kinds of meshes (ways):
    linear      straight meshes, metric of second derivatives, interpolant of degree 1
    straight    straight meshes, metric of third derivatives, interpolant of degree 2 (on curved walls: elements that are straight
                inside and follow the wall, `curve --objective shape`)
    curved      curved meshes, interpolant of degree 2

Unknowns are vertices for degree 1 and nodes for degree 2. A cell has the errors of the last cycle in L2 and H1, the minimum and maximum L2 error
of the last three cycles, and the seconds of all cycles. "invalid!" is the number of invalid elements, "missing!" the number of cycles after an
invalid mesh. Rates are least-squares fits error ~ unknowns^-rate over the three finest meshes. "Fewer" is the ratio of unknowns of the other way
and of `curved` at the smallest error that both reached, interpolated between the measured points in log-log. A ~ marks ways without a common
range of errors; their fit is extrapolated to the error of `curved`.
"""
import argparse
import json
import math
import os
import sys
import tempfile
import time

from program import Program

SQUARE = ("rectangle", "--set", "cells=[20,20]")
CUBE = ("box", "--set", "cells=[8,8,8]")
SHELL = ("shell", "--elements", 8000, "--set", "outer_radius=2")
SPHERES = {"analytic": [{"references": [2], "sphere": {"radius": 1}}, {"references": [1], "sphere": {"radius": 2}}]}
SPHERE = "sqrt(x^2+y^2+z^2)"
PLANAR = "tanh((0.8*x+0.6*y-0.7)/0.01)"
FIELDS = {"circle": (SQUARE, "tanh((sqrt(x^2+y^2)-0.5)/0.005)"),
          "wavy": (SQUARE, "tanh((y-0.5-0.1*sin(6.28318530718*x))/0.01)"),
          "planar": (SQUARE, PLANAR),
          "planar short": (SQUARE, PLANAR, "--max-size", 0.3),
          "smooth": (SQUARE, "sin(3*x)*exp(y)"),
          "sphere": (CUBE, f"tanh(({SPHERE}-0.5)/0.02)"),
          "thin sphere": (CUBE, f"tanh(({SPHERE}-0.5)/0.005)"),
          "layer": (SHELL, f"exp(-({SPHERE}-1)/0.08)")}
OF_DIMENSION = {"2D": ("circle", "wavy", "planar", "planar short", "smooth"), "3D": ("sphere", "thin sphere", "layer")}
COMPLEXITIES = {"2D": (100, 200, 400, 800, 1600), "3D": (400, 800, 1600, 3200, 6400)}
FURTHER = {"2D": 2, "3D": 1}
WAYS = {"linear": ("--degree", 1), "straight": ("--degree", 1, "--set", "metric/solution/degree=2"), "curved": ()}
JUDGED = {"linear": "linear", "straight": "curved", "curved": "curved"}  # interpolant in the output of `camber check --field`
ERRORS = ("l2", "h1")
LAST = 3  # number of cycles of the range of errors
FINEST = 3  # number of meshes of the fit


def cycles_of(folder):
    with open(f"{folder}/cycles.json", encoding="utf-8") as file:
        return json.load(file)["cycles"]


def spread(last):
    return {f"{error} {which.__name__}": which(one[error] for one in last) for error in ERRORS for which in (min, max)}


class Bench:
    def __init__(self, arguments):
        self.camber = Program(os.path.abspath(arguments.camber))
        self.cycles, self.threads = arguments.cycles, arguments.threads
        self.options = {way: [] for way in WAYS}
        for one in arguments.set:
            way, _, setting = one.partition(":")
            if way not in WAYS:
                raise SystemExit(f"adaptation.py: --set {one}: there is no way '{way}'; there are {', '.join(WAYS)}")
            self.options[way] += ["--set", setting]

    def measured(self, mesh, field, way, wall):
        """Returns {unknowns, invalid, l2, h1} of the mesh of a cycle."""
        if way == "straight":
            self.camber("convert", mesh, "--elevate", "-o", "even.meshb")
            mesh = "even.meshb"
            if wall:
                self.camber("curve", mesh, "-o", "wall.meshb", "--objective", "shape", *wall)
                mesh = "wall.meshb"
        report = json.loads(self.camber("check", mesh, "--field", field, "--json", "--worst", 0, "--threads", self.threads))
        found = report["interpolation"][0][JUDGED[way]]
        return {"unknowns": report["nodes"], "invalid": report["invalid"] + report["undecided"],
                **{error: found[error]["value"] for error in ERRORS}}

    def run(self, name, way, complexity):
        """Returns {complexity, unknowns, l2, h1, minimum and maximum of both in the last cycles, seconds}."""
        shape, field, *options = FIELDS[name]
        wall = ("--geometry", json.dumps(SPHERES)) if shape is SHELL else ()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            self.camber("generate", *shape, "-o", "first.meshb")
            begin = time.perf_counter()
            self.camber("adapt", "first.meshb", "--field", field, "--complexity", complexity, "--cycles", self.cycles, "--convergence-tolerance", 0,
                        *WAYS[way], *self.options[way], *options, *wall, "--threads", self.threads, "--folder", "cycles", "-o", "last.meshb")
            seconds = time.perf_counter() - begin
            whole = len(cycles_of("cycles")) - 1  # fewer than requested if the loop ended early
            last = [self.measured(f"cycles/cycle-{cycle:03}/mesh.meshb", field, way, wall)
                    for cycle in range(max(1, whole - LAST + 1), whole + 1)]
            os.chdir("/")
        return last[-1] | spread(last) | {"complexity": complexity, "seconds": seconds, "missing": self.cycles - whole}


def rate(rows, error):
    """Returns (rate, a) of error = exp(a) * unknowns^-rate, a least-squares fit of the finest meshes in log-log."""
    x, y = ([math.log(row[key]) for row in rows[-FINEST:]] for key in ("unknowns", error))
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    slope = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum((a - mean_x) ** 2 for a in x)
    return -slope, mean_y - slope * mean_x


def unknowns_at(rows, error, level):
    """Returns the unknowns at which the lines between neighbouring points first have the error."""
    for one, other in zip(rows, rows[1:]):
        a, b = one[error], other[error]
        if min(a, b) <= level <= max(a, b):
            share = math.log(a / level) / math.log(a / b) if a != b else 0
            return one["unknowns"] * (other["unknowns"] / one["unknowns"]) ** share
    raise ValueError(f"no {error} of {level}")


def fewer(rows, curved, error):
    """Returns (ratio of unknowns, error of the comparison, True if it is extrapolated)."""
    smallest = max(min(row[error] for row in each) for each in (rows, curved))
    if smallest <= min(max(row[error] for row in each) for each in (rows, curved)):
        return unknowns_at(rows, error, smallest) / unknowns_at(curved, error, smallest), smallest, False
    slope, at = rate(rows, error)
    smallest = max(row[error] for row in curved)
    return math.exp((at - math.log(smallest)) / slope) / unknowns_at(curved, error, smallest), smallest, True


def gains_of(rows, curved):
    """Returns the ratios in L2 and H1."""
    found = (fewer(rows, curved, error) for error in ERRORS)
    return ", ".join("{}{} at {:.1e}".format("~" if beyond else "", f"{gain:.1f}" if gain < 1000 else "over 1000", at) for gain, at, beyond in found)


def cell(row):
    mark = "".join(f", {row[what]} {what}!" for what in ("invalid", "missing") if row[what])
    return f"{row['unknowns']}: {row['l2']:.2e}, {row['h1']:.2e} ({row['l2 min']:.2e} to {row['l2 max']:.2e}; {row['seconds']:.1f} s{mark})"


def table(found):
    """Yields one line per field and complexity."""
    yield "| field | complexity | " + " | ".join(WAYS) + " |\n|" + "---|" * (2 + len(WAYS))
    for name, ways in found.items():
        for turn, row in enumerate(ways["linear"]):
            first = " ".join((f"{name}: `{FIELDS[name][1]}`", *map(str, FIELDS[name][2:]))) if turn == 0 else ""
            cells = (cell(ways[way][turn]) if turn < len(ways[way]) else "" for way in WAYS)
            yield f"| {first} | {row['complexity']:g} | " + " | ".join(cells) + " |"


def summary(found):
    """Yields one line per field: rates and ratios of unknowns."""
    yield ("| field | rates in L2, H1: " + " | ".join(WAYS) + " | fewer than straight: L2, H1 | fewer than linear: L2, H1 |\n|"
           + "---|" * (3 + len(WAYS)))
    for name, ways in found.items():
        rates = [", ".join(f"{rate(ways[way], error)[0]:.2f}" for error in ERRORS) for way in WAYS]
        gains = [gains_of(ways[way], ways["curved"]) for way in ("straight", "linear")]
        yield f"| {name} | " + " | ".join(rates + gains) + " |"


def further(complexities, doublings):
    return [*complexities, *(complexities[-1] * 2 ** turn for turn in range(1, doublings + 1))]


def print_row(name, way, row):
    print(f"adaptation.py: {name}, {row['complexity']:g}, {way}: {cell(row)}", file=sys.stderr, flush=True)
    return row


def dimension(name):
    return next(key for key, names in OF_DIMENSION.items() if name in names)


def chosen(parser, arguments):
    """{field: complexities}"""
    names = [name for word in arguments.fields.split(",") for name in OF_DIMENSION.get(word, (word,))]
    for name in names:
        if name not in FIELDS:
            parser.error(f"unknown field '{name}'; known are 2D, 3D, {', '.join(FIELDS)}")
    own = [float(word) for word in arguments.complexities.split(",")] if arguments.complexities else None
    return {name: own or COMPLEXITIES[dimension(name)] for name in names}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("--fields", default="2D,3D", help="comma-separated names; 2D and 3D stand for all fields of a dimension (%(default)s)")
    parser.add_argument("--complexities", help="comma-separated (2D: %s; 3D: %s)" % tuple(",".join(map(str, c)) for c in COMPLEXITIES.values()))
    parser.add_argument("--further", type=int, help="doublings of the last complexity for straight meshes, towards errors of curved ones "
                        "(2D: {2D}; 3D: {3D})".format(**FURTHER))
    parser.add_argument("--cycles", type=int, default=8, help="cycles of each run (%(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="WAY:PATH=VALUE", help="an option of a way's runs")
    parser.add_argument("--threads", default=1, help="results do not depend on it, seconds do (%(default)s)")
    parser.add_argument("--json", help="also write all measurements to this file")
    arguments = parser.parse_args()
    fields, bench, found = chosen(parser, arguments), Bench(arguments), {}
    target = arguments.json and os.path.abspath(arguments.json)
    for name, complexities in fields.items():
        found[name] = {}
        for way in WAYS:
            own = complexities if way == "curved" else further(complexities, FURTHER[dimension(name)] if arguments.further is None else arguments.further)
            found[name][way] = [print_row(name, way, bench.run(name, way, complexity)) for complexity in own]
        if target:
            with open(target, "w", encoding="utf-8") as file:
                json.dump(found, file, indent=1)
    print("\n".join(table(found)))
    if all(len(each["curved"]) > 1 for each in found.values()):
        print("\n" + "\n".join(summary(found)))


if __name__ == "__main__":
    main()
