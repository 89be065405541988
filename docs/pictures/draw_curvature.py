#!/usr/bin/env python3
"""Draws the ratios of docs/curvature.md's table as bars: L2 errors of solutions by shape/by each way; of interpolants where nothing was solved.

    python3 docs/pictures/draw_curvature.py            # writes docs/pictures/curvature.svg
"""
import math
import re
from pathlib import Path

HERE = Path(__file__).resolve().parent
WAYS = {"straight": "#9aa5ad", "Gmsh, order 2": "#d98c3f", "default": "#1b6ca8", "metric of the field": "#7fb2d6", "solution": "#3c8d5a"}
LOW, HIGH = 1 / 5, 12
BAR, LEFT, WIDTH = 6, 250, 480


def ratio_of(cell):
    """The L2 error's ratio of a cell: solved, where that is there."""
    numbers = re.findall(r"\d+\.\d+", cell)
    return float(numbers[2 if len(numbers) == 4 else 0]) if numbers else None


def rows():
    """(mesh, field, {way: ratio}) of the page's first table."""
    mesh, titles = "", []
    for line in (HERE.parent / "curvature.md").read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| mesh | kind | field"):
            titles = cells
        elif titles and not line.startswith("|"):
            return
        elif titles and not line.startswith("| ---"):
            mesh = cells[0] or mesh
            yield mesh, cells[2].strip("`"), {title: ratio_of(cell) for title, cell in zip(titles, cells) if title in WAYS}


def x(ratio):
    return LEFT + WIDTH * math.log(min(max(ratio, LOW), HIGH) / LOW) / math.log(HIGH / LOW)


def drawing():
    table = list(rows())
    shown = [way for way in WAYS if any(ratios.get(way) for _, _, ratios in table)]
    row = BAR * len(shown) + 8
    height = row * len(table) + 70
    yield (f'<svg xmlns="http://www.w3.org/2000/svg" width="{LEFT + WIDTH + 40}" height="{height}" font-family="sans-serif" font-size="12">'
           f'<rect width="100%" height="100%" fill="white"/>')
    for ratio in (0.25, 0.5, 1, 2, 4, 8):
        yield (f'<line x1="{x(ratio):.1f}" x2="{x(ratio):.1f}" y1="40" y2="{height - 20}" stroke="{"black" if ratio == 1 else "#ddd"}"/>'
               f'<text x="{x(ratio):.1f}" y="{height - 5}" text-anchor="middle">{ratio:g}</text>')
    for i, way in enumerate(shown):
        yield (f'<rect x="{LEFT + 110 * i}" y="12" width="12" height="12" fill="{WAYS[way]}"/>'
               f'<text x="{LEFT + 110 * i + 17}" y="22">{way}</text>')
    last = ""
    for i, (mesh, label, ratios) in enumerate(table):
        top = 44 + row * i
        if mesh != last:
            yield f'<text x="8" y="{top + row / 2 + 3}" font-weight="bold">{mesh}</text>'
            last = mesh
        yield f'<text x="{LEFT - 10}" y="{top + row / 2 + 3}" text-anchor="end">{label}</text>'
        for k, way in enumerate(shown):
            if ratios.get(way):
                begin, end = sorted((x(1), x(ratios[way])))
                yield f'<rect x="{begin:.1f}" y="{top + BAR * k + 2}" width="{max(end - begin, 1):.1f}" height="{BAR - 1}" fill="{WAYS[way]}"/>'
    yield "</svg>\n"


if __name__ == "__main__":
    (HERE / "curvature.svg").write_text("\n".join(drawing()), encoding="utf-8")
