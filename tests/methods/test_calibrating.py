import numpy as np

from shapemorph.core.image import Chart
from shapemorph.core.mesh import textured_mesh
from shapemorph.methods.calibrating import calibrate


def test_a_tip_thinner_than_a_pixel_is_no_part_of_the_picture():
    """Its pixel centres are covered, but every sample of the finer texture falls beside it."""
    px = np.array([[5.0, 5], [5, 25], [25, 25], [25, 5], [40, 15.02], [40, 14.98], [25, 15]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [6, 4, 5]])
    vertices = np.column_stack([px[:, 0], -px[:, 1], np.zeros(len(px))])
    uv = np.stack([(px[:, 0] + 0.5) / 50, 1 - (px[:, 1] + 0.5) / 50], axis=-1)
    rng = np.random.default_rng(0)
    texture = rng.uniform(0.2, 0.8, (200, 200)).astype(np.float32)  # four texels a pixel
    mesh = textured_mesh(
        vertices, faces, uv[faces], np.zeros(3, dtype=np.int64), (texture,), name="t"
    )
    chart = Chart(np.arange(len(px)), faces, np.arange(3), px, 1.0)
    image, _ = calibrate(mesh, chart)
    assert np.isfinite(image.image.grey).all()
    np.testing.assert_array_equal(image.triangle >= 0, image.image.mask)
    assert image.image.mask[15, 10]
    assert not image.image.mask[15, 30:39].any()
    assert np.isnan(image.barycentric[15, 35]).all()
