"""Required entities are preserved bit for bit: vertices, and nodes of required edges, triangles and tetrahedra.

    python3 tests/pipelines/test_required.py build/bin/camber [unittest arguments]
"""
import sys
import unittest

from program import CONFIGS, Folder, report_of

import gmf  # noqa: E402  (program puts the oracle on the path)
import numpy as np
from sample_meshes import ascii_file, cube, elevate

ENDS = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]


def indices(*numbers):
    """Rows of a Required block, numbered from 1."""
    return np.asarray(numbers, np.int64).reshape(-1, 1), np.empty((len(numbers), 0))


def nodes_of(mesh, name):
    """{sorted ends of an edge: its node} over the P2 cells of that name."""
    cells = mesh.cells[name]
    corners = 4 if name.startswith("Tetra") else 3
    ends = ENDS if corners == 4 else ENDS[:3]
    return {tuple(sorted((int(row[a]), int(row[b])))): tuple(mesh.points[row[corners + i]])
            for row in cells.nodes for i, (a, b) in enumerate(ends)}


class Required(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def run_camber(self, *arguments, codes=(0,)):
        done = self.folder.camber(*arguments)
        self.assertIn(done.returncode, codes, done.stdout + done.stderr)
        return done

    def shell(self, **lists):
        """Writes the straight mesh of configs/spheres.json with these Required blocks; returns it and its elevated
        nodes."""
        self.run_camber("run", CONFIGS / "spheres.json", "--set", "stages=[]", "--set", "output/mesh=plain.mesh")
        mesh = gmf.read(self.folder.path / "plain.mesh")
        for name, numbers in lists.items():
            mesh.lists[name] = indices(*numbers)
        (self.folder.path / "in.mesh").write_bytes(ascii_file(mesh))
        self.run_camber("convert", "in.mesh", "-o", "straight.meshb", "--elevate")
        return mesh, nodes_of(gmf.read(self.folder.path / "straight.meshb"), "TetrahedraP2")

    def curved(self, *arguments, codes=(0,)):
        self.run_camber("curve", "in.mesh", "-o", "out.meshb", "--report", "r.json", *arguments, codes=codes)
        return gmf.read(self.folder.path / "out.meshb"), report_of(self.folder.path / "r.json")

    def repaired_block(self, *arguments, code, **lists):
        """Repairs a cube with the middle of a side beyond the inner vertex, which repair would move."""
        straight = cube(2)
        side = next(i for i, p in enumerate(straight.points) if tuple(p) == (0, 0.5, 0.5))
        straight.points[side][0] = 0.6
        mesh = elevate(straight)
        for name, numbers in lists.items():
            mesh.lists[name] = indices(*numbers)
        (self.folder.path / "in.mesh").write_bytes(ascii_file(mesh))
        self.run_camber("repair", "in.mesh", "-o", "out.meshb", "--report", "r.json", *arguments, codes=(code,))
        out = gmf.read(self.folder.path / "out.meshb")
        moved = (out.points[:len(straight.points)] != straight.points).any(axis=1)
        return np.flatnonzero(moved), report_of(self.folder.path / "r.json")

    # Guards against ignored required vertices.
    def test_repair_preserves_required_vertices(self):
        (inner,), report = self.repaired_block(code=0)
        self.assertEqual(report["relax"]["moved_vertices"], 1)
        moved, report = self.repaired_block(code=1, RequiredVertices=[inner + 1])
        self.assertEqual((len(moved), report["relax"]["moved_vertices"]), (0, 0))
        remaining = report["remaining_elements"]
        self.assertEqual([entry["element"] for entry in remaining], report["invalid_elements"])
        self.assertTrue(any("required and cannot move" in entry["reason"] for entry in remaining), remaining)

    def test_option_vertices_keep_preserves_all_vertices(self):
        moved, report = self.repaired_block("--set", "stages/relax/vertices=keep", code=1)
        self.assertEqual((len(moved), report["relax"]["moved_vertices"]), (0, 0))

    # Guards against ignored required edges, facets and elements.
    def test_nodes_of_required_triangles_and_tetrahedra_stay_straight(self):
        tetrahedra, triangles = range(1, 200, 7), range(1, 60, 3)
        mesh, straight = self.shell(RequiredTetrahedra=tetrahedra, RequiredTriangles=triangles)
        required_edges = {tuple(sorted((int(row[a]), int(row[b])))) for row in mesh.cells["Tetrahedra"].nodes[[t - 1 for t in tetrahedra]]
                for a, b in ENDS}
        on_triangles = {tuple(sorted((int(row[a]), int(row[b])))) for row in mesh.cells["Triangles"].nodes[[t - 1 for t in triangles]]
                        for a, b in ENDS[:3]}
        required_edges |= on_triangles
        for stages in ((), ("--set", 'stages=["elevate", "reinsert"]')):
            out, _ = self.curved(*stages, codes=(0, 1))
            nodes = nodes_of(out, "TetrahedraP2")
            self.assertEqual({e: nodes[e] for e in required_edges}, {e: straight[e] for e in required_edges}, stages)
            self.assertTrue(any(nodes[e] != straight[e] for e in nodes if e not in required_edges))
        out, _ = self.curved("--set", "features/required_boundary=geometry", codes=(0, 1))
        nodes = nodes_of(out, "TetrahedraP2")
        facets = nodes_of(out, "TrianglesP2")
        self.assertTrue(all(nodes[e] == straight[e] for e in required_edges if e not in facets))
        self.assertTrue(all(nodes[e] != straight[e] for e in on_triangles))

    def test_curve_preserves_required_nodes_of_a_curved_input(self):
        """Required edges keep their node of the file even where `curve` moves others onto the geometry."""
        mesh = elevate(cube(2))
        row = mesh.cells["TrianglesP2"].nodes[0]
        mesh.points[row[3]] += 0.01
        mesh.lists["RequiredTriangles"] = indices(1)
        (self.folder.path / "in.mesh").write_bytes(ascii_file(mesh))
        out, _ = self.curved("--set", 'stages=["curve", "validate", "relax", "commit"]')
        edge = tuple(sorted((int(row[0]), int(row[1]))))
        self.assertEqual(nodes_of(out, "TrianglesP2")[edge], tuple(mesh.points[row[3]]))

    def test_repair_preserves_a_required_kinked_node_and_lists_the_element(self):
        """The kinked node of a required triangle is preserved; its element is listed with that reason."""
        mesh = elevate(cube(2))
        triangles = mesh.cells["TrianglesP2"].nodes
        row = next(i for i, t in enumerate(triangles) if all(mesh.points[t[:3]][:, 2] == 0))
        a, b, node = triangles[row][0], triangles[row][1], triangles[row][3]
        mesh.points[node] = 0.85 * mesh.points[a] + 0.15 * mesh.points[b]
        mesh.lists["RequiredTriangles"] = indices(row + 1)
        (self.folder.path / "in.mesh").write_bytes(ascii_file(mesh))
        self.run_camber("repair", "in.mesh", "-o", "out.meshb", "--report", "r.json", "--boundary-tolerance", 1, codes=(1,))
        out = gmf.read(self.folder.path / "out.meshb")
        edge = tuple(sorted((int(a), int(b))))
        self.assertEqual(nodes_of(out, "TrianglesP2")[edge], tuple(mesh.points[node]))
        reasons = [entry["reason"] for entry in report_of(self.folder.path / "r.json")["remaining_elements"]]
        self.assertGreater(len(reasons), 0)
        self.assertTrue(all("edges are required and cannot move" in reason for reason in reasons), reasons)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
