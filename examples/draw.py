#!/usr/bin/env python3
"""Pictures of an adaptation: the first and the last cycle's mesh with its curved edges, the solution as colours, and errors.

    draw.py FOLDER -o PICTURE.png [--zoom X0 X1 Y0 Y1] [--camber build/bin/camber]

FOLDER is that of camber's cycles: cycle-000, cycle-001 ... with a mesh and solution.sol each, and cycles.json, which has the errors
where the exact solution is known. Meshes of formats other than .mesh and .mfem are converted by camber. In 3D the cut z = 0 is
drawn, by the curves in which faces of tetrahedra cross it.
"""
import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import LineCollection  # noqa: E402

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from mesh_files import EDGES, read_mesh, read_solution  # noqa: E402

COLOURS = "Spectral_r"
FACES = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]


def basis(points):
    """Nodal functions of degree 2 at points of the reference triangle (n, 2): (n, 6)."""
    l = np.column_stack((1 - points.sum(axis=1), points))
    return np.column_stack([l[:, i] * (2 * l[:, i] - 1) for i in range(3)] + [4 * l[:, i] * l[:, j] for i, j in EDGES[2]])


def lattice(n):
    """Points and triangles of the reference triangle cut into n² parts."""
    number, points = {}, []
    for j in range(n + 1):
        for i in range(n + 1 - j):
            number[i, j] = len(points)
            points.append((i / n, j / n))
    cells = [(number[i, j], number[i + 1, j], number[i, j + 1]) for i, j in number if i + j < n]
    cells += [(number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]) for i, j in number if i + j < n - 1]
    return np.array(points), np.array(cells)


def draw_triangles(axes, mesh, u, levels, n):
    points, cells = lattice(n)
    values = basis(points)
    x = np.einsum("pn,end->epd", values, mesh.nodes[mesh.elements])
    colours = u[mesh.elements] @ values.T
    parts = (np.arange(len(mesh.elements))[:, None, None] * len(points) + cells).reshape(-1, 3)
    image = axes.tripcolor(x[..., 0].ravel(), x[..., 1].ravel(), parts, colours.ravel(), shading="gouraud", rasterized=True,
                           cmap=COLOURS, vmin=levels[0], vmax=levels[1])
    edges = {}
    for element in mesh.elements:
        for k, (a, b) in enumerate(EDGES[2]):
            edges[element[3 + k]] = (element[a], element[b], element[3 + k])
    t = np.linspace(0, 1, 17)[:, None]
    a, b, middle = (mesh.nodes[list(column)][:, None] for column in zip(*edges.values()))
    curves = a * (1 - t) * (1 - 2 * t) + b * t * (2 * t - 1) + middle * 4 * t * (1 - t)
    axes.add_collection(LineCollection(curves, colors="black", linewidths=0.4, alpha=0.7))
    return image


def draw_cut(axes, mesh, u, levels, n):
    local = {pair: 4 + k for k, (i, j) in enumerate(EDGES[3]) for pair in ((i, j), (j, i))}
    faces = np.concatenate([mesh.elements[:, [a, b, c, local[a, b], local[b, c], local[c, a]]] for a, b, c in FACES])
    faces = faces[np.unique(np.sort(faces[:, 3:], axis=1), axis=0, return_index=True)[1]]
    faces = faces[(mesh.nodes[faces, 2].min(axis=1) < 0) & (mesh.nodes[faces, 2].max(axis=1) > 0)]
    points, cells = lattice(n)
    values = basis(points)
    x = np.einsum("pn,fnd->fpd", values, mesh.nodes[faces])[:, cells].reshape(-1, 3, 3)
    colours = (u[faces] @ values.T)[:, cells].reshape(-1, 3)
    above = x[..., 2] > 0
    crossed = (above.sum(axis=1) % 3) != 0
    x, colours, above = x[crossed], colours[crossed], above[crossed]
    # The corner that is alone on its side, and the two others.
    alone = np.argmax(above == (above.sum(axis=1) == 1)[:, None], axis=1)
    rows, ends, means = np.arange(len(x)), [], 0
    for step in (1, 2):
        other = (alone + step) % 3
        za, zb = x[rows, alone, 2], x[rows, other, 2]
        t = (za / (za - zb))[:, None]
        ends.append(x[rows, alone, :2] * (1 - t) + x[rows, other, :2] * t)
        means = means + (colours[rows, alone] * (1 - t[:, 0]) + colours[rows, other] * t[:, 0]) / 2
    lines = LineCollection(np.stack(ends, axis=1), array=means, linewidths=0.7, cmap=COLOURS, capstyle="round")
    lines.set_clim(*levels)
    axes.add_collection(lines)
    axes.set_facecolor("#eeeeee")
    axes.autoscale_view()
    return lines


def draw_errors(axes, table, dimension):
    found = [(row["unknowns"], row["solution_error"]["l2"], row["solution_error"]["h1"]) for row in table if "solution_error" in row]
    if not found:
        axes.set_axis_off()
        return
    unknowns, l2, h1 = np.array(found).T
    axes.loglog(unknowns, l2, "o-", label="L2", color="tab:blue")
    axes.loglog(unknowns, h1, "s-", label="H1", color="tab:orange")
    ends = np.array([unknowns.min(), unknowns.max()])
    axes.loglog(ends, l2[-1] * (ends / unknowns[-1]) ** (-3 / dimension), ":", color="grey", label="third order")
    for cycle, (n, e) in enumerate(zip(unknowns, l2)):
        axes.annotate(str(cycle), (n, e), textcoords="offset points", xytext=(6, 5), fontsize=8)
    axes.set_xlabel("unknowns")
    axes.set_title("error of the solution, by cycle")
    axes.xaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%d"))
    axes.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.grid(True, which="major", alpha=0.3)
    axes.legend()


def read_cycle(folder, camber):
    mesh_file = next(os.path.join(folder, name) for name in sorted(os.listdir(folder)) if name.startswith("mesh."))
    with tempfile.TemporaryDirectory() as place:
        if not mesh_file.endswith((".mesh", ".mfem")):
            converted = os.path.join(place, "mesh.mesh")
            subprocess.run([camber, "convert", mesh_file, "-o", converted], check=True, capture_output=True)
            mesh_file = converted
        return read_mesh(mesh_file), read_solution(os.path.join(folder, "solution.sol"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("-o", "--output", required=True, help="the picture (.png, .svg, .pdf)")
    parser.add_argument("--zoom", nargs=4, type=float, metavar=("X0", "X1", "Y0", "Y1"), help="draw this part of the last mesh too")
    parser.add_argument("--camber", default=shutil.which("camber") or "build/bin/camber")
    given = parser.parse_args()

    cycles = sorted(name for name in os.listdir(given.folder) if re.fullmatch(r"cycle-\d+", name)
                    and os.path.exists(os.path.join(given.folder, name, "solution.sol")))
    first, last = (read_cycle(os.path.join(given.folder, name), given.camber) for name in (cycles[0], cycles[-1]))
    levels = last[1].min(), last[1].max()
    draw = draw_triangles if first[0].dimension == 2 else draw_cut

    wide = np.ptp(first[0].nodes[:, 0]) > 1.5 * np.ptp(first[0].nodes[:, 1])
    panels = [(*first, "cycle 0", None), (*last, f"cycle {len(cycles) - 1}", None)]
    if given.zoom:
        panels.append((*last, f"cycle {len(cycles) - 1}, a part", given.zoom))
    count = len(panels) + 1
    shape = (2, (count + 1) // 2) if wide or count == 4 else (1, count)
    figure, grid = plt.subplots(*shape, figsize=(6 * shape[1], (3.2 if wide else 5.4) * shape[0]), constrained_layout=True)
    axes = list(np.ravel(grid))
    for place, (mesh, u, title, part) in zip(axes, panels):
        image = draw(place, mesh, u, levels, 10 if draw is draw_triangles else 6)
        place.set_aspect("equal")
        what = "triangles" if mesh.dimension == 2 else "tetrahedra"
        place.set_title(f"{title}: {len(mesh.elements)} {what}" if part is None else title)
        if part:
            place.set_xlim(part[:2])
            place.set_ylim(part[2:])
    figure.colorbar(image, ax=axes[:len(panels)], shrink=0.7, label="u")
    with open(os.path.join(given.folder, "cycles.json")) as file:
        draw_errors(axes[len(panels)], json.load(file)["cycles"], first[0].dimension)
    for place in axes[count:]:
        place.set_axis_off()
    figure.savefig(given.output, dpi=110, bbox_inches="tight")


if __name__ == "__main__":
    main()
