"""Lists functions, constructors and lambdas with more than six parameters.

    python3 tests/lint/parameters.py      sources of modules/ and apps/; exit code 1: a function that parameters.txt does not list

Parameters that belong together become a struct. clang-tidy (readability-function-size) reports neither declarations nor lambdas nor
constructors with an empty body, so it cannot replace this script. Function declarations count in namespaces and types, lambdas everywhere.
Commas in template arguments, default arguments and function types separate no parameters. Macros are not read.
"""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "includes"))
from check_includes import NOISE  # noqa: E402

LIMIT = 6
ALLOWED = {name for line in Path(__file__).with_suffix(".txt").read_text().splitlines() if line[:1] != "#" for name in line.split()}
DIRECTIVE = re.compile(r"^[ \t]*#(?:\\\n|[^\n])*|^(?:export )?(?:import|module)\b[^;\n]*;", re.M)
TOKEN = re.compile(r"\w+|::|->|<=>|[<>=!]=|&&|\|\||\S")
CLOSE = {"(": ")", "[": "]", "{": "}"}
NOT_FUNCTIONS = set("requires decltype noexcept explicit alignas __attribute__ static_assert".split())
SCOPES = set("namespace struct class union extern".split())


class Tokens:
    """The tokens of a source, and the index of the closing bracket of each opening one."""
    def __init__(self, text):
        self.text = DIRECTIVE.sub(blank, NOISE.sub(blank, text))
        matches = list(TOKEN.finditer(self.text))
        self.words, self.starts = [m[0] for m in matches], [m.start() for m in matches]
        self.close, open_ones = {}, []
        for at, word in enumerate(self.words):
            if word in CLOSE:
                open_ones.append(at)
            elif open_ones and word == CLOSE[self.words[open_ones[-1]]]:
                self.close[open_ones.pop()] = at

    def __getitem__(self, at):
        return self.words[at] if 0 <= at < len(self.words) else ""

    def line(self, at):
        return self.text.count("\n", 0, self.starts[at]) + 1

    def after_angles(self, at, end):
        """The index after the ">" that closes the "<" at `at`; nothing if that is a comparison."""
        depth = 0
        while at < end and self[at] not in (";", "&&", "||") or depth > 1 and at < end and self[at] == "&&":
            depth += (self[at] == "<") - (self[at] == ">")
            at = self.close.get(at, at) + 1
            if depth == 0:
                return at
        return None


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


def parameters(tokens, at):
    """The number of parameters in the brackets that open at `at`."""
    end, count, is_default = tokens.close.get(at, at), 0, False
    at += 1
    count = 1 if at < end else 0
    while at < end:
        word = tokens[at]
        after = tokens.after_angles(at, end) if word == "<" else None
        if after and (not is_default or tokens[after] in ("(", "{", "::", ",", ")")):
            at = after
            continue
        if word == ",":
            count, is_default = count + 1, False
        is_default = is_default or word == "="
        at = tokens.close.get(at, at) + 1
    return count


def lambdas(tokens):
    """The opening brackets of the parameters of lambdas."""
    for at, closed in tokens.close.items():
        before = tokens[at - 1]
        is_value = re.fullmatch(r"\w+|[)\]>]", before) and before not in ("return", "co_return", "co_yield", "else", "do")
        if tokens[at] == "[" and tokens[at + 1] != "[" and not is_value:
            after = closed + 1
            if tokens[after] == "<":
                after = tokens.after_angles(after, len(tokens.words)) or after
            if tokens[after] == "(":
                yield after, "lambda"


def functions(tokens):
    """The opening brackets of the parameters of functions that namespaces and types declare, with the functions' names."""
    yield from scope(tokens, 0, len(tokens.words))
    for at, word in enumerate(tokens.words):  # types in functions
        if word in ("struct", "class") and tokens[at - 1] in (";", "{", "}") and is_in_function(tokens, at):
            while at < len(tokens.words) and tokens[at] not in ("{", ";", "("):
                at += 1
            if tokens[at] == "{":
                yield from scope(tokens, at + 1, tokens.close.get(at, at))


def is_in_function(tokens, at):
    """True if a bracket around `at` opens the body of a function."""
    around = [opened for opened, closed in tokens.close.items() if opened < at < closed and tokens[opened] == "{"]
    return any(tokens[opened - 1] in (")", "const", "noexcept", "override", "mutable", ">", "&") for opened in around)


def scope(tokens, at, end):
    while at < end:
        if tokens[at] in ("public", "private", "protected") and tokens[at + 1] == ":":
            at += 2
            continue
        found, body, at = statement(tokens, at, end)
        if found:
            yield found
        elif body:
            yield from scope(tokens, body + 1, tokens.close[body])


def statement(tokens, at, end):
    """The parameters that a declaration has, the "{" of the namespace or type that it opens, and the index after it."""
    start, found, is_scope, is_value = at, None, False, False
    while at < end:
        word = tokens[at]
        after = tokens.after_angles(at, end) if word == "<" and not found and not is_value and tokens[at - 1] != "operator" else None
        if after:
            at = after
            continue
        if word == ";":
            return found, None, at + 1
        if word == "(" and not found and not is_value:
            name = name_before(tokens, at, start)
            if name and name.isupper() and at - 1 == start:  # a macro
                return None, None, tokens.close.get(at, at) + 1
            if name == "operator" and tokens[at + 1] == ")":
                at += 2
                name = "operator()"
            found = (at, name) if name else None
        if word == "{" and at in tokens.close:
            after = tokens.close[at] + 1
            if not found and is_scope:
                return None, at, after
            if tokens[after] not in (",", "{", ";", ")"):
                return found, None, after
        is_scope = is_scope or word in SCOPES
        is_value = is_value or word == "=" and tokens[at - 1] != "operator" and not found
        at = tokens.close.get(at, at) + 1
    return found, None, end


def name_before(tokens, at, start):
    """The name of the function whose parameters open at `at`, or "" if the brackets hold something else."""
    name = tokens[at - 1]
    if "operator" in tokens.words[max(start, at - 4):at]:
        return "operator"
    return name if re.fullmatch(r"[A-Za-z_]\w*|>", name) and name not in NOT_FUNCTIONS else ""


def excessive(text):
    """Rows (line, name, number of parameters)."""
    tokens = Tokens(text)
    rows = {(tokens.line(at), name, parameters(tokens, at)) for found in (functions, lambdas) for at, name in found(tokens)}
    return sorted(row for row in rows if row[2] > LIMIT)


def main():
    files = sorted(p for folder in ("modules", "apps") for p in (ROOT / folder).rglob("*") if p.suffix in (".cpp", ".cppm", ".hpp", ".h"))
    rows = [(path.relative_to(ROOT).as_posix(), *row) for path in files for row in excessive(path.read_text())]
    bad = [f"{path}:{line}: {name} has {count} parameters; the limit is {LIMIT}"
           for path, line, name, count in rows if f"{path}:{name}" not in ALLOWED]
    bad += [f"parameters.txt: {name} has no more than {LIMIT} parameters, or does not exist"
            for name in sorted(ALLOWED - {f"{path}:{name}" for path, _, name, _ in rows})]
    print("\n".join(bad), end="\n" if bad else "")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
