"""Sizes and stretches of triangles that are known on paper."""

import numpy as np

from shapemorph.kernels.facets import (
    affine_maps,
    measure_triangles,
    plane_moments,
    signed_area,
    stretch_triangles,
)

VERTICES = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0], [0, 0, 12]])
FACES = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 1]])


def test_areas_and_longest_sides_of_right_triangles():
    areas, longest = measure_triangles(VERTICES, FACES)
    np.testing.assert_allclose(areas, [6.0, 18.0, 0.0])
    np.testing.assert_allclose(longest, [5.0, np.sqrt(153.0), 3.0])


def test_stretches_are_the_singular_values_of_the_map():
    random = np.random.default_rng(3)
    space, plane = random.normal(size=(30, 3)), random.normal(size=(30, 2))
    faces = np.arange(30).reshape(-1, 3)
    sigma_1, sigma_2, areas = stretch_triangles(space, faces, plane, 1.0)
    for k, (a, b, c) in enumerate(faces):
        sides = np.stack([space[b] - space[a], space[c] - space[a]], axis=1)
        frame, local = np.linalg.qr(sides)
        gradient = np.stack([plane[b] - plane[a], plane[c] - plane[a]], axis=1) @ np.linalg.inv(
            local
        )
        singular = np.linalg.svd(gradient, compute_uv=False)
        sense = np.sign(np.linalg.det(gradient) * np.linalg.det(local))
        np.testing.assert_allclose(
            [sigma_1[k], sigma_2[k]], singular * [1.0, sense], rtol=1e-9, atol=1e-12
        )
        np.testing.assert_allclose(areas[k], 0.5 * abs(np.linalg.det(local)))
        assert frame.shape == (3, 2)


def test_a_triangle_without_area_has_no_stretch():
    plane = np.array([[0.0, 0], [1, 0], [0, 1], [1, 1]])
    sigma_1, sigma_2, areas = stretch_triangles(VERTICES, FACES, plane, -1.0)
    assert np.isnan(sigma_1[2])
    assert np.isnan(sigma_2[2])
    assert areas[2] == 0.0
    assert (sigma_2[:2] < 0).all()  # seen in a plane whose second axis runs downwards


def test_areas_in_the_plane_have_the_sign_of_their_turn():
    plane = np.array([[0.0, 0], [2, 0], [0, 1]])
    assert signed_area(plane, np.array([[0, 1, 2]])) == 1.0
    assert signed_area(plane, np.array([[0, 2, 1], [0, 2, 1]])) == -2.0


def test_moments_of_a_rectangle_are_those_of_the_book():
    plane = np.array([[0.0, 0], [6, 0], [6, 2], [0, 2]]) + 5.0
    space = np.column_stack([plane, np.zeros(4)]) @ np.diag([1.0, 2.0, 1.0])
    faces = np.array([[0, 1, 2], [0, 3, 2]])  # the second lies upside down and counts as much
    centre, second, along = plane_moments(space, plane, faces)
    np.testing.assert_allclose(centre, [8.0, 6.0])
    np.testing.assert_allclose(second, [[3.0, 0.0], [0.0, 1.0 / 3.0]], atol=1e-12)
    # Centroids lie at (1, -1/3) and (-1, 1/3) about the centre; y is doubled in space.
    np.testing.assert_allclose(along, [[1.0, -2.0 / 3.0, 0.0], [-1.0 / 3.0, 2.0 / 9.0, 0.0]])


def test_affine_maps_of_triangles_are_found_and_points_have_none():
    source = np.array([[0.0, 0], [2, 1], [1, 3], [4, 2]])
    matrix, faces = np.array([[1.5, -0.5], [0.25, 2.0]]), np.array([[0, 1, 2], [0, 1, 3]])
    maps = affine_maps(source, faces, (source @ matrix.T + 7.0)[faces])
    np.testing.assert_allclose(maps[0], matrix)
    np.testing.assert_array_equal(maps[1], 0.0)
