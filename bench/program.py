"""The program that a benchmark runs."""
import subprocess


class Program:
    """program(words…): what it prints; ends the benchmark where it fails (exit codes 0 and 1 do not)."""

    def __init__(self, path):
        self.path = path

    def __call__(self, *words):
        done = subprocess.run([self.path, *map(str, words)], capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1):
            raise SystemExit(f'{" ".join(map(str, words))}\n{done.stderr}')
        return done.stdout
