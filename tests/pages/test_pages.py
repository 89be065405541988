"""Links, paths and names in the pages exist; tables of modules are those of the manifests. Measured tables: test_tables.py.

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
    """The anchors of a page's headings, as GitHub makes them."""
    text = re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL)
    lower = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line).lower() for line in re.findall(r"^#+ (.*)$", text, re.MULTILINE)]
    return {re.sub(r"[^\w\- ]", "", line).strip().replace(" ", "-") for line in lower}


class Links(unittest.TestCase):
    def test_what_pages_link_to_is_there(self):
        links = 0
        for page in pages():
            for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL)):
                if "://" in target:
                    continue
                links += 1
                self.assertTrue((page.parent / target).exists(), f"{page.relative_to(ROOT)} links to {target}")
        self.assertGreater(links, 50)

    def test_headings_that_pages_link_to_are_there(self):
        anchors = 0
        for page in pages():
            for target, anchor in re.findall(r"\]\(([^)#\s]*)#([^)]*)\)", re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL)):
                if "://" in target or not target.endswith(".md") and target:
                    continue
                anchors += 1
                self.assertIn(anchor, headings(page.parent / target if target else page), f"{page.relative_to(ROOT)} links to {target}#{anchor}")
        self.assertGreater(anchors, 20)


def braces(path):
    """`a/{b,c}.cpp` is `a/b.cpp` and `a/c.cpp`."""
    found = re.match(r"(.*?)\{([^}]*)\}(.*)", path)
    return [found[1] + part + found[3] for part in found[2].split(",")] if found else [path]


class Words(unittest.TestCase):
    def test_one_name_for_a_thing(self):
        """docs/glossary.md has the words; docs/report.md tells of a key that was called otherwise."""
        other = re.compile(r"normali[sz]ed[ _]jacobian|untangl", re.IGNORECASE)
        for page in pages():
            if page.name not in ("glossary.md", "report.md"):
                self.assertIsNone(other.search(text_of(page)), page.relative_to(ROOT))

    def test_words_of_the_house_stay_away(self):
        """Said instead: recommended, settled, curved back mesh, length reduction, disjoint."""
        other = re.compile(r"\bwish(?:es|ed)?\b|\bat rest\b|\bcarried (?:field|one)\b|\b(?:length|mean) gain|proved clear", re.IGNORECASE)
        for page in pages():
            self.assertIsNone(other.search(" ".join(text_of(page).split())), page.relative_to(ROOT))


def sentences(text):
    """Of what is read as text: no blocks of code, a table's cells and a list's items each by themselves."""
    text = re.sub(r"```.*?```|<!--.*?-->", "\n\n", text, flags=re.DOTALL)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    for part in re.split(r"\n\s*\n|\n(?=[-#|]|\d\. )|\|", text):
        yield from re.split(r"(?<=[.!?:;])\s+", part.replace("\n", " ").strip())


class Sentences(unittest.TestCase):
    def test_what_is_read_first_is_read_once(self):
        """No sentence of the README, of CONTRIBUTING or of a guide has more than 30 words."""
        for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs" / "guides").glob("*.md")]:
            for sentence in sentences(text_of(page)):
                self.assertLessEqual(len(sentence.split()), 30, f"{page.relative_to(ROOT)}: {sentence}")

    def test_long_ones_are_found(self):
        long = " ".join(["word"] * 31)
        self.assertEqual([s for s in sentences(f"# Head\n\nShort one. {long}.\n") if len(s.split()) > 30], [long + "."])


class Places(unittest.TestCase):
    """Where pages say that something is, it is."""

    def test_files_are_there(self):
        files = 0
        for page in pages():
            for named in re.findall(r"`((?:apps|bench|cmake|configs|docs|examples|modules|packaging|tests)/[^`\s]*)`", text_of(page)):
                for path in braces(named):
                    if re.search(r"[A-Z]{3,}|…", path) or re.fullmatch(r"configs/\w+\.\w+\.json", path):
                        continue  # a word that stands for many
                    files += 1
                    self.assertTrue(list(ROOT.glob(path.rstrip("/"))), f"{page.relative_to(ROOT)} names {named}")
        self.assertGreater(files, 40)

    def test_partitions_are_there(self):
        """`module:partition`, and `:partition` of the module named last before it."""
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
    """The names in a cell, without what is said of them in brackets."""
    return {name.strip() for name in re.sub(r"\([^)]*\)", "", cell).split(",") if name.strip()}


class Modules(unittest.TestCase):
    """The table of modules in docs/embedding.md, and the list in docs/architecture.md, are those of the manifests."""

    def header_only(self):
        """Nothing of these is left to link once the module is built."""
        text = text_of(ROOT / "cmake" / "CamberModule.cmake")
        words = re.search(r"set\(CAMBER_HEADER_ONLY ([^)]*)\)", text)[1].split()
        return {LIBRARIES[word] for word in words if word in LIBRARIES}

    def floors(self):
        return re.search(r"set\(camber_floors ([^)]*)\)", text_of(ROOT / "CMakeLists.txt"))[1].split()

    def test_the_table_is_that_of_the_manifests(self):
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

    def test_the_drawing_has_every_module_above_what_it_uses(self):
        text = text_of(ROOT / "docs" / "architecture.md")
        floors = {name: int(floor) for floor, name in re.findall(r"^  (\d+)  (\w+) ", text, re.MULTILINE)}
        self.assertEqual(set(floors), set(self.floors()))
        for module, floor in floors.items():
            below = [floors[used] for used in manifest(module).get("USES", [])]
            self.assertEqual(floor, max(below, default=-1) + 1, module)

    def test_the_map_has_a_line_for_each_source_file(self):
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
