import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.methods.rigid_search import largest_rigid_set

TURN = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()
NOISE = 0.005


def disc(seed=12, count=2500):
    rng = np.random.default_rng(seed)
    radius, angle = 35 * np.sqrt(rng.random(count)), rng.random(count) * 2 * np.pi
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * radius], axis=1)


def search(source, target, softness, **changes):
    options = {"noise": NOISE, "smallest_share": 0.05, "seed": 0} | changes
    return largest_rigid_set(source, target, softness, **options)


def test_clamped_flange_of_a_bulge_is_found_and_nothing_else():
    source = disc()
    radius = np.hypot(source[:, 0], source[:, 1])
    height = np.where(radius < 27, 20 * (1 + np.cos(np.pi * radius / 27)) / 2, 0)
    moved = source + height[:, None] * [0, 0, 1]
    rng = np.random.default_rng(13)
    target = moved @ TURN.T + [5, 6, 7] + rng.normal(0, NOISE, source.shape)
    found = search(source, target, np.where(radius < 27, 0.5, 0) + rng.random(len(source)) * 0.01)
    assert found is not None
    np.testing.assert_allclose(found.transform.rotation, TURN, atol=1e-4)
    assert radius[found.members].min() > 26
    assert found.members[radius > 27].mean() > 0.97


def test_flange_is_found_even_if_the_hint_says_nothing():
    source = disc()
    radius = np.hypot(source[:, 0], source[:, 1])
    moved = source + np.where(radius < 20, 0.05 * (20 - radius) ** 2, 0)[:, None] * [0, 0, 1]
    found = search(source, moved @ TURN.T, np.full(len(source), np.nan))
    assert found is not None
    np.testing.assert_allclose(found.transform.rotation, TURN, atol=1e-5)


def test_stretched_body_has_no_rigid_part_however_small_the_stretch():
    source = disc()
    rng = np.random.default_rng(14)
    for stretch in (1.5, 1.05, 1.002):
        target = source * stretch + rng.normal(0, NOISE, source.shape)
        assert search(source, target, rng.random(len(source))) is None


def test_rigid_body_with_gross_errors_keeps_all_its_sound_points():
    source = disc()
    rng = np.random.default_rng(15)
    target = source @ TURN.T + rng.normal(0, NOISE, source.shape)
    target[:250] += rng.normal(0, 3, (250, 3))
    found = search(source, target, rng.random(len(source)))
    assert found is not None
    assert found.members[250:].mean() > 0.98
    assert found.members[:250].mean() < 0.05


def test_same_seed_gives_the_same_bits():
    source = disc()
    rng = np.random.default_rng(16)
    target = source @ TURN.T + rng.normal(0, NOISE, source.shape)
    first, second = (search(source, target, np.zeros(len(source))) for _ in range(2))
    np.testing.assert_array_equal(first.transform.rotation, second.transform.rotation)
    np.testing.assert_array_equal(first.members, second.members)


def test_two_points_are_no_body():
    assert search(disc()[:2], disc()[:2], np.zeros(2)) is None
