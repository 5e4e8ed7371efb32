"""Clouds become surfaces: in the best plane where that is enough, by balls elsewhere."""

import numpy as np
import pytest

from shapemorph.core.errors import DataError, ShapemorphError
from shapemorph.methods import open3d_import
from shapemorph.methods.cleaning import clean_surface
from shapemorph.methods.meshing import mesh_points

RULES = {"steepest": np.deg2rad(75), "reach": 3.0, "least_used": 0.98}
POSE = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]


def sheet(count=3000, seed=1):
    """Random points of a curved sheet of 3 x 2."""
    plane = np.random.default_rng(seed).random((count, 2)) * [3, 2]
    return np.column_stack([plane, 0.3 * np.sin(2 * plane[:, 0])])


def ball(count=2000):
    """Evenly spread points of the unit sphere (golden spiral)."""
    step = np.arange(count) + 0.5
    height = 1 - 2 * step / count
    angle = np.pi * (1 + np.sqrt(5)) * step
    ring = np.sqrt(1 - height**2)
    return np.column_stack([ring * np.cos(angle), ring * np.sin(angle), height])


def counts_of(points):
    meshed = mesh_points(points, **RULES)
    clean = clean_surface(
        points, meshed.faces, weld_tolerance=1e-6, flatness=1e-9, least_piece=0.02
    )
    return meshed, clean


@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_a_sheet_in_any_pose_and_scale_is_one_disk_by_delaunay(scale):
    points = scale * sheet() @ POSE.T + scale
    meshed, clean = counts_of(points)
    assert "Delaunay" in meshed.method
    assert clean.counts.euler_characteristic == 1
    assert clean.counts.components == 1
    assert len(np.unique(clean.faces)) > 0.99 * len(points)


def test_a_regular_grid_becomes_two_triangles_a_cell():
    x, y = np.meshgrid(np.arange(20.0), np.arange(13.0))
    points = np.stack([x, y, 0.02 * x * y], axis=-1).reshape(-1, 3)
    assert len(mesh_points(points, **RULES).faces) == 2 * 19 * 12


def test_a_hole_wider_than_the_reach_stays_open():
    points = sheet(6000)
    ring = points[np.hypot(points[:, 0] - 1.5, points[:, 1] - 1) > 0.4]
    _, clean = counts_of(ring)
    assert clean.counts.boundary_loops == 2
    assert clean.counts.euler_characteristic == 0


def test_a_closed_ball_is_meshed_by_balls_without_a_hole():
    meshed, clean = counts_of(ball())
    assert "ball pivoting" in meshed.method
    assert clean.counts.boundary_loops == 0
    assert clean.counts.euler_characteristic == 2
    np.testing.assert_allclose(np.linalg.norm(clean.vertices, axis=1), 1.0)


def test_two_layers_over_one_plane_are_no_graph():
    plane = np.stack(np.meshgrid(np.arange(30.0), np.arange(40.0)), axis=-1).reshape(-1, 2)
    lower = np.column_stack([plane, np.zeros(1200)])
    upper = np.column_stack([np.add(plane, [0.5, 0.4]), np.full(1200, 12.0)])
    meshed, clean = counts_of(np.concatenate([lower, upper]))
    assert "ball pivoting" in meshed.method
    assert np.ptp(clean.vertices[:, 2]) == 0.0


def test_the_same_cloud_gives_the_same_triangles_again():
    points = ball(500)
    first, second = (mesh_points(points, **RULES).faces for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_points_on_a_line_are_refused():
    with pytest.raises(DataError, match=r"line|join"):
        mesh_points(np.outer(np.arange(30.0), [1, 2, 3]), **RULES)


def test_a_machine_without_the_system_libraries_is_told_what_to_run(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "open3d", None)
    with pytest.raises(ShapemorphError, match="shapemorph doctor"):
        open3d_import.import_open3d()
