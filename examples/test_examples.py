#!/usr/bin/env python3
"""Runs the examples in a few cycles, where their solvers are installed.

    test_examples.py build/bin/camber [NAME ...] [--all]

NAMEs are those of CASES; without any those that take seconds, with --all the heavy ones too. Every cycle's mesh must be good by
`camber check`, and every cycle's error less than the one before. Exit code 0: all that ran passed; 1: one failed; 77: none could run.
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time

EXAMPLES = os.path.dirname(os.path.abspath(__file__))
SKIPPED = 77
NUMPY = "import numpy, scipy"
DOLFINX = "import gmsh, dolfinx, dolfinx.io.gmshio"
GETFEM = "import getfem, numpy"
# Name: config, what its solver needs, settings, whether it is heavy.
CASES = {
    "own-solver": ("own-solver/adapt.json", NUMPY, ["adapt/cycles=3", "adapt/complexity=[60, 120, 240]"], False),
    "own-solver-mfem": ("own-solver/adapt.json", NUMPY,
                        ["adapt/cycles=2", "adapt/complexity=[60, 120]", "adapt/mesh=mesh.mfem"], False),
    "own-solver-3d": ("own-solver/adapt-3d.json", NUMPY, ["adapt/cycles=2", "adapt/complexity=[100, 200]"], True),
    "poisson-layer": ("poisson-layer/adapt.json", DOLFINX, ["adapt/cycles=3", "adapt/complexity=[60, 120, 240]"], False),
    "poisson-layer-3d": ("poisson-layer/adapt-3d.json", DOLFINX, ["adapt/cycles=2", "adapt/complexity=[200, 400]"], True),
    "advection-diffusion": ("advection-diffusion/adapt.json", GETFEM, ["adapt/cycles=3", "adapt/complexity=[60, 120, 240]"],
                            False),
}


class Failed(Exception):
    pass


def python_with(needed):
    """The environment in which `python3` has the modules: as it is, else with Debian's python first; None: neither has."""
    for path in (os.environ["PATH"], "/usr/bin" + os.pathsep + os.environ["PATH"]):
        environment = dict(os.environ, PATH=path, OMP_NUM_THREADS="1")
        if subprocess.run(["python3", "-c", needed], env=environment, capture_output=True).returncode == 0:
            return environment
    return None


def run(arguments, environment, accepted=(0,)):
    done = subprocess.run(arguments, cwd=os.path.dirname(EXAMPLES), env=environment, capture_output=True, text=True)
    if done.returncode not in accepted:
        raise Failed(f"{' '.join(arguments)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def adapt(camber, name, environment, folder):
    """The folder of the cycles."""
    config, _, settings, _ = CASES[name]
    cycles = os.path.join(folder, name + ".cycles")
    mesh = os.path.join(folder, name + ".meshb")
    settings = settings + [f"adapt/folder={cycles}", f"output/mesh={mesh}", f"output/report={os.path.join(folder, name)}.json"]
    run([camber, "run", os.path.join("examples", config), "--allow-commands", *(word for s in settings for word in ("--set", s))],
        environment)
    check(camber, mesh, environment)
    return cycles


def check(camber, mesh, environment):
    told = json.loads(run([camber, "check", mesh, "--json", "--worst", "0"], environment, accepted=(0, 1)))
    if not told["all_good"] or told["degree"] != 2 or told["valid"] != told["elements"]:
        raise Failed(f"{mesh}: {told['elements'] - told['valid']} elements of {told['elements']} are not valid, or it is not sound")


def check_cycles(camber, cycles, environment):
    """A line on the errors."""
    with open(os.path.join(cycles, "cycles.json")) as file:
        table = json.load(file)["cycles"]
    folders = sorted(name for name in os.listdir(cycles) if re.fullmatch(r"cycle-\d+", name))
    if len(folders) != len(table) or len(table) < 3:
        raise Failed(f"{len(folders)} folders of {len(table)} cycles")
    for name in folders:
        mesh = next(file for file in os.listdir(os.path.join(cycles, name)) if file.startswith("mesh."))
        check(camber, os.path.join(cycles, name, mesh), environment)
        said = re.search(r"error in L2 (\S+), in H1 (\S+)", open(os.path.join(cycles, name, "solver.txt")).read())
        row = table[folders.index(name)]
        # The solver's own integral of its error is that of camber: rows of the solution are in the mesh file's order.
        if not said or abs(float(said[1]) - row["solution_error"]["l2"]) > 0.02 * float(said[1]):
            raise Failed(f"{name}: the solver's error is {said and said[1]}, camber's {row['solution_error']['l2']:.3e}")
    for kind in ("interpolation_error", "solution_error"):
        errors = [row[kind]["l2"] for row in table]
        if any(after >= before for before, after in zip(errors, errors[1:])):
            raise Failed(f"the {kind} in L2 does not fall: {errors}")
    return ", ".join(f"{row['solution_error']['l2']:.1e}" for row in table)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camber")
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(CASES))
    parser.add_argument("--all", action="store_true", help="the heavy ones too")
    given = parser.parse_args()
    for name in given.names:
        if name not in CASES:
            parser.error(f"{name} is none of {', '.join(CASES)}")
    names = given.names or [name for name, case in CASES.items() if given.all or not case[3]]
    camber = os.path.abspath(given.camber)

    outcomes = []
    for name in names:
        environment = python_with(CASES[name][1])
        if environment is None:
            print(f"{name}: skipped, `{CASES[name][1]}` fails", flush=True)
            outcomes.append(SKIPPED)
            continue
        begin = time.perf_counter()
        try:
            with tempfile.TemporaryDirectory() as folder:
                errors = check_cycles(camber, adapt(camber, name, environment, folder), environment)
            print(f"{name}: passed in {time.perf_counter() - begin:.1f} s; errors in L2 by cycle {errors}", flush=True)
            outcomes.append(0)
        except Failed as failure:
            print(f"{name}: FAILED: {failure}", flush=True)
            outcomes.append(1)
    return 1 if 1 in outcomes else 0 if 0 in outcomes else SKIPPED


if __name__ == "__main__":
    sys.exit(main())
