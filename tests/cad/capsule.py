"""Mesh of a capsule (capsule.brep: a cylinder of radius 1 up to z = 2 with a ball on top) with facets across the circle between both."""
import math
import pathlib

MESH = pathlib.Path(__file__).parent / "capsule.mesh"


def across_circle():
    """Returns the mesh as text, with every second vertex of the circle moved down the cylinder."""
    words = MESH.read_text().split()
    at = words.index("Vertices") + 2
    x, y, z = ([float(words[at + 4 * v + k]) for v in range(int(words[at - 1]))] for k in range(3))
    circle = [v for v, height in enumerate(z) if abs(height - 2) < 1e-9 and abs(math.hypot(x[v], y[v]) - 1) < 1e-9]
    assert len(circle) > 6
    for v in circle[::2]:
        words[at + 4 * v + 2] = "1.9"
    return " ".join(words) + "\n"
