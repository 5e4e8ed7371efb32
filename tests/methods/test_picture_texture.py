"""The picture on the surface shows at every point what the mesh's own texture shows."""

import numpy as np
import pytest

from shapemorph.core.mesh import textured_mesh
from shapemorph.methods.calibrating import calibrate
from shapemorph.methods.charting import chart_at_scale
from shapemorph.methods.parametrize.disk import cut_piece
from shapemorph.methods.picture_texture import wear_picture


@pytest.fixture(scope="module")
def worn(wave_pattern):
    """A bent sheet, its picture at another angle than its texture, and the sheet wearing it."""
    rows, cols = 18, 25
    y, x = np.divmod(np.arange(rows * cols), cols)
    uv = np.stack([x / (cols - 1), y / (rows - 1)], axis=1)
    number = np.arange(rows * cols).reshape(rows, cols)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    vertices = np.stack([30 * uv[:, 0], 20 * uv[:, 1], 2 * uv[:, 0] ** 2], axis=1)
    grid = np.stack(np.meshgrid(np.arange(600.0), np.arange(400.0)), axis=-1)
    texture = (wave_pattern(14.0)(grid).astype(np.float32),)
    which = np.zeros(len(faces), int)
    mesh = textured_mesh(vertices, faces, uv[faces], which, texture, name="sheet")
    piece = cut_piece(vertices, faces, name="sheet")
    plane = vertices[piece.vertex_ids][:, :2] @ np.array([[0.8, 0.6], [-0.6, 0.8]])
    image, _ = calibrate(mesh, chart_at_scale(piece, plane, px_per_mm=17.0))
    return mesh, image, wear_picture(mesh, image)


def _grey(mesh, faces, weights):
    """Grey at barycentric places of faces, bilinear."""
    from scipy.ndimage import map_coordinates

    height, width = mesh.textures[0].shape
    uv = np.einsum("nk,nkd->nd", weights, mesh.wedge_uv[faces])
    place = [(1 - uv[:, 1]) * height - 0.5, uv[:, 0] * width - 0.5]
    return map_coordinates(mesh.textures[0], place, order=1, mode="nearest")


def test_it_shows_the_same_grey_at_the_same_points(worn):
    mesh, image, dressed = worn
    rng = np.random.default_rng(0)
    weights = rng.dirichlet([1, 1, 1], 4000)
    chosen = rng.integers(0, len(dressed.faces), 4000)
    own = image.chart.face_ids[chosen]
    np.testing.assert_array_equal(dressed.faces, mesh.faces[image.chart.face_ids])
    error = _grey(dressed, chosen, weights) - _grey(mesh, own, weights)
    # two bilinear interpolations of a pattern of 14 px; half a pixel of shift gives 0.03
    assert np.sqrt(np.mean(error**2)) < 4e-3


def test_geometry_and_name_stay(worn):
    mesh, _, dressed = worn
    assert dressed.vertices is mesh.vertices
    assert dressed.name == mesh.name


def test_grey_goes_on_beyond_the_rim_so_that_filters_find_no_edge(worn):
    _, image, dressed = worn
    mask = image.image.mask
    row = mask.shape[0] // 2
    first = int(np.flatnonzero(mask[row])[0])
    beside = dressed.textures[0][row, first - 2 : first]
    np.testing.assert_allclose(beside, image.image.grey[row, first], atol=0.1)
    np.testing.assert_array_equal(dressed.textures[0][mask], image.image.grey[mask])
