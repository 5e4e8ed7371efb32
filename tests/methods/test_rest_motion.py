"""Motion that subsets have not followed against motion that was made."""

import numpy as np
import pytest

from shapemorph.core.image import GreyImage
from shapemorph.methods.rest_motion import unfollowed_motion
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import (
    SubsetSettings,
    grid_points,
    identity_starts,
    match_points,
)

SHAPE = (150, 210)
SETTINGS = SubsetSettings(10, 1, 1e-3, 50, 0.5, 10.0)


def _rest(pattern, pixels, period, noise):
    """Errors of matches in waves of half a pixel along y, and the motion that is left."""

    def field(at):
        wave = 0.3 + 0 * at[..., 1]
        if period:  # on the right half only: the calmest fifth of the points tells the noise
            strength = 0.25 * (1 + np.tanh((at[..., 0] - 90) / 15))
            wave = strength * np.cos(2 * np.pi * at[..., 1] / period)
        return at + np.stack([0 * wave, wave], axis=-1)

    back = pixels.copy()
    for _ in range(60):
        back += pixels - field(back)
    rng, full = np.random.default_rng(1), np.ones(SHAPE, dtype=bool)
    first, second = (
        GreyImage((pattern(at) + rng.normal(0, noise, SHAPE)).astype("f4"), full)
        for at in (pixels, back)
    )
    source = prepare_reference(first, allowed=None, pad=SETTINGS.pad)
    target = prepare_deformed(second, pad=SETTINGS.pad)
    points = grid_points(full, spacing=6).points[3:-3, 3:-3]
    flat = points.reshape(-1, 2)
    found = match_points(source, target, flat, identity_starts(len(flat)), settings=SETTINGS)
    usable = (found.status == 0).reshape(points.shape[:2])
    warps = found.warps.reshape(*usable.shape, 12)
    rest = unfollowed_motion(source, target, points, warps, usable, radius=10)
    error = found.position.reshape(points.shape) - field(points.astype(np.float64))
    return error[usable], rest[usable]


@pytest.mark.parametrize(("period", "noise"), [(18, 0.0), (26, 0.0), (18, 2 / 255)])
def test_what_was_not_followed_is_told(period, noise, wave_pattern, pixel_grid):
    error, rest = _rest(wave_pattern(), pixel_grid(SHAPE), period, noise)
    wrong = np.abs(error[:, 1]) > 0.1
    assert wrong.mean() > 0.3
    told = np.abs(rest).max(axis=1) > 0.05
    assert told[wrong].mean() > 0.9
    assert (error[wrong & told, 1] * rest[wrong & told, 1] < 0).mean() > 0.9  # truth - estimate


@pytest.mark.parametrize("noise", [0.0, 3 / 255])
def test_what_was_followed_leaves_nothing(noise, wave_pattern, pixel_grid):
    _, rest = _rest(wave_pattern(), pixel_grid(SHAPE), 0, noise)
    assert (rest != 0).any(axis=1).mean() < 0.01
    assert np.isfinite(rest).all()


def test_points_without_a_match_have_no_value(wave_pattern, pixel_grid):
    grey = GreyImage(wave_pattern()(pixel_grid(SHAPE)).astype("f4"), np.ones(SHAPE, dtype=bool))
    source = prepare_reference(grey, allowed=None, pad=SETTINGS.pad)
    target = prepare_deformed(grey, pad=SETTINGS.pad)
    points = grid_points(grey.mask, spacing=10).points[2:-2, 2:-2]
    usable = np.ones(points.shape[:2], dtype=bool)
    usable[0, 0] = False
    warps = identity_starts(usable.size).reshape(*usable.shape, 12)
    rest = unfollowed_motion(source, target, points, warps, usable, radius=10)
    assert np.isnan(rest[0, 0]).all()
    assert (rest[usable] == 0).all()
