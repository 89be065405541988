"""The packaged program: installed, moved, and run without the files of the build.

    python3 tests/packaging/test_packaging.py build/bin/camber build cmake [unittest arguments]

The packages are those of docs/installing.md, with faster compression.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "packaging"))
import help_text  # noqa: E402

CAMBER, BUILD = (str(pathlib.Path(sys.argv.pop(1)).resolve()) for _ in range(2))
CMAKE = sys.argv.pop(1)
GLIBC = re.compile(r"^(linux-vdso|/lib.*/ld-linux|lib(c|m|dl|rt|pthread)\.so)")
MODEL = ROOT / "tests" / "cad" / "shell.brep"
BARE = {"PATH": "/usr/bin:/bin", "LANG": "C"}  # no LD_LIBRARY_PATH


def run(*command, code=0, **options):
    options = {"env": BARE, "capture_output": True, "text": True} | options
    done = subprocess.run([str(word) for word in command], **options)
    if done.returncode != code:
        raise AssertionError(f"{command}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def numbers(version):
    return [int(part) for part in version.split(".")]


KEEP = tempfile.TemporaryDirectory()
FOLDER = pathlib.Path(KEEP.name)
HAS_CAD = any(pathlib.Path(BUILD, "lib").glob("libcamber_occ*"))


def setUpModule():  # noqa: N802
    """Builds the packages in FOLDER."""
    if shutil.which("dpkg-query") is None:
        raise unittest.SkipTest("no dpkg, whose packages tell the licences")
    cpack = pathlib.Path(CMAKE).parent / "cpack"
    run(cpack, "--config", pathlib.Path(BUILD, "CPackConfig.cmake"), "-B", FOLDER, "-G", "TZST;DEB", "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=none")


def tearDownModule():  # noqa: N802
    KEEP.cleanup()


class Archive(unittest.TestCase):
    """The archive, unpacked and moved."""

    @classmethod
    def setUpClass(cls):
        archive, = FOLDER.glob("camber-*.tar.zst")
        run(CMAKE, "-E", "tar", "xf", archive, cwd=FOLDER)
        cls.prefix = FOLDER / "moved" / "else where"
        cls.prefix.parent.mkdir()
        (FOLDER / archive.name.removesuffix(".tar.zst")).rename(cls.prefix)
        cls.camber = cls.prefix / "bin" / "camber"
        cls.out = FOLDER / "out"
        cls.out.mkdir()
        run(cls.camber, "generate", "shell", "-o", "shell.mesh", cwd=cls.out)

    def libraries(self, **more):
        """Paths of the loaded libraries by name, with OpenCASCADE also those loaded for a CAD model."""
        done = run(self.camber, "curve", "shell.mesh", "-o", "cad.meshb", *(["--cad", MODEL] if HAS_CAD else []), cwd=self.out,
                   env=BARE | {"LD_DEBUG": "files"} | more)
        return {pathlib.Path(path).name: path for path in re.findall(r"calling init: (/\S.*)", done.stderr)}

    def test_the_moved_program_curves_and_checks(self):
        run(self.camber, "curve", "shell.mesh", "-o", "curved.meshb", cwd=self.out)
        self.assertIn("valid", run(self.camber, "check", "curved.meshb", cwd=self.out).stdout)
        self.assertEqual(run(self.camber, "--version").stdout, run(CAMBER, "--version").stdout)

    def test_the_program_runs_through_a_symbolic_link(self):
        link = self.out / "link"
        link.symlink_to(self.camber)
        run(link, "check", "shell.mesh", cwd=self.out)

    def test_all_libraries_except_glibc_are_loaded_from_the_archive(self):
        loaded = self.libraries()
        self.assertGreater(len(loaded), 10)
        for name, path in loaded.items():
            if not GLIBC.match(name) and not name.startswith("ld-linux"):
                self.assertTrue(path.startswith(str(self.prefix)), path)
        if HAS_CAD:
            self.assertIn("libcamber_occ.so", loaded)

    def test_ld_library_path_does_not_replace_libraries_of_the_archive(self):
        others = self.out / "others"
        others.mkdir()
        for name in ("libtbb.so.12", "libfmt.so.9"):
            (others / name).write_text("no library")
        self.assertIn(str(self.prefix), self.libraries(LD_LIBRARY_PATH=str(others))["libtbb.so.12"])

    def test_required_glibc_versions_are_available(self):
        host = numbers(os.confstr("CS_GNU_LIBC_VERSION").split()[1])
        for file in [self.camber, *(self.prefix / "lib" / "camber").iterdir()]:
            for version in re.findall(rb"GLIBC_([0-9.]+[0-9])\0", file.read_bytes()):
                self.assertLessEqual(numbers(version.decode()), host, file)

    def test_the_archive_contains_configs_and_examples(self):
        (self.out / "out").mkdir(exist_ok=True)
        share = self.prefix / "share" / "camber"
        run(self.camber, "run", share / "configs" / "annulus-2d.json", cwd=self.out)
        self.assertTrue((share / "examples" / "own-solver" / "adapt.json").exists())

    def test_every_library_of_the_archive_has_its_licence(self):
        folder = self.prefix / "share" / "doc" / "camber"
        self.assertEqual((folder / "LICENSE").read_text(), (ROOT / "LICENSE").read_text())
        listed = "".join(list_.read_text() for list_ in folder.glob("licences/*/*.txt"))
        for library in (self.prefix / "lib" / "camber").glob("*.so.*"):
            package = re.search(rf"^{re.escape(library.name)}: (\S+) ", listed, re.MULTILINE)
            self.assertTrue(package and list(folder.glob(f"licences/*/{package.group(1)}")), library.name)
        if pathlib.Path(BUILD, "apps/page/node_modules/three/LICENSE").exists():
            self.assertIn("MIT", (folder / "licences" / "camber" / "three.js").read_text())


@unittest.skipUnless(shutil.which("dpkg-deb"), "no dpkg")
class DebianPackages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.packages = {file.name.split("_")[0]: file for file in FOLDER.glob("*.deb")}
        cls.files = {name: {line.split()[5] for line in run("dpkg-deb", "--contents", file).stdout.splitlines() if line.startswith("-")}
                     for name, file in cls.packages.items()}

    def field(self, name, field):
        return run("dpkg-deb", "--field", self.packages[name], field).stdout.strip()

    def test_debian_packages_are_camber_and_camber_cad(self):
        self.assertEqual(set(self.packages), {"camber", "camber-cad"} if HAS_CAD else {"camber"})
        self.assertIn("./usr/bin/camber", self.files["camber"])
        self.assertRegex(self.field("camber", "Depends"), r"^libc6 \(>= [0-9.]+\)$")

    @unittest.skipUnless(HAS_CAD, "no OpenCASCADE")
    def test_debian_packages_share_no_file_and_require_equal_versions(self):
        self.assertEqual(self.files["camber"] & self.files["camber-cad"], set())
        version = self.field("camber", "Version")
        self.assertEqual(self.field("camber-cad", "Depends"), f"camber (= {version})")
        self.assertEqual(self.field("camber", "Recommends"), f"camber-cad (= {version})")

    @unittest.skipUnless(HAS_CAD, "no OpenCASCADE")
    def test_only_cad_models_require_camber_cad(self):
        root = FOLDER / "root"
        camber = root / "usr" / "bin" / "camber"
        run("dpkg-deb", "--extract", self.packages["camber"], root)
        run(camber, "generate", "shell", "-o", root / "shell.mesh")
        run(camber, "check", root / "shell.mesh")
        run("dpkg-deb", "--extract", self.packages["camber-cad"], root)
        run(camber, "curve", root / "shell.mesh", "--cad", MODEL, "-o", root / "curved.meshb")


class Help(unittest.TestCase):
    """The parsed help, source of man pages and completion."""

    @classmethod
    def setUpClass(cls):
        cls.whole, cls.verbs = help_text.of_program(CAMBER)

    def test_the_parsed_help_contains_every_word(self):
        for verb, shown in self.verbs.items():
            text = run(CAMBER, verb, "--help-all").stdout
            parts = [shown.description, "Usage:", shown.usage, shown.footer]
            for title, entries in shown.lists.items():
                parts += [title + ":", *(word for entry in entries for word in (entry.name, entry.text))]
            self.assertEqual(sorted(text.split()), sorted(" ".join(parts).split()), verb)

    def test_every_option_has_a_name_and_a_description(self):
        for verb, shown in self.verbs.items():
            for entry in shown.options:
                self.assertTrue(entry.options and all(re.fullmatch(r"-[a-z]|--[a-z0-9-]+", word) for word in entry.options), entry)
                self.assertTrue(entry.text, f"{verb} {entry.name}")

    def test_option_names_wider_than_their_column_are_parsed(self):
        text = "Words\n\nUsage: camber x\n\nOptions:\n  --far FLOAT:[0, 1000000000000]\n" + " " * 30 + "Far\n  --near FLOAT:[0, 1)         Near\n"
        self.assertEqual([(entry.name, entry.text) for entry in help_text.parsed(text).options],
                         [("--far FLOAT:[0, 1000000000000]", "Far"), ("--near FLOAT:[0, 1)", "Near")])


class Texts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.verbs = help_text.of_program(CAMBER)[1]
        cls.temporary = tempfile.TemporaryDirectory()
        cls.share = pathlib.Path(cls.temporary.name)
        for script in ("man_pages.py", "completion.py"):
            run(sys.executable, "-B", ROOT / "packaging" / script, CAMBER, cls.share)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_each_verb_has_a_man_page_with_its_options(self):
        for verb, shown in self.verbs.items():
            page = (self.share / "man" / "man1" / f"camber-{verb}.1").read_text(encoding="ascii")
            for request in re.findall(r"(?m)^[.'](\S*)", page):
                self.assertIn(request, ("TH", "SH", "PP", "TP", "B", "BR", "nf", "fi"))
            for entry in shown.options:
                self.assertIn(f"\n.TP\n.B {entry.name}\n", page.replace("\\-", "-"))
        self.assertIn("camber\\-curve", (self.share / "man" / "man1" / "camber.1").read_text(encoding="ascii"))

    @unittest.skipUnless(shutil.which("groff") or os.environ.get("CAMBER_NO_SKIP"), "no groff")
    def test_groff_reads_man_pages_without_a_warning(self):
        for page in (self.share / "man" / "man1").iterdir():
            done = run("groff", "-man", "-ww", "-Tutf8", page, encoding="utf-8")
            self.assertEqual(done.stderr, "")
            self.assertIn("SYNOPSIS", re.sub(r".\x08", "", done.stdout))

    def completed(self, *words):
        """The completions that bash offers for the last word."""
        quoted = " ".join(f"'{word}'" for word in words)
        script = f'. "$1"; COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; _camber; printf "%s\\n" "${{COMPREPLY[@]}}"'
        return run("bash", "-c", script, "bash", self.share / "bash-completion" / "completions" / "camber").stdout.split()

    def test_bash_completes_verbs_options_and_values(self):
        self.assertEqual(self.completed("camber", "ch"), ["check"])
        self.assertEqual(set(self.completed("camber", "")), {*self.verbs, "--help", "--verbose", "--version"})
        for verb, shown in self.verbs.items():
            expected = {word for entry in shown.options for word in entry.options if word.startswith("--")}
            self.assertEqual(set(self.completed("camber", verb, "--")), expected, verb)
        self.assertEqual(self.completed("camber", "curve", "--flat", "p"), ["plane"])
        self.assertIn("gmf-binary", self.completed("camber", "convert", "a.mesh", "--format", ""))
        self.assertEqual(self.completed("camber", "explain", "sur"), ["surface", "surrogate"])
        self.assertEqual(self.completed("camber", "curve", "wing"), [])  # a file name is expected


if __name__ == "__main__":
    unittest.main()
