"""Grids of points, threads, partial subsets."""

import numba
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import (
    SubsetSettings,
    grid_points,
    identity_starts,
    judge_zncc,
    match_points,
)
from shapemorph.methods.threads import kernel_threads, run_blocks


def test_points_are_whole_multiples_of_the_spacing_over_the_mask():
    mask = np.zeros((40, 50), dtype=bool)
    mask[7:31, 12:40] = True
    mask[20, 25] = False
    grid = grid_points(mask, spacing=5)
    assert_array_equal(grid.points[0, :, 0], [15, 20, 25, 30, 35])
    assert_array_equal(grid.points[:, 0, 1], [10, 15, 20, 25, 30])
    assert not grid.inside[2, 2]
    assert grid.inside.sum() == 24


def test_an_empty_mask_has_no_points():
    assert grid_points(np.zeros((9, 9), dtype=bool), spacing=3).points.shape == (0, 0, 2)


def test_low_zncc_is_told_and_nothing_else_changes():
    status = np.array([0, 0, 0, 5], dtype=np.uint8)
    zncc = np.array([0.9, 0.3, np.nan, 0.1])
    judged = judge_zncc(status, zncc, min_zncc=0.7)
    assert_array_equal(judged, [0, PointStatus.LOW_ZNCC, PointStatus.LOW_ZNCC, 5])


def test_a_match_far_below_the_usual_is_low_too():
    zncc = np.concatenate([np.full(50, 0.999), [0.9, 0.96]])
    judged = judge_zncc(np.zeros(52, dtype=np.uint8), zncc, min_zncc=0.7)
    assert_array_equal(np.flatnonzero(judged), [50])
    noisy = judge_zncc(np.zeros(52, dtype=np.uint8), zncc - 0.02, min_zncc=0.7)
    assert not noisy.any()


def _match(threads, wave_pattern, pixel_grid):
    shape = (110, 150)
    pattern, pixels = wave_pattern(), pixel_grid(shape)
    rng = np.random.default_rng(0)
    noise = rng.normal(0, 0.01, (2, *shape))
    full = np.ones(shape, dtype=bool)
    settings = SubsetSettings(7, 1, 1e-3, 30, 0.5, 7.0)
    pictures = pattern(pixels) + noise[0], pattern(pixels * 0.99 + 0.7) + noise[1]
    reference = prepare_reference(
        GreyImage(pictures[0].astype("f4"), full), allowed=None, pad=settings.pad
    )
    deformed = prepare_deformed(GreyImage(pictures[1].astype("f4"), full), pad=settings.pad)
    points = grid_points(full, spacing=3).points.reshape(-1, 2)
    with kernel_threads(threads):
        return match_points(
            reference, deformed, points, identity_starts(len(points)), settings=settings
        )


def test_the_result_does_not_depend_on_the_number_of_threads(wave_pattern, pixel_grid):
    one, two = (_match(threads, wave_pattern, pixel_grid) for threads in (1, 2))
    for name in ("warps", "zncc", "iterations", "status"):
        assert_array_equal(getattr(one, name), getattr(two, name))
    assert (one.status == PointStatus.OK).mean() > 0.8


def _fail_with_one_thread():
    with kernel_threads(1):
        assert numba.get_num_threads() == 1
        raise RuntimeError


def test_the_number_of_threads_is_restored_even_after_an_error():
    before = numba.get_num_threads()
    with pytest.raises(RuntimeError):
        _fail_with_one_thread()
    assert numba.get_num_threads() == before


@pytest.mark.parametrize("threads", [1, 2])
def test_every_item_is_in_one_block(threads):
    seen = np.zeros(23, dtype=int)

    def work(first, last):
        seen[first:last] += 1

    with kernel_threads(threads):
        run_blocks(work, 23, block=5)
    assert_array_equal(seen, 1)


def test_an_error_in_a_block_is_not_swallowed():
    def work(_first, _last):
        raise ZeroDivisionError

    with kernel_threads(2), pytest.raises(ZeroDivisionError):
        run_blocks(work, 10, block=1)


def test_a_pattern_that_is_faint_along_one_direction_settles_all_the_same(pixel_grid):
    rng = np.random.default_rng(5)
    x, y = np.moveaxis(pixel_grid((160, 200)), -1, 0)

    def picture(x, y):
        grey = 0.5 + 0.3 * np.sin(2 * np.pi * x / 7.3) * (1 + 0.2 * np.sin(x / 17))
        grey = grey + 0.008 * np.sin(2 * np.pi * y / 9) + 0.01 * rng.normal(size=x.shape)
        return GreyImage(grey.astype(np.float32), np.ones(x.shape, dtype=bool))

    before, after = picture(x, y), picture(x - 0.3, y - 0.4)
    settings = SubsetSettings(15, 1, 1e-3, 30, 0.6, 20.0)
    points = np.stack(np.meshgrid(np.arange(40, 160, 10), np.arange(40, 120, 10)), -1)
    points = points.reshape(-1, 2)
    found = match_points(
        prepare_reference(before, allowed=None, pad=20),
        prepare_deformed(after, pad=20),
        points,
        identity_starts(len(points)),
        settings=settings,
    )
    assert (found.status == PointStatus.OK).all()  # noise in the gradients shortens every step
    assert found.iterations.mean() < 15
    off = found.position - points - [0.3, 0.4]
    faint = 0.01 * np.sqrt(2) / (31 * 0.008 * 2 * np.pi / 9 / np.sqrt(2))  # sigma without its noise
    assert np.abs(off[:, 0]).max() < 0.01
    assert off[:, 1].std() < 3 * faint
    assert abs(off[:, 1].mean()) < faint
