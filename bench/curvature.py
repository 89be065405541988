"""Does curvature pay? Curves meshes with each objective and asks `camber check --field` for the errors of interpolants.

    /usr/bin/python3 bench/curvature.py build/bin/camber MESHES
    /usr/bin/python3 bench/curvature.py build/bin/camber MESHES --meshes polar-100k,layer-single --objectives energy,shape

MESHES is a folder with the meshes that docs/results.md describes; what is not there is left out, and so are objectives
that the program does not know. Prints one Markdown table. A ratio is that of the errors on the straight-sided mesh of
the same vertices and on the curved one, at equal unknowns: above 1, curvature pays.
"""
import argparse
import json
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

SPHERE, CIRCLE = "sqrt(x^2+y^2+z^2)", "sqrt(x^2+y^2)"
OBJECTIVES = ("accuracy", "straight field", "energy", "length", "shape")
STEEP_OBJECTIVES = ("accuracy", "straight field", "shape")  # the others take minutes where walls sag by more than a layer
# What an objective's name sets; the straight field is that of `accuracy`.
SETTINGS = {"straight field": ["--set", "stages/curve/back_mesh=straight"]}


def generic(size, dim=3):
    """Fields that no metric of these meshes follows: a planar front, waves, a vortex, something else. `size` is that of
    the fields' features, in model units."""
    third = f"+0.3*z/{size}" if dim == 3 else ""
    return {
        "planar front": f"tanh((0.6*x+0.7*y{'+0.4*z' if dim == 3 else ''}-0.4*{size})/(0.2*{size}))",
        "waves": f"sin(2*pi*x/{size})*cos(2*pi*y/{size})",
        "vortex": f"exp(-((x-0.3*{size})^2+(y-0.5*{size})^2)/(0.5*{size})^2)*(x-0.3*{size})",
        "unrelated": f"1/(1+(x/{size}+0.4)^2+2*(y/{size}-0.1)^2)*exp(0.5*y/{size}{third})",
    }


def fronts(radius, at, widths):
    return {f"tanh((r-{at})/{width})": f"tanh(({radius}-{at})/{width})" for width in widths}


def layers(radius, widths):
    return {f"exp(-(r-1)/{width})": f"exp(-({radius}-1)/{width})" for width in widths}


@dataclass
class Case:
    """A mesh of the folder, or a config that generates one."""
    fields: dict
    config: dict = field(default_factory=dict)


def generated(shape, metric="natural", geometry="surrogate"):
    return {"input": {"generate": shape}, "metric": metric, "geometry": geometry,
            "stages": ["elevate", "curve", "validate", "relax", "commit"]}


def steep(first, growth, count):
    return generated({"shell": {"inner_size": 0.46, "outer_size": 1.75,
                                "inner_layer": {"count": count, "first_height": first, "growth": growth}}})


WALL = layers(SPHERE, (0.05, 0.2)) | fronts(SPHERE, 1.1, (0.05,))
SHOCK = {"field": {"spherical-shock": {"centre": [0, 0], "radius": 0.5, "min_size": 0.03, "size": 0.08, "width": 0.1}}}
CASES = {
    "polar-100k": Case(fronts(CIRCLE, 0.5, (0.005, 0.01, 0.03)) | generic(0.5)),
    "layer-single": Case(layers(SPHERE, (0.05, 0.2)) | fronts(SPHERE, 1.1, (0.05,)) | generic(5)),
    "layer-double": Case(layers(SPHERE, (0.05, 0.2)) | fronts(SPHERE, 1.1, (0.05,)) | generic(5)),
    "spheres-fine": Case(layers(SPHERE, (0.5,)) | fronts(SPHERE, 2, (0.5,)) | generic(5)),
    "cube-cylinder": Case(fronts(CIRCLE, 0.5, (0.1,)) | fronts(CIRCLE, 0.7, (0.1,)) | generic(0.5)),
    "circle-2d": Case(layers(CIRCLE, (0.1, 0.4)) | fronts(CIRCLE, 1.1, (0.05,)) | generic(2, 2),
                      generated({"annulus": {"inner_radius": 1, "outer_radius": 3, "inner_size": 0.4, "outer_size": 0.6,
                                             "inner_layer": {"count": 6, "first_height": 0.02, "growth": 1.3}}})),
    "shock-2d": Case(fronts(CIRCLE, 0.5, (0.03, 0.1, 0.3)) | generic(0.5, 2),
                     generated({"rectangle": {"cells": [32, 32], "jitter": 0.2}}, SHOCK, "straight")),
    "layers-1.4": Case(layers(SPHERE, (0.05, 0.2)) | fronts(SPHERE, 1.1, (0.05,)) | generic(5),
                       generated({"shell": {"inner_size": 0.3, "outer_size": 1.6,
                                            "inner_layer": {"count": 8, "first_height": 0.02, "growth": 1.4}}})),
    # The first layer is a tenth of the wall's sagitta, or less.
    "steep-1.4": Case(WALL, steep(0.0026, 1.4, 10)),
    "steep-1.6": Case(WALL, steep(0.0026, 1.6, 8)),
    "steep-2.4": Case(WALL, steep(0.0026, 2.4, 5)),
    "steep-thin": Case(WALL, steep(4.6e-5, 1.6, 17)),
    "steep-2d": Case(layers(CIRCLE, (0.05, 0.2)) | fronts(CIRCLE, 1.1, (0.05,)),
                     generated({"annulus": {"inner_radius": 1, "outer_radius": 3, "inner_size": 0.4, "outer_size": 0.6,
                                            "inner_layer": {"count": 10, "first_height": 0.002, "growth": 1.4}}})),
}


class Unknown(Exception):
    """The program does not know what it was asked for."""


class Program:
    def __init__(self, camber, meshes, threads):
        self.camber, self.meshes, self.threads = Path(camber).resolve(), Path(meshes).resolve(), str(threads)

    def call(self, *arguments):
        done = subprocess.run([str(self.camber), *map(str, arguments), "--threads", self.threads], capture_output=True,
                              text=True)
        if done.returncode == 2:
            raise Unknown(done.stderr.strip())
        if done.returncode not in (0, 1):  # 1: elements are left that are not valid
            sys.exit(f"curvature.py: {' '.join(map(str, arguments))} failed: {done.stderr}")
        return done.stdout

    def curved(self, name, objective, folder):
        """The report of the run that curves a case; its mesh is out.meshb in the folder."""
        mesh, report = folder / "out.meshb", folder / "report.json"
        settings = SETTINGS.get(objective, ["--set", f"stages/curve/objective={objective}"])
        if CASES[name].config:
            config = folder / "config.json"
            config.write_text(json.dumps(CASES[name].config | {"output": {"mesh": str(mesh), "report": str(report)}}))
            self.call("run", config, *settings)
        else:
            metric = self.meshes / f"{name}.solb"
            self.call("curve", self.meshes / f"{name}.meshb", "-o", mesh, "--report", report, *settings,
                      *(["--metric", metric] if metric.exists() else []))
        return json.loads(report.read_text())

    def checked(self, name, folder):
        """What `check` says of the mesh and the fields of the case."""
        fields = [part for text in CASES[name].fields.values() for part in ("--field", text)]
        return json.loads(self.call("check", folder / "out.meshb", "--json", "--worst", 0, *fields))


def figures(program, name, objective):
    """Of one mesh and objective: what the curved mesh is like, and for each field the errors' ratios "L2 FIELD" and "H1 FIELD";
    "uncertain FIELD" where some element's error is not resolved."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        begin = time.monotonic()
        report = program.curved(name, objective, folder)
        seconds = time.monotonic() - begin
        check = program.checked(name, folder)
    before = report.get("validity_before_correction", report["validity"])
    gain = report.get("curve", {}).get("after_correction", {}).get("mean_gain")
    row = {"invalid_before": before["invalid"] + before["undecided"], "smallest": check["min_scaled_jacobian"], "seconds": seconds}
    if gain is not None:
        row["gain"] = gain
    for label, found in zip(CASES[name].fields, check["interpolation"]):
        row |= {f"L2 {label}": found["ratio"]["l2"], f"H1 {label}": found["ratio"]["h1"]}
        if found["unresolved"] or found["curved_turned"]:
            row[f"uncertain {label}"] = 1
    return row


def rows(program, name, objective):
    """The lines of one mesh and objective, a field each; what belongs to the mesh stands in the first."""
    found = figures(program, name, objective)
    of_mesh = [str(found["invalid_before"]), f"{found['smallest']:.3g}",
               f"{100 * found['gain']:.2f}" if "gain" in found else "-", f"{found['seconds']:.1f}"]
    for label in CASES[name].fields:
        mark = " !" if f"uncertain {label}" in found else ""
        yield [name, label, objective, f"{found['L2 ' + label]:.2f}{mark}", f"{found['H1 ' + label]:.2f}", *of_mesh]
        of_mesh = [""] * len(of_mesh)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("meshes_folder", metavar="MESHES")
    parser.add_argument("--meshes", default=",".join(CASES), help="names, divided by commas (%(default)s)")
    parser.add_argument("--objectives", default=",".join(OBJECTIVES), help="of the stage curve; straight field: accuracy in that (%(default)s)")
    parser.add_argument("--threads", default=0)
    arguments = parser.parse_args()
    program = Program(arguments.camber, arguments.meshes_folder, arguments.threads)
    print("| mesh | field | objective | L2 straight/curved | H1 | invalid before repair | smallest scaled Jacobian | "
          "length gain, % | seconds to curve |\n|" + "---|" * 9)
    unknown = set()
    for name in arguments.meshes.split(","):
        if name not in CASES:
            parser.error(f"there is no mesh '{name}'; there are {', '.join(CASES)}")
        if not CASES[name].config and not (program.meshes / f"{name}.meshb").exists():
            print(f"curvature.py: no {name}.meshb in {program.meshes}: left out", file=sys.stderr)
            continue
        for objective in arguments.objectives.split(","):
            if objective in unknown:
                continue
            try:
                for row in rows(program, name, objective):
                    print("| " + " | ".join(row) + " |", flush=True)
            except Unknown as why:
                unknown.add(objective)
                print(f"curvature.py: objective {objective} is left out: {why}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
