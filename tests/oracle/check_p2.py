"""Independent check of a P2 mesh. Exit status 0: no problem; 1: problems; 2: bad input.

    check_p2.py FILE [--linear INPUT] [--sphere REF,RADIUS[,CX,CY,CZ]]... [--planes] [--json]
"""
import argparse
import json
import sys

import numpy as np

import conformity
import gmf
import jacobian
import shapes

LISTED = 20


def sphere_argument(text):
    """REF,RADIUS[,CX,CY[,CZ]]"""
    parts = text.split(",")
    if len(parts) not in (2, 4, 5):
        raise argparse.ArgumentTypeError("REF,RADIUS[,CX,CY,CZ] expected")
    centre = [float(p) for p in parts[2:]] + [0.0] * (5 - len(parts))
    return int(parts[0]), float(parts[1]), centre


def validity(mesh, rows):
    """Figures and problems of the elements' Jacobians."""
    out = jacobian.examine(mesh.points, rows)
    invalid = np.flatnonzero(out["verdict"] == jacobian.INVALID) + 1
    undecided = np.flatnonzero(out["verdict"] == jacobian.UNDECIDED) + 1
    smallest = out["smallest"]
    found = smallest.element >= 0
    figures = {
        "invalid": len(invalid), "undecided": len(undecided),
        "invalid_elements": invalid.tolist(), "undecided_elements": undecided.tolist(),
        "min_scaled_jacobian": smallest.lower if found else None,
        "min_scaled_jacobian_attained": smallest.upper if found else None,
        "min_scaled_jacobian_element": smallest.element + 1 if found else None,
        "straight_inverted": int((out["straight_sign"] < 0).sum()),
        "straight_flat": int((out["straight_sign"] == 0).sum()),
        "decided_in_rationals": out["decided_in_rationals"],
    }
    problems = [f"{len(found)} {what} elements: {', '.join(map(str, found[:LISTED]))}"
                for what, found in (("invalid", invalid), ("undecided", undecided)) if len(found)]
    return figures, problems


def check(mesh, linear=None, spheres=(), planes=False):
    """All checks: (report, problems)."""
    name = "TetrahedraP2" if mesh.dim == 3 else "TrianglesP2"
    cells = mesh.cells.get(name)
    report = {"dimension": mesh.dim, "degree": 2, "nodes": len(mesh.points),
              "vertices": 0, "elements": 0, "skipped_keywords": mesh.skipped}
    if cells is None or not len(cells.nodes):
        return report, [f"no {name} in the file"]
    report["elements"] = len(cells.nodes)
    report["vertices"] = len(np.unique(cells.nodes[:, :mesh.dim + 1]))
    problems = [f"{len(c.nodes)} {n} of degree 1 in a P2 file" for n, c in mesh.cells.items()
                if gmf.CELLS[n][1] == 1 and len(c.nodes)]
    if not np.isfinite(mesh.points).all():
        problems.append("coordinates that are not finite")

    def add(key, result):
        figures, found = result
        if key:
            report[key] = figures
        else:
            report.update(figures)
        problems.extend(found)

    add(None, validity(mesh, cells.nodes))
    add("mid_node_check", conformity.mid_nodes(mesh, linear))
    add("boundary_check", conformity.boundary(mesh, linear))
    if linear is not None:
        add("survival", conformity.survival(mesh, linear))
    if planes:
        add("planes", shapes.planes(mesh))
    report["spheres"] = []
    for ref, radius, centre in spheres:
        figures, found = shapes.sphere(mesh, ref, radius, centre)
        report["spheres"].append(figures)
        problems.extend(found)
    return report, problems


def print_report(report, problems):
    for key, value in report.items():
        if isinstance(value, list) and len(value) > LISTED:
            value = f"{value[:LISTED]} and {len(value) - LISTED} more"
        print(f"{key}: {value}")
    for problem in problems:
        print(f"FAILED: {problem}")
    print("all holds" if not problems else f"{len(problems)} problems")


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Independent check of a P2 mesh.")
    parser.add_argument("file")
    parser.add_argument("--linear", metavar="INPUT", help="the linear mesh that was curved")
    parser.add_argument("--sphere", metavar="REF,RADIUS[,CX,CY,CZ]", action="append", default=[],
                        type=sphere_argument)
    parser.add_argument("--planes", action="store_true", help="planar references stay planar")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    try:
        mesh = gmf.read(options.file)
        linear = gmf.read(options.linear) if options.linear else None
    except (OSError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    report, problems = check(mesh, linear, options.sphere, options.planes)
    if options.json:
        print(json.dumps({**report, "problems": problems}))
    else:
        print_report(report, problems)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
