"""The process that reads CAD models apart: what libraries do on damaged files does not end this one."""

import sys

from . import _camber

if __name__ == "__main__":
    sys.exit(_camber.read_cad(["camber", *sys.argv[1:]]))
