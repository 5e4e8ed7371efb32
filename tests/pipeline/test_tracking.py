"""Frames that are followed from one to the next."""

import numpy as np

from shapemorph.config import CorrelateConfig, RunConfig
from shapemorph.core.image import GreyImage
from shapemorph.methods.warping import warp_points
from shapemorph.pipeline import tracking

SHAPE = (180, 220)
STEP = np.array([4.5, 1.5])  # px from frame to frame


def test_the_field_of_the_frame_before_is_where_the_next_search_begins(
    wave_pattern, pixel_grid, monkeypatch
):
    pattern, pixels, full = wave_pattern(), pixel_grid(SHAPE), np.ones(SHAPE, dtype=bool)
    frames = [GreyImage(pattern(pixels - k * STEP).astype("f4"), full) for k in range(4)]
    begun = []
    usual = tracking.correlate_from

    def watched(left, right, warps, config):
        begun.append(warp_points(warps[0], np.array([[70.0, 60.0]]))[0][0] - [70.0, 60.0])
        return usual(left, right, warps, config)

    def refuse(*_arguments):
        raise AssertionError

    monkeypatch.setattr(tracking, "correlate_from", watched)
    monkeypatch.setattr(tracking, "match_pictures", refuse)
    settings = CorrelateConfig(subset_size=21, spacing=10, reference="first", refinements=0)
    tracker = tracking.Tracker("first", frames[0], RunConfig(correlate=settings))
    for k, frame in enumerate(frames[1:], start=1):
        found = tracker.follow(str(k), frame)
        ok = found.grid.status == 0
        error = (found.grid.deformed_px - found.grid.reference_px)[ok] - k * STEP
        assert ok.mean() > 0.8
        assert np.median(np.abs(error)) < 0.01
    np.testing.assert_allclose(begun, [k * STEP for k in range(3)], atol=0.05)
