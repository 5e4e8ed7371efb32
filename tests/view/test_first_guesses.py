import numpy as np
import pytest

from shapemorph.view.first_guesses import agreement_figure, guess_figure


@pytest.fixture
def guess(results):
    """Found: twice the guessed shift and gradient, beside two guesses that are unknown."""
    at = results.grid.reference_px.reshape(-1, 2)
    targets = at * [1.1, 1.05]
    targets[:2] = np.nan
    gradient = np.tile(np.diag([1.1, 1.05]), (len(at), 1, 1))
    return results.grid, targets, gradient, "a note"


def test_changes_of_the_first_guess_are_mapped(guess):
    grid, *_ = guess
    figure = guess_figure(*guess)
    panels = [axes for axes in figure.axes if axes.collections and axes.yaxis_inverted()]
    assert len(panels) == 6
    at = np.asarray(panels[0].collections[0].get_offsets())
    assert len(at) <= grid.ok_count
    np.testing.assert_allclose(panels[0].collections[0].get_array(), 0.1 * at[:, 0])
    np.testing.assert_allclose(panels[1].collections[0].get_array(), 0.1)
    np.testing.assert_allclose(panels[5].collections[0].get_array(), 0.05)


def test_what_was_found_is_drawn_over_its_guess(guess):
    axes = agreement_figure(*guess).axes
    assert len(axes) == 6
    before, after = axes[0].lines[0].get_xydata().T
    np.testing.assert_allclose(after, 2 * before)
    ends = axes[0].lines[1].get_xydata()
    np.testing.assert_allclose(ends[:, 0], ends[:, 1])
