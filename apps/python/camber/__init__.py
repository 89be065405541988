"""Camber: curved (P2) meshes of triangles and tetrahedra, always valid, adapted to a metric and to the geometry.

    import camber

    mesh = camber.read("wing.meshb")                       # or camber.Mesh(points, {"tetra": cells})
    made = camber.curve(mesh, cad="wing.step")             # made.mesh, made.report
    finer = camber.remesh(mesh, metric=M)                  # M: (v,) sizes or (v, D, D) tensors
    made = camber.adapt(mesh, solve=solver, complexity=5000)
    print(camber.check(made)["table"])

The verbs are those of the program, with its arguments as keywords and the same results. Meshes are immutable and share
their memory with numpy. Errors are exceptions (`camber.exceptions`); notices go to the logger "camber".
"""

from . import _camber, exceptions, exchange, files, metric, plots
from ._verbs import elevate, errors, run, validate
from .exceptions import (
    Error,
    InputError,
    InternalError,
    NotCertified,
    OutOfMemory,
    Stopped,
    UnsupportedError,
    UsageError,
    WriteError,
)
from .exchange import from_gmsh, from_meshio, from_pyvista, from_vtk, to_dolfinx, to_meshio, to_pyvista, to_skfem, to_vtk
from .files import read, write
from .mesh import Made, Mesh
from .verbs import adapt, check, curve, generate, geometry, remesh, repair, transfer

__version__: str = _camber.version

_camber.start_itself_by(files.cad_reader(_camber.__file__))


__all__ = [
    "Error", "InputError", "InternalError", "Made", "Mesh", "NotCertified", "OutOfMemory", "Stopped", "UnsupportedError",
    "UsageError", "WriteError", "adapt", "check", "curve", "elevate",
    "errors", "exceptions", "exchange", "files", "from_gmsh", "from_meshio", "from_pyvista", "from_vtk", "generate", "geometry",
    "metric", "plots", "read", "remesh", "repair", "run", "to_dolfinx", "to_meshio", "to_pyvista", "to_skfem", "to_vtk",
    "transfer", "validate", "write",
]
