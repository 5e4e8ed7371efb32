import numpy as np
import pytest

from shapemorph.methods.consistency import consistent_pairs, frame_support

RNG = np.random.default_rng(0)
SOURCE = RNG.uniform([0, 0], [600, 400], (900, 2))
MAP = np.array([[1.4, -0.5], [0.6, 0.9]])
WILD = np.arange(900) % 5 == 0


def bent(points):
    return points @ MAP.T + 0.0004 * (points - 300) ** 2


def with_outliers(target, spread):
    spoilt = target.copy()
    spoilt[WILD] += RNG.uniform(8, spread, (WILD.sum(), 2)) * RNG.choice([-1, 1], (WILD.sum(), 2))
    return spoilt


def test_pairs_whose_frames_agree_support_each_other():
    target = with_outliers(bent(SOURCE), 300)
    frames = np.tile(MAP, (900, 1, 1)) + RNG.normal(0, 0.1, (900, 2, 2))
    support = frame_support(SOURCE, target, frames, neighbours=16, relative=0.25, absolute=4.0)
    assert np.median(support[~WILD]) > 0.6
    assert (support[WILD] < 0.25).mean() > 0.95


def test_pairs_at_random_find_no_support():
    target = RNG.uniform([0, 0], [600, 400], (900, 2))
    angle = RNG.uniform(0, 2 * np.pi, 900)
    frames = np.stack(
        [
            np.stack([np.cos(angle), -np.sin(angle)], -1),
            np.stack([np.sin(angle), np.cos(angle)], -1),
        ],
        -2,
    )
    support = frame_support(SOURCE, target, frames, neighbours=16, relative=0.25, absolute=4.0)
    assert support.max() < 0.25


def test_few_pairs_support_nobody():
    frames = np.tile(np.eye(2), (3, 1, 1))
    few = SOURCE[:3]
    assert not frame_support(few, few, frames, neighbours=16, relative=0.25, absolute=4.0).any()


def test_outliers_leave_and_all_others_stay():
    target = with_outliers(bent(SOURCE) + RNG.normal(0, 0.3, SOURCE.shape), 60)
    good = consistent_pairs(SOURCE, target, neighbours=24, tolerance=2.0, cap=4.0)
    assert not good[WILD].any()
    assert good[~WILD].mean() > 0.995


@pytest.mark.parametrize("angle", [0.0, 0.6, 1.9])
def test_points_beside_a_kink_stay(angle):
    across = np.array([np.cos(angle), np.sin(angle)])
    beyond = np.maximum((SOURCE - [300, 200]) @ across, 0)
    target = SOURCE + 0.8 * beyond[:, None] * across
    good = consistent_pairs(SOURCE, target, neighbours=24, tolerance=0.5, cap=1.0)
    assert good.mean() > 0.98


def test_map_that_turns_the_picture_over_agrees_with_nobody():
    mirrored = SOURCE * [-1.0, 1.0]
    assert not consistent_pairs(SOURCE, mirrored, neighbours=24, tolerance=2.0, cap=4.0).any()


def test_handful_of_pairs_is_never_consistent():
    few = SOURCE[:12]
    assert not consistent_pairs(few, few, neighbours=24, tolerance=2.0, cap=4.0).any()
