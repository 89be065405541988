"""Checks that links, paths and names in the pages exist and that module tables equal the manifests. test_tables.py
checks measured tables.

    python3 tests/pages/test_pages.py [unittest arguments]
"""
import re
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
from tables import pages  # noqa: E402


def text_of(page):
    return page.read_text(encoding="utf-8")


def headings(page):
    """The anchors of the headings of a page, formed as on GitHub."""
    text = re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL)
    lower = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line).lower() for line in re.findall(r"^#+ (.*)$", text, re.MULTILINE)]
    return {re.sub(r"[^\w\- ]", "", line).strip().replace(" ", "-") for line in lower}


class Links(unittest.TestCase):
    def test_link_targets_of_pages_exist(self):
        links = 0
        for page in pages():
            for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL)):
                if "://" in target:
                    continue
                links += 1
                self.assertTrue((page.parent / target).exists(), f"{page.relative_to(ROOT)} links to {target}")
        self.assertGreater(links, 50)

    def test_linked_headings_of_pages_exist(self):
        anchors = 0
        for page in pages():
            for target, anchor in re.findall(r"\]\(([^)#\s]*)#([^)]*)\)", re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL)):
                if "://" in target or not target.endswith(".md") and target:
                    continue
                anchors += 1
                self.assertIn(anchor, headings(page.parent / target if target else page), f"{page.relative_to(ROOT)} links to {target}#{anchor}")
        self.assertGreater(anchors, 20)


def braces(path):
    """Expands braces: `a/{b,c}.cpp` gives `a/b.cpp` and `a/c.cpp`."""
    found = re.match(r"(.*?)\{([^}]*)\}(.*)", path)
    return [found[1] + part + found[3] for part in found[2].split(",")] if found else [path]


class Words(unittest.TestCase):
    def test_pages_use_the_terms_of_the_glossary(self):
        """docs/glossary.md defines the terms; docs/report.md mentions the former name of a key."""
        other = re.compile(r"normali[sz]ed[ _]jacobian|untangl", re.IGNORECASE)
        for page in pages():
            if page.name not in ("glossary.md", "report.md"):
                self.assertIsNone(other.search(text_of(page)), page.relative_to(ROOT))

    def test_pages_do_not_use_private_words(self):
        """Terms to use instead: recommended, settled, curved back mesh, length reduction, disjoint."""
        other = re.compile(r"\bwish(?:es|ed)?\b|\bat rest\b|\bcarried (?:field|one)\b|\b(?:length|mean) gain|proved clear", re.IGNORECASE)
        for page in pages():
            self.assertIsNone(other.search(" ".join(text_of(page).split())), page.relative_to(ROOT))


def sentences(text):
    """Sentences of the text without code blocks; table cells and list items are separate."""
    text = re.sub(r"```.*?```|<!--.*?-->", "\n\n", text, flags=re.DOTALL)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    for part in re.split(r"\n\s*\n|\n(?=[-#|]|\d\. )|\|", text):
        yield from re.split(r"(?<=[.!?:;])\s+", part.replace("\n", " ").strip())


class Sentences(unittest.TestCase):
    def test_sentences_of_readme_contributing_and_guides_have_at_most_30_words(self):
        for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs" / "guides").glob("*.md")]:
            for sentence in sentences(text_of(page)):
                self.assertLessEqual(len(sentence.split()), 30, f"{page.relative_to(ROOT)}: {sentence}")

    def test_a_sentence_of_31_words_is_found(self):
        long = " ".join(["word"] * 31)
        self.assertEqual([s for s in sentences(f"# Head\n\nShort one. {long}.\n") if len(s.split()) > 30], [long + "."])


class Places(unittest.TestCase):
    """Files and modules that pages name exist."""

    def test_files_named_in_pages_exist(self):
        files = 0
        for page in pages():
            for named in re.findall(r"`((?:apps|bench|cmake|configs|docs|examples|modules|packaging|tests)/[^`\s]*)`", text_of(page)):
                for path in braces(named):
                    if re.search(r"[A-Z]{3,}|…", path) or re.fullmatch(r"configs/\w+\.\w+\.json", path):
                        continue  # a placeholder
                    files += 1
                    self.assertTrue(list(ROOT.glob(path.rstrip("/"))), f"{page.relative_to(ROOT)} names {named}")
        self.assertGreater(files, 40)

    def test_module_partitions_named_in_pages_exist(self):
        """Checks `module:partition`, and `:partition` of the module named last."""
        partitions = 0
        for page in [*(ROOT / "docs" / "algorithms").glob("*.md"), ROOT / "docs" / "glossary.md"]:
            module = None
            for name, partition in re.findall(r"`(\w*):(\w+)\*?`", text_of(page)):
                module = name or module
                partitions += 1
                self.assertTrue(list((ROOT / "modules" / str(module)).glob(f"{partition}*.cppm")),
                                f"{page.relative_to(ROOT)} names {module}:{partition}")
        self.assertGreater(partitions, 60)


LIBRARIES = {"tl::expected": "tl-expected", "TBB::tbb": "TBB", "range-v3::range-v3": "range-v3", "Boost::headers": "Boost",
             "ZLIB::ZLIB": "zlib", "LibLZMA::LibLZMA": "liblzma", "lz4": "lz4", "pugixml::pugixml": "pugixml", "muparser::muparser": "muparser", "Eigen3::Eigen": "Eigen",
             "fmt::fmt-header-only": "fmt", "nlohmann_json::nlohmann_json": "nlohmann_json"}


def manifest(module):
    """{keyword: words} of modules/NAME/CMakeLists.txt."""
    text = text_of(ROOT / "modules" / module / "CMakeLists.txt")
    begin = text.index("camber_module(") + len("camber_module(")
    words = text[begin:text.index(")\n", begin)].split()
    found, keyword = {}, "NAME"
    for word in words:
        if word in ("INTERFACE", "PARTS", "IMPL", "USES", "LINK_PUBLIC", "LINK_PRIVATE"):
            keyword = word
        else:
            found.setdefault(keyword, []).append(word)
    return found


def libraries(cell):
    """The names in a table cell, without remarks in brackets."""
    return {name.strip() for name in re.sub(r"\([^)]*\)", "", cell).split(",") if name.strip()}


class Modules(unittest.TestCase):
    """The module table in docs/embedding.md and the list in docs/architecture.md equal the manifests."""

    def header_only(self):
        """Header-only libraries: not linked after the module is built."""
        text = text_of(ROOT / "cmake" / "CamberModule.cmake")
        words = re.search(r"set\(CAMBER_HEADER_ONLY ([^)]*)\)", text)[1].split()
        return {LIBRARIES[word] for word in words if word in LIBRARIES}

    def floors(self):
        return re.search(r"set\(camber_floors ([^)]*)\)", text_of(ROOT / "CMakeLists.txt"))[1].split()

    def test_the_module_table_equals_the_manifests(self):
        text = text_of(ROOT / "docs" / "embedding.md")
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()
                if re.match(r"\| `\w+` \| ", line)]
        self.assertEqual([row[0].strip("`") for row in rows], self.floors())
        for name, uses, installed, to_build, _ in rows:
            with self.subTest(module=name):
                there = manifest(name.strip("`"))
                self.assertEqual(set(uses.split()), set(there.get("USES", [])))
                public = {LIBRARIES[word] for word in there.get("LINK_PUBLIC", [])}
                private = {LIBRARIES[word] for word in there.get("LINK_PRIVATE", [])}
                self.assertEqual(libraries(installed), public | (private - self.header_only()))
                self.assertEqual(libraries(to_build), private & self.header_only())

    def test_the_layer_diagram_places_modules_above_those_they_use(self):
        text = text_of(ROOT / "docs" / "architecture.md")
        floors = {name: int(floor) for floor, name in re.findall(r"^  (\d+)  (\w+) ", text, re.MULTILINE)}
        self.assertEqual(set(floors), set(self.floors()))
        for module, floor in floors.items():
            below = [floors[used] for used in manifest(module).get("USES", [])]
            self.assertEqual(floor, max(below, default=-1) + 1, module)

    def test_the_list_of_source_files_is_complete(self):
        text = text_of(ROOT / "docs" / "architecture.md").split("## Source files of the modules")[1]
        listed = {}
        for section in text.split("\n### ")[1:]:
            listed[section.split("\n")[0]] = sorted(re.findall(r"^\| `([^`]+)` \| .", section, re.MULTILINE))
        self.assertEqual(list(listed), self.floors())
        for module, files in listed.items():
            folder = ROOT / "modules" / module
            there = [str(path.relative_to(folder)) for path in folder.rglob("*") if path.suffix in (".cpp", ".cppm", ".hpp")]
            alone = sum(name.endswith(".cppm") for name in there) == 1  # otherwise the primary unit only exports its partitions
            unlisted = ["example.cpp"] if alone else ["example.cpp", f"{module}.cppm"]
            self.assertEqual(files, sorted(set(there) - set(unlisted)), module)


if __name__ == "__main__":
    unittest.main()
