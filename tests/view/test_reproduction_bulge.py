"""Figures and page of the reproduced bulge, from a few points."""

import numpy as np
import pytest

from shapemorph.methods.twin_errors import TwinPoints
from shapemorph.view.reproduction_bulge import (
    bulge_page_html,
    correspondence_figure,
    noise_figure,
    radial_figure,
    stretch_figure,
)


@pytest.fixture
def points():
    rng = np.random.default_rng(0)
    material = rng.uniform(-15, 15, (200, 2))
    moved = np.column_stack([material, 20 - 0.05 * (material**2).sum(axis=1)])
    strain = np.tile([0.5, 0.3], (200, 1))
    return TwinPoints(material, moved, moved, strain + 0.01, strain)


def test_noise_is_drawn_even_where_nothing_was_found():
    rows = [
        {"noise_levels": 1.5, "error_rms_mm": 0.01, "share_of_points": 0.95},
        {"noise_levels": 20.0, "error_rms_mm": float("nan"), "share_of_points": 0.0},
    ]
    figure = noise_figure(rows)
    lines = [axes.lines[0].get_ydata() for axes in figure.axes]
    np.testing.assert_allclose(lines[0], [0.01, np.nan])
    np.testing.assert_allclose(lines[1], [0.95, 0.0])


def test_errors_are_gathered_by_the_true_stretch(points):
    true = np.where(np.arange(200)[:, None] < 180, [0.5, 0.3], [1.5, 0.3])  # λ 1.41 and 2
    true[190:, 0] = 2.0  # of too few points
    found = TwinPoints(
        points.material, points.displacement, points.truth, np.add(true, [0.01, 0.02]), true
    )
    off = np.where(true[:, :1] < 1.0, [0.0, 0.0, 0.1], [0.3, 0.0, 0.4])
    alone = stretch_figure({"fe": found}, {"fe": off}).axes
    np.testing.assert_allclose(alone[0].lines[0].get_xydata(), [[1.45, 0.1]])
    true[:20, 0] = 1.6
    off[:20] = [0.3, 0.0, 0.4]
    found = TwinPoints(
        points.material, points.displacement, points.truth, np.add(true, [0.01, 0.02]), true
    )
    axes = stretch_figure({"fe": found}, {"fe": off}).axes
    np.testing.assert_allclose(axes[0].lines[0].get_xydata(), [[1.45, 0.1], [2.05, 0.5]])
    np.testing.assert_allclose(axes[1].lines[0].get_ydata(), 0.01)
    np.testing.assert_allclose(axes[2].lines[0].get_ydata(), 0.02)


def test_the_truth_is_a_line_among_the_points_of_each_law(points):
    truth = np.column_stack([np.linspace(0, 15, 5), np.full((5, 2), 0.5), np.full(5, 20.0)])
    figure = radial_figure({"fe": points, "landmarks": points}, truth)
    labels = [line.get_label() for line in figure.axes[0].lines]
    assert labels == ["fe", "landmarks", "truth"]


def test_near_points_are_drawn_last(points):
    before = np.column_stack([points.material, np.zeros(200)])
    figure = correspondence_figure(before, points.displacement, np.hypot(*points.material.T))
    shown = figure.axes[0].collections[0].get_offsets()
    assert shown[0, 1] > shown[-1, 1]  # of a flat sheet the far side is seen on top


def test_the_page_says_what_was_found_under_glare():
    row = {"mean": 0.001, "std": 0.002}
    law = {
        "points": 10,
        "points_away_from_kink": 8,
        "largest_E1": 1.6,
        "against_truth": dict.fromkeys(("u", "v", "w", "E1", "E2"), row),
        "rms_away_from_kink": dict.fromkeys(("position_mm", "displacement_mm", "E1", "E2"), 0.0123),
        "seconds": 3.0,
    }
    summary = {
        "laws": {"fe": law},
        "laws_agree_mm": None,
        "glare": {"points": 4, "share_found": 0.75, "rms_E1": 0.005},
        "shapes": {state: {"overlap_rms_mm": 0.004} for state in ("before", "after")},
    }
    page = bulge_page_html(summary, ["figures/a.png"])
    assert "<td>10</td>" in page
    assert "<td>8</td>" in page
    assert "built-in" not in page
    assert "75.0 %" in page
    assert "0.0123" in page
    assert "Positions measured with the laws" not in page  # there is but one
    assert 'src="figures/a.png"' in page
