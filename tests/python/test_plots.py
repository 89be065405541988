"""Plots: pages in notebooks, matplotlib in 2D, VTK in 3D."""
import os
import unittest

import numpy as np

import shared
from shared import camber, shell, square
from test_exchange import need


class Plots(unittest.TestCase):
    def test_a_notebook_displays_the_page_of_a_mesh(self):
        text = camber.curve(square())._repr_html_()
        self.assertTrue(text.startswith("<iframe srcdoc="), text[:200])

    def test_a_2d_plot_draws_curved_edges(self):
        need(self, "matplotlib")
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot

        mesh = camber.curve(camber.generate("annulus", set={"inner_size": 0.5, "outer_size": 0.5})).mesh
        curves = camber.plots.edge_curves(mesh, 8)
        self.assertEqual(curves.shape, (len(mesh.edges), 9, 2))
        np.testing.assert_allclose(curves[:, 4], mesh.mid_nodes, atol=1e-15)
        np.testing.assert_array_equal(curves[:, 0], mesh.vertices[mesh.edges[:, 0]])
        figure, ax = pyplot.subplots(figsize=(3, 3))
        self.assertIs(mesh.plot(values=mesh.points[:, 0], ax=ax), ax)
        figure.canvas.draw()
        pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3]
        self.assertGreater((pixels.min(axis=2) < 250).mean(), 0.2)

    def test_curved_faces_are_subdivided(self):
        mesh = camber.curve(shell()).mesh
        faces = len(mesh.cells["triangle6"])
        points, triangles, values = camber.plots.subdivided(mesh, 4, np.ones(len(mesh.points)))
        self.assertEqual((len(points), len(triangles)), (15 * faces, 16 * faces))
        np.testing.assert_allclose(values, 1)
        radii = np.linalg.norm(points, axis=1)
        self.assertLess(np.minimum(np.abs(radii - 1), np.abs(radii - 2)).max(), 0.03)

    def test_faces_and_edges_are_converted_to_vtk(self):
        need(self, "vtkmodules")
        mesh = camber.curve(shell()).mesh
        faces = len(mesh.cells["triangle6"])
        data = camber.plots.surface(mesh, mesh.points[:, 2], 3)
        self.assertEqual(data.GetNumberOfPolys(), 9 * faces)
        self.assertEqual(data.GetPointData().GetScalars().GetNumberOfTuples(), data.GetNumberOfPoints())
        self.assertEqual(camber.plots.edge_lines(mesh).GetNumberOfLines(), 3 * faces // 2)

    def test_a_3d_plot_draws_an_image_or_reports_the_missing_x_server(self):
        need(self, "vtkmodules")
        if "DISPLAY" not in os.environ:
            self.assertRaisesRegex(camber.UsageError, "X server", shell().plot)
            return
        picture = camber.curve(shell()).mesh.plot(size=(200, 160))
        self.assertEqual(picture.shape, (160, 200, 3))
        self.assertGreater((picture.min(axis=2) < 250).mean(), 0.2)


if __name__ == "__main__":
    shared.main()
