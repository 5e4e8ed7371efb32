import numpy as np
import pytest

from shapemorph.core.mesh import textured_mesh
from shapemorph.methods.calibrating import calibrate
from shapemorph.methods.chart_index import index_chart
from shapemorph.methods.charting import chart_at_scale
from shapemorph.methods.parametrize.boundary_first import parametrise_boundary_first
from shapemorph.methods.parametrize.disk import cut_piece
from shapemorph.methods.surface_lookup import (
    grey_at,
    locate,
    pixel_positions,
    positions,
    project,
)


def _saddle(seed=0, rows=23, cols=31):
    """A bent sheet with a hole, its vertices and faces in random order."""
    number = np.arange(rows * cols).reshape(rows, cols)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    rng = np.random.default_rng(seed)
    y, x = np.divmod(np.arange(rows * cols), cols)
    flat = np.stack([x, y], axis=1) + rng.uniform(-0.2, 0.2, (rows * cols, 2))
    vertices = np.column_stack([flat, 0.01 * (flat[:, 0] - 14) * (flat[:, 1] - 9)])
    middle = flat[faces].mean(axis=1)
    faces = faces[np.linalg.norm(middle - [11, 9], axis=1) > 3]
    uv = flat / [cols, rows] * 0.9 + 0.05
    texture = rng.random((64, 80), dtype=np.float32)
    faces = faces[rng.permutation(len(faces))]
    none = np.zeros(len(faces), dtype=np.int64)
    return textured_mesh(vertices, faces, uv[faces], none, (texture,), name="saddle")


@pytest.fixture(scope="module")
def case():
    mesh = _saddle()
    piece = cut_piece(mesh.vertices, mesh.faces, name="saddle")
    plane = parametrise_boundary_first(mesh.vertices[piece.vertex_ids], piece.faces)
    image, _ = calibrate(mesh, chart_at_scale(piece, plane, px_per_mm=6.3))
    return mesh, image


def test_from_px_to_the_surface_and_back_is_exact(case):
    mesh, image = case
    points = np.random.default_rng(1).uniform([0, 0], image.image.shape[::-1], (20_000, 2))
    found = locate(image, points)
    on = found.face >= 0
    assert 0.5 < on.mean() < 0.95
    size = max(image.image.shape)
    assert np.abs(project(image, found)[on] - points[on]).max() < 1e-9 * size
    assert np.isnan(found.barycentric[~on]).all()
    assert np.abs(found.barycentric[on].sum(axis=1) - 1).max() < 1e-15 * 4
    assert found.barycentric[on].min() > -1e-12
    assert np.isfinite(positions(mesh, found)[on]).all()


def test_every_point_has_the_triangle_that_a_search_through_all_finds(case):
    _, image = case
    points = np.random.default_rng(2).uniform([5, 5], [150, 120], (400, 2))
    found = locate(image, points)
    corners = image.chart.corner_px
    for point, face in zip(points, found.face, strict=True):
        one, two, three = (corners[:, k] - point for k in range(3))
        areas = np.stack(
            [
                a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
                for a, b in ((one, two), (two, three), (three, one))
            ]
        )
        inside = np.flatnonzero((areas < 0).all(axis=0) | (areas > 0).all(axis=0))
        assert [face] == ([-1] if len(inside) == 0 else image.chart.face_ids[inside].tolist())


def test_pixel_centres_agree_with_the_raster(case):
    mesh, image = case
    rows, cols = np.nonzero(np.ones(image.image.shape, dtype=bool))
    found = locate(image, np.stack([cols, rows], axis=1).astype(float))
    triangle = image.triangle[rows, cols]
    np.testing.assert_array_equal(
        found.face, np.where(triangle >= 0, image.chart.face_ids[triangle], -1)
    )
    places = pixel_positions(mesh, image)[rows, cols]
    np.testing.assert_array_equal(places, positions(mesh, found))


def test_the_border_belongs_to_the_surface(case):
    mesh, image = case
    chart = image.chart
    assert (locate(image, chart.vertex_px).face >= 0).all()
    np.testing.assert_allclose(
        positions(mesh, locate(image, chart.vertex_px)), mesh.vertices[chart.vertex_ids], atol=1e-11
    )
    part = np.linspace(0, 1, 7)[:, None, None]
    one, other = chart.vertex_px[chart.faces], chart.vertex_px[np.roll(chart.faces, -1, axis=1)]
    edges = (one.reshape(-1, 2) * (1 - part) + other.reshape(-1, 2) * part).reshape(-1, 2)
    assert (locate(image, edges).face >= 0).all()


def test_off_the_surface_is_minus_one(case):
    _, image = case
    points = np.array([[-1e6, 3.0], [np.nan, 5.0], [1e300, 1e300], [np.inf, 0.0], [0.0, 0.0]])
    assert (locate(image, points).face == -1).all()
    outside = np.argwhere(~image.image.mask)[:, ::-1].astype(float)
    assert (locate(image, outside).face == -1).all()
    assert len(locate(image, np.zeros((0, 2))).face) == 0


def test_a_micrometre_beyond_the_border_is_off_the_surface(case):
    _, image = case
    rightmost = image.chart.vertex_px[:, 0].argmax()
    corner = image.chart.vertex_px[rightmost]
    assert locate(image, corner[None]).face[0] >= 0
    assert locate(image, corner[None] + [[1e-9, 0.0]]).face[0] == -1


def test_the_handedness_of_the_chart_does_not_matter(case):
    import dataclasses

    _, image = case
    width = image.image.shape[1]
    mirrored_px = image.chart.vertex_px * [-1, 1] + [width - 1, 0]
    chart = dataclasses.replace(image.chart, vertex_px=mirrored_px)
    mirrored = dataclasses.replace(image, chart=chart)
    assert index_chart(chart).sign == -index_chart(image.chart).sign
    points = np.random.default_rng(3).uniform([0, 0], image.image.shape[::-1], (3000, 2))
    one = locate(image, points)
    other = locate(mirrored, points * [-1, 1] + [width - 1, 0])
    assert (one.face == other.face).mean() > 0.999  # ties and round-off apart
    np.testing.assert_allclose(
        one.barycentric[one.face >= 0], other.barycentric[one.face >= 0], atol=1e-9
    )


def test_grey_at_a_pixel_centre_is_the_grey_of_the_pixel(case):
    mesh, image = case
    rows, cols = np.nonzero(image.image.mask)
    grey, inside = grey_at(mesh, image, np.stack([cols, rows], axis=1).astype(float))
    assert inside.all()
    np.testing.assert_array_equal(grey, image.image.grey[rows, cols])
    grey, inside = grey_at(mesh, image, np.array([[0.0, 0.0]]))
    assert not inside[0]
    assert np.isnan(grey[0])
