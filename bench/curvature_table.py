"""Table of bench/curvature.py from rows {mesh: {way: row}}. A row has the keys "L2 FIELD", "H1 FIELD", "solved L2 FIELD", "solved H1 FIELD" and
"KIND FIELD" besides figures of the mesh."""
from curvature_cases import ERRORS, KINDS

TITLES = {"straight": "straight", "gmsh": "Gmsh, order 2", "default": "default", "metric": "metric of the field", "solution": "solution"}


def kinds_of(row):
    """{label: kind}"""
    return {key.removeprefix(kind + " "): kind for kind in KINDS for key in row if key.startswith(kind + " ")}


def ratios(base, row, label):
    """Returns the known ratios of errors shape/this way."""
    return [base[f"{error} {label}"] / row[f"{error} {label}"] for error in ERRORS
            if row.get(f"{error} {label}") and f"{error} {label}" in base]


def pairs(numbers):
    """L2, H1 / solved L2, H1"""
    return " / ".join(", ".join(numbers[i:i + 2]) for i in range(0, len(numbers), 2))


def cells(base, row, labels):
    """Returns one cell per field for a mesh and a way, with the minimum ratio in bold."""
    found = {label: ratios(base, row, label) for label in labels}
    least = min((x for one in found.values() for x in one), default=0)
    written = lambda x: f"**{x:.2f}**" if x == least < 0.995 else f"{x:.2f}"
    return {label: (pairs([written(x) for x in one]) or "-") + (" !" if f"uncertain {label}" in row else "") for label, one in found.items()}


def errors(row, label):
    return pairs([f"{row[f'{error} {label}']:.2e}" for error in ERRORS if f"{error} {label}" in row])


def ways_of(found):
    return [way for way in TITLES if any(ways.get(way) for ways in found.values())]


def titles(found):
    return ["mesh", "kind", "field", "shape: errors L2, H1 / solved L2, H1", *(TITLES[way] for way in ways_of(found))]


def titles_of_took(found):
    return ["mesh", "", "shape", *(TITLES[way] for way in ways_of(found))]


def lines(found):
    """Yields one line per mesh and field."""
    for mesh, ways in found.items():
        base, kinds = ways["shape"], kinds_of(ways["shape"])
        columns = {way: cells(base, ways[way], kinds) if ways.get(way) else {} for way in ways_of(found)}
        for i, (label, kind) in enumerate(kinds.items()):
            yield [mesh if i == 0 else "", kind, f"`{label}`", errors(base, label), *(column.get(label, "-") for column in columns.values())]


def took(found):
    """Yields one line per mesh and figure."""
    shown = {"invalid_before": ("invalid before repair", "d"), "smallest": ("smallest scaled Jacobian", ".3g"), "seconds": ("time", ".1f")}
    for mesh, ways in found.items():
        for i, (key, (what, form)) in enumerate(shown.items()):
            unit = " s" if key == "seconds" else ""
            written = (f"{ways[way][key]:{form}}{unit}" if key in ways.get(way, {}) else "-" for way in ("shape", *ways_of(found)))
            yield [mesh if i == 0 else "", what, *written]


def markdown(head, rows):
    return "".join("| " + " | ".join(map(str, line)) + " |\n" for line in [head, ["---"] * len(head), *rows])
