"""Ways from two pictures to a grid."""

import numpy as np

from shapemorph.config import CorrelateConfig, RunConfig
from shapemorph.core.image import GreyImage
from shapemorph.pipeline import picture_match
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import follow_pictures, picture_law_inputs


def test_propagation_matches_no_features(wave_pattern, pixel_grid, monkeypatch):
    def refuse(*_arguments):
        raise AssertionError

    for name in ("match_pictures", "morph_by_law", "_near_warp"):
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
