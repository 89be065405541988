"""Quality of standalone surface meshes in analytic metrics and on analytic surfaces. This module shares no code with any remesher."""
import numpy as np

import analytic_metrics as metrics

STEP = 1e-6  # step of gradients


def edges_of(triangles):
    pairs = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def euler(triangles):
    """Returns V - E + F of the used vertices, edges and triangles."""
    return len(np.unique(triangles)) - len(edges_of(triangles)) + len(triangles)


def normals(x, triangles):
    """Returns normals with twice the area as length."""
    a, b, c = x[triangles].transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def gradients(face, at):
    return np.stack([face(at + STEP * np.eye(3)[i]) - face(at - STEP * np.eye(3)[i]) for i in range(3)], 1) / (2 * STEP)


class Surface:
    """Data from the initial mesh: the face of the true surface of each reference, and the orientation of its triangles."""

    def __init__(self, faces, x, triangles, references):
        self.euler, self.of_reference = euler(triangles), {}
        for reference in np.unique(references):
            mine = triangles[references == reference]
            face = min(faces, key=lambda f: abs(f(x[np.unique(mine)])).max())  # noqa: B023: called here
            if abs(face(x[np.unique(mine)])).max() > 1e-6:
                raise SystemExit(f"surface_measure.py: reference {reference} is on no face of the surface")
            turned = (normals(x, mine) * gradients(face, x[mine].mean(1))).sum()
            self.of_reference[reference] = face, np.sign(turned)

    def sides(self, x, triangles, references):
        """Returns 1 for each triangle, or -1 if it is folded over, and the maximum distances of vertices and of midpoints."""
        side, vertices, middles = np.ones(len(triangles)), 0.0, 0.0
        for reference, (face, sign) in self.of_reference.items():
            mine = references == reference
            if not mine.any():
                continue
            centres = x[triangles[mine]].mean(1)
            side[mine] = sign * np.sign((normals(x, triangles[mine]) * gradients(face, centres)).sum(1))
            vertices = max(vertices, abs(face(x[np.unique(triangles[mine])])).max())
            middles = max(middles, abs(face(centres)).max())
        return side, vertices, middles


def qualities(field, x, triangles):
    """Returns the mean ratio of each triangle in its plane (1 if regular), in the log-Euclidean mean of the metrics at its vertices."""
    rows, sizes = field(x)
    logs = np.einsum("nki,nk,nkj->nij", rows, -2 * np.log(sizes), rows)
    values, axes = np.linalg.eigh(logs[triangles].mean(1))
    a, b, c = x[triangles].transpose(1, 0, 2)
    u, v = (np.einsum("nik,ni->nk", axes, side) * np.exp(values / 2) for side in (b - a, c - a))
    areas = np.linalg.norm(np.cross(u, v), axis=1) / 2
    return 4 * 3 ** 0.5 * areas / ((u ** 2).sum(1) + (v ** 2).sum(1) + ((v - u) ** 2).sum(1))


def judged(case, surface, x, triangles, references):
    edges = edges_of(triangles)
    long = metrics.lengths(case.field, x[edges[:, 0]], x[edges[:, 1]])
    side, vertices, middles = surface.sides(x, triangles, references)
    quality = side * qualities(case.field, x, triangles)
    area = np.linalg.norm(normals(x, triangles), axis=1).sum() / 2
    return {"triangles": len(triangles), "unit": ((long >= metrics.SLIM) & (long <= metrics.LONG)).mean(), "least": quality.min(),
            "mean": quality.mean(), "vertices": vertices, "middles": middles, "area": area / case.area - 1,
            "euler": euler(triangles) == surface.euler, "references": set(np.unique(references)) == set(surface.of_reference)}
