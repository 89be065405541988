#!/usr/bin/env python3
"""Elongation of elements along a curved front: meshes of degree 2 remeshed to a layer around the origin.

    longer_elements.py [--camber build/bin/camber] [--keep FOLDER] [--bend-around N]

Layers: UGAWG's polar-1 (sizes h_t along circles, about h_r + 0.4 |r - 1/2| across them) on the unit square and the unit cube, in degree
2 from a curved mesh and from a straight one, six (3D: four) runs of `camber remesh`. Each run evaluates the field at the vertices of the
previous mesh. Printed: elements divided by complexity/(√3/4) (3D: √2/12), the number of regular unit elements; unit edges along the
curves in the exact field by 24 Gauss points; the results of tests/oracle/check_p2.py; and the number of accepted requests in all runs
out of those with a valid star.

Front: tanh((r - 1/2)/0.005) on the square, in a metric with h_t = 0.15 r and |u'''| across; the L2 error of the P2 interpolant, scaled
to 3 400 unknowns by N^{3/2}. The same for the mesh remeshed to this metric in degree 1.

--bend-around N: collapses may move the nodes of N edges around their cavity (collapse/neighbour_edges). Runs the layers only and also prints the
number of such collapses.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / 'tests' / 'oracle'))
import gmf  # noqa: E402
from program import Program  # noqa: E402

RADIUS, WIDTH = 0.5, 0.005


def simplices(path):
    """Returns nodes of the elements, (n, nodes, dimension), in Vizir's order. Straight elements have nodes at the midpoints of chords."""
    mesh = gmf.read(path)
    dim = mesh.dim
    name = {2: 'Triangles', 3: 'Tetrahedra'}[dim]
    if f'{name}P2' in mesh.cells and len(mesh.cells[f'{name}P2'].nodes):
        return mesh.cells[f'{name}P2'].nodes, mesh.points[mesh.cells[f'{name}P2'].nodes]
    rows = mesh.cells[name].nodes
    corners = mesh.points[rows]
    middles = [(corners[:, a] + corners[:, b]) / 2 for a, b, _ in gmf.LOCAL_EDGES[dim]]
    return rows, np.concatenate([corners, np.stack(middles, 1)], 1)


def unique_curves(rows, nodes):
    """Returns (edges, 3, dimension): both ends and the node of each edge."""
    dim = nodes.shape[2]
    ends = np.concatenate([rows[:, [a, b]] for a, b, _ in gmf.LOCAL_EDGES[dim]])
    curves = np.concatenate([nodes[:, [a, b, m]] for a, b, m in gmf.LOCAL_EDGES[dim]])
    _, first = np.unique(np.sort(ends, 1), axis=0, return_index=True)
    return curves[first]


def across(r, along, least):
    """Returns UGAWG's size across a circle of radius r."""
    return least + 2 * (along - least) * np.abs(r - RADIUS)


def lengths(curves, along, least):
    """Returns lengths in the exact field along the curves."""
    t, w = np.polynomial.legendre.leggauss(24)
    t, w = (t[:, None, None] + 1) / 2, w / 2
    a, b, m = curves[None, :, 0], curves[None, :, 1], curves[None, :, 2]
    x = (1 - t) * (1 - 2 * t) * a + t * (2 * t - 1) * b + 4 * t * (1 - t) * m
    v = (4 * t - 3) * a + (4 * t - 1) * b + 4 * (1 - 2 * t) * m
    r = np.maximum(np.hypot(x[..., 0], x[..., 1]), 1e-12)
    radial = (v[..., 0] * x[..., 0] + v[..., 1] * x[..., 1]) / r
    rest = np.maximum((v ** 2).sum(-1) - radial ** 2, 0)
    return (w[:, None] * np.sqrt(radial ** 2 / across(r, along, least) ** 2 + rest / along ** 2)).sum(0)


def ideal_elements(dim, along, least):
    q = (np.arange(1200) + 0.5) / 1200
    x, y = np.meshgrid(q, q)
    complexity = (1 / (across(np.hypot(x, y), along, least) * along ** (dim - 1))).mean()
    return complexity / (3 ** 0.5 / 4 if dim == 2 else 2 ** 0.5 / 12)


def begin(camber, folder, dim, along, least, curved):
    """Makes a mesh of degree 2 that is suitable for a layer with smaller sizes along it."""
    first = field(min(along, 0.05 if dim == 2 else 0.1), least)
    camber('generate', 'rectangle' if dim == 2 else 'box', '-o', folder / 'a.meshb', '--set', f'cells={[40] * 2 if dim == 2 else [14] * 3}')
    for _ in range(4):
        camber('remesh', folder / 'a.meshb', '--metric', first, '--geometry', 'straight', '-o', folder / 'a.meshb')
    stages = ['elevate', 'curve', 'validate', 'relax', 'commit'] if curved else ['elevate']
    config = {'input': {'mesh': str(folder / 'a.meshb')}, 'metric': json.loads(first), 'geometry': 'straight', 'stages': stages,
              'output': {'mesh': str(folder / 'b.meshb')}}
    (folder / 'c.json').write_text(json.dumps(config))
    camber('run', folder / 'c.json')


def field(along, least):
    return json.dumps({'field': {'polar-1': {'min_size': least, 'size': along, 'radius': RADIUS}}})


def layer(camber, folder, dim, along, least, curved, more=()):
    begin(camber, folder, dim, along, least, curved)
    counts, seconds, followed = {}, 0, 0
    for _ in range(6 if dim == 2 else 4):
        camber('remesh', folder / 'b.meshb', '--metric', field(along, least), '--geometry', 'straight', '-o', folder / 'b.meshb',
               '--report', folder / 'r.json', '--threads', 1, *more)
        for p in json.loads((folder / 'r.json').read_text())['remesh']['passes']:
            planned, accepted = counts.get(p['pass'], (0, 0))
            counts[p['pass']] = (planned + p['planned'] - p['rejected'].get('waits', 0), accepted + p['accepted'])
            seconds += p['seconds']
            followed += p['neighbour_moves']
    rows, nodes = simplices(folder / 'b.meshb')
    found = lengths(unique_curves(rows, nodes), along, least)
    valid = subprocess.run([sys.executable, ROOT / 'tests/oracle/check_p2.py', folder / 'b.meshb', '--json'], capture_output=True, text=True,
                           check=False)
    invalid = json.loads(valid.stdout)
    invalid = invalid.get('invalid', invalid.get('validity', {}).get('invalid'))
    ratio = len(rows) / ideal_elements(dim, along, least)
    unit = np.mean((found >= 0.5 ** 0.5) & (found <= 2 ** 0.5))
    shares = ', '.join(f'{name} {accepted}/{planned}' for name, (planned, accepted) in counts.items() if planned)
    print(f'| {dim}D | {along}, {least} | {along ** 2 / 8 / RADIUS / least:.1f} | {"curved" if curved else "straight"} | {len(rows)} | {ratio:.2f} '
          f'| {100 * unit:.1f} % | {found.min():.2f} to {found.max():.2f} | {invalid} | {shares}{f", {followed} bent around" if more else ""} | {seconds:.2f} |', flush=True)


def front_metric(points, complexity, areas):
    """Returns one tensor per point (lower half) with h_t = 0.15 r and |u'''| across, without its zeros, scaled to a complexity."""
    r = np.hypot(points[:, 0], points[:, 1])
    n = points / np.maximum(r, 1e-9)[:, None]
    envelope = 2 / np.cosh((r - RADIUS) / WIDTH) ** 2 / WIDTH ** 3
    along = 1 / np.minimum(0.15 * np.maximum(r, 0.25), 0.5) ** 2
    scale = 1.0
    for _ in range(60):
        radial = np.maximum(scale * envelope ** (4 / 7) + 4, along)
        scale *= complexity / (np.sqrt(radial * along) * areas).sum()
    return np.stack([along + (radial - along) * n[:, 0] ** 2, (radial - along) * n[:, 0] * n[:, 1],
                     along + (radial - along) * n[:, 1] ** 2], 1)


def front_error(nodes):
    """Returns the L2 error of the P2 interpolant of tanh((r - 1/2)/WIDTH), by 16 x 16 collapsed Gauss points."""
    t, w = np.polynomial.legendre.leggauss(16)
    t, w = (t + 1) / 2, w / 2
    total = 0.0
    u = lambda x: np.tanh((np.hypot(x[..., 0], x[..., 1]) - RADIUS) / WIDTH)
    values = u(nodes)
    for s, ws in zip(t, w):
        for q, wq in zip(t, w):
            b = np.array([1 - s - q * (1 - s), s, q * (1 - s)])
            exps = gmf.CANONICAL[2]
            phi = np.array([b[i] * (2 * b[i] - 1) for i in range(3)] +
                           [4 * np.prod([b[i] for i in range(3) if e[i]]) for e in exps[3:]])
            slopes = np.zeros((6, 3))
            for i in range(3):
                slopes[i, i] = 4 * b[i] - 1
            for k, e in enumerate(exps[3:]):
                i, j = [i for i in range(3) if e[i]]
                slopes[3 + k, i], slopes[3 + k, j] = 4 * b[j], 4 * b[i]
            slopes = slopes[:, 1:] - slopes[:, :1]
            j = np.einsum('nkd,ke->nde', nodes, slopes)
            x = np.einsum('nkd,k->nd', nodes, phi)
            total += (ws * wq * (1 - s) * np.abs(np.linalg.det(j)) * (u(x) - values @ phi) ** 2).sum()
    return total ** 0.5


def front(camber, folder, complexity, degree):
    mesh = folder / 'f.meshb'
    camber('generate', 'rectangle', '-o', mesh, '--set', 'cells=[80, 80]')
    for run in range(8):
        rows, nodes = simplices(mesh)
        corners = nodes[:, :3]
        count = rows[:, :3].max() + 1
        points, areas = np.zeros((count, 2)), np.zeros(count)
        area = np.abs(np.linalg.det(np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], -1))) / 2
        for k in range(3):
            points[rows[:, k]] = corners[:, k]
            np.add.at(areas, rows[:, k], area / 3)
        tensors = front_metric(points, complexity, areas)
        text = '\n'.join(' '.join(repr(float(x)) for x in row) for row in tensors)
        (folder / 'f.sol').write_text(f'MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n{count}\n1 3\n{text}\nEnd\n')
        stages = ['remesh', 'elevate', 'curve', 'validate', 'relax', 'commit'] if degree == 2 and run == 0 else ['remesh']
        config = {'input': {'mesh': str(mesh)}, 'metric': {'file': str(folder / 'f.sol')}, 'geometry': 'straight', 'stages': stages,
                  'output': {'mesh': str(mesh)}}
        (folder / 'c.json').write_text(json.dumps(config))
        camber('run', folder / 'c.json')
    rows, nodes = simplices(mesh)
    unknowns = rows[:, :3].max() + 1 + len(unique_curves(rows, nodes))
    error = front_error(nodes)
    print(f'| {degree} | {complexity} | {len(rows)} | {unknowns} | {error:.2e} | {error * (unknowns / 3400) ** 1.5:.2e} |', flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--camber', default=ROOT / 'build/bin/camber', type=pathlib.Path)
    parser.add_argument('--keep', type=pathlib.Path, help='a folder for the meshes')
    parser.add_argument('--bend-around', type=int, help='maximum number of edges around a cavity whose nodes may move')
    options = parser.parse_args()
    more = () if options.bend_around is None else ('--set', f'stages/remesh/collapse/neighbour_edges={options.bend_around}')
    camber = Program(options.camber.resolve())
    with tempfile.TemporaryDirectory() as temporary:
        base = options.keep or pathlib.Path(temporary)

        def place(name):
            (base / name).mkdir(parents=True, exist_ok=True)
            return base / name
        print('| | h_t, h_r | sagitta / h_r | start | elements | over complexity | unit edges | lengths | invalid | accepted, of stars | s |\n'
              '|---|---|---|---|---|---|---|---|---|---|---|')
        for dim, least in ((2, 0.002), (3, 0.004)):
            for along in (0.1, 0.2):
                for curved in (True, False):
                    layer(camber, place(f'{dim}d-{along}-{"curved" if curved else "straight"}'), dim, along, least, curved, more)
        layer(camber, place('2d-0.4-curved'), 2, 0.4, 0.002, True, more)
        if more:
            return
        print('\n| degree | complexity | elements | unknowns | L2 error | scaled to 3 400 |\n|---|---|---|---|---|---|')
        for degree, complexity in ((2, 650), (2, 800), (1, 650)):
            front(camber, place(f'front-{degree}-{complexity}'), complexity, degree)


if __name__ == '__main__':
    main()
