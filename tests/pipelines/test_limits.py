"""Every command under system limits: it ends with its exit code and a reason, never by a signal, and leaves no partial
output.

    python3 tests/pipelines/test_limits.py build/bin/camber [unittest arguments]
"""
import json
import os
import re
import resource
import subprocess
import sys
import unittest

import bad_moments
from program import CAMBER, Folder

RUN = {"input": {"mesh": "in.mesh"}, "stages": ["elevate", "curve"], "output": {"mesh": "out.mesh", "report": "out.json"}}
SOLUTION = "MeshVersionFormatted 2\nDimension 3\nSolAtVertices {}\n1 1\n{}End\n"

# One row per command: its words and its output files.
COMMANDS = [
    (("info", "in.mesh"), ()),
    (("check", "in.mesh"), ()),
    (("check", "p2.mesh", "--vtu", "out.vtu"), ("out.vtu",)),
    (("check", "p2.mesh", "--page", "out.html"), ("out.html",)),
    *((("convert", "in.mesh", "-o", "out." + ending), ("out." + ending,))
      for ending in ("meshb", "msh", "vtu", "vtk", "mfem", "cgns", "xdmf")),
    (("curve", "in.mesh", "-o", "out.mesh", "--report", "out.json"), ("out.mesh", "out.json")),
    (("curve", "in.meshb", "-o", "out.meshb", "--blocks", "2"), ("out.meshb",)),
    (("curve", "in.meshb", "-o", "out.meshb", "--memory", "50"), ("out.meshb",)),
    (("remesh", "in.mesh", "-o", "out.mesh", "--metric", "0.4"), ("out.mesh",)),
    (("remesh", "in.meshb", "-o", "out.meshb", "--metric", "0.4", "--blocks", "2"), ("out.meshb",)),
    (("adapt", "in.mesh", "-o", "out.mesh", "--field", "exp(3*x)", "--complexity", "20", "--cycles", "1"), ("out.mesh",)),
    (("repair", "p2.mesh", "-o", "out.mesh"), ("out.mesh",)),
    (("metric", "in.mesh", "--solution", "u.sol", "-o", "out.sol", "--complexity", "50"), ("out.sol",)),
    (("transfer", "in.mesh", "in.mesh", "--solution", "u.sol", "-o", "out.sol"), ("out.sol",)),
    (("generate", "box", "-o", "out.mesh"), ("out.mesh",)),
    (("picture", "p2.mesh", "-o", "out.png"), ("out.png",)),
    (("report", "p2.mesh", "-o", "out.html"), ("out.html",)),
    (("geometry", "p2.mesh"), ()),
    (("plot", "report.json", "-o", "out.svg"), ("out.svg",)),
    (("run", "run.json"), ("out.mesh", "out.json")),
    (("explain", "curve"), ()),
    (("help", "curve"), ()),
    (("schema",), ()),
]

# Commands that read a file, `{}` for its name; the format of CAD models depends on the ending.
READS = [
    ("info", "{}"), ("check", "{}"), ("check", "in.mesh", "--metric", "{}"), ("convert", "{}", "-o", "out.mesh"),
    ("curve", "{}", "-o", "out.mesh"), ("curve", "{}", "-o", "out.meshb", "--blocks", "2"),
    ("curve", "{}", "-o", "out.meshb", "--memory", "50"), ("curve", "in.mesh", "-o", "out.mesh", "--metric", "{}"),
    ("curve", "in.mesh", "-o", "out.mesh", "--geometry", '{{"mesh": "{}"}}'),
    ("remesh", "{}", "-o", "out.mesh", "--metric", "0.4"), ("remesh", "in.mesh", "-o", "out.mesh", "--metric", "{}"),
    ("adapt", "in.mesh", "-o", "out.mesh", "--solution", "{}", "--complexity", "20"),
    ("repair", "{}", "-o", "out.mesh"), ("metric", "in.mesh", "--solution", "{}", "-o", "out.sol", "--complexity", "50"),
    ("transfer", "{}", "in.mesh", "--solution", "u.sol", "-o", "out.sol"),
    ("transfer", "in.mesh", "in.mesh", "--solution", "{}", "-o", "out.sol"),
    ("picture", "{}", "-o", "out.png"), ("report", "{}", "-o", "out.html"), ("geometry", "{}"), ("plot", "{}", "-o", "out.svg"),
    ("generate", "{}", "-o", "out.mesh"), ("run", "{}"),
]


def limited(*limits):
    def set_all():
        for kind, value in limits:
            resource.setrlimit(kind, (value, value))
    return set_all


class Limits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        path = cls.folder.path
        for words in (("generate", "box", "-o", "in.mesh", "--set", "cells=[4,4,4]"), ("convert", "in.mesh", "-o", "in.meshb"),
                      ("curve", "in.mesh", "-o", "p2.mesh", "--report", "report.json")):
            done = cls.folder.camber(*words)
            assert done.returncode == 0, done.stderr
        vertices = int(re.search(r"Vertices\s+(\d+)", (path / "in.mesh").read_text())[1])
        (path / "u.sol").write_text(SOLUTION.format(vertices, "".join(f"{i % 7}\n" for i in range(vertices))))
        (path / "run.json").write_text(json.dumps(RUN))
        cls.inputs = cls.folder.files()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def tearDown(self):
        self.remove_outputs()

    def remove_outputs(self):
        for name in self.new_files():
            (self.folder.path / name).unlink()

    def new_files(self):
        return sorted(set(self.folder.files()) - set(self.inputs))

    def under(self, words, *limits):
        """Removes the outputs and runs a command under system limits."""
        self.remove_outputs()
        return self.folder.camber(*words, preexec_fn=limited(*limits))

    def check_refused(self, done, code, *reasons):
        """Expects the exit code and a reason in the last line."""
        self.assertEqual(done.returncode, code, done.stderr)
        last = done.stderr.splitlines()[-1]
        self.assertTrue(any(reason in last for reason in reasons), done.stderr)

    def test_every_verb_is_tested_under_limits(self):
        text = self.folder.camber("--help").stdout
        verbs = set(re.findall(r"^  ([a-z]+)  ", text[text.lower().index("subcommands"):], flags=re.M))
        self.assertIn("curve", verbs)
        self.assertEqual(verbs - {words[0] for words, _ in COMMANDS}, set())

    def test_a_file_size_limit_is_reported_and_leaves_no_output(self):
        for words, outputs in COMMANDS:
            with self.subTest(" ".join(words)):
                done = self.under(words, (resource.RLIMIT_FSIZE, 256))
                if outputs:
                    self.check_refused(done, 3, "File too large")
                    self.assertIn("ulimit -f", done.stderr)
                    self.assertNotIn("memory", done.stderr.splitlines()[-1])
                else:
                    self.assertIn(done.returncode, (0, 1), done.stderr)
                self.assertEqual(self.new_files(), [])

    def test_a_file_size_limit_of_standard_output_is_reported(self):
        for words in (("info", "in.mesh"), ("check", "in.mesh"), ("explain", "curve"), ("schema",), ("geometry", "p2.mesh")):
            with self.subTest(" ".join(words)), open(self.folder.path / "out.txt", "w", encoding="utf-8") as out:
                done = subprocess.run([CAMBER, *words], cwd=self.folder.path, stdout=out, stderr=subprocess.PIPE, text=True,
                                      preexec_fn=limited((resource.RLIMIT_FSIZE, 100)))
                self.check_refused(done, 3, "standard output: cannot be written: File too large")

    def test_a_small_stack_does_not_change_results(self):
        for words, outputs in COMMANDS:
            with self.subTest(" ".join(words)):
                usual = self.under(words)
                repeatable = [name for name in outputs if not name.endswith((".json", ".cgns", ".html"))]
                made = {name: (self.folder.path / name).read_bytes() for name in repeatable}
                done = self.under(words, (resource.RLIMIT_STACK, 64 << 10))
                self.assertEqual((done.returncode, done.stderr), (usual.returncode, usual.stderr))
                for name in repeatable:
                    self.assertEqual((self.folder.path / name).read_bytes(), made[name], name)
                self.assertEqual(self.new_files(), sorted(outputs))

    def test_a_small_address_space_is_reported_and_leaves_no_output(self):
        for words, _ in COMMANDS:
            for mebibytes in (60, 78):
                with self.subTest(" ".join(words), mebibytes=mebibytes):
                    done = self.under(words, (resource.RLIMIT_AS, mebibytes << 20))
                    if done.returncode in (0, 1, bad_moments.LOADER_FAILED):
                        continue
                    self.check_refused(done, 4, "not enough memory", "the run needs about", "the system refuses")
                    if words[0] != "adapt":  # adapt writes the mesh of each cycle
                        self.assertEqual(self.new_files(), [])

    def test_a_limit_of_open_files_is_reported_and_leaves_no_output(self):
        for words, _ in COMMANDS:
            with self.subTest(" ".join(words)):
                done = self.under(words, (resource.RLIMIT_NOFILE, 5))
                if done.returncode in (0, 1, bad_moments.LOADER_FAILED):
                    continue
                self.check_refused(done, 3, "Too many open files", "cannot")
                self.assertEqual(self.new_files(), [])

    def check_stream(self, words, name, **options):
        words = [word.format(name) if "{}" in word else word for word in words]
        self.remove_outputs()
        done = self.folder.camber(*words, **options)
        self.assertIn(done.returncode, (2, 3), f"{words}: {done.stderr}")
        self.assertRegex(done.stderr.splitlines()[-1], "known format|stream of more than|regular file|is no|expected|line 1")
        if words[0] != "adapt":  # it writes the mesh of each cycle
            self.assertEqual(self.new_files(), [])

    def test_every_reader_rejects_an_endless_device(self):
        memory = limited((resource.RLIMIT_AS, 1 << 30))
        for words in READS:
            with self.subTest(" ".join(words)):
                self.check_stream(words, "/dev/zero", preexec_fn=memory)

    def test_every_reader_rejects_a_file_name_linked_to_an_endless_device(self):
        memory = limited((resource.RLIMIT_AS, 1 << 30))
        for ending, words in ((".mesh", ("info", "{}")), (".vtu", ("check", "{}")), (".cgns", ("curve", "{}", "-o", "out.mesh")),
                              (".sol", ("remesh", "in.mesh", "-o", "out.mesh", "--metric", "{}")), (".json", ("run", "{}")),
                              (".step", ("curve", "in.mesh", "-o", "out.mesh", "--cad", "{}")),
                              (".brep", ("geometry", "in.mesh", "--cad", "{}"))):
            link = self.folder.path / ("endless" + ending)
            os.symlink("/dev/zero", link)
            try:
                with self.subTest(" ".join(words)):
                    self.inputs.append(link.name)
                    self.check_stream(words, link.name, preexec_fn=memory)
            finally:
                link.unlink()

    def test_an_endless_pipe_is_rejected(self):
        beginnings = ((b"y\n", "belongs to a known format"), (b"MeshVersionFormatted 2\nDimension 3\nVertices 9\n" + b"0 0 0 0\n" * 64,
                                                   "stream of more than"))
        for beginning, reason in beginnings:
            for words in (("check", "/dev/stdin"), ("info", "-"), ("curve", "-", "-o", "out.mesh")):
                with self.subTest(" ".join(words), beginning=beginning[:8]):
                    endless = f"import sys\nwhile True: sys.stdout.buffer.write({beginning!r} * 4096)"
                    with subprocess.Popen([sys.executable, "-c", endless], stdout=subprocess.PIPE,
                                          stderr=subprocess.DEVNULL) as writer:
                        done = self.folder.camber(*words, stdin=writer.stdout,
                                                  preexec_fn=limited((resource.RLIMIT_AS, 400 << 20)))
                        writer.stdout.close()
                        writer.wait()
                    self.check_refused(done, 3, reason)

    def test_a_mesh_is_read_from_a_pipe(self):
        mesh = (self.folder.path / "in.mesh").read_bytes()
        for words in (("info", "-"), ("check", "/dev/stdin")):
            done = subprocess.run([CAMBER, *words], input=mesh, capture_output=True, cwd=self.folder.path)
            self.assertEqual(done.returncode, 0, done.stderr)

    @unittest.skipIf(bad_moments.no_disk(), bad_moments.no_disk() or "")
    def test_a_full_disk_for_temporary_arrays_is_reported(self):

        self.inputs.append("large.meshb")
        done = self.folder.camber("generate", "box", "-o", "large.meshb", "--set", "cells=[20,20,20]")
        self.assertEqual(done.returncode, 0, done.stderr)
        os.makedirs(self.folder.path / "disk", exist_ok=True)
        script = 'mount -t tmpfs -o size=1m tmpfs disk && "$0" curve large.meshb -o disk/out.meshb --memory 50'
        done = subprocess.run(["unshare", "--mount", "sh", "-c", script, CAMBER], cwd=self.folder.path, capture_output=True,
                              text=True)
        self.check_refused(done, 3, "disk: temporary files of arrays cannot be written: No space left on device")

    def test_a_file_size_limit_of_temporary_arrays_is_reported(self):
        done = self.folder.camber("generate", "box", "-o", "large.meshb", "--set", "cells=[20,20,20]")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.inputs.append("large.meshb")
        done = self.folder.camber("curve", "large.meshb", "-o", "out.meshb", "--memory", "50",
                                  preexec_fn=limited((resource.RLIMIT_FSIZE, 300 << 10)))
        self.check_refused(done, 3, "temporary files of arrays cannot be written: File too large (raise the limit (ulimit -f))")
        self.assertEqual(self.new_files(), [])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
