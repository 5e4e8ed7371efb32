import numba
import numpy as np
import pytest

from shapemorph.kernels.raster import rasterise


def _grid(rows, cols):
    number = np.arange(rows * cols).reshape(rows, cols)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    y, x = np.divmod(np.arange(rows * cols), cols)
    return np.stack([x, y], axis=1).astype(np.float64), faces


@pytest.fixture(params=["aligned", "oblique"])
def mesh(request):
    """A grid over whole pixels, its vertices on pixel centres in the first case."""
    px, faces = _grid(13, 17)
    if request.param == "aligned":
        return 2.0 * px + 3.0, faces
    turn = np.array([[0.9, 0.35], [-0.4, 1.1]])
    jitter = np.random.default_rng(0).uniform(-0.2, 0.2, px.shape)
    return (px + jitter) @ turn.T * 3.1 + np.array([5.2, 25.3]), faces


def test_every_pixel_inside_has_exactly_one_triangle(mesh):
    px, faces = mesh
    shuffled = faces[np.random.default_rng(1).permutation(len(faces))]
    triangle, _, overlaps = rasterise(px, shuffled, 1.0, 60, 70)
    assert overlaps == 0
    inside = triangle >= 0
    for row in np.flatnonzero(inside.any(axis=1)):
        cols = np.flatnonzero(inside[row])
        assert len(cols) == cols[-1] - cols[0] + 1, "a pinhole"


def test_pixels_on_shared_vertices_and_edges_are_counted_once():
    px, faces = _grid(9, 6)
    triangle, _, overlaps = rasterise(4.0 * px, faces, 1.0, 40, 30)
    assert overlaps == 0
    assert (triangle >= 0).sum() == 33 * 21  # the border counts


def test_barycentric_weights_give_back_the_pixel(mesh):
    px, faces = mesh
    triangle, pair, _ = rasterise(px, faces, 1.0, 60, 70)
    rows, cols = np.nonzero(triangle >= 0)
    weights = pair[rows, cols]
    weights = np.column_stack([1 - weights.sum(axis=1), weights])
    back = np.einsum("nk,nkd->nd", weights, px[faces[triangle[rows, cols]]])
    # coordinates to 70 px, round-off 1e-16 of them, times the slenderness of the triangles
    np.testing.assert_allclose(back, np.stack([cols, rows], axis=1), atol=1e-12)
    assert np.isnan(pair[triangle < 0]).all()


def test_mirrored_triangles_need_the_other_sign(mesh):
    px, faces = mesh
    turned = faces[:, [0, 2, 1]]
    assert (rasterise(px, turned, 1.0, 60, 70)[0] == -1).all()
    np.testing.assert_array_equal(
        rasterise(px, turned, -1.0, 60, 70)[0] >= 0, rasterise(px, faces, 1.0, 60, 70)[0] >= 0
    )


def test_where_sheets_overlap_the_first_wins_and_it_is_counted():
    px = np.array([[0.5, 0.5], [9.4, 0.5], [0.5, 9.4]])
    faces = np.array([[0, 1, 2], [0, 1, 2]])
    triangle, _, overlaps = rasterise(px, faces, 1.0, 11, 12)
    assert overlaps == (triangle == 0).sum() > 0
    assert (triangle < 1).all()


def test_the_number_of_threads_changes_nothing(mesh):
    px, faces = mesh
    many = rasterise(px, faces, 1.0, 60, 70)
    before = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        one = rasterise(px, faces, 1.0, 60, 70)
    finally:
        numba.set_num_threads(before)
    np.testing.assert_array_equal(one[0], many[0])
    np.testing.assert_array_equal(one[1], many[1])


def test_triangles_off_the_picture_do_no_harm():
    px = np.array([[-50.0, -50.0], [500.0, -40.0], [-40.0, 500.0]])
    triangle, _, _ = rasterise(px, np.array([[0, 1, 2]]), 1.0, 8, 9)
    assert (triangle == 0).all()
    assert (rasterise(px - 1000, np.array([[0, 1, 2]]), 1.0, 8, 9)[0] == -1).all()
