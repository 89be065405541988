"""Files of Gmsh: its meshes are read, and written meshes are read by Gmsh and meshio, node by node.

    python3 tests/pipelines/test_msh.py build/bin/camber [unittest arguments]
"""
import json
import subprocess
import sys
import unittest
from collections import Counter

import numpy as np

from program import Folder
from readers import needs

import gmf
import msh_text

FORMATS = ("msh", "msh-ascii", "msh2", "msh2-ascii")
SQUARE = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
1 6 "inlet"
1 7 "heated"
2 8 "all"
$EndPhysicalNames
$Entities
0 2 1 0
1 0 0 0 1 0 0 {groups} 0
2 1 0 0 1 1 0 {others} 0
1 0 0 0 1 1 0 1 8 2 1 2
$EndEntities
$Nodes
1 5 1 5
2 1 0 5
1
2
3
4
5
0 0 0
1 0 0
1 1 0
0 1 0
0.5 0.5 0
$EndNodes
$Elements
{edges}
2 1 2 4
11 1 2 5
12 2 3 5
13 3 4 5
14 4 1 5
$EndElements
"""
BOX = """
SetFactory("Built-in");
Point(1) = {0, 0, 0, 0.6}; Point(2) = {1, 0, 0, 0.6}; Point(3) = {1, 1, 0, 0.6}; Point(4) = {0, 1, 0, 0.6};
Point(5) = {0.5, 0.5, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Circle(3) = {3, 5, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Extrude {0, 0, 1} { Surface{1}; }
Physical Volume("the solid", 7) = {1};
Physical Surface("bottom", 3) = {1}; Physical Surface("other walls", 9) = {13, 17, 21, 25, 26};
Physical Curve("rim", 5) = {1, 3}; Physical Point("a corner", 2) = {1};
"""


class Msh(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return self.folder.path / name

    def gmsh(self, *arguments):
        done = subprocess.run(["gmsh", "-nopopup", "-v", "2", *map(str, arguments)], cwd=self.folder.path,
                              capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertNotIn("Error", done.stdout + done.stderr)

    def camber(self, *arguments):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def box(self, order, *options):
        """Generates a curved box with Gmsh, as text of version 4.1."""
        self.path("box.geo").write_text(BOX)
        self.gmsh("-3", "box.geo", "-order", order, "-format", "msh41", "-o", "box.msh", *options)
        return msh_text.read(self.path("box.msh"))

    def by_gmsh(self, name):
        """Reads the file with Gmsh and returns the mesh that Gmsh writes as text."""
        self.gmsh(name, "-save", "-format", "msh41", "-o", "by_gmsh.msh")
        return msh_text.read(self.path("by_gmsh.msh"))

    def same(self, read, expected):
        self.assertEqual(read.cells(), expected.cells())
        self.assertEqual(read.names, expected.names)

    def square(self, groups, others="0", edges="2 5 1 14\n1 1 1 1\n1 1 2"):
        """Writes a square with its lower edge in `groups` and, if listed, its right edge in `others`."""
        self.path("square.msh").write_text(SQUARE.format(groups=groups, others=others, edges=edges))

    def edges_by_group(self, name):
        """Number of edges by the names or numbers of their groups."""
        read = msh_text.read(self.path(name))
        return Counter(tuple(read.names.get((1, p), p) for p in e[3]) for e in read.elements if e[1] in (1, 8))

    def test_unlisted_boundary_edges_are_in_no_named_group(self):
        self.square("1 6")
        for verb in ("curve", "remesh"):
            self.camber(verb, "square.msh", "-o", "out.msh")
            groups = self.edges_by_group("out.msh")
            self.assertEqual(groups["heated",], 0)
            self.assertEqual(set(groups), {("inlet",), (8,)})

    def test_edges_in_several_groups_stay_in_all_groups(self):
        for groups, others, expected in (("2 6 7", "0", {("inlet", "heated")}),
                                       ("2 6 7", "1 6", {("inlet", "heated"), ("inlet",)}),
                                       ("2 6 7", "1 7", {("inlet", "heated"), ("heated",)}),
                                       ("2 7 9", "1 6", {("heated", "group_9"), ("inlet",)})):
            self.square(groups, others, "3 6 1 14\n1 1 1 1\n1 1 2\n1 2 1 1\n2 2 3")
            for verb in (("convert", "--format", "msh-ascii"), ("curve",), ("remesh", "--metric", "0.2"),
                         ("adapt", "--field", "tanh(5*(x-0.3))*y", "--complexity", "300", "--cycles", "2"),
                         ("adapt", "--field", "tanh(5*(x-0.3))*y", "--complexity", "300", "--cycles", "1", "--quiet")):
                self.camber(verb[0], "square.msh", "-o", "out.msh", *verb[1:])
                with self.subTest(groups=groups, others=others, verb=verb):
                    found = {g for g in self.edges_by_group("out.msh") if isinstance(g and g[0], str)}
                    self.assertEqual(found, expected)

    def test_adapt_preserves_group_names_and_notes_lost_ones(self):
        self.square("2 6 7")
        adapt = ("adapt", "square.msh", "--field", "tanh(5*(x-0.3))*y", "--complexity", "300", "--folder", "cycles")
        first = self.camber(*adapt, "--cycles", "1", "-o", "out.msh")
        self.assertNotIn("names of references", first.stderr)
        names = msh_text.read(self.path("out.msh")).names
        self.assertEqual(names, {(1, 6): "inlet", (1, 7): "heated", (2, 8): "all"})
        second = self.camber(*adapt, "--cycles", "2", "--from", "1", "-o", "again.msh", "--quiet")
        self.assertEqual(second.stderr, "")
        self.assertEqual(msh_text.read(self.path("again.msh")).names, names)
        self.assertIn(("inlet", "heated"), self.edges_by_group("again.msh"))
        lost = self.camber(*adapt[:-2], "--cycles", "1", "-o", "out.vtu")
        self.assertIn("VTU has no place for 4 names of references", lost.stderr)

    @needs("gmsh")
    def test_meshes_of_gmsh_are_converted_and_read_by_gmsh_unchanged(self):
        for order in (1, 2):
            expected = self.box(order)
            self.assertEqual(set(kind for _, kind, *_ in expected.elements), {15, 1, 2, 4} if order == 1 else {15, 8, 9, 11})
            for version in ("msh22", "msh41"):
                for kind in ([], ["-bin"]):
                    self.gmsh("box.msh", "-save", "-format", version, *kind, "-o", "in.msh")
                    for name in FORMATS:
                        self.camber("convert", "in.msh", "--format", name, "-o", "out.msh")
                        with self.subTest(order=order, version=version, kind=kind, name=name):
                            if name.endswith("ascii"):
                                self.same(msh_text.read(self.path("out.msh")), expected)
                            self.same(self.by_gmsh("out.msh"), expected)
                            self.camber("convert", "out.msh", "--format", name, "-o", "again.msh")
                            self.assertEqual(self.path("again.msh").read_bytes(), self.path("out.msh").read_bytes())

    @needs("gmsh")
    def test_convert_preserves_the_order_of_vertices_and_elements(self):
        for order in (1, 2):
            expected = self.box(order)
            self.camber("convert", "box.msh", "--format", "msh-ascii", "-o", "out.msh")
            read = msh_text.read(self.path("out.msh"))
            mids = {n for _, kind, _, _, nodes in expected.elements for n in nodes[msh_text.DIMENSION[kind] + 1:]}
            corners = [n for n in sorted(expected.nodes) if n not in mids]
            self.assertEqual([read.nodes[i + 1] for i in range(len(corners))], [expected.nodes[n] for n in corners])
            self.assertEqual(len(read.nodes), len(expected.nodes))
            ordered = [[e[1:4] for e in sorted(m.elements) if e[1] in (4, 11)] for m in (read, expected)]
            self.assertEqual(*ordered)

    @needs("gmsh")
    def test_parametric_coordinates_of_nodes_are_preserved(self):
        expected = self.box(1, "-setnumber", "Mesh.SaveParametric", "1")
        places = {msh_text.rounded(expected.nodes[n]): place for n, place in expected.places.items()}
        self.assertTrue(any(len(place[2]) == 2 for place in places.values()))
        for kind in ([], ["-bin"]):
            self.gmsh("-3", "box.geo", "-setnumber", "Mesh.SaveParametric", "1", "-format", "msh41", *kind, "-o", "in.msh")
            self.camber("convert", "in.msh", "--format", "msh-ascii", "-o", "out.msh")
            self.same_places(places, msh_text.read(self.path("out.msh")))
            self.gmsh("-3", "box.geo", "-setnumber", "Mesh.SaveParametric", "1", "-format", "msh22", *kind, "-o", "in.msh")
            self.camber("convert", "in.msh", "--format", "msh-ascii", "-o", "out.msh")
            self.same_places(places, msh_text.read(self.path("out.msh")))

    def same_places(self, places, read):
        for n, (dimension, entity, parameters) in read.places.items():
            expected = places[msh_text.rounded(read.nodes[n])]
            self.assertEqual((dimension, entity), expected[:2])
            np.testing.assert_allclose(parameters, expected[2], atol=1e-12)

    @needs("gmsh")
    def test_partitions_of_a_gmsh_mesh_are_joined(self):
        for order in (1, 2):
            expected = self.box(order)
            for version, topology in (("msh41", 1), ("msh41", 0), ("msh22", 0)):
                for kind in ([], ["-bin"]):
                    self.gmsh("box.msh", "-part", 3, "-setnumber", "Mesh.PartitionCreateTopology", topology, "-save",
                              "-format", version, *kind, "-o", "parts.msh")
                    done = self.camber("convert", "parts.msh", "--format", "msh-ascii", "-o", "out.msh")
                    self.assertIn("the mesh is partitioned: the partitions were joined", done.stderr)
                    read = msh_text.read(self.path("out.msh"))
                    with self.subTest(order=order, version=version, topology=topology, kind=kind):
                        self.assertEqual(read.cells(), expected.cells())

    @needs("gmsh")
    def test_msh_output_has_the_version_and_encoding_of_msh_input(self):
        self.box(1)
        for name, begins in (("msh", b"4.1 1"), ("msh-ascii", b"4.1 0"), ("msh2", b"2.2 1"), ("msh2-ascii", b"2.2 0")):
            self.camber("convert", "box.msh", "--format", name, "-o", "in.msh")
            for verb in ("curve", "convert", "remesh"):
                self.camber(verb, "in.msh", "-o", "out.msh")
                self.assertEqual(self.path("out.msh").read_bytes().splitlines()[1][:5], begins, verb)
            self.camber("curve", "in.msh", "-o", "out.msh", "--format", "msh2-ascii")
            self.assertEqual(self.path("out.msh").read_bytes().splitlines()[1][:5], b"2.2 0")
        self.camber("convert", "in.msh", "-o", "in.meshb")
        self.camber("curve", "in.meshb", "-o", "out.msh")
        self.assertEqual(self.path("out.msh").read_bytes().splitlines()[1][:5], b"4.1 1")

    @needs("gmsh")
    def test_ridges_added_by_a_run_are_in_no_group(self):
        self.path("box.geo").write_text(BOX.replace('Physical Curve("rim", 5) = {1, 3};', ""))
        self.gmsh("-3", "box.geo", "-format", "msh41", "-o", "in.msh")
        self.camber("remesh", "in.msh", "-o", "out.msh", "--format", "msh-ascii")
        read = msh_text.read(self.path("out.msh"))
        curves = [e for e in read.elements if e[1] == 1]
        self.assertGreater(len(curves), 0)
        self.assertEqual({e[3] for e in curves}, {()})
        self.assertEqual({e[3] for e in read.elements if e[1] == 4}, {(7,)})

    @needs("gmsh")
    def test_reports_contain_tags_and_group_names_of_the_file(self):
        expected = self.box(1)
        checked = json.loads(self.folder.camber("check", "box.msh", "--json", "--worst", "3").stdout)
        self.assertIn({"dimension": 2, "reference": 3, "name": "bottom"}, checked["groups"])
        elements = {e[0]: e for e in expected.elements if e[1] == 4}
        for entry in checked["worst"]:
            self.assertEqual(entry["name"], "the solid")
            self.assertEqual(entry["tag"], sorted(elements)[entry["element"] - 1])
        printed = self.camber("check", "box.msh").stdout
        self.assertIn("3 bottom: ", printed)
        self.assertIn("with the file's tags beside them", printed)
        self.assertIn(f"element {checked['worst'][0]['element']} (tag {checked['worst'][0]['tag']})", printed)
        self.assertIn("3 bottom, 9 other walls", self.camber("geometry", "box.msh").stdout)
        self.assertRegex(self.camber("info", "box.msh").stdout, r"triangles_by_reference +3 bottom: \d+, 9 other walls: ")

    @needs("gmsh")
    def test_msh2_notes_triangles_in_several_groups(self):
        self.path("box.geo").write_text(BOX + 'Physical Surface("again", 4) = {1};\n')
        for version in ("msh22", "msh41"):
            for kind in ([], ["-bin"]):
                self.gmsh("-3", "box.geo", "-format", version, *kind, "-o", "in.msh")
                done = self.camber("convert", "in.msh", "--format", "msh2-ascii", "-o", "out.msh")
                self.assertRegex(done.stderr, 'MSH 2.2 has one group for a simplex: [0-9]+ triangles of "bottom" are '
                                              'left out of "again"')
                read = msh_text.read(self.path("out.msh"))
                self.assertEqual({e[3] for e in read.elements if e[1] == 2}, {(3,), (9,)})
                self.camber("curve", "out.msh", "-o", "curved.msh")  # no triangle is listed twice

    @needs("gmsh")
    def test_unsupported_elements_are_rejected_with_their_count(self):
        self.path("q.geo").write_text("Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Line(1) = {1, 2}; Transfinite Curve {1} = 4;"
                                      "Extrude {0, 1, 0} { Curve{1}; Layers{2}; Recombine; }\n")
        for version in ("msh22", "msh41"):
            for kind in ([], ["-bin"]):
                self.gmsh("-2", "q.geo", "-format", version, *kind, "-o", "q.msh")
                done = self.folder.camber("check", "q.msh")
                self.assertEqual(done.returncode, 3)
                self.assertIn("q.msh: holds 6 quadrangles, which Camber does not support", done.stderr)
                self.assertIn('{"quadrangles":6}', self.camber("info", "q.msh").stdout)

    @needs("gmsh")
    def test_info_prints_gmsh_commands_that_convert_degree_3_to_degree_2(self):
        self.path("box.geo").write_text(BOX)
        self.gmsh("-3", "box.geo", "-order", "3", "-o", "p3.msh")
        split = json.loads(self.camber("info", "p3.msh", "--json").stdout)["split"]
        self.path("order.geo").write_text(split.split("lines ")[1].replace("FILE", "p2") + "\n")
        self.gmsh("order.geo", "-")
        self.assertEqual(json.loads(self.camber("info", "p2.msh", "--json").stdout)["degree"], 2)

    @needs("gmsh")
    def test_msh_versions_1_and_4_0_are_read_and_3_is_rejected(self):
        self.box(1)
        counts = lambda name: {k: v for k, v in json.loads(self.camber("info", name, "--json").stdout).items()  # noqa: E731
                               if k in ("vertices", "tetrahedra_by_reference", "triangles_by_reference")}
        for version in ("msh1", "msh40"):
            self.gmsh("box.msh", "-save", "-format", version, "-o", "old.msh")
            self.assertEqual(counts("old.msh"), counts("box.msh"))
        self.gmsh("box.msh", "-save", "-format", "msh3", "-o", "old.msh")
        done = self.folder.camber("info", "old.msh")
        self.assertEqual(done.returncode, 3)
        self.assertIn("is not 1, 2 or 4 (gmsh FILE -save -format msh41 -o NEW.msh)", done.stderr)

    @needs("gmsh")
    def test_gmsh_reads_the_curved_mesh_with_all_nodes_and_groups(self):
        straight = self.box(1)
        for ending in ("msh", "meshb"):
            config = {"input": {"mesh": "box.msh"}, "stages": ["elevate", "curve", "validate", "relax", "commit"],
                      "output": {"mesh": "curved." + ending}}
            self.path("run.json").write_text(json.dumps(config))
            self.camber("run", "run.json")
        read = self.by_gmsh("curved.msh")
        count = {kind: sum(e[1] == kind for e in straight.elements) for kind in (2, 4)}
        self.assertEqual(sum(e[1] == 11 for e in read.elements), count[4])
        self.assertEqual(sum(e[1] == 9 for e in read.elements), count[2])
        self.assertEqual(read.names, straight.names)
        # The nodes equal those of the GMF file in the order of local nodes.
        mesh = gmf.read(self.path("curved.meshb"))
        tetrahedra = mesh.cells["TetrahedraP2"].nodes
        ours = msh_text.Msh(nodes=dict(enumerate(map(tuple, mesh.points))),
                            elements=[(0, 11, 1, (7,), tuple(row[[0, 1, 2, 3, 4, 5, 6, 7, 9, 8]])) for row in tetrahedra])
        self.assertEqual(read.cells({11}), ours.cells())

    def made_here(self, shape, stages=("elevate",)):
        self.path("run.json").write_text(json.dumps(
            {"input": {"generate": shape}, "stages": list(stages), "output": {"mesh": "m.meshb"}}))
        self.camber("run", "run.json")
        return gmf.read(self.path("m.meshb"))

    @needs("meshio")
    def test_meshio_reads_all_msh_formats(self):
        import meshio
        mesh = self.made_here({"box": {"low": [0, 0, 0], "high": [1, 2, 3], "cells": [2, 2, 2]}})
        for name in FORMATS:
            self.camber("convert", "m.meshb", "--format", name, "-o", "out.msh")
            read = meshio.read(self.path("out.msh"), file_format="gmsh")
            nodes = np.concatenate([c.data for c in read.cells if c.type == "tetra10"])
            expected = np.array(mesh.cells["TetrahedraP2"].nodes)
            by_place = [sorted(points.reshape(len(expected), -1).tolist())
                        for points in (read.points[nodes], mesh.points[expected])]
            self.assertEqual(*by_place)
            blocks = [i for i, c in enumerate(read.cells) if c.type == "triangle6"]
            physical = np.concatenate([read.cell_data["gmsh:physical"][i] for i in blocks])
            self.assertEqual(sorted(physical), sorted(mesh.cells["TrianglesP2"].refs))

    @needs("meshio")
    def test_meshio_reads_node_fields(self):
        import meshio
        self.made_here({"box": {"low": [0, 0, 0], "high": [1, 1, 1], "cells": [1, 2, 1]}}, stages=())
        mesh = gmf.read(self.path("m.meshb"))
        rows = "".join(f"{x} {x + 1} {y}\n" for x, y, z in mesh.points)
        self.path("m.sol").write_text(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(mesh.points)}\n1 2\n{rows}End\n")
        for name in FORMATS:
            self.camber("convert", "m.meshb", "--metric", "m.sol", "--format", name, "-o", "out.msh")
            read = meshio.read(self.path("out.msh"), file_format="gmsh")
            (values,) = [values for key, values in read.point_data.items() if not key.startswith("gmsh:")]
            np.testing.assert_array_equal(values[:, 1], np.array(mesh.points)[:, 0] + 1)

    @needs("gmsh")
    def test_groups_with_reversed_entities_are_read(self):
        geometry = ("Point(1) = {0,0,0,0.5}; Point(2) = {1,0,0,0.5}; Point(3) = {1,1,0,0.5}; Point(4) = {0,1,0,0.5};"
                    "Line(1) = {1,2}; Line(2) = {2,3}; Line(3) = {3,4}; Line(4) = {4,1}; Curve Loop(1) = {1,2,3,4};"
                    "Plane Surface(1) = {1}; Physical Surface(\"plate\", 2) = {1};"
                    "Physical Curve(\"rim\", 4) = {1,2,3,4}; Physical Curve(5) = {-1};")
        geometry = geometry.replace(";", ";\n")
        self.path("r.geo").write_text(geometry)
        for version in ("msh22", "msh41"):
            self.gmsh("r.geo", "-2", "-format", version, "-o", "r.msh")
            info = json.loads(self.camber("info", "--json", "r.msh").stdout)
            self.assertEqual(info["edges_by_reference"], {"4": 6, "6": 2}, version)  # reference 6: in groups 4 and 5
            self.camber("curve", "r.msh", "-o", "c.msh")
        # If no simplex is in a group, references are entities without group names.
        self.path("s.geo").write_text(geometry[:geometry.index("Physical")])
        self.gmsh("s.geo", "-2", "-format", "msh41", "-o", "s.msh")
        text = self.path("s.msh").read_text().replace("$EndMeshFormat\n", "$EndMeshFormat\n$PhysicalNames\n1\n1 4 \"rim\"\n$EndPhysicalNames\n")
        self.path("s.msh").write_text(text)
        info = json.loads(self.camber("info", "--json", "s.msh").stdout)
        self.assertNotIn("groups", info)
        self.assertIn("1 names of physical groups were left out: no simplex is in them", info["notices"])

    @needs("meshio")
    def test_cell_fields_are_written_to_msh_and_read_back(self):
        import meshio
        self.path("run.json").write_text(json.dumps({"input": {"generate": {"shell": {"inner_size": 0.8, "outer_size": 2.5}}},
                                                     "output": {"mesh": "m.vtu"}}))
        self.camber("run", "run.json")
        expected = {field["name"] for field in json.loads(self.camber("info", "--json", "m.vtu").stdout)["fields"] if field["at"] == "cells"}
        self.assertIn("verdict", expected)
        for name in FORMATS:
            self.camber("convert", "m.vtu", "--format", name, "-o", "out.msh")
            if name in ("msh", "msh-ascii"):  # for version 2.2 meshio confuses the numbers of columns and cells
                read = meshio.read(self.path("out.msh"), file_format="gmsh")
                for field in expected:
                    for cells, values in zip(read.cells, read.cell_data[field]):
                        self.assertEqual(len(cells.data), len(values))
                        if field == "verdict":
                            self.assertEqual(set(values), {0 if cells.type == "tetra10" else -1})
            self.camber("convert", "out.msh", "-o", "back.vtu")
            again = json.loads(self.camber("info", "--json", "back.vtu").stdout)
            self.assertEqual({field["name"] for field in again["fields"] if field["at"] == "cells"}, expected)

    def test_a_2d_mesh_is_written_to_msh_and_read_back(self):
        self.made_here({"annulus": {"inner_layer": {"count": 3, "first_height": 0.05, "growth": 1.3}}},
                       stages=("elevate", "curve", "validate", "relax", "commit"))
        for name in FORMATS:
            self.camber("convert", "m.meshb", "--format", name, "-o", "out.msh")
            info = json.loads(self.camber("info", "--json", "out.msh").stdout)
            expected = json.loads(self.camber("info", "--json", "m.meshb").stdout)
            self.assertEqual(info["written_in_dimension"], 3)
            for key in ("dimension", "degree", "vertices", "triangles_by_reference", "edges_by_reference", "mid_nodes"):
                self.assertEqual(info[key], expected[key], key)
            self.camber("check", "out.msh")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
