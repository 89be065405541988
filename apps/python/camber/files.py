"""Mesh files in all formats of the program (docs/formats.md), and the CAD reader process."""

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
    """Read a mesh with its fields (`Mesh.fields`).

    flat: meaning of triangles without tetrahedra that all have the same z: "plane", a 2D mesh, written with its z again,
        or "surface", a surface in space.
    reference_array: cell array with the references (.vtu, .vtk).
    zone: number or name of the zone to read (.su2, .cgns); default: all.

    Raises InputError with the place in the file.
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
    """Write a mesh to a file, with its fields if the format supports them.

    format: name of the format, for any ending: "gmf-binary", "msh-ascii" …; default: the format of the ending.

    Data that the format cannot hold is logged ("camber"). Raises UsageError, WriteError.
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
    """Return the command of the process that reads CAD models, so that a crash on a damaged file does not end this one.

    It is Python with only the extension; empty if Python is embedded in another program.
    """
    return [sys.executable, "-I", "-c", _CAD_READER, extension] if sys.executable else []
