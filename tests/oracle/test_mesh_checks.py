"""Self-tests of the conformity, survival and shape checks.  Run: python3 test_mesh_checks.py."""
import io
import tempfile
import unittest
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np

import check_p2
import conformity
import gmf
import sample_meshes as samples
import shapes


class Checks(unittest.TestCase):
    def setUp(self):
        self.linear = samples.cube(3)
        self.mesh = samples.elevate(self.linear)

    def problems(self, **options):
        return check_p2.check(self.mesh, self.linear, planes=True, **options)[1]

    def test_a_conforming_mesh_has_no_problems(self):
        self.assertEqual(self.problems(), [])

    def test_two_mid_nodes_on_one_edge_are_reported(self):
        self.mesh.points = np.vstack([self.mesh.points, self.mesh.points[-1]])
        self.mesh.point_refs = np.append(self.mesh.point_refs, 0)
        self.mesh.cells["TetrahedraP2"].nodes[0, 4] = len(self.mesh.points) - 1
        self.assertTrue(any("several mid nodes" in p for p in self.problems()))

    def test_shared_mid_nodes_corners_as_mid_nodes_and_orphans_are_reported(self):
        nodes = self.mesh.cells["TetrahedraP2"].nodes
        nodes[0, 4] = nodes[0, 5]
        self.assertTrue(any("mid nodes on several edges" in p for p in self.problems()))
        nodes[0, 4] = 0
        self.assertTrue(any("are corners" in p for p in self.problems()))
        self.mesh.points = np.vstack([self.mesh.points, [9, 9, 9]])
        self.assertTrue(any("belong to no element" in p for p in self.problems()))

    def test_a_hole_in_the_boundary_is_reported(self):
        triangles = self.mesh.cells["TrianglesP2"]
        triangles.nodes, triangles.refs = triangles.nodes[1:], triangles.refs[1:]
        found = check_p2.check(self.mesh)[1]
        self.assertTrue(any("not listed" in p for p in found))
        self.assertTrue(any("odd number" in p for p in found))

    def test_interfaces_are_allowed_between_references_only(self):
        tets, triangles = self.mesh.cells["TetrahedraP2"], self.mesh.cells["TrianglesP2"]
        triangles.nodes = np.vstack([triangles.nodes, tets.nodes[0][[0, 1, 3, 4, 8, 7]]])
        facets, count, _ = conformity.domain_facets(self.mesh)
        face = np.sort(tets.nodes[0][[0, 1, 3]])
        self.assertEqual(count[(facets == face).all(axis=1)], 2)
        triangles.refs = np.append(triangles.refs, 50)
        self.assertTrue(any("inside one reference" in p for p in check_p2.check(self.mesh)[1]))
        tets.refs[0] = 2
        self.assertEqual(check_p2.check(self.mesh)[1], [])

    def test_changed_vertices_references_and_required_lists_are_reported(self):
        self.mesh.points[5, 0] = np.nextafter(self.mesh.points[5, 0], 2)
        self.assertTrue(any("do not survive" in p for p in self.problems()))
        self.setUp()
        self.mesh.cells["TrianglesP2"].refs[3] += 1
        self.assertTrue(any("another reference" in p for p in self.problems()))
        self.setUp()
        self.linear.lists["RequiredVertices"] = (np.array([[1]]), np.empty((1, 0)))
        self.assertTrue(any("RequiredVertices differ" in p for p in self.problems()))

    def test_a_node_off_its_plane_by_one_bit_is_reported(self):
        mid = self.mesh.cells["TrianglesP2"].nodes[0, 3]
        axis = (self.mesh.cells["TrianglesP2"].refs[0] - 1) // 2
        self.mesh.points[mid, axis] += 1e-18 if self.mesh.points[mid, axis] == 0 else 2.0 ** -50
        self.assertTrue(any("to the bit" in p for p in self.problems()))

    def test_the_error_ratio_of_a_curved_circle_exceeds_30(self):
        angle = np.arange(6) * np.pi / 3
        rim = np.column_stack([np.cos(angle), np.sin(angle)])
        turn = [[i, (i + 1) % 6] for i in range(6)]
        disk = samples.elevate(samples.linear_mesh(np.vstack([rim, [0, 0]]),
                                                   [[a, b, 6] for a, b in turn], turn))
        samples.push_to_sphere(disk, 1, 1.0)
        figures, problems = shapes.sphere(disk, 1, 1.0, [0, 0, 0])
        self.assertEqual(problems, [])
        self.assertAlmostEqual(figures["straight"], 1 - np.sqrt(3) / 2)
        self.assertGreater(figures["ratio"], 30)
        self.assertEqual(check_p2.check(disk)[1], [])

    def test_the_exit_status_is_1_for_an_invalid_mesh(self):
        with tempfile.TemporaryDirectory() as folder, redirect_stdout(io.StringIO()):
            path = Path(folder, "cube.meshb")
            path.write_bytes(samples.binary_file(self.mesh, 2))
            self.assertEqual(check_p2.main([str(path), "--json"]), 0)
            self.mesh.points[-1] -= 10
            path.write_bytes(samples.binary_file(self.mesh, 2))
            self.assertEqual(check_p2.main([str(path)]), 1)


if __name__ == "__main__":
    unittest.main()
