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
    metric: Metric. natural: sizes of the input mesh; solution: interpolates solution best; otherwise a size such as
        0.1, a file (.sol, .solb, or a mesh file with the field metric), or JSON such as '{"field": {"polar-1":
        {}}}'. Or an array at the vertices: sizes (v,) or tensors (v, D, D). Default: natural.
    size: Size at boundary facets with a reference, such as 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE. KIND is
        facets, edges, vertices or elements. Or {reference: size}.
    geometry_error: Largest distance between the boundary and its geometry, in both directions, in model units. It
        bounds the sizes of the metric. remesh refines until the boundary meets it. If that fails: `success` is
        False. none: no limit. By default, remesh limits the distance of new facets to 0.01 times the size of their
        surface, and their turn to 30 degrees (degree 2: 90). In (0, inf).
    gradation: Largest ratio of the metric's sizes at adjacent edges; 0: no limit. Default: 2.5 for the metric of a
        solution, no limit for others. In (1, 1000].
    complexity: Complexity to which the graded metric is scaled: about 1/12 of the number of tetrahedra, or 1/2.6 of
        the number of triangles. Default: no scaling. In (0, inf).
    geometry: Geometry of the boundary. surrogate: smooth surface through the mesh; straight: flat facets; or JSON
        such as '{"analytic": [{"references": [1], "sphere": {"radius": 5}}]}' or '{"mesh": "first.meshb"}', the
        boundary of another mesh of the body. Or a mesh: its boundary. Default: surrogate.
    cad: CAD model onto which the boundary is projected (.step, .stp, .iges, .igs or .brep). geometry can add
        analytic surfaces by reference.
    cad_unit: Unit of the mesh's coordinates. The CAD model is converted to it. Default: auto, the unit of the
        model's file if the boundary of the mesh lies on the model in it, otherwise the only unit in which it does.
    cad_vertices: Treatment of boundary vertices that are off the CAD model. keep: they stay; too many of them are
        an error; move: they move onto the model first. Default: keep.
    cad_timeout: Time limit for reading the CAD model, in s. Default: 10 s, and 1 s for each megabyte of its file.
        In [0, inf).
    cad_memory: Memory limit for reading the CAD model, in MB. Default: 1000, and 50 times the size of its file. In
        [0, inf).
    geometry_tolerance: Largest distance of the node of a boundary edge from its geometry. Farther nodes: `success`
        is False. Default: 1e-5. In [0, inf).
    objective: Objective that determines node positions. accuracy: functions to which the metric belongs are
        interpolated well; energy: edges of minimal energy in the metric, which are smooth and evenly spaced;
        length: edges of minimal length in the metric; shape: no metric, Jacobians of elements as uniform as
        possible; solution: no metric, the run's solution is interpolated well. Default: solution if there is
        solution and no metric, otherwise accuracy.
    min_scaled_jacobian: Smallest scaled Jacobian that every element must have, from 0 to below 1. Elements below
        it: `success` is False. By default, elements below 0.1 are reported in a note. In [0, 1).
    solution: Fields on the input that are transferred: rows at its vertices or nodes, a mesh file of the same mesh
        with fields, or an expression at its nodes such as 'tanh((x-y)/0.05)'. curve places inner nodes to
        interpolate them best, unless there is a metric or an objective. Default: the fields of the input file. Or
        an array, or {name: array}, at the vertices or nodes: (n,), (n, D), (n, D, D).
    fields: Names of the fields to read. Default: all.
    transfer: Interpolate: the old field at the new nodes; conserve: where elements changed, the nearest field in L2
        with the same integral over each material.
    vtu: Also write the mesh with the run's fields for ParaView (.vtu).
    plots: Also write histograms as SVG files into this folder.
    page: Also write the mesh and the report as a page for a browser (.html).
    set: Override one option of the config: path=value, e.g. stages/curve/objective=length. Or {path: value}.
    threads: Number of threads; 0: all. The result does not depend on it. In [0, inf).
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
    """Adapt a straight or curved mesh to a metric: split, collapse, swap and smooth until its edges have unit length.

    References, materials, interfaces, ridges, listed curves, corners and required entities are preserved. New
    boundary vertices lie on the geometry: by default a smooth surface through the boundary's vertices, and through
    its nodes if it is curved. If a mesh is remeshed repeatedly, specify the first mesh or the CAD model as the
    geometry, so that the boundary does not drift. A mesh of degree 2 keeps its degree: edges are measured along
    their curves, and every new element is valid. To curve a remeshed straight mesh onto the same geometry, put
    "remesh" before "elevate" in a config (configs/remesh.json). Algorithm: docs/algorithms/cavity-operator.md

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    metric: Metric. natural: sizes of the input mesh; solution: interpolates solution best; otherwise a size such as
        0.1, a file (.sol, .solb, or a mesh file with the field metric), or JSON such as '{"field": {"polar-1":
        {}}}'. Or an array at the vertices: sizes (v,) or tensors (v, D, D). Default: natural.
    size: Size at boundary facets with a reference, such as 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE. KIND is
        facets, edges, vertices or elements. Or {reference: size}.
    geometry_error: Largest distance between the boundary and its geometry, in both directions, in model units. It
        bounds the sizes of the metric. remesh refines until the boundary meets it. If that fails: `success` is
        False. none: no limit. By default, remesh limits the distance of new facets to 0.01 times the size of their
        surface, and their turn to 30 degrees (degree 2: 90). In (0, inf).
    gradation: Largest ratio of the metric's sizes at adjacent edges; 0: no limit. Default: 2.5 for the metric of a
        solution, no limit for others. In (1, 1000].
    complexity: Complexity to which the graded metric is scaled: about 1/12 of the number of tetrahedra, or 1/2.6 of
        the number of triangles. Default: no scaling. In (0, inf).
    geometry: Geometry of the boundary. surrogate: smooth surface through the mesh; straight: flat facets; or JSON
        such as '{"analytic": [{"references": [1], "sphere": {"radius": 5}}]}' or '{"mesh": "first.meshb"}', the
        boundary of another mesh of the body. Or a mesh: its boundary. Default: surrogate.
    cad: CAD model onto which the boundary is projected (.step, .stp, .iges, .igs or .brep). geometry can add
        analytic surfaces by reference.
    cad_unit: Unit of the mesh's coordinates. The CAD model is converted to it. Default: auto, the unit of the
        model's file if the boundary of the mesh lies on the model in it, otherwise the only unit in which it does.
    cad_vertices: Treatment of boundary vertices that are off the CAD model. keep: they stay; too many of them are
        an error; move: they move onto the model first. Default: keep.
    cad_timeout: Time limit for reading the CAD model, in s. Default: 10 s, and 1 s for each megabyte of its file.
        In [0, inf).
    cad_memory: Memory limit for reading the CAD model, in MB. Default: 1000, and 50 times the size of its file. In
        [0, inf).
    geometry_tolerance: Largest distance of the node of a boundary edge from its geometry. Farther nodes: `success`
        is False. Default: 1e-5. In [0, inf).
    rounds: The largest number of rounds of collapse, split, swap and smooth. Fewer are done if few operations
        remain. In [0, 1000].
    blocks: Straight meshes only: number of elements in a block. Each block is remeshed separately with a fixed
        interface to other blocks; then the mesh is divided into other blocks and remeshed again. 0: the mesh is
        remeshed as a whole. In [0, inf).
    objective: Degree 2: objective for nodes of inner edges, as in the stage curve: accuracy, energy or length;
        auto: that of an earlier stage curve, else accuracy. Default: auto.
    solution: Fields on the input that are transferred: rows at its vertices or nodes, a mesh file of the same mesh
        with fields, or an expression at its nodes such as 'tanh((x-y)/0.05)'. curve places inner nodes to
        interpolate them best, unless there is a metric or an objective. Default: the fields of the input file. Or
        an array, or {name: array}, at the vertices or nodes: (n,), (n, D), (n, D, D).
    fields: Names of the fields to read. Default: all.
    transfer: Interpolate: the old field at the new nodes; conserve: where elements changed, the nearest field in L2
        with the same integral over each material.
    vtu: Also write the mesh with the run's fields for ParaView (.vtu).
    plots: Also write histograms as SVG files into this folder.
    page: Also write the mesh and the report as a page for a browser (.html).
    set: Override one option of the config: path=value, e.g. stages/curve/objective=length. Or {path: value}.
    threads: Number of threads; 0: all. The result does not depend on it. In [0, inf).
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
    """Repair a curved mesh from another program: validate, relax, commit.

    The boundary and interfaces between materials stay unchanged. Nodes of the volume move, and its vertices if
    necessary. With cad, or analytic surfaces, boundary nodes are first projected onto these. They slide on them
    only if other moves fail. With boundary_tolerance T, nodes of boundary edges may move by at most T if other
    moves fail. Between nodes, the surface then moves by at most 4/3 T. Boundary vertices never move. Elements that
    cannot be repaired are listed with the reason. The mesh is written with them, and `success` is False. Algorithm:
    docs/algorithms/repair.md

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    boundary_tolerance: Largest distance by which the node of a boundary edge may move, in model units; 0 (the
        default): it does not move. In [0, inf).
    geometry: Geometry of the boundary. surrogate: smooth surface through the mesh; straight: flat facets; or JSON
        such as '{"analytic": [{"references": [1], "sphere": {"radius": 5}}]}' or '{"mesh": "first.meshb"}', the
        boundary of another mesh of the body. Or a mesh: its boundary. Default: surrogate.
    cad: CAD model onto which the boundary is projected (.step, .stp, .iges, .igs or .brep). geometry can add
        analytic surfaces by reference.
    cad_unit: Unit of the mesh's coordinates. The CAD model is converted to it. Default: auto, the unit of the
        model's file if the boundary of the mesh lies on the model in it, otherwise the only unit in which it does.
    cad_vertices: Treatment of boundary vertices that are off the CAD model. keep: they stay; too many of them are
        an error; move: they move onto the model first. Default: keep.
    cad_timeout: Time limit for reading the CAD model, in s. Default: 10 s, and 1 s for each megabyte of its file.
        In [0, inf).
    cad_memory: Memory limit for reading the CAD model, in MB. Default: 1000, and 50 times the size of its file. In
        [0, inf).
    geometry_tolerance: Largest distance of the node of a boundary edge from its geometry. Farther nodes: `success`
        is False. Default: 1e-5. In [0, inf).
    min_scaled_jacobian: Smallest scaled Jacobian that every element must have, from 0 to below 1. Elements below
        it: `success` is False. By default, elements below 0.1 are reported in a note. In [0, 1).
    solution: Fields on the input that are transferred: rows at its vertices or nodes, a mesh file of the same mesh
        with fields, or an expression at its nodes such as 'tanh((x-y)/0.05)'. curve places inner nodes to
        interpolate them best, unless there is a metric or an objective. Default: the fields of the input file. Or
        an array, or {name: array}, at the vertices or nodes: (n,), (n, D), (n, D, D).
    fields: Names of the fields to read. Default: all.
    transfer: Interpolate: the old field at the new nodes; conserve: where elements changed, the nearest field in L2
        with the same integral over each material.
    vtu: Also write the mesh with the run's fields for ParaView (.vtu).
    plots: Also write histograms as SVG files into this folder.
    page: Also write the mesh and the report as a page for a browser (.html).
    set: Override one option of the config: path=value, e.g. stages/curve/objective=length. Or {path: value}.
    threads: Number of threads; 0: all. The result does not depend on it. In [0, inf).
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
    """Adapt a mesh to a solution in cycles of metric, remesh, curve, transfer and solver.

    Each cycle reads a mesh and its solution. It computes the metric that interpolates the solution best with the
    specified complexity, remeshes, and curves the edges for the solution. Then it transfers the solution to the new
    mesh. Every mesh is valid. The boundary stays on the geometry: that of geometry or cad, otherwise that of the
    first mesh. Cycles end if the error has converged (convergence_tolerance) or at the limit of cycles. The result
    is the mesh with the smallest error (see result). Algorithm: docs/algorithms/adaptation.md

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    solve: called with each mesh, the solution before brought to it ({} of the first), and the cycle; gives the
        solution on it, an array or {name: array} at its vertices or nodes.
    solution: Solution on the mesh: a file of rows at its vertices or nodes, or a file of the same mesh with fields.
        It allows one cycle, because it is unknown on the next mesh. An expression such as 'tanh((x-y)/0.05)' allows
        any number of cycles. Or an array, or {name: array}, at the vertices or nodes: (n,), (n, D), (n, D, D).
    fields: Names of the fields to use. Default: all.
    metric: Metric to use instead of a solution: a size, a file (.sol, .solb, or a mesh file with the field metric),
        or JSON such as '{"field": {"polar-1": {}}}'. Or an array at the vertices: sizes (v,) or tensors (v, D, D).
    field: Exact solution as an expression. Its errors are reported for each cycle. Without another target, the mesh
        is adapted to it.
    complexity: Complexity of the metric in each cycle; the last value applies to all later cycles. A mesh has about
        12 times as many tetrahedra, or 2.6 times as many triangles. Default: the number of elements of the mesh. In
        (0, inf).
    norm: Exponent p of the L^p norm of the error; 0: the maximum of the error; H1: the same as norm 2 error_of
        gradients. In [0, inf). Default: 2.
    error_of: Quantity in the norm: values of the error, or its gradients.
    min_size: Smallest size; 0: none. In [0, inf). Default: 0.
    max_size: Largest size; 0: the domain's diameter. In [0, inf). Default: 0.
    max_anisotropy: Largest ratio of sizes; 0: only derivatives are limited, to 1e5. A larger value raises that
        limit. In [0, inf). Default: 0.
    size: Size at boundary facets with a reference, such as 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE. KIND is
        facets, edges, vertices or elements. Or {reference: size}.
    geometry_error: Largest distance between the boundary and its geometry, in both directions, in model units. A
        larger distance in the result: `success` is False. none: no limit. The default is set by the expected error
        of the solution, and a larger distance causes a note; new facets are limited as with remesh. In (0, inf).
    gradation: Largest ratio of the metric's sizes at adjacent edges; 0: no limit. Default: 2.5 for the metric of a
        solution, no limit for others. In (1, 1000].
    cycles: Maximum number of cycles. They end earlier if the error has converged. Default: 8, or 1 with a solution
        file. In [1, 1000].
    degree: Degree of the new meshes. 1: straight; 2: curved. In [1, 2]. Default: 2.
    convergence_tolerance: Condition to end: the minimum error of the last complexity has fallen by no more than
        this share over two cycles. Without an error: in one cycle, the share of unit edges in the metric of the
        mesh's own solution has risen by no more than a fifth of this. 0: all cycles are run. In [0, 1]. Default:
        0.1.
    result: Best: the mesh with the smallest error among those of the last complexity; last: the mesh of the last
        cycle; auto: last if the solver's command has {cycle}, with which each cycle may solve another problem,
        otherwise best.
    geometry: Geometry of the boundary. surrogate: smooth surface through the mesh; straight: flat facets; or JSON
        such as '{"analytic": [{"references": [1], "sphere": {"radius": 5}}]}' or '{"mesh": "first.meshb"}', the
        boundary of another mesh of the body. Or a mesh: its boundary. Default: surrogate.
    cad: CAD model onto which the boundary is projected (.step, .stp, .iges, .igs or .brep). geometry can add
        analytic surfaces by reference.
    cad_unit: Unit of the mesh's coordinates. The CAD model is converted to it. Default: auto, the unit of the
        model's file if the boundary of the mesh lies on the model in it, otherwise the only unit in which it does.
    cad_vertices: Treatment of boundary vertices that are off the CAD model. keep: they stay; too many of them are
        an error; move: they move onto the model first. Default: keep.
    cad_timeout: Time limit for reading the CAD model, in s. Default: 10 s, and 1 s for each megabyte of its file.
        In [0, inf).
    cad_memory: Memory limit for reading the CAD model, in MB. Default: 1000, and 50 times the size of its file. In
        [0, inf).
    geometry_tolerance: Largest distance of the node of a boundary edge from its geometry. Farther nodes: `success`
        is False. Default: 1e-5. In [0, inf).
    transfer: Interpolate: the old field at the new nodes; conserve: where elements changed, the nearest field in L2
        with the same integral over each material.
    min_scaled_jacobian: Smallest scaled Jacobian that every element must have, from 0 to below 1. Elements below
        it: `success` is False. By default, elements below 0.1 are reported in a note. In [0, 1).
    set: Override one option of the config: path=value, e.g. stages/curve/objective=length. Or {path: value}.
    threads: Number of threads; 0: all. The result does not depend on it. In [0, inf).
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
    """Check the validity and quality of a mesh of degree 1 or 2 from any program. The mesh is not changed.

    An element of degree 2 is valid if det J is positive everywhere. Its scaled Jacobian is the minimum of det J
    divided by det J of the straight element with the same vertices. Other programs use this name for Knupp's
    measure. For a straight mesh, the report has the quality, which is the mean ratio. check also examines the whole
    mesh: conformity, orientation, nodes, boundary, and crossing of curved facets.

    A field is an expression of x, y, z and pi with + - * / ^, c ? a : b, sqrt, exp, tanh ... For a field, the
    report has the L2 and H1 errors of its interpolants: of degree 1 and 2 on straight edges, and on the curved
    mesh. If the error on straight edges divided by that on the curved mesh is above 1, curved elements are more
    accurate with the same number of unknowns (docs/algorithms/interpolation-error.md). In a metric, the quality of
    an element of degree 2 is 1 divided by its mean distortion: 1 is regular, 0 is folded
    (docs/algorithms/distortion.md). All lines of the report: docs/algorithms/check.md

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    min_scaled_jacobian: Minimum scaled Jacobian of a valid element, from 0 and below 1. In [0, 1). Default: 0.
    ridge_angle: Boundary faces that meet at a smaller angle than this (degrees) belong to one smooth wall. In [0,
        180]. Default: 40.
    worst: Number of worst elements to show. In [0, 1000000]. Default: 10.
    field: Expression of x, y (and z) whose interpolation errors are reported.
    metric: Metric file. The report then has lengths of edges, the share of unit edges and qualities of elements in
        it. For degree 2 it has them straight and along the curves, with a bound of the quality at every point. Or
        an array at the vertices: sizes (v,) or tensors (v, D, D).
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
    """Analyse the boundary of a mesh and its distance from a geometry. The mesh has degree 1 or 2 and is not changed.

    Ridges are edges where facets turn by more than the ridge angle, edges between references, and edges that the
    file lists as ridges. Patches are the smooth parts between ridges. Two facets in one plane turn by 0 degrees.
    Suspicious places depend on the ridge angle, or have no smooth surface: knife edges, tips of cones, vertices
    with divergent normals. Check them before curving. To correct them, list edges as Ridges in the file, assign
    different references to facets of different surfaces, or choose another angle.

    Distances are measured in both directions. The distance from the boundary to the geometry shows how closely the
    mesh follows the geometry. The distance from the geometry to the boundary shows parts that the mesh misses. For
    a CAD model it is sampled on all faces and edges, for other geometries only opposite the facets of the mesh.
    Without a geometry, the reference is the smooth surface through the vertices of the mesh. The distance then
    measures the deviation of facets or curves from that surface, not from the original part. More:
    docs/algorithms/distances.md

    mesh: the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's.
    geometry: Geometry of the boundary. surrogate: smooth surface through the mesh; straight: flat facets; or JSON
        such as '{"analytic": [{"references": [1], "sphere": {"radius": 5}}]}' or '{"mesh": "first.meshb"}', the
        boundary of another mesh of the body. Or a mesh: its boundary. Default: surrogate.
    cad: CAD model onto which the boundary is projected (.step, .stp, .iges, .igs or .brep). geometry can add
        analytic surfaces by reference.
    cad_unit: Unit of the mesh's coordinates. The CAD model is converted to it. Default: auto, the unit of the
        model's file if the boundary of the mesh lies on the model in it, otherwise the only unit in which it does.
    cad_vertices: Treatment of boundary vertices that are off the CAD model. keep: they stay; too many of them are
        an error; move: they move onto the model first. Default: keep.
    cad_timeout: Time limit for reading the CAD model, in s. Default: 10 s, and 1 s for each megabyte of its file.
        In [0, inf).
    cad_memory: Memory limit for reading the CAD model, in MB. Default: 1000, and 50 times the size of its file. In
        [0, inf).
    ridge_angle: Angle (degrees) above which two facets form a ridge. In (0, 180]. Default: 40.
    worst: Number of patches, ridges and suspicious places of each kind to show. In [0, 1000000]. Default: 10.
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
    """Transfer a solution to another mesh of the domain.

    Nodes that did not move preserve their values exactly. Other nodes take the value of the old field at their
    position in the old curved mesh, or at the nearest point of its boundary. In changed elements, conserve takes
    the field with the smallest L2 difference that preserves the integral over each material. More:
    docs/algorithms/transfer.md

    old_mesh: the mesh that the fields are on.
    new_mesh: the mesh that they are brought to.
    solution: the fields: an array, or {name: array}.
    fields: Names of the fields to use. Fields of a solution file are field_1, field_2 … Default: all.
    method: Method of transfer: interpolate (the default), or conserve.
    bounds: Bounds of values, for conserve only. none: no bounds (the default); local: values stay within the old
        values around.
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
    """Generate a straight mesh of a simple shape, at any size.

    Options of a shape: camber explain shell (annulus, box, rectangle, bump, layer). Options of layers are
    inner_layer/count and so on. The same options give the same file for any number of threads. More:
    docs/algorithms/delaunay-and-shapes.md

    shape: its name, or the config's object as a dict.
    set: Set one option of the shape: path=value. Or {path: value}.
    elements: Approximate number of tetrahedra or triangles, within 20 percent except for very small numbers. Sizes
        or cells are scaled, layers are not. In [1, 4294967294].
    structure: Structure of a shell or annulus. unstructured: Delaunay mesh of scattered points; prisms: rows of
        prisms divided along random diagonals, fast at any size.
    threads: Number of threads; 0: all. The result does not depend on it. In [0, inf).
    progress: called with the stage and its share, from 0 to 1, now and then; False from it stops the work, and
        Stopped is raised.
    """
    options = locals()
    return _verbs.generate(options)
