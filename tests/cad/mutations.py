#!/usr/bin/env python3
"""Runs the program on damaged CAD files. Each file has one byte, number, reference or line changed. The program must end
in time and, if it rejects a file, print one line with the reason.

    python3 tests/cad/mutations.py build/bin/camber --models build/bin/cad_models --count 500
    python3 tests/cad/mutations.py build/bin/camber --model part.step --mesh part.msh --count 98
"""
import argparse
import collections
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import plate

NUMBER = re.compile(rb"(?<![#\w.])-?\d+\.\d*(?:[eE][-+]?\d+)?|(?<= )-?\d+(?= )")
REFERENCE = re.compile(rb"(?<=[(,])#\d+|(?<= )[-+]\d+ 0(?= )")


def replaced(data, span, text):
    return data[:span[0]] + text + data[span[1]:]


def byte(data, numbers):
    at = numbers.randrange(len(data))
    return replaced(data, (at, at + 1), bytes([numbers.randrange(256)]))


def number(data, numbers):
    found = [m.span() for m in NUMBER.finditer(data)]
    if not found:
        return byte(data, numbers)
    begin, end = span = numbers.choice(found)
    old = data[begin:end]
    return replaced(data, span, numbers.choice([b"0.", b"-" + old, b"1.E300", b"-1.E10", old + b"1", b"1.E-300", b"7."]))


def reference(data, numbers):
    found = [m.span() for m in REFERENCE.finditer(data)]
    if not found:
        return line(data, numbers)
    begin, end = numbers.choice(found)
    other = numbers.choice(found)
    return replaced(data, (begin, end), data[other[0]:other[1]])


def line(data, numbers):
    lines = data.splitlines(keepends=True)
    at, other = numbers.randrange(len(lines)), numbers.randrange(len(lines))
    change = numbers.randrange(3)
    if change == 0:
        del lines[at]
    elif change == 1:
        lines.insert(at, lines[other])
    else:
        lines[at], lines[other] = lines[other], lines[at]
    return b"".join(lines)


KINDS = (byte, number, reference, line)


class Trials:
    def __init__(self, program, folder, mesh, seconds):
        self.program, self.folder, self.mesh, self.seconds = program, folder, mesh, seconds
        self.exits, self.longest, self.failures = collections.Counter(), 0.0, []

    def run(self, verb, model):
        to = ["-o", self.folder / "out.mesh"] if verb == "curve" else ["--json"]
        limits = [] if self.seconds is None else ["--cad-timeout", str(self.seconds)]
        start = time.monotonic()
        try:
            done = subprocess.run([self.program, verb, self.mesh, "--cad", model, "--threads", "1", *to, *limits],
                                  capture_output=True, text=True, errors="replace", timeout=120)
        except subprocess.TimeoutExpired:
            return None, "no end", 120.0
        return done.returncode, done.stderr, time.monotonic() - start

    def check(self, name, verb, model):
        code, stderr, seconds = self.run(verb, model)
        self.longest = max(self.longest, seconds)
        lines = [l for l in stderr.splitlines() if not l.startswith("camber: note")]
        self.exits[code] += 1
        for phrase in ("crashes on it", "takes more than", "lie on", "do not lie"):
            if phrase in stderr:
                self.exits[phrase] += 1
        is_right = code in (0, 1) or (code in (2, 3) and len(lines) == 1 and lines[0].startswith("camber: "))
        is_slow = seconds > 12 + (self.seconds or 10)
        if not is_right or is_slow:
            self.failures.append(f"{name}, {verb}: {'slow, ' if is_slow else ''}{seconds:.1f} s, exit {code}: {stderr[:300]!r}")


def models_of(arguments, folder):
    """Returns the files to damage and their mesh."""
    if arguments.model:
        return [pathlib.Path(arguments.model)], arguments.mesh
    mesh = folder / "plate.mesh"
    mesh.write_text(plate.text(*plate.plate()))
    files = []
    for ending in ("step", "iges", "brep"):
        files.append(folder / f"plate.{ending}")
        subprocess.run([arguments.models, files[-1]], check=True)
    return files, mesh


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--models", help="program that writes the models to damage")
    parser.add_argument("--model", help="file to damage instead")
    parser.add_argument("--mesh", help="mesh of the model")
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seconds", type=float, help="time limit in seconds")
    parser.add_argument("--cad-timeout", type=float, help="value of the program's option")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", help="folder for files that fail")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        files, mesh = models_of(arguments, folder)
        trials = Trials(arguments.program, folder, mesh, arguments.cad_timeout)
        for verb in ("curve", "geometry"):
            for file in files:
                code, stderr, _ = trials.run(verb, file)
                assert code == 0, f"{file}, undamaged, {verb}: exit {code}: {stderr}"
        start, count = time.monotonic(), 0
        for i in range(arguments.count):
            if arguments.seconds and time.monotonic() - start > arguments.seconds:
                break
            numbers = random.Random(f"{arguments.seed}/{i}")
            source = files[i % len(files)]
            kind = KINDS[i // len(files) % len(KINDS)]
            model = folder / f"damaged{source.suffix}"
            model.write_bytes(kind(source.read_bytes(), numbers))
            before = len(trials.failures)
            trials.check(f"{source.name}, {kind.__name__}, seed {arguments.seed}/{i}",
                         "curve" if i // 12 % 2 == 0 else "geometry", model)
            count += 1
            if arguments.keep and len(trials.failures) > before:
                folder_for_failures = pathlib.Path(arguments.keep)
                folder_for_failures.mkdir(parents=True, exist_ok=True)
                (folder_for_failures / f"{i}{source.suffix}").write_bytes(model.read_bytes())
    print(f"{count} damaged files in {time.monotonic() - start:.0f} s, longest {trials.longest:.1f} s; exit codes and phrases: "
          + ", ".join(f"{key}: {count}" for key, count in sorted(trials.exits.items(), key=str)))
    for failure in trials.failures:
        print(failure)
    return 1 if trials.failures else 0


if __name__ == "__main__":
    sys.exit(main())
