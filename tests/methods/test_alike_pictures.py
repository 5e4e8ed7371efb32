"""Two originals made alike in light, from where the search for matches would begin."""

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.core.morphed import Morphed
from shapemorph.methods.alike_pictures import laid_over, made_alike
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


def alike(slope, light, painted=1.0):
    """Make a speckle and what became of it alike, and say what was done to the second."""
    pattern, pixels = painted * speckle(), np.stack([X, Y], axis=-1)
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
    spot = 0.6 + 0.6 * np.exp(-((X - 90) ** 2 + (Y - 140) ** 2) / 60**2)  # it moves along
    before, after = alike(STRETCHED, np.ones(SHAPE), painted=spot)
    assert after is before


def test_light_is_taken_off_an_original_that_is_stretched_too():
    light = 0.8 + 0.3 * X / WIDTH
    for slope in (np.eye(2), STRETCHED):
        before, after = alike(slope, light)
        even = (after.grey * light / before.grey)[before.mask]
        assert np.ptp(even) < 0.04 * even.mean()


def test_a_picture_laid_over_shows_each_pixel_where_a_warp_leads_and_masks_the_rest():
    image = GreyImage((0.3 + 0.001 * X + 0.0005 * Y).astype(np.float32), (X > 5) & (Y < HEIGHT - 9))
    none, shape = identity_warp((250, 333)), (250, 333)
    slope, shift = STRETCHED, np.array([7.25, -3.5])
    warp = Warp(none.coefficients @ slope.T + shift, none.origin, none.spacing)
    part = laid_over(image, warp, shape)
    places = np.stack(np.meshgrid(np.arange(333.0), np.arange(250.0)), axis=-1) @ slope.T + shift
    x, y = places[..., 0], places[..., 1]
    sure = (x > 7) & (x < WIDTH - 2) & (y > 1) & (y < HEIGHT - 11)
    lost = (x < 5) | (x > WIDTH) | (y < -1) | (y > HEIGHT - 8)
    assert part.mask[sure].all()
    assert not part.mask[lost].any()
    wanted = 0.3 + 0.001 * x + 0.0005 * y
    np.testing.assert_allclose(part.grey[sure], wanted[sure], atol=2e-5)
