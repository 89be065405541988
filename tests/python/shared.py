"""Common code of the tests of the package: python3 test_NAME.py BUILD_DIRECTORY PROGRAM [unittest arguments]."""
import functools
import os
import subprocess
import sys
import unittest

BUILD, PROGRAM = sys.argv[1:3]
sys.path.insert(0, os.path.join(BUILD, "python"))

import numpy as np  # noqa: E402

import camber  # noqa: E402


def program(*words):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise AssertionError(done.stderr)
    return done


@functools.lru_cache
def shell():
    """A small straight mesh between spheres of radii 1 and 2."""
    return camber.generate("shell", set={"outer_radius": 2, "inner_size": 0.6, "outer_size": 0.9})


@functools.lru_cache
def square(n=8):
    """A straight mesh of the unit square."""
    return camber.generate("rectangle", set={"cells": [n, n]})


def arrays(mesh):
    """The arrays of a mesh, for comparisons; corners and other lists are not among them."""
    parts = mesh.cells, mesh.references
    return [mesh.points.tolist(), mesh.names, *[{k: v.tolist() for k, v in part.items()} for part in parts]]


def two_tetrahedra():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    return points, np.array([[0, 1, 2, 3], [1, 2, 3, 4]])


def main():
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
