#!/usr/bin/env python3
"""Draws the tables of "Does curvature pay in adaptation?": L2 errors against unknowns, a panel a field, a line a way; bars: the last three cycles.

    python3 docs/pictures/draw_adaptation.py [PAGE]            # docs/curvature.md; writes docs/pictures/adaptation.svg (needs matplotlib)
"""
import math
import re
import sys
from pathlib import Path

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams |= {"svg.fonttype": "none", "svg.hashsalt": "camber", "font.family": "sans-serif", "font.size": 9, "axes.edgecolor": "#888"}
import matplotlib.pyplot as plt  # noqa: E402

HERE = Path(__file__).resolve().parent
WAYS = {"linear": ("degree 1, straight", "#9aa5ad", "s"), "straight": ("degree 2, straight inside", "#d98c3f", "o"),
        "curved": ("degree 2, curved", "#1b6ca8", "o"), "chords": ("degree 2, chords at the wall too", "#7fb2d6", "^"),
        "walls": ("degree 2, straight inside", "#d98c3f", "o")}
CELL = re.compile(r"(\d+): (\S+), (\S+) \((\S+) to (\S+);")
COLUMNS = 3


def cells_of(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def panels(lines):
    """{title: {way: [(unknowns, L2, least, largest)]}} of all tables whose columns are ways."""
    found, titles, name = {}, [], ""
    for line in lines:
        cells = cells_of(line)
        if not line.startswith("|"):
            titles = []
        elif "curved" in cells and "complexity" in cells:
            titles, name = cells, "solved: exp(-(r-1)/0.05), 2D"
        elif titles and not set(line) <= set("|- \n"):
            if titles[0] == "field" and cells[0]:
                name = cells[0].replace("`", "")
            for way, cell in zip(titles, cells):
                if way in WAYS and (match := CELL.match(cell)):
                    unknowns, l2, _, least, largest = map(float, match.groups())
                    found.setdefault(name, {}).setdefault(way, []).append((unknowns, l2, least, largest))
    return found


def written(title):
    """Name and options, then the formula."""
    name, _, formula = title.partition(": ")
    formula, *options = formula.split(" --")
    for long, short in (("sqrt(x^2+y^2+z^2)", "r"), ("sqrt(x^2+y^2)", "r"), ("6.28318530718*", "2π"), ("*", "")):
        formula = formula.replace(long, short)
    return "\n".join((", ".join((name, *options)), formula))


def draw(axes, title, ways):
    for way, rows in ways.items():
        label, colour, mark = WAYS[way]
        x, y, least, largest = zip(*rows)
        axes.vlines(x, least, largest, color=colour, lw=1.2, alpha=0.7)
        axes.plot(x, y, color=colour, marker=mark, ms=3.5, lw=1.5, label=label)
    axes.set(xscale="log", yscale="log")
    axes.set_title(written(title), fontsize=8, loc="left")
    axes.grid(color="#e4e4e4", lw=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.minorticks_off()


def drawing(found):
    rows = math.ceil(len(found) / COLUMNS)
    figure, grid = plt.subplots(rows, COLUMNS, figsize=(9, 2.75 * rows + 0.5), squeeze=False)
    every = list(grid.flat)
    for axes, (title, ways) in zip(every, found.items()):
        draw(axes, title, ways)
    for axes in every[len(found):]:
        axes.axis("off")
    for axes in grid[:, 0]:
        axes.set_ylabel("error in L2")
    for axes in every[max(0, len(found) - COLUMNS):len(found)]:
        axes.set_xlabel("unknowns")
    legend = {label: handle for axes in every for handle, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(legend.values(), legend.keys(), loc="upper left", ncol=len(legend), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.3 / (2.75 * rows + 0.5)))
    return figure


if __name__ == "__main__":
    page = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parent / "curvature.md"
    panels_of_page = panels(page.read_text(encoding="utf-8").splitlines())
    drawing(panels_of_page).savefig(HERE / "adaptation.svg", metadata={"Date": None})
