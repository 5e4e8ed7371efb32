from dataclasses import replace

import numpy as np
import pytest

from shapemorph.core.calibration import Calibration
from shapemorph.core.camera import Rig
from shapemorph.methods.cameras.bundle_model import LENS, PLACE
from shapemorph.methods.cameras.quality import baseline_sigma, drift_since


def test_the_noise_of_the_baseline_is_that_of_the_translation_along_it(stereo_pair):
    along = np.array([0.6, 0.0, 0.8])
    left, right = stereo_pair
    right = right.placed(replace(right.pose, translation=200 * along))
    unknowns = 2 * (LENS + PLACE)
    covariance = 100.0 * np.eye(unknowns)  # of all else: it must not count
    covariance[-3:, -3:] = np.diag([0.03, 0.5, 0.04]) ** 2
    found = Calibration(Rig((left, right), ("left", "right")), covariance=covariance)
    assert baseline_sigma(found, 1) == pytest.approx(np.hypot(0.6 * 0.03, 0.8 * 0.04), rel=1e-12)


def test_without_sightings_no_drift_is_told(stereo_pair):
    rig = Rig(stereo_pair, ("left", "right"))
    assert drift_since(Calibration(rig), rig) is None
