"""Damage: where it is, what it hides, what it leaves alone."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.synthetic import DamageSpot
from shapemorph.methods.synthetic.damage import is_visible, place_damage, spoil, spot_distance
from shapemorph.methods.synthetic.shapes import material_map

KINDS = ("print", "glare", "lost_patch")


def _map(shape):
    return material_map(shape, size=70.0, offset=0.0, tilt=0.0)


@pytest.mark.parametrize("shape", ["bulge", "hole", "tube", "freeform"])
def test_spots_lie_inside_and_apart_and_the_print_at_the_pole(shape):
    mapped = _map(shape)
    spots = place_damage(mapped, KINDS, size=70.0, rng=np.random.default_rng(2))
    assert [spot.kind for spot in spots] == list(KINDS)
    assert_allclose(spots[0].centre, mapped.pole)
    for k, spot in enumerate(spots[1:], start=1):
        assert mapped.rim(spot.centre[None])[0] > spot.radius
        for other in spots[:k]:
            gap = spot_distance(mapped, spot.centre[None], other.centre)[0]
            assert gap > spot.radius + other.radius


@pytest.mark.parametrize("kind", KINDS)
def test_a_spot_changes_what_it_hides_and_little_else(kind):
    mapped = _map("dome")
    spot = DamageSpot(kind, np.array([5.0, -8.0]), 3.0)
    rng = np.random.default_rng(0)
    material = rng.uniform(-20, 20, (20000, 2))
    grey = rng.uniform(0.2, 0.8, len(material))
    change = np.abs(spoil(grey, material, mapped, (spot,)) - grey)
    hidden = ~is_visible(mapped, material, (spot,))
    assert hidden.sum() == pytest.approx(20000 * np.pi * 9 / 1600, rel=0.1)
    assert np.median(change[hidden]) > 0.05
    assert change[spot_distance(mapped, material, spot.centre) > 6.0].max() < 1e-3


def test_glare_saturates_and_a_lost_patch_is_bare():
    mapped = _map("dome")
    centre = np.array([[1.0, 2.0]])
    grey = np.array([0.1])
    for kind, low, high in (("glare", 1.0, 2.0), ("lost_patch", 0.55, 0.55), ("print", 0.08, 0.08)):
        found = spoil(grey, centre, mapped, (DamageSpot(kind, centre[0], 3.0),))
        assert low - 1e-12 <= found[0] <= high + 1e-12


def test_a_spot_reaches_across_the_seam_of_a_tube():
    mapped = _map("tube")
    near = np.array([[0.5, 30.0], [mapped.period - 0.5, 30.0], [0.5 * mapped.period, 30.0]])
    spot = DamageSpot("lost_patch", np.array([0.0, 30.0]), 2.0)
    assert list(is_visible(mapped, near, (spot,))) == [False, False, True]
