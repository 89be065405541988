"""Counts habits of unclear prose in the comments and messages of modules/ and apps/, and compares them with limits.

    python3 tests/lint/prose.py [FOLDER…]      a row for each folder, then each habit: file:line: phrase: sentence

The rules are in CONTRIBUTING.md, "Language". A habit is a phrase that readers of English as a second language have to read twice: a sentence
that begins with a relative clause, a vague passive ("is told", "is asked"), a pronoun without a referent. Messages are string literals of at
least four words. Exit code 1: a folder has more than LIMIT habits for each 1 000 words, a comment begins with a word of STARTS, or
doc comments have more than MAX_WORDS words.
"""
import bisect
import re
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

LIMIT = 3  # habits for each 1 000 words
MAX_WORDS = 90_000  # of all doc comments
STARTS = ("What", "Of", "Whether", "Those")
HABITS = re.compile("|".join((
    r"(?:^|(?<=[.;:] ))(?:What|Of|Whether|Those|Which|So many|So much|Where|How|As|By)\b(?! is the\b| to use\b| an? example\b)",
    r"\b(?:is|are|was|were|be|been) (?:told|said|asked|given|wanted|looked for|gone through|had)\b",
    r"\btell(?:s|ing)?\b|\btold\b",
    r"\b(?:whoever|nobody|somebody|whichever|whatever)\b",
    r"\b(?:wish(?:es|ed)?|wanted)\b",
    r"\b(?:as it is|as they are|as it was|of its own|of their own|of itself|by itself|by themselves)\b",
    r"\bin (?:nobody's|its) way\b",
    r"\b(?:goes|go|went|gone|comes|come|came) (?:along|home|back|of it|out of)\b",
    r"\bwhat (?:is|it|they|was|are|the|a|has|comes|becomes|goes|lies|stays)\b",
    r"\b(?:stands|lies) (?:there|here|beside|behind)\b",
)))
# Strings, characters and comments; digits may contain an apostrophe.
TOKEN = re.compile(r'(?P<raw>R"(?P<d>[^()\\\s]{0,16})\(.*?\)(?P=d)")|(?P<string>"(?:\\.|[^"\\\n])*")|(?<!\w)\'(?:\\.|[^\'\\\n])+\'|'
                   r"(?P<comment>//[^\n]*)|(?P<block>/\*.*?\*/)", re.S)
MACHINE = re.compile(r"NOLINT|clang-format|^\s*//\s*namespace\b|^-{3,}")


@dataclass
class Text:
    line: int
    words: str
    kind: str  # "doc", "comment" or "message"


def texts(source):
    """The comments and messages of a C++ source: lines of one comment are joined, and so are adjacent string literals."""
    starts = [0] + [m.end() for m in re.finditer("\n", source)]
    found, end = [], 0
    for match in TOKEN.finditer(source):
        line = bisect.bisect_right(starts, match.start())
        between = source[end:match.start()]
        if match["comment"] is not None:
            doc = match[0].startswith("///")
            words, kind = re.sub(r"^//[/<]*\s?", "", match[0]).strip(), "doc" if doc else "comment"
            alone = not source[starts[line - 1]:match.start()].strip()
            joins = alone and words and not re.match(r"[-*] |\d\. ", words)
        elif match["block"] is not None:
            words, kind, joins = " ".join(re.sub(r"^/\*+|\*/$|^\s*\*", "", match[0], flags=re.M).split()), "comment", False
        elif match["string"] is not None:
            words, kind, joins = match["string"][1:-1].replace(r"\"", '"').replace(r"\n", "\n"), "message", True
        else:
            continue
        if joins and found and found[-1].kind == kind and not between.strip() and (kind == "message" or between.count("\n") == 1):
            found[-1].words += words if kind == "message" else " " + words
        else:
            found.append(Text(line, words, kind))
        end = match.end()
    return [t for t in found if not MACHINE.search(t.words) and (t.kind != "message" or len(re.findall(r"[A-Za-z]{2,}", t.words)) > 3 and " " in t.words)]


def sentences(text):
    text = re.sub(r"`[^`]*`", "x", text) if text.count("`") % 2 == 0 else text
    return [" ".join(s.split()) for s in re.split(r"(?<=[.!?])\s+(?=[A-Z0-9\"(])|\n", text) if len(s.split()) > 2]


@dataclass
class Count:
    doc_words: int = 0
    words: int = 0
    findings: list = None

    def add(self, path, source):
        for text in texts(source):
            first = text.words.split(" ", 1)[0].rstrip(":,")
            if text.kind != "message" and first in STARTS:
                self.findings.append((path, text.line, f"begins with {first}", text.words))
            for sentence in sentences(text.words):
                number = len(sentence.split())
                self.words += number
                self.doc_words += number if text.kind == "doc" else 0
                self.findings += [(path, text.line, match[0].strip(), sentence) for match in HABITS.finditer(sentence)]


def count(paths):
    counted = Count(findings=[])
    for path in paths:
        counted.add(path.relative_to(ROOT), path.read_text(encoding="utf-8"))
    return counted


def sources(folder):
    return sorted(p for p in folder.rglob("*") if p.suffix in (".cpp", ".cppm", ".hpp", ".h"))


def folders():
    return [f for top in ("modules", "apps") for f in sorted((ROOT / top).iterdir()) if f.is_dir() and sources(f)]


def main(arguments):
    chosen = [Path(a).resolve() for a in arguments] or folders()
    wrong, doc_words = [], 0
    print(f"{'doc words':>9} {'words':>7} {'habits':>6} {'/1 000':>6}  folder")
    for folder in chosen:
        found = count(sources(folder))
        doc_words += found.doc_words
        rate = 1000 * len(found.findings) / max(found.words, 1)
        print(f"{found.doc_words:>9} {found.words:>7} {len(found.findings):>6} {rate:>6.1f}  {folder.relative_to(ROOT)}")
        starts = [f for f in found.findings if f[2].startswith("begins with ")]
        wrong += found.findings if rate > LIMIT or arguments else starts
    for path, line, phrase, sentence in wrong:
        print(f"{path}:{line}: {phrase}: {sentence}")
    if doc_words > MAX_WORDS:
        print(f"doc comments have {doc_words} words; the limit is {MAX_WORDS}")
    return 1 if wrong or doc_words > MAX_WORDS else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
