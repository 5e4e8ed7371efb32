import numpy as np

from shapemorph.kernels.blend import blend_corners


def test_an_affine_map_of_the_corners_is_met_inside():
    rng = np.random.default_rng(2)
    corners, slope = rng.random((5, 3, 2)), rng.random((2, 4))
    triangle = rng.integers(0, 5, 40)
    weights = rng.dirichlet(np.ones(3), 40)
    places = np.einsum("nk,nkd->nd", weights, corners[triangle])
    found = blend_corners(corners @ slope + 3.0, triangle, weights[:, 1:])
    np.testing.assert_allclose(found, places @ slope + 3.0, atol=1e-13)


def test_corners_keep_their_very_values_and_nothing_is_off_the_triangles():
    corners = np.arange(18.0).reshape(3, 3, 2) / 7.0
    found = blend_corners(corners, np.array([1, 2, -1]), np.array([[0.0, 0.0], [1.0, 0.0], [0, 0]]))
    np.testing.assert_array_equal(found[:2], [corners[1, 0], corners[2, 1]])
    assert np.isnan(found[2]).all()
