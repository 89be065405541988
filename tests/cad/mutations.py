#!/usr/bin/env python3
"""The program on damaged CAD files: each is one file with one byte, number, reference or line of it changed. It ends by
itself, in time, and says in one line why it takes one not.

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
    way = numbers.randrange(3)
    if way == 0:
        del lines[at]
    elif way == 1:
        lines.insert(at, lines[other])
    else:
        lines[at], lines[other] = lines[other], lines[at]
    return b"".join(lines)


KINDS = (byte, number, reference, line)


class Trials:
    def __init__(self, program, folder, mesh, seconds):
        self.program, self.folder, self.mesh, self.seconds = program, folder, mesh, seconds
        self.ends, self.longest, self.wrong = collections.Counter(), 0.0, []

    def run(self, verb, model):
        to = ["-o", self.folder / "out.mesh"] if verb == "curve" else ["--json"]
        limits = [] if self.seconds is None else ["--cad-timeout", str(self.seconds)]
        began = time.monotonic()
        try:
            done = subprocess.run([self.program, verb, self.mesh, "--cad", model, "--threads", "1", *to, *limits],
                                  capture_output=True, text=True, errors="replace", timeout=120)
        except subprocess.TimeoutExpired:
            return None, "no end", 120.0
        return done.returncode, done.stderr, time.monotonic() - began

    def judge(self, name, verb, model):
        code, said, took = self.run(verb, model)
        self.longest = max(self.longest, took)
        lines = [l for l in said.splitlines() if not l.startswith("camber: note")]
        self.ends[code] += 1
        for what in ("crashes on it", "takes more than", "lie on", "do not lie"):
            if what in said:
                self.ends[what] += 1
        right = code in (0, 1) or (code in (2, 3) and len(lines) == 1 and lines[0].startswith("camber: "))
        slow = took > 12 + (self.seconds or 10)
        if not right or slow:
            self.wrong.append(f"{name}, {verb}: {'slow, ' if slow else ''}{took:.1f} s, exit {code}: {said[:300]!r}")


def models_of(arguments, folder):
    """Files to damage, and their mesh."""
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
    parser.add_argument("--models", help="the program that writes the models to damage")
    parser.add_argument("--model", help="a file to damage instead")
    parser.add_argument("--mesh", help="its mesh")
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seconds", type=float, help="end after so many, whatever the count")
    parser.add_argument("--cad-timeout", type=float, help="as the program's")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", help="a folder for the files on which something went wrong")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        files, mesh = models_of(arguments, folder)
        trials = Trials(arguments.program, folder, mesh, arguments.cad_timeout)
        for verb in ("curve", "geometry"):
            for file in files:
                code, said, _ = trials.run(verb, file)
                assert code == 0, f"{file}, as it is, {verb}: exit {code}: {said}"
        began, tried = time.monotonic(), 0
        for i in range(arguments.count):
            if arguments.seconds and time.monotonic() - began > arguments.seconds:
                break
            numbers = random.Random(f"{arguments.seed}/{i}")
            source = files[i % len(files)]
            kind = KINDS[i // len(files) % len(KINDS)]
            model = folder / f"damaged{source.suffix}"
            model.write_bytes(kind(source.read_bytes(), numbers))
            before = len(trials.wrong)
            trials.judge(f"{source.name}, {kind.__name__}, seed {arguments.seed}/{i}",
                         "curve" if i // 12 % 2 == 0 else "geometry", model)
            tried += 1
            if arguments.keep and len(trials.wrong) > before:
                kept = pathlib.Path(arguments.keep)
                kept.mkdir(parents=True, exist_ok=True)
                (kept / f"{i}{source.suffix}").write_bytes(model.read_bytes())
    print(f"{tried} damaged files in {time.monotonic() - began:.0f} s, the longest {trials.longest:.1f} s; exits and words: "
          + ", ".join(f"{key}: {count}" for key, count in sorted(trials.ends.items(), key=str)))
    for wrong in trials.wrong:
        print(wrong)
    return 1 if trials.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
