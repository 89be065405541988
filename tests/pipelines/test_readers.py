"""Files that others wrote, read by the program: VTK's and meshio's .vtu in every encoding.

    /usr/bin/python3 tests/pipelines/test_readers.py build/bin/camber [unittest arguments]
"""
import itertools
import json
import sys
import unittest

import numpy as np

from program import Folder
from readers import needs

import gmf

SHAPES = {2: {"annulus": {"inner_layer": {"count": 3, "first_height": 0.05, "growth": 1.3}}},
          3: {"shell": {"inner_size": 0.8, "outer_size": 2.5}}}
STAGES = {1: [], 2: ["elevate", "curve", "validate", "relax", "commit"]}
# degree (or kind) -> VTK's cell type by dimension
VTK_TYPES = {1: {1: 3, 2: 5, 3: 10}, 2: {1: 21, 2: 22, 3: 24}, "lagrange": {1: 68, 2: 69, 3: 71},
             "lagrange of degree 1": {1: 68, 2: 69, 3: 71}}
MESHIO_NAMES = {1: {1: "line", 2: "triangle", 3: "tetra"}, 2: {1: "line3", 2: "triangle6", 3: "tetra10"}}


class Readers(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.random = np.random.default_rng(5)

    def path(self, name):
        return self.folder.path / name

    def run_camber(self, *arguments):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, 0, (arguments, done.stderr))
        return done

    def made(self, dimension, degree):
        """A mesh of Camber's as its GMF file has it, the points in another order."""
        config = {"input": {"generate": SHAPES[dimension]}, "stages": STAGES[degree], "output": {"mesh": "made.meshb"}}
        self.path("run.json").write_text(json.dumps(config))
        self.run_camber("run", "run.json")
        mesh = gmf.read(self.path("made.meshb"))
        order = self.random.permutation(len(mesh.points))
        place = np.argsort(order)
        mesh.points, mesh.point_refs = mesh.points[order], self.random.integers(0, 9, len(order))
        for cells in mesh.cells.values():
            cells.nodes = place[cells.nodes]
        return mesh

    def by_dimension(self, mesh):
        return {gmf.CELLS[name][0]: cells for name, cells in mesh.cells.items()}

    def same(self, given, name, tolerance):
        """What Camber makes of the file has the nodes, cells and references that were given, cells in their order by dimension."""
        self.run_camber("convert", name, "-o", "read.mesh")
        read = gmf.read(self.path("read.mesh"))
        wanted, found = self.by_dimension(given), self.by_dimension(read)
        self.assertEqual(set(wanted), set(found))
        self.assertEqual(len(read.points), len(given.points))
        corners = set()
        for k, cells in wanted.items():
            np.testing.assert_array_equal(found[k].refs, cells.refs)
            self.assertEqual(found[k].nodes.shape, cells.nodes.shape)
            difference = read.points[found[k].nodes][:, :, :given.dim] - given.points[cells.nodes]
            self.assertLessEqual(abs(difference).max(), tolerance)
            ends = slice(0, k + 1)
            np.testing.assert_array_equal(read.point_refs[found[k].nodes[:, ends]],
                                          given.point_refs[cells.nodes[:, ends]])
            corners.update(found[k].nodes[:, ends].ravel())
        info = json.loads(self.run_camber("info", name, "--json").stdout)
        self.assertEqual((info["dimension"], info["vertices"]), (given.dim, len(corners)))
        elements = "triangles" if given.dim == 2 else "tetrahedra"
        self.assertEqual(info[elements], len(wanted[given.dim].nodes))
        self.assertEqual(sum(info[elements + "_by_reference"].values()), info[elements])
        return info

    def vtk_grid(self, mesh, kind):
        """The mesh with cells of all dimensions mixed, and with arrays of points and cells."""
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
        grid, points = vtkUnstructuredGrid(), vtkPoints()
        points.SetDataTypeToDouble()
        points.SetData(numpy_to_vtk(np.pad(mesh.points, ((0, 0), (0, 3 - mesh.dim))), deep=True))
        grid.SetPoints(points)
        references = []
        columns = [[(VTK_TYPES[kind][k], row, ref) for row, ref in zip(cells.nodes, cells.refs)]
                   for k, cells in self.by_dimension(mesh).items()]
        for group in itertools.zip_longest(*columns):
            for cell in filter(None, group):
                grid.InsertNextCell(cell[0], len(cell[1]), [int(n) for n in cell[1]])
                references.append(cell[2])

        def add(data, name, values):
            array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
            array.SetName(name)
            data.AddArray(array)
        n, c = len(mesh.points), len(references)
        add(grid.GetPointData(), "reference", mesh.point_refs.astype(np.int32))
        add(grid.GetPointData(), "velocity", self.random.random((n, 3)))
        add(grid.GetPointData(), "pair", self.random.random((n, 2)).astype(np.float32))
        add(grid.GetCellData(), "quality", self.random.random(c))
        add(grid.GetCellData(), "CellEntityIds", np.array(references, np.int64))
        add(grid.GetFieldData(), "TimeValue", np.array([0.5]))
        return grid

    @needs("vtkmodules")
    def test_vtk_in_every_encoding(self):
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter
        mesh = self.made(3, 2)
        grid = self.vtk_grid(mesh, 2)
        tried = 0
        for mode, encode, compress, header, order in itertools.product(
                ("Ascii", "Binary", "Appended"), (False, True), ("None", "ZLib"), ("UInt32", "UInt64"),
                ("LittleEndian", "BigEndian")):
            if encode and mode != "Appended":
                continue
            writer = vtkXMLUnstructuredGridWriter()
            getattr(writer, "SetDataModeTo" + mode)()
            getattr(writer, "SetCompressorTypeTo" + compress)()
            getattr(writer, "SetHeaderTypeTo" + header)()
            getattr(writer, "SetByteOrderTo" + order)()
            writer.SetEncodeAppendedData(encode)
            writer.SetBlockSize(4096)  # several blocks an array
            writer.SetFileName(str(self.path("vtk.vtu")))
            writer.SetInputData(grid)
            self.assertEqual(writer.Write(), 1)
            with self.subTest(mode=mode, encode=encode, compress=compress, header=header, order=order):
                info = self.same(mesh, "vtk.vtu", 1e-9 if mode == "Ascii" else 0)
                self.assertEqual(len(info["notices"]), 3, info["notices"])  # pair, TimeValue, references of mid nodes
                tried += 1
        self.assertEqual(tried, 4 * 2 * 2 * 2)

    @needs("vtkmodules")
    def test_vtk_cells_of_all_kinds(self):
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter
        for dimension in SHAPES:
            for kind in VTK_TYPES:
                mesh = self.made(dimension, 1 if kind in (1, "lagrange of degree 1") else 2)
                writer = vtkXMLUnstructuredGridWriter()
                writer.SetFileName(str(self.path("vtk.vtu")))
                writer.SetInputData(self.vtk_grid(mesh, kind))
                self.assertEqual(writer.Write(), 1)
                with self.subTest(dimension=dimension, kind=kind):
                    self.same(mesh, "vtk.vtu", 0)

    @needs("vtkmodules")
    def test_what_vtk_writes_and_camber_cannot_hold(self):
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter
        mesh = self.made(3, 1)
        grid = self.vtk_grid(mesh, 1)
        for _ in range(3):
            grid.InsertNextCell(9, 4, [0, 1, 2, 3])
        grid.InsertNextCell(14, 5, [0, 1, 2, 3, 4])
        writer = vtkXMLUnstructuredGridWriter()
        writer.SetFileName(str(self.path("vtk.vtu")))
        writer.SetInputData(grid)
        for data in (grid.GetCellData(), grid.GetPointData()):
            data.Initialize()
        writer.Write()
        done = self.folder.camber("info", "vtk.vtu")
        self.assertEqual(done.returncode, 3)
        self.assertIn("holds 3 quadrilaterals, 1 pyramids, which Camber cannot hold", done.stderr)
        writer.SetCompressorTypeToLZ4()
        writer.Write()
        done = self.folder.camber("info", "vtk.vtu")
        self.assertEqual(done.returncode, 3)
        self.assertIn("another compressor", done.stderr)

    @needs("meshio")
    def test_meshio(self):
        import meshio
        for dimension, degree in itertools.product(SHAPES, STAGES):
            mesh = self.made(dimension, degree)
            cells = sorted(self.by_dimension(mesh).items())
            written = meshio.Mesh(np.pad(mesh.points, ((0, 0), (0, 3 - dimension))),
                                  [(MESHIO_NAMES[degree][k], c.nodes) for k, c in cells],
                                  point_data={"reference": mesh.point_refs, "t": self.random.random(len(mesh.points))},
                                  cell_data={"medit:ref": [c.refs for _, c in cells],
                                             "gmsh:geometrical": [c.refs + 1 for _, c in cells]})
            for binary, compression, header in itertools.product((False, True), (None, "zlib"), ("UInt32", "UInt64")):
                meshio.vtu.write(str(self.path("meshio.vtu")), written, binary=binary, compression=compression,
                                 header_type=header)
                with self.subTest(dimension=dimension, degree=degree, binary=binary, compression=compression):
                    self.same(mesh, "meshio.vtu", 1e-9 if not binary else 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
