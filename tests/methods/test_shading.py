import numpy as np
import pytest

from shapemorph.core.image import Chart
from shapemorph.core.mesh import coloured_mesh, textured_mesh
from shapemorph.methods.calibrating import calibrate, continue_outside
from shapemorph.methods.shading import map_textures, texel_density


def _square(side=20.0, cells=6):
    """A flat square in cells, corner vertices in reading order, faces up."""
    line = np.linspace(0, side, cells + 1)
    x, y = np.meshgrid(line, line)
    number = np.arange(x.size).reshape(x.shape)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), faces


def _chart(vertices, faces, px_per_mm):
    """Seen from above: x right, y up."""
    px = vertices[:, :2] * [px_per_mm, -px_per_mm] + [4, 4 + px_per_mm * vertices[:, 1].max()]
    everything = np.arange(len(vertices))
    return Chart(everything, faces, np.arange(len(faces)), px, px_per_mm)


def _textured(vertices, faces, uv, *textures, face_texture=None):
    which = np.zeros(len(faces), dtype=np.int64) if face_texture is None else face_texture
    return textured_mesh(vertices, faces, uv[faces], which, textures, name="square")


def _waves(height, width):
    """A smooth picture as a function of uv and its samples at texel centres."""

    def wave(u, v):
        return 0.5 + 0.3 * np.sin(9 * u + 2 * v) * np.cos(7 * v - 3 * u)

    rows, cols = np.mgrid[0:height, 0:width]
    return wave, wave((cols + 0.5) / width, 1 - (rows + 0.5) / height).astype(np.float32)


@pytest.mark.parametrize(("px_per_mm", "tolerance"), [(12.0, 2e-4), (3.0, 4e-3), (1.0, 3e-2)])
def test_grey_comes_from_where_the_uv_coordinates_say(px_per_mm, tolerance):
    """Texel centres at (i + 0.5) / W, origin at the lower left; coarse pixels average."""
    vertices, faces = _square()
    wave, texture = _waves(90, 120)
    uv = 0.1 + 0.8 * vertices[:, :2] / 20
    mesh = _textured(vertices, faces, uv, texture)
    image, _ = calibrate(mesh, _chart(vertices, faces, px_per_mm))
    rows, cols = np.nonzero(image.image.mask)
    u = 0.1 + 0.8 * (cols - 4) / px_per_mm / 20
    v = 0.1 + 0.8 * (20 - (rows - 4) / px_per_mm) / 20
    inner = (np.abs(u - 0.5) < 0.35) & (np.abs(v - 0.5) < 0.35)
    error = image.image.grey[rows, cols] - wave(u, v)
    assert np.abs(error[inner]).max() < tolerance  # the mean over a pixel differs by curvature
    assert abs(error[inner].mean()) < tolerance / 10


def test_pixels_much_coarser_than_texels_average_them():
    vertices, faces = _square()
    checks = (np.indices((512, 512)).sum(axis=0) % 2).astype(np.float32)
    mesh = _textured(vertices, faces, 0.02 + 0.96 * vertices[:, :2] / 20, checks)
    for px_per_mm in (9.0, 4.0, 1.5):  # 2.7, 6 and 16 texels per pixel
        image, _ = calibrate(mesh, _chart(vertices, faces, px_per_mm))
        inner = image.image.grey[8:-8, 8:-8]
        assert np.abs(inner - 0.5).max() < 0.06, px_per_mm


def test_neighbours_in_space_do_not_mix_with_neighbours_in_the_atlas():
    """Two islands apart in the texture, each in its own grey, black in between."""
    vertices, faces = _square(cells=8)
    left = vertices[faces].mean(axis=1)[:, 0] < 10
    texture = np.zeros((256, 256), np.float32)
    texture[:, 10:110] = 0.25
    texture[:, 150:250] = 0.75
    wedge = vertices[faces][..., :2] / 20
    wedge[..., 0] = np.where(left[:, None], 0.1 + wedge[..., 0] * 0.5, 0.35 + wedge[..., 0] * 0.5)
    none = np.zeros(len(faces), dtype=np.int64)
    mesh = textured_mesh(vertices, faces, wedge, none, (texture,), name="square")
    for px_per_mm in (7.0, 2.0):
        image, _ = calibrate(mesh, _chart(vertices, faces, px_per_mm))
        rows, cols = np.nonzero(image.image.mask)
        x = (cols - 4) / px_per_mm
        grey = image.image.grey[rows, cols]
        sure = np.abs(x - 10) > 0.5 / px_per_mm  # pixels across the seam see both
        np.testing.assert_allclose(grey[sure], np.where(x < 10, 0.25, 0.75)[sure], atol=2e-3)
        assert grey.min() > 0.24


def test_every_face_reads_its_own_texture():
    vertices, faces = _square(cells=4)
    which = (vertices[faces].mean(axis=1)[:, 0] > 10).astype(np.int64)
    flat = [np.full((16, 24), grey, np.float32) for grey in (0.3, 0.6)]
    mesh = _textured(vertices, faces, vertices[:, :2] / 20, *flat, face_texture=which)
    image, _ = calibrate(mesh, _chart(vertices, faces, 5.0))
    assert np.abs(image.image.grey[10:90, 10:50] - 0.3).max() < 1e-6
    assert np.abs(image.image.grey[10:90, 60:90] - 0.6).max() < 1e-6


def test_uv_beyond_the_picture_repeat_it():
    vertices, faces = _square()
    rows, cols = np.mgrid[0:64, 0:96]
    texture = (0.5 + 0.3 * np.sin(2 * np.pi * (cols + 0.5) / 96)).astype(np.float32)
    texture += (0.1 * np.cos(4 * np.pi * (rows + 0.5) / 64)).astype(np.float32)
    uv = vertices[:, :2] / 20 * [2.5, 1.5] - [0.7, 0.4]
    mesh = _textured(vertices, faces, uv, texture)
    image, _ = calibrate(mesh, _chart(vertices, faces, 14.0))
    rows, cols = np.nonzero(image.image.mask)
    u = (cols - 4) / 14 / 20 * 2.5 - 0.7
    v = (20 - (rows - 4) / 14) / 20 * 1.5 - 0.4
    expected = 0.5 + 0.3 * np.sin(2 * np.pi * u) + 0.1 * np.cos(4 * np.pi * v)
    np.testing.assert_allclose(image.image.grey[rows, cols], expected, atol=2e-3)


def test_the_border_texel_goes_on_beyond_the_last_centre():
    vertices, faces = _square()
    texture = np.full((8, 8), 0.5, np.float32)
    texture[:, 0], texture[:, -1] = 0.2, 0.8
    mesh = _textured(vertices, faces, vertices[:, :2] / 20, texture)
    image, _ = calibrate(mesh, _chart(vertices, faces, 10.0))
    middle = image.image.grey[104]
    np.testing.assert_allclose(middle[6:14], 0.2, atol=1e-6)
    np.testing.assert_allclose(middle[194:202], 0.8, atol=1e-6)


def test_grey_of_corners_is_interpolated_linearly():
    vertices, faces = _square()
    plane = 0.2 + 0.015 * vertices[:, 0] + 0.01 * vertices[:, 1]
    mesh = coloured_mesh(vertices, faces, plane[faces], name="square")
    image, _ = calibrate(mesh, _chart(vertices, faces, 4.5))
    rows, cols = np.nonzero(image.image.mask)
    expected = 0.2 + 0.015 * (cols - 4) / 4.5 + 0.01 * (20 - (rows - 4) / 4.5)
    inner = (np.minimum(rows, cols) > 6) & (np.maximum(rows, cols) < 90)
    np.testing.assert_allclose(image.image.grey[rows, cols][inner], expected[inner], atol=1e-6)


def test_texture_density_is_measured():
    vertices, faces = _square()
    mesh = _textured(vertices, faces, vertices[:, :2] / 20, np.zeros((300, 400), np.float32))
    chart = _chart(vertices, faces, 5.0)
    under = map_textures(mesh, chart)
    np.testing.assert_allclose(texel_density(under.gradients), np.sqrt(3.0 * 4.0))


def test_the_number_of_threads_changes_nothing():
    import numba

    vertices, faces = _square()
    texture = np.random.default_rng(0).random((200, 300), dtype=np.float32)
    mesh = _textured(vertices, faces, vertices[:, :2] / 20, texture)
    chart = _chart(vertices, faces, 6.0)
    many, _ = calibrate(mesh, chart)
    before = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        one, _ = calibrate(mesh, chart)
    finally:
        numba.set_num_threads(before)
    np.testing.assert_array_equal(one.image.grey, many.image.grey)


def test_the_picture_goes_on_a_little_beyond_its_mask():
    mask = np.zeros((30, 40), dtype=bool)
    mask[8:22, 10:30] = True
    grey = np.where(mask, np.linspace(0.2, 0.8, 40), 7.0).astype(np.float32)
    filled = continue_outside(grey, mask)
    np.testing.assert_array_equal(filled[mask], grey[mask])
    assert np.abs(filled[15, 6:10] - grey[15, 10]).max() < 0.05
    assert filled.max() < 0.81
