"""What comes out depends on the pictures, not on the law that was begun with."""

import numpy as np
import pytest

from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.methods.laws.settling import settle_warp
from shapemorph.methods.warp_fit import fit_warp
from shapemorph.methods.warping import warp_points

SHAPE, BIG = (230, 300), (330, 410)
CENTRE, THERE = np.array([140.0, 120.0]), np.array([195.0, 170.0])
NOTHING = (np.zeros((0, 2)), np.zeros((0, 2)))


def _truth(points, factor=1.0):
    """Radial map: magnification 1.35 at the centre, 1.1 and less at the corners."""
    away = points - CENTRE
    square = np.sum(away**2, axis=-1, keepdims=True)
    return THERE + factor * away * (1.1 + 0.25 / (1 + square / 90.0**2))


def _undone(targets):
    source = CENTRE + (targets - THERE) / 1.2
    for _ in range(60):
        source = source - (_truth(source) - targets) / 1.3
    return source


def _grid(spacing=12.0):
    columns, rows = np.meshgrid(
        np.arange(0, SHAPE[1] + spacing, spacing), np.arange(0, SHAPE[0] + spacing, spacing)
    )
    return np.stack([columns, rows], axis=-1).reshape(-1, 2)


def _law(targets):
    extent = (np.full(2, -20.0), np.array(SHAPE[::-1]) + 20.0)
    return fit_warp(_grid(), targets, extent=extent, spacing=24.0, smoothing=1e-6)


@pytest.fixture(scope="module")
def pictures(wave_pattern, pixel_grid):
    pattern = wave_pattern(5.0)
    rng = np.random.default_rng(0)

    def picture(material):
        grey = pattern(material) + rng.normal(scale=0.005, size=material.shape[:-1])
        return GreyImage(grey.astype("f4"), np.ones(grey.shape, dtype=bool))

    return picture(pixel_grid(SHAPE)), picture(_undone(pixel_grid(BIG)))


def _errors(warp):
    inner = _grid()
    inner = inner[(inner > 12).all(axis=1) & (inner < np.array(SHAPE[::-1]) - 12).all(axis=1)]
    inside = (_truth(inner) > 15).all(axis=1) & (_truth(inner) < np.array(BIG[::-1]) - 15).all(1)
    inner = inner[inside]
    return np.linalg.norm(warp_points(warp, inner)[0] - _truth(inner), axis=1)


@pytest.mark.parametrize("factor", [1.0, 0.9, 1.1])
def test_a_law_ten_percent_wrong_leads_to_the_same_field(pictures, factor):
    law = _law(_truth(_grid(), factor))
    before = _errors(law)
    found = settle_warp(*pictures, law, NOTHING)
    if factor != 1.0:
        assert before.max() > 15
    # it stops when it moves by less than 0.1 px; subsets follow ten times as much
    assert np.median(_errors(found.warp)) < 0.15
    assert np.percentile(_errors(found.warp), 98) < 0.9
    assert found.added == 0


def test_a_law_that_is_off_everywhere_is_found_by_the_wide_search(pictures):
    found = settle_warp(*pictures, _law(_truth(_grid()) + np.array([22.0, -14.0])), NOTHING)
    assert np.median(_errors(found.warp)) < 0.15
    assert found.added == 0


def test_matches_take_over_where_a_law_leads_nowhere(pictures):
    law = _law(_grid()[:, ::-1] * 3.0 + 40)
    rng = np.random.default_rng(1)
    known = rng.uniform(20, np.array(SHAPE[::-1]) - 20, (150, 2))
    found = settle_warp(*pictures, law, (known, _truth(known)))
    assert found.added > 100
    assert np.median(_errors(found.warp)) < 0.15


def test_a_law_that_leads_nowhere_without_matches_is_refused(pictures):
    with pytest.raises(StageError, match=r"leads nowhere: only 0%"):
        settle_warp(*pictures, _law(_grid()[:, ::-1] * 3.0 + 40), NOTHING)


def test_blank_pictures_are_refused():
    blank = GreyImage(np.zeros((90, 120), "f4"), np.ones((90, 120), dtype=bool))
    with pytest.raises(StageError, match="blank"):
        settle_warp(blank, blank, identity_warp((90, 120)), NOTHING)
