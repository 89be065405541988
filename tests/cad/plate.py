"""Tetrahedral mesh of a plate [-1, 1]² × [0, 0.5] with a hole of radius 0.5 along z."""
import math

HOLE = {"references": [7], "cylinder": {"point": [0, 0, 0], "axis": [0, 0, 1], "radius": 0.5}}


def plate(n=4, rings=2, layers=2, radius=0.5, height=0.5, growth=1):
    """Returns points, tetrahedra and triangles with references.

    Rings grow outwards by `growth`. References: 1 to 4 the sides at low x, high x, low y, high y, 5 bottom, 6 top, 7 the hole.
    """
    around = 8 * (n // 2)
    points, number = [], {}
    for k in range(layers + 1):
        for j in range(rings + 1):
            for i in range(around):
                angle = 2 * math.pi * i / around
                x, y = math.cos(angle), math.sin(angle)
                side = max(abs(x), abs(y))
                t = j / rings if growth == 1 else (growth ** j - 1) / (growth ** rings - 1)
                number[i, j, k] = len(points)
                p = [(1 - t) * radius * c + t * c / side for c in (x, y)]
                if j == rings:
                    p = [round(c) if abs(abs(c) - 1) < 1e-12 else c for c in p]
                points.append((p[0], p[1], height * k / layers))
    def at(i, j, k):
        return number[i % around, j, k]
    tetrahedra, triangles = [], []
    def volume(t):
        a, b, c, d = (points[v] for v in t)
        u, v, w = ([q[m] - a[m] for m in range(3)] for q in (b, c, d))
        return (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]))
    for i in range(around):
        for j in range(rings):
            for k in range(layers):
                # Kuhn's subdivision, so that faces of neighbours agree.
                for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
                    corner, path = [i, j, k], [at(i, j, k)]
                    for axis in order:
                        corner[axis] += 1
                        path.append(at(*corner))
                    if volume(path) < 0:
                        path[0], path[1] = path[1], path[0]
                    tetrahedra.append(tuple(path))
    faces = {}
    for t in tetrahedra:
        a, b, c, d = t
        for f in ((a, c, b), (a, b, d), (b, c, d), (a, d, c)):
            faces.setdefault(tuple(sorted(f)), []).append(f)
    for found in faces.values():
        if len(found) == 1:
            p = [points[v] for v in found[0]]
            def all_at(axis, value):
                return all(abs(q[axis] - value) < 1e-12 for q in p)
            reference = next((r for r, (axis, value) in enumerate(((0, -1), (0, 1), (1, -1), (1, 1), (2, 0), (2, height)), 1)
                              if all_at(axis, value)), 7)
            triangles.append((*found[0], reference))
    return points, tetrahedra, triangles


def text(points, tetrahedra, triangles):
    rows = lambda name, items: f"{name}\n{len(items)}\n" + "".join(" ".join(map(repr, r)) + "\n" for r in items)
    return ("MeshVersionFormatted 2\nDimension 3\n" + rows("Vertices", [(*p, 0) for p in points]) +
            rows("Tetrahedra", [tuple(v + 1 for v in t) + (1,) for t in tetrahedra]) +
            rows("Triangles", [tuple(v + 1 for v in t[:3]) + (t[3],) for t in triangles]) + "End\n")


if __name__ == "__main__":
    print(text(*plate()), end="")
