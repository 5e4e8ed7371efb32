"""Synthetic pictures between two states: each half of the way comes from its own picture."""

from collections.abc import Iterator

import numpy as np
from scipy import ndimage

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.kernels.bspline import sample
from shapemorph.methods.sequence_turn import NO_TURN, Turn
from shapemorph.methods.warping import warp_points

_STEPS = 8
_SETTLED = 0.1  # px: Newton is there or far away
_AT_REST = 1e-4  # px: the step after a smaller one is lost in rounding
_STRIDE = 4


def morph_sequence(
    reference: GreyImage,
    deformed: GreyImage,
    forward: Warp,
    backward: Warp,
    *,
    images: int,
    turn: Turn = NO_TURN,
) -> Iterator[GreyImage]:
    """Yield the synthetic pictures I_2 ... I_{N-1} of a morph of N pictures.

    I_i is the reference moved by (i-1)/(N-2) of the forward warp for i = 2 ... N/2, and the
    deformed picture moved by (N-i)/(N-2) of the backward warp for the others. Both middle
    pictures lie half-way and agree when the warps are inverse to each other. A turn between
    the pictures is taken along an arc: on straight ways half a turn would shrink everything
    to a point.

    Parameters
    ----------
    reference, deformed : GreyImage
    forward, backward : Warp
        Reference -> deformed and deformed -> reference.
    images : int
        N - 2, even.
    turn : Turn
        From the reference to the deformed picture.

    Yields
    ------
    GreyImage
        On a canvas that holds both pictures; the mask is where the moved picture lies.

    References
    ----------
    .. [1] Genovese, K. and Sorgente, D. (2017). A morphing-based scheme for large
       deformation analysis with stereo-DIC. Optics and Lasers in Engineering, Eq. 3-4.
       :doi:`10.1016/j.optlaseng.2017.06.020`
    """
    canvas = (
        max(reference.shape[0], deformed.shape[0]),
        max(reference.shape[1], deformed.shape[1]),
    )
    for number in range(2, images + 2):
        if number <= images // 2 + 1:
            yield move_picture(reference, forward, (number - 1) / images, canvas, turn)
        else:
            part = (images + 2 - number) / images
            yield move_picture(deformed, backward, part, canvas, turn.back)


def move_picture(
    image: GreyImage,
    warp: Warp,
    fraction: float,
    shape: tuple[int, int],
    turn: Turn = NO_TURN,
) -> GreyImage:
    """Move a picture by a fraction of its warp: pixel x goes to x + fraction (warp(x) - x).

    That is so without a turn. With one, what the warp does beside the turn is done by this
    fraction, and then the turn by the same fraction.

    Parameters
    ----------
    image : GreyImage
    warp : Warp
        From this picture onto another.
    fraction : float
        0 leaves it where it is, 1 carries it all the way.
    shape : (int, int)
        Height and width of the result.
    turn : Turn
        Part of the warp.

    Returns
    -------
    GreyImage
        Sampled once, by cubic splines.
    """
    coefficients = ndimage.spline_filter(image.grey.astype(np.float64), order=3, mode="mirror")
    coefficients = np.pad(coefficients, 2, mode="reflect")  # the support reaches beyond the rim
    source = _origins(shape, warp, fraction, turn).reshape(-1, 2)
    covered = _is_inside(image.mask, source)
    grey = np.zeros(len(source), dtype=np.float32)
    grey[covered] = np.clip(sample(coefficients, source[covered] + 2.0), 0.0, 1.0)
    return GreyImage(grey.reshape(shape), covered.reshape(shape))


def _is_inside(mask: Bools, points: Floats) -> Bools:
    """Look up a mask at the nearest pixel; False outside and where a point is NaN."""
    height, width = mask.shape
    column, row = np.nan_to_num(points, nan=-1.0).T
    near = (column > -0.5) & (column < width - 0.5) & (row > -0.5) & (row < height - 0.5)
    column, row = column[near].round().astype(np.int64), row[near].round().astype(np.int64)
    near[near] = mask[row, column]
    found: Bools = near
    return found


def _origins(shape: tuple[int, int], warp: Warp, fraction: float, turn: Turn) -> Floats:
    """Find where every pixel comes from, (H, W, 2); NaN where nothing does.

    Solved on every fourth pixel and interpolated: a warp bends over its spacing only.
    """
    height, width = shape
    rows, columns = np.arange(0, height + _STRIDE, _STRIDE), np.arange(0, width + _STRIDE, _STRIDE)
    nodes = np.stack(np.meshgrid(columns, rows), axis=-1).astype(np.float64)
    source = origins_of_points(nodes.reshape(-1, 2), warp, fraction, turn).reshape(nodes.shape)
    return _between(_between(source, height).swapaxes(0, 1), width).swapaxes(0, 1)


def _between(values: Floats, count: int) -> Floats:
    """Interpolate linearly along the first axis at 0, 1, ... count - 1 of the fine grid."""
    place = np.arange(count)
    low, part = place // _STRIDE, (place % _STRIDE / _STRIDE)[:, None, None]
    return (1.0 - part) * values[low] + part * values[low + 1]


def origins_of_points(targets: Floats, warp: Warp, fraction: float, turn: Turn = NO_TURN) -> Floats:
    """Find what a moved picture shows at each target, by Newton's method.

    Parameters
    ----------
    targets : (N, 2)
        Places in the moved picture, px.
    warp : Warp
    fraction : float
        Part of its way that the picture was moved.
    turn : Turn
        Part of the warp.

    Returns
    -------
    (N, 2)
        Places in the picture itself, px; NaN where nothing comes to lie there.
    """
    targets, warp = turn.undo(targets, fraction), turn.straighten(warp)
    source = _first_guess(targets, warp, fraction)
    moving = np.arange(len(source))
    for _ in range(_STEPS):
        some = source[moving]
        moved, gradient = warp_points(warp, some)
        miss = some + fraction * (moved - some) - targets[moving]
        slope = (1.0 - fraction) * np.eye(2) + fraction * gradient
        step = _solve(slope, miss)
        source[moving] = some - step
        moving = moving[~(np.abs(step).max(axis=-1) < _AT_REST)]
    moved, _ = warp_points(warp, source)
    miss = np.abs(source + fraction * (moved - source) - targets).max(axis=-1)
    source[~(miss < _SETTLED)] = np.nan
    return source


def _first_guess(targets: Floats, warp: Warp, fraction: float) -> Floats:
    """Invert the affine map nearest to the moved coefficients of the warp."""
    rows, columns = np.mgrid[0 : warp.coefficients.shape[0], 0 : warp.coefficients.shape[1]]
    nodes = warp.origin + warp.spacing * np.stack([columns, rows], axis=-1).reshape(-1, 2)
    moved = nodes + fraction * (warp.coefficients.reshape(-1, 2) - nodes)
    design = np.column_stack([moved, np.ones(len(moved))])
    affine, *_ = np.linalg.lstsq(design, nodes, rcond=None)
    low, high = nodes.min(axis=0) + warp.spacing, nodes.max(axis=0) - warp.spacing
    guess: Floats = np.clip(targets @ affine[:2] + affine[2], low, high)
    return guess


def _solve(matrix: Floats, vector: Floats) -> Floats:
    """Solve many 2 x 2 systems; NaN where one is singular."""
    (a, b), (c, d) = np.moveaxis(matrix[:, 0], -1, 0), np.moveaxis(matrix[:, 1], -1, 0)
    determinant = a * d - b * c
    with np.errstate(divide="ignore", invalid="ignore"):
        x = (d * vector[:, 0] - b * vector[:, 1]) / determinant
        y = (a * vector[:, 1] - c * vector[:, 0]) / determinant
    return np.stack([x, y], axis=-1)
