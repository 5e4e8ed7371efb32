import numpy as np

from shapemorph.core.image import Chart
from shapemorph.core.mesh import coloured_mesh
from shapemorph.methods.picture_scale import mm_per_px


def test_scale_carries_picture_steps_to_steps_on_the_surface():
    rng = np.random.default_rng(8)
    vertices, px = rng.normal(size=(3, 3)), rng.normal(size=(3, 2))
    mesh = coloured_mesh(vertices, np.array([[0, 1, 2], [2, 1, 0]]), np.zeros((2, 3)), name="m")
    chart = Chart(np.arange(3), np.array([[0, 1, 2]]), np.array([0]), px, 1.0)
    scale = mm_per_px(mesh, chart, np.array([0, 1, -1]))
    np.testing.assert_allclose(scale[0] @ (px[1] - px[0]), vertices[1] - vertices[0], atol=1e-12)
    np.testing.assert_allclose(scale[0] @ (px[2] - px[0]), vertices[2] - vertices[0], atol=1e-12)
    assert np.isnan(scale[1:]).all()  # a face the chart leaves out, and no face at all
