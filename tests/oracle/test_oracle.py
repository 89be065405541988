"""Runs all self-tests of the oracle: python3 test_oracle.py.

With CAMBER_CASES set to a folder with the linear cases, they are elevated and compared with published
counts of invalid elements and smallest ratios (midpoints, boundary nodes on the exact spheres).
"""
import os
import unittest
from pathlib import Path

import check_p2
import gmf
import sample_meshes as samples
from test_gmf import *  # noqa: F401,F403
from test_mesh_checks import *  # noqa: F401,F403
from test_length_reduction import *  # noqa: F401,F403
from test_validity import *  # noqa: F401,F403


class PublishedCases(unittest.TestCase):
    """Invalid elements and smallest ratio with straight volume edges and exact spheres."""
    EXPECTED = {"spheres-coarse": (5, 1, 0, 0.304), "spheres-fine": (5, 1, 0, 0.782),
                "layer-single": (1, 5, 994, -1.54), "layer-double": (1, 5, 1496, -1.86)}

    @unittest.skipUnless(os.environ.get("CAMBER_CASES"), "CAMBER_CASES is not set")
    def test_published_counts_and_smallest_ratios_are_reproduced(self):
        for name, (first, second, invalid, smallest) in self.EXPECTED.items():
            linear = gmf.read(Path(os.environ["CAMBER_CASES"], name + ".meshb"))
            mesh = samples.elevate(linear)
            samples.push_to_sphere(mesh, 1, first)
            samples.push_to_sphere(mesh, 2, second)
            report, problems = check_p2.check(mesh, linear)
            self.assertEqual((report["invalid"], report["undecided"]), (invalid, 0), name)
            self.assertAlmostEqual(report["min_scaled_jacobian"], smallest, delta=0.005, msg=name)
            self.assertEqual(len(problems), 1 if invalid else 0, name)


if __name__ == "__main__":
    unittest.main()
