"""Files of meshes, in all formats that the program reads and writes (docs/formats.md), and the reader of CAD files."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Any, Literal

from . import _camber
from .exceptions import UsageError
from .mesh import Mesh, _log, _tell, mesh_of


def read(
    path: str | os.PathLike[str],
    *,
    flat: Literal["plane", "surface"] = "plane",
    reference_array: str | None = None,
    zone: str | None = None,
    progress: Callable[[str, float], Any] | None = None,
) -> Mesh:
    """The mesh of a file, with its fields (`Mesh.fields`).

    flat: what triangles without tetrahedra and of one z are: "plane", a mesh in 2D, written with its z again, or
        "surface", one in space.
    reference_array: the array of cells that has their references (.vtu, .vtk).
    zone: the zone to read, by its number or name (.su2, .cgns); default: all.

    Raises InputError: what is wrong with the file, and where.
    """
    if flat not in ("plane", "surface"):
        raise UsageError(f'is "{flat}"', "flat", remedy='give "plane" or "surface"')
    words = ["info", os.fspath(path)]
    if reference_array is not None:
        words.append(f"--reference-array={reference_array}")
    if zone is not None:
        words.append(f"--zone={zone}")
    mesh = Mesh._of(_camber.read(os.fspath(path), flat, words, progress))
    _tell(mesh)
    return mesh


def write(
    path: str | os.PathLike[str],
    mesh: Any,
    *,
    format: str = "",
    progress: Callable[[str, float], Any] | None = None,
) -> None:
    """Write a mesh to a file, with its fields where the format has a place for them.

    format: the format's name, whatever the ending: "gmf-binary", "msh-ascii" …; default: that of the ending.

    What the format cannot hold is logged ("camber"). Raises UsageError, WriteError.
    """
    of = mesh_of(mesh)
    for loss in _camber.write(of._handle, dict(of.fields), os.fspath(path), format, progress):
        _log.warning("%s: %s", os.fspath(path), loss)


_CAD_READER = """
import sys
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
path = sys.argv.pop(1)
spec = spec_from_file_location("_camber", path, loader=ExtensionFileLoader("_camber", path))
module = module_from_spec(spec)
spec.loader.exec_module(module)
sys.exit(module.read_cad(["camber", *sys.argv[1:]]))
"""


def cad_reader(extension: str) -> list[str]:
    """The command of the process that reads CAD models apart: what libraries do on damaged files does not end this one.

    Python with nothing but the extension; none where Python is a part of another program.
    """
    return [sys.executable, "-I", "-c", _CAD_READER, extension] if sys.executable else []
