#!/usr/bin/env python3
"""Quality of a curved mesh that is remeshed to its natural metric, by number of rounds of all passes.

    rounds.py MESH… [--camber build/bin/camber] [--rounds 0,1,5,20] [--spheres 1,5]

Each straight MESH is curved (`camber curve`) and then remeshed to its natural metric with each number of rounds. `camber check --metric` evaluates
the results: elements not certified valid, crossing walls, the minimum scaled Jacobian, unit edges and qualities along curves, and the gain, the
mean reduction of the length of curved edges relative to their chords in the metric. With --spheres also the surface error: the largest distance
of curved boundary triangles on the spheres (by reference) from the nearest sphere around the origin with these radii, at 45 points
of each triangle. The last lines have the same start remeshed by passes of degree 1 and curved at the end, and the last mesh curved once more in its
metric ("again").
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent


class Program:
    def __init__(self, path, folder):
        self.path, self.folder = path, folder

    def __call__(self, *words):
        done = subprocess.run([self.path, *map(str, words)], capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1):
            raise SystemExit(done.stderr)
        return done.stdout

    def pipeline(self, mesh, metric, stages, out, sizes):
        config = self.folder / 'config.json'
        config.write_text(json.dumps({'input': {'mesh': str(mesh)}, 'metric': metric, 'stages': stages,
                                      'output': {'mesh': str(out), 'metric': str(sizes)}}))
        self('run', config)


def p2_triangles(program, mesh):
    """Returns nodes of boundary triangles, (n, 6, 3)."""
    text = program.folder / 'mesh.mesh'
    program('convert', mesh, '-o', text)
    lines = text.read_text().split('\n')

    def table(word):
        at = lines.index(word)
        count = int(lines[at + 1])
        return numpy.array([line.split() for line in lines[at + 2:at + 2 + count]], float)

    points, triangles = table('Vertices')[:, :3], table('TrianglesP2')[:, :6].astype(int) - 1
    return points[triangles]


def surface_error(nodes, radii):
    """Returns the largest distance from the nearest sphere. Triangles without vertices on a sphere are omitted."""
    places = [(i / 8, j / 8) for i in range(9) for j in range(9 - i)]
    x, y = numpy.array(places).T
    xi = numpy.array([1 - x - y, x, y])
    shapes = [c * (2 * c - 1) for c in xi] + [4 * xi[i] * xi[j] for i, j in ((0, 1), (1, 2), (0, 2))]
    near = numpy.abs(numpy.linalg.norm(nodes[:, :3], axis=2)[:, :, None] - numpy.array(radii)).max(axis=1)
    nodes = nodes[near.min(axis=1) < 1e-2 * min(radii)]
    r = numpy.linalg.norm(numpy.einsum('tnc,np->tpc', nodes, numpy.array(shapes)), axis=2)
    return numpy.abs(r[:, :, None] - numpy.array(radii)).min(axis=2).max()


def row(program, name, mesh, sizes, radii):
    checked = json.loads(program('check', mesh, '--json', '--metric', sizes))
    curved, straight = checked['curved_unit_mesh'], checked['unit_mesh']
    bad = checked['invalid'] + checked['undecided']
    error = f"{surface_error(p2_triangles(program, mesh), radii):.2e}" if radii else ''
    print(f"| {name} | {checked['elements']} | {bad}, {checked['crossings']['crossing']} | "
          f"{100 * curved['unit_edges'] / curved['edges']:.1f} % | {curved['min_quality']:.3f}, {curved['mean_quality']:.4f} | "
          f"{checked['min_scaled_jacobian']:.2f} | {curved['mean_length']:.4f} | {straight['mean_length'] - curved['mean_length']:.4f} | {error} |",
          flush=True)


def show(program, mesh, counts, radii):
    folder = program.folder
    print(f'\n{mesh.name}\n\n| rounds | tetrahedra | not valid, crossing | unit edges | smallest, mean quality | smallest scaled Jacobian | '
          'mean length | gain | surface error |\n|---|---|---|---|---|---|---|---|---|')
    start, out, sizes = folder / 'start.meshb', folder / 'out.meshb', folder / 'out.solb'
    program('curve', mesh, '-o', start)
    for count in counts:
        program.pipeline(start, 'natural', [{'remesh': {'rounds': count, 'min_change': 0}}], out, sizes)
        row(program, count, out, sizes, radii)
    again = folder / 'again.meshb'
    program.pipeline(out, {'file': str(sizes)}, ['curve', 'validate', 'relax', 'commit'], again, folder / 'again.solb')
    row(program, 'again', again, sizes, radii)
    program.pipeline(mesh, 'natural',
                     [{'remesh': {'rounds': 5, 'min_change': 0}}, 'elevate', 'curve', 'validate', 'relax', 'commit'], out, sizes)
    row(program, 'degree 1, then curved', out, sizes, radii)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('meshes', nargs='+', type=pathlib.Path)
    parser.add_argument('--camber', default=str(ROOT / 'build/bin/camber'))
    parser.add_argument('--rounds', default='0,1,5,20')
    parser.add_argument('--spheres', default='')
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        program = Program(a.camber, pathlib.Path(folder))
        for mesh in a.meshes:
            show(program, mesh.resolve(), [int(n) for n in a.rounds.split(',')], [float(r) for r in a.spheres.split(',') if r])


if __name__ == '__main__':
    main()
