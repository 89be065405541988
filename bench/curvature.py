#!/usr/bin/env python3
"""Compares errors of fields on meshes curved in different ways, interpolated (`camber check --field`) and solved (`poisson --field`).

    bench/curvature.py build/bin/camber                                the tables of docs/curvature.md: half an hour
    bench/curvature.py build/bin/camber --meshes circle-2d,bend --ways straight,default
    bench/curvature.py build/bin/camber --safe [--set PATH=VALUE]      smooth fields: losses of the default
    bench/curvature.py build/bin/camber --layers [--set PATH=VALUE]    layers: gains of the default
    bench/curvature.py build/bin/camber --trade PATH VALUE,VALUE       both for each value of an option

Meshes of other programs are read from a folder (`--folder`). Missing meshes are skipped, and so are ways that the program does not support.
`poisson` must be next to the program (`ninja -C build poisson`); without it the equations are not solved. The Python module of Gmsh makes
the parts with CAD models.

Ratios are the error on the mesh with the objective `shape` divided by the error on the given mesh, at equal unknowns and on the same domain. Above
1 the given mesh is better. Straight edges end at the chords of walls, which is another domain, on which the field is known too. For the field
that is 0 on the wall, the solver uses 0 at the chords.
"""
import argparse
import math
import sys

from curvature_cases import CASES, ERRORS, LAYERS, SAFE, SHOWN
from curvature_measure import WAYS, Bench, Unknown, ways_of
from curvature_table import lines, markdown, titles, titles_of_took, took

OF_LAYERS = ("wall", "front")


def figures(bench, name, way):
    """Returns a row of the table as numbers by name. It is empty if the program does not support this way for a field."""
    try:
        like, found = bench.figures(name, way)
    except Unknown as why:
        if way in ("shape", "default"):
            raise
        print(f"curvature.py: {way} on {name} is left out: {why}", file=sys.stderr, flush=True)
        return {}
    row = dict(like)
    for label, errors in found.items():
        row[f"{bench.fields(name)[label][0]} {label}"] = 1
        row |= {f"{error} {label}": value for error, value in errors.items()}
    return row


def table(bench, names, ways):
    found = {}
    for name in names:
        found[name] = {}
        for way in dict.fromkeys(("shape", *ways)):
            if way in ways_of(name):
                print(f"curvature.py: {name}, {way}", file=sys.stderr, flush=True)
                found[name][way] = figures(bench, name, way)
    print(markdown(titles(found), lines(found)))
    print(markdown(titles_of_took(found), took(found)), end="")


def compared(bench, names, kinds, settings):
    """Yields (mesh, field, {error: ratio shape/default}) for fields of the given kinds, with settings for the default."""
    for name in names:
        labels = [label for label, (kind, _) in bench.fields(name).items() if kind in kinds]
        _, shape = bench.figures(name, "shape", labels)
        _, default = bench.figures(name, "default", labels, settings)
        for label in labels:
            yield name, label, {error: shape[label][error] / default[label][error] for error in ERRORS if default[label].get(error)}


def worst_of(rows):
    """Returns the largest loss: (ratio default/shape, its description)."""
    return max((1 / ratio, f"{name}, {label}, {error}") for name, label, ratios in rows for error, ratio in ratios.items())


def gains_of(rows):
    """Returns the geometric mean of the gains and the minimum: (gain, its description)."""
    every = [(ratio, f"{name}, {label}, {error}") for name, label, ratios in rows for error, ratio in ratios.items()]
    return math.exp(sum(math.log(ratio) for ratio, _ in every) / len(every)), min(every)


def print_rows(what, rows, written):
    """Prints the rows and yields them."""
    print(f"| mesh | field | {' | '.join(f'{error}: {what}' for error in ERRORS)} |\n" + "|---" * (2 + len(ERRORS)) + "|")
    for name, label, ratios in rows:
        cells = (written(ratios[error]) if error in ratios else "-" for error in ERRORS)
        print(f"| {name} | `{label}` | {' | '.join(cells)} |", flush=True)
        yield name, label, ratios


def safe(bench, names, settings):
    """Prints losses on smooth fields: above 1 the default is worse than shape."""
    rows = compared(bench, names, ("smooth",), settings)
    loss, what = worst_of(print_rows("default/shape", rows, lambda ratio: f"{1 / ratio:.3f}"))
    print(f"\nworst: {loss:.3f} ({what})")


def layers(bench, names, settings):
    """Prints gains on layers: above 1 the default is better than shape."""
    rows = compared(bench, names, OF_LAYERS, settings)
    mean, (least, what) = gains_of(print_rows("shape/default", rows, lambda ratio: f"{ratio:.2f}"))
    print(f"\nmean: {mean:.2f}; least: {least:.2f} ({what})")


def trade(bench, safe_names, layer_names, option, values):
    """Prints one line per value. "preserved" is the logarithm of the mean gain as a share of that of the default."""
    print(f"| {option} | worst loss on smooth fields, by it/by shape | gain on layers, shape/it: mean | preserved | minimum |\n|---|---|---|---|---|")
    whole = None
    for value in ("(as it is)", *values):
        settings = () if value == "(as it is)" else ("--set", f"{option}={value}")
        loss, where = worst_of(compared(bench, safe_names, ("smooth",), settings))
        mean, (least, what) = gains_of(compared(bench, layer_names, OF_LAYERS, settings))
        whole = whole or math.log(mean)
        print(f"| {value} | {loss:.3f} ({where}) | {mean:.3f} | {100 * math.log(mean) / whole:.0f} % | {least:.2f} ({what}) |", flush=True)


def there(bench, names, parser):
    for name in names:
        if name not in CASES:
            parser.error(f"unknown mesh '{name}'; known are {', '.join(CASES)}")
        if not bench.is_there(name):
            print(f"curvature.py: no {name}.meshb in {bench.meshes}: left out", file=sys.stderr)
    return [name for name in names if bench.is_there(name)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("--folder", default=".", help="folder with meshes of other programs (%(default)s)")
    parser.add_argument("--meshes", help="comma-separated names (default: those of docs/curvature.md; of --safe and --layers the most sensitive)")
    parser.add_argument("--ways", default=",".join(WAYS), help="ways of the table (%(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE", help="an option of the default, of --safe and --layers")
    parser.add_argument("--threads", default=2)
    mode = parser.add_mutually_exclusive_group()
    mode.add_argument("--safe", action="store_true", help="smooth fields only: ratios default/shape of errors, and the worst")
    mode.add_argument("--layers", action="store_true", help="layers and fronts only: ratios shape/default of errors")
    mode.add_argument("--trade", nargs=2, metavar=("PATH", "VALUES"), help="an option's values: worst loss of --safe, gain of --layers")
    arguments = parser.parse_args()
    bench = Bench(arguments.camber, arguments.folder, arguments.threads)
    if not bench.poisson.exists():
        print(f"curvature.py: no {bench.poisson}: nothing is solved", file=sys.stderr)
    chosen = lambda names: there(bench, arguments.meshes.split(",") if arguments.meshes else names, parser)
    settings = tuple(word for one in arguments.set for word in ("--set", one))
    if arguments.safe:
        safe(bench, chosen(SAFE), settings)
    elif arguments.layers:
        layers(bench, chosen(LAYERS), settings)
    elif arguments.trade:
        trade(bench, chosen(SAFE), there(bench, LAYERS, parser), arguments.trade[0], arguments.trade[1].split(","))
    else:
        table(bench, chosen(SHOWN), arguments.ways.split(","))


if __name__ == "__main__":
    try:
        main()
    except Unknown as error:
        sys.exit(f"curvature.py: {error}")
