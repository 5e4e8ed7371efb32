"""The maps against closed forms: cap, cylinder, cone, plane."""

import numpy as np
import pytest

from shapemorph.methods.distortion import local_scale, singular_values
from shapemorph.methods.parametrize.boundary_first import (
    close_polygon,
    parametrise_boundary_first,
)
from shapemorph.methods.parametrize.conformal_lscm import parametrise_lscm
from shapemorph.methods.parametrize.disk import boundary_loops
from shapemorph.methods.parametrize.harmonic_disk import parametrise_on_disk
from shapemorph.methods.parametrize.holes import order_by_length
from shapemorph.methods.parametrize.orthographic import parametrise_orthographic

CONFORMAL = [parametrise_boundary_first, parametrise_lscm]


def grid_faces(rows, cols):
    number = np.arange(rows * cols).reshape(rows, cols)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def disk_grid(rings):
    """Polar angle and azimuth, in [0, 1] and radians, of a disk of triangles."""
    radius, azimuth, faces, first = [0.0], [0.0], [], 0
    for ring in range(1, rings + 1):
        start, count, inner = len(radius), 6 * ring, max(6 * (ring - 1), 1)
        radius += [ring / rings] * count
        azimuth += list(np.arange(count) * 2 * np.pi / count)
        for k in range(count):
            sector, place = divmod(k, ring)
            below = first + (sector * (ring - 1) + place) % inner
            before = first + (sector * (ring - 1) + place - 1) % inner
            here, after = start + k, start + (k + 1) % count
            faces.append([below, here, after])
            if place > 0:
                faces.append([before, here, below])
        first = start
    return np.array(radius), np.array(azimuth), np.array(faces)


def cap(half_angle, rings=40, size=35.0):
    radius, azimuth, faces = disk_grid(rings)
    polar = radius * half_angle
    points = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=1
    )
    return size * points, faces, polar


def shuffled(vertices, faces, seed=0):
    """The same mesh in another order, turned and moved in space."""
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(seed)
    order = rng.permutation(len(vertices))
    place = np.argsort(order)
    turned = Rotation.from_rotvec([0.3, -1.1, 0.7]).apply(vertices[order])
    turned = turned + np.array([5.0, -80.0, 12.0])
    return turned, place[faces][rng.permutation(len(faces))], place


@pytest.mark.parametrize("half_angle", [0.6, np.pi / 2, 2.2])
def test_boundary_first_lays_a_cap_flat_like_the_stereographic_projection(half_angle):
    vertices, faces, polar = cap(half_angle)
    vertices, faces, place = shuffled(vertices, faces)
    plane = parametrise_boundary_first(vertices, faces)
    rim = 35.0 * np.sin(half_angle)
    expected = rim * np.tan(polar / 2) / np.tan(half_angle / 2)
    centred = plane - plane[place[0]]
    found = np.linalg.norm(centred, axis=1)[place]
    # chords of 40 rings: (half_angle / 40)^2 / 2 of the size, 1.5e-3 for the largest cap
    np.testing.assert_allclose(found, expected, atol=3e-3 * rim)


def test_boundary_first_converges_to_the_stereographic_projection():
    errors = []
    for rings in (10, 20, 40):
        vertices, faces, polar = cap(np.pi / 2, rings)
        plane = parametrise_boundary_first(vertices, faces)
        found = np.linalg.norm(plane - plane[0], axis=1)
        errors.append(np.abs(found - 35.0 * np.tan(polar / 2)).max())
    assert errors[2] < 0.02
    assert errors[0] / errors[1] > 3  # second order: 4
    assert errors[1] / errors[2] > 3


@pytest.mark.parametrize("make", CONFORMAL)
def test_a_cylinder_patch_unrolls_without_stretch(make):
    rows, cols = 41, 63
    height, angle = np.meshgrid(
        np.linspace(0, 30, rows), np.linspace(-1.2, 1.5, cols), indexing="ij"
    )
    jitter = np.random.default_rng(1).uniform(-0.01, 0.01, angle.shape)
    jitter[:, [0, -1]] = 0
    angle = angle + jitter
    points = np.stack([20 * np.cos(angle), 20 * np.sin(angle), height], axis=-1).reshape(-1, 3)
    vertices, faces, _ = shuffled(points, grid_faces(rows, cols))
    stretch = singular_values(vertices, faces, make(vertices, faces))
    scale = np.median(stretch.sigma_1)  # LSCM fixes the scale at two pins
    np.testing.assert_allclose(stretch.sigma_1 / scale, 1.0, atol=1e-3)
    np.testing.assert_allclose(stretch.sigma_2 / scale, 1.0, atol=1e-3)


@pytest.mark.parametrize("make", CONFORMAL)
def test_conformal_maps_keep_angles_on_a_bumpy_surface(make):
    x, y = np.meshgrid(np.linspace(-1, 1, 61), np.linspace(-0.7, 0.7, 47))
    z = 0.5 * np.exp(-4 * (x**2 + y**2)) + 0.1 * x * y
    vertices, faces, _ = shuffled(np.stack([x, y, z], axis=-1).reshape(-1, 3), grid_faces(47, 61))
    stretch = singular_values(vertices, faces, make(vertices, faces))
    assert stretch.flips == 0
    assert np.quantile(stretch.sigma_1 / stretch.sigma_2, 0.99) < 1.05


def test_boundary_first_keeps_the_length_of_the_rim():
    x, y = np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-0.7, 0.7, 31))
    points = np.stack([x, y, 0.3 * np.cos(2 * x) * y], axis=-1).reshape(-1, 3)
    faces = grid_faces(31, 41)
    plane = parametrise_boundary_first(points, faces)
    rim = boundary_loops(faces, name="x")[0]
    in_space = np.linalg.norm(points[np.roll(rim, -1)] - points[rim], axis=1)
    in_plane = np.linalg.norm(plane[np.roll(rim, -1)] - plane[rim], axis=1)
    np.testing.assert_allclose(in_plane, in_space, rtol=0.02)  # closing the polygon


def test_boundary_first_gives_a_plane_with_a_hole_back():
    x, y = np.meshgrid(np.linspace(0, 9, 31), np.linspace(0, 6, 25))
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    faces = grid_faces(25, 31)
    centre = points[faces].mean(axis=1)
    faces = faces[np.linalg.norm(centre - [4, 3.2, 0], axis=1) > 1.1]
    used, renamed = np.unique(faces, return_inverse=True)
    vertices, faces, _ = shuffled(points[used], renamed.reshape(-1, 3))
    stretch = singular_values(vertices, faces, parametrise_boundary_first(vertices, faces))
    np.testing.assert_allclose(stretch.sigma_1, 1.0, atol=1e-9)
    np.testing.assert_allclose(stretch.sigma_2, 1.0, atol=1e-9)


@pytest.mark.parametrize("make", [*CONFORMAL, parametrise_on_disk])
def test_the_outer_side_comes_up_and_repeats_bit_for_bit(make):
    vertices, faces, _ = cap(1.2, 20)
    plane = make(vertices, faces)
    assert singular_values(vertices, faces, plane).flips == 0
    np.testing.assert_array_equal(plane, make(vertices.copy(), faces.copy()))
    mirrored = make(vertices * [-1, 1, 1], faces[:, [0, 2, 1]])
    assert singular_values(vertices * [-1, 1, 1], faces[:, [0, 2, 1]], mirrored).flips == 0


def test_a_change_of_unit_changes_the_map_by_that_unit_alone():
    vertices, faces, _ = cap(1.2, 20)
    plane = parametrise_boundary_first(vertices, faces)
    np.testing.assert_allclose(
        parametrise_boundary_first(1e3 * vertices, faces), 1e3 * plane, rtol=1e-9, atol=1e-6
    )


def test_the_disk_map_cannot_fold_even_a_crumpled_sheet():
    x, y = np.meshgrid(np.linspace(0, 1, 30), np.linspace(0, 1, 26))
    noise = np.random.default_rng(7).normal(0, 0.03, (26 * 30, 3))  # an edge is 0.035 long
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3) + noise
    faces = grid_faces(26, 30)
    plane = parametrise_on_disk(points, faces)
    assert singular_values(points, faces, plane).flips == 0


def test_a_polygon_is_closed_by_the_least_change_of_its_lengths():
    turning = np.full(5, 2 * np.pi / 5)
    corners = close_polygon(np.array([1.0, 1.0, 1.0, 1.0, 1.2]), turning)
    edges = np.roll(corners, -1, axis=0) - corners
    assert np.linalg.norm(edges, axis=1) == pytest.approx(np.linalg.norm(edges, axis=1))
    np.testing.assert_allclose(edges.sum(axis=0), 0, atol=1e-12)
    heading = np.arctan2(edges[:, 1], edges[:, 0])
    np.testing.assert_allclose(np.mod(np.diff(heading), 2 * np.pi), turning[1:], atol=1e-12)


def test_projection_along_z_is_the_picture_of_x_and_y():
    vertices, faces, _ = cap(1.2, 12)
    plane = parametrise_orthographic(vertices, faces, axis=np.array([0.0, 0.0, 2.0]))
    np.testing.assert_allclose(plane, vertices[:, :2], atol=1e-12)
    # Eq. 5: radius sqrt(R^2 - Z^2)
    radius = np.sqrt(35.0**2 - vertices[:, 2] ** 2)
    np.testing.assert_allclose(np.linalg.norm(plane, axis=1), radius, atol=1e-6)


def test_without_an_axis_projection_looks_at_the_outer_side():
    vertices, faces, place = shuffled(*cap(0.8, 12)[:2])
    plane = parametrise_orthographic(vertices, faces, axis=None)
    assert singular_values(vertices, faces, plane).flips == 0
    from_pole = np.linalg.norm(plane - plane[place[0]], axis=1)
    assert from_pole.max() == pytest.approx(35 * np.sin(0.8), rel=1e-3)


def test_the_longest_loop_is_the_rim():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [9, 0, 0], [5, 4, 0]])
    short, long = np.array([0, 1, 2]), np.array([3, 4, 5])
    assert order_by_length(points, [short, long])[0] is long


def test_scale_of_a_cap_varies_as_the_stereographic_projection_says():
    vertices, faces, polar = cap(np.pi / 2, 40)
    stretch = singular_values(vertices, faces, parametrise_boundary_first(vertices, faces))
    middle = polar[faces].mean(axis=1)
    expected = 0.5 / np.cos(middle / 2) ** 2  # d(tan(t/2)) / dt for a rim of scale 1
    np.testing.assert_allclose(local_scale(stretch), expected, rtol=0.02)
