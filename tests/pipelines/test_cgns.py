"""CGNS files: written files pass cgnscheck and are read again; files written with the CGNS library are read.

    python3 tests/pipelines/test_cgns.py build/bin/camber [unittest arguments]
"""
import ctypes
import ctypes.util
import json
import re
import resource
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np

from program import SANITIZED, Folder
from readers import needs

import gmf

WRITE, UNSTRUCTURED, REAL_DOUBLE, POINT_LIST, POINT_RANGE = 1, 3, 4, 2, 4
BAR_2, TRI_3, QUAD_4, TETRA_4, MIXED = 3, 5, 7, 10, 20
VERTEX, FACE_CENTER = 2, 4
USER_DEFINED, ABUTTING_1_TO_1 = 1, 4
TYPES = Path("/usr/include/cgnstypes.h")
IS_HERE = ctypes.util.find_library("cgns") is not None and TYPES.exists()
# The library has one integer width.
SIZE = ctypes.c_int if IS_HERE and re.search(r"define CG_BUILD_64BIT\s+0", TYPES.read_text()) else ctypes.c_long
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1.]])
TETRAHEDRA = [[1, 2, 3, 4], [2, 5, 3, 4]]
TRIANGLES = [[1, 3, 2], [1, 2, 4], [1, 4, 3], [2, 3, 5], [3, 4, 5], [2, 5, 4]]


class File:
    """Writes a CGNS file with the library; each call must succeed."""

    def __init__(self, path, points, cells, dimension=3):
        name = ctypes.util.find_library("cgns")
        self.library = ctypes.CDLL(name)
        self.library.cg_get_error.restype = ctypes.c_char_p
        self.number = ctypes.c_int()
        self.call("open", str(path).encode(), WRITE, ctypes.byref(self.number))
        one = ctypes.c_int()
        self.call("base_write", self.number, b"Base", dimension, 3, ctypes.byref(one))
        self.begin_zone(b"Zone", points, cells)

    def begin_zone(self, name, points, cells):
        """Starts a zone; later calls apply to it."""
        zone, one = ctypes.c_int(), ctypes.c_int()
        self.call("zone_write", self.number, 1, name, self.sizes(len(points), cells, 0), UNSTRUCTURED, ctypes.byref(zone))
        self.zone = zone.value
        for c, axis in enumerate(b"XYZ"):
            column = np.ascontiguousarray(points[:, c], dtype=np.float64)
            self.call("coord_write", self.number, 1, self.zone, REAL_DOUBLE, b"Coordinate" + bytes([axis]),
                      column.ctypes.data_as(ctypes.c_void_p), ctypes.byref(one))

    def call(self, name, *arguments):
        done = getattr(self.library, "cg_" + name)(*arguments)
        assert done == 0, (name, self.library.cg_get_error())

    @staticmethod
    def sizes(*numbers):
        return (SIZE * len(numbers))(*numbers)

    def section(self, name, kind, first, last, numbers):
        s = ctypes.c_int()
        self.call("section_write", self.number, 1, self.zone, name, kind, SIZE(first), SIZE(last), 0,
                  self.sizes(*numbers), ctypes.byref(s))

    def mixed_section(self, name, first, cells):
        """Cells as (type, nodes)."""
        numbers, offsets, s = [], [0], ctypes.c_int()
        for kind, nodes in cells:
            numbers += [kind, *nodes]
            offsets.append(len(numbers))
        self.call("poly_section_write", self.number, 1, self.zone, name, MIXED, SIZE(first),
                  SIZE(first + len(cells) - 1), 0, self.sizes(*numbers), self.sizes(*offsets), ctypes.byref(s))

    def condition(self, name, kind, location, numbers):
        bc = ctypes.c_int()
        self.call("boco_write", self.number, 1, self.zone, name, USER_DEFINED, kind, SIZE(len(numbers)),
                  self.sizes(*numbers), ctypes.byref(bc))
        self.call("boco_gridlocation_write", self.number, 1, self.zone, bc, location)

    def connection(self, name, vertices, donor):
        """Writes a one-to-one connection of vertices of this zone to those of another."""
        one = ctypes.c_int()
        self.call("conn_write_short", self.number, 1, self.zone, name, VERTEX, ABUTTING_1_TO_1, POINT_LIST,
                  SIZE(len(vertices)), self.sizes(*vertices), donor, ctypes.byref(one))

    def close(self):
        self.call("close", self.number)


class Hdf5:
    """Modifies a CGNS file through HDF5; each call must succeed."""

    def __init__(self, path):
        name = ctypes.util.find_library("hdf5_serial") or ctypes.util.find_library("hdf5")
        if name is None:
            raise unittest.SkipTest("no HDF5 here")
        self.library = ctypes.CDLL(name)
        self.call("H5open")
        self.file = self.call("H5Fopen", str(path).encode(), ctypes.c_uint(1), 0)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.call("H5Fclose", self.file)

    def call(self, name, *arguments):
        function = getattr(self.library, name)
        function.restype = ctypes.c_int64 if name in ("H5Fopen", "H5Dopen2", "H5Dcreate2", "H5Screate_simple", "H5Pcreate") else ctypes.c_int
        done = function(*(ctypes.c_int64(a) if isinstance(a, int) else a for a in arguments))
        assert done >= 0, name
        return done

    def of_library(self, name):
        return ctypes.c_int64.in_dll(self.library, name).value

    def set_numbers(self, path, numbers):
        data = self.call("H5Dopen2", self.file, path, 0)
        kind = self.of_library("H5T_NATIVE_INT_g" if SIZE is ctypes.c_int else "H5T_NATIVE_LONG_g")
        self.call("H5Dwrite", data, kind, 0, 0, 0, (SIZE * len(numbers))(*numbers))
        self.call("H5Dclose", data)

    def blow_up(self, node, kind, size):
        """Replaces the data of a node by a chunked data set of `size` numbers without written chunks."""
        self.call("H5Ldelete", self.file, node + b"/ data", 0)
        space = self.call("H5Screate_simple", 1, (ctypes.c_uint64 * 1)(size), None)
        options = self.call("H5Pcreate", self.of_library("H5P_CLS_DATASET_CREATE_ID_g"))
        self.call("H5Pset_chunk", options, 1, (ctypes.c_uint64 * 1)(1 << 20))
        data = self.call("H5Dcreate2", self.file, node + b"/ data", self.of_library(f"H5T_NATIVE_{kind}_g"), space, 0, options, 0)
        for name, thing in (("H5Dclose", data), ("H5Pclose", options), ("H5Sclose", space)):
            self.call(name, thing)


@unittest.skipUnless(IS_HERE, "no CGNS here")
class Cgns(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return self.folder.path / name

    def run_camber(self, *arguments):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def info(self, name):
        return json.loads(self.run_camber("info", "--json", name).stdout)

    @needs("cgnscheck")
    def test_written_files_pass_cgnscheck_and_are_read_unchanged(self):
        shapes = {"box": {"box": {"cells": [2, 2, 2]}}, "annulus": {"annulus": {"inner_layer": {"count": 3, "first_height": 0.05, "growth": 1.3}}},
                  "shell": {"shell": {"inner_size": 0.8, "outer_size": 2.5}}}
        for shape, options in shapes.items():
            for stages in ([], ["elevate", "curve", "validate", "relax", "commit"]):
                config = {"input": {"generate": options}, "stages": stages, "output": {"mesh": "a.cgns"}}
                self.path("run.json").write_text(json.dumps(config))
                self.run_camber("run", "run.json")
                config["output"] = {"mesh": "a.meshb"}
                self.path("run.json").write_text(json.dumps(config))
                self.run_camber("run", "run.json")
                checked = subprocess.run(["cgnscheck", str(self.path("a.cgns"))], capture_output=True, text=True)
                self.assertNotIn("ERROR", checked.stdout + checked.stderr)
                # The only warnings are missing units of coordinates.
                self.assertEqual((checked.stdout + checked.stderr).count("WARNING"), checked.stdout.count("dataclass not given"))
                self.run_camber("convert", "a.cgns", "-o", "b.meshb")
                a, b = gmf.read(self.path("a.meshb")), gmf.read(self.path("b.meshb"))
                np.testing.assert_array_equal(a.points, b.points)
                self.assertEqual(sorted(a.cells), sorted(b.cells))
                for kind, cells in a.cells.items():
                    rows = [sorted(map(tuple, np.column_stack([m.cells[kind].nodes, m.cells[kind].refs]))) for m in (a, b)]
                    self.assertEqual(*rows)

    def test_fields_are_written_to_cgns_and_read_back(self):
        self.path("run.json").write_text(json.dumps({"input": {"generate": {"box": {"cells": [2, 2, 2]}}}, "stages": [],
                                                     "output": {"mesh": "a.mesh"}}))
        self.run_camber("run", "run.json")
        n = len(gmf.read(self.path("a.mesh")).points)
        rows = "\n".join(f"{i} {i / 8} {-i} {i * i}" for i in range(n))
        self.path("a.sol").write_text(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{n}\n2 1 2\n{rows}\nEnd\n")
        self.run_camber("convert", "a.mesh", "-o", "a.cgns", "--metric", "a.sol")
        self.assertEqual([(f["name"], f["kind"]) for f in self.info("a.cgns")["fields"]],
                         [("field_1", "scalar"), ("field_2", "vector")])
        self.run_camber("convert", "a.cgns", "-o", "b.sol")
        self.run_camber("convert", "a.sol", "-o", "c.sol")
        self.assertEqual(self.path("b.sol").read_bytes(), self.path("c.sol").read_bytes())

    def test_mixed_sections_and_boundary_conditions_become_references_and_groups(self):
        file = File(self.path("mixed.cgns"), POINTS, 2)
        file.mixed_section(b"fluid", 1, [(TETRA_4, t) for t in TETRAHEDRA] + [(TRI_3, t) for t in TRIANGLES[:3]])
        file.section(b"far", TRI_3, 6, 8, [n for cell in TRIANGLES[3:] for n in cell])
        file.condition(b"floor", POINT_LIST, VERTEX, [1, 2, 3])
        file.condition(b"sides", POINT_LIST, FACE_CENTER, [4, 5])
        file.condition(b"nowhere", POINT_RANGE, FACE_CENTER, [90, 95])
        file.close()
        info = self.info("mixed.cgns")
        self.assertEqual((info["tetrahedra"], info["triangles_by_reference"]), (2, {"1": 1, "2": 2, "4": 3}))
        self.assertEqual({(g["dimension"], g["reference"]): g["name"] for g in info["groups"]},
                         {(2, 1): "floor", (2, 2): "sides", (2, 4): "far", (3, 1): "fluid"})
        self.assertIn('the boundary condition "nowhere" contains no face of the mesh', info["notices"])
        self.run_camber("check", "mixed.cgns")

    def test_references_stated_in_the_file_are_assigned_to_one_group_only(self):
        file = File(self.path("given.cgns"), POINTS, 2)
        file.section(b"fluid", TETRA_4, 1, 2, [n for cell in TETRAHEDRA for n in cell])
        file.section(b"loose", TRI_3, 3, 5, [n for cell in TRIANGLES[:3] for n in cell])
        file.section(b"listed", TRI_3, 6, 8, [n for cell in TRIANGLES[3:] for n in cell])
        file.condition(b"wall", POINT_RANGE, FACE_CENTER, [6, 8])
        file.call("goto", file.number, 1, b"Zone_t", 1, b"ZoneBC_t", 1, b"BC_t", 1, b"end")
        file.call("descriptor_write", b"reference", b"1")
        file.close()
        info = self.info("given.cgns")
        self.assertEqual(info["triangles_by_reference"], {"1": 3, "2": 3})
        self.assertEqual({(g["dimension"], g["reference"]): g["name"] for g in info["groups"]},
                         {(2, 1): "wall", (2, 2): "loose", (3, 1): "fluid"})

    def test_boundary_conditions_of_a_surface_assign_references_to_its_edges(self):
        square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1.]])
        file = File(self.path("surface.cgns"), square, 2, dimension=2)
        file.section(b"skin", TRI_3, 1, 2, [1, 2, 3, 1, 3, 4])
        file.section(b"rim", BAR_2, 3, 6, [1, 2, 2, 3, 3, 4, 4, 1])
        file.condition(b"edge", POINT_LIST, VERTEX, [1, 2, 3])
        file.close()
        info = self.info("surface.cgns")
        self.assertEqual((info["triangles_by_reference"], info["edges_by_reference"]), ({"1": 2}, {"1": 2, "2": 2}))

    def test_a_file_size_limit_is_an_error_and_leaves_no_output(self):
        self.path("run.json").write_text(json.dumps({"input": {"generate": {"box": {"cells": [8, 8, 8]}}}, "stages": [],
                                                     "output": {"mesh": "a.meshb"}}))
        self.run_camber("run", "run.json")
        few = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))  # noqa: E731
        done = self.folder.camber("convert", "a.meshb", "-o", "a.cgns", preexec_fn=few)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("cannot be", done.stderr)
        self.assertNotIn("a.cgns", self.folder.files())

    def zones(self, name, connected):
        """The two tetrahedra in separate zones, with the faces of the box as walls."""
        file = File(self.path(name), POINTS[:4], 1)
        file.section(b"solid", TETRA_4, 1, 1, [1, 2, 3, 4])
        file.section(b"faces", TRI_3, 2, 4, [n for cell in TRIANGLES[:3] for n in cell])
        file.condition(b"wall", POINT_RANGE, FACE_CENTER, [2, 4])
        if connected:
            file.connection(b"to the right", [2, 3, 4], b"Right")
        file.begin_zone(b"Right", POINTS[1:], 1)
        file.section(b"solid", TETRA_4, 1, 1, [1, 4, 2, 3])
        file.section(b"faces", TRI_3, 2, 4, [n - 1 for cell in TRIANGLES[3:] for n in cell])
        file.condition(b"wall", POINT_RANGE, FACE_CENTER, [2, 4])
        file.close()

    def test_zones_are_joined_at_connections_or_selected_by_name(self):
        self.zones("apart.cgns", False)
        self.zones("joined.cgns", True)
        apart, joined = self.info("apart.cgns"), self.info("joined.cgns")
        self.assertEqual((apart["vertices"], joined["vertices"]), (8, 5))
        for info in (apart, joined):
            self.assertEqual(info["tetrahedra_by_reference"], {"1": 1, "2": 1})
            self.assertEqual(info["triangles_by_reference"], {"1": 6})
            self.assertEqual({(g["dimension"], g["reference"]): g["name"] for g in info["groups"]},
                             {(2, 1): "wall", (3, 1): "Right solid", (3, 2): "Zone solid"})
        self.assertIn("2 zones were joined into one mesh, at 3 vertices", joined["notices"])
        self.run_camber("curve", "joined.cgns", "-o", "curved.meshb")
        for zone in ("Right", "1"):  # by name, in the order of the library
            done = self.run_camber("info", "joined.cgns", "--zone", zone, "--json")
            self.assertEqual(json.loads(done.stdout)["vertices"], 4)
            self.run_camber("convert", "joined.cgns", "-o", "right.meshb", "--zone", zone)
        done = self.folder.camber("info", "joined.cgns", "--zone", "Left")
        self.assertEqual(done.returncode, 3)
        self.assertIn('joined.cgns: has no zone "Left" (its zones are Right, Zone)', done.stderr)

    def test_unsupported_cells_and_bad_node_numbers_are_rejected(self):
        file = File(self.path("quads.cgns"), POINTS, 2)
        file.section(b"fluid", TETRA_4, 1, 2, [n for cell in TETRAHEDRA for n in cell])
        file.section(b"quads", QUAD_4, 3, 5, [1, 2, 3, 4] * 3)
        file.close()
        done = self.folder.camber("check", "quads.cgns")
        self.assertEqual(done.returncode, 3)
        self.assertIn("quads.cgns: holds 3 QUAD_4, which Camber does not support", done.stderr)
        self.assertEqual(self.info("quads.cgns")["not_held"], {"QUAD_4": 3})
        file = File(self.path("far.cgns"), POINTS, 1)
        file.section(b"fluid", TETRA_4, 1, 1, [1, 2, 3, 99])
        file.close()
        done = self.folder.camber("info", "far.cgns")
        self.assertEqual(done.returncode, 3)
        self.assertIn("far.cgns: tetrahedron 1: a node is not one of those that the file lists", done.stderr)

    # Guards against the allocation of gigabytes for data sets without chunks.
    def test_data_sets_without_written_chunks_are_rejected(self):
        """An HDF5 data set has its declared size even if no chunk is written."""
        many = 400_000_000
        for changed in ("vertices", "elements", "a name"):
            file = File(self.path("bomb.cgns"), POINTS, 2)
            file.section(b"fluid", TETRA_4, 1, 2, [n for cell in TETRAHEDRA for n in cell])
            file.call("goto", file.number, 1, b"end")
            file.call("descriptor_write", b"reference", b"1")
            file.close()
            with Hdf5(self.path("bomb.cgns")) as file:
                if changed == "vertices":
                    file.set_numbers(b"/Base/Zone/ data", [many, 2, 0])
                    for axis in b"XYZ":
                        file.blow_up(b"/Base/Zone/GridCoordinates/Coordinate" + bytes([axis]), "DOUBLE", many)
                elif changed == "elements":
                    file.set_numbers(b"/Base/Zone/fluid/ElementRange/ data", [1, many])
                    file.blow_up(b"/Base/Zone/fluid/ElementConnectivity", "INT" if SIZE is ctypes.c_int else "LONG", 4 * many)
                else:
                    file.blow_up(b"/Base/reference", "SCHAR", 8 * many)
            self.assertLess(self.path("bomb.cgns").stat().st_size, 100_000)
            limit = None if SANITIZED else lambda: resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
            done = self.folder.camber("info", "bomb.cgns", preexec_fn=limit)
            self.assertEqual(done.returncode, 3, (changed, done.stderr))
            self.assertIn("bomb.cgns: " + ("" if changed == "a name" else "its nodes declare more than 64 MiB"), done.stderr)

    def test_cgns_rejects_an_empty_mesh(self):
        self.path("empty.mesh").write_text("MeshVersionFormatted 2\nDimension 3\nVertices\n0\nEnd\n")
        done = self.folder.camber("convert", "empty.mesh", "-o", "empty.cgns")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("a CGNS zone must have vertices", done.stderr)

    def test_a_damaged_file_is_an_error(self):
        self.path("cut.cgns").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(200))
        done = self.folder.camber("info", "cut.cgns")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("cut.cgns: the file cannot be opened as CGNS", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
