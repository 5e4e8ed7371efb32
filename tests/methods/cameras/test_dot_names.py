import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.methods.cameras.dot_names import identify
from shapemorph.methods.cameras.dots import Dots
from shapemorph.methods.synthetic.turntable import (
    dotted_cone,
    turntable_camera,
    turntable_poses,
)

CONE = dotted_cone(30.0)
CAMERA = turntable_camera(0.25)
POSES = turntable_poses(CAMERA, 12, 640.0)


def seen(pose):
    """Which dots face the camera clearly, and where and how large they are."""
    points = pose.apply(CONE.points)
    cosine = -(points * pose.rotate(CONE.normals)).sum(axis=1) / np.linalg.norm(points, axis=1)
    ids = np.flatnonzero(cosine > 0.3)
    return ids, CAMERA.project(points[ids]), 110.0 * cosine[ids]


@pytest.mark.parametrize("number", [0, 5, 9])
def test_a_cone_is_named_amid_the_speckle_of_the_part_that_it_carries(number):
    ids, pixels, areas = seen(POSES[number])
    rng = np.random.default_rng(number)
    middle = CAMERA.project(POSES[number].apply(np.zeros(3)))
    speckle = middle + rng.uniform(-1, 1, (60, 2)) * (90, 60)
    dots = Dots(np.concatenate([pixels, speckle]), np.concatenate([areas, np.full(60, 90.0)]))
    found, at = identify(CONE, dots, [])
    assert len(found) > 60
    place = {int(name): pixel for name, pixel in zip(ids, pixels, strict=True)}
    for name, pixel in zip(found, at, strict=True):
        np.testing.assert_allclose(pixel, place[int(name)])


def test_dots_without_rows_are_no_target():
    rng = np.random.default_rng(0)
    scattered = Dots(rng.uniform(0, 500, (40, 2)), np.full(40, 90.0))
    with pytest.raises(DataError, match=r"rows and columns|dots in a row"):
        identify(CONE, scattered, [])
