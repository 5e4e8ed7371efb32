"""The figure of morph laws, on the analytic run."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

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


def test_profiles_are_about_the_axis_of_the_shape_wherever_it_lies(results):
    ok = (results.grid.status == 0) & (results.tracked.status == 0)
    first = radial_view(results)
    out, up = 1.3 * first.radius, -((first.radius / 10) ** 2)
    dome = np.stack([out * np.cos(first.angle), out * np.sin(first.angle), up], axis=-1)
    deformed = np.full_like(results.tracked.deformed, np.nan)
    deformed[ok] = dome @ Rotation.from_rotvec([0.5, -0.7, 0.2]).as_matrix().T + [40.0, 5.0, -90.0]
    view = radial_view(replace(results, tracked=replace(results.tracked, deformed=deformed)))
    # Rings are as wide as a bin; in one the height of the dome differs by up to 0.2 mm.
    assert_allclose(view.out, out, atol=0.05)
    assert_allclose(view.up, up - up.max(), atol=0.05)


def test_bins_without_values_are_empty():
    place, middle = binned(np.array([0.0, 1.0, 60.0]), np.array([2.0, np.nan, 4.0]))
    assert_allclose([place[0], place[-1]], [0.5, 59.5])
    assert middle[0] == 2.0
    assert np.isnan(middle[1])
    assert middle[-1] == 4.0
