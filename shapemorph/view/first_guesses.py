"""What the last match made of its first guesses, as maps and one against the other."""

from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus
from shapemorph.view.layout import Heading
from shapemorph.view.panels import draw_points, sheet
from shapemorph.view.style import DEFORMED_COLOUR, INK

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PARTS = (("u", "px"), ("u_x", "–"), ("u_y", "–"), ("v", "px"), ("v_x", "–"), ("v_y", "–"))
"""Of the affine shape function, and their units."""


def guess_figure(grid: CorrelationGrid, targets: Floats, gradient: Floats, note: str) -> "Figure":
    """Map what the last match has changed of its first guesses p0: p - p0.

    Parameters
    ----------
    grid : CorrelationGrid
        What was found.
    targets : (N, 2)
        Where its points were looked for, px.
    gradient : (N, 2, 2)
        With this gradient.
    note : str
        Which match it was.
    """
    at, guessed, found = _both(grid, targets, gradient)
    titles = [f"{name} - {name}0" for name, _ in PARTS]
    figure, axes = sheet(titles, 3, Heading("First guesses", f"p - p0: {note}"))
    for own, (_, unit), values in zip(axes, PARTS, (found - guessed).T, strict=True):
        draw_points(figure, own, at, values, unit)
        own.invert_yaxis()
    return figure


def agreement_figure(
    grid: CorrelationGrid, targets: Floats, gradient: Floats, note: str
) -> "Figure":
    """Draw p over p0, part by part, with the line on which both are alike; see guess_figure."""
    _, guessed, found = _both(grid, targets, gradient)
    titles = [f"{name} over {name}0  [{unit}]" for name, unit in PARTS]
    figure, axes = sheet(titles, 3, Heading("p against p0", note))
    for own, before, after in zip(axes, guessed.T, found.T, strict=True):
        own.plot(before, after, ".", color=DEFORMED_COLOUR, markersize=1.5)
        ends = [before.min(), before.max()]
        own.plot(ends, ends, "-", color=INK, linewidth=0.8)
    return figure


def _both(
    grid: CorrelationGrid, targets: Floats, gradient: Floats
) -> tuple[Floats, Floats, Floats]:
    """Places (N, 2) of the points that were found, and p0 and p (N, 6) there."""
    start = grid.reference_px.reshape(-1, 2)
    known = np.isfinite(targets).all(axis=1) & np.isfinite(gradient).all(axis=(1, 2))
    known &= (grid.status == PointStatus.OK).ravel()
    guessed = _parts((targets - start)[known], gradient[known])
    moved = grid.deformed_px.reshape(-1, 2) - start
    found = _parts(moved[known], grid.gradient.reshape(-1, 2, 2)[known])
    return start[known], guessed, found


def _parts(shift: Floats, gradient: Floats) -> Floats:
    """u, u_x, u_y, v, v_x, v_y (N, 6) of shifts and gradients of positions."""
    slope = gradient - np.eye(2)
    rows = [np.column_stack([shift[:, k], slope[:, k]]) for k in (0, 1)]
    return np.concatenate(rows, axis=1)
