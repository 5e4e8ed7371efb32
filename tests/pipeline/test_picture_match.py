"""Ways from two pictures to a grid."""

import numpy as np
from scipy.ndimage import gaussian_filter

from shapemorph.config import CorrelateConfig, RunConfig
from shapemorph.core.image import GreyImage
from shapemorph.methods.synthetic.planar import planar_speckle
from shapemorph.pipeline import picture_match
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import follow_pictures, picture_law_inputs


def test_propagation_matches_no_features(wave_pattern, pixel_grid, monkeypatch):
    def refuse(*_arguments):
        raise AssertionError

    for name in ("match_pictures", "morph_by_law", "_near_start"):
        monkeypatch.setattr(picture_match, name, refuse)
    pattern, pixels, full = wave_pattern(), pixel_grid((90, 110)), np.ones((90, 110), dtype=bool)
    left, right = (
        GreyImage(pattern(pixels - shift).astype("f4"), full) for shift in ([0, 0], [7.4, -6.2])
    )
    config = RunConfig(correlate=CorrelateConfig(seeds="propagate", subset_size=15, spacing=8))
    inputs = picture_law_inputs(config)
    found = follow_pictures(left, right, config, inputs, Clock(lambda _: None))
    assert found.matches is None
    ok = found.grid.status == 0
    assert ok.sum() > 60
    error = (found.grid.deformed_px - found.grid.reference_px)[ok] - [7.4, -6.2]
    assert np.abs(error).max() < 0.1  # of subsets that the rim cuts
    assert np.median(np.abs(error)) < 0.003


def test_near_pictures_of_which_one_is_out_of_focus_are_seen_alike():
    cols, rows = np.meshgrid(np.arange(320.0), np.arange(320.0))
    at, speckle = np.stack([cols, rows], axis=-1), planar_speckle(diameter=5.0, seed=1)
    full, noise = np.ones((320, 320), dtype=bool), np.random.default_rng(0)
    greys = [0.5 + 0.15 * speckle.at(at - by) for by in (0.0, np.array([1.3, -0.7]))]
    greys[1] = gaussian_filter(greys[1], 1.6)
    left, right = (
        GreyImage((grey + noise.normal(0, 2 / 255, grey.shape)).astype("f4"), full)
        for grey in greys
    )
    config = RunConfig()
    found = follow_pictures(left, right, config, picture_law_inputs(config), Clock(lambda _: None))
    assert found.matches is None  # a near start
    inner = (np.abs(found.grid.reference_px - 160.0) < 130.0).all(axis=-1)
    assert np.median(found.grid.zncc[inner]) > 0.98
    error = (found.grid.deformed_px - found.grid.reference_px)[inner] - [1.3, -0.7]
    assert np.sqrt((error**2).mean()) < 0.035


def test_a_field_that_bends_within_subsets_takes_smaller_ones(wave_pattern, pixel_grid):
    shape = (150, 210)
    pattern, pixels, full = wave_pattern(7.0), pixel_grid(shape), np.ones(shape, dtype=bool)

    def field(at):
        strength = 0.25 * (1 + np.tanh((at[..., 0] - 90) / 15))
        wave = strength * np.cos(2 * np.pi * at[..., 1] / 24)
        return at + np.stack([0 * wave, wave], axis=-1)

    back = pixels.copy()
    for _ in range(60):
        back += pixels - field(back)
    left, right = (GreyImage(pattern(at).astype("f4"), full) for at in (pixels, back))
    found = {}
    for size in (None, 27):
        config = RunConfig(correlate=CorrelateConfig(subset_size=size, spacing=6, order=2))
        inputs = picture_law_inputs(config)
        grid = follow_pictures(left, right, config, inputs, Clock(lambda _: None)).grid
        error = np.abs(grid.deformed_px - field(grid.reference_px)).max(axis=-1)
        found[size] = grid, np.nanmean(error < 0.1)
    assert found[None][0].subset_size < 22
    assert found[27][0].subset_size == 27
    assert found[None][1] > found[27][1] + 0.05


def test_a_gradient_of_light_across_the_picture_turns_no_point_wrong(wave_pattern, pixel_grid):
    shape = (150, 210)
    pattern, pixels, full = wave_pattern(), pixel_grid(shape), np.ones(shape, dtype=bool)
    rng, shift = np.random.default_rng(2), np.array([0.4, -0.3])
    gain, offset = 0.6 + 5e-4 * pixels[..., 0], 3e-4 * pixels[..., 1]  # half a range in 1000 px
    greys = [pattern(pixels), gain * pattern(pixels - shift) + offset]
    left, right = (
        GreyImage((grey + rng.normal(0, 2 / 255, shape)).astype("f4"), full) for grey in greys
    )
    config = RunConfig(correlate=CorrelateConfig(subset_size=21, spacing=6))
    found = follow_pictures(left, right, config, picture_law_inputs(config), Clock(lambda _: None))
    assert found.matches is None
    ok = found.grid.status == 0
    assert ok.mean() > 0.97
    error = np.abs(found.grid.deformed_px - found.grid.reference_px - shift).max(axis=-1)
    assert (error[ok] > 0.1).mean() < 0.003  # beside the rim, where half a subset is seen
    whole = ok & ((found.grid.reference_px > 12) & (found.grid.reference_px < [197, 137])).all(-1)
    assert error[whole].max() < 0.1
