import numpy as np
import pytest

from shapemorph.core.image import Chart, GreyImage
from shapemorph.core.matching import Warp
from shapemorph.core.mesh import textured_mesh
from shapemorph.methods.calibrating import calibrate
from shapemorph.methods.morphing import morph_image, morph_surface


def affine(matrix, offset, extent, spacing=16.0):
    """A spline warp that is exactly affine: its coefficients are the map of their places."""
    count = int(np.ceil(extent / spacing)) + 6
    origin = np.array([-2 * spacing, -2 * spacing])
    rows, cols = np.mgrid[0:count, 0:count]
    places = origin + spacing * np.stack([cols, rows], axis=-1)
    return Warp(places @ np.asarray(matrix).T + np.asarray(offset), origin, spacing)


def wave(x, y):
    return 0.5 + 0.2 * np.sin(0.21 * x + 0.05 * y) + 0.2 * np.cos(0.17 * y - 0.08 * x)


@pytest.fixture(scope="module")
def surface():
    """A flat plate of 12 x 9 mm at 10 px/mm that shows `wave` in px of its own picture."""
    x, y = np.meshgrid(np.linspace(0, 12, 9), np.linspace(0, 9, 7))
    number = np.arange(x.size).reshape(x.shape)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    vertices = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    rows, cols = np.mgrid[0:360, 0:480]
    texture = wave(4 + (cols + 0.5) / 4, 4 + (rows + 0.5) / 4).astype(np.float32)
    uv = vertices[:, :2] / [12, 9]
    none = np.zeros(len(faces), dtype=np.int64)
    mesh = textured_mesh(vertices, faces, uv[faces], none, (texture,), name="plate")
    px = vertices[:, :2] * [10, -10] + [4, 94]
    chart = Chart(np.arange(len(px)), faces, np.arange(len(faces)), px, 10.0)
    return mesh, calibrate(mesh, chart)[0]


def test_through_the_identity_a_surface_morphs_into_its_own_picture(surface):
    mesh, image = surface
    morphed = morph_surface(mesh, image, affine(np.eye(2), [0, 0], 200), image.image.shape)
    np.testing.assert_array_equal(morphed.mask, image.image.mask)
    np.testing.assert_allclose(morphed.grey, image.image.grey, atol=1e-6)


def test_a_surface_is_read_where_the_warp_points(surface):
    mesh, image = surface
    matrix, offset = np.array([[0.8, 0.25], [-0.2, 1.1]]), np.array([20.3, 11.7])
    morphed = morph_surface(mesh, image, affine(matrix, offset, 200), (90, 110))
    rows, cols = np.mgrid[0:90, 0:110]
    x, y = np.moveaxis(np.stack([cols, rows], axis=-1) @ matrix.T + offset, -1, 0)
    inside = (x > 4) & (x < 124) & (y > 4) & (y < 94)
    tie = np.abs(np.stack([x - 4, x - 124, y - 4, y - 94])).min(axis=0) < 1e-9
    np.testing.assert_array_equal(morphed.mask[~tie], inside[~tie])
    deep = (x > 6) & (x < 122) & (y > 6) & (y < 92)
    # the mean of a wave of 0.22 rad/px over 1.1 px differs from its middle by 0.4 * 0.05 / 24
    np.testing.assert_allclose(morphed.grey[deep], wave(x, y)[deep], atol=2e-3)


def test_beyond_the_warp_there_is_no_material(surface):
    mesh, image = surface
    morphed = morph_surface(mesh, image, affine(np.eye(2), [0, 0], 40), image.image.shape)
    assert morphed.mask[20:40, 20:40].all()
    assert not morphed.mask[:, 110:].any()
    assert np.isfinite(morphed.grey).all()


def test_a_shrinking_warp_averages_what_it_gathers(surface):
    mesh, image = surface
    rows, cols = np.mgrid[0:360, 0:480]
    checks = ((rows // 2 + cols // 2) % 2).astype(np.float32)
    fine = textured_mesh(
        mesh.vertices, mesh.faces, mesh.wedge_uv, mesh.face_texture, (checks,), name="fine"
    )
    morphed = morph_surface(fine, image, affine(3.3 * np.eye(2), [8, 8], 200), (24, 32))
    assert np.abs(morphed.grey[morphed.mask] - 0.5).max() < 0.1


def test_a_narrowing_warp_reads_the_texture_as_finely_as_it_is(surface):
    mesh, image = surface
    _rows, cols = np.mgrid[0:720, 0:960]
    stripes = 0.5 + 0.4 * np.sin(2 * np.pi * (cols + 0.5) / 16)  # 2 px wide: 8 texels a px
    fine = textured_mesh(
        mesh.vertices,
        mesh.faces,
        mesh.wedge_uv,
        mesh.face_texture,
        (stripes.astype(np.float32),),
        name="fine",
    )
    narrow = affine(np.diag([0.2, 0.9]), [20, 10], 200)
    morphed = morph_surface(fine, image, narrow, (80, 120))
    x = 20 + 0.2 * np.arange(10, 110)
    expected = 0.5 + 0.4 * np.sin(2 * np.pi * (x - 4) / 2)
    shown = morphed.grey[10:70, 10:110]
    kept = (shown - 0.5) @ (expected - 0.5) / np.sum((expected - 0.5) ** 2)
    np.testing.assert_allclose(kept, np.exp(-((2 * np.pi / 10) ** 2) / 24), atol=0.01)


def test_a_picture_is_read_where_the_warp_points_without_bias():
    rows, cols = np.mgrid[0:120, 0:150]
    mask = np.ones((120, 150), dtype=bool)
    mask[:, 140:] = False
    picture = GreyImage(wave(cols, rows).astype(np.float32), mask)
    matrix, offset = np.array([[0.9, 0.1], [-0.15, 0.8]]), np.array([22.4, 30.6])
    morphed = morph_image(picture, affine(matrix, offset, 160), (100, 130))
    x, y = np.moveaxis(np.stack(np.mgrid[0:100, 0:130][::-1], axis=-1) @ matrix.T + offset, -1, 0)
    inside = (x >= -0.5) & (x < 139.5) & (y >= -0.5) & (y <= 119.5)
    tie = np.abs(x - 139.5) < 1e-9
    np.testing.assert_array_equal(morphed.mask[~tie], inside[~tie])
    deep = (x > 6) & (x < 134) & (y > 6) & (y < 114)
    error = (morphed.grey - wave(x, y))[deep]
    assert np.abs(error).max() < 1e-4
    assert abs(error.mean()) < 1e-5


def test_through_the_identity_a_picture_stays_what_it_was():
    grey = np.random.default_rng(0).random((57, 83), dtype=np.float32)
    picture = GreyImage(grey, np.ones(grey.shape, dtype=bool))
    morphed = morph_image(picture, affine(np.eye(2), [0, 0], 100), grey.shape)
    assert morphed.mask.all()
    np.testing.assert_allclose(morphed.grey, grey, atol=2e-6)


def test_a_warp_that_narrows_one_strip_alone_keeps_that_strip_sharp(surface):
    mesh, image = surface
    _rows, cols = np.mgrid[0:720, 0:960]
    stripes = (0.5 + 0.4 * np.sin(2 * np.pi * (cols + 0.5) / 8)).astype(np.float32)
    fine = textured_mesh(
        mesh.vertices, mesh.faces, mesh.wedge_uv, mesh.face_texture, (stripes,), name="fine"
    )
    plain = affine(np.eye(2), [0, 0], 200, spacing=8.0)
    x = plain.coefficients[..., 0]
    bent = np.where(x < 24, 20 + 0.2 * x, 20 + 0.2 * 24 + 0.9 * (x - 24))  # narrow on the left
    warp = Warp(np.stack([bent, plain.coefficients[..., 1]], axis=-1), plain.origin, 8.0)
    morphed = morph_surface(fine, image, warp, (80, 100))
    x = 20 + 0.2 * np.arange(4, 16)
    wave_there = np.sin(2 * np.pi * (x - 4))  # 5 pixels each
    kept = (morphed.grey[10:70, 4:16] - 0.5) @ wave_there / np.sum(0.4 * wave_there**2)
    assert np.sinc(1 / 5) - 0.01 < kept.mean() < 1  # what a box as wide as the pixel keeps, or more
