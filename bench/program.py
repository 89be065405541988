"""The programs that a benchmark runs."""
import resource
import subprocess
import sys


class Program:
    """program(words…): what it prints; ends the benchmark where it fails (exit codes 0 and 1 do not)."""

    def __init__(self, path):
        self.path = path

    def __call__(self, *words):
        done = subprocess.run([self.path, *map(str, words)], capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1):
            raise SystemExit(f'{" ".join(map(str, words))}\n{done.stderr}')
        return done.stdout


def seconds_of(words):
    """Seconds of the processor that a command line takes, of whichever program; None, and the end of what it said, where it fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1):
        print(f"{' '.join(map(str, words))}\n{(done.stderr or done.stdout)[-500:]}", file=sys.stderr)
        return None
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
