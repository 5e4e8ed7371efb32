import numpy as np
from numpy.testing import assert_allclose

from shapemorph.methods.synthetic.planar import (
    Exposure,
    inverse_at,
    planar_speckle,
    take_picture,
)

DARK = Exposure(gain=0.5, offset=0.1, slope=0.2, noise=0.0, seed=0)


def everywhere(points):
    return np.ones(points.shape[:-1], bool)


def test_speckle_belongs_to_the_material():
    speckle = planar_speckle(diameter=6.0, seed=1)

    def moved(points):
        return points - np.array([13.0, 4.0])

    plain = Exposure(gain=1, offset=0, slope=0, noise=0, seed=0)
    still = take_picture(speckle, (40, 60), plain, material_at=lambda p: p, inside=everywhere)
    shifted = take_picture(speckle, (50, 80), plain, material_at=moved, inside=everywhere)
    assert_allclose(shifted.grey[4:44, 13:73], still.grey)


def test_light_changes_contrast_and_adds_a_slope():
    speckle = planar_speckle(diameter=6.0, seed=1)
    plain = Exposure(gain=1, offset=0, slope=0, noise=0, seed=0)
    bright, dark = (
        take_picture(speckle, (300, 400), light, material_at=lambda p: p, inside=everywhere).grey
        for light in (plain, DARK)
    )
    inner = (bright > 0.05) & (bright < 0.95)  # not clipped
    slope = 0.2 * (np.mgrid[:300, :400][1] / 400 - 0.5)
    expected = 0.5 + 0.5 * (bright - 0.5) + 0.1 + slope
    assert_allclose(dark[inner], expected[inner], atol=1.1 / 255)  # two roundings


def test_outside_the_specimen_is_masked():
    picture = take_picture(
        planar_speckle(diameter=6.0, seed=1),
        (30, 40),
        DARK,
        material_at=lambda p: p,
        inside=lambda p: p[..., 0] < 25,
    )
    assert picture.mask.sum() == 30 * 25
    assert not picture.grey[:, 25:].any()


def test_inverse_finds_where_material_is_seen():
    def material_at(points):
        return points + 3 * np.sin(points[..., ::-1] / 20)

    pixels = np.random.default_rng(0).uniform(0, 100, (20, 2))
    found = inverse_at(material_at, material_at(pixels), pixels + 1.0)
    assert_allclose(found, pixels, atol=1e-7)
