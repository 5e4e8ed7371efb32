import numpy as np
import pytest

from shapemorph.methods.forming.cuts import cut_surface, middle_of, plane_of


def plate(rows=21, cols=31, hole=False):
    """Triangulated plate of 15 x 10 mm in the plane z = 0."""
    y, x = np.mgrid[:rows, :cols] * 0.5
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    number = np.arange(rows * cols).reshape(rows, cols)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    corners = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    if hole:
        middle = points[corners].mean(axis=1)
        corners = corners[np.linalg.norm(middle - [7.5, 5, 0], axis=1) > 2.6]
    return points, corners


def tube():
    """Closed around the x axis: radius 5 mm, length 20 mm."""
    angle, along = np.meshgrid(np.arange(60) * np.pi / 30, np.linspace(0, 20, 21))
    points = np.stack([along, 5 * np.cos(angle), 5 * np.sin(angle)], axis=-1).reshape(-1, 3)
    number = np.arange(21 * 60).reshape(21, 60)
    right = np.roll(number, -1, axis=1)
    a, b, c, d = (part.ravel() for part in (number[:-1], right[:-1], right[1:], number[1:]))
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def test_a_cut_runs_from_rim_to_rim_with_linear_fields_exact():
    points, corners = plate()
    plane = plane_of(middle_of(points, corners), None, None, np.radians(30))
    cut = cut_surface("a", points, corners, plane)
    places = cut.along_cut(points)
    assert cut.starts.sum() == 1
    np.testing.assert_allclose((places - plane.point) @ plane.normal, 0, atol=1e-12)
    along = (places - plane.point) @ plane.along
    assert (np.diff(along) > -1e-12).all()
    assert np.ptp(along) == pytest.approx(15 / np.cos(np.radians(30)))
    linear = points @ [1.0, 2.0, 3.0]
    np.testing.assert_allclose(cut.along_cut(linear), places @ [1.0, 2.0, 3.0])


def test_a_hole_parts_the_cut_in_two():
    points, corners = plate(hole=True)
    cut = cut_surface("a", points, corners, plane_of(middle_of(points, corners), None, None, 0.0))
    assert cut.starts.sum() == 2
    x = cut.along_cut(points)[:, 0]
    assert x[0] == pytest.approx(0)
    assert x[-1] == pytest.approx(15)
    assert 3 < np.diff(x).max() < 6


def test_a_ring_is_one_closed_line():
    points, corners = tube()
    plane = plane_of(middle_of(points, corners), np.array([9.7, 0, 0]), np.array([2.0, 0, 0]), 0.0)
    cut = cut_surface("ring", points, corners, plane)
    places = cut.along_cut(points)
    assert cut.starts.sum() == 1
    np.testing.assert_allclose(places[:, 0], 9.7)
    step = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert step.sum() == pytest.approx(2 * np.pi * 5, rel=0.02)


def test_a_plane_that_misses_cuts_nothing():
    points, corners = plate()
    plane = plane_of(middle_of(points, corners), np.array([0, 99.0, 0]), np.array([0, 1.0, 0]), 0.0)
    assert len(cut_surface("none", points, corners, plane).share) == 0


def test_a_diameter_is_measured_from_the_x_axis_about_the_mean_normal():
    points, corners = plate()
    plane = plane_of(middle_of(points, corners), None, None, np.radians(90))
    np.testing.assert_allclose(plane.along, [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(plane.point, [7.5, 5, 0], atol=1e-12)
