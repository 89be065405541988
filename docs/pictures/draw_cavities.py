"""Draws cavities before and after as SVG: cavity-insertion.svg, cavity-collapse.svg, cavity-swap.svg, cavity-shell.svg, and
in a curved mesh cavity-curved-insertion.svg, cavity-curved-collapse.svg, cavity-curved-swap.svg.

    ninja -C build cavities && build/bin/cavities | python3 docs/pictures/draw_cavities.py

The meshes are what Camber's operations gave: bench/cavities.cpp prints them.
"""
import json
import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PANEL, GAP = 380, 24
CAVITY, STAR, LINE, BOLD, POINT = "#f7d9b0", "#bfdcf0", "#8a939b", "#1b4f72", "#c0392b"
TITLES = {"insertion": ("the cavity of a point", "joined to it"), "collapse": ("the vertex and its ball", "joined to a neighbour"),
          "swap": ("an edge's two triangles", "joined to a vertex across"), "shell": ("an edge and its shell", "joined to a vertex around it"),
          "curved-insertion": ("the cavity of a point on a curved edge", "joined to it"),
          "curved-collapse": ("the vertex and its ball", "joined to a neighbour"),
          "curved-swap": ("an edge's two triangles", "joined to a vertex across")}
EYE = (0.35, -1.0, 0.42)


def seen(point):
    """A point in the plane of the picture: itself, or the view from EYE, z upwards."""
    if len(point) == 2:
        return point
    n = math.sqrt(sum(x * x for x in EYE))
    eye = [x / n for x in EYE]
    m = math.hypot(eye[0], eye[1])
    right = (-eye[1] / m, eye[0] / m, 0)
    up = (-eye[2] * right[1], eye[2] * right[0], eye[0] * right[1] - eye[1] * right[0])
    return tuple(sum(a * b for a, b in zip(axis, point)) for axis in (right, up))


class Panel:
    """One half of a picture, as SVG."""

    def __init__(self, scene, which, left):
        """What is seen: the cavity, and a share of its size around it."""
        mesh = scene[which]
        cavity = [seen(scene["before"]["points"][v]) for *vertices, marked in scene["before"]["elements"] if marked for v in vertices]
        nodes = nodes_of(scene["before"])
        cavity += [nodes[edge] for edge in edges_of(scene["before"]) if edge in nodes]
        low, high = ([limit(p[i] for p in cavity) for i in (0, 1)] for limit in (min, max))
        self.x, self.y = ((a + b) / 2 for a, b in zip(low, high))
        around = 1.06 if len(mesh["points"][0]) == 3 else 1.5
        self.half = around * max(b - a for a, b in zip(low, high)) / 2
        self.left = left
        self.mesh = mesh
        self.points = [seen(p) for p in mesh["points"]]
        self.nodes = nodes_of(mesh)

    def at(self, p):
        scale = PANEL / 2 / self.half
        return self.left + PANEL / 2 + scale * (p[0] - self.x), PANEL / 2 - scale * (p[1] - self.y)

    def path(self, vertices, closed=True):
        """Along the edges; a curved one is a quadratic Bézier curve with the control point 2 node - (a + b) / 2."""
        steps = [self.place(self.points[vertices[0]])]
        for a, b in zip(vertices, [*vertices[1:], *vertices[:closed]]):
            node = self.nodes.get((min(a, b), max(a, b)))
            control = node and [2 * m - (x + y) / 2 for m, x, y in zip(node, self.points[a], self.points[b])]
            if control or b != vertices[0]:
                steps.append((f"Q{self.place(control)} " if control else "L") + self.place(self.points[b]))
        return "M" + "".join(steps) + ("Z" if closed else "")

    def place(self, p):
        return "{:.1f},{:.1f}".format(*self.at(p))

    def mid_nodes(self):
        return (self.dot(node, LINE, 2.2) for node in self.nodes.values())

    def straight_forms(self):
        """Of new triangles that their vertices alone would invert."""
        for *vertices, marked in self.mesh["elements"]:
            (ax, ay), (bx, by), (cx, cy) = (self.points[v] for v in vertices)
            if marked and (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) <= 0:
                places = "L".join(self.place(self.points[v]) for v in vertices)
                yield f'<path d="M{places}Z" fill="{POINT}" fill-opacity="0.15" stroke="{POINT}" stroke-width="1.3" stroke-dasharray="5 4"/>'

    def triangles(self, fill):
        for *vertices, marked in self.mesh["elements"]:
            yield f'<path d="{self.path(vertices)}" fill="{fill if marked else "white"}" stroke="{LINE}" stroke-width="1"/>'

    def line(self, a, b, colour, width, more=""):
        return f'<path d="{self.path((a, b), False)}" fill="none" stroke="{colour}" stroke-width="{width}" {more}/>'

    def dot(self, p, colour=POINT, radius=5):
        x, y = self.at(p)
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{colour}"/>'


def nodes_of(mesh):
    """By their edges' ends; none of a straight mesh."""
    return {(min(a, b), max(a, b)): place for a, b, *place in mesh.get("nodes", ())}


def edges_of(mesh, marked_only=True):
    return {tuple(sorted((a, b))) for *v, marked in mesh["elements"] if marked or not marked_only
            for i, a in enumerate(v) for b in v[:i]}


def ellipse(root, centre, panel):
    """Where |R (x - p)| = 1."""
    (a, b), (c, d) = root
    det = a * d - b * c
    turns = [2 * math.pi * i / 90 for i in range(90)]
    circle = [(math.cos(t), math.sin(t)) for t in turns]
    points = [(centre[0] + (d * x - b * y) / det, centre[1] + (a * y - c * x) / det) for x, y in circle]
    path = "M" + "L".join("{:.1f},{:.1f}".format(*panel.at(p)) for p in points) + "Z"
    return f'<path d="{path}" fill="none" stroke="{POINT}" stroke-width="1.3" stroke-dasharray="5 4"/>'


def plane_picture(scene):
    before, after = Panel(scene, "before", 0), Panel(scene, "after", PANEL + GAP)
    point = scene["point"]
    place = scene["after"]["points"][point]
    yield 0, before.triangles(CAVITY)
    yield 0, before.mid_nodes()
    gone = edges_of(scene["before"]) - edges_of(scene["after"], False)
    yield 0, (before.line(a, b, POINT, 1.8, 'stroke-dasharray="3 3"') for a, b in sorted(gone))
    if "root" in scene:
        yield 0, [ellipse(scene["root"], place, before)]
    if "goes" in scene:
        yield 0, [before.line(scene["goes"], point, BOLD, 2.5, 'marker-end="url(#arrow)"'), before.dot(scene["before"]["points"][scene["goes"]])]
    yield 0, [before.dot(place, POINT if "goes" not in scene else BOLD)]
    yield 1, after.triangles(STAR)
    made = edges_of(scene["after"]) - edges_of(scene["before"], "root" in scene)
    yield 1, (after.line(a, b, BOLD, 2) for a, b in sorted(made))
    if after.nodes:
        yield 1, after.straight_forms()
    yield 1, after.mid_nodes()
    yield 1, [after.dot(place, BOLD if "goes" in scene else POINT)]


def space_picture(scene):
    """Edges alone; those that go or come are bold, and the faces at them are tinted."""
    before, after = Panel(scene, "before", 0), Panel(scene, "after", PANEL + GAP)
    old, new = edges_of(scene["before"]), edges_of(scene["after"])
    # The ring around the edge: behind all.
    ring = list(range(2, len(scene["before"]["points"])))
    yield 0, [f'<path d="{before.path(ring)}" fill="{CAVITY}" fill-opacity="0.8" stroke="none"/>']
    yield 0, (before.line(a, b, LINE, 1.3) for a, b in sorted(old & new))
    yield 0, (before.line(a, b, POINT, 3) for a, b in sorted(old - new))
    yield 0, [before.dot(before.points[v], BOLD, 4) for v in [scene["point"]]]
    yield 1, [f'<path d="{after.path(ring)}" fill="{STAR}" fill-opacity="0.8" stroke="none"/>']
    yield 1, (after.line(a, b, LINE, 1.3) for a, b in sorted(old & new))
    yield 1, (after.line(a, b, BOLD, 3) for a, b in sorted(new - old))
    yield 1, [after.dot(after.points[v], BOLD, 4) for v in [scene["point"]]]


def drawing(name, scene):
    width, height = 2 * PANEL + GAP, PANEL + 24
    yield (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
           f'font-family="sans-serif" font-size="14">')
    yield '<rect width="100%" height="100%" fill="white"/><defs>'
    yield (f'<marker id="arrow" viewBox="0 0 10 10" refX="14" refY="5" markerWidth="5" markerHeight="5" orient="auto">'
           f'<path d="M0,0L10,5L0,10Z" fill="{BOLD}"/></marker>')
    for i in (0, 1):
        yield f'<clipPath id="panel{i}"><rect x="{i * (PANEL + GAP)}" y="0" width="{PANEL}" height="{PANEL}"/></clipPath>'
    yield "</defs>"
    parts = space_picture(scene) if len(scene["before"]["points"][0]) == 3 else plane_picture(scene)
    for panel, lines in parts:
        yield f'<g clip-path="url(#panel{panel})" stroke-linejoin="round">'
        yield from lines
        yield "</g>"
    for i, title in enumerate(TITLES[name]):
        yield f'<text x="{i * (PANEL + GAP) + PANEL / 2}" y="{PANEL + 18}" text-anchor="middle">{title}</text>'
    yield "</svg>\n"


if __name__ == "__main__":
    for scene_name, data in json.load(sys.stdin).items():
        (HERE / f"cavity-{scene_name}.svg").write_text("\n".join(drawing(scene_name, data)), encoding="utf-8")
