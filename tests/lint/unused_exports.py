"""Lists names that module interfaces export and the program does not use.

    python3 tests/lint/unused_exports.py [--all]      exit code 1: a name that unused_exports.txt does not list

The names are functions, types, constants, aliases, and public member functions and static members of types. The program uses a name if code
reaches it from `main`, from the C and Python interfaces or from code without a name. A name that only unused functions mention is unused.
Declarations, definitions, explicit instantiations and a function's own body are not uses. For each unused name the table lists the code that
reaches it: tests, bench, examples (with example.cpp of modules), or nothing. `--all` adds the names of unused_exports.txt.

The script compares spellings and resolves no scopes: names with the same spelling in two modules count as one. So the table can lack names.
"""
import re
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "includes"))
from check_includes import NOISE  # noqa: E402

ALLOWED = {name for line in Path(__file__).with_suffix(".txt").read_text().splitlines() if line[:1] != "#" for name in line.split()}

PROGRAM = ("modules", "apps/camber", "apps/mpi")
OTHER_LANGUAGES = ("apps/c", "apps/python", "apps/page")
CALLERS = ("tests", "bench", "examples")
# Names that the language and the standard library call.
HOOKS = set("main hash begin end get what rebind allocate deallocate construct overflow underflow sync xsputn".split())
NOT_FUNCTIONS = set("requires decltype noexcept explicit alignas __attribute__ if for while return".split())
WORD = re.compile(r"(?:\.|->)?(?<![\w'])[A-Za-z_]\w*(?:\s*[(<])?")
LOCAL = re.compile(r"(?:[\w>&*\]]\s+|[&*])(?<!return )(\w+)(?=\s*[=;,:){])")
DIRECTIVE = re.compile(r"^[ \t]*#(?:\\\n|[^\n])*|^(?:export )?(?:import|module)\b[^;\n]*;", re.M)
MACRO = re.compile(r"\s*#\s*define\s+\w+(?:\([^)]*\))?")
ACCESS = re.compile(r"\s*(public|protected|private)\s*:(?!:)")
BRACKET = re.compile(r"[({\[;]")
CONTINUES = re.compile(r"\s*[;,{(.=+*/?|&<-]")
SPACE = re.compile(r"\s*(?:export\s+)?(?:(?:inline\s+)?namespace\b[^={]*|extern\s*|){")
TYPE = re.compile(r"\b(struct|class|union|enum)\s+(?:(?:class|struct)\s+)?(?:\[\]\s*|alignas\(\)\s*)*([\w:]+)")
FUNCTION = re.compile(r"([\w:~]+)\s*\(\)")
VARIABLE = re.compile(r"(\w+)\s*(?:\[\]\s*)*(?:=|\{|;|,)")


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


def plain(path):
    return DIRECTIVE.sub(blank, NOISE.sub(blank, path.read_text()))


def words(text):
    """Names in the text of a declaration, without local variables unless they are called; ".name" after an object."""
    found = set(WORD.findall(text))
    called = {word.rstrip("(< \n") for word in found if word[-1] in "(<"}
    return {word.replace("->", ".") for word in called | found - set(LOCAL.findall(text)) if word[-1] not in "(<"}


class Names:
    """The names of the program's sources, and the words that each of them uses."""
    def __init__(self):
        self.uses, self.members = defaultdict(set), set()
        self.roots, self.exports = set(HOOKS), []  # names that are used; rows (path, line, name, kind)

    def reached(self, roots):
        done, todo = set(), list(roots)
        while todo:
            name = todo.pop()
            name = name[1:] if name[0] == "." and name[1:] in self.members else name
            if name not in done:
                done.add(name)
                todo.extend(self.uses.get(name, ()))
        return done


class Source:
    def __init__(self, names, path):
        self.names, self.path, self.close, open_ones = names, path, {}, []
        self.text = DIRECTIVE.sub(self.directive, NOISE.sub(blank, path.read_text()))
        for match in re.finditer(r"[(){}\[\]]", self.text):
            if match[0] in "([{":
                open_ones.append(match.start())
            elif open_ones:
                self.close[open_ones.pop()] = match.start()
        self.names.roots |= words(self.block(0, len(self.text), "", False))

    def directive(self, match):
        """Explicit instantiations in a macro remain as text. All words of other macros are used."""
        head = MACRO.match(match[0])
        body = match[0][head.end():] if head else ""
        if re.match(r"[\s\\]*(extern\s+)?template\b", body):
            return " " * head.end() + body.replace("\\\n", " \n")
        self.names.roots |= words(body)
        return blank(match)

    def block(self, at, end, owner, exported):
        """Reads the declarations of a namespace or type; returns the text of those without a name."""
        public, rest = True, []
        while at < end:
            if access := ACCESS.match(self.text, at):
                public, at = access[1] == "public", access.end()
                continue
            start = at
            head, body, at = self.statement(at, end)
            rest.append(self.declaration(start, at, head, body, owner, exported and public))
        return "\n".join(rest)

    def statement(self, at, end):
        """The next statement: its text with empty brackets and without template arguments, its last braces, and its end."""
        head, body = "", None
        while match := BRACKET.search(self.text, at, end):
            head, at = head + self.text[at:match.end()], match.end()
            if match[0] == ";":
                break
            close = self.close.get(match.start(), end - 1)
            head, at = head + self.text[close], close + 1
            if match[0] == "{":
                body = match.end(), close
                if SPACE.match(head) or not CONTINUES.match(self.text, at):
                    break
        else:
            return head, body, end
        head = head.replace("->", " ")
        while (shorter := re.sub(r"<[^<>]*>", " ", head)) != head:
            head = shorter
        return head, body, at

    def declaration(self, start, end, head, body, owner, exported):
        """Records the names of a statement; returns its text if it has none."""
        text = self.text[start:end]
        exported = exported or re.match(r"\s*export\b", head) is not None
        if SPACE.match(head) and body:
            return self.block(*body, owner, exported)
        kind, found = named(head)
        if kind == "type" and body:
            text = self.text[start:body[0]] + self.block(*body, found[0], exported) + self.text[body[1]:end]
        if kind == "operator" and not owner:  # the program uses it if it uses the type of a parameter
            found = [word for word in words(text[text.find("("):text.find("{")]) if word[0].isupper()]
        hidden = kind == "operator" or found == [owner] or re.search(r"\b(friend|override)\b", head)
        if not found or owner and (hidden or kind == "constant" and not re.search(r"\bstatic\b", head)):
            return text
        self.names.members |= set(found) if owner else set()
        for name in found:
            self.names.uses[name] |= words(text) - {name, "." + name}
            if exported and not hidden and self.path.suffix == ".cppm":
                line = self.text.count("\n", 0, start + re.search(rf"\b{name}\b", self.text[start:end]).start()) + 1
                self.names.exports.append((self.path, line, f"{owner}::{name}" if owner else name, kind))
        return ""


def named(head):
    """The kind and names of a declaration."""
    if re.search(r"\boperator\b", head):
        return "operator", []
    if match := re.search(r"\b(?:using|concept)\s+(\w+)\s*=", head):
        return "alias", [match[1]]
    function = next((m for m in FUNCTION.finditer(head) if m[1] not in NOT_FUNCTIONS), None)
    value = re.search(r"=|\{", head)
    if (match := TYPE.search(head)) and (value or not function):
        return "type", [match[2].split("::")[-1]]
    if function and not (value and value.start() < function.start()):
        is_macro = not head[:function.start()].strip() and function[1].isupper()
        return "function", [] if is_macro else [function[1].split("::")[-1].lstrip("~")]
    if re.match(r"\s*(export\s+)?(using|static_assert)\b", head):
        return "", []
    return "constant", [match[1] for match in VARIABLE.finditer(re.sub(r"=[^,;]*", "=", head.replace("{}", "{")))]


def unused(root):
    """Rows (module, file:line, name, kind, callers) of the unused names of the sources below `root`."""
    names, callers = Names(), {caller: set() for caller in CALLERS}
    for folder in PROGRAM + OTHER_LANGUAGES + CALLERS:
        for path in sorted(p for p in (root / folder).rglob("*") if p.suffix in (".cpp", ".cppm", ".hpp", ".h", ".c")):
            if folder in PROGRAM and path.name != "example.cpp":
                Source(names, path)
            else:
                callers.get("examples" if folder in PROGRAM else folder, names.roots).update(words(plain(path)))
    used, by = names.reached(names.roots), {caller: names.reached(some) for caller, some in callers.items()}
    rows = {}
    for path, line, name, kind in names.exports:
        word, where = name.split("::")[-1], path.relative_to(root).as_posix()
        module, reach = where.split("/")[1], [caller for caller in CALLERS if word in by[caller]]
        if word not in used:
            rows.setdefault((module, name), (module, f"{where}:{line}", name, kind, " ".join(reach) or "nothing"))
    return list(rows.values())


def main(arguments):
    rows, bad = unused(ROOT), 0
    for module, where, name, kind, callers in rows:
        allowed = callers != "nothing" and f"{module}:{name}" in ALLOWED
        bad += not allowed
        if not allowed or "--all" in arguments:
            print(f"{module:16}{where:48}{kind:9} {name:34} {callers:21} {'allowed' if allowed else ''}".rstrip())
    for name in sorted(ALLOWED - {f"{row[0]}:{row[2]}" for row in rows}):
        bad += 1
        print(f"unused_exports.txt: {name}: the program uses it, or it does not exist")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
