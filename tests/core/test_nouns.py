"""Nouns refuse arrays that do not fit together."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from shapemorph.core.errors import DataError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.mesh import coloured_mesh, textured_mesh
from shapemorph.core.status import PointStatus, count_statuses
from shapemorph.core.surface import TrackedSurface
from shapemorph.core.transform import RigidTransform

VERTICES = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])
FACES = np.array([[0, 1, 2]])


def test_statuses_are_counted_by_name():
    codes = np.array([[0, 0, 3], [7, 0, 3]], dtype=np.uint8)
    assert count_statuses(codes) == {"OK": 3, "LEFT_IMAGE": 2, "OUTLIER": 1}


def test_rigid_transform_and_its_inverse_cancel():
    turn = Rotation.from_euler("xyz", [0.3, -1.0, 2.0]).as_matrix()
    target_from_source = RigidTransform(turn, np.array([5.0, -2.0, 7.0]))
    points = np.random.default_rng(0).normal(size=(4, 6, 3))
    back = target_from_source.inverse().apply(target_from_source.apply(points))
    assert_allclose(back, points, atol=1e-12)


def test_a_reflection_is_no_rigid_transform():
    with pytest.raises(DataError, match="determinant"):
        RigidTransform(np.diag([1.0, 1.0, -1.0]), np.zeros(3))


def test_textured_mesh_needs_uv_for_every_corner():
    with pytest.raises(DataError, match="wedge_uv"):
        textured_mesh(
            VERTICES, FACES, np.zeros((1, 2, 2)), np.zeros(1, int), (np.ones((2, 2)),), name="a"
        )


def test_coloured_mesh_knows_its_size():
    mesh = coloured_mesh(VERTICES, FACES, np.ones((1, 3)), name="a")
    assert mesh.size == pytest.approx(5.0)
    assert not mesh.has_texture


def _grid(status, deformed):
    shape = status.shape
    return CorrelationGrid(
        reference_px=np.zeros((*shape, 2)),
        deformed_px=deformed,
        gradient=np.zeros((*shape, 2, 2)),
        zncc=np.zeros(shape),
        iterations=np.zeros(shape, dtype=int),
        sigma_px=np.zeros((*shape, 2)),
        status=status,
        spacing=5,
        subset_size=21,
        kernel_seconds=0.1,
    )


def test_a_lost_point_may_not_carry_a_number():
    status = np.array([[0, PointStatus.OUTLIER]], dtype=np.uint8)
    with pytest.raises(DataError, match="NaN exactly"):
        _grid(status, np.zeros((1, 2, 2)))


def test_ok_points_are_counted():
    status = np.array([[0, PointStatus.OUTLIER]], dtype=np.uint8)
    deformed = np.array([[[1.0, 2.0], [np.nan, np.nan]]])
    assert _grid(status, deformed).ok_count == 1


def test_tracked_surface_checks_shapes_before_values():
    status = np.zeros((2, 3), dtype=np.uint8)
    good, bad = np.zeros((2, 3, 3)), np.zeros((3, 2, 3))
    with pytest.raises(DataError, match="deformed must be"):
        TrackedSurface(good, bad, good, good, np.zeros((2, 3)), status, np.zeros(2))
