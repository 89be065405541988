"""clang-tidy over all sources of the project, several units in one run.

    python3 tests/lint/together.py BUILD [--clang-tidy PROGRAM] [--jobs N]        exit code 1: something was found

With modules clang-tidy walks for each unit through all that it imports, the standard library too: that, and not the unit's own text, was
what lint cost. So it walks once for many:

- Interface units are no runs of their own: one text imports all modules, and the filter of headers lets the diagnostics of what it imports
  pass. A unit that no module's interface reaches is linted alone.
- Implementation units of one module are put together into one text under BUILD/lint/: their includes, `module NAME;`, their imports, then
  the rest of each. Diagnostics are told where they are in the sources. Units that define the same local name are not put together; where
  a text does not compile all the same, its units are linted one by one. So what goes together is a matter of time alone.

What only the preprocessor sees (readability-duplicate-include) is looked for here, in the text of each file.
"""
import argparse
import json
import os
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINES = 2500  # of one text, about: more of them leave one processor waiting at the end
DIAGNOSTIC = re.compile(r"^(/[^:\n]+):(\d+):(\d+): (warning|error|note): ")
MODULE = re.compile(r"^(export )?module (camber[\w.]*)(:\w+)?;")
LOCAL_TYPE = re.compile(r"^\s*(?:template <[^>]*>\s*)?(?:struct|class|enum class|enum|union|using|concept)\s+(\w+)(?!.*;\s*$)|^\s*using (\w+) =")
LOCAL_VALUE = re.compile(r"^(?:static |inline |constexpr |const )+[\w:<>, ]+?\s(\w+)(?:\[\w*\])?(?:\s*=|\{|;)")
INSTANTIATED = re.compile(r"^\s*template (?:class (\w+)<|[^<(].*?\s(\w+)<\w+>::)")  # a class, or a member of it: not both in one text
LOCAL_FUNCTION = re.compile(r"^[\w\[\]:<>,*& ]+?[\s*&](\w+)\(")


@dataclass
class Unit:
    path: Path
    command: list  # without its output, and without what is not the same under another name
    imports: dict  # module: its compiled interface
    output: str  # the interface that it compiles itself; empty: none
    lines: list
    module: str  # of an implementation unit; empty: of another unit
    exported: str  # of a module's primary interface unit; empty: of another unit

    def locals(self) -> set:
        """What two units of one text must not both define, guessed from the text. Functions of one name are as often overloads, but
        whether they are the text does not tell."""
        found, inside = set(), not self.module
        for line in self.lines:
            if line.startswith("namespace {"):
                inside = True
            elif line.startswith("}  // namespace") and not line.startswith("}  // namespace camber"):
                inside = not self.module
            elif match := INSTANTIATED.match(line):
                found.add(match[1] or match[2])
            elif inside or line.startswith("static "):
                if match := LOCAL_TYPE.match(line) or LOCAL_VALUE.match(line):
                    found.add(match[1] or match[match.lastindex])
                elif not line.startswith((" ", "#", "/", "}", "template", "return")) and (match := LOCAL_FUNCTION.match(line)):
                    found.add(match[1])
        return found


@dataclass
class Text:
    """One run of clang-tidy: of its units, or of all that they import."""
    units: list
    all_imports: bool = False
    names: set = field(default_factory=set)

    def size(self) -> int:
        return sum(len(unit.lines) for unit in self.units)


def read_unit(entry: dict) -> Unit:
    directory = Path(entry["directory"])
    words, command, imports, output = shlex.split(entry["command"]), [], {}, ""
    skip = False
    for word in words[1:]:
        if skip or word in ("-o", "-c") or word == entry["file"]:
            skip = word == "-o"
        elif word.startswith("@"):
            for line in (directory / word[1:]).read_text().splitlines():
                if line.startswith("-fmodule-file="):
                    name, file = line.removeprefix("-fmodule-file=").split("=", 1)
                    imports[name] = file
                elif line.startswith("-fmodule-output="):
                    output = line.removeprefix("-fmodule-output=")
        elif not word.startswith("-W"):  # clang-tidy's own remain; a text of several units has other warnings than each
            command.append(word)
    path = Path(entry["file"])
    lines = path.read_text().splitlines()
    named = [match for line in lines if (match := MODULE.match(line))]
    module = named[0][2] if named and not named[0][1] and not named[0][3] else ""
    exported = named[0][2] if named and named[0][1] and not named[0][3] else ""
    return Unit(path, command, imports, output, lines, module, exported)


def texts_of(units: list) -> list:
    """Units of the same module and flags together, as far as their local names are different ones."""
    texts: dict = {}
    for unit in sorted(units, key=lambda unit: -len(unit.lines)):
        places = texts.setdefault((unit.module, *unit.command), [])
        names = unit.locals()
        fits = (text for text in places if unit.module and text.size() + len(unit.lines) <= LINES and not text.names & names)
        place = next(fits, None)
        if place is None:
            place = Text([])
            places.append(place)
        place.units.append(unit)
        place.names |= names
    return [text for places in texts.values() for text in places]


def write_text(text: Text, path: Path) -> list:
    """Writes the units as one, and gives for each line of it the unit's path and line."""
    head, imports, rest = [("module;", None)], [], []
    for unit in sorted(text.units, key=lambda unit: "template <>" not in unit.lines):  # before what they specialise is used
        declared = next(i for i, line in enumerate(unit.lines) if MODULE.match(line))
        for i, line in enumerate(unit.lines):
            where = (unit.path, i + 1)
            if i < declared:
                head += [(line, where)] if line != "module;" else []
            elif line.startswith("import "):
                imports.append((line, where))
            elif i > declared:
                rest.append((line, where))
        rest += [(f"#undef {match[1]}", None) for line in unit.lines if (match := re.match(r"#define (\w+)", line))]
    lines = [*head, (f"module {text.units[0].module};", None), *imports, *rest]
    path.write_text("\n".join(line for line, _ in lines) + "\n")
    return [where for _, where in lines]


def run(arguments, text: Text, number: int) -> tuple:
    """What clang-tidy says of a text, by diagnostic with its notes, and whether it compiled."""
    first = text.units[0]
    source, places = first.path, []
    imports = {name: file for unit in text.units for name, file in unit.imports.items()}
    header_filter = ""
    command = [*first.command, *(f"-iquote{folder}" for folder in sorted({str(unit.path.parent) for unit in text.units}))]
    if text.all_imports:
        source = arguments.build / "lint" / "interfaces.cpp"
        source.write_text("".join(f"import {unit.exported};\n" for unit in text.units))
        imports |= {unit.exported: unit.output for unit in text.units}
        header_filter = f"^{re.escape(str(ROOT))}/(modules|apps)/.*[.]cppm$"
    elif len(text.units) > 1:
        source = arguments.build / "lint" / f"{first.module}-{number}.cpp"
        places = write_text(text, source)
    elif first.output:
        command += ["-x", "c++-module"]
    command += [f"-fmodule-file={name}={file}" for name, file in imports.items()]
    result = subprocess.run(
        [arguments.clang_tidy, "-quiet", f"--config-file={ROOT}/.clang-tidy", "--checks=-readability-duplicate-include",
         f"--header-filter={header_filter}", str(source), "--", *command],
        cwd=arguments.build, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    found, compiled = [], "[clang-diagnostic-error" not in result.stdout
    for line in result.stdout.splitlines():
        match = DIAGNOSTIC.match(line)
        if match and places and match[1] == str(source):
            where = places[int(match[2]) - 1]
            line = (f"{where[0]}:{where[1]}" if where else f"{source}:{match[2]}") + line[match.end(2):]
        if match and match[4] != "note" or not found:
            found.append(line)
        else:
            found[-1] += "\n" + line
    if compiled and result.returncode != 0 and not found:
        found = [f"{source}: {arguments.clang_tidy} failed\n{result.stderr}"]
    return found, compiled


def lint(arguments, text: Text, number: int) -> list:
    found, compiled = run(arguments, text, number)
    if compiled or text.all_imports or len(text.units) == 1:
        return found
    print("lint: these do not compile together, so each is linted alone: " + " ".join(unit.path.name for unit in text.units)
          + "\n" + next(line for line in found if "clang-diagnostic-error" in line).split("\n")[0], file=sys.stderr)
    return [line for unit in text.units for line in run(arguments, Text([unit]), number)[0]]


def included_twice(path: Path) -> list:
    seen, found = set(), []
    for i, line in enumerate(path.read_text().splitlines()):
        if match := re.match(r"\s*#\s*include\s*(\S+)", line):
            if match[1] in seen:
                found.append(f"{path}:{i + 1}: error: {match[1]} is included twice")
            seen.add(match[1])
        elif re.match(r"\s*#\s*(if|el|endif)", line):
            seen.clear()
    return found


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=Path)
    parser.add_argument("--clang-tidy", default="clang-tidy-19")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    arguments.build = arguments.build.resolve()
    (arguments.build / "lint").mkdir(exist_ok=True)

    entries = json.loads((arguments.build / "compile_commands.json").read_text())
    ours = re.compile(rf"{re.escape(str(ROOT))}/(modules|apps)/")
    units = list({unit.path: unit for entry in entries if ours.match(entry["file"]) for unit in [read_unit(entry)]}.values())
    modules = [unit for unit in units if unit.exported]
    reached = {file for unit in modules for file in [unit.output, *unit.imports.values()]}
    texts = texts_of([unit for unit in units if not unit.output])
    texts += [Text([unit]) for unit in units if unit.output and unit.output not in reached]
    texts.append(Text(modules, all_imports=True))
    texts.sort(key=lambda text: -text.size())

    with ThreadPoolExecutor(arguments.jobs) as pool:
        told = list(pool.map(lambda numbered: lint(arguments, numbered[1], numbered[0]), enumerate(texts)))
    found = [line for lines in told for line in lines]
    found += [line for unit in units for line in included_twice(unit.path)]
    print("\n".join([*found, f"{len(units)} units in {len(texts)} runs"]))
    return 1 if found or not units else 0


if __name__ == "__main__":
    sys.exit(main())
