"""Cases of bad input: the creation of the files, and the promised behaviour of the program.

test_bad_input.py runs the cases, and docs/input.md lists them.
"""
import math
import os
import random
import resource
from dataclasses import dataclass
from typing import Callable

import bad_moments
from program import ROOT
from bad_meshes import *  # noqa: F403  (the whole vocabulary of the cases)

CURVE = ("curve", "in.mesh", "-o", "out.mesh")
RUN_SEQUENTIALLY = ("run", "run.json", "--threads", "1")
RUN, RUN_P2 = ("run", "run.json"), ("run", "p2.json")
FOR_SOLUTION = ("remesh", "in.mesh", "-o", "out.mesh", "--solution", "u.sol", "--metric", "solution", "--complexity", "99")
WITH_METRIC = CURVE + ("--metric", "m.solb")
BINARY = ("curve", "in.meshb", "-o", "out.mesh")


def with_cad_shell(radius=5):
    """A CAD model of the shell between spheres of radii 1 and 5, a mesh with this outer radius, and a mesh of a
    cube."""
    model = (ROOT / "tests" / "cad" / "shell.brep").read_bytes()
    octahedron = [tuple(side * radius * (i == k) for i in range(3)) for side in (1, -1) for k in range(3)]
    faces = [(1, 2, 3), (2, 4, 3), (4, 5, 3), (5, 1, 3), (2, 1, 6), (4, 2, 6), (5, 4, 6), (1, 5, 6)]
    mesh = "MeshVersionFormatted 2\nDimension 3\nVertices\n7\n" + "".join(
        "%g %g %g 0\n" % p for p in octahedron + [(0, 0, 0)]) + "Tetrahedra\n8\n" + "".join(
        "%d %d %d 7 1\n" % f for f in faces) + "End\n"
    return plain(block)() | {"shell.brep": model, "shell.mesh": mesh.encode()}


def quadratic_solution(order):
    """A straight mesh of the unit square and a quadratic field: rows of vertices, then of edges in the order of
    `order`."""
    n = 20
    at = lambda i, j: i * (n + 1) + j
    points = [(i / n, j / n) for i in range(n + 1) for j in range(n + 1)]
    triangles = [t for i in range(n) for j in range(n)
                 for t in ((at(i, j), at(i + 1, j), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i, j + 1)))]
    edges = list(dict.fromkeys(tuple(sorted(e)) for a, b, c in triangles for e in ((a, b), (b, c), (c, a))))
    places = points + [tuple((a + b) / 2 for a, b in zip(points[v], points[w])) for v, w in order(edges)]
    rows = lambda name, items: f"{name}\n{len(items)}\n" + "".join(" ".join(map(repr, r)) + "\n" for r in items)
    mesh = "MeshVersionFormatted 2\nDimension 2\n" + rows("Vertices", [(*p, 0) for p in points]) + rows(
        "Triangles", [(a + 1, b + 1, c + 1, 1) for a, b, c in triangles]) + "End\n"
    values = "".join(f"{math.tanh((math.hypot(x, y) - 0.5) / 0.1)!r}\n" for x, y in places)
    return {"in.mesh": mesh.encode(), "u.sol": ("MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n"
                                                f"{len(places)}\n1 1\n{values}End\n").encode()}


def shuffled(edges):
    return random.Random(1).sample(edges, len(edges))


@dataclass
class Case:
    """`files` maps names to bytes (None: a folder). With exit code 0 or 1 out.mesh is written, otherwise nothing."""
    group: str
    name: str
    does: str                       # repaired, refused, accepted
    code: int
    says: str                       # part of the line on standard error; "" if none is printed
    files: Callable
    arguments: tuple = CURVE
    finds: str = ""                 # key of the defect in `camber check --json`
    limits: tuple = ()              # limits of the process: (resource, bytes)
    setup: Callable = lambda folder: None   # final changes in the folder
    as_unprivileged_user: bool = False         # needed for permissions: root may read and write everything
    run: Callable = None            # replaces the start of the program
    needs: Callable = lambda: ""    # reason why it cannot be tested here, or ""


# ---------------------------------------------------------------- all cases

CASES = [
    # ------------------------------------------------ cut off
    Case("Cut off", "an empty file", "refused", 3, "the file is empty", lambda: {"in.mesh": b""}),
    Case("Cut off", "binary: within the first words", "refused", 3, "cut off", binary(lambda d: d[:6]), BINARY),
    Case("Cut off", "binary: within the header of a block", "refused", 3, "in.meshb: byte",
         binary(lambda d: d[:keyword_at(d, 8) + 6]), BINARY),
    Case("Cut off", "binary: within a block", "refused", 3, "cut off", binary(lambda d: d[:keyword_at(d, 8) + 200]),
         BINARY),
    Case("Cut off", "binary: between two blocks", "refused", 3, "cut off", binary(lambda d: d[:keyword_at(d, 8)]),
         BINARY),
    Case("Cut off", "binary: within a number", "refused", 3, "cut off",
         binary(lambda d: d[:keyword_at(d, 4) + 12 + 11]), BINARY),
    Case("Cut off", "ASCII: within a line", "refused", 3, "cut off",
         lambda: {"in.mesh": cut(ascii_file(block()), b"Tetrahedra\n48\n", 40)}),
    Case("Cut off", "ASCII: within a block, at the end of a line", "refused", 3, "cut off",
         lambda: {"in.mesh": b"\n".join(ascii_file(block()).split(b"\n")[:20]) + b"\n"}),
    Case("Cut off", "ASCII: between two blocks", "refused", 3, "the mesh is empty",
         lambda: {"in.mesh": cut(ascii_file(block()), b"Tetrahedra\n", 0)}),
    Case("Cut off", "ASCII: without End", "accepted", 0, "the file has no keyword End", text(("\nEnd", "\n"))),

    # ------------------------------------------------ wrong words and numbers
    Case("Words and numbers", "no mesh at all", "refused", 3, "not a GMF file",
         lambda: {"in.mesh": b"a solid cube\nfacet normal 0 0 1\n"}),
    Case("Words and numbers", "10¹⁸ vertices in half a kilobyte", "refused", 3, "announces 1000000000000000000 rows",
         lambda: {"in.meshb": small_binary(10 ** 18)}, BINARY),
    Case("Words and numbers", "ASCII: 10¹⁸ vertices", "refused", 3, "announces 1000000000000000000 rows",
         text(("Vertices\n27", "Vertices\n1000000000000000000"))),
    Case("Words and numbers", "binary: two thousand million tetrahedra", "refused", 3, "announces 2000000000 rows",
         binary(lambda d: with_count(d, 8, 2000000000)), BINARY),
    Case("Words and numbers", "a negative count", "refused", 3, "negative",
         binary(lambda d: with_count(d, 8, -5)), BINARY),
    Case("Words and numbers", "fewer rows than announced", "refused", 3, "announces 49 rows",
         text(("Tetrahedra\n48", "Tetrahedra\n49"))),
    Case("Words and numbers", "Dimension 4", "refused", 3, "Dimension is 4, not 2 or 3",
         text(("Dimension 3", "Dimension 4"))),
    Case("Words and numbers", "no Dimension", "refused", 3, "Dimension", text(("Dimension 3\n", ""))),
    Case("Words and numbers", "tetrahedra in a file of Dimension 2", "refused", 3, "tetrahedra",
         text(("End", "Tetrahedra\n1\n1 2 3 4 0\nEnd"), make=square)),
    Case("Words and numbers", "a vertex number 0", "refused", 3, "tetrahedron 1: the index 0",
         text(("Tetrahedra\n48\n1 ", "Tetrahedra\n48\n0 "))),
    Case("Words and numbers", "a vertex number beyond the last", "refused", 3, "the index 28 is not between 1 and 27",
         text(("Tetrahedra\n48\n1 ", "Tetrahedra\n48\n28 "))),
    Case("Words and numbers", "a negative vertex number", "refused", 3, "the index -1",
         text(("Tetrahedra\n48\n1 ", "Tetrahedra\n48\n-1 "))),
    Case("Words and numbers", "an element that names a vertex twice", "refused", 3, "occurs twice",
         changed(block, lambda m: appended(elements(m), [0, 1, 2, 0], 0))),
    Case("Words and numbers", "a coordinate that is no number (NaN)", "refused", 3, "vertex 1: a value is infinite",
         text(("\n0.0 0.0 0.0 0", "\n0.0 nan 0.0 0"))),
    Case("Words and numbers", "an infinite coordinate", "refused", 3, "vertex 1: a value is infinite",
         text(("\n0.0 0.0 0.0 0", "\n0.0 0.0 inf 0"))),
    Case("Words and numbers", "a word where a number belongs", "refused", 3, "line",
         text(("\n0.0 0.0 0.0 0", "\n0.0 0.0 0x1 0"))),
    Case("Words and numbers", "a block twice", "refused", 3, "a second block", text(("End", "Vertices\n0\nEnd"))),

    Case("Words and numbers", "a coordinate beyond 1e60", "refused", 3,
         "vertex 27: is more than 1e60 away from the origin",
         changed(block, lambda m: m.points.__setitem__(26, 1e160)), finds="distant_vertices"),
    Case("Words and numbers", "a whole mesh smaller than 1e-60", "refused", 3,
         "tetrahedron 1: is smaller than 1e-60", changed(block, lambda m: m.points.__imul__(1e-300)),
         finds="tiny_elements"),
    Case("Words and numbers", "a mid node that far away, in a quadratic mesh", "refused", 3,
         "is more than 1e60 away from the origin", quadratic(lambda m: None, lambda m: m.points.__setitem__(30, 1e160)),
         RUN_P2, finds="distant_nodes"),
    Case("Words and numbers", "bytes that are no text in an unknown keyword", "accepted", 0, "Wib??[31mble was skipped",
         lambda: {"in.mesh": ascii_file(block()).replace(b"\nEnd", b"\nWib\xff\x1b[31mble\n1\n1\nEnd")}),

    # ------------------------------------------------ element kinds
    Case("Kinds of elements", "hexahedra", "refused", 3, "Hexahedra", with_block("Hexahedra", "1 2 3 4 5 6 7 8 0")),
    Case("Kinds of elements", "prisms", "refused", 3, "Prisms", with_block("Prisms", "1 2 3 4 5 6 0")),
    Case("Kinds of elements", "pyramids", "refused", 3, "Pyramids", with_block("Pyramids", "1 2 3 4 5 0")),
    Case("Kinds of elements", "quadrilaterals", "refused", 3, "Quadrilaterals",
         with_block("Quadrilaterals", "1 2 3 4 0")),
    Case("Kinds of elements", "elements of degree 3", "refused", 3, "TetrahedraP3",
         with_block("TetrahedraP3", " ".join(map(str, range(1, 21))) + " 0")),
    Case("Kinds of elements", "a quadratic mesh where a straight one is expected", "refused", 3, "quadratic already",
         quadratic(lambda m: None, lambda m: m.points.__setitem__((30, 0), m.points[30, 0] + 0.01))),
    Case("Kinds of elements", "a quadratic mesh that nothing has bent where a straight one is expected", "accepted", 0,
         "new nodes of its edges are computed", quadratic()),
    Case("Kinds of elements", "straight and quadratic elements together", "accepted", 0, "", mixed_degrees, RUN_P2),
    Case("Kinds of elements", "a keyword that Camber does not know", "accepted", 0, "Wibbles was skipped",
         with_block("Wibbles", "1 2 3")),

    # ------------------------------------------------ sizes
    Case("Sizes", "an empty mesh: no vertices", "refused", 3, "the mesh is empty",
         lambda: {"in.mesh": b"MeshVersionFormatted 2\nDimension 3\nVertices\n0\nEnd\n"}),
    Case("Sizes", "an empty mesh: vertices only", "refused", 3, "the mesh is empty",
         lambda: {"in.mesh": b"MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 0 0 0\nEnd\n"}),
    Case("Sizes", "a mesh of one tetrahedron", "accepted", 0, "", plain(one_tetrahedron)),
    Case("Sizes", "a mesh of one triangle in 2D", "accepted", 0, "", plain(one_triangle)),
    Case("Sizes", "a surface only (triangles in 3D)", "accepted", 0, "", plain(surface_only)),

    # ------------------------------------------------ vertices
    Case("Vertices", "two at one place, both used", "refused", 3, "vertex 28: has the same position as vertex 10",
         changed(block, cut_open(False)), finds="duplicate_vertices"),
    Case("Vertices", "two at one place, on a seam of a surface", "refused", 3, "has the same position as vertex",
         plain(duplicated_surface), finds="duplicate_vertices"),
    Case("Vertices", "two at one place, across a slit with both sides listed", "accepted", 0, "across a slit",
         changed(block, cut_open(True)), finds="slit_vertices"),
    Case("Vertices", "unused ones", "accepted", 0, "belong to no entity",
         changed(block, lambda m: with_points(m, [[7, 7, 7], [0.5, 0.5, 0.5]])), finds="unused_vertices"),

    # ------------------------------------------------ elements
    Case("Elements", "some numbered the wrong way round", "repaired", 0, "3 tetrahedra are numbered the wrong way round",
         changed(block, swapped([2, 7, 30])), finds="reversed_elements"),
    Case("Elements", "all numbered the wrong way round", "repaired", 0, "48 tetrahedra are numbered the wrong way round",
         changed(block, swapped(slice(None))), finds="reversed_elements"),
    Case("Elements", "the same in 2D", "repaired", 0, "triangle 2 is numbered the wrong way round: turned",
         changed(square, swapped([1])), finds="reversed_elements"),
    Case("Elements", "the same in a quadratic mesh", "repaired", 0, "tetrahedron 3 is numbered the wrong way round",
         quadratic(swapped([2])), RUN_P2, finds="reversed_elements"),
    Case("Elements", "inverted ones (a vertex beyond the opposite face)", "accepted", 0, "",
         changed(block, centre_out), finds="tangled_elements"),
    Case("Elements", "without volume", "accepted", 1, "flat or inverted before curving",
         changed(block, onto_face), finds="flat_elements"),
    Case("Elements", "some inside the elements of another body", "accepted", 1, "elements overlap in 1 place",
         plain(nested_bodies)),
    Case("Elements", "one listed twice", "repaired", 0, "tetrahedron 49 lists the vertices of tetrahedron 6 again",
         changed(block, lambda m: appended(elements(m), elements(m).nodes[5][[1, 0, 3, 2]], 1)),
         finds="repeated_elements"),
    Case("Elements", "one listed twice, with another reference", "refused", 3,
         "tetrahedron 49: has the vertices of tetrahedron 6, but another reference",
         changed(block, lambda m: appended(elements(m), elements(m).nodes[5], 8)), finds="contradicting_elements"),
    Case("Elements", "three on one face", "refused", 3, "shares a face with more than one other tetrahedron",
         plain(three_on_a_face), finds="non_manifold_faces"),
    Case("Elements", "a hanging vertex", "refused", 3, "vertex 6: lies inside a face of triangle 1",
         changed(square, hanging), finds="hanging_vertices"),

    Case("Elements", "a hanging vertex in 3D", "refused", 3, "vertex 6: lies inside a face of tetrahedron 1",
         plain(hanging_in_space), finds="hanging_vertices"),

    # ------------------------------------------------ boundary
    Case("Boundary", "no triangles listed", "repaired", 0, "added 48 triangles of reference 1",
         changed(block, lambda m: without(facets(m), slice(0, 0))), finds="no_facets"),
    Case("Boundary", "some triangles not listed", "repaired", 0, "added 8 triangles of reference 7",
         changed(block, lambda m: without(facets(m), facets(m).refs != 3)), finds="missing_facets"),
    Case("Boundary", "edges not listed in 2D", "repaired", 0, "added 1 edge of reference 5",
         changed(square, lambda m: without(facets(m), facets(m).refs != 2)), finds="missing_facets"),
    Case("Boundary", "triangles not listed in a quadratic mesh", "repaired", 0, "added 8 triangles of reference 7",
         quadratic(lambda m: without(facets(m), facets(m).refs != 3)), RUN_P2, finds="missing_facets"),
    Case("Boundary", "a triangle that is a face of no element", "repaired", 0,
         "triangle 49 is a face of no tetrahedron: dropped",
         changed(block, lambda m: appended(facets(m), [0, 13, 20], 1)), finds="stray_facets"),
    Case("Boundary", "an edge of no triangle in 2D", "repaired", 0, "edge 5 is a face of no triangle: dropped",
         changed(square, lambda m: appended(m.cells["Edges"], [1, 3], 5)), finds="stray_facets"),
    Case("Boundary", "a triangle listed twice", "repaired", 0, "triangle 49 lists the vertices of triangle 1 again",
         changed(block, lambda m: appended(facets(m), facets(m).nodes[0][::-1], facets(m).refs[0])),
         finds="repeated_facets"),
    Case("Boundary", "a triangle listed twice, with another reference", "refused", 3,
         "triangle 49: has the vertices of triangle 1, but another reference",
         changed(block, lambda m: appended(facets(m), facets(m).nodes[0], 77)), finds="contradicting_facets"),
    Case("Boundary", "an edge of four boundary faces", "accepted", 0,
         "edge from vertex 1 to vertex 2 is shared by more than two faces", plain(pair_at_edge), finds="non_manifold_edges"),
    Case("Boundary", "a vertex where the boundary touches itself", "accepted", 0,
         "vertex 1 is a point at which the boundary touches itself", plain(pair_at_vertex), finds="pinched_vertices"),
    Case("Boundary", "the same in 2D", "accepted", 0, "vertex 1 is a point at which the boundary touches itself",
         plain(pair_at_corner), finds="pinched_vertices"),
    Case("Boundary", "triangles inside one material", "accepted", 0, "lie between tetrahedra of one reference",
         changed(block, inner_face), finds="inner_facets"),
    Case("Boundary", "two materials, their interface listed", "accepted", 0, "", changed(block, listed_interface)),
    Case("Boundary", "two materials, their interface not listed", "repaired", 0, "added 8 triangles of reference 7",
         changed(block, two_materials), finds="missing_interfaces"),
    Case("Boundary", "a feature edge that is an edge of nothing", "accepted", 0, "belongs to no tetrahedron",
         with_block("Edges", "1 26 1"), finds="isolated_edges"),

    # ------------------------------------------------ flat meshes
    Case("Flat meshes", "triangles with z = 0 in a file of dimension 3", "accepted", 0, "the mesh is flat (z = 0)",
         plain(flat_square)),
    Case("Flat meshes", "a metric of six components beside them", "accepted", 0, "the mesh is flat (z = 0)", flat_metric,
         WITH_METRIC),
    Case("Flat meshes", "z that differ by rounding", "accepted", 0, "the mesh is nearly flat",
         changed(flat_square, lambda m: m.points.__setitem__((2, 2), 1e-17))),

    # ------------------------------------------------ metrics
    Case("Metrics", "in another dimension than the mesh", "refused", 3, "m.solb: is in 2D, the mesh in 3D",
         metric(row=[1.0, 0, 1], dim=2), WITH_METRIC),
    Case("Metrics", "with another number of rows", "refused", 3, "has 26 rows, the mesh 27 vertices", metric(rows=26),
         WITH_METRIC),
    Case("Metrics", "with a negative eigenvalue", "refused", 3, "metric at vertex 5",
         metric(row=[1.0, 0, -1, 0, 0, 1], at=5), WITH_METRIC),
    Case("Metrics", "with a zero tensor", "refused", 3, "metric at vertex 5", metric(row=[0.0] * 6, at=5), WITH_METRIC),
    Case("Metrics", "with a negative eigenvalue by rounding only", "accepted", 0, "1 of the 27 tensors",
         metric(row=[1.0, 1, 1 - 2.3e-16, 0, 0, 1], at=5), WITH_METRIC),
    Case("Metrics", "with NaN", "refused", 3, "m.sol: line", metric_text("nan"),
         CURVE + ("--metric", "m.sol")),
    Case("Metrics", "with an infinite number", "refused", 3, "m.sol: line", metric_text("1e999"),
         CURVE + ("--metric", "m.sol")),
    Case("Metrics", "a size that is not positive", "refused", 3, "size at vertex 1",
         metric(row=[0.0], kind=1), WITH_METRIC),
    Case("Metrics", "a size of 1e-300", "refused", 3, "metric at vertex 1",
         metric(row=[1e-300], kind=1), WITH_METRIC),
    Case("Metrics", "the same in a tensor", "refused", 3, "metric at vertex 5",
         metric(row=[1e200, 0, 1, 0, 0, 1], at=5), WITH_METRIC),
    Case("Metrics", "the same in a config", "refused", 2, "/metric", config(metric={"expression": {"size": "1e-300"}}),
         RUN),
    Case("Metrics", "vectors instead of tensors", "refused", 3, "is no metric", metric(row=[1.0, 1, 1], kind=2),
         WITH_METRIC),
    Case("Metrics", "a mesh instead of a metric", "refused", 3, "no SolAtVertices",
         lambda: plain(block)() | {"m.solb": binary_file(block(), 2)}, WITH_METRIC),
    Case("Metrics", "cut off", "refused", 3, "cut off",
         lambda: plain(block)() | {"m.solb": metric()()["m.solb"][:-9]}, WITH_METRIC),
    Case("Metrics", "an assignment in a formula", "refused", 2, "at position 2 (write == to compare", plain(block),
         CURVE + ("--metric", '{"expression": {"size": "x=0.5 ? 1 : 2"}}')),
    Case("Metrics", "no such file", "refused", 3, "m.solb: cannot be read", plain(block), WITH_METRIC),

    # ------------------------------------------------ solutions
    Case("Solutions", "edges in the order in which elements first have them", "refused", 3,
         "in the order in which these edges", lambda: quadratic_solution(lambda edges: edges), FOR_SOLUTION),
    Case("Solutions", "edges in any other order", "refused", 3, "are in another order",
         lambda: quadratic_solution(shuffled), FOR_SOLUTION),
    Case("Solutions", "with another number of rows", "refused", 3, "has 1680 rows, but the mesh has 441 vertices, or 1681 nodes",
         lambda: quadratic_solution(lambda edges: sorted(edges)[1:]), FOR_SOLUTION),

    # ------------------------------------------------ files and configs
    Case("Files", "no such mesh", "refused", 3, "in.mesh: cannot be read", lambda: {}),
    Case("Files", "a folder as the mesh", "refused", 3, "in.mesh: cannot be read", lambda: {"in.mesh": None}),
    Case("Files", "a mesh that may not be read", "refused", 3, "in.mesh: cannot be read", plain(block),
         as_unprivileged_user=True, setup=lambda folder: os.chmod(folder / "in.mesh", 0)),
    Case("Files", "a device without an end", "refused", 3, "belongs to a known format", lambda: {},
         ("curve", "/dev/zero", "-o", "out.mesh")),
    Case("Files", "a device without an end that is named as a mesh", "refused", 3, "a stream of more than 64.0 MiB", lambda: {},
         setup=lambda folder: os.symlink("/dev/zero", folder / "in.mesh")),
    Case("Files", "no such config", "refused", 2, "run.json: cannot be read", lambda: {}, RUN),
    Case("Files", "a folder as the config", "refused", 2, "run.json: cannot be read", lambda: {"run.json": None}, RUN),
    Case("Files", "a config that may not be read", "refused", 2, "run.json: cannot be read", config(), RUN,
         as_unprivileged_user=True, setup=lambda folder: os.chmod(folder / "run.json", 0)),
    Case("Files", "a config that is no JSON", "refused", 2, "line 1", lambda: {"run.json": b"{\"input\": }"}, RUN),
    Case("Files", "a config that names no such mesh", "refused", 3, "absent.mesh: cannot be read",
         config(input={"mesh": "absent.mesh"}), RUN),
    Case("Files", "a config that names no such metric", "refused", 3, "absent.solb: cannot be read",
         config(metric={"file": "absent.solb"}), RUN),

    # ------------------------------------------------ CAD models
    Case("CAD models", "of an unknown format", "refused", 2, "no CAD format known", plain(block),
         CURVE + ("--cad", "in.mesh")),
    Case("CAD models", "no such file", "refused", 3, "absent.step: cannot be opened", plain(block),
         CURVE + ("--cad", "absent.step"), needs=bad_moments.no_cad),
    Case("CAD models", "no model", "refused", 3, "it is not a STEP file", lambda: plain(block)() | {"m.step": b"solid\n"},
         CURVE + ("--cad", "m.step"), needs=bad_moments.no_cad),
    Case("CAD models", "of another part", "refused", 3, "the mesh's boundary reaches from", with_cad_shell,
         CURVE + ("--cad", "shell.brep"), needs=bad_moments.no_cad),
    Case("CAD models", "in another unit than the mesh", "refused", 3, "give that as the unit", with_cad_shell,
         ("curve", "shell.mesh", "-o", "out.mesh", "--cad", "shell.brep", "--cad-unit", "m"), needs=bad_moments.no_cad),
    Case("CAD models", "of the same part with another size", "refused", 3, "away from CAD face", lambda: with_cad_shell(5.5),
         ("curve", "shell.mesh", "-o", "out.mesh", "--cad", "shell.brep"), needs=bad_moments.no_cad),
    Case("CAD models", "a unit without a model", "refused", 2, "--cad-unit", plain(block), CURVE + ("--cad-unit", "mm")),
    Case("CAD models", "vertices to move without a model", "refused", 2, "--cad-vertices", plain(block),
         CURVE + ("--cad-vertices", "move")),
    Case("CAD models", "a reference named twice", "refused", 2, "is named twice", with_cad_shell,
         ("curve", "shell.mesh", "-o", "out.mesh", "--geometry",
          '{"cad": {"file": "shell.brep", "references": [1, 1]}}'), needs=bad_moments.no_cad),
    Case("CAD models", "a reference that no facet has", "refused", 2, "no boundary triangle", with_cad_shell,
         ("curve", "shell.mesh", "-o", "out.mesh", "--geometry",
          '{"cad": {"file": "shell.brep", "references": [99]}}'), needs=bad_moments.no_cad),
    Case("CAD models", "a model and another geometry", "refused", 2, "--geometry", plain(block),
         CURVE + ("--cad", "m.step", "--geometry", "straight")),

    Case("CAD models", "a device without an end", "refused", 3, "is not a regular file", plain(block), CURVE + ("--cad", "m.step"),
         setup=lambda folder: os.symlink("/dev/zero", folder / "m.step"), needs=bad_moments.no_cad),

    # ------------------------------------------------ output
    Case("Output", "below a file instead of a folder", "refused", 3, "its folder in.mesh/deep is below a file", plain(block),
         ("curve", "in.mesh", "-o", "in.mesh/deep/out.mesh")),
    Case("Output", "a folder", "refused", 3, "Is a directory", lambda: plain(block)() | {"out.mesh": None}),
    Case("Output", "not permitted", "refused", 3, "Permission denied", lambda: plain(block)() | {"closed": None},
         ("curve", "in.mesh", "-o", "closed/out.mesh"), as_unprivileged_user=True,
         setup=lambda folder: os.chmod(folder / "closed", 0o555)),
    Case("Output", "of an unknown format", "refused", 2, "no format known", plain(block),
         ("curve", "in.mesh", "-o", "out.xyz")),
    Case("Output", "a full device", "refused", 3, "No space left on device", plain(block),
         setup=lambda folder: os.symlink("/dev/full", folder / "out.mesh")),
    Case("Output", "beyond the largest size of a file (ulimit -f)", "refused", 3, "File too large", plain(block),
         limits=((resource.RLIMIT_FSIZE, 512),)),
    Case("Output", "temporary files of arrays beyond the largest size of a file (--memory, ulimit -f)", "refused", 3,
         "temporary files of arrays cannot be written: File too large", lambda: {"in.meshb": binary_file(cube(20), 2)},
         ("curve", "in.meshb", "-o", "out.meshb", "--memory", "50"),
         limits=((resource.RLIMIT_FSIZE, 300 << 10),)),
    Case("Output", "a full disk", "refused", 3, "No space left on device", plain(lambda: cube(6)),
         ("curve", "in.mesh", "-o", "disk/out.mesh"), run=bad_moments.on_a_full_disk, needs=bad_moments.no_disk),

    Case("Output", "the report over the mesh that is read", "refused", 2, "inputs are not overwritten", plain(block),
         (*CURVE, "--report", "in.mesh")),
    Case("Output", "the report over the metric, through a link", "refused", 2, "--metric m.solb",
         lambda: plain(block)() | {"m.solb": b""}, (*WITH_METRIC, "--report", "link"),
         setup=lambda folder: os.symlink("m.solb", folder / "link")),
    Case("Output", "two in one file", "refused", 2, "give --report a separate file", plain(block),
         (*CURVE, "--report", "./out.mesh")),
    Case("Output", "a path with a NUL character", "refused", 2, "NUL",
         lambda: {"run.json": b'{"input": {"mesh": "in.mesh"}, "output": {"mesh": "out.mesh", "report": "x\\u0000y"}}'},
         RUN),
    Case("Output", "standard output on a full device", "refused", 3, "standard output: cannot be written", plain(block),
         run=bad_moments.printing_on_a_full_device),

    # ------------------------------------------------ memory and threads
    Case("Memory", "less than the run is estimated to need (ulimit -v)", "refused", 4, "the run needs about",
         bad_moments.box_config(30), RUN_SEQUENTIALLY, limits=((resource.RLIMIT_AS, 60 << 20),),
         needs=bad_moments.address_sanitizer),
    Case("Memory", "none left on the way (ulimit -v)", "refused", 4, "not enough memory", bad_moments.box_config(10),
         RUN_SEQUENTIALLY, run=bad_moments.with_ever_more_memory, needs=bad_moments.address_sanitizer),
    Case("Memory", "none left on the way, several threads", "refused", 4, "not enough memory",
         bad_moments.box_config(10), RUN, run=bad_moments.with_ever_more_memory_for_threads,
         needs=bad_moments.address_sanitizer),
    Case("Memory", "no thread to be had (ulimit -u)", "refused", 4, "the system refuses", bad_moments.box_config(10),
         RUN, limits=((resource.RLIMIT_NPROC, 1),), as_unprivileged_user=True, needs=bad_moments.no_threads_to_refuse),

    # ------------------------------------------------ interrupts
    Case("Interrupts", "Ctrl-C while a file is read", "refused", 130, "stopped on request", lambda: {},
         run=bad_moments.interrupted_reading),
    Case("Interrupts", "Ctrl-C during the work", "refused", 130, "stopped on request", bad_moments.box_config(48),
         RUN, run=bad_moments.interrupted_working),
    Case("Interrupts", "Ctrl-C while a file is written", "refused", 130, "stopped on request", plain(lambda: cube(6)),
         run=bad_moments.interrupted_writing),
    Case("Interrupts", "Ctrl-C at any other time", "refused", 130, "stopped on request", plain(lambda: cube(6)),
         run=bad_moments.interrupted_anywhere),
]
