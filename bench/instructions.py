#!/usr/bin/env python3
"""Compares the numbers of instructions of fixed runs of the program with stored ones. Run it before changes that must not increase the cost.

    bench/instructions.py build/bin/camber [RUN…] [--write]

counts the instructions of ten runs with Valgrind, one thread each, and compares them with `bench/instructions.json`. Exit code 1 if a run
takes more than 1 % above its stored count, or has none. A commit that increases a count on purpose stores the new counts (`--write`) and gives the
reason in its message. A commit that decreases a count stores the new counts too, so that the gain is preserved.

Valgrind simulates the same processor for each program, with AVX2 and without AVX-512. Counts of two runs differ by less than 0.1 %. They depend on
the compiler, the C library and the build: the stored counts are for clang 19, Debian 12 and the preset `release`. On another system, count
the program before the change too (`--write`), and do not commit that file.

Needs Valgrind (`apt-get install valgrind`) and the library next to the program (`./x build`). Takes four minutes.
"""
import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
STORED = ROOT / 'bench' / 'instructions.json'
GROWTH = 0.01
FRONT = 'tanh((sqrt(x^2+y^2)-2)/0.1)'

# Name and arguments.
RUNS = {
    'generate': ['generate', 'shell', '--elements', '8000', '-o', 'shell.meshb'],
    'check': ['check', 'large.meshb'],
    'convert': ['convert', 'large.meshb', '-o', 'large.vtu'],
    'curve': ['curve', 'shell.meshb', '-o', 'curved.meshb'],
    'curve-shape': ['curve', 'shell.meshb', '--set', 'stages/curve/objective=shape', '-o', 'shape.meshb'],
    'curve-cad': ['curve', '--cad=shell.brep'],
    'remesh': ['remesh', 'coarse.meshb', '--metric', '0.6', '-o', 'straight.meshb'],
    'remesh-curved': ['remesh', 'coarse-curved.meshb', '--metric', '0.8', '-o', 'remeshed.meshb'],
    'adapt': ['adapt', 'ring.meshb', '--field', FRONT, '--complexity', '1000', '--cycles', '2', '-o', 'adapted.meshb'],
    'geometry': ['geometry', 'curved.meshb'],
}
# Inputs of the runs, which are not counted.
INPUTS = [
    RUNS['generate'],
    RUNS['curve'],
    ['generate', 'shell', '--structure', 'prisms', '--elements', '100000', '-o', 'large.meshb'],
    ['generate', 'annulus', '--elements', '2000', '-o', 'ring.meshb'],
    ['generate', 'shell', '--elements', '2000', '-o', 'coarse.meshb'],
    ['curve', 'coarse.meshb', '-o', 'coarse-curved.meshb'],
]
# Runs of the library: the program reads CAD models in a second process, which Valgrind cannot start.
BY_LIBRARY = {'curve-cad': 'shell.meshb'}
LIBRARY = '''
import ctypes, sys
camber, mesh, result = ctypes.CDLL(sys.argv[1]), ctypes.c_void_p(), ctypes.c_void_p()
words = [word.encode() for word in sys.argv[3:]]
status = camber.camber_read(sys.argv[2].encode(), ctypes.byref(mesh)) or camber.camber_run(
    mesh, len(words), (ctypes.c_char_p * len(words))(*words), None, ctypes.byref(result))
if status:
    camber.camber_error.restype = ctypes.c_char_p
    sys.exit(camber.camber_error().decode())
'''
# A fixed environment: it is on the stack, and its length changes addresses.
ENVIRONMENT = {'PATH': '/usr/bin:/bin', 'LC_ALL': 'C', 'HOME': '/nonexistent', 'PYTHONHASHSEED': '0'}


def run(command, folder):
    done = subprocess.run(command, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"instructions.py: {' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
    return done.stderr


def prepared(program, folder):
    """Makes the inputs in the folder with the measured program."""
    shutil.copy(ROOT / 'tests' / 'cad' / 'shell.brep', folder)
    for arguments in INPUTS:
        run([program, *arguments, '--quiet'], folder)


def command_of(program, name):
    if name not in BY_LIBRARY:
        return [program, *RUNS[name], '--threads', '1']
    library = pathlib.Path(program).parent.parent / 'lib' / 'libcamber.so'
    return ['/usr/bin/python3', '-I', '-S', '-c', LIBRARY, str(library), BY_LIBRARY[name], *RUNS[name], '--threads=1']


def instructions(command, folder):
    text = run(['valgrind', '--tool=cachegrind', '--cache-sim=no', '--cachegrind-out-file=/dev/null', *command], folder)
    counted = re.search(r'I\s+refs:\s+([\d,]+)', text)
    if not counted:
        sys.exit(f'instructions.py: Valgrind printed no count:\n{text}')
    return int(counted[1].replace(',', ''))


def has_grown(name, count, before):
    """Prints a row. Returns True if the run takes more instructions than stored."""
    print(f"{name:14} {count:15,} {f'{100 * (count / before - 1):+8.2f} %' if before else 'not stored'}", flush=True)
    return not before or count > (1 + GROWTH) * before


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('program')
    parser.add_argument('runs', nargs='*', metavar='RUN', help=', '.join(RUNS))
    parser.add_argument('--write', action='store_true', help='store the counts')
    arguments = parser.parse_args()
    if unknown := set(arguments.runs) - set(RUNS):
        parser.error(f"no run {', '.join(sorted(unknown))}: there are {', '.join(RUNS)}")
    if not shutil.which('valgrind'):
        sys.exit('instructions.py: valgrind is missing: apt-get install valgrind')
    if 'avx2' not in pathlib.Path('/proc/cpuinfo').read_text():
        sys.exit('instructions.py: the stored counts need a processor with AVX2')
    stored = json.loads(STORED.read_text()) if STORED.exists() else {}
    program = str(pathlib.Path(arguments.program).resolve())
    with tempfile.TemporaryDirectory() as folder:
        prepared(program, folder)
        counts, grown = {}, []
        for name in arguments.runs or RUNS:
            counts[name] = instructions(command_of(program, name), folder)
            if has_grown(name, counts[name], stored.get(name)):
                grown.append(name)
    if arguments.write:
        STORED.write_text(json.dumps({**stored, **counts}, indent=4) + '\n')
        return 0
    if grown:
        print(f"more than {100 * GROWTH:.0f} % above the stored count: {', '.join(grown)}. Find out why; if it is worth it, store the new counts (--write) in the "
              'same commit.')
    return 1 if grown else 0


if __name__ == '__main__':
    sys.exit(main())
