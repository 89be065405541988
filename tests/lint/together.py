"""clang-tidy over all sources of the project, several units in one run.

    python3 tests/lint/together.py BUILD [PATH…] [--clang-tidy PROGRAM] [--jobs N]        exit code 1: something was found

PATH: a part of the path of the units to lint, each by itself; without, all of them.

With modules clang-tidy walks for each unit through all that it imports, the standard library too: that, and not the unit's own text, was
what lint cost. So it walks once for many:

- Interface units are no runs of their own: one text imports all modules, and the filter of headers lets the diagnostics of what it imports
  pass. Those of a partition that no module's interface reaches pass in a text that imports it. Named by a PATH, interface units are linted
  as the text that they were compiled as.
- Other units of one module, or of none and compiled alike, are put together into one text under BUILD/lint/, as for compiling
  (cmake/together.py), more of them: what they import is united, and a local name that another unit writes, too, is given its unit's for a
  surname. Diagnostics are told where they are in the sources. Where a text does not compile all the same, its units are linted one by
  one. So what goes together is a matter of time alone.

What only the preprocessor sees (readability-duplicate-include) is looked for here, in the text of each file.
"""
import argparse
import json
import os
import re
import shlex
import subprocess
import sys
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cmake"))
import together  # noqa: E402

LINES = 2500  # of one text, about: more of them leave one processor waiting at the end
WORD = re.compile(r"[A-Za-z_]\w*")
DIAGNOSTIC = re.compile(r"^(/[^:\n]+):(\d+):(\d+): (warning|error|note): ")


@dataclass
class Unit(together.Source):
    command: list = field(default_factory=list)  # without its output, and without what is not the same under another name
    given: dict = field(default_factory=dict)  # module: its compiled interface
    output: str = ""  # the interface that it compiles itself; empty: none
    compiled: Path = Path()  # the unit, or the text of it and of others


@dataclass
class Text(together.Text):
    """One run of clang-tidy: of its units, or of all that they import. Told is also of the parts, which its units import."""
    all_imports: bool = False
    parts: list = field(default_factory=list)


def files_of(entry: dict) -> list:
    return together.members(Path(entry["file"])) or [Path(entry["file"])]


def read_interfaces(entries: list) -> dict:
    """Of each module the interface units that were compiled as one text."""
    texts = ([together.read_source(path) for path in files_of(entry)] for entry in entries if entry["file"].endswith(".cppm"))
    texts = (together.one_interface(units) for units in texts)
    return {units[-1].exported: units for units in texts if units}


def read_units(entry: dict, interfaces: dict) -> list:
    """The units of an entry of compile_commands.json: several where they were compiled as one text."""
    directory = Path(entry["directory"])
    words, command, given, output = shlex.split(entry["command"]), [], {}, ""
    skip = False
    for word in words[1:]:
        if skip or word in ("-o", "-c") or word == entry["file"]:
            skip = word == "-o"
        elif word.startswith("@"):
            for line in (directory / word[1:]).read_text().splitlines():
                if line.startswith("-fmodule-file="):
                    name, file = line.removeprefix("-fmodule-file=").split("=", 1)
                    given[name] = file
                elif line.startswith("-fmodule-output="):
                    output = line.removeprefix("-fmodule-output=")
        elif not word.startswith("-W"):  # clang-tidy's own remain; a text of several units has other warnings than each
            command.append(word)
    sources = [together.read_source(path) for path in files_of(entry)]
    sources = [together.without_partitions(source, interfaces.get(source.of, [])) for source in sources]
    return [Unit(**vars(source), command=command, given=given, output=output, compiled=Path(entry["file"])) for source in sources]


@cache
def places_in(path: str) -> list:
    """Of each line of a text that was compiled as several units its place in them; empty: of a source."""
    return together.places(Path(path)) if together.members(Path(path)) else []


def write_text(text: Text, path: Path) -> list:
    """Writes the units as one, and gives for each line of it the unit's path and line."""
    lines = together.joined(text.units)
    path.write_text("\n".join(line for line, _ in lines) + "\n")
    return [where for _, where in lines]


@cache
def elsewhere() -> tuple:
    """The words of interface units, and the functions of headers."""
    found = []
    for kind, word in ("*.cppm", WORD), ("*.hpp", re.compile(r"(\w+)\(")):
        paths = (path for folder in ("modules", "apps") for path in (ROOT / folder).rglob(kind))
        lines = (line for path in paths for line in path.read_text().splitlines() if not line.lstrip().startswith("//"))
        found.append({name for line in lines for name in word.findall(line)})
    return tuple(found)


def with_surnames(units: list) -> list:
    """The units of one text, perhaps, with local names that are in nobody's way: one that is another unit's word, or an interface's, becomes
    NAME_of_UNIT."""
    texts = ["\n".join(unit.lines) for unit in units]
    writers = Counter(word for text in texts for word in set(WORD.findall(text)))
    return [renamed(unit, [name for name in unit.locals()
                           if (writers[name] > 1 or name in elsewhere()[0]) and may_be_renamed(name, unit, text)])
            for unit, text in zip(units, texts)]


def may_be_renamed(name: str, unit: Unit, text: str) -> bool:
    """Not where a member is called so, or what is instantiated, what the function overloads, or what a header declares; macros neither."""
    interfaces, headers = elsewhere()
    instantiated = (name in match.groups() for match in map(together.INSTANTIATED.match, unit.lines) if match)
    overloads = unit.module and name in interfaces and re.search(rf"\b{name}\(", text)
    return not (name.isupper() or overloads or name in headers or any(instantiated) or re.search(rf"(?:[.~]|->|::){name}\b", text))


def renamed(unit: Unit, names: list) -> Unit:
    if not names:
        return unit
    written = re.compile(rf"\b({'|'.join(names)})\b")
    surname = re.sub(r"\W", "_", unit.path.stem if unit.of else unit.path.parent.name + "_" + unit.path.stem)
    return replace(unit, lines=[line if together.INCLUDE.match(line) or together.IMPORT.match(line) else written.sub(rf"\1_of_{surname}", line)
                                for line in unit.lines])


def together_in_texts(units: list) -> list:
    """Units of one module, or of none, that are compiled alike."""
    alike = defaultdict(list)
    for unit in units:
        alike[unit.module, *unit.command].append(unit)
    return [Text(text.units) for some in alike.values() for text in together.texts_of(with_surnames(some), lambda unit: None, LINES)]


def give_parts(texts: list, parts: list) -> list:
    """Texts for all parts: one of those that import it, else its own."""
    for part in parts:
        reader = next((text for text in texts if any(part.output in unit.given.values() for unit in text.units)), None)
        if reader:
            reader.parts.append(part)
        else:
            texts = [*texts, Text([part])]
    return texts


def asked_for(told: str, text: Text) -> bool:
    """Not of a unit that is only compiled in the same text."""
    return (not DIAGNOSTIC.match(told) or "[clang-diagnostic-error" in told
            or told.startswith(tuple(f"{unit.path}:" for unit in text.units)))


def run(arguments, text: Text, number: int) -> tuple:
    """What clang-tidy says of a text, by diagnostic with its notes, and whether it compiled."""
    first = text.units[0]
    source, places = first.compiled, []
    imports = {name: file for unit in text.units for name, file in unit.given.items()}
    header_filter = "|".join(f"^{re.escape(str(part.compiled))}$" for part in text.parts)
    command = [*first.command, "-Wconditional-uninitialized", *(f"-iquote{folder}" for folder in sorted({str(unit.path.parent) for unit in text.units}))]
    if text.all_imports:
        source = arguments.build / "lint" / "interfaces.cpp"
        source.write_text("".join(f"import {unit.exported};\n" for unit in text.units))
        imports |= {unit.exported: unit.output for unit in text.units}
        header_filter = f"^({re.escape(str(ROOT))}/(modules|apps)|{re.escape(str(arguments.build))}/together)/.*[.]cppm$"
    elif first.output:
        command += ["-x", "c++-module"]
    elif len(text.units) > 1 or first.compiled != first.path:
        source = arguments.build / "lint" / f"{first.of}-{number}.cpp"
        places = write_text(text, source)
    command += [f"-fmodule-file={name}={file}" for name, file in imports.items()]
    result = subprocess.run(
        [arguments.clang_tidy, "-quiet", f"--config-file={ROOT}/.clang-tidy", "--checks=-readability-duplicate-include",
         f"--header-filter={header_filter}", str(source), "--", *command],
        cwd=arguments.build, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    found, compiled = [], "[clang-diagnostic-error" not in result.stdout
    for line in result.stdout.splitlines():
        match = DIAGNOSTIC.match(line)
        if match:
            there = places if places and match[1] == str(source) else places_in(match[1])
            where = there[int(match[2]) - 1] if there else None
            line = (f"{where[0]}:{where[1]}" if where else f"{match[1]}:{match[2]}") + line[match.end(2):]
        if match and match[4] != "note" or not found:
            found.append(line)
        else:
            found[-1] += "\n" + line
    if compiled and result.returncode != 0 and not found:
        found = [f"{source}: {arguments.clang_tidy} failed\n{result.stderr}"]
    if first.output and not text.all_imports:
        found = [told for told in found if asked_for(told, text)]
    return found, compiled


def lint(arguments, text: Text, number: int) -> list:
    found, compiled = run(arguments, text, number)
    if compiled or text.all_imports or text.units[0].output or len(text.units) == 1:
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
    parser.add_argument("paths", nargs="*")
    parser.add_argument("--clang-tidy", default="clang-tidy-19")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    arguments.build = arguments.build.resolve()
    (arguments.build / "lint").mkdir(exist_ok=True)

    entries = json.loads((arguments.build / "compile_commands.json").read_text())
    ours = re.compile(rf"{re.escape(str(ROOT))}/(modules|apps)/")
    interfaces = read_interfaces(entries)
    units = {unit.path: unit for entry in entries for unit in read_units(entry, interfaces) if ours.match(str(unit.path))}.values()
    if arguments.paths:
        units = [unit for unit in units if any(part in str(unit.path) for part in arguments.paths)]
    modules = [unit for unit in units if unit.exported]
    reached = {file for unit in modules for file in [unit.output, *unit.given.values()]}
    alone = [unit for unit in units if not unit.output]
    if arguments.paths:
        texts = [Text([unit]) for unit in alone]
        texts += [Text([unit for unit in units if unit.output == output]) for output in dict.fromkeys(unit.output for unit in units) if output]
    else:
        texts = give_parts(together_in_texts(alone), [unit for unit in units if unit.output and unit.output not in reached])
        texts.append(Text(list(modules), all_imports=True))
    texts.sort(key=lambda text: -text.size())

    with ThreadPoolExecutor(arguments.jobs) as pool:
        told = list(pool.map(lambda numbered: lint(arguments, numbered[1], numbered[0]), enumerate(texts)))
    found = [line for lines in told for line in lines]
    found += [line for unit in units for line in included_twice(unit.path)]
    print("\n".join([*found, f"{len(units)} units in {len(texts)} runs"]))
    return 1 if found or not units else 0  # a path that fits no unit would be a lint that never fails


if __name__ == "__main__":
    sys.exit(main())
