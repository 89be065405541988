#!/usr/bin/env python3
"""Draws the ratios straight/curved in L2 of docs/curvature.md as bars, for the fields that the metric belongs to.

    python3 docs/pictures/draw_curvature.py            # writes docs/pictures/curvature.svg
"""
import math
from pathlib import Path

HERE = Path(__file__).resolve().parent
OBJECTIVES = {"accuracy": "#1b6ca8", "straight field": "#7fb2d6", "energy": "#d98c3f", "shape": "#9aa5ad"}
LOW, HIGH = 1 / 3, 7.5
ROW, BAR, LEFT, WIDTH = 40, 8, 250, 480


def rows():
    """(mesh, field, {objective: L2 ratio}) of the page's first table, of fields in code."""
    mesh, titles = "", []
    for line in (HERE.parent / "curvature.md").read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| mesh | field"):
            titles = [title.split(":")[0] for title in cells]
        elif titles and not line.startswith("|"):
            return
        elif titles and not line.startswith("|---"):
            mesh = cells[0] or mesh
            if cells[1].startswith("`"):
                yield mesh, cells[1].strip("`"), {t: float(c.split(",")[0].rstrip(" !")) for t, c in zip(titles[2:], cells[2:])}


def x(ratio):
    return LEFT + WIDTH * math.log(min(max(ratio, LOW), HIGH) / LOW) / math.log(HIGH / LOW)


def drawing():
    table = list(rows())
    height = ROW * len(table) + 70
    yield (f'<svg xmlns="http://www.w3.org/2000/svg" width="{LEFT + WIDTH + 40}" height="{height}" font-family="sans-serif" font-size="12">'
           f'<rect width="100%" height="100%" fill="white"/>')
    for ratio in (0.5, 1, 2, 4):
        yield (f'<line x1="{x(ratio):.1f}" x2="{x(ratio):.1f}" y1="40" y2="{height - 20}" stroke="{"black" if ratio == 1 else "#ddd"}"/>'
               f'<text x="{x(ratio):.1f}" y="{height - 5}" text-anchor="middle">{ratio:g}</text>')
    for i, (name, colour) in enumerate(OBJECTIVES.items()):
        yield (f'<rect x="{LEFT + 110 * i}" y="12" width="12" height="12" fill="{colour}"/>'
               f'<text x="{LEFT + 110 * i + 17}" y="22">{name}</text>')
    last = ""
    for i, (mesh, label, ratios) in enumerate(table):
        top = 44 + ROW * i
        if mesh != last:
            yield f'<text x="8" y="{top + 16}" font-weight="bold">{mesh}</text>'
            last = mesh
        yield f'<text x="{LEFT - 10}" y="{top + 16}" text-anchor="end">{label}</text>'
        for k, (name, colour) in enumerate(OBJECTIVES.items()):
            begin, end = sorted((x(1), x(ratios[name])))
            yield f'<rect x="{begin:.1f}" y="{top + BAR * k + 2}" width="{max(end - begin, 1):.1f}" height="{BAR - 1}" fill="{colour}"/>'
    yield "</svg>\n"


if __name__ == "__main__":
    (HERE / "curvature.svg").write_text("\n".join(drawing()), encoding="utf-8")
