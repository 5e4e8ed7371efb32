"""Polygons are cut into triangles that cover them exactly."""

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.methods.polygons import triangulate


def star(corners, seed):
    """A star-shaped outline (K, 2) with reflex corners, counter-clockwise."""
    random = np.random.default_rng(seed)
    angle = np.sort(random.random(corners)) * 0.3 + np.arange(corners) * 2 * np.pi / corners
    radius = random.uniform(0.3, 2.0, corners)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def signed_areas(flat, triangles):
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def shoelace(flat):
    ahead = np.roll(flat, -1, axis=0)
    return 0.5 * float(np.sum(flat[:, 0] * ahead[:, 1] - flat[:, 1] * ahead[:, 0]))


def in_space(flat):
    """The plane placed obliquely in space."""
    return flat @ np.array([[0.8, 0.1, 0.59], [-0.2, 0.97, 0.11]])


def test_triangles_and_convex_polygons_become_fans():
    square = np.array([[0, 0], [2, 0], [2, 1], [0, 1.5]])
    corners, polygon = triangulate(in_space(np.concatenate([square[:3], square])), np.array([3, 4]))
    np.testing.assert_array_equal(corners, [[0, 1, 2], [3, 4, 5], [3, 5, 6]])
    np.testing.assert_array_equal(polygon, [0, 1, 1])


@pytest.mark.parametrize("reflex", range(4))
def test_a_quad_is_cut_through_its_reflex_corner(reflex):
    arrow = np.array([[0, 0], [3, 1], [0.6, 0.6], [1, 3]])
    outline = np.roll(arrow, reflex - 2, axis=0)
    corners, _ = triangulate(in_space(outline), np.array([4]))
    areas = signed_areas(outline, corners)
    assert (areas > 0).all()
    np.testing.assert_allclose(areas.sum(), shoelace(outline))


@pytest.mark.parametrize("seed", range(12))
def test_outlines_with_reflex_corners_are_covered_without_overlap(seed):
    outline = star(5 + seed % 6, seed)
    assert shoelace(outline) > 0
    corners, polygon = triangulate(in_space(outline), np.array([len(outline)]))
    areas = signed_areas(outline, corners)
    assert (areas > 0).all()
    np.testing.assert_allclose(areas.sum(), shoelace(outline), rtol=1e-12)
    assert len(corners) == len(outline) - 2
    assert (polygon == 0).all()


def test_polygons_of_mixed_sizes_keep_their_order():
    outlines = [star(k, k) for k in (6, 3, 4, 5, 3)]
    sizes = np.array([len(outline) for outline in outlines])
    corners, polygon = triangulate(in_space(np.concatenate(outlines)), sizes)
    np.testing.assert_array_equal(polygon, np.repeat(np.arange(5), sizes - 2))
    first = np.cumsum(sizes) - sizes
    assert (corners >= first[polygon][:, None]).all()
    assert (corners < (first + sizes)[polygon][:, None]).all()


def test_an_outline_too_large_to_clip_is_refused_and_a_large_convex_one_is_not():
    crooked = star(501, 0)
    with pytest.raises(DataError, match="up to 500 corners, got one of 501"):
        triangulate(in_space(crooked), np.array([501]))
    angle = np.arange(2000) * 2 * np.pi / 2000
    corners, _ = triangulate(
        np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]), np.array([2000])
    )
    assert corners.shape == (1998, 3)


def test_a_polygon_without_area_still_gives_its_triangles():
    corners, _ = triangulate(np.zeros((6, 3)), np.array([6]))
    assert corners.shape == (4, 3)
