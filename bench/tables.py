#!/usr/bin/env python3
"""Runs the commands of the measured tables in the pages, and compares what they print with what the pages have.

    bench/tables.py                                     all tables in docs/ and bench/results/: hours
    bench/tables.py docs/curvature.md --only fronts     some pages, some tables
    bench/tables.py --longest 60                        the tables that take at most about a minute
    bench/tables.py --write                             also writes the new tables into the pages
    bench/tables.py --list                              names, tolerances, estimated seconds, pages, commands

A measured table is a Markdown table or a `text` block behind a comment that the rendered page does not show:

    <!-- measured NAME: within 1.3; 20 s; needs mpirun, python3-gmsh -->

Its command is the nearest `sh` block above it. Several tables behind one command are the tables that it prints, in their order. A `text`
block begins with the same line in the page and in the output, and ends at an empty line. Commands run in an empty folder in which the
project's files are found under their names, `camber` and `build/bin/…` are the programs beside the given one, and `python3` is the
interpreter that runs this script.

Texts and first columns must be equal. Other numbers must agree within the factor, or within a unit of the last digit of a decimal number.
Seconds and megabytes, known by the unit behind a number or at the end of a column's title, are reported and not compared. The exit code
is 1 if a table differs or a command fails. Tables whose programs or Python modules (python3-NAME) are missing are listed and not run.
"""
import argparse
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import namedtuple
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MARKER = re.compile(r"<!-- measured ([a-z0-9-]+): within (\d+(?:\.\d+)?); (\d+) (s|min|h)(?:; needs ([^;]+))? -->")
IN_SECONDS = {"s": 1, "min": 60, "h": 3600}
NUMBER = re.compile(r"[-+−]?\d+(?:[ \u00a0\u202f]\d{3}(?!\d))*(?:\.\d+)?(?:e[-+]?\d+)?")
UNITS = ("s", "ms", "µs", "us", "ns", "/s", "seconds", "kB", "MB", "GB", "MiB", "GiB", "MB/s")
UNIT_BEHIND = re.compile(r" ?(?:" + "|".join(UNITS) + r")(?![\w/])")
ROUNDING = 1e-12  # two numbers below it are both 0


class Unusable(Exception):
    """A page or a table that cannot be measured, with the reason."""


@dataclass(frozen=True)
class Table:
    """A measured table of a page: lines[first:last] are its lines, without the marker."""
    page: Path
    name: str
    factor: float
    seconds: int
    needs: tuple
    command: str
    order: int  # among the Markdown tables behind one command
    first: int
    last: int

    def lines(self):
        return self.page.read_text(encoding="utf-8").splitlines()[self.first:self.last]


Number = namedtuple("Number", "text value unit is_of_machine")  # unit: that of the last digit; 0 for an integer


# Pages

def pages():
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "bench" / "results").glob("*.md"))]


def block_end(lines, first):
    """The end of the table or fenced block that begins at a line; `first` if none does."""
    last = first
    if first < len(lines) and lines[first].startswith("```"):
        last = next((k + 1 for k in range(first + 1, len(lines)) if lines[k].startswith("```")), first)
    while last < len(lines) and lines[last].startswith("|"):
        last += 1
    return last


def table_at(page, lines, at, command, order):
    """The table whose marker is at a line."""
    where, found = f"{page}: line {at + 1}", MARKER.fullmatch(lines[at])
    if not found:
        raise Unusable(f"{where}: not of the form <!-- measured NAME: within FACTOR; SECONDS s[; needs PROGRAM, …] -->")
    if not command:
        raise Unusable(f"{where}: no `sh` block above it has the command")
    last = block_end(lines, at + 1)
    if last == at + 1:
        raise Unusable(f"{where}: neither a table nor a `text` block follows it")
    needs = tuple(found[5].split(", ")) if found[5] else ()
    return Table(page, found[1], float(found[2]), int(found[3]) * IN_SECONDS[found[4]], needs, command, order, at + 1, last)


def tables_of(page):
    """The measured tables of a page."""
    lines, tables = page.read_text(encoding="utf-8").splitlines(), []
    command, order, at = "", 0, 0
    while at < len(lines):
        if lines[at].startswith("```"):
            last = block_end(lines, at)
            if lines[at] == "```sh":
                command, order = "\n".join(lines[at + 1:last - 1]), 0
            at = max(last, at + 1)
        elif lines[at].startswith("<!-- measured"):
            tables.append(table_at(page, lines, at, command, order))
            order, at = order + lines[at + 1].startswith("|"), tables[-1].last
        else:
            at += 1
    return tables


# Commands

def programs_of(command):
    """The programs of the build that a command calls, and the scripts of the project."""
    return re.findall(r"build/bin/([\w-]+)", command), re.findall(r"(?<![\w/])((?:bench|tests|docs)/[\w/]+\.py)", command)


def missing(table, camber):
    """The programs and Python modules that a table needs and this machine does not have."""
    built = programs_of(" ".join((table.command, *table.needs)))[0]
    modules = [name for name in table.needs if name.startswith("python3-")]
    others = [name for name in table.needs if not name.startswith(("python3-", "build/"))]
    return [*(name for name in built if not (camber.parent / name).exists()), *(name for name in others if not shutil.which(name)),
            *(name for name in modules if not importlib.util.find_spec(name.removeprefix("python3-")))]


def printed(command, camber):
    """Returns the standard output of a command that runs in a temporary folder."""
    with tempfile.TemporaryDirectory() as folder:
        for entry in ROOT.iterdir():
            if entry.name not in ("build", "out") and not entry.name.startswith("."):
                Path(folder, entry.name).symlink_to(entry)
        Path(folder, "build").symlink_to(camber.parents[1])
        interpreter = Path(folder, ".programs", "python3")
        interpreter.parent.mkdir()
        interpreter.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n', encoding="utf-8")
        interpreter.chmod(0o755)
        paths = os.pathsep.join(map(str, (interpreter.parent, camber.parent, os.environ["PATH"])))
        done = subprocess.run(["sh", "-ec", command], cwd=folder, env=os.environ | {"PATH": paths}, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        last = (done.stderr or done.stdout).strip().splitlines()[-1:] or ["no message"]
        raise Unusable(f"exit code {done.returncode}: {last[0]}")
    return done.stdout.splitlines()


def table_in(output, table):
    """The lines of the output that belong into the page instead of the table's."""
    old = table.lines()
    if old[0].startswith("```"):
        first = next((k for k, line in enumerate(output) if skeleton(line) == skeleton(old[1])), None)
        if first is None:
            raise Unusable(f"the output has no line '{old[1].strip()}'")
        last = next((k for k in range(first, len(output)) if not output[k].strip()), len(output))
        return [old[0], *output[first:last], "```"]
    begins = [k for k, line in enumerate(output) if line.startswith("|") and (k == 0 or not output[k - 1].startswith("|"))]
    if table.order >= len(begins):
        raise Unusable(f"the output has {len(begins)} tables, the page at least {table.order + 1}")
    return output[begins[table.order]:block_end(output, begins[table.order])]


# Comparison

def is_of_machine(title):
    """True if a column's title ends with a unit of time or memory and names nothing else."""
    words = re.split(r"[ ,()]+", title.strip(" )"))
    return title.count(",") <= 1 and ";" not in title and words[-1] in UNITS


def numbers(text, of_machine):
    """The numbers in a text; `of_machine` decides by the end of a number."""
    found = []
    for match in NUMBER.finditer(text):
        digits = re.sub(r"[ \u00a0\u202f]", "", match[0]).replace("−", "-")
        mantissa, _, exponent = digits.partition("e")
        decimals = len(mantissa.partition(".")[2])
        unit = 10.0 ** (int(exponent or 0) - decimals) if decimals or exponent else 0
        found.append(Number(match[0], float(digits), unit, bool(UNIT_BEHIND.match(text, match.end())) or of_machine(match.end())))
    return found


def agree(one, other, factor):
    """True if two numbers are equal, nearly 0, within the factor, or within a unit of the last digit."""
    a, b = one.value, other.value
    if a == b or max(abs(a), abs(b)) < ROUNDING or abs(a - b) <= 1.001 * max(one.unit, other.unit):
        return True
    return a * b > 0 and max(a / b, b / a) <= factor


def skeleton(text):
    """The text without the values of numbers, bold type and repeated blanks."""
    return " ".join(NUMBER.sub("#", text.replace("**", "")).split())


class Comparison:
    """Differences between a table of a page and a printed one, and the ratios of seconds and megabytes."""

    def __init__(self, table, new):
        self.factor, self.differences, self.times = table.factor, [], []
        old, new = ([line for line in lines if not line.startswith("```")] for lines in (table.lines(), new))
        if len(old) != len(new):
            self.differences.append(f"{len(old)} lines, printed {len(new)}")
        elif old[0].startswith("|"):
            self.compare_rows(*([[cell.strip() for cell in line.strip("|").split("|")] for line in lines] for lines in (old, new)))
        else:
            self.compare_text(old, new)

    def compare(self, where, old, new, of_machine):
        """Compares two cells or lines; each rule of `of_machine` is for the text of the same place in the pair."""
        a, b = numbers(old, of_machine[0]), numbers(new, of_machine[1])
        if skeleton(old) != skeleton(new):
            self.differences.append(f"{where}: '{old.strip()}', printed '{new.strip()}'")
            return
        for one, other in zip(a, b):
            if one.is_of_machine:
                self.times += [other.value / one.value] if one.value > 0 else []
            elif not agree(one, other, self.factor):
                self.differences.append(f"{where}: {one.text}, printed {other.text}")

    def compare_text(self, old, new):
        """Lines of text; right-aligned columns below a unit are the machine's."""
        ends = [{match.end() for match in re.finditer(r"\S+", lines[0]) if match[0] in UNITS} for lines in (old, new)]
        for one, other in zip(old, new):
            self.compare(f"'{' '.join(one.split())[:20]}…'", one, other, [each.__contains__ for each in ends])

    def compare_rows(self, old, new):
        """Rows of cells; those above the line of dashes are the titles."""
        dashes = next((k for k, cells in enumerate(old) if all(re.fullmatch(":?-+:?", cell) for cell in cells)), 0)
        titles, row_name = [" ".join(title).strip() for title in zip(*old[:dashes])], ""
        if old[:dashes] != new[:dashes]:
            self.differences.append(f"titles {titles}, printed {new[:dashes]}")
            return
        for row, (one, other) in enumerate(zip(old[dashes + 1:], new[dashes + 1:]), start=1):
            row_name = one[0] or row_name
            if len(one) != len(other) or one[0] != other[0]:
                self.differences.append(f"row {row}: '{one[0]}', printed '{other[0]}'")
                continue
            for title, a, b in list(zip(titles, one, other))[1:]:
                self.compare(f"row {row}, {row_name}, {title}", a, b, [lambda _, title=title: is_of_machine(title)] * 2)

    def summary(self):
        times = f"; seconds and memory {min(self.times):.2g} to {max(self.times):.2g} of the page's" if self.times else ""
        return (f"{len(self.differences)} differences" if self.differences else "agrees") + times


# Runs

def write(page, new_tables):
    """Puts new lines in place of tables: {table: lines}."""
    lines = page.read_text(encoding="utf-8").splitlines()
    for table, new in sorted(new_tables.items(), key=lambda item: -item[0].first):
        lines[table.first:table.last] = new
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")


class Runs:
    """Runs each command once, and counts the tables that differ."""

    def __init__(self, camber, writes):
        self.camber, self.writes, self.outputs, self.failed, self.new = camber, writes, {}, 0, {}

    def output_of(self, command):
        """The printed lines, or why there are none."""
        if command not in self.outputs:
            begin = time.perf_counter()
            try:
                self.outputs[command] = printed(command, self.camber)
            except Unusable as why:
                self.outputs[command] = why
            print(f"  ({time.perf_counter() - begin:.0f} s)", flush=True)
        if isinstance(self.outputs[command], Unusable):
            raise self.outputs[command]
        return self.outputs[command]

    def __call__(self, table):
        absent = missing(table, self.camber)
        print(f"{shown(table.page)}: {table.name}" + (f": not run, as there is no {', '.join(absent)}" if absent else ""), flush=True)
        if absent:
            return
        try:
            new = table_in(self.output_of(table.command), table)
        except Unusable as why:
            self.failed += 1
            print(f"  {why}", flush=True)
            return
        compared = Comparison(table, new)
        self.failed += bool(compared.differences)
        self.new.setdefault(table.page, {})[table] = new
        print("\n".join(f"  {line}" for line in [*compared.differences, compared.summary()]), flush=True)

    def finish(self):
        """Writes the pages with --write. Returns the exit code."""
        if self.writes:
            for page, new_tables in self.new.items():
                write(page, new_tables)
        return 1 if self.failed else 0


def shown(page):
    return page.relative_to(ROOT) if page.is_relative_to(ROOT) else page


def list_tables(tables):
    print("| table | page | within | s, about | needs | command |\n|---|---|---|---|---|---|")
    for table in tables:
        command = "; ".join(line for line in table.command.replace("\\\n", "").splitlines() if not line.startswith("#"))
        print(f"| {table.name} | {shown(table.page)} | {table.factor:g} | {table.seconds} | {', '.join(table.needs)} | `{' '.join(command.split())}` |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="*", type=lambda path: Path(path).resolve(), metavar="PAGE", help="pages (all)")
    parser.add_argument("--camber", type=lambda path: Path(path).resolve(), default=ROOT / "build" / "bin" / "camber", help="the program (%(default)s)")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="tables of these names")
    parser.add_argument("--longest", type=float, default=float("inf"), metavar="SECONDS", help="tables that are estimated to take no longer")
    parser.add_argument("--write", action="store_true", help="write the new tables into the pages")
    parser.add_argument("--list", action="store_true", help="list the tables and run nothing")
    options = parser.parse_args()
    try:
        tables = [table for page in options.pages or pages() for table in tables_of(page)]
    except Unusable as why:
        sys.exit(f"tables.py: {why}")
    unknown = set(options.only or ()) - {table.name for table in tables}
    if unknown:
        parser.error(f"unknown tables: {', '.join(sorted(unknown))}; see --list")
    tables = [table for table in tables if (not options.only or table.name in options.only) and table.seconds <= options.longest]
    if options.list:
        list_tables(tables)
        return
    run = Runs(options.camber, options.write)
    for table in tables:
        run(table)
    sys.exit(run.finish())


if __name__ == "__main__":
    main()
