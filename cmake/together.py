"""Units of one library compiled as one text. With modules most of what a unit costs is to read what it imports: several units read it once.

    python3 cmake/together.py interfaces INTERFACE…                       the interface units, a text a line: "a.cppm|b.cppm", then those left alone
    python3 cmake/together.py group LINES FILE… [--beside INTERFACE…]     the files, a text of about so many lines a line, "a.cpp|b.cpp"
    python3 cmake/together.py write TEXT FILE… [--beside INTERFACE…] [--install TEXT]
                                                                          writes the text; #line tells where each line is from

Interface units are one text, the module's primary unit and all partitions that it reaches by imports, each behind what it imports. What a
partition exports that the primary unit does not export again is not exported by the text. A partition that the primary unit does not
reach stays alone, and imports the module instead of the partitions that are in it: what it includes is not to reach whoever imports the module.
With --install a second text is written, for other machines: its #line name no folder of this one.

Implementation units of a module go together if they include the same headers of other libraries and of our own, but for those that cost
nothing (LIGHT), and have no local name in each other's way. What they import is united: that each imports what it uses is looked for by
tests/includes/check_imports.py, as headers of the standard library are by check_includes.py. Units of no module are those of tests and
programs. Where `write` finds that units no longer go together it fails, after it has touched the stamp beside
the text that CMake watches: the next build groups them anew.
"""
import argparse
import re
import sys
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

MODULE = re.compile(r"^(export )?module (camber[\w.]*)(:\w+)?;")
IMPORT = re.compile(r"^(?:export )?import ")
PARTITION = re.compile(r"^(export )?import (:\w+);")
INCLUDE = re.compile(r'^#include ([<"])([^>"]+)[>"]')
LIGHT = re.compile(r"(?:fmt|nlohmann|range|CLI)/")  # headers of other libraries that are compiled once, or that are short
LOCAL_TYPE = re.compile(r"^(?:template <[^>]*>\s*)?(?:(?:struct|class|enum class|enum|union|concept)\s+(\w+)\b(?!\s*;)|using (\w+) =)")
LOCAL_VALUE = re.compile(r"^(?:static |inline |constexpr |const )+[\w:<>,*& ]+?[\s*&](\w+)(?:\[\w*\])?(?:\s*=|\{|;)")
INSTANTIATED = re.compile(r"^(?:#define CAMBER_INSTANTIATE\(D\))?\s*template (?:class (\w+)<|[^<(].*?\s(\w+)<\w+>::)")  # a class, or a member of it: not both in one text
DECLARED = re.compile(r"[\w>&*\]] [&*]?(\w+)\s*(?=[=;,){\[:])")  # a variable or a parameter, perhaps
USED = re.compile(r"(?<![\w.>:])(\w+)\s*(?=[(<{])")  # a function or a type, perhaps; `a.b(`, `a->b(` and `a::b(` are looked up elsewhere
LOCAL_FUNCTION = re.compile(r"^[\w\[\]:<>,*& ]+?[\s*&](\w+)\(")


@dataclass
class Source:
    path: Path
    lines: list
    of: str = ""  # the module; empty: of none
    partition: str = ""  # ":name"; empty: of another unit
    exports: bool = False

    @property
    def module(self) -> str:
        """Of an implementation unit; empty: of another unit."""
        return "" if self.exports or self.partition else self.of

    @property
    def exported(self) -> str:
        """Of a module's primary interface unit; empty: of another unit."""
        return self.of if self.exports and not self.partition else ""

    def declaration(self) -> str:
        return f"{'export ' if self.exports else ''}module {self.of}{self.partition};" if self.of else ""

    def begins(self) -> int:
        """The line after the head: after `module NAME;`, or the first that is no comment or directive (headers behind imports want them)."""
        if self.of:
            return next(i for i, line in enumerate(self.lines) if MODULE.match(line)) + 1
        told = re.compile(r"^(\s*$|//|#)")
        return next((i for i, line in enumerate(self.lines) if not told.match(line)), len(self.lines))

    def imports(self) -> frozenset:
        return frozenset(line.removeprefix("export ").strip() for line in self.lines if IMPORT.match(line))

    def headers(self) -> frozenset:
        """What it includes, but for the standard library."""
        found = (INCLUDE.match(line) for line in self.lines)
        return frozenset(match[2] for match in found if match and (match[1] == '"' or re.search("[./]", match[2])))

    def values(self) -> set:
        """Names of variables at namespace scope, which nothing in another unit of the text is to shadow."""
        return {match[1] for line in self.lines if (match := LOCAL_VALUE.match(line))}

    def declared(self) -> set:
        return {name for line in self.lines for name in DECLARED.findall(line)}

    def used(self) -> set:
        """Names that a local one of another unit would hide, or overload."""
        return {name for line in self.lines if not line.lstrip().startswith("//") for name in USED.findall(line)}

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


@cache
def declares(header: Path) -> tuple:
    """Names at the start of a line of a header and of those that it includes: all of them, and those of variables."""
    names, values = set(), set()
    for line in header.read_text().splitlines():
        if match := LOCAL_VALUE.match(line):
            values.add(match[1])
        elif (match := LOCAL_TYPE.match(line)) or not line.startswith((" ", "#", "/", "}", "template", "return")) and (match := LOCAL_FUNCTION.match(line)):
            names.add(match[1] or match[match.lastindex])
    inner = [declares(path) for path in own_headers(Source(header, header.read_text().splitlines()))]
    return frozenset(names | values).union(*(one[0] for one in inner)), frozenset(values).union(*(one[1] for one in inner))


def own_headers(unit: Source) -> list:
    """The headers of ours that it includes: beside it, or what tests support each other with."""
    folders = unit.path.parent, unit.path.parent.parent / "support"
    found = (match[2] for line in unit.lines if (match := INCLUDE.match(line)) and match[1] == '"')
    return [path for name in found if (path := next((folder / name for folder in folders if (folder / name).exists()), None))]


def in_the_way(unit: Source, other: Source) -> bool:
    """Whether a header that the one includes, and the other does not, declares what the other does."""
    for header in set(own_headers(unit)) - set(own_headers(other)):
        names, values = declares(header)
        if names & other.locals() or values & other.declared():
            return True
    return False


@dataclass
class Text:
    units: list = field(default_factory=list)
    names: set = field(default_factory=set)
    values: set = field(default_factory=set)
    declared: set = field(default_factory=set)
    used: set = field(default_factory=set)

    def size(self) -> int:
        return sum(len(unit.lines) for unit in self.units)

    def takes(self, unit: Source) -> bool:
        """Whether no name is in the way."""
        if not unit.of and any(in_the_way(unit, other) or in_the_way(other, unit) for other in self.units):
            return False
        return not (self.names & (unit.locals() | unit.used()) or self.used & unit.locals()
                    or self.values & unit.declared() or self.declared & unit.values())

    def add(self, unit: Source) -> None:
        self.units.append(unit)
        self.names |= unit.locals()
        self.values |= unit.values()
        self.declared |= unit.declared()
        self.used |= unit.used()


def read_source(path: Path) -> Source:
    lines = path.read_text().splitlines()
    named = next((match for line in lines if (match := MODULE.match(line))), None)
    return Source(path, lines, named[2], named[3] or "", bool(named[1])) if named else Source(path, lines)


def partitions_of(unit: Source) -> dict:
    """The partitions that it imports, and whether it exports them again."""
    return {match[2]: bool(match[1]) for line in unit.lines if (match := PARTITION.match(line))}


def one_interface(units: list) -> list:
    """Of a module's interface units those that are one text: the primary one and what it reaches, each behind what it imports."""
    named = {unit.partition: unit for unit in units if unit.partition}
    ordered: dict = {}

    def visit(unit: Source, above: tuple = ()) -> None:
        if unit.partition in above:
            raise SystemExit(f"{unit.path}: partitions import each other: {' '.join([*above, unit.partition])}")
        for name in partitions_of(unit):
            if name in named and name not in ordered:
                visit(named[name], (*above, unit.partition))
        ordered[unit.partition] = unit

    for unit in units:
        if unit.exported:
            visit(unit)
    return list(ordered.values())


def without_partitions(unit: Source, interface: list) -> Source:
    """The unit as it sees a module whose interface is one text: imports of what is in that go, line by line. A partition beside it imports
    the module in their place; implementation units do so without a word."""
    there = {other.partition for other in interface}
    lines, wanted = [], f"import {interface[-1].exported};" if unit.partition and unit.partition not in there else ""
    for line in unit.lines:
        match = PARTITION.match(line)
        gone = match and match[2] in there
        lines.append(wanted if gone else line)
        wanted = "" if gone else wanted
    return replace(unit, lines=lines)


def texts_of(units: list, key, most: int) -> list:
    """Units of one key together, as far as their local names are different ones and the text has no more lines than `most`."""
    texts: dict = {}
    for unit in sorted(units, key=lambda unit: (-len(unit.lines), str(unit.path))):
        places = texts.setdefault(key(unit), [])
        place = next((text for text in places if text.size() + len(unit.lines) <= most and text.takes(unit)), None)
        if place is None:
            place = Text()
            places.append(place)
        place.add(unit)
    return [text for places in texts.values() for text in places]


def key_of(unit: Source) -> tuple:
    """What units that may go together have in common."""
    return (unit.module, frozenset(name for name in unit.headers() if not LIGHT.match(name))) if unit.module else ("",)


def hidden(unit: Source) -> Source:
    """A partition that exports nothing: for whoever imports the module it is not there."""
    return replace(unit, lines=[re.sub(r"^export (?!module)", "", line) for line in unit.lines])


def interface_text(interface: list) -> list:
    """The interface units in their order as the module's primary one, by lines, each with its unit's path and line."""
    exported = {"": True} | partitions_of(interface[-1])
    units = [unit if exported.get(unit.partition) else hidden(unit) for unit in interface]
    return united([without_partitions(unit, interface) for unit in units], interface[-1].declaration())


def joined(units: list) -> list:
    """The units as one text, by lines, each with the unit's path and line; without, it is the text's own."""
    units = sorted(units, key=lambda unit: "template <>" not in unit.lines)  # before what they specialise is used
    return united(units, units[0].declaration())


def united(units: list, declaration: str) -> list:
    head, imports, rest = [], [], []
    for unit in units:
        begins = unit.begins()
        for i, line in enumerate(unit.lines):
            where = (unit.path, i + 1)
            match = INCLUDE.match(line)
            if match and match[1] == '"' and (unit.path.parent / match[2]).exists():
                line = f'#include "{(unit.path.parent / match[2]).resolve()}"'
            if IMPORT.match(line):
                imports.append((line, where))
            elif i < begins:
                head += [(line, where)] if line.strip() and line != "module;" and not MODULE.match(line) and not line.startswith("//") else []
            else:
                rest.append((line, where))
        rest += [(f"#undef {match[1]}", None) for line in unit.lines if (match := re.match(r"#\s*define (\w+)", line))]
    if not declaration:
        return [*head, *imports, *rest]
    return [("module;", None), *once(head, INCLUDE), (declaration, None), *once(imports, IMPORT), *rest]


def once(lines: list, kind: re.Pattern) -> list:
    """The lines without those of a kind that are there before, unless a condition is upon them. An import that is exported goes before its like."""
    seen, kept, depth = set(), [], 0
    exported = {line.removeprefix("export ") for line, _ in lines if line.startswith("export ")}
    for line, where in lines:
        depth += line.startswith("#if") - line.startswith("#endif")
        if kind.match(line) and not depth:
            line = f"export {line}" if line in exported else line
            if line in seen:
                continue
            seen.add(line)
        kept.append((line, where))
    return kept


def told(lines: list, name=str) -> str:
    """The text, with #line wherever its lines do not go on; `name` is what a path is called there."""
    written, before = [], None
    for line, where in lines:
        if where and (not before or where[0] != before[0] or where[1] != before[1] + 1):
            written.append(f'#line {where[1]} "{name(where[0])}"')
        written.append(line)
        before = where
    return "\n".join(written) + "\n"


def members(text: Path) -> list:
    """Of which files a text was made; none: of another text."""
    with text.open() as file:
        first, second = file.readline(), file.readline()
    line = second if first.strip() == "module;" else first
    return [Path(path) for path in line.removeprefix("// together: ").strip().split("|")] if line.startswith("// together: ") else []


def places(text: Path) -> list:
    """Of each line of such a text on disk the path and line that it is from; None: it is the text's own."""
    found, where = [], None
    for line in text.read_text().splitlines():
        begins = re.match(r'#line (\d+) "(.*)"$', line)
        found.append(None if begins else where)
        if begins:
            where = (Path(begins[2]), int(begins[1]))
        elif where:
            where = (where[0], where[1] + 1)
    return found


def for_others(lines: list, module: str) -> str:
    """An interface's text as it is installed, where a path is MODULE/FILE. A header of ours is not there."""
    for line, where in lines:
        if line.startswith('#include "'):
            raise SystemExit(f"{where[0]}:{where[1]}: an interface unit that is installed includes a header that is not")
    return told(lines, lambda path: f"{module.replace('.', '/')}/{path.name}")


def put(out: Path, text: str) -> None:
    if not out.exists() or out.read_text() != text:  # else nothing is compiled again
        out.write_text(text)


def text_of(units: list, beside: list):
    """What the units are as one text, by lines; None: they do not go together."""
    interface = one_interface(beside)
    inside = {unit.path for unit in interface}
    if {unit.path for unit in units} == inside:
        return interface_text(interface)
    if units[0].path in {unit.path for unit in beside}:
        return joined([without_partitions(units[0], interface)]) if units[0].path not in inside and len(units) == 1 else None
    units = [without_partitions(unit, interface) for unit in units]
    return joined(units) if len(texts_of(units, key_of, sys.maxsize)) == 1 else None


def write(out: Path, paths: list, beside: list, installed: list) -> int:
    units, beside = ([read_source(path) for path in some] for some in (paths, beside))
    lines = text_of(units, beside)
    if lines is None:
        (out.parent / "stamp").touch()
        print(f"{out}: {', '.join(path.name for path in paths)} no longer go together: build again, then they are grouped anew", file=sys.stderr)
        return 1
    text = told(lines)
    note = "// together: " + "|".join(str(path) for path in paths)
    put(out, text.replace("module;\n", f"module;\n{note}\n", 1) if text.startswith("module;") else f"{note}\n{text}")
    for other in installed:
        put(other, for_others(lines, next(unit.exported for unit in units if unit.exported)))
    return 0


def group(most: int, paths: list, beside: list) -> int:
    beside = [read_source(path) for path in beside]
    interface = one_interface(beside)
    units = [without_partitions(read_source(path), interface) for path in paths]
    for text in texts_of(units, key_of, most):
        print("|".join(str(unit.path) for unit in text.units))
    return 0


def interfaces(paths: list) -> int:
    units = [read_source(path) for path in paths]
    inside = [unit.path for unit in one_interface(units)]
    print("|".join(str(path) for path in inside))
    for unit in units:
        if unit.path not in inside:
            print(unit.path)
    return 0


def main(words: list) -> int:
    parser = argparse.ArgumentParser(usage=__doc__)
    verbs = parser.add_subparsers(dest="verb", required=True)
    for verb, first in (("interfaces", None), ("group", int), ("write", Path)):
        one = verbs.add_parser(verb)
        if first:
            one.add_argument("first", type=first)
        one.add_argument("paths", nargs="+", type=Path)
        one.add_argument("--beside", nargs="*", type=Path, default=[])
        one.add_argument("--install", nargs=1, type=Path, default=[])
    given = parser.parse_args(words)
    if given.verb == "interfaces":
        return interfaces(given.paths)
    if given.verb == "group":
        return group(given.first, given.paths, given.beside)
    return write(given.first, given.paths, given.beside, given.install)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
