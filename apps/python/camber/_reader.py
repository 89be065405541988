"""The process that reads CAD models apart: what libraries do on damaged files does not end this one."""

from __future__ import annotations

import sys

_START = """
import sys
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
path = sys.argv.pop(1)
spec = spec_from_file_location("_camber", path, loader=ExtensionFileLoader("_camber", path))
module = module_from_spec(spec)
spec.loader.exec_module(module)
sys.exit(module.read_cad(["camber", *sys.argv[1:]]))
"""


def words(extension: str) -> list[str]:
    """By which Python with nothing but the extension is started; none where Python is a part of another program."""
    return [sys.executable, "-I", "-c", _START, extension] if sys.executable else []
