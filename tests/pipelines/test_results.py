"""The small rows of docs/results.json, measured again: pages show commands that give these figures.

    python3 tests/pipelines/test_results.py build/bin/camber [unittest arguments]
"""
import json
import sys
import unittest

from program import CAMBER, ROOT

sys.path.insert(0, str(ROOT / "bench"))
import results  # noqa: E402

KEPT = json.loads(results.RESULTS.read_text(encoding="utf-8"))
SMALL = {"configs": ["annulus-2d", "bump-2d", "polar-2d", "spheres"],
         "paper": ["paper-spheres-coarse relax"],
         "repair": ["paper-spheres-coarse 0.05 relax"],
         "curvature": ["circle-2d, default", "circle-2d, shape", "shock-2d, default"]}
TIMES = {"seconds", "megabytes"}  # of the machine


class Results(unittest.TestCase):
    def test_what_is_quoted_is_what_the_commands_give(self):
        program = results.Program(CAMBER, ROOT / "none", 2)
        for name, rows in SMALL.items():
            for row, found in results.measured(name, program, rows)["rows"].items():
                with self.subTest(table=name, row=row):
                    kept = KEPT[name]["rows"][row]
                    self.assertLessEqual(found.keys(), kept.keys())  # nothing is solved where no benchmarks are built
                    for key in found.keys() - TIMES:
                        self.assertAlmostEqual(found[key], kept[key], delta=1e-4 * abs(kept[key]) + 1e-12,
                                               msg=f"{name}/{row}/{key}: bench/results.py --only {name}")

    def test_tables_are_of_the_commands_and_rows_of_the_script(self):
        self.assertEqual(KEPT.keys(), results.TABLES.keys())
        for name, table in results.TABLES.items():
            with self.subTest(table=name):
                self.assertEqual((KEPT[name]["command"], KEPT[name]["of"]), (table.command, table.of))
                self.assertEqual(list(KEPT[name]["rows"]), list(table.rows))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=1)
