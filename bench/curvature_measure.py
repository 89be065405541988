"""Measurements of bench/curvature.py: curves the mesh of a case in some way and computes the errors of fields on it, interpolated and solved."""
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import curvature_cases
import curvature_parts
from curvature_cases import CASES

# Options of `camber curve` besides the mesh and its metric. {FIELD} is the expression of the field: each field has its own mesh.
# {METRIC} is the optimal metric of degree METRIC for the solution on the straight mesh, with the same number of elements.
METRIC = ("--degree", 1, "--norm", 2)
WAYS = {"shape": ("--set", "stages/curve/objective=shape"),
        "straight": (),  # not curved
        "gmsh": (),  # curved by Gmsh
        "default": (),
        "metric": ("--metric", "{METRIC}", "--set", "stages/curve/metric_kind=hessian"),
        "solution": ("--solution", "{FIELD}", "--objective", "solution")}


class Unknown(Exception):
    """The program does not support the request, or the equations could not be solved."""


def vertices_of(solution, count):
    """Reduces an ASCII solution of scalars to its first rows."""
    words = solution.read_text().split()
    rows = words.index("SolAtVertices") + 1
    fields = int(words[rows + 1])
    begin = rows + 2 + fields
    values = words[begin:begin + count * fields]
    solution.write_text("\n".join([*words[:rows], str(count), *words[rows + 1:begin], *values, "End", ""]))


class Bench:
    """Programs, the folder of input meshes, a folder for results, and a cache of the measurements."""

    def __init__(self, camber, meshes, threads):
        self.camber = Path(camber).resolve()
        self.poisson = self.camber.with_name("poisson")
        self.meshes, self.threads = Path(meshes).resolve(), str(threads)
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        self.cache = {}

    def once(self, key, make):
        if key not in self.cache:
            self.cache[key] = make()
        return self.cache[key]

    def file(self, *words):
        return self.folder / "-".join(map(str, words))

    def call(self, program, *words):
        threads = [] if words[0] in ("convert", "generate", "info") else ["--threads", self.threads]
        done = subprocess.run([str(program), *map(str, words), *threads], capture_output=True, text=True)
        takes_for_file = done.returncode == 3 and words[0] == "curve" and "--solution" in words
        if done.returncode == 2 or takes_for_file or (done.returncode == 3 and program == self.poisson):
            raise Unknown(done.stderr.strip())
        if done.returncode not in (0, 1):  # exit code 1: invalid elements remain
            sys.exit(f"curvature.py: {program.name} {' '.join(map(str, words))} failed: {done.stderr}")
        return done.stdout

    # ---------------------------------------------------------------- meshes

    def is_there(self, name):
        case = CASES[name]
        return bool(case.shape or case.part) or (self.meshes / f"{name}.meshb").exists()

    def linear(self, name):
        """Returns the straight mesh of a case."""
        def make():
            case = CASES[name]
            if case.part:
                curvature_parts.make(case.part, self.folder)
                return self.file(f"{case.part}.msh")
            if not case.shape:
                return self.meshes / f"{name}.meshb"
            mesh = self.file(f"{name}.meshb")
            self.call(self.camber, "generate", json.dumps(case.shape), "-o", mesh)
            return mesh
        return self.once(("linear", name), make)

    def straight(self, name):
        """Returns the straight mesh in degree 2, vertices first."""
        def make():
            mesh = self.file(name, "straight.mesh")
            self.call(self.camber, "convert", self.linear(name), "--elevate", "-o", mesh)
            return mesh
        return self.once(("straight", name), make)

    def info(self, name):
        return self.once(("info", name), lambda: json.loads(self.call(self.camber, "info", "--json", self.linear(name))))

    def fields(self, name):
        """Returns {label: (kind, expression)} of the given kinds."""
        case = CASES[name]
        low, high = self.info(name)["box"]
        every = case.fields | curvature_cases.smooth(low, high)
        return {label: field for kind in curvature_cases.KINDS for label, field in every.items() if field[0] == kind}

    def metric_of(self, name, label):
        """Returns the metric of the solution of the field on the straight mesh."""
        solution, metric = self.file("solution.sol"), self.file("metric.solb")
        self.call(self.poisson, self.straight(name), "--field", self.fields(name)[label][1], "--solution", solution)
        vertices_of(solution, self.info(name)["vertices"])
        self.call(self.camber, "metric", self.linear(name), "--solution", solution, "-o", metric, *METRIC)
        return metric

    def source(self, name, options):
        """Returns options of `camber curve` for the geometry of a case, and for its metric unless the options have one."""
        case, metric = CASES[name], self.meshes / f"{name}.solb"
        words = ["--metric", metric if metric.exists() and not case.shape else case.metric]
        words = [] if "--metric" in options else words
        return words + (["--cad", self.file(f"{case.part}.step")] if case.part else ["--geometry", case.geometry])

    def curved(self, name, words, mesh):
        """Returns the report of `camber curve`."""
        report = self.file("report.json")
        self.call(self.camber, "curve", self.linear(name), "-o", mesh, "--report", report, *self.source(name, words), *words)
        return json.loads(report.read_text())

    def meshes_of(self, name, way, label, settings):
        """Returns files and the report. Gmsh gives two files, of which the better one counts."""
        if way == "straight":
            return [self.straight(name)], None
        if way == "gmsh":
            self.linear(name)
            return [self.file(CASES[name].part, f"gmsh-{optimised}.msh") for optimised in (0, 2)], None
        places = {"{FIELD}": lambda: self.fields(name)[label][1], "{METRIC}": lambda: self.metric_of(name, label)}
        words = [places[word]() if word in places else word for word in (*WAYS[way], *settings)]
        mesh = self.file("curved.meshb")
        return [mesh], self.curved(name, words, mesh)

    # ---------------------------------------------------------------- errors

    def checked(self, mesh, fields):
        words = [word for _, text in fields.values() for word in ("--field", text)]
        return json.loads(self.call(self.camber, "check", mesh, "--json", "--worst", 0, *words))

    def solved_on(self, mesh, fields, boundary):
        """{label: {error: value}}"""
        same = {label: text for label, (_, text) in fields.items() if label not in boundary}
        runs = [(same, [])] + [({label: fields[label][1]}, ["--boundary", boundary[label]]) for label in fields if label in boundary]
        found = {}
        for texts, boundary_words in runs:
            if texts:
                rows = self.call(self.poisson, mesh, "--json", *boundary_words, *(word for text in texts.values() for word in ("--field", text)))
                found |= {label: {"solved L2": row["l2"], "solved H1": row["h1"]} for label, row in zip(texts, json.loads(rows))}
        return found

    def errors_on(self, mesh, fields, boundary):
        """Returns the output of `check` for a mesh, and {error: value} for each field."""
        check = self.checked(mesh, fields)
        found = {}
        for label, of_field in zip(fields, check["interpolation"]):
            found[label] = {"L2": of_field["curved"]["l2"]["value"], "H1": of_field["curved"]["h1"]["value"]}
            if of_field["unresolved"] or of_field["curved_inverted"]:
                found[label]["uncertain"] = 1
        if self.poisson.exists():
            try:
                for label, errors in self.solved_on(mesh, fields, boundary).items():
                    found[label] |= errors
            except Unknown as why:
                print(f"curvature.py: {mesh.name} is not solved on: {why}", file=sys.stderr, flush=True)
        return check, found

    def measured(self, name, way, labels, settings):
        """Measures one mesh and its fields."""
        begin = time.monotonic()
        meshes, report = self.meshes_of(name, way, labels[0], settings)
        took = {"seconds": time.monotonic() - begin} if report else {}
        if report:
            before = report.get("validity_before_correction", report["validity"])
            took["invalid_before"] = before["invalid"] + before["undecided"]
        fields = {label: self.fields(name)[label] for label in labels}
        checks, found = zip(*(self.errors_on(mesh, fields, CASES[name].boundary) for mesh in meshes))
        took["smallest"] = max(check["min_scaled_jacobian"] for check in checks)
        return took, {label: {key: min(one[label][key] for one in found if key in one[label])
                              for key in found[0][label]} for label in labels}

    def figures(self, name, way, labels=None, settings=()):
        """Returns figures of a mesh and {label: {error: value}} of fields; without labels, of all fields. Meshes made for a field are made for each."""
        labels = list(labels or self.fields(name))
        of_field = any(word in ("{FIELD}", "{METRIC}") for word in WAYS[way])
        took, found = {}, {}
        for part in [[label] for label in labels] if of_field else [labels]:
            key = (name, way, tuple(part), tuple(settings))
            like, errors = self.once(key, lambda part=part: self.measured(name, way, part, settings))
            found |= errors
            for what, value in like.items():
                better = min if what == "smallest" else max
                took[what] = better(took.get(what, value), value)
        return took, found


def ways_of(name):
    """Returns the ways of a mesh. Without a CAD model there is no way by Gmsh."""
    return [way for way in WAYS if way != "gmsh" or CASES[name].part]
