"""Second evaluation of the length reduction of a P2 mesh on the true field (the back mesh).

    length_reduction.py LINEAR P2 [--metric natural|FILE.solb] [--back LINEAR] [--json]

Each volume edge (on no boundary facet and no listed boundary cell) is measured straight and curved
by 12 Gauss points; reduction = straight / curved - 1, curvature = |P^l - middle| / |chord|.
"""
import argparse
import json
import sys

import numpy as np

import gmf
import log_metrics
from back_mesh import BackMesh
from conformity import corner_rows, domain_facets, rows_as_keys

GAUSS_POINTS = 12
BATCH = 8192
LONGER = 1e-9


def volume_edges(mesh):
    """(end, end, mid, one element of it) of the edges of the elements that are not on the boundary."""
    k = mesh.dim
    rows = mesh.cells["TetrahedraP2" if k == 3 else "TrianglesP2"].nodes
    local = np.array(gmf.LOCAL_EDGES[k])
    triples = rows[:, local].reshape(-1, 3)
    triples[:, :2].sort(axis=1)
    first = np.unique(triples[:, :2], axis=0, return_index=True)[1]
    owners = np.repeat(np.arange(len(rows)), len(local))[first]
    triples = triples[first]
    facets, count, _ = domain_facets(mesh)
    facets = np.concatenate([facets[count == 1], np.sort(corner_rows(mesh, k - 1)[0], axis=1)])
    sides = [(0, 1), (1, 2), (0, 2)] if k == 3 else [(0, 1)]
    border = np.concatenate([facets[:, side] for side in sides])
    keys = rows_as_keys(np.concatenate([triples[:, :2], border]))
    inner = ~np.isin(keys[:len(triples)], keys[len(triples):])
    return triples[inner], owners[inner]


def lengths(back, start, ends, middle):
    """Riemannian length of parabolas: ends (n, 2, d), Lagrange middle (n, d).  l(t) and l'(t) are
    those of the P2 Lagrange functions on [0, 1].  Returns (lengths, points outside)."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    total, outside = np.zeros(len(ends)), 0
    for t, w in zip((nodes + 1) / 2, weights / 2):
        x = (1 - t) * (1 - 2 * t) * ends[:, 0] + 4 * t * (1 - t) * middle + t * (2 * t - 1) * ends[:, 1]
        v = (4 * t - 3) * ends[:, 0] + 4 * (1 - 2 * t) * middle + (4 * t - 1) * ends[:, 1]
        logs, lost = back.log_metric(x, start)
        total += w * log_metrics.speeds(logs, v)
        outside += lost
    return total, outside


def measure(mesh, back, same_elements):
    """Straight and curved lengths and curvatures of all volume edges."""
    triples, owners = volume_edges(mesh)
    ends = mesh.points[triples[:, :2]]
    middle = mesh.points[triples[:, 2]]
    straight, curved, outside = np.empty(len(ends)), np.empty(len(ends)), 0
    for at in range(0, len(ends), BATCH):
        part = slice(at, at + BATCH)
        centre = ends[part].mean(axis=1)
        start = owners[part] if same_elements else back.nearest_start(centre)
        straight[part], _ = lengths(back, start, ends[part], centre)
        curved[part], lost = lengths(back, start, ends[part], middle[part])
        outside += lost
    chord = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    curvature = np.linalg.norm(middle - ends.mean(axis=1), axis=1) / chord
    return triples, straight, curved, curvature, outside


def statistics(triples, straight, curved, curvature, outside):
    """Statistics of the length reductions."""
    if not len(triples):
        return {"volume_edges": 0}
    reduction = straight / curved - 1
    best = int(reduction.argmax())
    return {"volume_edges": len(triples), "mean_length_reduction": float(reduction.mean()),
            "largest_length_reduction": float(reduction.max()), "smallest_length_reduction": float(reduction.min()),
            "largest_gain_edge": [int(v) + 1 for v in triples[best, :2]],
            "edges_longer_than_straight": int((curved > straight * (1 + LONGER)).sum()),
            "mean_curvature": float(curvature.mean()), "largest_curvature": float(curvature.max()),
            "points_outside_back_mesh": outside}


def evaluate(linear, mesh, metric="natural", back=None):
    """Statistics of a P2 mesh; the metric is given at the vertices of the back mesh."""
    support = back if back is not None else linear
    floored = 0
    if metric == "natural":
        logs = log_metrics.natural(support)
    else:
        logs, floored = log_metrics.from_field(gmf.read(metric), support.dim)
        if len(logs) != len(support.points):
            raise ValueError(f"{len(logs)} metrics for {len(support.points)} vertices")
    name = "TetrahedraP2" if mesh.dim == 3 else "TrianglesP2"
    if name not in mesh.cells:
        raise ValueError(f"no {name} in the P2 file")
    own = corner_rows(support, support.dim)[0]
    same = np.array_equal(own, mesh.cells[name].nodes[:, :mesh.dim + 1])
    figures = statistics(*measure(mesh, BackMesh(support, logs), same))
    figures["floored_metrics"] = floored
    return figures


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Length reduction of a P2 mesh on the true field.")
    parser.add_argument("linear")
    parser.add_argument("p2")
    parser.add_argument("--metric", default="natural", metavar="natural|FILE.solb")
    parser.add_argument("--back", metavar="LINEAR", help="back mesh; default: the linear mesh")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    try:
        figures = evaluate(gmf.read(options.linear), gmf.read(options.p2), options.metric,
                           gmf.read(options.back) if options.back else None)
    except (OSError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if options.json:
        print(json.dumps(figures))
    else:
        for key, value in figures.items():
            print(f"{key}: {value}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
