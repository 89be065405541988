"""Programs run by a benchmark."""
import resource
import subprocess
import sys


class Program:
    """program(words…) returns the output. Exits the benchmark if the program fails (exit codes other than 0 and 1)."""

    def __init__(self, path):
        self.path = path

    def __call__(self, *words):
        done = subprocess.run([self.path, *map(str, words)], capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1):
            raise SystemExit(f'{" ".join(map(str, words))}\n{done.stderr}')
        return done.stdout


def seconds_of(words):
    """Returns the CPU seconds of any command line, or None after printing the end of its output if it fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1):
        print(f"{' '.join(map(str, words))}\n{(done.stderr or done.stdout)[-500:]}", file=sys.stderr)
        return None
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
