#!/usr/bin/env python3
"""Compares meshes adapted to a sampled solution by `camber metric` and `camber remesh` with uniform meshes and with meshes by exact derivatives. Also
measures times.

    solution_metrics.py build/bin/camber [--only errors|times] [--keep FOLDER] [--fields front,noise] [--dimensions 2]
                        [--degrees 1,2,2s] [--gradation 1.5] [--turns 3]

Errors: six fields on the unit square and the unit cube, elements of degree k = 1, 2 (straight at first, curved by the remesher) and 2s (always
straight: remeshed in degree 1). A turn samples the field at the vertices (k = 2: at all nodes), runs `metric --complexity` and `remesh`. For
the last mesh: unit edges in its metric, from the report of the remesher; the error of the nodal interpolant of degree k in L2 and the seminorm
of H1, by collapsed Gauss points. The same for

  exact     the same turns, after the first with the metric of exact derivatives: k = 1, det(|H|)^(-1/(4 + D)) |H| with the diameter of the domain
            as the maximum size, at the vertices of each mesh, scaled to the same complexity; k = 2, `metric` of the field at the nodes of a mesh
            adapted to 4 (3D: 3) times the complexity, from which the remesher interpolates it ("metric_mesh")
  chords    the last mesh with edge nodes at the midpoints of their chords (k = 2)
  uniform   a lattice with about the same number of elements, cut into simplices

The sampled values of `noise` have uniform noise of 1 %; its errors are those of the field without noise.

Times: wall-clock and CPU seconds of whole commands, the minimum of 3 runs (--repeat), with 1 and 2 threads alternately; then the steps that the
program shows while it runs.
"""
import argparse
import json
import os
import pathlib
import pty
import re
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / 'tests' / 'oracle'))
import gmf  # noqa: E402
from program import Program  # noqa: E402

COMPLEXITY = {(2, 1): 1000, (2, 2): 1000, (3, 1): 1000, (3, 2): 300}
PER_COMPLEXITY = {2: 4 / 3 ** 0.5, 3: 6 * 2 ** 0.5}  # elements
NAMES = {2: 'Triangles', 3: 'Tetrahedra'}
TAU = 2 * np.pi


def swirl(x):
    """Returns a component of the velocity of a Lamb-Oseen vortex, core 0.1; in 3D its axis is oblique."""
    p, q = x[..., 0] - 0.5, x[..., 1] - 0.5
    if x.shape[-1] == 3:
        p, q = p - 0.3 * (x[..., 2] - 0.5), q + 0.2 * (x[..., 2] - 0.5)
    s = p * p + q * q + 1e-30
    return q * np.expm1(-s / 0.01) / s * 0.1


FIELDS = {
    'layer': lambda x: np.exp(-x[..., -1] / 0.02) * (1 + 0.3 * np.sin(np.pi * x[..., 0])),
    'front': lambda x: np.tanh((np.sqrt((x * x).sum(-1)) - 0.5) / 0.05),
    'vortex': swirl,
    'crossing': lambda x: np.tanh((x[..., 0] + 0.5 * x[..., -1] - 0.75) / 0.05) + np.tanh((x[..., 1] - 0.5 * x[..., 0] - 0.25) / 0.05),
    'smooth': lambda x: np.sin(TAU * x).prod(-1),
    'noise': lambda x: np.sin(TAU * x).prod(-1),
}


def sampled(name, x):
    values = FIELDS[name](x)
    if name == 'noise':
        hashed = np.modf(np.abs(np.sin(x @ np.array([12.9898, 78.233, 37.719])[:x.shape[1]]) * 43758.5453))[0]
        values = values + 0.01 * (2 * hashed - 1)
    return values


def write_rows(path, dim, rows):
    """Writes scalars, or the lower halves of tensors."""
    rows = np.asarray(rows).reshape(len(rows), -1)
    with open(path, 'w', encoding='ascii') as file:
        file.write(f'MeshVersionFormatted 2\nDimension {dim}\nSolAtVertices\n{len(rows)}\n1 {1 if rows.shape[1] == 1 else 3}\n')
        np.savetxt(file, rows, '%.17g')
        file.write('End\n')


def read_mesh(path):
    """Returns points and nodes of elements in Vizir's order."""
    mesh = gmf.read(path)
    name = NAMES[mesh.dim]
    cells = mesh.cells.get(f'{name}P2')
    return mesh.points, (cells if cells is not None and len(cells.nodes) else mesh.cells[name]).nodes


def lower(dim):
    return np.array([(i, j) for i in range(dim) for j in range(i + 1)]).T


def measure(points, rows):
    """Returns the measure of straight elements."""
    x = points[rows[:, :points.shape[1] + 1]]
    return np.abs(np.linalg.det(x[:, 1:] - x[:, :1])) / (2 if points.shape[1] == 2 else 6)


def quadrature(dim, count):
    """Returns barycentric coordinates and weights, which sum to 1."""
    t, w = np.polynomial.legendre.leggauss(count)
    t, w = (t + 1) / 2, w / 2
    grid = np.stack(np.meshgrid(*[t] * dim, indexing='ij'), -1).reshape(-1, dim)
    weights = np.stack(np.meshgrid(*[w] * dim, indexing='ij'), -1).reshape(-1, dim).prod(1)
    out, rest = [], np.ones(len(grid))
    for i in range(dim):
        out.append(rest * grid[:, i])
        weights = weights * (1 - grid[:, i]) ** (dim - 1 - i)
        rest = rest * (1 - grid[:, i])
    return np.stack([rest, *out], 1), weights / weights.sum()


def shapes(b, degree):
    """Returns values of the functions of degree 1 or 2 and their derivatives along the edges from the first vertex."""
    dim = len(b) - 1
    values, slopes = b, np.eye(dim + 1)
    if degree == 2:
        exponents = gmf.CANONICAL[dim]
        values, slopes = np.zeros(len(exponents)), np.zeros((len(exponents), dim + 1))
        for n, e in enumerate(exponents):
            ends = [i for i in range(dim + 1) if e[i]]
            if len(ends) == 1:
                i, = ends
                values[n], slopes[n, i] = b[i] * (2 * b[i] - 1), 4 * b[i] - 1
            else:
                i, j = ends
                values[n], slopes[n, i], slopes[n, j] = 4 * b[i] * b[j], 4 * b[j], 4 * b[i]
    return values, slopes[:, 1:] - slopes[:, :1]


def gradient(f, x, step=1e-6):
    return np.stack([(f(x + d) - f(x - d)) / (2 * step) for d in step * np.eye(x.shape[-1])], -1)


def hessian(f, x, step=1e-4):
    dim = x.shape[-1]
    e = step * np.eye(dim)
    out = np.empty(x.shape + (dim,))
    for i in range(dim):
        for j in range(i + 1):
            out[..., i, j] = out[..., j, i] = (f(x + e[i] + e[j]) - f(x + e[i] - e[j]) - f(x - e[i] + e[j]) + f(x - e[i] - e[j])) / (4 * step ** 2)
    return out


def errors(f, points, rows):
    """Returns the L2 error and the H1 seminorm error of the interpolant of the degree of the elements."""
    dim = points.shape[1]
    degree = 1 if rows.shape[1] == dim + 1 else 2
    nodes, values = points[rows], f(points)[rows]
    total = np.zeros(2)
    for b, w in zip(*quadrature(dim, 8 if dim == 2 else 4)):
        phi, slopes = shapes(b, degree)
        jacobian = np.einsum('nkd,ke->nde', nodes, slopes)
        x = np.einsum('nkd,k->nd', nodes, phi)
        there = np.linalg.solve(jacobian.transpose(0, 2, 1), (values @ slopes)[..., None])[..., 0]
        weight = w * np.abs(np.linalg.det(jacobian)) / (2 if dim == 2 else 6)
        total += (weight * (f(x) - values @ phi) ** 2).sum(), (weight[:, None] * (gradient(f, x) - there) ** 2).sum()
    return total ** 0.5


def complexity(points, rows, tensors):
    """Returns the integral of sqrt(det M), whose log is linear between vertices."""
    dim = points.shape[1]
    full = np.zeros((len(tensors), dim, dim))
    i, j = lower(dim)
    full[:, i, j] = full[:, j, i] = tensors
    logs = np.linalg.slogdet(full)[1][rows[:, :dim + 1]] / 2
    b, w = quadrature(dim, 5)
    return (measure(points, rows) * (np.exp(logs @ b.T) @ w)).sum()


def exact_metric(f, points, rows, target, p=2):
    """Returns rows of the optimal metric of degree 1 from exact Hessians: Q'/eps, Q' = max(Q, eps/L^2), eps = s det(Q')^{1/(2p + D)}."""
    dim = points.shape[1]
    q, axes = np.linalg.eigh(hessian(f, points))
    q = np.maximum(np.abs(q), 1e-30)
    i, j = lower(dim)
    least = 1 / dim  # maximum size of the metric: the diameter is sqrt(dim)

    def rows_of(log_s):
        eps = np.full(len(q), q.max())
        for _ in range(100):
            eps = np.exp(log_s) * np.maximum(q, eps[:, None] * least).prod(1) ** (1 / (2 * p + dim))
        sizes = np.maximum(q / eps[:, None], least)
        return np.einsum('nik,nk,njk->nij', axes, sizes, axes)[:, i, j]
    low, high = -60.0, 60.0
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if complexity(points, rows, rows_of(middle)) > target else (low, middle)
    return rows_of((low + high) / 2)


LABELS = {'1': '1', '2': '2', '2s': '2, straight'}


class Problem:
    """A field, a dimension and a degree, with its files in a folder."""

    def __init__(self, camber, folder, name, dim, kind, gradation):
        self.camber, self.folder, self.name, self.dim, self.kind, self.degree = camber, folder, name, dim, kind, int(kind[0])
        degree = self.degree
        self.field, self.target = FIELDS[name], COMPLEXITY[dim, degree]
        self.more = ('--gradation', gradation) if gradation else ()

    def file(self, name):
        return self.folder / name

    def lattice(self, name, elements):
        cells = max(2, round((elements / (2 if self.dim == 2 else 6)) ** (1 / self.dim)))
        self.camber('generate', 'rectangle' if self.dim == 2 else 'box', '-o', self.file(name), '--set', f'cells={[cells] * self.dim}', '--set', 'jitter=0')
        self.elevate(name)

    def elevate(self, name):
        """Elevates to degree 2 if required. The mesh of degree 1 is preserved."""
        if self.degree == 2:
            os.replace(self.file(name), self.file(f'linear-{name}'))
            self.camber('convert', self.file(f'linear-{name}'), '--elevate', '-o', self.file(name))

    def metric(self, mesh, out, target, name):
        points, _ = read_mesh(self.file(mesh))
        write_rows(self.file('u.sol'), self.dim, sampled(name, points))
        return self.camber('metric', self.file(mesh), '--solution', self.file('u.sol'), '-o', self.file(out), '--complexity', target, '--threads', 1, *self.more)

    def remesh(self, mesh, metric, out, of=None):
        """Remeshes and returns the share of unit edges. The metric is at the nodes of the mesh `of`, by default this mesh."""
        more = [] if of is None and self.kind != '2s' else ['--set', f'metric_mesh={self.file(of or mesh)}']
        self.camber('remesh', self.file(f'linear-{mesh}' if self.kind == '2s' else mesh), '--metric', self.file(metric), '-o', self.file(out),
                    '--report', self.file('r.json'), '--threads', 1, *more)
        if self.kind == '2s':
            self.elevate(out)
        after = json.loads(self.file('r.json').read_text())['remesh']['after']
        return 100 * after['unit_edges'] / after['edges']

    def exact(self, mesh, out):
        """Runs one turn with the metric of exact derivatives."""
        if self.degree == 1:
            points, rows = read_mesh(self.file(mesh))
            write_rows(self.file('e.sol'), self.dim, exact_metric(self.field, points, rows, self.target))
            return self.remesh(mesh, 'e.sol', out)
        clean = 'smooth' if self.name == 'noise' else self.name
        if not self.file('fine.meshb').exists():
            self.metric(mesh, 'f.sol', (4 if self.dim == 2 else 3) * self.target, clean)
            self.remesh(mesh, 'f.sol', 'fine.meshb')
            self.metric('fine.meshb', 'e.sol', self.target, clean)
        return self.remesh(mesh, 'e.sol', out, 'fine.meshb')

    def move(self, old, new):
        os.replace(self.file(old), self.file(new))
        if self.kind == '2s':
            os.replace(self.file(f'linear-{old}'), self.file(f'linear-{new}'))

    def measured(self, mesh, is_straight=False):
        points, rows = read_mesh(self.file(mesh))
        if is_straight and self.degree == 2:
            for a, b, middle in gmf.LOCAL_EDGES[self.dim]:
                points[rows[:, middle]] = (points[rows[:, a]] + points[rows[:, b]]) / 2
        return (len(rows), *errors(self.field, points, rows))

    def row(self, turns):
        self.lattice('0.meshb', self.target * PER_COMPLEXITY[self.dim])
        for turn in range(turns):
            self.metric(f'{turn}.meshb', 'm.sol', self.target, self.name)
            unit = self.remesh(f'{turn}.meshb', 'm.sol', f'{turn + 1}.meshb')
        ours, chords = self.measured(f'{turns}.meshb'), self.measured(f'{turns}.meshb', True)
        self.move('1.meshb' if turns > 1 else '0.meshb', 'x.meshb')
        for _ in range(max(1, turns - 1)):
            self.exact('x.meshb', 'y.meshb')
            self.move('y.meshb', 'x.meshb')
        exact = self.measured('x.meshb')
        self.lattice('z.meshb', ours[0])
        uniform = self.measured('z.meshb')
        cells = [self.name, LABELS[self.kind], f'{unit:.1f}', ours[0]]
        for n in (1, 2):
            cells += [f'{ours[n]:.2e}', f'{chords[n]:.2e}' if self.kind == '2' else '', f'{exact[n]:.2e}', f'{uniform[n]:.2e}']
        return '| ' + ' | '.join(map(str, cells)) + ' |'


def tables_of_errors(camber, base, options):
    """Prints one table per dimension."""
    titles = 'field | k | unit edges (%) | elements | L2 | chords | exact metric | uniform | H1 | chords | exact metric | uniform'
    for dim in options.dimensions:
        print(f'\n{dim}D:\n\n| {titles} |\n|' + '---|' * 12, flush=True)
        for name in options.fields:
            for kind in options.degrees:
                folder = base / f'{name}-{dim}-{kind}'
                folder.mkdir(parents=True, exist_ok=True)
                (folder / 'fine.meshb').unlink(missing_ok=True)
                print(Problem(camber, folder, name, dim, kind, options.gradation).row(options.turns or 5 - dim), flush=True)


def steps(path, words):
    """Returns the seconds from the first display of a step to that of the next one on a terminal. The first step counts from the start.
    Steps that are too short to be shown count to the previous step."""
    main, other = pty.openpty()
    begin = time.perf_counter()
    running = subprocess.Popen([path, *map(str, words)], stdout=subprocess.DEVNULL, stderr=other)
    os.close(other)
    shown = []
    try:
        while data := os.read(main, 65536):
            now = time.perf_counter()
            for line in re.split(r'[\r\n]', re.sub(r'\x1b\[[0-9;?]*[A-Za-z]', '', data.decode(errors='replace'))):
                name = re.match(r'\s*([a-z][a-z ]*?)\s*\[', line)
                if name and (not shown or shown[-1][0] != name[1]):
                    shown.append((name[1], now if shown else begin))
    except OSError:  # the other end is closed
        pass
    running.wait()
    end = time.perf_counter()
    os.close(main)
    return [(name, later - begin) for (name, begin), (_, later) in zip(shown, shown[1:] + [('', end)])]


def timed(path, words):
    """Returns wall-clock seconds, CPU seconds and GB."""
    done = subprocess.run(['/usr/bin/time', '-f', '%e %U %S %M', path, *map(str, words)], capture_output=True, text=True, check=True)
    clock, user, system, size = map(float, done.stderr.split()[-4:])
    return clock, user + system, size / 1e6


def table_of_times(camber, base, options):
    field, cases = FIELDS['front'], [('1M', 55, 1), ('200k', 32, 2)] + ([('1M', 55, 2)] if options.large else [])
    splits = []
    for size, cells, degree in cases:
        mesh, new, u = (base / f't-{size}-{degree}.{end}' for end in ('meshb', 'new.meshb', 'solb'))
        for path, seed in ((mesh, 1), (new, 2)):
            camber('generate', 'box', '-o', path, '--set', f'cells={[cells] * 3}', '--set', f'seed={seed}')
            if degree == 2:
                camber('convert', path, '--elevate', '-o', base / 'elevated.meshb')
                os.replace(base / 'elevated.meshb', path)
        points, elements = read_mesh(mesh)
        write_rows(base / 'u.sol', 3, field(points))
        camber('convert', base / 'u.sol', '-o', u)
        what = f'{len(elements)} tetrahedra of degree {degree}, {len(points)} rows'
        calls = [('metric', ['metric', mesh, '--solution', u, '-o', base / 'm.solb'])]
        calls += [(f'transfer, {method}', ['transfer', mesh, new, '--solution', u, '-o', base / 'v.solb', '--method', method])
                  for method in ('interpolate', 'conserve')]
        for title, words in calls:
            runs = [[timed(camber.path, [*words, '--threads', threads]) for threads in (1, 2)] for _ in range(options.repeat)]
            (one, two), processor = ([min(run[n][part] for run in runs) for n in range(2)] for part in range(2))
            print(f'| {what} | {title} | {one:.2f} | {two:.2f} | {one / two:.2f} | {processor[0]:.2f} | {processor[1]:.2f} | {runs[0][0][2]:.2f} |', flush=True)
            if title == 'metric':
                splits += [(what, threads, steps(camber.path, [*words, '--threads', threads])) for threads in (1, 2)]
    print('\n| mesh | threads | steps of metric, s |\n|---|---|---|')
    for what, threads, found in splits:
        print(f'| {what} | {threads} | {", ".join(f"{name} {seconds:.2f}" for name, seconds in found)} |')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('camber', type=pathlib.Path)
    parser.add_argument('--only', choices=('errors', 'times'))
    parser.add_argument('--keep', type=pathlib.Path, help='a folder for the meshes')
    parser.add_argument('--fields', type=lambda text: text.split(','), default=list(FIELDS))
    parser.add_argument('--dimensions', type=lambda text: [int(x) for x in text.split(',')], default=[2, 3])
    parser.add_argument('--degrees', type=lambda text: text.split(','), default=['1', '2', '2s'])
    parser.add_argument('--gradation', type=float, help='gradation of the metrics of sampled fields; default: none')
    parser.add_argument('--turns', type=int, help='number of turns; default: 3 in 2D, 2 in 3D')
    parser.add_argument('--repeat', type=int, default=3)
    parser.add_argument('--large', action='store_true', help='times of 1 million tetrahedra of degree 2, too')
    options = parser.parse_args()
    camber = Program(options.camber.resolve())
    with tempfile.TemporaryDirectory() as temporary:
        base = options.keep or pathlib.Path(temporary)
        base.mkdir(parents=True, exist_ok=True)
        if options.only != 'times':
            tables_of_errors(camber, base, options)
        if options.only != 'errors':
            print('\n| mesh | command | 1 thread, s | 2 threads, s | ratio | processor, s | with 2 | GB, 1 thread |\n|' + '---|' * 8)
            table_of_times(camber, base, options)


if __name__ == '__main__':
    main()
