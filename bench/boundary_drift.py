#!/usr/bin/env python3
"""Drift of the boundary when a curved mesh is remeshed many times, each time from the previous mesh.

    boundary_drift.py [MESH] [--camber build/bin/camber] [--runs 20] [--dimension 3] [--radii 1=5,2=1] [--size 0.3] [--geometry JSON…]

MESH (default: a shell, in 2D an annulus, of `camber generate`) is curved once by `camber curve` with its surrogate. It is then remeshed
to sizes of SIZE times the distance from the centre, alternately multiplied by 0.7 and 1. A boundary reference lies on the sphere around
the origin with its radius (--radii REFERENCE=RADIUS,…). Each --geometry, as in `camber remesh`, gives one column: "surrogate",
"analytic" (these spheres) or "first" (the first curved mesh as {"mesh": …}). Printed for each mesh: the root mean square and the largest
distance of its boundary from the spheres (at 45 points of each curved triangle, 9 points of each curved edge in 2D), the root mean squares for
vertices and for nodes, and the volume (2D: the area) compared with the exact one.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent


def run(program, *words):
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise SystemExit(done.stderr)


def boundary_of(program, mesh, folder, dimension):
    """Returns nodes of the boundary simplices of degree 2, (n, 6 or 3, dimension), and their references."""
    text = folder / 'text.mesh'
    run(program, 'convert', mesh, '-o', text)
    lines = text.read_text().split('\n')

    def table(word):
        at = lines.index(word)
        count = int(lines[at + 1])
        return numpy.array([line.split() for line in lines[at + 2:at + 2 + count]], float)

    points = table('Vertices')[:, :dimension]
    facets = table('TrianglesP2' if dimension == 3 else 'EdgesP2').astype(int)
    return points[facets[:, :-1] - 1], facets[:, -1]


def triangle_rule(cells):
    """Returns quadratic shape functions and their derivatives at the lattice points."""
    places = numpy.array([(i / cells, j / cells) for i in range(cells + 1) for j in range(cells + 1 - i)])
    return shapes_of(places[:, 0], places[:, 1])


def shapes_of(x, y):
    xi, dx, dy = (1 - x - y, x, y), (-1, 1, 0), (-1, 0, 1)
    pairs = ((0, 1), (1, 2), (0, 2))
    values = [c * (2 * c - 1) for c in xi] + [4 * xi[i] * xi[j] for i, j in pairs]
    by = [[d[i] * (4 * xi[i] - 1) for i in range(3)] + [4 * (d[i] * xi[j] + xi[i] * d[j]) for i, j in pairs] for d in (dx, dy)]
    return numpy.array(values), numpy.array(by[0]), numpy.array(by[1])


def volume_within(nodes, dimension):
    """Returns ∫ x·n / dimension over facets of a sphere around the origin, by a rule that is exact for degree 2."""
    if dimension == 2:
        t, w = numpy.polynomial.legendre.leggauss(4)
        t, w = (t + 1) / 2, w / 2
        values = numpy.array([(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)])
        by = numpy.array([4 * t - 3, 4 * t - 1, 4 - 8 * t])
        p, d = numpy.einsum('fkc,kq->fqc', nodes, values), numpy.einsum('fkc,kq->fqc', nodes, by)
        return abs_by_facet(0.5 * numpy.einsum('fq,q->f', p[..., 0] * d[..., 1] - p[..., 1] * d[..., 0], w))
    g, w = numpy.polynomial.legendre.leggauss(5)
    g, w = (g + 1) / 2, w / 2
    u, v = numpy.meshgrid(g, g, indexing='ij')
    weights = (numpy.outer(w, w) * (1 - u)).ravel()
    values, dx, dy = shapes_of(u.ravel(), (v * (1 - u)).ravel())
    p, a, b = (numpy.einsum('fkc,kq->fqc', nodes, m) for m in (values, dx, dy))
    return abs_by_facet(numpy.einsum('fq,q->f', numpy.einsum('fqc,fqc->fq', p, numpy.cross(a, b)), weights) / 3)


def abs_by_facet(parts):
    """Makes the sign independent of the orientation: the origin is on one side of all facets of a sphere."""
    return numpy.abs(parts).sum()


def judge(nodes, references, radii, dimension):
    if dimension == 3:
        shapes = triangle_rule(8)[0]
    else:
        t = numpy.linspace(0, 1, 9)
        shapes = numpy.array([(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)])
    off, at_vertices, at_nodes, volumes = [], [], [], []
    for reference, radius in radii.items():
        of = nodes[references == reference]
        def error(points):
            return (numpy.linalg.norm(points, axis=-1) - radius).ravel()
        off.append(error(numpy.einsum('fkc,kp->fpc', of, shapes)))
        at_vertices.append(error(of[:, :dimension]))
        at_nodes.append(error(of[:, dimension:]))
        volumes.append((radius, volume_within(of, dimension)))
    volumes.sort()
    exact = [math.pi * r ** 2 if dimension == 2 else 4 / 3 * math.pi * r ** 3 for r, _ in volumes]
    rms = lambda parts: math.sqrt(numpy.mean(numpy.concatenate(parts) ** 2))
    return {'rms': rms(off), 'largest': float(numpy.abs(numpy.concatenate(off)).max()), 'vertices': rms(at_vertices), 'nodes': rms(at_nodes),
            'volume': volumes[-1][1] - sum(v for _, v in volumes[:-1]), 'exact': exact[-1] - sum(exact[:-1])}


def sized(size, dimension):
    h = f'1/({size}*{size}*(x^2+y^2{"+z^2" if dimension == 3 else ""}))'
    return {'expression': {'tensor': [h, '0', h] if dimension == 2 else [h, '0', h, '0', '0', h]}}


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument('mesh', nargs='?')
    arguments.add_argument('--camber', default=ROOT / 'build/bin/camber')
    arguments.add_argument('--runs', type=int, default=20)
    arguments.add_argument('--dimension', type=int, default=3, choices=(2, 3))
    arguments.add_argument('--radii', default='1=2,2=1')
    arguments.add_argument('--size', type=float, default=0.3)
    arguments.add_argument('--geometry', nargs='+', default=['surrogate', 'first', 'analytic'])
    options = arguments.parse_args()
    radii = {int(reference): float(radius) for reference, radius in (part.split('=') for part in options.radii.split(','))}
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        mesh = options.mesh
        if not mesh:
            mesh = folder / 'straight.mesh'
            shape = {'outer_radius': max(radii.values()), 'inner_radius': min(radii.values()), 'inner_size': options.size, 'outer_size': 2 * options.size}
            run(options.camber, 'generate', json.dumps({'shell' if options.dimension == 3 else 'annulus': shape}), '-o', mesh)
        first = folder / 'first.meshb'
        run(options.camber, 'curve', mesh, '-o', first)
        spheres = {'analytic': [{'references': [r], 'sphere': {'radius': radius}} for r, radius in radii.items()]}
        named = {'analytic': spheres, 'first': {'mesh': str(first)}}
        print('| geometry | run | facets | rms | largest | vertices | nodes | volume − exact |\n|---|---|---|---|---|---|---|---|')
        for geometry in options.geometry:
            words = json.dumps(named[geometry]) if geometry in named else geometry
            before = first
            for k in range(options.runs + 1):
                if k > 0:
                    after = folder / f'run-{k % 2}.meshb'
                    size = options.size * (0.7 if k % 2 == 1 else 1)
                    run(options.camber, 'remesh', before, '-o', after, '--metric', json.dumps(sized(size, options.dimension)), '--geometry', words)
                    before = after
                nodes, references = boundary_of(options.camber, before, folder, options.dimension)
                j = judge(nodes, references, radii, options.dimension)
                print(f"| {geometry} | {k} | {len(nodes)} | {j['rms']:.2e} | {j['largest']:.2e} | {j['vertices']:.2e} | {j['nodes']:.2e} | "
                      f"{j['volume'] - j['exact']:+.3e} |", flush=True)


if __name__ == '__main__':
    sys.exit(main())
