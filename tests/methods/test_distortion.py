import numpy as np
import pytest

from shapemorph.core.image import Chart
from shapemorph.methods.distortion import (
    chart_distortion,
    chart_handedness,
    local_scale,
    singular_values,
    weighted_quantile,
)

FACES = np.array([[0, 1, 2], [2, 1, 3]])
SPACE = np.array([[0.0, 0, 0], [2, 0, 0], [0.3, 1.5, 0], [2.2, 1.8, 0]])


def _turned(points):
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec([0.4, 1.0, -0.6]).apply(points) + np.array([3.0, 2.0, 1.0])


def test_singular_values_of_a_known_matrix():
    matrix = np.array([[2.0, 0.7], [-0.4, 1.1]])
    stretch = singular_values(_turned(SPACE), FACES, SPACE[:, :2] @ matrix.T)
    expected = np.linalg.svd(matrix, compute_uv=False)
    np.testing.assert_allclose(stretch.sigma_1, expected[0])
    np.testing.assert_allclose(stretch.sigma_2, expected[1])
    np.testing.assert_allclose(stretch.area, [1.5, 1.68])
    np.testing.assert_allclose(local_scale(stretch), np.sqrt(np.linalg.det(matrix)))


def test_a_flipped_triangle_has_a_negative_second_value():
    stretch = singular_values(SPACE, FACES, SPACE[:, :2] * [1, -3])
    np.testing.assert_allclose(stretch.sigma_1, 3)
    np.testing.assert_allclose(stretch.sigma_2, -1)
    assert stretch.flips == 2
    assert np.isnan(local_scale(stretch)).all()


def test_a_triangle_without_area_has_no_values():
    space = SPACE.copy()
    space[3] = 0.5 * (space[1] + space[2])
    stretch = singular_values(space, FACES, SPACE[:, :2])
    np.testing.assert_array_equal(np.isnan(stretch.sigma_1), [False, True])
    assert stretch.area[1] == 0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_most_of_the_area_decides_which_side_of_a_chart_is_up(sign):
    px = SPACE[:, :2] * [10, 10 * sign]
    chart = Chart(np.arange(4), FACES, np.arange(2), px, 10.0)
    assert chart_handedness(chart) == sign
    stretch = chart_distortion(SPACE, chart)
    np.testing.assert_allclose(stretch.sigma_2, 10)


def test_quantiles_count_by_weight_and_leave_out_the_unknown():
    values = np.array([5.0, np.nan, 1.0, 3.0])
    weights = np.array([1.0, 100.0, 6.0, 3.0])
    assert weighted_quantile(values, weights, 0.5) == 1.0
    assert weighted_quantile(values, weights, 0.85) == 3.0
    assert weighted_quantile(values, weights, 1.0) == 5.0
    assert np.isnan(weighted_quantile(values[:0], weights[:0], 0.5))
