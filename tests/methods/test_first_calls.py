"""What is compiled beside a first run: the very loops that the run will call."""

import numba
import numpy as np
import pytest

from shapemorph.config import CorrelateConfig
from shapemorph.core.image import GreyImage
from shapemorph.core.morphed import Morphed
from shapemorph.kernels import components, neighbours, subset_noise, subset_rest, subset_samples
from shapemorph.methods import first_calls
from shapemorph.methods.grid_windows import connected_windows
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.stages.correlate import correlate

LOOPS = (
    *(subset_noise.residual_products, subset_noise.solution_covariance),
    *(subset_samples.sample_subsets, subset_samples.weigh_subsets, subset_rest.rest_motion),
    *(neighbours.predict_from_neighbours, components.connect),
)


def test_the_loops_are_called_as_a_correlation_calls_them(wave_pattern, pixel_grid):
    grey = wave_pattern()(pixel_grid((90, 110))).astype(np.float32)
    picture = GreyImage(grey, np.ones(grey.shape, dtype=bool))
    section = CorrelateConfig(subset_size=21, spacing=8)
    morphed = Morphed(picture, identity_warp(grey.shape))
    grid = correlate(picture, lambda _warp: picture, morphed, section, None)
    for _windows in connected_windows(grid.status == 0, window=5, chunk=1000):
        pass
    before = [set(loop.signatures) for loop in LOOPS]
    first_calls.call_late_loops()
    assert all(before)
    assert [set(loop.signatures) for loop in LOOPS] == before


@pytest.mark.parametrize(("left", "started"), [("", 1), ("subset_noise.f-1.py311.nbi", 0)])
def test_a_process_is_started_only_where_nothing_was_compiled(tmp_path, monkeypatch, left, started):
    calls = []

    class Beside:
        def __init__(self, command, **_streams):
            calls.append(command)

        def kill(self):
            calls.append("killed")

        def wait(self):
            calls.append("gone")

    monkeypatch.setattr(first_calls.subprocess, "Popen", Beside)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", 2)
    (tmp_path / "kernels").mkdir()
    if left:
        (tmp_path / "kernels" / left).touch()
    with first_calls.late_loops_compiled():
        assert len(calls) == started
    assert calls[1:] == ["killed", "gone"] * started
