"""The examples in Python, as their readers run them: scripts, and the code of notebooks."""
import contextlib
import io
import json
import os
import re
import runpy
import unittest

import shared
from test_exchange import need

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "python")


def said_by(name):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        runpy.run_path(os.path.join(FOLDER, name), run_name="__main__")
    return out.getvalue()


class Examples(unittest.TestCase):
    def test_the_loop(self):
        need(self, "scipy")
        said = said_by("loop.py")
        errors = [float(x) for x in re.search(r"error in L2 (\S+), in H1 (\S+)", said).groups()]
        self.assertLess(errors[0], 1e-3)
        self.assertEqual(said.count("cycle "), 6)

    def test_the_loop_is_short(self):
        with open(os.path.join(FOLDER, "loop.py")) as file:
            self.assertLessEqual(sum(1 for line in file if line.strip()), 25)

    def test_a_part_of_gmshs(self):
        need(self, "gmsh")
        said = said_by("gmsh_part.py")
        self.assertIn("degree 2", said)
        self.assertIn("all", said)

    def test_the_notebook(self):
        need(self, "matplotlib")
        import matplotlib

        matplotlib.use("Agg")
        with open(os.path.join(FOLDER, "size_share.ipynb")) as file:
            notebook = json.load(file)
        self.assertEqual(notebook["nbformat"], 4)
        names = {}
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            for cell in notebook["cells"]:
                if cell["cell_type"] == "code":
                    self.assertEqual(cell["outputs"], [], "kept without outputs")
                    exec(compile("".join(cell["source"]), "size_share.ipynb", "exec"), names)
        self.assertEqual(out.getvalue().count("times better than straight"), len(names["shares"]))
        self.assertGreater(max(names["gains"]), 1)


if __name__ == "__main__":
    shared.main()
