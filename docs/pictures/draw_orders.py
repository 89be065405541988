#!/usr/bin/env python3
"""Draws errors over mesh sizes, both by logarithms, of what bench/surface_orders.py measured: docs/algorithms/surface.md.

    python3 docs/pictures/draw_orders.py FOLDER/orders.json            # writes docs/pictures/surface-orders.svg
"""
import json
import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
CURVES = (("surrogate", "edges", "surrogate, edges", "#1b6ca8", ""), ("surrogate", "inside", "surrogate, inside", "#7fb2d6", ""),
          ("own", "boundary", "P2 on the surrogate", "#d98c3f", ""), ("cad", "boundary", "P2 on CAD", "#7a5195", ""),
          ("surrogate", "normal", "normal of the surrogate (rad)", "#1b6ca8", "4 3"),
          ("own", "normal", "normal of P2 (rad)", "#d98c3f", "4 3"))
WIDTH, HEIGHT, LEFT, TOP, GAP = 250, 260, 48, 72, 54
LOW, HIGH = -9, 0.3  # powers of ten
LEAST = 10 ** LOW


def places(sizes):
    """Powers of ten of a panel from left to right: so many in each, so that all show slopes alike."""
    middle = (math.log10(sizes[0]) + math.log10(sizes[-1])) / 2
    return middle - 0.55, middle + 0.6


def panel(name, rows, left, top):
    sizes = [row["edge"] for row in rows]
    begin, end = places(sizes)

    def at(size, error):
        return (left + WIDTH * (math.log10(size) - begin) / (end - begin),
                top + HEIGHT * (HIGH - math.log10(max(error, LEAST))) / (HIGH - LOW))

    yield f'<text x="{left + WIDTH / 2}" y="{top - 8}" text-anchor="middle" font-weight="bold">{name}</text>'
    yield f'<rect x="{left}" y="{top}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#888"/>'
    for power in range(LOW + 1, 1, 2):
        _, y = at(sizes[0], 10.0 ** power)
        yield (f'<line x1="{left}" x2="{left + WIDTH}" y1="{y:.1f}" y2="{y:.1f}" stroke="#e4e4e4"/>'
               f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">1e{power}</text>')
    for size in sizes:
        x, _ = at(size, 1)
        yield f'<text x="{x:.1f}" y="{top + HEIGHT + 15}" text-anchor="middle">{size:.2g}</text>'
    for order, height in ((4, 2e-8), (3, 2e-7)):  # what such an order looks like
        (x, y), (u, v) = at(sizes[-1], height), at(sizes[-3], height * (sizes[-3] / sizes[-1]) ** order)
        yield (f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{u:.1f}" y2="{v:.1f}" stroke="#999"/>'
               f'<text x="{x - 4:.1f}" y="{y + 4:.1f}" text-anchor="end" fill="#777">{order}</text>')
    for part, value, _, colour, dash in CURVES:
        points = [at(row["edge"], row[part][value]) for row in rows if part in row]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        yield f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="1.6" stroke-dasharray="{dash}"/>'
        yield from (f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.4" fill="{colour}"/>' for x, y in points)


def drawing(bodies):
    columns = 3
    width = columns * (WIDTH + LEFT) + 30
    height = TOP + math.ceil(len(bodies) / columns) * (HEIGHT + GAP)
    yield (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="11">'
           f'<rect width="100%" height="100%" fill="white"/>')
    for i, (_, _, name, colour, dash) in enumerate(CURVES):
        left, y = LEFT + (180 + 60 * (i // 4)) * (i % 4), 16 + 20 * (i // 4)
        yield (f'<line x1="{left}" x2="{left + 22}" y1="{y}" y2="{y}" stroke="{colour}" stroke-width="1.6" stroke-dasharray="{dash}"/>'
               f'<text x="{left + 27}" y="{y + 4}">{name}</text>')
    for i, (name, rows) in enumerate(bodies.items()):
        yield from panel(name, rows, LEFT + i % columns * (WIDTH + LEFT), TOP + i // columns * (HEIGHT + GAP))
    yield "</svg>\n"


if __name__ == "__main__":
    found = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    (HERE / "surface-orders.svg").write_text("\n".join(drawing(found)), encoding="utf-8")
