"""Unrolled cylinders are isometric, however far they wind."""

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.methods.distortion import singular_values
from shapemorph.methods.parametrize.cylindrical import parametrise_cylindrical, unwrap_angle


def unroll(points, faces, centre=None, axis=None):
    return parametrise_cylindrical(points, faces, centre=centre, axis=axis, name="pipe.obj")


def assert_same_up_to_motion(found, wanted, atol):
    """In the plane: turned, moved, not mirrored."""
    found, wanted = found - found.mean(axis=0), wanted - wanted.mean(axis=0)
    left, _, right = np.linalg.svd(found.T @ wanted)
    turn = left @ right
    assert np.linalg.det(turn) > 0
    np.testing.assert_allclose(found @ turn, wanted, atol=atol)


@pytest.mark.parametrize("turn", [0.2, 2.0, 6.2, 11.0])
@pytest.mark.parametrize("scale", [1.2, 900.0])
def test_the_map_is_arc_and_height(pipe, anywhere, turn, scale):
    points, faces, angle, height = pipe(turn, pitch=0.5 if turn > 6.3 else 0.0)
    plane = unroll(anywhere(points, scale), faces)
    # the normals of facets lie across the axis up to the square of their angle, at random
    atol = 1e-5 if turn < 6.3 else 2e-3
    assert_same_up_to_motion(plane / scale, np.stack([angle, height], axis=1), atol)


def test_it_is_shown_from_outside_and_from_inside(pipe, anywhere):
    points, faces, _, _ = pipe(4.0)
    for side in (faces, faces[:, ::-1]):
        space = anywhere(points)
        assert singular_values(space, side, unroll(space, side)).flips == 0


def test_noise_and_a_flap_hardly_tilt_the_axis(pipe, anywhere):
    points, faces, angle, height = pipe(5.0, rows=41, cols=140)
    flap = height > 1.85
    points = points * np.where(flap, 1.0 + 0.8 * (height - 1.85), 1.0)[:, None] ** [1, 1, 0]
    plane = unroll(anywhere(points, noise=1e-3), faces)
    wanted = np.stack([angle, height], axis=1)
    assert_same_up_to_motion(plane[~flap], wanted[~flap], atol=0.02)


def test_a_flat_sheet_stays_as_it_is(pipe, anywhere):
    _, faces, angle, height = pipe(3.0)
    flat = np.stack([height, angle, 0 * angle], axis=1)
    plane = unroll(anywhere(flat), faces)
    assert_same_up_to_motion(plane, np.stack([angle, height], axis=1), atol=1e-5)


def test_a_given_axis_is_up(pipe):
    points, faces, angle, height = pipe(2.5)
    plane = unroll(points, faces, centre=np.array([0, 0, 5.0]), axis=np.array([0, 0, 3.0]))
    np.testing.assert_allclose(plane[:, 1], height, atol=1e-12)
    np.testing.assert_allclose(np.diff(plane[:, 0]), np.diff(angle), atol=1e-12)


def test_a_closed_tube_is_refused_with_advice(pipe, anywhere):
    points, faces, _, _ = pipe(2 * np.pi * 89 / 90)
    seam = np.arange(20) * 90
    bridge = [[seam + 89, seam, seam + 90], [seam + 89, seam + 90, seam + 179]]
    closed = np.concatenate([faces, *(np.stack(each, axis=1) for each in bridge)])
    with pytest.raises(DataError, match=r"pipe\.obj: .* closes around the axis.*auto"):
        unroll(anywhere(points), closed)


def test_the_angle_is_continued_through_the_mesh_not_by_its_value(pipe):
    _, faces, angle, _ = pipe(11.0)
    wrapped = np.angle(np.exp(1j * angle))
    found = unwrap_angle(wrapped, faces, name="x")
    np.testing.assert_allclose(found - found[0], angle - angle[0], atol=1e-9)
