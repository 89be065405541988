"""Files of other programs: .vtu of VTK and meshio in every encoding, .su2 of Gmsh, STL of all three, and written MFEM
meshes against an independent reader.

    /usr/bin/python3 tests/pipelines/test_readers.py build/bin/camber [unittest arguments]
"""
import itertools
import json
import subprocess
import sys
import unittest

import numpy as np

from program import Folder
from readers import needs

import gmf
import mfem_reader
import sample_meshes

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
        """A mesh of Camber, read from its GMF file, with permuted points."""
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

    def same(self, expected_mesh, name, tolerance):
        """Checks that Camber reads nodes, cells and references of the file, cells in their order by dimension."""
        self.run_camber("convert", name, "-o", "read.mesh")
        read = gmf.read(self.path("read.mesh"))
        expected, found = self.by_dimension(expected_mesh), self.by_dimension(read)
        self.assertEqual(set(expected), set(found))
        self.assertEqual(len(read.points), len(expected_mesh.points))
        corners = set()
        for k, cells in expected.items():
            np.testing.assert_array_equal(found[k].refs, cells.refs)
            self.assertEqual(found[k].nodes.shape, cells.nodes.shape)
            difference = read.points[found[k].nodes][:, :, :expected_mesh.dim] - expected_mesh.points[cells.nodes]
            self.assertLessEqual(abs(difference).max(), tolerance)
            ends = slice(0, k + 1)
            np.testing.assert_array_equal(read.point_refs[found[k].nodes[:, ends]],
                                          expected_mesh.point_refs[cells.nodes[:, ends]])
            corners.update(found[k].nodes[:, ends].ravel())
        info = json.loads(self.run_camber("info", name, "--json").stdout)
        self.assertEqual((info["dimension"], info["vertices"]), (expected_mesh.dim, len(corners)))
        elements = "triangles" if expected_mesh.dim == 2 else "tetrahedra"
        self.assertEqual(info[elements], len(expected[expected_mesh.dim].nodes))
        self.assertEqual(sum(info[elements + "_by_reference"].values()), info[elements])
        return info

    def vtk_grid(self, mesh, kind):
        """The mesh as a VTK grid with cells of all dimensions mixed and with point and cell arrays."""
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
    def test_vtu_files_of_vtk_are_read_in_every_encoding(self):
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
            writer.SetBlockSize(4096)  # several blocks per array
            writer.SetFileName(str(self.path("vtk.vtu")))
            writer.SetInputData(grid)
            self.assertEqual(writer.Write(), 1)
            with self.subTest(mode=mode, encode=encode, compress=compress, header=header, order=order):
                info = self.same(mesh, "vtk.vtu", 1e-9 if mode == "Ascii" else 0)
                self.assertEqual(len(info["notices"]), 3, info["notices"])  # pair, TimeValue, references of mid nodes
                tried += 1
        self.assertEqual(tried, 4 * 2 * 2 * 2)

    @needs("vtkmodules")
    def test_legacy_vtk_files_and_all_vtu_compressors_are_read(self):
        from vtkmodules.vtkIOLegacy import vtkUnstructuredGridWriter
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter
        mesh = self.made(3, 2)
        grid = self.vtk_grid(mesh, 2)
        for version, kind in itertools.product((42, 51), ("ASCII", "Binary")):
            writer = vtkUnstructuredGridWriter()
            writer.SetFileVersion(version)
            getattr(writer, "SetFileTypeTo" + kind)()
            writer.SetFileName(str(self.path("old.vtk")))
            writer.SetInputData(grid)
            self.assertEqual(writer.Write(), 1)
            with self.subTest(version=version, kind=kind):
                self.same(mesh, "old.vtk", 1e-9 if kind == "ASCII" else 0)
        for compress in ("LZ4", "LZMA"):
            writer = vtkXMLUnstructuredGridWriter()
            getattr(writer, "SetCompressorTypeTo" + compress)()
            writer.SetBlockSize(4096)
            writer.SetFileName(str(self.path("vtk.vtu")))
            writer.SetInputData(grid)
            self.assertEqual(writer.Write(), 1)
            with self.subTest(compress=compress):
                self.same(mesh, "vtk.vtu", 0)

    @needs("vtkmodules")
    def test_vtk_reads_written_vtk_and_stl_files(self):
        from vtkmodules.vtkFiltersCore import vtkMassProperties
        from vtkmodules.vtkIOGeometry import vtkSTLReader
        from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader
        for degree in (1, 2):
            mesh = self.made(3, degree)
            cells = sum(len(c.nodes) for c in mesh.cells.values())
            for name in ("vtk", "vtk-ascii"):
                self.run_camber("convert", "made.meshb", "-o", "ours.vtk", "--format", name)
                reader = vtkUnstructuredGridReader()
                reader.SetFileName(str(self.path("ours.vtk")))
                reader.Update()
                read = reader.GetOutput()
                self.assertEqual((read.GetNumberOfPoints(), read.GetNumberOfCells()), (len(mesh.points), cells))
                self.assertEqual(read.GetCellType(0), VTK_TYPES[degree][3])
            for name in ("stl", "stl-ascii"):
                self.run_camber("convert", "made.meshb", "-o", "ours.stl", "--format", name)
                reader = vtkSTLReader()
                reader.SetFileName(str(self.path("ours.stl")))
                masses = vtkMassProperties()
                masses.SetInputConnection(reader.GetOutputPort())
                masses.Update()
                shell = 4 / 3 * np.pi * (5 ** 3 - 1)
                self.assertLess(abs(masses.GetVolume() / shell - 1), 0.3 if degree == 1 else 0.1)

    def triangles(self, points, triangles):
        """Corners of all triangles in single precision, cyclically rotated to the smallest corner first."""
        corners = np.asarray(points, np.float32)[np.asarray(triangles)] + np.float32(0)
        turned = [min(tuple(map(tuple, np.roll(rows, n, axis=0))) for n in range(3)) for rows in corners.tolist()]
        return sorted(turned)

    def stl_read(self, name):
        """The triangles and references that Camber reads; coincident corners are merged."""
        self.run_camber("convert", name, "-o", "read.meshb")
        read = gmf.read(self.path("read.meshb"))
        self.assertEqual(len(np.unique(read.points, axis=0)), len(read.points))
        return self.triangles(read.points, read.cells["Triangles"].nodes), read.cells["Triangles"].refs

    def test_verbs_read_and_write_stl_files(self):
        self.run_camber("generate", "box", "--set", "cells=[3,3,3]", "-o", "box.meshb")
        for name in ("stl", "stl-ascii"):
            self.run_camber("convert", "box.meshb", "-o", "box.stl", "--format", name)
            reported = json.loads(self.run_camber("info", "box.stl", "--json").stdout)
            self.assertEqual((reported["vertices"], reported["triangles"], reported["tetrahedra"]), (56, 108, 0))
            self.assertEqual(len(reported.get("groups", [])), 6 if name == "stl-ascii" else 0)
            self.assertTrue(json.loads(self.run_camber("check", "box.stl", "--json").stdout)["soundness"]["sound"])
            self.run_camber("curve", "box.stl", "-o", "box.vtu")
            self.run_camber("convert", "box.stl", "-o", "again.stl", "--format", name)
            self.assertEqual(self.path("again.stl").read_bytes(), self.path("box.stl").read_bytes())
            self.path("cut.stl").write_bytes(self.path("box.stl").read_bytes()[:1000])
            cut = self.folder.camber("check", "cut.stl")
            self.assertEqual(cut.returncode, 3)
            self.assertRegex(cut.stderr, r"^camber: cut.stl: (line|byte) \d+: ")

    @needs("vtkmodules")
    def test_stl_files_are_exchanged_with_vtk(self):
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOGeometry import vtkSTLReader, vtkSTLWriter
        self.made(3, 1)
        for name in ("stl", "stl-ascii"):
            self.run_camber("convert", "made.meshb", "-o", "ours.stl", "--format", name)
            expected, _ = self.stl_read("ours.stl")
            reader = vtkSTLReader()
            reader.SetFileName(str(self.path("ours.stl")))
            reader.Update()
            surface = reader.GetOutput()
            points, rows = vtk_to_numpy(surface.GetPoints().GetData()), vtk_to_numpy(surface.GetPolys().GetConnectivityArray())
            self.assertEqual(self.triangles(points, rows.reshape(-1, 3)), expected)
            writer = vtkSTLWriter()
            writer.SetFileName(str(self.path("vtk.stl")))
            writer.SetInputData(surface)
            writer.SetFileTypeToBinary() if name == "stl" else writer.SetFileTypeToASCII()
            writer.Write()
            found, references = self.stl_read("vtk.stl")
            # VTK writes text with six digits.
            np.testing.assert_allclose(np.sort(np.ravel(found)), np.sort(np.ravel(expected)), rtol=0, atol=0 if name == "stl" else 1e-4)
            self.assertEqual(set(references), {1})

    @needs("meshio")
    def test_stl_files_are_exchanged_with_meshio(self):
        import meshio
        self.made(3, 1)
        for name in ("stl", "stl-ascii"):
            self.run_camber("convert", "made.meshb", "-o", "ours.stl", "--format", name)
            expected, _ = self.stl_read("ours.stl")
            read = meshio.read(self.path("ours.stl"))
            self.assertEqual(self.triangles(read.points, read.cells_dict["triangle"]), expected)
            read.write(self.path("theirs.stl"), binary=name == "stl")
            self.assertEqual(self.stl_read("theirs.stl")[0], expected)

    @needs("meshio")
    @needs("gmsh")
    def test_stl_files_of_gmsh_are_read_with_group_names(self):
        import meshio
        self.path("in.geo").write_text('SetFactory("OpenCASCADE");\nCylinder(1) = {0, 0, 0, 0, 0, 2, 1};\nMesh.MeshSizeMax = 0.5;\n'
                                       'Physical Surface("round", 4) = {1};\nPhysical Surface("caps", 2) = {2, 3};\n')
        for options in (["-setnumber", "Mesh.StlOneSolidPerSurface", "2"], ["-bin"]):
            for name in ("out.stl", "out.msh"):
                subprocess.run(["gmsh", "-2", "in.geo", *options, "-o", name], cwd=self.folder.path, check=True, capture_output=True)
            expected_mesh = meshio.read(self.path("out.msh"))
            found, references = self.stl_read("out.stl")
            self.assertEqual(found, self.triangles(expected_mesh.points, expected_mesh.cells_dict["triangle"]))
            groups = expected_mesh.cell_data_dict["gmsh:physical"]["triangle"]
            if options != ["-bin"]:
                self.assertEqual(sorted(np.bincount(references)[1:]), sorted(n for n in np.bincount(groups) if n))
                names = {group["name"] for group in json.loads(self.run_camber("info", "out.stl", "--json").stdout)["groups"]}
                self.assertEqual(names, {"round", "caps"})

    @needs("meshio")
    @needs("h5py")
    def test_meshio_reads_written_vtk_and_xdmf_files(self):
        import meshio
        for dimension, degree in itertools.product(SHAPES, (1, 2)):
            mesh = self.made(dimension, degree)
            cells = self.by_dimension(mesh)
            for name, kinds in (("ours.vtk", cells), ("ours.xdmf", cells if degree == 1 else [dimension])):
                self.run_camber("convert", "made.meshb", "-o", name)
                read = meshio.read(self.path(name))
                with self.subTest(dimension=dimension, degree=degree, name=name):
                    self.assertEqual({c.type: len(c.data) for c in read.cells},
                                     {MESHIO_NAMES[degree][k]: len(cells[k].nodes) for k in kinds})
                    self.assertEqual(len(read.points), len(mesh.points))

    @needs("vtkmodules")
    def test_vtk_cells_of_all_supported_types_are_read(self):
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
    def test_unsupported_vtk_cells_are_rejected_with_their_counts(self):
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
        for compress in (writer.SetCompressorTypeToZLib, writer.SetCompressorTypeToLZ4, writer.SetCompressorTypeToLZMA):
            compress()
            writer.Write()
            done = self.folder.camber("convert", "vtk.vtu", "-o", "vtk.mesh")
            self.assertEqual(done.returncode, 3)
            self.assertIn("holds 3 quadrilaterals, 1 pyramids, which Camber does not support", done.stderr)
            info = json.loads(self.folder.camber("info", "vtk.vtu", "--json").stdout)
            self.assertEqual(info["not_held"], {"quadrilaterals": 3, "pyramids": 1})
            self.assertIn("Tetrahedralize", info["split"])

    @needs("meshio")
    def test_vtu_files_of_meshio_are_read_in_every_encoding(self):
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

    def same_simplices(self, found, cells, k, mesh):
        """Checks that the simplices of an MFEM file equal the cells of the GMF file, node by node, bit for bit, except
        for attributes."""
        self.assertEqual(len(found), len(cells.nodes))
        for simplex, row in zip(found, cells.nodes):
            np.testing.assert_array_equal(simplex.corners, mesh.points[row[:k + 1]])
            if len(row) == k + 1:
                self.assertEqual(simplex.mid_nodes, {})
                continue
            mids = {frozenset(ends): place for ends, place in simplex.mid_nodes.items()}
            self.assertEqual(len(mids), len(row) - k - 1)
            for a, b, mid in gmf.LOCAL_EDGES[k]:
                np.testing.assert_array_equal(mids[frozenset((a, b))], mesh.points[row[mid]])

    def same_references(self, found, cells):
        """Positive references are preserved; each other reference gets a new unique one."""
        became = {}
        for simplex, reference in zip(found, cells.refs):
            self.assertGreater(simplex.attribute, 0)
            self.assertEqual(became.setdefault(int(reference), simplex.attribute), simplex.attribute)
        self.assertEqual(len(set(became.values())), len(became))
        self.assertTrue(all(reference == attribute for reference, attribute in became.items() if reference > 0), became)

    def test_an_independent_mfem_reader_reads_the_same_mesh(self):
        for dimension, degree in itertools.product(SHAPES, STAGES):
            mesh = self.made(dimension, degree)
            for surface in (False, True) if dimension == 3 else (False,):
                if surface:
                    mesh.cells = {name: c for name, c in mesh.cells.items() if gmf.CELLS[name][0] < 3}
                for cells in mesh.cells.values():
                    cells.refs[::3] = -5
                    cells.refs[1::3] = 0
                self.path("given.mesh").write_bytes(sample_meshes.ascii_file(mesh))
                reported = self.run_camber("convert", "given.mesh", "-o", "written.mfem").stderr
                self.assertIn("MFEM's attributes are positive: of the elements reference 0 becomes", reported)
                self.run_camber("convert", "given.mesh", "-o", "same.mesh")  # without unused vertices
                expected_mesh, found = gmf.read(self.path("same.mesh")), mfem_reader.read(self.path("written.mfem"))
                top = dimension - 1 if surface else dimension
                self.assertEqual(found.dimension, top)
                self.assertEqual(found.nodes.shape[1], dimension)
                by_dimension = self.by_dimension(expected_mesh)
                for rows, k in ((found.elements, top), (found.boundary, top - 1)):
                    if k in by_dimension:
                        self.same_simplices(rows, by_dimension[k], k, expected_mesh)
                        self.same_references(rows, by_dimension[k])
                    else:
                        self.assertEqual(rows, [])
                # Conversion back.
                self.run_camber("convert", "written.mfem", "-o", "back.mesh")
                self.run_camber("convert", "back.mesh", "-o", "again.mfem")
                self.assertEqual(self.path("again.mfem").read_bytes(), self.path("written.mfem").read_bytes())
                back = gmf.read(self.path("back.mesh"))
                np.testing.assert_array_equal(back.points[self.by_dimension(back)[top].nodes],
                                              expected_mesh.points[by_dimension[top].nodes])
                info = json.loads(self.run_camber("info", "written.mfem", "--json").stdout)
                self.assertEqual((info["dimension"], info["degree"]), (dimension, degree))

    @needs("gmsh")
    @needs("meshio")
    def test_su2_files_of_gmsh_equal_their_msh_files(self):
        """Compares .su2 and .msh files of Gmsh for the same mesh: simplex coordinates, and facets by marker names."""
        import meshio
        groups = {2: 'Rectangle(1) = {0, 0, 0, 1, 2}; Physical Curve("wall") = {1, 3}; Physical Curve("far") = {2, 4}; '
                     'Physical Surface("air") = {1};',
                  3: 'Box(1) = {0, 0, 0, 1, 2, 1}; Physical Surface("wall") = {1, 3, 5}; Physical Surface("far") = {2, 4, 6}; '
                     'Physical Volume("air") = {1};'}
        names = {2: ("Edges", "line", "Triangles", "triangle"), 3: ("Triangles", "triangle", "Tetrahedra", "tetra")}

        def places(points, rows):
            return {tuple(sorted(map(tuple, np.round(points[row], 9) + 0.0))) for row in rows}
        for dimension, geometry in groups.items():
            self.path("in.geo").write_text('SetFactory("OpenCASCADE");\nMesh.CharacteristicLengthMax = 0.4;\n' + geometry + "\n")
            for ending in ("su2", "msh"):
                subprocess.run(["gmsh", "-" + str(dimension), "in.geo", "-o", "out." + ending], cwd=self.folder.path, check=True,
                               capture_output=True)
            self.run_camber("convert", "out.su2", "-o", "read.mesh")
            found, expected = gmf.read(self.path("read.mesh")), meshio.read(self.path("out.msh"))
            self.assertEqual(found.dim, dimension)
            facets, facet_type, elements, element_type = names[dimension]
            points = expected.points[:, :dimension]
            self.assertEqual(places(found.points, found.cells[elements].nodes),
                             places(points, expected.cells_dict[element_type]))
            for reference, name in ((1, "wall"), (2, "far")):
                rows = expected.cells_dict[facet_type]
                rows = rows[expected.cell_data_dict["gmsh:physical"][facet_type] == expected.field_data[name][0]]
                chosen = found.cells[facets].nodes[found.cells[facets].refs == reference]
                self.assertGreater(len(chosen), 0)
                self.assertEqual(places(found.points, chosen), places(points, rows))
            self.assertEqual(self.run_camber("info", "out.su2").stderr, "")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
