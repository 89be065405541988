"""Does each unit of a module import the partitions and modules of the names that it uses, and include the headers of other libraries? Where
several units are compiled as one text (cmake/Together.cmake) no compiler says so, and a build with -DCAMBER_TOGETHER=OFF would break.

    python3 tests/includes/check_imports.py        exit code 1: something is missing, or is defined twice in a module

Names are looked for in the text: types, and functions that are called, which only units declare that this one does not see, in its own
module or in those that its module imports. A name that is declared in several places, one of which it sees, passes.
"""
import re
import sys
from collections import defaultdict
from pathlib import Path

from check_includes import NOISE, ROOT

sys.path.insert(0, str(ROOT / "cmake"))
import together  # noqa: E402

OTHER = re.compile(r"^(?:export )?import (camber\.\w+);")
TYPE = re.compile(r"^(?:struct|class|enum class|enum|concept|using) (\w+)")
SPACE = re.compile(r"^namespace camber::(\w+)")
FUNCTION = re.compile(r"^(?![#/}]|return|namespace|export |template|import|module)[\w\[\]:<>,*& ]+?[\s*&](\w+)\(")
NAMESPACE = re.compile(r"^(?:export )?namespace ([\w:]+) \{")
DEFINED = re.compile(r"^(?:export )?(?:inline constexpr [\w:<>,*& ]+?[\s*&](\w+)(?:\[\w*\])? ?[={]|(?:struct|class|enum class|concept) (\w+) (?:[:={]|final\b))")
USED = re.compile(r"(?:(?<![\w.>:~])|(?<=[a-z]::))(?:([A-Z]\w*)|(?!sizeof|operator|static_assert|camber\b|std\b)(\w+)(?=[(<]|::))")
OWN = re.compile(r"[\w\]>][>&*]*(?<!return)(?<!throw)(?<!else)(?<!case)(?<!requires) (\w+)\s*(?=[=;,){(\[]|:(?!:))|, (\w+) =")
PARAMETER = re.compile(r"(?:class|typename|auto|int)(?:[.]{3})? (\w+)")
LIBRARIES = {"fmt": "fmt/", "nlohmann": "nlohmann/", "CLI": "CLI/", "ranges": "range/"}  # by namespace: where their headers are
BESIDE = {"model_of", "words"}  # found beside an argument's type, by concepts


def plain(path: Path) -> str:
    """Without comments, literals and names of the standard library."""
    text = NOISE.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), path.read_text())
    return re.sub(r"\bstd(::\w+)+", "std", text)


def declared(text: str) -> set:
    """Names at namespace scope, and of namespaces, where nothing is indented."""
    lines = (re.sub(r"^(?:export |template <[^>]*> )+", "", line) for line in text.splitlines())
    return {match[1] for line in lines if (match := TYPE.match(line) or together.LOCAL_VALUE.match(line) or FUNCTION.match(line) or SPACE.match(line))}


def own(text: str) -> set:
    """Names that the unit gives to members, parameters and variables itself."""
    bound = (names for taken in re.findall(r"auto&* \[([\w, ]+)\]", text) for names in taken.split(", "))
    return {*(name for names in OWN.findall(text) for name in names), *PARAMETER.findall(text), *bound}


def seen_by(unit: together.Source, units: dict) -> tuple:
    """The units and the other modules that it sees: a partition brings its own imports."""
    seen, modules, left = set(), set(), [unit]
    while left:
        source = left.pop()
        if source.path in seen:
            continue
        seen.add(source.path)
        modules |= {match[1] for line in source.lines if (match := OTHER.match(line))}
        left += [units[source.of, name] for name in together.partitions_of(source) if (source.of, name) in units]
    return seen, modules


def sees(unit: together.Source, units: dict) -> tuple:
    """What the text of a unit sees: an implementation unit its module's interface, too."""
    seen, modules = seen_by(unit, units)
    if unit.module:
        paths, others = seen_by(units[unit.of, ""], units)
        seen, modules = seen | paths, modules | others
    return seen, modules


def libraries(unit: together.Source, text: str) -> list:
    """What the unit uses of libraries whose headers it does not include, as `missing` says it."""
    included = unit.headers()
    for path in together.own_headers(unit):
        included |= together.read_source(path).headers()
    uses = ((space, re.search(rf"(?<![\w:]){space}::", text)) for space, folder in LIBRARIES.items()
            if not any(name.startswith(folder) for name in included))
    return [(unit.path, text.count("\n", 0, match.start()) + 1, space, []) for space, match in uses if match]


def missing(paths: list) -> list:
    """[(unit, line, name, the units that declare it)], the first use of each name."""
    sources = [unit for unit in map(together.read_source, paths) if unit.of]
    units = {(unit.of, unit.partition): unit for unit in sources if not unit.module}
    texts = {unit.path: plain(unit.path) for unit in sources}
    owners, united = defaultdict(set), defaultdict(set)  # of a name; of a module: what it imports, and itself
    for unit in sources:
        united[unit.of] |= {unit.of, *seen_by(unit, units)[1]}
    for unit in units.values():
        for name in declared(texts[unit.path]):
            owners[name].add((unit.of, unit.path))
    found = []
    for unit in sources:
        text = texts[unit.path]
        seen, modules = sees(unit, units)
        passed = own(text) | declared(text) | BESIDE
        for match in USED.finditer(text):
            name = match[1] or match[2]
            given = {(of, path) for of, path in owners[name] if of in united[unit.of]}
            if name not in passed and given and not any(path in seen or of in modules for of, path in given):
                found.append((unit.path, text.count("\n", 0, match.start()) + 1, name, sorted(path for _, path in given)))
            passed.add(name)
        found += libraries(unit, text)
    return found


def twice(paths: list) -> list:
    """Names that two interface units of a module define in one namespace: where units are compiled together the wrong one may be taken, and no
    compiler says so."""
    defined = defaultdict(set)
    for path in paths:
        unit = together.read_source(path)
        if not unit.partition:
            continue
        space = ""
        for line in plain(path).splitlines():
            space = (NAMESPACE.match(line) or {1: space})[1]
            if name := DEFINED.match(line):
                defined[(unit.of, space, name[1] or name[2])].add(path)
    return [(name, sorted(of)) for (_, _, name), of in sorted(defined.items()) if len(of) > 1]


def main() -> int:
    found = missing(sorted(path for folder in ("modules", "apps") for path in (ROOT / folder).rglob("*.cpp*")))
    for path, line, name, needed in found:
        where = " or ".join(str(one.relative_to(ROOT)) for one in needed)
        print(f"{path.relative_to(ROOT)}:{line}: {name} needs " + (f"an import of what is in {where}" if needed else "its header"))
    again = twice(sorted(path for folder in ("modules", "apps") for path in (ROOT / folder).rglob("*.cppm")))
    for name, paths in again:
        print(f"{name} is defined by several units of a module: " + ", ".join(str(path.relative_to(ROOT)) for path in paths))
    return 1 if found or again else 0


if __name__ == "__main__":
    sys.exit(main())
