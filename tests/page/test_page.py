"""Tests of the text of `camber report` pages and of their display in a browser.  Usage: test_page.py CAMBER
[Class.test]

Tests that need Chromium are skipped where it is not installed; with CAMBER_NO_SKIP=1 they fail."""

import base64
import json
import math
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import browser

CAMBER = str(pathlib.Path(sys.argv.pop(1)).resolve())


def camber(*arguments, code=0, **options):
    done = subprocess.run([CAMBER, *map(str, arguments)], capture_output=True, text=True, **options)
    if done.returncode != code:
        raise AssertionError(f"camber {' '.join(map(str, arguments))}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def array(page, name):
    text = re.search(f'id="camber-{name}">([^<]*)<', page).group(1)
    return zlib.decompress(base64.b64decode(text))


def words(data):
    """Decodes little-endian words of 32 bits from their planes of bytes."""
    n = len(data) // 4
    return [data[i] | data[n + i] << 8 | data[2 * n + i] << 16 | data[3 * n + i] << 24 for i in range(n)]


def ids(data):
    next_id, out = 0, []
    for word in words(data):
        out.append(next_id - word)
        next_id += word == 0
    return out


def values_of(page):
    return json.loads(re.search(r'id="camber-page">([^<]*)<', page).group(1))


class Folder(unittest.TestCase):
    """Meshes shared by all tests."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        camber("generate", "shell", "-o", cls.folder / "shell.meshb", "--elements", 800)
        camber("curve", "shell.meshb", "-o", "shell-p2.meshb", "--report", "report.json", cwd=cls.folder)
        camber("generate", "annulus", "-o", cls.folder / "ring.mesh", "--elements", 60)
        camber("curve", cls.folder / "ring.mesh", "-o", cls.folder / "ring-p2.mesh")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def two_materials(self, name):
        """Writes a box with element reference 1 below x = 1/2 and 2 above, facet reference 1 at x = 0 and 5
        elsewhere."""
        camber("generate", "box", "-o", self.folder / "box.mesh", "--set", "cells=[4,4,4]")
        sections, points, out = iter((self.folder / "box.mesh").read_text().splitlines()), [], []
        for line in sections:
            out.append(line)
            if line.strip() not in ("Vertices", "Tetrahedra", "Triangles"):
                continue
            count = next(sections)
            out.append(count)
            for _ in range(int(count)):
                row = next(sections).split()
                if line.strip() == "Vertices":
                    points.append([float(x) for x in row[:3]])
                    out.append(" ".join(row))
                    continue
                x = [points[int(v) - 1][0] for v in row[:-1]]
                middle = sum(x) / len(x)
                reference = (1 if middle < 0.5 else 2) if line.strip() == "Tetrahedra" else 1 if middle == 0 else 5
                out.append(" ".join([*row[:-1], str(reference)]))
        (self.folder / name).write_text("\n".join(out) + "\n")

    def page(self, name, *arguments):
        out = self.folder / f"{self.id()}.html"
        camber("report", self.folder / name, "-o", out, *arguments)
        return out


class Text(Folder):
    def test_the_page_contains_the_table_of_check(self):
        page = self.page("shell-p2.meshb").read_text()
        table = camber("check", self.folder / "shell-p2.meshb", "--no-histogram").stdout
        numbers = re.search(r"<h2>Numbers</h2>\n<pre[^>]*>(.*?)</pre>", page, re.S).group(1)
        for line in table.splitlines()[2:]:
            self.assertIn(line.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;"), numbers)
        self.assertIn(table.splitlines()[0], page)
        self.assertRegex(page, r"<pre[^>]*>camber report \S*shell-p2.meshb -o \S*.html</pre>")

    def test_the_page_does_not_depend_on_the_number_of_threads(self):
        a, b = (self.folder / name for name in ("a.html", "b.html"))
        texts = []
        for out, threads in ((a, 1), (b, 3)):
            camber("report", "shell-p2.meshb", "-o", "page.html", "--threads", threads, cwd=self.folder)
            texts.append((self.folder / "page.html").read_text().replace(f"--threads {threads}", ""))
        self.assertEqual(*texts)

    def test_the_page_loads_nothing_from_the_network(self):
        page = self.page("shell-p2.meshb").read_text()
        head = re.sub(r"<script.*?</script>", "", page, flags=re.S)
        self.assertNotRegex(head, r"src=|href=\"(?!data:,)|@import|url\(")
        self.assertIn("The above copyright notice and this permission notice shall be included", page)
        self.assertLess(len(page), 700_000 + 60 * 40_000)

    def test_the_page_stores_all_boundary_faces_and_their_elements(self):
        for name, corners in (("shell.meshb", 3), ("shell-p2.meshb", 6)):
            with self.subTest(name):
                page = self.page(name).read_text()
                values = values_of(page)
                info = json.loads(camber("info", self.folder / name, "--json").stdout)
                counts = values["counts"]
                self.assertEqual(counts["faces"], info["triangles"])
                self.assertEqual(counts["faces"] + 2 * counts["inner"], 4 * info["tetrahedra"])
                self.assertEqual(counts["worst"], 40)
                nodes = ids(array(page, "faces"))
                self.assertEqual(len(nodes), corners * (counts["faces"] + counts["inner"] + counts["worst"]))
                self.assertEqual(max(nodes) + 1, counts["nodes"])
                owners = ids(array(page, "owners"))
                self.assertEqual(len(owners), counts["faces"] + 2 * counts["inner"] + counts["worst"])
                self.assertEqual(set(owners), set(range(info["tetrahedra"])))

    def test_stored_boundary_nodes_lie_on_their_sphere(self):
        page = self.page("shell-p2.meshb").read_text()
        values = values_of(page)
        n = values["counts"]["nodes"]
        floats = struct.unpack(f"<{3 * n}f", struct.pack(f"<{3 * n}I", *words(array(page, "nodes"))))
        stored_nodes = list(zip(floats[:n], floats[n : 2 * n], floats[2 * n :]))
        faces = ids(array(page, "faces"))
        for at in range(0, 6 * values["counts"]["faces"], 6):
            corners = [[x + o for x, o in zip(stored_nodes[node], values["origin"])] for node in faces[at : at + 3]]
            self.assertLess(min(abs(math.hypot(*c) / r - 1) for c in corners for r in (1, 5)), 1e-5)
            if math.hypot(*corners[0]) < 3:  # the mesh is too coarse there: its nodes have the same distance to the sphere
                continue
            for i, node in enumerate(faces[at + 3 : at + 6]):
                a, b = corners[i], corners[(i + 1) % 3]
                place = [(p + q) / 2 + d for p, q, d in zip(a, b, stored_nodes[node])]
                self.assertLess(abs(math.hypot(*place) / 5 - 1), 0.003)

    def test_vertex_values_are_averaged_at_mid_nodes(self):
        vertices = json.loads(camber("info", self.folder / "shell-p2.meshb", "--json").stdout)["vertices"]
        rows = "".join(f"{i * i % 17}\n" for i in range(vertices))
        (self.folder / "u.sol").write_text(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices {vertices}\n1 1\n{rows}End\n")
        page = self.page("shell-p2.meshb", "--solution", self.folder / "u.sol").read_text()
        data = words(array(page, "field-1"))
        values = struct.unpack(f"<{len(data)}f", struct.pack(f"<{len(data)}I", *data))
        faces = ids(array(page, "faces"))
        for at in range(0, 6 * values_of(page)["counts"]["faces"], 6):
            corners = [values[node] for node in faces[at : at + 3]]
            for i, node in enumerate(faces[at + 3 : at + 6]):
                self.assertEqual(values[node], (corners[i] + corners[(i + 1) % 3]) / 2)

    def test_inner_faces_are_limited_and_noted(self):
        counts = values_of(self.page("shell-p2.meshb", "--inner-faces", 500).read_text())
        self.assertLessEqual(counts["counts"]["inner"], 500)
        self.assertGreater(counts["counts"]["inner"], 100)
        self.assertTrue(all(0 < len(places) < 255 for places in counts["cut"]["places"]), counts["cut"])
        self.assertIn("positions along x, y and z", counts["cut"]["note"])

    def test_the_page_of_a_report_contains_results_before_and_after_correction(self):
        page = self.page("report.json").read_text()
        for text in ("before correction", "after correction", "largest distance to the geometry", "Length reduction"):
            self.assertIn(text, page)

    def test_the_page_of_remesh_compares_input_and_remeshed_mesh(self):
        camber("generate", "box", "-o", "box.mesh", "--set", "cells=[2,2,2]", cwd=self.folder)
        camber("remesh", "box.mesh", "-o", "finer.mesh", "--metric", 0.3, "--page", "finer.html", cwd=self.folder)
        page = (self.folder / "finer.html").read_text()
        for text in (">input</text>", ">remeshed</text>"):
            self.assertIn(text, page)

    def test_option_page_writes_the_page_of_a_run_and_of_check(self):
        shown = {"curvature", "length_reduction", "distance_to_geometry", "Anisotropy of the metric"}
        camber("curve", "shell.meshb", "-o", "again.meshb", "--page", "curve.html", cwd=self.folder)
        page = (self.folder / "curve.html").read_text()
        self.assertLessEqual(shown, {q["title"] for q in values_of(page)["quantities"]})
        self.assertIn("mean length reduction", page)
        camber("check", "shell-p2.meshb", "--page", "check.html", cwd=self.folder)
        camber("report", "shell-p2.meshb", "-o", "report.html", cwd=self.folder)
        texts = [(self.folder / name).read_text().split("<h2>Command")[0] for name in ("check.html", "report.html")]
        self.assertEqual(*texts)

    def test_distances_by_face_are_listed_largest_first(self):
        camber("curve", "shell.meshb", "-o", "d.meshb", "--report", "d.json", "--set", "output/distances=both", cwd=self.folder)
        distances = json.loads((self.folder / "d.json").read_text())["boundary"]["distances"]
        page = self.page("d.json").read_text()
        rows = re.findall(r"<tr><th>([^<]*)</th><td>([^<]*)</td>", page)
        self.assertEqual(len(rows), len(distances["entities"]))
        largest = max(distances["entities"], key=lambda e: max(e["to_geometry"]["largest"], e["to_boundary"]["largest"]))
        self.assertEqual(rows[0], (f"{largest['kind']} {largest['number']}", f"{largest['to_geometry']['largest']:.4g}"))
        self.assertNotIn("Distances by face", self.page("report.json").read_text())

    def test_a_limit_of_inner_faces_keeps_faces_between_groups(self):
        self.two_materials("two.mesh")
        counts = values_of(self.page("two.mesh", "--inner-faces", 60).read_text())
        self.assertLessEqual(counts["counts"]["inner"], 60)
        self.assertGreaterEqual(counts["counts"]["inner"], 32)  # faces between the materials

    def test_file_names_are_escaped_in_html(self):
        strange = self.folder / "a<b>&'c.meshb"
        strange.write_bytes((self.folder / "shell.meshb").read_bytes())
        page = self.page(strange.name).read_text()
        self.assertIn("<title>a&lt;b&gt;&amp;'c.meshb</title>", page)


class Errors(Folder):
    def fails(self, *arguments, code, says):
        done = camber("report", *arguments, code=code, cwd=self.folder)
        self.assertIn(says, done.stderr)

    def test_report_rejects_an_empty_mesh(self):
        (self.folder / "empty.mesh").write_text("MeshVersionFormatted 2\nDimension 3\nVertices 1\n0 0 0 0\nEnd\n")
        self.fails("empty.mesh", "-o", "e.html", code=3, says="has no elements and no faces")

    def test_report_rejects_an_output_that_is_not_html(self):
        self.fails("shell.meshb", "-o", "page.png", code=2, says=".html")

    def test_report_rejects_a_report_whose_mesh_is_missing(self):
        report = json.loads((self.folder / "report.json").read_text())
        report["config"]["output"]["mesh"] = "gone.meshb"
        (self.folder / "other.json").write_text(json.dumps(report))
        self.fails("other.json", "-o", "page.html", code=3, says="gone.meshb")
        self.fails("../nothing.json", "-o", "page.html", code=3, says="nothing.json")

    def test_report_rejects_json_that_is_no_report(self):
        (self.folder / "some.json").write_text("{}")
        self.fails("some.json", "-o", "page.html", code=3, says="report.json")


@unittest.skipUnless(browser.program() or os.environ.get("CAMBER_NO_SKIP"), "no Chromium")
class InBrowser(Folder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        super().tearDownClass()

    def open(self, name, *arguments):
        self.browser.trouble.clear()
        self.browser.open(self.page(name, *arguments))

    def tearDown(self):
        self.assertEqual(self.browser.trouble, [])

    def assert_round(self, counts):
        area, width, height = counts
        self.assertLess(abs(width - height), 0.01 * width)
        self.assertGreater(width, 400)
        self.assertLess(abs(area / (math.pi / 4 * width * height) - 1), 0.01, counts)

    def test_a_coarse_curved_sphere_is_drawn_round(self):
        self.open("shell-p2.meshb")
        self.assert_round(self.browser.silhouette())

    def test_a_straight_sphere_is_not_drawn_round(self):
        self.open("shell.meshb")
        area, width, height = self.browser.silhouette()
        self.assertLess(area / (math.pi / 4 * width * height), 0.995)

    def test_a_2d_annulus_covers_its_area(self):
        self.open("ring-p2.mesh")
        area, width, height = self.browser.silhouette()
        self.assertLess(abs(area / (math.pi / 4 * width * height) / (1 - 0.2**2) - 1), 0.01)

    def test_a_standalone_surface_is_drawn(self):
        camber("geometry", self.folder / "shell.meshb", "--surface", self.folder / "skin.vtu")
        self.open("skin.vtu")
        self.assertGreater(self.browser.silhouette()[0], 100_000)

    def test_a_cut_hides_about_half_of_the_mesh(self):
        self.open("shell-p2.meshb")
        self.browser.press("X")  # view along x: y points right, z up
        whole = self.browser.silhouette()
        self.browser.press("y")
        half = self.browser.silhouette()
        self.assertLess(half[1], 0.7 * whole[1])
        self.assertGreater(half[0], 0.4 * whole[0])
        self.browser.press("]")
        self.assertEqual(self.browser.evaluate("document.getElementById('place').value"), "128")
        self.browser.press("Escape")
        self.assertAlmostEqual(self.browser.silhouette()[0], whole[0], delta=2)

    def test_key_1_marks_the_worst_element(self):
        self.open("shell-p2.meshb")
        self.browser.press("1")
        self.assertEqual(self.browser.evaluate("document.getElementById('worst-0').getAttribute('aria-pressed')"), "true")
        self.assertFalse(self.browser.evaluate("document.getElementById('pin').hidden"))
        self.browser.press("Escape")
        self.assertTrue(self.browser.evaluate("document.getElementById('pin').hidden"))

    def test_keys_c_and_t_change_colour_and_theme(self):
        self.open("shell-p2.meshb")
        for _ in range(self.browser.evaluate("document.getElementById('colour').length")):
            self.browser.press("c")
        self.browser.press("t")
        self.assertEqual(self.browser.evaluate("document.documentElement.dataset.theme"), "dark")

    def test_group_switches_hide_elements_and_faces(self):
        self.two_materials("two.mesh")
        self.open("two.mesh")
        self.browser.press("Y")  # view along y: x points right
        whole = self.browser.silhouette()
        switch = lambda group: (self.browser.evaluate(f"document.getElementById('group-{group}').click()"), self.browser.settle())
        switch("elements-1")
        right = self.browser.silhouette()
        self.assertAlmostEqual(right[0] / whole[0], 0.5, delta=0.05)  # perspective view
        switch("elements-2")
        self.assertLess(self.browser.silhouette()[0], 0.01 * whole[0])
        self.browser.evaluate("document.getElementById('groupsAll').click()")
        self.browser.settle()
        self.assertAlmostEqual(self.browser.silhouette()[0], whole[0], delta=2)
        switch("faces-5")
        self.assertLess(self.browser.silhouette()[0], 0.05 * whole[0])  # the face at x = 0 is seen edge on
        self.browser.press("X")
        self.assertGreater(self.browser.silhouette()[0], 0.5 * whole[0])

    def test_a_mesh_of_one_group_has_no_group_list(self):
        self.open("ring-p2.mesh")
        self.assertTrue(self.browser.evaluate("document.getElementById('groups').hidden"))

    def test_numbers_are_not_cut_off(self):
        self.open("report.json")
        for element in self.browser.evaluate("[...document.querySelectorAll('pre, .tiles li')].map(p => [p.scrollWidth, p.clientWidth])"):
            self.assertLessEqual(*element)

    def test_buttons_of_views_and_cuts_have_different_shapes(self):
        self.open("shell-p2.meshb")
        shown = "[...document.querySelectorAll('#tools .axis, [id^=cut-]')].map(b => [b.textContent, getComputedStyle(b).borderRadius])"
        buttons = self.browser.evaluate(shown)
        self.assertEqual([text for text, _ in buttons], ["x", "y", "z", "Cut x", "Cut y", "Cut z"])
        self.assertEqual([radius for _, radius in buttons], ["50%"] * 3 + ["7px"] * 3)

    def test_without_webgl_the_page_shows_one_message_and_the_numbers(self):
        script = "HTMLCanvasElement.prototype.getContext = () => null"
        script = self.browser.call("Page.addScriptToEvaluateOnNewDocument", source=script)["identifier"]
        try:
            with self.assertRaisesRegex(RuntimeError, "This browser cannot draw the mesh: WebGL 2 is off"):
                self.open("shell-p2.meshb")
        finally:
            self.browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script)
        self.browser.trouble.clear()
        text = self.browser.evaluate("document.getElementById('stage').innerText").strip()
        self.assertEqual(text, "This browser cannot draw the mesh: WebGL 2 is off. The numbers are below.")
        self.assertIn("smallest scaled Jacobian", self.browser.evaluate("document.body.innerText"))
        self.assertFalse(self.browser.evaluate("document.getElementById('colour').checkVisibility()"))

    def test_the_page_text_contains_the_smallest_scaled_jacobian(self):
        self.open("shell-p2.meshb")
        text = self.browser.evaluate("document.body.innerText")
        least = re.search(r"smallest scaled Jacobian +([\d.]+)", camber("check", self.folder / "shell-p2.meshb").stdout)
        self.assertIn(least.group(1), text)


if __name__ == "__main__":
    unittest.main()
