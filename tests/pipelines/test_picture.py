"""`camber picture`, and verdicts for viewers by `camber check --vtu`.

    python3 tests/pipelines/test_picture.py build/bin/camber [unittest arguments]
"""
import itertools
import json
import re
import struct
import sys
import unittest
import xml.etree.ElementTree as xml
import zlib

import numpy as np

from program import Folder
from readers import needs

SVG = "{http://www.w3.org/2000/svg}"


def pixels(path):
    """Decodes a PNG independently: rows of red, green, blue (and alpha)."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        length, name = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        assert zlib.crc32(name + body) == struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0]
        if name == b"IHDR":
            width, height, depth, kind = struct.unpack(">IIBB", body[:10])
            assert depth == 8
        packed += body if name == b"IDAT" else b""
        at += length + 12
    size = {2: 3, 6: 4}[kind]
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, width * size + 1).astype(int)
    above = np.zeros(width * size, int)
    rows = []
    for filter_, *row in raw.tolist():
        out = [0] * (width * size)
        for i, x in enumerate(row):
            a, b = out[i - size] if i >= size else 0, above[i]
            c = above[i - size] if i >= size else 0
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            out[i] = (x + [0, a, b, (a + b) // 2, nearest][filter_]) % 256
        rows.append(out)
        above = out
    return np.array(rows).reshape(height, width, size)


def two_boxes(path, cells=3):
    """Two cubes side by side along x with elements `left` (1), `right` (2), facets `inlet` (1), `outlet` (4), `wall`
    (5) and between the cubes `interface` (6)."""
    n = cells
    corner = lambda i, j, k: 1 + i + (2 * n + 1) * (j + (n + 1) * k)
    points = [(i / n, j / n, k / n) for k in range(n + 1) for j in range(n + 1) for i in range(2 * n + 1)]
    tetrahedra, faces = [], {}
    for i, j, k in itertools.product(range(2 * n), range(n), range(n)):
        for order in itertools.permutations(range(3)):
            at = [i, j, k]
            vertices = [corner(*at)]
            for axis in order:
                at[axis] += 1
                vertices.append(corner(*at))
            if order not in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                vertices[2:] = vertices[:1:-1]
            tetrahedra.append((vertices, 1 if i < n else 2))
    for vertices, reference in tetrahedra:
        for face in itertools.combinations(vertices, 3):
            faces.setdefault(tuple(sorted(face)), []).append(reference)
    triangles = []
    for face, beside in faces.items():
        x = {points[v - 1][0] for v in face}
        if len(beside) == 1:
            triangles.append((face, 1 if x == {0} else 4 if x == {2} else 5))
        elif beside[0] != beside[1]:
            triangles.append((face, 6))
    names = ((2, 1, "inlet"), (2, 4, "outlet"), (2, 5, "wall"), (2, 6, "interface"), (3, 1, "left"), (3, 2, "right"))
    rows = [f"{kind} 2 {reference} {reference} {' '.join(map(str, vertices))}"
            for kind, cells_of in ((2, triangles), (4, tetrahedra)) for vertices, reference in cells_of]
    path.write_text("\n".join(
        ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names))]
        + [f'{d} {r} "{name}"' for d, r, name in names] + ["$EndPhysicalNames", "$Nodes", str(len(points))]
        + [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(points, 1)] + ["$EndNodes", "$Elements", str(len(rows))]
        + [f"{i} {row}" for i, row in enumerate(rows, 1)] + ["$EndElements"]) + "\n")


class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        cls.addClassCleanup(cls.folder.cleanup)
        two_boxes(cls.folder.path / "two.msh")
        for verb in (("generate", "annulus", "-o", "ring.mesh", "--elements", "200"),
                     ("curve", "ring.mesh", "-o", "ring-p2.mesh", "--objective", "shape"),
                     ("generate", "shell", "-o", "shell.meshb", "--elements", "2000"),
                     ("curve", "shell.meshb", "-o", "shell-p2.meshb", "--objective", "shape")):
            done = cls.folder.camber(*verb)
            assert done.returncode == 0, done.stderr

    def camber(self, *arguments):
        done = self.folder.camber(*arguments)
        self.assertEqual(done.returncode, 0, (arguments, done.stderr))
        return done

    def image(self, *arguments):
        self.camber("picture", *arguments, "-o", "p.png")
        return pixels(self.folder.path / "p.png")

    def fails(self, code, text, *arguments):
        done = self.folder.camber("picture", *arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(text, done.stderr)

    def test_an_annulus_covers_the_pixels_of_its_area(self):
        """The area between circles of radius 1 and 5 is π (5² − 1²)."""
        image = self.image("ring-p2.mesh", "--size", "300x300", "--colour", "none", "--background", "transparent")
        opaque = image[:, :, 3] / 255
        scale = (opaque.max(axis=0) > 0.5).sum() / 10  # the annulus has diameter 10
        self.assertAlmostEqual(opaque.sum() / scale ** 2, np.pi * 24, delta=0.01 * np.pi * 24)

    def test_size_and_background_options_apply(self):
        image = self.image("shell-p2.meshb", "--size", "160x120", "--background", "dark", "--threads", "1")
        self.assertEqual(image.shape, (120, 160, 3))
        self.assertLess(image[0, 0].sum(), 120)

    def test_the_image_does_not_depend_on_the_number_of_threads(self):
        self.image("shell-p2.meshb", "--size", "160x120", "--background", "dark", "--threads", "1")
        one = (self.folder.path / "p.png").read_bytes()
        self.image("shell-p2.meshb", "--size", "160x120", "--background", "dark", "--threads", "3")
        self.assertEqual(one, (self.folder.path / "p.png").read_bytes())

    def test_a_cut_shows_the_inner_elements(self):
        whole = self.image("shell-p2.meshb", "--size", "200x200", "--colour", "reference", "--view", "right")
        cut = self.image("shell-p2.meshb", "--size", "200x200", "--colour", "reference", "--cut", "x=0", "--view", "right")
        self.assertGreater(np.abs(whole - cut).max(axis=2).astype(bool).mean(), 0.2)
        other = self.image("shell-p2.meshb", "--size", "200x200", "--colour", "reference", "--cut", "x>0", "--view", "left")
        self.assertGreater(np.abs(cut - other).max(axis=2).astype(bool).mean(), 0.2)

    def test_an_svg_has_a_curve_for_each_curved_edge_and_a_legend(self):
        self.camber("picture", "ring-p2.mesh", "-o", "r.svg", "--worst", "3")
        root = xml.parse(self.folder.path / "r.svg").getroot()
        paths = [path.get("d") for path in root.iter(SVG + "path")]
        self.assertGreater(sum("q" in d for d in paths), 20)
        texts = [text.text for text in root.iter(SVG + "text")]
        self.assertIn("scaled Jacobian", texts)
        self.assertLessEqual({"0", "0.5", "1"}, set(texts))
        self.assertEqual(len(list(root.iter(SVG + "circle"))), 3)
        self.camber("picture", "ring.mesh", "-o", "s.svg")
        straight = xml.parse(self.folder.path / "s.svg").getroot()
        self.assertFalse([d for d in (p.get("d") for p in straight.iter(SVG + "path")) if "q" in d])
        self.assertIn("quality", [text.text for text in straight.iter(SVG + "text")])

    def test_metrics_and_solutions_colour_the_picture(self):
        vertices = json.loads(self.camber("info", "ring.mesh", "--json").stdout)["vertices"]
        for name, kind, row in (("m.sol", 3, "{} 0 400"), ("u.sol", 1, "{}")):
            rows = "".join(row.format(1 + i / 10) + "\n" for i in range(vertices))
            (self.folder.path / name).write_text(
                f"MeshVersionFormatted 2\nDimension 2\nSolAtVertices {vertices}\n1 {kind}\n{rows}End\n")
        self.camber("picture", "ring.mesh", "-o", "m.svg", "--metric", "m.sol")
        root = xml.parse(self.folder.path / "m.svg").getroot()
        texts = [text.text for text in root.iter(SVG + "text")]
        self.assertIn("anisotropy", texts)
        self.assertIn("20", texts)  # anisotropy of sizes 1 and 1/20 at the first vertex
        self.camber("picture", "ring.mesh", "-o", "u.svg", "--solution", "u.sol", "--no-edges")
        text = (self.folder.path / "u.svg").read_text()
        self.assertIn("field_1", text)

    def legend(self, *arguments):
        self.camber("picture", "two.msh", "-o", "l.svg", "--colour", "reference", *arguments)
        return [text.text for text in xml.parse(self.folder.path / "l.svg").getroot().iter(SVG + "text")]

    def test_legends_list_the_names_of_visible_groups(self):
        self.assertEqual(self.legend(), ["group", "inlet (1)", "outlet (4)", "wall (5)"])
        self.assertEqual(self.legend("--cut", "x=0.4"), ["group", "inlet, left (1)", "wall (5)"])
        self.assertEqual(self.legend("--hide", "wall"), ["group", "inlet (1)", "outlet (4)"])
        self.assertEqual(self.legend("--show", "interface"), ["group", "interface (6)"])
        self.assertEqual(self.legend("--show", "right"), ["group", "right (2)", "outlet (4)", "wall (5)"])

    def area(self, *arguments):
        """Share of covered pixels in the front view."""
        image = self.image("two.msh", "--size", "220x120", "--colour", "none", "--background", "transparent", "--view", "front",
                           "--zoom", "1,0.5,0.5,1", *arguments)
        return (image[:, :, 3] > 127).mean()

    def test_hidden_groups_are_not_drawn(self):
        both = self.area()
        self.assertAlmostEqual(self.area("--hide", "left"), both / 2, delta=0.02 * both)
        self.assertAlmostEqual(self.area("--show", "right"), both / 2, delta=0.02 * both)
        self.assertAlmostEqual(self.area("--show", "2"), both / 2, delta=0.02 * both)
        self.assertEqual(self.area("--show", "left,right"), both)
        self.assertEqual(self.area("--show", "left,right", "--hide", "right"), self.area("--show", "left"))

    def test_hidden_facets_reveal_the_facets_behind_them(self):
        colour = lambda *arguments: self.image("two.msh", "--size", "100x100", "--colour", "reference", "--view", "left",
                                               "--background", "transparent", *arguments)[50, 20:60, :3].mean(axis=0)
        front, behind = colour(), colour("--hide", "inlet")
        self.assertGreater(np.abs(front - behind).max(), 20)
        np.testing.assert_allclose(behind, colour("--show", "outlet"), atol=12)
        self.assertGreater(np.abs(behind - colour("--hide", "1,outlet")).max(), 20)  # 1 means the facets, not the elements

    def test_groups_of_2d_meshes_and_surfaces_are_hidden_by_reference(self):
        (self.folder.path / "plane.mesh").write_text(
            "MeshVersionFormatted 2\nDimension 2\nVertices 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\nTriangles 2\n1 2 3 7\n1 3 4 8\nEnd\n")
        (self.folder.path / "surface.mesh").write_text(
            "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n1 1 0 0\n0 1 0 1\nTriangles 2\n1 2 3 7\n1 3 4 8\nEnd\n")
        for name in ("plane.mesh", "surface.mesh"):
            for choice in (("--show", "8"), ("--hide", "7")):
                self.camber("picture", name, "-o", "l.svg", "--colour", "reference", *choice)
                texts = [text.text for text in xml.parse(self.folder.path / "l.svg").getroot().iter(SVG + "text")]
                self.assertEqual(texts, ["reference", "8"])
            self.fails(2, 'no group and no reference "9" (there are: 7, 8)', name, "-o", "r.png", "--hide", "9")

    def test_an_unknown_group_is_rejected_with_a_list_of_groups(self):
        self.fails(2, 'camber: --hide: the mesh has no group and no reference "lid" (there are: of boundary facets inlet (1), '
                      'outlet (4), wall (5), interface (6); of elements left (1), right (2))', "two.msh", "-o", "r.png",
                   "--hide", "wall,lid")
        self.fails(3, "there is nothing to draw", "two.msh", "-o", "r.png", "--hide", "left,right")

    def test_hidden_worst_elements_are_noted_with_a_cut_that_shows_one(self):
        done = self.camber("picture", "shell-p2.meshb", "-o", "w.svg", "--worst", "6")
        circles = lambda: len(list(xml.parse(self.folder.path / "w.svg").getroot().iter(SVG + "circle")))
        note = re.search(r"note: (\d) of the 6 worst elements cannot be seen and (?:is|are) not marked\. A cut next to an "
                         r"element shows it: --cut (\S+) for number (\d)", done.stderr)
        self.assertEqual(circles(), 6 - int(note[1]))
        self.camber("picture", "shell-p2.meshb", "-o", "w.svg", "--worst", "6", "--cut", note[2])
        texts = [text.text for text in xml.parse(self.folder.path / "w.svg").getroot().iter(SVG + "text")]
        self.assertIn(note[3], texts)
        done = self.camber("picture", "ring-p2.mesh", "-o", "w.svg", "--worst", "4", "--cut", "x=100")
        self.assertEqual((circles(), done.stderr), (4, ""))
        done = self.camber("picture", "two.msh", "-o", "w.svg", "--worst", "768", "--hide", "left")
        self.assertTrue(0 < circles() < 100, circles())

    def test_nothing_is_drawn_outside_the_zoom_window(self):
        image = self.image("ring-p2.mesh", "--size", "300x200", "--zoom", "3,0,0.4")
        is_paper = (image == 255).all(axis=2)
        self.assertTrue(is_paper[:8].all() and is_paper[-8:].all() and is_paper[:, :14].all())
        self.assertFalse(is_paper[20:180, 30:180].any())

    def test_wrong_picture_options_are_rejected(self):
        self.fails(2, "name a .png or a .svg file", "ring.mesh", "-o", "r.jpg")
        self.fails(2, '--size: "12" is not understood', "ring.mesh", "-o", "r.png", "--size", "12")
        self.fails(2, '--cut: "x" is not understood', "ring.mesh", "-o", "r.png", "--cut", "x")
        self.fails(2, '--view: "up" is not understood', "ring.mesh", "-o", "r.png", "--view", "up")
        self.fails(2, "give --metric FILE", "ring.mesh", "-o", "r.png", "--colour", "anisotropy")
        self.fails(3, "there is nothing to draw", "ring.mesh", "-o", "r.png", "--cut", "x=-100")
        self.assertFalse((self.folder.path / "r.png").exists())


class Verdicts(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    @needs("vtk")
    def test_vtk_reads_verdicts_and_scaled_jacobians_of_check(self):
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy
        self.folder.camber("generate", "annulus", "-o", "ring.mesh", "--elements", "100")
        self.folder.camber("curve", "ring.mesh", "-o", "ring-p2.mesh", "--objective", "shape")
        done = self.folder.camber("check", "ring-p2.mesh", "--vtu", "v.vtu", "--elements")
        self.assertEqual(done.returncode, 0, done.stderr)
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(self.folder.path / "v.vtu"))
        reader.Update()
        data = reader.GetOutput().GetCellData()
        columns = {name: vtk_to_numpy(data.GetArray(name)) for name in ("verdict", "scaled_jacobian", "quality")}
        titles, *lines = [line.split(",") for line in done.stdout.splitlines()]
        n = len(lines)
        reported = np.array([float(line[titles.index("min_scaled_jacobian")]) for line in lines])
        np.testing.assert_allclose(columns["scaled_jacobian"][:n], reported, rtol=1e-5)
        self.assertTrue((columns["verdict"][:n] == 0).all() and (columns["verdict"][n:] == -1).all())
        self.assertTrue((columns["quality"][:n] > 0).all() and np.isnan(columns["quality"][n:]).all())

    def test_check_writes_the_quality_of_a_straight_surface_to_vtu(self):
        (self.folder.path / "s.mesh").write_text(
            "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
            "Triangles 2\n1 2 3 1\n1 2 4 2\nEnd\n")
        self.folder.camber("check", "s.mesh", "--vtu", "s.vtu")
        self.assertIn("quality", (self.folder.path / "s.vtu").read_bytes().decode("latin-1"))
        self.assertEqual(self.folder.camber("check", "s.mesh", "--vtu", "s.mesh").returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=1)
