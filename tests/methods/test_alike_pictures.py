"""Two originals made alike in light, from where the search for matches would begin."""

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.core.morphed import Morphed
from shapemorph.methods.alike_pictures import made_alike
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.methods.near_start import NearStart
from shapemorph.methods.warping import warp_points

SHAPE = HEIGHT, WIDTH = 240, 320
Y, X = np.mgrid[:HEIGHT, :WIDTH].astype(np.float64)
STRETCHED = np.array([[1.12, 0.0], [0.05, 0.95]])


def speckle():
    noise = gaussian_filter(np.random.default_rng(4).normal(size=SHAPE), 2.0)
    return 0.5 + 0.15 * noise / noise.std()


def seen_at(grey, places):
    """What a picture shows at places (..., 2); beyond its rim it goes on evenly."""
    shown = map_coordinates(grey, [places[..., 1], places[..., 0]], order=1, mode="nearest")
    inside = ((places >= 0) & (places <= [WIDTH - 1, HEIGHT - 1])).all(axis=-1)
    return GreyImage(shown.astype(np.float32), inside)


def alike(slope, light):
    """Make a speckle and what became of it alike, and say what was done to the second."""
    pattern, pixels = speckle(), np.stack([X, Y], axis=-1)
    deformed = seen_at(pattern, pixels @ np.linalg.inv(slope).T)
    deformed = GreyImage((light * deformed.grey).astype(np.float32), deformed.mask)

    def remorph(warp):
        targets, _slope = warp_points(warp, pixels.reshape(-1, 2))
        return seen_at(deformed.grey, targets.reshape(pixels.shape))

    none = identity_warp(SHAPE)
    start = NearStart(Warp(none.coefficients @ slope.T, none.origin, none.spacing), None, None)
    reference = GreyImage(pattern.astype(np.float32), np.ones(SHAPE, dtype=bool))
    given = Morphed(deformed, none)
    _reference, _remorph, made = made_alike(reference, remorph, given, start)
    return given.image, made.image


def test_a_stretch_between_originals_is_not_taken_for_light():
    before, after = alike(STRETCHED, np.ones(SHAPE))
    assert after is before


def test_light_is_taken_off_an_original_that_is_stretched_too():
    light = 0.8 + 0.3 * X / WIDTH
    for slope in (np.eye(2), STRETCHED):
        before, after = alike(slope, light)
        even = (after.grey * light / before.grey)[before.mask]
        assert np.ptp(even) < 0.04 * even.mean()
