"""Units of one library compiled as one text. With modules most of what a unit costs is to read what it imports: several units read it once.

    python3 cmake/together.py group LINES FILE… [--beside INTERFACE…]     the files, a text of about so many lines a line, "a.cpp|b.cpp"
    python3 cmake/together.py write TEXT FILE… [--beside INTERFACE…]      writes the text; #line tells where each line is from

Units of a module go together if they import the same (what the module's own interface units import, all of its units see anyway), include
the same headers of other libraries and of our own, and have no local name in each other's way: so each of them still compiles by itself. Headers of the
standard library are another matter (tests/includes/check_includes.py). Units of no module, which are those of tests and programs, may
import what they like. Where `write` finds that units no longer go together it fails, after it has touched the stamp beside the text that CMake
watches: the next build groups them anew.
"""
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

MODULE = re.compile(r"^(export )?module (camber[\w.]*)(:\w+)?;")
IMPORT = re.compile(r"^(?:export )?import ")
INCLUDE = re.compile(r'^#include ([<"])([^>"]+)[>"]')
LOCAL_TYPE = re.compile(r"^(?:template <[^>]*>\s*)?(?:(?:struct|class|enum class|enum|union|concept)\s+(\w+)\b(?!\s*;)|using (\w+) =)")
LOCAL_VALUE = re.compile(r"^(?:static |inline |constexpr |const )+[\w:<>, ]+?\s(\w+)(?:\[\w*\])?(?:\s*=|\{|;)")
INSTANTIATED = re.compile(r"^\s*template (?:class (\w+)<|[^<(].*?\s(\w+)<\w+>::)")  # a class, or a member of it: not both in one text
DECLARED = re.compile(r"[\w>&*\]] [&*]?(\w+)\s*(?=[=;,){\[:])")  # a variable or a parameter, perhaps
USED = re.compile(r"(?<![\w.>:])(\w+)\s*(?=[(<{])")  # a function or a type, perhaps; `a.b(`, `a->b(` and `a::b(` are looked up elsewhere
LOCAL_FUNCTION = re.compile(r"^[\w\[\]:<>,*& ]+?[\s*&](\w+)\(")


@dataclass
class Source:
    path: Path
    lines: list
    module: str  # of an implementation unit; empty: of another unit
    exported: str  # of a module's primary interface unit; empty: of another unit

    def begins(self) -> int:
        """The line after the head: after `module NAME;`, or the first that is no comment or directive (headers behind imports want them)."""
        if self.module:
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
    named = [match for line in lines if (match := MODULE.match(line))]
    module = named[0][2] if named and not named[0][1] and not named[0][3] else ""
    exported = named[0][2] if named and named[0][1] and not named[0][3] else ""
    return Source(path, lines, module, exported)


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


def key_of(beside: list):
    """What units that may go together have in common."""
    seen = frozenset(line for source in beside for line in source.imports())
    return lambda unit: (unit.module, unit.imports() - seen if unit.module else None, unit.headers())


def joined(units: list) -> list:
    """The units as one text, by lines, each with the unit's path and line; without, it is the text's own."""
    head, imports, rest = [], [], []
    for unit in sorted(units, key=lambda unit: "template <>" not in unit.lines):  # before what they specialise is used
        begins = unit.begins()
        for i, line in enumerate(unit.lines):
            where = (unit.path, i + 1)
            if IMPORT.match(line):
                imports.append((line, where))
            elif i < begins:
                match = INCLUDE.match(line)
                if match and match[1] == '"' and (unit.path.parent / match[2]).exists():
                    line = f'#include "{(unit.path.parent / match[2]).resolve()}"'
                head += [(line, where)] if line.strip() and line != "module;" and not MODULE.match(line) and not line.startswith("//") else []
            else:
                rest.append((line, where))
        rest += [(f"#undef {match[1]}", None) for line in unit.lines if (match := re.match(r"#\s*define (\w+)", line))]
    module = units[0].module
    named = [(f"module {module};", None)] if module else []
    return [*([("module;", None)] if module else []), *head, *named, *imports, *rest]


def told(lines: list) -> str:
    """The text, with #line wherever its lines do not go on."""
    written, before = [], None
    for line, where in lines:
        if where and (not before or where[0] != before[0] or where[1] != before[1] + 1):
            written.append(f'#line {where[1]} "{where[0]}"')
        written.append(line)
        before = where
    return "\n".join(written) + "\n"


def members(text: Path) -> list:
    """Of which files a text was made; none: of another text."""
    with text.open() as file:
        first, second = file.readline(), file.readline()
    line = second if first.strip() == "module;" else first
    return [Path(path) for path in line.removeprefix("// together: ").strip().split("|")] if line.startswith("// together: ") else []


def write(out: Path, paths: list, beside: list) -> int:
    units = [read_source(path) for path in paths]
    if len(texts_of(units, key_of([read_source(path) for path in beside]), sys.maxsize)) > 1:
        (out.parent / "stamp").touch()
        print(f"{out}: {', '.join(path.name for path in paths)} no longer go together: build again, then they are grouped anew", file=sys.stderr)
        return 1
    text = told(joined(units))
    note = "// together: " + "|".join(str(path) for path in paths)
    text = text.replace("module;\n", f"module;\n{note}\n", 1) if text.startswith("module;") else f"{note}\n{text}"
    if not out.exists() or out.read_text() != text:  # else nothing is compiled again
        out.write_text(text)
    return 0


def group(most: int, paths: list, beside: list) -> int:
    for text in texts_of([read_source(path) for path in paths], key_of([read_source(path) for path in beside]), most):
        print("|".join(str(unit.path) for unit in text.units))
    return 0


def main(words: list) -> int:
    if len(words) < 3 or words[0] not in ("group", "write"):
        print(__doc__, file=sys.stderr)
        return 2
    cut = words.index("--beside") if "--beside" in words else len(words)
    paths, beside = [Path(word) for word in words[2:cut]], [Path(word) for word in words[cut + 1:]]
    return group(int(words[1]), paths, beside) if words[0] == "group" else write(Path(words[1]), paths, beside)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
