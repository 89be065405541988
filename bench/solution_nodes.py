#!/usr/bin/env python3
"""Gain of `curve --solution` over straight elements on meshes adapted to a known solution.

    bench/solution_nodes.py build/bin/camber build/bin/poisson
    bench/solution_nodes.py build/bin/camber --shape           compared with `shape` on meshes of a shell, with and without layers

Each mesh is remeshed to the metric of the Hessian of the field in L² (`remesh`, five times) and elevated, and Poisson's equation is solved on it
with straight elements of degree 2. Then it is curved by that solution, by the expression of the field, and by default. The numbers are ratios of
interpolation errors in L2 and the seminorm of H1, straight (on the chords) over curved.
"""
import argparse
import json
import math
import os
import tempfile

from program import Program

CIRCLE, SPHERE = "sqrt(x^2+y^2)", "sqrt(x^2+y^2+z^2)"
ANNULUS = ("annulus", "--elements", 4000, "--set", "outer_radius=3", "--set", "inner_size=0.1", "--set", "outer_size=0.2")
SHELL = ("shell", "--elements", 15000, "--set", "outer_radius=2")
CASES = [("wall, 2D", ANNULUS, f"exp(-({CIRCLE}-1)/0.05)", (600, 2400)),
         ("wide wall, 2D", ANNULUS, f"exp(-({CIRCLE}-1)/0.2)", (600, 2400)),
         ("front, 2D", ANNULUS, f"tanh(({CIRCLE}-1.7)/0.05)", (600, 2400)),
         ("wall, 3D", SHELL, f"exp(-({SPHERE}-1)/0.08)", (1500, 4000))]
METRIC = '{"solution": {"degree": 1, "norm": 2}}'


def adapted(camber, shape, field, complexity):
    """Makes mesh.meshb, a straight mesh of degree 2."""
    camber("generate", *shape, "-o", "0.meshb")
    for turn in range(5):
        camber("remesh", f"{turn}.meshb", "--solution", field, "--metric", METRIC, "--complexity", complexity, "-o", f"{turn + 1}.meshb")
    camber("convert", "5.meshb", "--elevate", "-o", "mesh.meshb")


def gains(camber, field, *way):
    """Returns ratios straight/curved of errors in L2 and H1."""
    camber("curve", "mesh.meshb", "-o", "curved.meshb", *way, "--threads", 1)
    report = json.loads(camber("check", "curved.meshb", "--json", "--worst", 0, "--field", field))
    ratio = report["interpolation"][0]["ratio"]
    return ratio["l2"], ratio["h1"]


LAYER = {"count": 8, "first_height": 0.02, "growth": 1.4}
LAYERS = {"layers": ({"shell": {"inner_size": 0.3, "outer_size": 1.6, "inner_layer": LAYER}},
                     (f"exp(-({SPHERE}-1)/0.05)", f"exp(-({SPHERE}-1)/0.2)", f"tanh(({SPHERE}-1.1)/0.05)", "(x/10)^3", "sin(2*3.14159265*x/10)",
                      "y*exp(4*x/10)")),
          "uniform": ({"shell": {"inner_size": 0.3, "outer_size": 0.9}}, (f"exp(-({SPHERE}-1)/0.5)", "(x/10)^3"))}


def write_values(mesh, field, solution):
    """Writes values of a field at the vertices of an ASCII mesh in 3D."""
    with open(mesh, encoding="utf-8") as file:
        words = file.read().split()
    first = words.index("Vertices") + 2
    count = int(words[first - 1])
    functions = {"exp": math.exp, "sqrt": math.sqrt, "tanh": math.tanh, "sin": math.sin}
    with open(solution, "w", encoding="utf-8") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{count}\n1 1\n")
        for k in range(first, first + 4 * count, 4):
            place = dict(zip("xyz", map(float, words[k:k + 3])))
            file.write(f"{eval(field.replace('^', '**'), functions, place)!r}\n")  # fields are those above
        file.write("End\n")


def against_shape(camber):
    """Prints ratios of errors with the nodes of `shape` and with nodes by exact vertex values or by the expression."""
    print("| mesh, field | degree 1 | expression |\n|---|---|---|")
    for mesh, (shape, fields) in LAYERS.items():
        camber("generate", json.dumps(shape), "-o", "straight.meshb")
        camber("convert", "straight.meshb", "-o", "straight.mesh")
        for field in fields:
            errors = []
            write_values("straight.mesh", field, "values.sol")
            for way in (("--objective", "shape"), ("--solution", "values.sol"), ("--solution", field)):
                camber("curve", "straight.meshb", "-o", "curved.meshb", *way)
                report = json.loads(camber("check", "curved.meshb", "--json", "--worst", 0, "--field", field))
                errors.append([report["interpolation"][0]["curved"][norm]["value"] for norm in ("l2", "h1")])
            cells = ["%.2f, %.2f" % tuple(a / b for a, b in zip(errors[0], one)) for one in errors[1:]]
            print(f"| {mesh}, `{field}` | " + " | ".join(cells) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("poisson", nargs="?")
    parser.add_argument("--shape", action="store_true", help="compare with `shape`, on meshes of a shell")
    options = parser.parse_args()
    camber = Program(os.path.abspath(options.camber))
    if options.shape:
        with tempfile.TemporaryDirectory() as here:
            os.chdir(here)
            return against_shape(camber)
    poisson = Program(os.path.abspath(options.poisson))
    print("| field, complexity | by the computed solution | by the expression | default |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name, shape, field, complexities in CASES:
            for complexity in complexities:
                adapted(camber, shape, field, complexity)
                poisson("mesh.meshb", "--field", field, "--solution", "u.sol")
                ways = (("--solution", "u.sol"), ("--solution", field), ())
                columns = ["%.2f, %.2f" % gains(camber, field, *way) for way in ways]
                print(f"| {name}, {complexity} | " + " | ".join(columns) + " |", flush=True)


if __name__ == "__main__":
    main()
