"""Runs the guides: writes files named in bold before a block, runs `sh` blocks in an empty folder, and compares quoted
output.

    python3 tests/guides/test_guides.py build/bin/camber [unittest arguments]
    python3 tests/guides/test_guides.py build/bin/camber --pictures        # and put the pictures into docs/pictures/guides
"""
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CAMBER = Path(sys.argv[1] if len(sys.argv) > 1 else "build/bin/camber").resolve()
BUILD = CAMBER.parents[1]  # the guides use $CAMBER/build, the actual build may be elsewhere
PICTURES = ROOT / "docs" / "pictures" / "guides" if "--pictures" in sys.argv else None
GUIDES = ROOT / "docs" / "guides"
BLOCK = re.compile(r"(?:^\*\*(?P<file>[^*\n]+)\*\*\n\n)?^```(?P<kind>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
TOLERANCE = 0.25  # relative: meshes of different Gmsh versions differ


def is_there(what):
    if what == "installed":  # installation requires a complete build
        return (CAMBER.parent / "test_core").exists() and shutil.which("clang++-19") is not None
    if what == "opencascade":
        return any((BUILD / "lib").glob("libcamber_occ*"))
    if what == "scipy":  # for the interpreter that the guides use
        return subprocess.run(["/usr/bin/python3", "-c", "import scipy"], capture_output=True, check=False).returncode == 0
    return shutil.which(what) is not None or importlib.util.find_spec(what) is not None


def words(line):
    """Splits a line into words; 1 090 is one word."""
    return re.sub(r"(?<=\d) (?=\d{3}\b)", "", line).split()


def is_alike(quoted, found):
    if quoted == found:
        return True
    parts = [re.findall(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?|\D+", word) for word in (quoted, found)]
    if len(parts[0]) != len(parts[1]):
        return False
    for a, b in zip(*parts):
        try:
            if abs(float(a) - float(b)) > TOLERANCE * max(abs(float(a)), abs(float(b))):
                return False
        except ValueError:
            if a != b:
                return False
    return True


def is_quoted(line, printed):
    quoted = words(line)
    return any(len(quoted) == len(found) and all(map(is_alike, quoted, found)) for found in map(words, printed.splitlines()))


class Guides(unittest.TestCase):
    def run_guide(self, name):
        page = (GUIDES / name).read_text(encoding="utf-8")
        for what in re.search(r"<!-- needs ([^>]*) -->", page)[1].split():
            if not is_there(what):
                (self.fail if os.environ.get("CAMBER_NO_SKIP") == "1" else self.skipTest)(f"{what} is not installed")
        environment = {**os.environ, "CAMBER": str(ROOT), "PATH": f"{CAMBER.parent}:{os.environ['PATH']}"}
        printed = ""
        with tempfile.TemporaryDirectory() as folder:
            for block in BLOCK.finditer(page):
                if block["file"]:
                    Path(folder, block["file"]).write_text(block["text"])
                elif block["kind"] == "sh":
                    commands = block["text"].replace("$CAMBER/build", str(BUILD))
                    done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", commands], cwd=folder, env=environment,
                                          capture_output=True, text=True, timeout=600, check=False)
                    printed = done.stdout + done.stderr
                    self.assertEqual(done.returncode, 0, f"{name}:\n{block['text']}\n{printed}")
                elif block["kind"] == "text":
                    for line in block["text"].splitlines():
                        self.assertTrue(is_quoted(line, printed), f"{name} quotes\n{line}\nof\n{printed}")
            self.look_at_pictures(name, page, Path(folder))

    def look_at_pictures(self, name, page, folder):
        """Checks that the commands of the page write its pictures, and that stored pictures are small."""
        for picture in re.findall(r"\]\(\.\./pictures/guides/([^)]+)\)", page):
            self.assertTrue((folder / picture).exists(), f"{name} does not make {picture}")
            if PICTURES:
                shutil.copy(folder / picture, PICTURES / picture)
            self.assertLess((ROOT / "docs" / "pictures" / "guides" / picture).stat().st_size, 60000, picture)


for guide in sorted(GUIDES.glob("*.md")):
    if guide.name != "README.md":
        setattr(Guides, "test_" + guide.stem.replace("-", "_"), lambda self, name=guide.name: self.run_guide(name))


class Quoting(unittest.TestCase):
    def test_quoted_numbers_may_differ_by_a_quarter_and_words_may_not(self):
        self.assertTrue(is_quoted("valid elements 1 086", "  valid elements      1 190\n"))
        self.assertFalse(is_quoted("valid elements 1 086", "  valid elements      2 190\n"))
        self.assertFalse(is_quoted("valid elements 4", "  invalid elements 4\n"))
        self.assertTrue(is_quoted("J 0.5 -> -6.3 (tag 10)", "J 0.55 -> -6.2 (tag 11)"))
        self.assertFalse(is_quoted("J 0.5", "J none"))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *(a for a in sys.argv[2:] if a != "--pictures")], verbosity=1)
