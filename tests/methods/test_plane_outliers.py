import numpy as np

from shapemorph.methods.plane_outliers import near_plane


def test_pairs_far_from_the_plane_through_dv_are_outliers():
    rng = np.random.default_rng(0)
    reference = rng.uniform(0, 500, (200, 2))
    parallax = rng.uniform(-40, 40, 200)
    dv = 2.0 + 0.01 * reference[:, 0] - 0.02 * reference[:, 1] + rng.normal(0, 0.3, 200)
    deformed = reference + np.column_stack([parallax, dv])
    deformed[::10, 1] += rng.choice([-1, 1], 20) * rng.uniform(8, 60, 20)
    expected = np.ones(200, bool)
    expected[::10] = False
    np.testing.assert_array_equal(near_plane(reference, deformed, least_px=1.5), expected)
