"""Systematic part of the error of matched points: shape function and interpolation."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus
from shapemorph.methods.grid_correlation import GridMatches
from shapemorph.methods.plane_maps import inverse_maps
from shapemorph.methods.spline_pictures import SLOPE, SMOOTH, ReferencePicture

TILES = (128, 64, 32)  # px: widths of the tiles from which a spectrum is taken
MOST_TILES = 6  # along each axis
EMPTY = 0.375  # cycles per px: beyond it along both axes a pattern leaves the noise alone
RIM = 2  # windows: so far from a whole window its estimate is taken on
REPLICAS = np.array([(k, m) for k in (-1, 0, 1) for m in (-1, 0, 1) if (k, m) != (0, 0)])


def systematic_error(
    reference: ReferencePicture,
    found: GridMatches,
    rest: Floats,
    grid: CorrelationGrid,
    *,
    order: int,
) -> Floats:
    """Estimate the systematic error of matched positions.

    The sum of what the shape function does not follow, carried into the deformed picture,
    and of :func:`interpolation_bias` of pictures that are sampled on their own pixels. The
    first is the motion that the match has left at the centre of the subset, where that is
    told from noise, else :func:`shape_bias` of the field of all points.

    Parameters
    ----------
    reference : ReferencePicture
    found : GridMatches
        In the morphed picture.
    rest : (R, C, 2)
        Motion that is left there, see :func:`~shapemorph.methods.rest_motion.unfollowed_motion`.
    grid : CorrelationGrid
        The same points in the deformed picture.
    order : int
        Of the shape function.

    Returns
    -------
    (R, C, 2)
        Expected estimate - truth, px of the deformed picture; NaN where it is not known.
    """
    ok = grid.status == PointStatus.OK
    shape = shape_bias(
        found.position, ok, spacing=grid.spacing, radius=grid.subset_size // 2, order=order
    )
    shape = np.where((rest != 0.0).any(axis=-1, keepdims=True), -rest, shape)
    slope = np.full(grid.gradient.shape, np.nan)
    slope[ok] = grid.gradient[ok] @ inverse_maps(found.gradient[ok])
    motion = grid.deformed_px - grid.reference_px
    sampled = interpolation_bias(reference, motion, grid.gradient, width=grid.subset_size)
    return np.asarray(np.einsum("rcij,rcj->rci", slope, shape) + sampled)


def shape_bias(position: Floats, usable: Bools, *, spacing: int, radius: int, order: int) -> Floats:
    """Estimate what a shape function that cannot follow the field makes of it.

    A least-squares match gives at the centre of the subset about what a polynomial of the
    order of the shape function, fitted to the true field over the subset, has there. The
    field itself is a polynomial two orders higher, fitted to the found points around, over
    at least the width of the subset. Points near a rim take the estimate of the nearest
    point that has a whole window.

    Parameters
    ----------
    position : (R, C, 2)
        Found positions on a regular grid, px.
    usable : (R, C) bool
    spacing, radius : int
        Of the grid and of the subset, px.
    order : int
        Of the shape function: 0, 1 or 2.

    Returns
    -------
    (R, C, 2)
        px; NaN where no whole window is near.

    References
    ----------
    H. W. Schreier, M. A. Sutton, "Systematic errors in digital image correlation due to
    undermatched subset shape functions", Experimental Mechanics 42 (2002),
    doi:10.1007/BF02410987.
    """
    import cv2

    half = max(2, -(-radius // spacing))
    stencil = _bias_stencil(half, spacing, radius, order)
    around = np.ones(stencil.shape, np.uint8)
    whole = cv2.erode(
        usable.astype(np.uint8), around, borderType=cv2.BORDER_CONSTANT, borderValue=0
    ).astype(bool)
    result = np.full(position.shape, np.nan)
    if not whole.any():
        return result
    for k in range(2):
        values = np.where(usable, position[..., k], 0.0)
        result[..., k] = cv2.filter2D(values, -1, stencil, borderType=cv2.BORDER_REPLICATE)
    distance, label = cv2.distanceTransformWithLabels(
        (~whole).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    place = np.empty(label.max() + 1, dtype=np.int64)
    place[label[whole]] = np.flatnonzero(whole)
    result = result.reshape(-1, 2)[place[label]]
    result[~usable | (distance > RIM * len(stencil))] = np.nan
    return result


def _bias_stencil(half: int, spacing: int, radius: int, order: int) -> Floats:
    """(2 half + 1, same) weights of the points of a window that make up the bias."""
    exponents = [(i, j) for i in range(order + 3) for j in range(order + 3 - i)]
    unit = float(half * spacing)
    steps = np.arange(-half, half + 1) * spacing / unit
    field = _monomials(steps, exponents)
    pixels = _monomials(np.arange(-radius, radius + 1) / unit, exponents)
    followed = pixels[:, [order >= i + j for i, j in exponents]]
    centre = np.linalg.pinv(followed)[0]  # what the fitted polynomial has at the centre
    gain = centre @ pixels
    gain[0] -= 1.0  # less the true value there
    weights: Floats = gain @ np.linalg.pinv(field)
    return weights.reshape(2 * half + 1, 2 * half + 1)


def _monomials(steps: Floats, exponents: list[tuple[int, int]]) -> Floats:
    y, x = (each.ravel() for each in np.meshgrid(steps, steps, indexing="ij"))
    return np.stack([x**i * y**j for i, j in exponents], axis=1)


def interpolation_bias(
    reference: ReferencePicture, motion: Floats, gradient: Floats, *, width: int
) -> Floats:
    """Estimate the error that the spline between the pixels causes.

    The spline keeps replicas of the spectrum of the picture, which turn with the position
    between the pixels; projected on the slopes of the reference they move the match. In a
    subset that is stretched or turned the positions differ, and the error averages out.

    Parameters
    ----------
    reference : ReferencePicture
    motion : (R, C, 2)
        Deformed - reference, px.
    gradient : (R, C, 2, 2)
        d deformed[i] / d reference[j].
    width : int
        Of the subset, px.

    Returns
    -------
    (R, C, 2)
        px; NaN where the motion is.

    References
    ----------
    H. W. Schreier, J. R. Braasch, M. A. Sutton, "Systematic errors in digital image
    correlation caused by intensity interpolation", Optical Engineering 39 (2000),
    doi:10.1117/1.1314593.
    """
    total = np.where(np.isfinite(motion), 0.0, np.nan)
    power = pattern_spectrum(reference)
    if power is None:
        return total
    strength = _replica_strengths(power, reference.degree)
    for replica, each in zip(REPLICAS.astype(np.float64), strength, strict=True):
        along = (gradient - np.eye(2)).swapaxes(-1, -2) @ replica
        total = total + (
            each * (np.sin(2 * np.pi * motion @ replica) * _blurred(along, width))[..., None]
        )
    return total


def _replica_strengths(power: Floats, degree: int) -> Floats:
    """(8, 2) error that each replica causes a quarter of a turn from the pixels, px."""
    frequency: Floats = np.fft.fftfreq(len(power)).astype(np.float64)
    slope = _knot_slope(frequency, degree) / _knot_gain(frequency, degree)
    along = np.stack(np.broadcast_arrays(slope[None, :], slope[:, None])).reshape(2, -1)
    weighted = along * power.ravel()
    kept = {replica: _spline_gain(frequency, replica, degree) for replica in (-1, 0, 1)}
    pushes = [weighted @ np.outer(kept[m], kept[k]).ravel() for k, m in REPLICAS.tolist()]
    solution = np.linalg.lstsq(weighted @ along.T, np.stack(pushes, axis=1), rcond=None)[0]
    return np.asarray(-solution.T)


def _knot_gain(frequency: Floats, degree: int) -> Floats:
    """Tell what the knots of a B-spline do to a wave."""
    weights = SMOOTH[degree].astype(np.float64)
    steps = np.arange(len(weights)) - len(weights) // 2
    return np.asarray(np.cos(2 * np.pi * np.outer(frequency, steps)) @ weights)


def _knot_slope(frequency: Floats, degree: int) -> Floats:
    """Tell what the slopes of a B-spline at its knots do to a wave, a quarter of a turn on."""
    weights = SLOPE[degree].astype(np.float64)
    steps = np.arange(len(weights)) - len(weights) // 2
    return np.asarray(np.sin(2 * np.pi * np.outer(frequency, steps)) @ weights)


def _spline_gain(frequency: Floats, replica: int, degree: int) -> Floats:
    """Tell how strongly an interpolating spline keeps a replica of each wave."""
    return np.asarray(np.sinc(frequency + replica) ** (degree + 1) / _knot_gain(frequency, degree))


def _blurred(along: Floats, width: int) -> Floats:
    """Mean over a subset of a wave (..., 2) cycles per px, relative to its centre."""
    turn = np.pi * along
    small = np.abs(np.sin(turn)) < 1e-6
    safe = np.where(small, 1.0, np.sin(turn))
    kept = np.where(small, 1.0, np.sin(width * turn) / (width * safe))
    return np.asarray(kept.prod(axis=-1))


def pattern_spectrum(reference: ReferencePicture) -> Floats | None:
    """Mean power of the pattern less that of its noise.

    Returns
    -------
    (T, T) or None
        In the order of :func:`numpy.fft.fftfreq`, any unit; None where no tile is whole or
        none shows a pattern.
    """
    for size in TILES:
        tiles = _whole_tiles(reference, size)
        if tiles:
            break
    else:
        return None
    window = np.hanning(size + 2)[1:-1]
    window2d = np.outer(window, window)
    halves = [np.abs(np.fft.rfft2((tile - tile.mean()) * window2d)) ** 2 for tile in tiles]
    power = _both_halves(np.mean(halves, axis=0))
    high = np.abs(np.fft.fftfreq(size)) > EMPTY
    pattern: Floats = np.maximum(power - np.median(power[np.ix_(high, high)]), 0.0)
    return pattern if pattern.any() else None


def _both_halves(half: Floats) -> Floats:
    """Power (T, T) of a real picture from its columns (T, T / 2 + 1) of no negative frequency."""
    opposite = np.roll(half[::-1], 1, axis=0)[:, -2:0:-1]
    return np.concatenate([half, opposite], axis=1)


def _whole_tiles(reference: ReferencePicture, size: int) -> list[Floats]:
    rows, cols = reference.inside.shape
    counts = reference.counts
    tiles = []
    for top in _starts(rows, size):
        for left in _starts(cols, size):
            bottom, right = top + size, left + size
            seen = counts[bottom, right] - counts[top, right] - counts[bottom, left]
            if seen + counts[top, left] == size * size:
                tiles.append(reference.planes[0][top:bottom, left:right].astype(np.float64))
    return tiles


def _starts(length: int, size: int) -> list[int]:
    """Evenly spread starts of tiles, the last one flush with the end."""
    if length < size:
        return []
    number = min(2 * MOST_TILES, max(2, 2 * length // size))
    return sorted({int(start) for start in np.linspace(0, length - size, number)})
