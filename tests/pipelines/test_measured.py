"""Repeats two fast measured tables of the pages: their commands print the stored figures.

    python3 tests/pipelines/test_measured.py build/bin/camber [unittest arguments]

After a change of results: bench/tables.py --only circle configs --write, and the other tables that the change affects.
"""
import subprocess
import sys
import unittest

from program import CAMBER, ROOT


class Measured(unittest.TestCase):
    # Guards against tables that do not belong to their commands.
    def test_table_commands_print_the_stored_figures(self):
        done = subprocess.run([sys.executable, str(ROOT / "bench" / "tables.py"), "--camber", str(CAMBER), "--only", "circle", "configs"],
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=1)
