#!/usr/bin/env python3
"""Compares the output of two builds of the program byte by byte, for changes that must not change any output.

    same_bytes.py BEFORE AFTER [MESH…] [--keep FOLDER] [--only TEXT] [--threads N]

runs the programs BEFORE and AFTER on each config of configs/, and on each MESH with the commands of `camber repair`,
`camber curve` and `camber run` below. Compares exit codes and written meshes. For a mesh that differs it
prints figures of the reports (gain, minimum scaled Jacobian, invalid elements, surface edges). Exit code 1
if anything differs. With --keep, the output of BEFORE is stored in FOLDER and reused.
"""
import argparse
import filecmp
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
RELAX = 'stages/relax/method={}'
REINSERT = 'stages=["elevate", "reinsert"]'


def runs_of(meshes):
    """Yields (name, arguments) without the output."""
    for config in sorted((ROOT / 'configs').glob('*.json')):
        if config.stem != 'schema':
            yield config.stem, ['run', str(config)]
    for mesh in meshes:
        straight, name = str(mesh), mesh.stem
        metric = next((str(m) for m in (mesh.with_suffix('.solb'), mesh.with_suffix('.sol')) if m.exists()), None)
        field = ['--metric', metric] if metric else []
        yield f'{name}.curve', ['curve', straight, *field]
        yield f'{name}.shape', ['curve', straight, '--set', 'stages/curve/objective=shape']
        for way in ('edge', 'segment', 'backtracking'):
            yield f'{name}.{way}', ['curve', straight, *field, '--set', RELAX.format(way)]
        yield f'{name}.bound', ['curve', straight, *field, '--min-scaled-jacobian', '0.2']
        yield f'{name}.reinsert', ['curve', straight, *field, '--set', REINSERT]
        yield f'{name}.unrepaired', ['curve', straight, *field, '--set', 'stages=["elevate", "curve", "commit"]']
        yield f'{name}.remesh', ['remesh', straight, *field]
        yield f'{name}.remesh-curved', ['remesh', f'@{name}.curve', '--metric', '{"constant": {"sizes": [0.4]}}' if not metric else 'natural']
        yield f'{name}.repair', ['repair', f'@{name}.unrepaired']
        yield f'{name}.repair-tolerance', ['repair', f'@{name}.unrepaired', '--boundary-tolerance', '0.1']


def run(program, folder, name, arguments, threads):
    mesh, report = folder / f'{name}.meshb', folder / f'{name}.json'
    arguments = [str(folder / f'{a[1:]}.meshb') if a.startswith('@') else a for a in arguments]
    command = [program, *arguments]
    if arguments[0] == 'run':
        command += [f'--set=output/mesh={mesh}', '--set=output/vtu=', '--set=output/plots=', f'--set=output/report={report}']
    else:
        command += ['-o', str(mesh), '--report', str(report)]
    done = subprocess.run([*command, '--threads', str(threads)], capture_output=True, text=True)
    (folder / f'{name}.code').write_text(f'{done.returncode}\n')
    return done


def figures(folder, name):
    try:
        report = json.loads((folder / f'{name}.json').read_text())
    except (OSError, ValueError):
        return 'no report'
    curve = report.get('curve') or {}
    validity = report.get('validity') or {}
    relax = report.get('relax') or {}
    gain = (curve.get('after_correction') or curve.get('before_correction') or {}).get('mean_length_reduction')
    smallest = next((validity[k] for k in validity if 'scaled_jacobian' in k and 'bound' not in k), None)
    return (f"gain {gain}, smallest {smallest}, invalid {validity.get('invalid')}, undecided {validity.get('undecided')}, "
            f"surface edges {relax.get('relaxed_surface_edges')}, work {relax.get('work')}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('before')
    parser.add_argument('after')
    parser.add_argument('meshes', nargs='*', type=pathlib.Path)
    parser.add_argument('--keep', type=pathlib.Path)
    parser.add_argument('--only', default='')
    parser.add_argument('--threads', type=int, default=2)
    options = parser.parse_args()
    scratch = pathlib.Path(tempfile.mkdtemp(prefix='same_bytes.'))
    before, after = options.keep or scratch / 'before', scratch / 'after'
    for folder in (before, after):
        folder.mkdir(parents=True, exist_ok=True)
    different = compared = 0
    for name, arguments in runs_of(options.meshes):
        if options.only not in name and '.unrepaired' not in name:
            continue
        if not (before / f'{name}.code').exists():
            run(options.before, before, name, arguments, options.threads)
        done = run(options.after, after, name, arguments, options.threads)
        compared += 1
        codes = [(folder / f'{name}.code').read_text().strip() for folder in (before, after)]
        files = [folder / f'{name}.meshb' for folder in (before, after)]
        if codes[0] == codes[1] and files[0].exists() == files[1].exists() and (
                not files[0].exists() or filecmp.cmp(*files, shallow=False)):
            continue
        different += 1
        print(f'{name}: differs, exit codes {codes[0]} and {codes[1]}')
        for label, folder in (('before', before), ('after', after)):
            print(f'    {label}: {figures(folder, name)}')
        if codes[1] not in '01':
            print('    ' + done.stderr.strip().replace('\n', '\n    '))
    print(f'{compared} runs compared, {different} differ')
    shutil.rmtree(scratch)
    return 1 if different else 0


if __name__ == '__main__':
    sys.exit(main())
