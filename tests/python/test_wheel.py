"""The wheel, installed in a virtual environment with the numpy of the system."""
import os
import subprocess
import sys
import tempfile
import unittest

import shared
from shared import BUILD

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")

SCRIPT = """
import sys, numpy as np, camber
assert "site-packages" in camber.__file__, camber.__file__
made = camber.curve(camber.generate("shell", set={"inner_size": 0.6, "outer_size": 0.6}))
assert made.success and camber.check(made)["success"]
print(camber.__version__, len(made.mesh.elements))
"""


def run(*words, **options):
    done = subprocess.run(words, capture_output=True, text=True, **options)
    if done.returncode:
        raise AssertionError(f"{words}: {done.stdout}{done.stderr}")
    return done.stdout


class Wheel(unittest.TestCase):
    def test_the_wheel_is_installed_and_curves_a_mesh(self):
        with tempfile.TemporaryDirectory() as folder:
            made = run(sys.executable, os.path.join(SOURCE, "apps", "python", "make_wheel.py"), BUILD, folder).strip()
            python = os.path.join(folder, "venv", "bin", "python3")
            run(sys.executable, "-m", "venv", "--system-site-packages", os.path.join(folder, "venv"))
            run(python, "-m", "pip", "install", "--no-index", "--no-deps", made)
            environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
            self.assertRegex(run(python, "-c", SCRIPT, cwd=folder, env=environment), r"^\d+\.\d+")


if __name__ == "__main__":
    shared.main()
