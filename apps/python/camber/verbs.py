"""The verbs: `camber curve`, `remesh`, `repair`, `adapt`, `check`, `geometry`, `transfer` and `generate` over meshes in
memory, with the program's own arguments as keywords.

Made by make_verbs.py from the descriptions of the program's arguments: `camber curve --help`. None is the default
everywhere: what the program does without the argument.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from . import _verbs
from .mesh import Made, Mesh

Progress = Callable[[str, float], Any]


@_verbs.with_new_names
def curve(
    mesh: Any,
    *,
    metric: str | float | np.ndarray | Mapping[str, Any] | None = None,
    size: Mapping[int | str, float] | Sequence[str] | None = None,
    geometry_error: float | Literal["none"] | None = None,
    gradation: float | None = None,
    complexity: float | None = None,
    geometry: str | Mapping[str, Any] | Mesh | Made | None = None,
    cad: str | None = None,
    cad_unit: Literal["auto", "file", "m", "cm", "mm", "um", "in", "ft"] | None = None,
    cad_vertices: Literal["keep", "move"] | None = None,
    cad_timeout: float | None = None,
    cad_memory: float | None = None,
    geometry_tolerance: float | None = None,
    objective: Literal["accuracy", "energy", "length", "shape", "solution"] | None = None,
    min_scaled_jacobian: float | None = None,
    solution: str | np.ndarray | Mapping[str, Any] | None = None,
    fields: Sequence[str] | None = None,
    transfer: Literal["interpolate", "conserve"] | None = None,
    vtu: str | None = None,
    plots: str | None = None,
    page: str | None = None,
    set: Mapping[str, Any] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Made:
    """Curve a straight mesh: elevate, curve, validate, relax, commit.

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    metric: natural, a size such as 0.1, solution (what interpolates solution best), a file (.sol, .solb, or a mesh
        file with its field metric), or JSON such as '{"field": {"polar-1": {}}}'. Or an array at the vertices:
        sizes (v,) or tensors (v, D, D). Default: natural.
    size: A size at boundary facets by their reference, as 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE with facets,
        edges, vertices or elements. Or {reference: size}.
    geometry_error: Largest distance of the boundary from its geometry, both ways. The metric gets the sizes for it;
        remesh refines until it is met, or ends with `success` is False. Default: remesh makes no facet that is
        farther than a hundredth of the size of its surface, or that turns by more than 30 degrees, with degree 2 by
        90; none: any. In (0, inf).
    gradation: Largest ratio of the metric's sizes at adjacent edges; 0: not limited. Default: 2.5 for the metric of
        a solution, others as they are. In (1, 1000].
    complexity: Scale the metric, once it is graded, to this complexity: about 12 times as many tetrahedra, 2.6
        times as many triangles. Default: as the metric is. In (0, inf).
    geometry: surrogate (from the mesh), straight, or JSON such as '{"analytic": [{"references": [1], "sphere":
        {"radius": 5}}]}' or '{"mesh": "first.meshb"}': the boundary of another mesh of the body. Or a mesh: its
        boundary. Default: surrogate.
    cad: The CAD model that the boundary is put onto (.step, .stp, .iges, .igs or .brep); geometry may have analytic
        surfaces beside it, by reference.
    cad_unit: The unit of the mesh's coordinates, to which the CAD model is converted. Default: auto, that of the
        model's file if the mesh's boundary lies on the model in it, else the only unit in which it does.
    cad_vertices: Vertices of the boundary that are off the CAD model: keep, or move them onto it first. Default:
        keep, and too many of them are an error.
    cad_timeout: How long reading the CAD model may take (s). Default: 10, and 1 for each megabyte of its file. In
        [0, inf).
    cad_memory: How much memory reading the CAD model may take (MB). Default: 1000, and 50 times its file. In [0,
        inf).
    geometry_tolerance: Largest distance of the node of a boundary edge from its geometry; nodes beyond it:
        `success` is False. Default: 1e-5. In [0, inf).
    objective: What edges are curved for: accuracy, that what the metric belongs to is interpolated well; energy or
        length, that this is least in the metric (energy: smooth, evenly spaced); shape: no metric, the Jacobians of
        elements are made as even as may be; solution: that the run's solution is interpolated well, no metric.
        Default: solution where there is solution and no metric, else accuracy.
    min_scaled_jacobian: Every element's scaled Jacobian must be at least this, from 0 and below 1; what is not:
        `success` is False. Without it 0.1 is recommended: what is below is a note. In [0, 1).
    solution: Fields on the input that go along: rows at its vertices or nodes, a file of the same mesh with fields,
        or an expression such as 'tanh((x-y)/0.05)' of its nodes. curve places inner nodes where these are
        interpolated best, but for a metric or an objective. Default: the fields of the input's own file. Or an
        array, or {name: array}, at the vertices or nodes: (n,), (n, D), (n, D, D).
    fields: Names of the fields to take. Default: all.
    transfer: Interpolate: the old field at the new nodes; conserve: where elements changed the nearest field in L2
        that keeps the integrals by material.
    vtu: Also write the mesh with the run's fields for ParaView (.vtu).
    plots: Also write histograms as SVG files into this folder.
    page: Also write the mesh and the figures as a page for a browser (.html).
    set: Override one option of the config: path=value, e.g. stages/curve/objective=length. Or {path: value}.
    threads: Threads to use; 0: all. The result does not depend on it. In [0, inf).
    progress: called with the stage and its share, from 0 to 1, now and then; False from it stops the work, and
        Stopped is raised.
    """
    options = locals()
    return _verbs.curve(options)


@_verbs.with_new_names
def remesh(
    mesh: Any,
    *,
    metric: str | float | np.ndarray | Mapping[str, Any] | None = None,
    size: Mapping[int | str, float] | Sequence[str] | None = None,
    geometry_error: float | Literal["none"] | None = None,
    gradation: float | None = None,
    complexity: float | None = None,
    geometry: str | Mapping[str, Any] | Mesh | Made | None = None,
    cad: str | None = None,
    cad_unit: Literal["auto", "file", "m", "cm", "mm", "um", "in", "ft"] | None = None,
    cad_vertices: Literal["keep", "move"] | None = None,
    cad_timeout: float | None = None,
    cad_memory: float | None = None,
    geometry_tolerance: float | None = None,
    rounds: int | None = None,
    blocks: int | None = None,
    objective: Literal["auto", "accuracy", "energy", "length"] | None = None,
    solution: str | np.ndarray | Mapping[str, Any] | None = None,
    fields: Sequence[str] | None = None,
    transfer: Literal["interpolate", "conserve"] | None = None,
    vtu: str | None = None,
    plots: str | None = None,
    page: str | None = None,
    set: Mapping[str, Any] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Made:
    """Bring a mesh, straight or curved, to a metric: split, collapse, swap and smooth until its edges are of unit
    length.

    References, materials, interfaces, ridges, listed curves, corners and whatever is required are kept; new
    vertices of the boundary lie on the geometry: a smooth surface through its vertices, and nodes where it is
    curved. Where a mesh is remeshed many times, each time from the one before, give the first one as the geometry,
    or the CAD model: the boundary then stays where it was. A mesh of degree 2 stays one: edges are measured along
    their curves, and every element that is made is valid. To curve what comes of a straight one onto the same
    geometry, put "remesh" before "elevate" in a config (configs/remesh.json). How it is done:
    docs/algorithms/cavity-operator.md

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    metric: natural, a size such as 0.1, solution (what interpolates solution best), a file (.sol, .solb, or a mesh
        file with its field metric), or JSON such as '{"field": {"polar-1": {}}}'. Or an array at the vertices:
        sizes (v,) or tensors (v, D, D). Default: natural.
    size: A size at boundary facets by their reference, as 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE with facets,
        edges, vertices or elements. Or {reference: size}.
    geometry_error: Largest distance of the boundary from its geometry, both ways. The metric gets the sizes for it;
        remesh refines until it is met, or ends with `success` is False. Default: remesh makes no facet that is
        farther than a hundredth of the size of its surface, or that turns by more than 30 degrees, with degree 2 by
        90; none: any. In (0, inf).
    gradation: Largest ratio of the metric's sizes at adjacent edges; 0: not limited. Default: 2.5 for the metric of
        a solution, others as they are. In (1, 1000].
    complexity: Scale the metric, once it is graded, to this complexity: about 12 times as many tetrahedra, 2.6
        times as many triangles. Default: as the metric is. In (0, inf).
    geometry: surrogate (from the mesh), straight, or JSON such as '{"analytic": [{"references": [1], "sphere":
        {"radius": 5}}]}' or '{"mesh": "first.meshb"}': the boundary of another mesh of the body. Or a mesh: its
        boundary. Default: surrogate.
    cad: The CAD model that the boundary is put onto (.step, .stp, .iges, .igs or .brep); geometry may have analytic
        surfaces beside it, by reference.
    cad_unit: The unit of the mesh's coordinates, to which the CAD model is converted. Default: auto, that of the
        model's file if the mesh's boundary lies on the model in it, else the only unit in which it does.
    cad_vertices: Vertices of the boundary that are off the CAD model: keep, or move them onto it first. Default:
        keep, and too many of them are an error.
    cad_timeout: How long reading the CAD model may take (s). Default: 10, and 1 for each megabyte of its file. In
        [0, inf).
    cad_memory: How much memory reading the CAD model may take (MB). Default: 1000, and 50 times its file. In [0,
        inf).
    geometry_tolerance: Largest distance of the node of a boundary edge from its geometry; nodes beyond it:
        `success` is False. Default: 1e-5. In [0, inf).
    rounds: At most so many rounds of collapse, split, swap and smooth; they end where nothing changes much. In [0,
        1000].
    blocks: Of a straight mesh: elements in a block, each of which is brought to the metric by itself while what it
        shares with others stays, then again in other blocks; 0: the mesh as a whole. In [0, inf).
    objective: Degree 2: what inner edges are curved for, as in the stage curve: accuracy, energy or length; auto:
        that of a stage curve before, else accuracy. Default: auto.
    solution: Fields on the input that go along: rows at its vertices or nodes, a file of the same mesh with fields,
        or an expression such as 'tanh((x-y)/0.05)' of its nodes. curve places inner nodes where these are
        interpolated best, but for a metric or an objective. Default: the fields of the input's own file. Or an
        array, or {name: array}, at the vertices or nodes: (n,), (n, D), (n, D, D).
    fields: Names of the fields to take. Default: all.
    transfer: Interpolate: the old field at the new nodes; conserve: where elements changed the nearest field in L2
        that keeps the integrals by material.
    vtu: Also write the mesh with the run's fields for ParaView (.vtu).
    plots: Also write histograms as SVG files into this folder.
    page: Also write the mesh and the figures as a page for a browser (.html).
    set: Override one option of the config: path=value, e.g. stages/curve/objective=length. Or {path: value}.
    threads: Threads to use; 0: all. The result does not depend on it. In [0, inf).
    progress: called with the stage and its share, from 0 to 1, now and then; False from it stops the work, and
        Stopped is raised.
    """
    options = locals()
    return _verbs.remesh(options)


@_verbs.with_new_names
def repair(
    mesh: Any,
    *,
    boundary_tolerance: float | None = None,
    geometry: str | Mapping[str, Any] | Mesh | Made | None = None,
    cad: str | None = None,
    cad_unit: Literal["auto", "file", "m", "cm", "mm", "um", "in", "ft"] | None = None,
    cad_vertices: Literal["keep", "move"] | None = None,
    cad_timeout: float | None = None,
    cad_memory: float | None = None,
    geometry_tolerance: float | None = None,
    min_scaled_jacobian: float | None = None,
    solution: str | np.ndarray | Mapping[str, Any] | None = None,
    fields: Sequence[str] | None = None,
    transfer: Literal["interpolate", "conserve"] | None = None,
    vtu: str | None = None,
    plots: str | None = None,
    page: str | None = None,
    set: Mapping[str, Any] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Made:
    """Repair a curved mesh made elsewhere: validate, relax, commit.

    The boundary stays as it is, bit for bit, interfaces between materials too: nodes of the volume move, and, if
    need be, its vertices. With cad, or analytic surfaces, the boundary's nodes are first put onto these, and slide
    on them where nothing else helps. With boundary_tolerance T the nodes of boundary edges may move too where
    nothing else helps, each by T at most (between them the surface then moves by 4/3 T at most); boundary vertices
    never do. Elements that cannot be repaired are listed with the reason, the mesh is written with them, and
    `success` is False. How it is done: docs/algorithms/repair.md

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    boundary_tolerance: How far the node of a boundary edge may move, in model units; 0 (the default): not at all.
        In [0, inf).
    geometry: surrogate (from the mesh), straight, or JSON such as '{"analytic": [{"references": [1], "sphere":
        {"radius": 5}}]}' or '{"mesh": "first.meshb"}': the boundary of another mesh of the body. Or a mesh: its
        boundary. Default: surrogate.
    cad: The CAD model that the boundary is put onto (.step, .stp, .iges, .igs or .brep); geometry may have analytic
        surfaces beside it, by reference.
    cad_unit: The unit of the mesh's coordinates, to which the CAD model is converted. Default: auto, that of the
        model's file if the mesh's boundary lies on the model in it, else the only unit in which it does.
    cad_vertices: Vertices of the boundary that are off the CAD model: keep, or move them onto it first. Default:
        keep, and too many of them are an error.
    cad_timeout: How long reading the CAD model may take (s). Default: 10, and 1 for each megabyte of its file. In
        [0, inf).
    cad_memory: How much memory reading the CAD model may take (MB). Default: 1000, and 50 times its file. In [0,
        inf).
    geometry_tolerance: Largest distance of the node of a boundary edge from its geometry; nodes beyond it:
        `success` is False. Default: 1e-5. In [0, inf).
    min_scaled_jacobian: Every element's scaled Jacobian must be at least this, from 0 and below 1; what is not:
        `success` is False. Without it 0.1 is recommended: what is below is a note. In [0, 1).
    solution: Fields on the input that go along: rows at its vertices or nodes, a file of the same mesh with fields,
        or an expression such as 'tanh((x-y)/0.05)' of its nodes. curve places inner nodes where these are
        interpolated best, but for a metric or an objective. Default: the fields of the input's own file. Or an
        array, or {name: array}, at the vertices or nodes: (n,), (n, D), (n, D, D).
    fields: Names of the fields to take. Default: all.
    transfer: Interpolate: the old field at the new nodes; conserve: where elements changed the nearest field in L2
        that keeps the integrals by material.
    vtu: Also write the mesh with the run's fields for ParaView (.vtu).
    plots: Also write histograms as SVG files into this folder.
    page: Also write the mesh and the figures as a page for a browser (.html).
    set: Override one option of the config: path=value, e.g. stages/curve/objective=length. Or {path: value}.
    threads: Threads to use; 0: all. The result does not depend on it. In [0, inf).
    progress: called with the stage and its share, from 0 to 1, now and then; False from it stops the work, and
        Stopped is raised.
    """
    options = locals()
    return _verbs.repair(options)


@_verbs.with_new_names
def adapt(
    mesh: Any,
    *,
    solve: Callable[[Mesh, Mapping[str, np.ndarray], int], Any] | None = None,
    solution: str | np.ndarray | Mapping[str, Any] | None = None,
    fields: Sequence[str] | None = None,
    metric: str | float | np.ndarray | Mapping[str, Any] | None = None,
    field: str | None = None,
    complexity: float | Sequence[float] | None = None,
    norm: float | None = None,
    error_of: Literal["values", "gradients"] | None = None,
    min_size: float | None = None,
    max_size: float | None = None,
    max_anisotropy: float | None = None,
    size: Mapping[int | str, float] | Sequence[str] | None = None,
    geometry_error: float | Literal["none"] | None = None,
    gradation: float | None = None,
    cycles: int | None = None,
    degree: int | None = None,
    convergence_tolerance: float | None = None,
    result: Literal["auto", "best", "last"] | None = None,
    geometry: str | Mapping[str, Any] | Mesh | Made | None = None,
    cad: str | None = None,
    cad_unit: Literal["auto", "file", "m", "cm", "mm", "um", "in", "ft"] | None = None,
    cad_vertices: Literal["keep", "move"] | None = None,
    cad_timeout: float | None = None,
    cad_memory: float | None = None,
    geometry_tolerance: float | None = None,
    transfer: Literal["interpolate", "conserve"] | None = None,
    min_scaled_jacobian: float | None = None,
    set: Mapping[str, Any] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Made:
    """Adapt a mesh to a solution, cycle after cycle: metric, remesh, curve, transfer; and the solver in between.

    A cycle takes the mesh and its solution, makes the metric of so many elements that interpolates it best,
    remeshes, puts the edges' nodes where it is interpolated best, and brings the solution to the new mesh; every
    mesh is valid. The boundary stays on the geometry: that of geometry or cad, else the first mesh's. Cycles end
    when the error has converged (convergence_tolerance), after cycles of them, or by Ctrl-C; the mesh with the
    least error is then in OUTPUT (result). How it works: docs/algorithms/adaptation.md

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    solve: called with each mesh, the solution before brought to it ({} of the first), and the cycle; gives the
        solution on it, an array or {name: array} at its vertices or nodes.
    solution: The solution on the mesh: a file of rows at its vertices or nodes, or of the same mesh with fields;
        one cycle, as the next mesh's is not known. Or an expression such as 'tanh((x-y)/0.05)', which is known
        everywhere. Or an array, or {name: array}, at the vertices or nodes: (n,), (n, D), (n, D, D).
    fields: Names of the fields to take. Default: all.
    metric: A metric instead: a size, a file (.sol, .solb, or a mesh file with its field metric), or JSON such as
        '{"field": {"polar-1": {}}}'. Or an array at the vertices: sizes (v,) or tensors (v, D, D).
    field: The exact solution as an expression: its errors are told by cycle. Alone: adapted to as well.
    complexity: Complexity of the metric, one a cycle, the last for all after it: about 12 times as many tetrahedra,
        2.6 times as many triangles. Default: as many elements as the mesh has. In (0, inf).
    norm: Exponent p of the L^p norm of the error; 0: the largest error anywhere; H1: as norm 2 error_of gradients.
        In [0, inf). Default: 2.
    error_of: What the norm is of: the error's values, or its gradients.
    min_size: Smallest size; 0: none. In [0, inf). Default: 0.
    max_size: Largest size; 0: the domain's diameter. In [0, inf). Default: 0.
    max_anisotropy: Largest ratio of sizes; 0: none, but for the 1e5 that derivatives alone may ask for; a larger
        one raises that. In [0, inf). Default: 0.
    size: A size at boundary facets by their reference, as 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE with facets,
        edges, vertices or elements. Or {reference: size}.
    geometry_error: Largest distance of the boundary from its geometry, both ways; what the result misses is
        `success` is False. Default: by the expected error of the solution, what misses that is a note, and no facet
        is made that is farther than with remesh; none: any. In (0, inf).
    gradation: Largest ratio of the metric's sizes at adjacent edges; 0: not limited. Default: 2.5 for the metric of
        a solution, others as they are. In (1, 1000].
    cycles: So many cycles at most; they end where the error has converged. Default: 8, of a solution's file 1. In
        [1, 1000].
    degree: Of the meshes that are made: 1, straight, or 2, curved. In [1, 2]. Default: 2.
    convergence_tolerance: Cycles end once the least error of the last complexity has fallen by no more than this
        share over two cycles; without an error, once the unit edges in the metric of the mesh's own solution rise
        by no more than a fifth of it in one; 0: never before their number. In [0, 1]. Default: 0.1.
    result: Best: the mesh with the least error among those of the last complexity; last: the mesh of the last
        cycle; auto: last if the solver's command has {cycle}, with which each cycle may solve another problem,
        otherwise best.
    geometry: surrogate (from the mesh), straight, or JSON such as '{"analytic": [{"references": [1], "sphere":
        {"radius": 5}}]}' or '{"mesh": "first.meshb"}': the boundary of another mesh of the body. Or a mesh: its
        boundary. Default: surrogate.
    cad: The CAD model that the boundary is put onto (.step, .stp, .iges, .igs or .brep); geometry may have analytic
        surfaces beside it, by reference.
    cad_unit: The unit of the mesh's coordinates, to which the CAD model is converted. Default: auto, that of the
        model's file if the mesh's boundary lies on the model in it, else the only unit in which it does.
    cad_vertices: Vertices of the boundary that are off the CAD model: keep, or move them onto it first. Default:
        keep, and too many of them are an error.
    cad_timeout: How long reading the CAD model may take (s). Default: 10, and 1 for each megabyte of its file. In
        [0, inf).
    cad_memory: How much memory reading the CAD model may take (MB). Default: 1000, and 50 times its file. In [0,
        inf).
    geometry_tolerance: Largest distance of the node of a boundary edge from its geometry; nodes beyond it:
        `success` is False. Default: 1e-5. In [0, inf).
    transfer: Interpolate: the old field at the new nodes; conserve: where elements changed the nearest field in L2
        that keeps the integrals by material.
    min_scaled_jacobian: Every element's scaled Jacobian must be at least this, from 0 and below 1; what is not:
        `success` is False. Without it 0.1 is recommended: what is below is a note. In [0, 1).
    set: Override one option of the config: path=value, e.g. stages/curve/objective=length. Or {path: value}.
    threads: Threads to use; 0: all. The result does not depend on it. In [0, inf).
    progress: called with the stage and its share, from 0 to 1, now and then; False from it stops the work, and
        Stopped is raised.
    """
    options = locals()
    return _verbs.adapt(options)


@_verbs.with_new_names
def check(
    mesh: Any,
    *,
    min_scaled_jacobian: float | None = None,
    ridge_angle: float | None = None,
    worst: int | None = None,
    field: str | Sequence[str] | None = None,
    metric: str | float | np.ndarray | Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Is it a good mesh? Of any mesh of degree 1 or 2, made by whatever program; nothing is changed.

    An element of degree 2 is valid where det J is positive everywhere; its scaled Jacobian is the smallest det J as
    a share of that of the straight element with the same vertices (other programs mean Knupp's measure by the
    name). Of a straight mesh the quality is told: the mean ratio. Beyond its elements the mesh is examined:
    conformity, orientation, nodes, boundary, and whether walls pass through each other, curved as they are. Of a
    field (x, y, z, pi, + - * / ^, c ? a : b, sqrt, exp, tanh ...) the errors of its interpolants are told, in L2
    and H1: of degree 1 and 2 with straight edges, and of the mesh as it is; a ratio straight / as it is above 1
    says that curvature pays at equal unknowns (docs/algorithms/interpolation-error.md). In a metric an element of
    degree 2 has the quality 1 / mean distortion: 1 is unit, 0 folded (docs/algorithms/distortion.md). What each
    line means: docs/algorithms/check.md

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    min_scaled_jacobian: What an element's scaled Jacobian must reach to be valid, from 0 and below 1. In [0, 1).
        Default: 0.
    ridge_angle: Faces of the boundary that turn by less than this (degrees) are one smooth wall. In [0, 180].
        Default: 40.
    worst: How many of the worst elements to show. In [0, 1000000]. Default: 10.
    field: An expression of x, y (and z) whose interpolants' errors are told.
    metric: A metric file: lengths of edges and qualities of elements in it are told, and how many edges are of unit
        length; of degree 2 straight and along the curves, with a bound of the quality at every point. Or an array
        at the vertices: sizes (v,) or tensors (v, D, D).
    progress: called with the stage and its share, from 0 to 1, now and then; False from it stops the work, and
        Stopped is raised.
    """
    options = locals()
    return _verbs.check(options)


@_verbs.with_new_names
def geometry(
    mesh: Any,
    *,
    geometry: str | Mapping[str, Any] | Mesh | Made | None = None,
    cad: str | None = None,
    cad_unit: Literal["auto", "file", "m", "cm", "mm", "um", "in", "ft"] | None = None,
    cad_vertices: Literal["keep", "move"] | None = None,
    cad_timeout: float | None = None,
    cad_memory: float | None = None,
    ridge_angle: float | None = None,
    worst: int | None = None,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """What the boundary of a mesh is, and how far it is from a geometry. Of any mesh of degree 1 or 2; nothing is
    changed.

    Ridges are edges where facets turn by more than the ridge angle, where references change, and those that the
    file lists; patches are what is smooth between them; a facet in the same plane as its neighbour turns by 0
    degrees. Suspicious is what a change of the angle would change, and what no smooth surface looks like: knife
    edges, tips of cones, vertices whose normals spread. Look there before you curve: list edges as Ridges in the
    file, give facets of different surfaces different references, or choose another angle.

    Distances go both ways. From the boundary to the geometry they say how well the mesh follows what it knows; from
    the geometry to the boundary, what it has left out: of a CAD model points are taken on all its faces and edges,
    of other geometries only where the mesh has facets. Without a geometry it is the smooth surface through the
    mesh's own vertices, which says how much its facets, or its curves, differ from that, and nothing of the part
    that was meant. More: docs/algorithms/distances.md

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    geometry: surrogate (from the mesh), straight, or JSON such as '{"analytic": [{"references": [1], "sphere":
        {"radius": 5}}]}' or '{"mesh": "first.meshb"}': the boundary of another mesh of the body. Or a mesh: its
        boundary. Default: surrogate.
    cad: The CAD model that the boundary is put onto (.step, .stp, .iges, .igs or .brep); geometry may have analytic
        surfaces beside it, by reference.
    cad_unit: The unit of the mesh's coordinates, to which the CAD model is converted. Default: auto, that of the
        model's file if the mesh's boundary lies on the model in it, else the only unit in which it does.
    cad_vertices: Vertices of the boundary that are off the CAD model: keep, or move them onto it first. Default:
        keep, and too many of them are an error.
    cad_timeout: How long reading the CAD model may take (s). Default: 10, and 1 for each megabyte of its file. In
        [0, inf).
    cad_memory: How much memory reading the CAD model may take (MB). Default: 1000, and 50 times its file. In [0,
        inf).
    ridge_angle: Facets that meet at more than this angle (degrees) make a ridge. In (0, 180]. Default: 40.
    worst: How many patches, ridges and suspicious places of a kind to show. In [0, 1000000]. Default: 10.
    progress: called with the stage and its share, from 0 to 1, now and then; False from it stops the work, and
        Stopped is raised.
    """
    options = locals()
    return _verbs.geometry(options)


@_verbs.with_new_names
def transfer(
    old_mesh: Any,
    new_mesh: Any,
    solution: Any,
    *,
    fields: Sequence[str] | None = None,
    method: Literal["interpolate", "conserve"] | None = None,
    bounds: Literal["none", "local"] | None = None,
    progress: Progress | None = None,
) -> dict[str, np.ndarray]:
    """A solution on another mesh of the domain: on one that was remeshed, or any.

    Nodes that stayed where they were keep their values to the bit; others take the old field's value where they are
    in the old mesh, curved as it is, or at the nearest point of its boundary. conserve: where elements changed the
    field of least difference in L2 that keeps the integrals by material. More: docs/algorithms/transfer.md

    old_mesh: the mesh that the fields are on.
    new_mesh: the mesh that they are brought to.
    solution: the fields: an array, or {name: array}.
    fields: Names of the fields to take; of a solution file field_1 and so on. Default: all.
    method: interpolate (the default), or conserve.
    bounds: conserve only: none (the default), or local: no value beyond the old ones around.
    progress: called with the stage and its share, from 0 to 1, now and then; False from it stops the work, and
        Stopped is raised.
    """
    options = locals()
    return _verbs.transfer(options)


@_verbs.with_new_names
def generate(
    shape: Any,
    *,
    set: Mapping[str, Any] | None = None,
    elements: float | None = None,
    structure: Literal["unstructured", "prisms"] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Mesh:
    """A straight mesh of a shape, without a file: to try things on, and at any size.

    The options of a shape: camber explain shell (annulus, box, rectangle, bump, layer); those of layers are
    inner_layer/count and so on. The same options give the same bytes, whatever the threads. More:
    docs/algorithms/delaunay-and-shapes.md

    shape: its name, or the config's object as a dict.
    set: One option of the shape: path=value. Or {path: value}.
    elements: About so many tetrahedra or triangles (within 20 per cent, but for very few): sizes or cells are
        scaled, layers stay as they are. In [1, 4294967294].
    structure: Of a shell or annulus: unstructured: Delaunay of spread points; prisms: rows of prisms along random
        diagonals, fast at any size.
    threads: Threads to use; 0: all. The result does not depend on it. In [0, inf).
    progress: called with the stage and its share, from 0 to 1, now and then; False from it stops the work, and
        Stopped is raised.
    """
    options = locals()
    return _verbs.generate(options)
