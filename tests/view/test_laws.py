"""The figure of morph laws, on the analytic run."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose

from shapemorph.core.laws import LawSpread
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.view.laws import binned, laws_figure, radial_view


def _spread(results):
    shape = results.pair.reference.calibrated.image.shape
    warps = (results.matches.forward, identity_warp(shape))
    two = np.array([0.0, 0.002])
    return LawSpread(("warp", "identity"), warps, two, np.array([9, 9]), two, two, {})


def test_the_figure_shows_profiles_radii_and_differences(results):
    spread = _spread(results)
    figure = laws_figure(replace(results, spread=spread), spread)
    profiles, radii, differences = figure.axes
    assert len(profiles.lines) == 18  # sixteen, their mean, their name
    assert [text.get_text() for text in radii.get_legend().get_texts()] == [
        "measured points", "warp", "identity",
    ]  # fmt: skip
    assert len(differences.lines) == 3
    assert any("2 um rms" in text.get_text() for text in figure.texts)


def test_radii_are_those_of_the_measured_points(results):
    view = radial_view(results)
    assert len(view.radius) == results.grid.ok_count
    assert view.radius.min() < 3.0
    assert np.isfinite(view.out).all()
    assert np.isfinite(view.up).all()
    assert np.median(view.up) < 0  # the pole is on top


def test_bins_without_values_are_empty():
    place, middle = binned(np.array([0.0, 1.0, 60.0]), np.array([2.0, np.nan, 4.0]))
    assert_allclose([place[0], place[-1]], [0.5, 59.5])
    assert middle[0] == 2.0
    assert np.isnan(middle[1])
    assert middle[-1] == 4.0
