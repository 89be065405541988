"""Typical mistakes of new users and the answers of the program: the transcript mistakes.txt contains every message.
Each states place, mistake and remedy.

    python3 tests/pipelines/test_mistakes.py build/bin/camber [unittest arguments]
    python3 tests/pipelines/test_mistakes.py build/bin/camber --write      rewrite mistakes.txt
"""
import shlex
import sys
import unittest
from pathlib import Path

from made_meshes import lattice
from program import Folder

TRANSCRIPT = Path(__file__).with_name("mistakes.txt")
HEAD = "# Made by test_mistakes.py --write: `$` a command, its standard error, and its exit code in brackets.\n"

OTHER_SIZES = "MeshVersionFormatted 2\nDimension 3\nSolAtVertices 4\n1 1\n" + "1\n" * 4 + "End\n"

MISTAKES = [
    # words
    "",
    "curv wing.mesh -o out.mesh",
    "curve wing.mesh",
    "curve wing.mesh -o out.mesh --objektive shape",
    "curve wing.mesh -o out.mesh --objective shap",
    "curve wing.mesh -o out.mesh --geometry surogate",
    "curve wing.mesh -o out.mesh --set stages/curv/objective=shape",
    "curve wing.mesh -o out.mesh --set stages/curve/objectiv=shape",
    "generate shel -o out.mesh",
    "explain curv",
    # numbers
    "curve wing.mesh -o out.mesh --threads two",
    "check wing.mesh --min-scaled-jacobian 2",
    "remesh wing.mesh -o out.mesh --metric 0,1",
    "remesh wing.mesh -o out.mesh --metric",
    "remesh wing.mesh -o out.mesh --metric 0.1 --metric 0.2",
    "remesh wing.mesh -o out.mesh --size wall=0.1",
    # files
    "curve my wing.mesh -o out.mesh",
    "curve wing.mesh out.mesh",
    "check wind.mesh",
    "curve wing.mesh -o out/deep/out.mesh",
    "curve wing.mesh -o out.msg",
    "convert wing.mesh -o out.msh --format msh-asci",
    "curve wing.mesh -o -",
    "curve wing.step -o out.mesh",
    "picture wing.mesh -o wing.jpg",
    "picture wing.mesh -o wing.png --cut 0.5",
    "picture wing.mesh -o wing.png --cut x=-9",
    "picture wing.mesh -o wing.png --color quality",
    # combinations
    "repair wing.mesh -o out.mesh",
    "remesh wing.mesh -o out.mesh --metric other.sol",
    "curve wing.mesh -o out.mesh --cad-unit mm",
    "picture wing.mesh -o wing.png --colour solution",
    "picture wing.mesh -o wing.png --field u",
    "metric wing.mesh --solution other.sol -o m.sol --complexity 10 --elements 20",
    "curve wing.mesh -o out.mesh --objective shape --size 1=0.1",
    "curve wing.mesh -o out.mesh --size 1=0.1",
    "curve wing.mesh -o out.mesh --complexity 500",
    "curve wing.mesh -o out.mesh --verbose --quiet",
    "remesh wing.mesh -o out.mesh --memory 2G",
    # names of earlier versions
    "curve wing.mesh -o out.mesh --set stages/relax/repair=cavity",
    "curve wing.mesh -o out.mesh --set stages/relax/method=relax",
    "run old.json",
    "remesh wing.mesh -o out.mesh --objective as_curved",
    "adapt wing.mesh -o out.mesh --metric 0.5 --settled 0",
    "curve wing.mesh -o out.mesh --cad wing.step --cad-seconds 9",
    "plot old-report.json -o plots",
    "report old-report.json -o out.html",
    "explain kept_boundary",
    # options of Mmg
    "remesh -in wing.mesh -out out.mesh",
    "remesh wing.mesh out.mesh -o new.mesh",
    "remesh wing.mesh -o out.mesh -hausd 0.01",
    "remesh wing.mesh -o out.mesh --hausd 0.01",
    "remesh wing.mesh -o out.mesh --hsiz 0.1",
    "remesh wing.mesh -o out.mesh -hmax 0.1",
    "remesh wing.mesh -o out.mesh -hmin 0.01",
    "remesh wing.mesh -o out.mesh -hgrad 1.3",
    "remesh wing.mesh -o out.mesh -ar 30",
    "remesh wing.mesh -o out.mesh -nr",
    "remesh wing.mesh -o out.mesh -optim",
    "remesh wing.mesh -o out.mesh -sol other.sol",
    "remesh wing.mesh -o out.mesh -m 2000",
    "remesh wing.mesh -o out.mesh -v 5",
    # options of Gmsh
    "curve wing.mesh -o out.mesh --order 3",
    "curve wing.mesh -o out.mesh -order 2",
    "curve wing.mesh -o out.mesh --degree 3",
    "adapt wing.mesh -o out.mesh --metric 0.5 --degree 3",
    "curve wing.mesh -o out.mesh --optimize",
    "curve wing.mesh -o out.mesh -optimize_ho",
    "remesh wing.mesh -o out.mesh -clmax 0.1",
    "remesh wing.mesh -o out.mesh -clscale 0.5",
    "curve wing.mesh -o out.mesh -3",
    "curve wing.mesh -o out.msh -format msh41",
    "curve wing.mesh -o out.mesh -nt 4",
    "curve wing.mesh -output out.mesh",
    # habits from other programs
    "mesh wing.mesh -o out.mesh",
    "optimize wing.mesh -o out.mesh",
    "view wing.mesh",
    "elevate wing.mesh -o out.mesh",
    "help curv",
    "explain --hausd",
    "convert wing.mesh -o out.vtu --binary",
    "convert wing.mesh -o out.msh --overwrite",
    "curve wing.mesh --out out.mesh",
    "curve wing.mesh -o out.mesh --cat wing.step",
    "check wing.mesh --field 'x=0.5 ? 1 : 0'",
    # files of a wrong kind
    "curve wing.mesh -o wing.mesh",
    "convert wing.mesh -o wing.mesh",
    "curve wing.mesh -o 'my results/out.mesh'",
    "run wing.mesh",
    "run wrong.json",
    "curve wrong.json -o out.mesh",
    "info abaqus.inp",
]


def transcript():
    folder = Folder()
    try:
        (folder.path / "wing.mesh").write_text(lattice(3, 1).text())
        (folder.path / "wing.step").write_text("ISO-10303-21;\n")
        (folder.path / "other.sol").write_text(OTHER_SIZES)
        (folder.path / "wrong.json").write_text("$x\n")
        (folder.path / "old.json").write_text('{"input": {"mesh": "wing.mesh"}, "stages": ["mend"]}\n')
        (folder.path / "old-report.json").write_text('{"format": 4, "histograms": {}}\n')
        (folder.path / "abaqus.inp").write_text("*HEADING\n*NODE\n1, 0, 0, 0\n")
        text = HEAD
        for mistake in MISTAKES:
            before = folder.files()
            done = folder.camber(*shlex.split(mistake))
            assert folder.files() == before and not done.stdout, mistake
            text += f"\n$ camber {mistake}\n{done.stderr}[{done.returncode}]\n"
        return text
    finally:
        folder.cleanup()


class Mistakes(unittest.TestCase):
    maxDiff = None

    def test_answers_equal_those_of_the_transcript(self):
        self.assertEqual(transcript(), TRANSCRIPT.read_text(), "test_mistakes.py build/bin/camber --write")

    def test_each_answer_is_one_line_with_a_suggestion(self):
        for answer in TRANSCRIPT.read_text().split("\n$ camber ")[1:]:
            _, *message, code = answer.rstrip().splitlines()
            self.assertEqual(len(message), 1, answer)
            self.assertRegex(message[0], r"^camber: .*\(.*\)$")
            self.assertIn(code, ("[2]", "[3]"))

    def test_no_answer_suggests_the_command_that_was_typed(self):
        for answer in TRANSCRIPT.read_text().split("\n$ camber ")[1:]:
            command, message, *_ = answer.splitlines()
            verb = command.partition(" ")[0]
            if verb:
                self.assertNotRegex(message, rf"camber {verb}[),;]", answer)


if __name__ == "__main__":
    if "--write" in sys.argv:
        TRANSCRIPT.write_text(transcript())
    else:
        unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
