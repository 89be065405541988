"""Runs the Python examples: scripts, and the code of notebooks."""
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


def output_of(name):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        runpy.run_path(os.path.join(FOLDER, name), run_name="__main__")
    return out.getvalue()


class Examples(unittest.TestCase):
    def test_example_loop_runs_six_cycles_and_reaches_an_l2_error_of_1e_3(self):
        need(self, "scipy")
        output = output_of("loop.py")
        errors = [float(x) for x in re.search(r"error in L2 (\S+), in H1 (\S+)", output).groups()]
        self.assertLess(errors[0], 1e-3)
        self.assertEqual(output.count("cycle "), 6)

    def test_example_loop_has_at_most_25_lines(self):
        with open(os.path.join(FOLDER, "loop.py")) as file:
            self.assertLessEqual(sum(1 for line in file if line.strip()), 25)

    def test_example_gmsh_part_curves_a_gmsh_model(self):
        need(self, "gmsh")
        output = output_of("gmsh_part.py")
        self.assertIn("degree 2", output)
        self.assertIn("all", output)

    def test_the_notebook_runs_and_is_stored_without_outputs(self):
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
