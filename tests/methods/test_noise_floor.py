"""Noise floor of measurements whose noise is known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.core.errors import DataError
from shapemorph.core.measurement import Measurement
from shapemorph.methods.noise_floor import noise_figures

BIAS, SPREAD = np.array([0.02, -0.05, 0.3]), np.array([0.01, 0.02, 0.04])
POINTS = 4000


def _measurement(turn, lost=0):
    """A wavy sheet scanned twice, with noise and bias along x, y, z of the reference."""
    rng = np.random.default_rng(11)
    flat = rng.uniform(-40, 60, (POINTS, 2))
    reference = np.column_stack([flat, 6 * np.sin(flat[:, 0] / 15) + 5 * np.cos(flat[:, 1] / 9)])
    moved = reference + BIAS + rng.normal(size=reference.shape) * SPREAD
    deformed = turn.apply(moved) + np.array([0.0, 0.0, 200.0 * (turn.magnitude() > 0)])
    status = np.zeros(POINTS, dtype=np.uint8)
    status[:lost], deformed[:lost] = 6, np.nan
    arrays = {
        "status": status,
        "deformed_position": deformed,
        "sigma_displacement": np.full(POINTS, np.sqrt(np.mean(SPREAD**2))),
        "E1": rng.normal(0.001, 0.002, POINTS),
        "E2": rng.normal(-0.001, 0.002, POINTS),
        "sigma_E1": np.full(POINTS, 0.001),
        "sigma_E2": np.full(POINTS, 0.002),
    }
    return Measurement(reference, np.zeros((0, 4), dtype=np.int64), arrays)


def test_in_one_frame_the_means_are_the_biases():
    found = noise_figures(_measurement(Rotation.identity()), remove_motion=False)
    for name, bias, spread in zip("uvw", BIAS, SPREAD, strict=True):
        assert found[name]["mean"] == pytest.approx(bias, abs=5 * spread / np.sqrt(POINTS))
        assert found[name]["std"] == pytest.approx(spread, rel=0.06)  # 1/sqrt(2 N) is 1.1 %
        assert found[name]["robust_std"] == pytest.approx(spread, rel=0.1)


def test_a_motion_between_the_scans_leaves_the_noise_along_the_axes_of_the_reference():
    turn = Rotation.from_euler("xyz", [0.7, -0.4, 1.1])
    found = noise_figures(_measurement(turn), remove_motion=True)
    for name, spread in zip("uvw", SPREAD, strict=True):
        assert found[name]["mean"] == pytest.approx(0, abs=1e-9)
        assert found[name]["std"] == pytest.approx(spread, rel=0.06)


def test_the_ratio_compares_with_what_was_predicted():
    found = noise_figures(_measurement(Rotation.identity()), remove_motion=False)
    assert found["E1"]["ratio"] == pytest.approx(2.0, rel=0.06)
    assert found["E2"]["ratio"] == pytest.approx(1.0, rel=0.06)
    assert found["E1"]["mean"] == pytest.approx(0.001, abs=2e-4)


def test_lost_points_do_not_count():
    found = noise_figures(_measurement(Rotation.identity(), lost=1000), remove_motion=True)
    assert found["points"] == POINTS - 1000
    assert np.isfinite(found["w"]["std"])


def test_nothing_measured_is_an_error():
    with pytest.raises(DataError, match="at least 3 OK points, got 0"):
        noise_figures(_measurement(Rotation.identity(), lost=POINTS), remove_motion=True)
