"""Random error of every matched point, from the residuals of all."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.kernels.subset_noise import residual_products, solution_covariance
from shapemorph.methods.matched_subsets import BLOCK, MAX_LAG, MatchedSubsets
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture
from shapemorph.methods.subset_dic import SubsetSettings
from shapemorph.methods.threads import run_blocks

AVERAGED = 2.0  # points; standard deviation of the weights that average the autocovariance
SAMPLED = 64  # subsets from which the effect of fitting is learnt
MOST_NOISY = 0.5  # share of the squared slopes that is put down to noise
LEAST_SHARE = 0.1  # of the variance that white noise of the same strength would cause


def displacement_covariance(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    points: Ints,
    warps: Floats,
    usable: Bools,
    *,
    settings: SubsetSettings,
) -> Floats:
    """Covariance of matched positions, random part only.

    The residual between each subset and its match, after gain, offset and a slope of the
    light, is the noise of both pictures as the match saw it. Its autocovariance, averaged
    over neighbouring points, is carried through the normal equations. A misfit of the
    shape function counts as noise too, so the figure is rather too high there.

    Parameters
    ----------
    reference, deformed : ReferencePicture, DeformedPicture
    points : (R, C, 2)
        Grid, px.
    warps : (R, C, 12)
        Subset warps.
    usable : (R, C) bool
        Points that were matched.
    settings : SubsetSettings
        With which they were matched.

    Returns
    -------
    (R, C, 2, 2)
        px^2; NaN where not usable.
    """
    lags = short_lags(MAX_LAG)
    seen = usable & _every_other(usable.shape)
    if not seen.any():
        seen = usable
    pictures, radius = (reference, deformed), settings.radius
    some = MatchedSubsets.at(pictures, points, warps, seen, radius)
    overlap = fitted_overlap(
        reference, some.points, radius=radius, order=settings.order, reach=2 * MAX_LAG
    )
    noise = _restore(_average(*_residual_products(some, lags), seen, usable), lags, overlap)
    subsets = MatchedSubsets.at(pictures, points, warps, usable, radius)
    found, squares = _covariance(subsets, lags, noise, settings.order)
    result = np.full((*usable.shape, 2, 2), np.nan)
    spread = _without_noisy_slopes(squares, noise[:, 0])
    result[usable] = found[:, [0, 2, 2, 1]].reshape(-1, 2, 2)
    result[usable] *= spread[:, :, None] * spread[:, None, :]
    return result


def _without_noisy_slopes(squares: Floats, noise: Floats) -> Floats:
    """(N, 2) factors on sigma, since only the slopes of the pattern hold a match.

    The mean squares of the slopes of the reference (N, 2) contain those of its own noise,
    which the deformed picture does not share; half of the residual's variance is taken for it.
    """
    turn = 2 * np.pi * np.fft.fftfreq(256)
    gain = float(np.mean((3.0 * np.sin(turn) / (2.0 + np.cos(turn))) ** 2))
    share = 0.5 * gain * noise[:, None] / np.maximum(squares, 1e-12)
    return np.asarray(1.0 / (1.0 - np.clip(share, 0.0, MOST_NOISY)))


def _residual_products(subsets: MatchedSubsets, lags: Ints) -> tuple[Floats, Floats]:
    """(N, K) sums of products of the residual at each lag, and number of pairs."""
    products, pairs = np.empty((2, len(subsets.points), len(lags)))

    def work(first: int, last: int) -> None:
        some = slice(first, last)
        residual_products(
            subsets.reference.planes,
            subsets.points[some],
            *subsets.samples(first, last),
            lags,
            products[some],
            pairs[some],
        )

    run_blocks(work, len(subsets.points), block=BLOCK)
    return products, pairs


def _covariance(
    subsets: MatchedSubsets, lags: Ints, noise: Floats, order: int
) -> tuple[Floats, Floats]:
    """(N, 3) variance of x, of y, covariance, from the autocovariance of the noise; (N, 2) slopes.

    The latter are the mean squares of the slopes along both axes.
    """
    result, squares = np.empty((len(subsets.points), 3)), np.empty((len(subsets.points), 2))
    noise = np.ascontiguousarray(noise)

    def work(first: int, last: int) -> None:
        some = slice(first, last)
        solution_covariance(
            subsets.reference.planes,
            subsets.points[some],
            subsets.weights(first, last),
            order,
            1 if order == 2 else None,
            lags,
            noise[some],
            LEAST_SHARE,
            result[some],
            squares[some],
        )

    run_blocks(work, len(subsets.points), block=BLOCK)
    return result, squares


def short_lags(largest: int) -> Ints:
    """(K, 2) lags (rows down, columns right) up to a length, one of each opposite pair."""
    steps = range(-largest, largest + 1)
    lags = [(r, c) for r in range(largest + 1) for c in steps if r > 0 or c >= 0]
    return np.array(lags, dtype=np.int64)


def _every_other(shape: tuple[int, ...]) -> Bools:
    """Mark every second point of every second row: subsets overlap, one sees for four."""
    chosen = np.zeros(shape, dtype=bool)
    chosen[::2, ::2] = True
    return chosen


def _average(products: Floats, pairs: Floats, seen: Bools, usable: Bools) -> Floats:
    """(N, K) autocovariance of the residuals seen around each usable point."""
    import cv2

    width = 2 * round(3.0 * AVERAGED) + 1
    noise = np.empty((np.count_nonzero(usable), products.shape[1]))
    everywhere = pairs.sum(axis=0)
    for k in range(products.shape[1]):
        sums = np.zeros((2, *seen.shape))
        sums[0][seen], sums[1][seen] = products[:, k], pairs[:, k]
        total, number = (
            cv2.GaussianBlur(each, (width, width), AVERAGED, borderType=cv2.BORDER_REFLECT)[usable]
            for each in sums
        )
        whole = products[:, k].sum() / max(everywhere[k], 1.0)
        noise[:, k] = np.where(number > 1e-3, total / np.maximum(number, 1e-3), whole)
    return noise


def _restore(noise: Floats, lags: Ints, overlap: Floats) -> Floats:
    """Autocovariance of the noise from that of the residuals, which lack what was fitted.

    A match projects the noise off the images that it fits. The residual's autocovariance
    is that of the noise less its convolution with the mean autocorrelation of the
    projector, which is inverted here.
    """
    centre = overlap.shape[0] // 2
    ahead = lags[:, None] - lags[None]
    back = lags[:, None] + lags[None]
    taken = overlap[centre + ahead[..., 0], centre + ahead[..., 1]]
    twice = (lags != 0).any(axis=1)
    taken = taken + twice * overlap[centre + back[..., 0], centre + back[..., 1]]
    restored: Floats = np.linalg.solve(np.eye(len(lags)) - taken, noise.T).T
    return restored


def fitted_overlap(
    reference: ReferencePicture, points: Ints, *, radius: int, order: int, reach: int
) -> Floats:
    """Mean autocorrelation of the projector on the images that a match fits.

    Parameters
    ----------
    reference : ReferencePicture
    points : (N, 2)
        Centres in the padded picture; a spread sample of them is looked at.
    radius, order : int
        Of the subset, px; of the shape function.
    reach : int
        Largest lag, px.

    Returns
    -------
    (2 reach + 1, 2 reach + 1)
        Mean of P[i, i + lag] over pixels and subsets, lag zero at the centre.
    """
    chosen = points[np.unique(np.linspace(0, len(points) - 1, SAMPLED).round().astype(int))]
    steps = np.arange(-radius, radius + 1)
    rows, cols = chosen[:, 1, None, None] + steps[:, None], chosen[:, 0, None, None] + steps
    inside = reference.inside[rows, cols] > 0
    images = _fitted_images(reference.planes[:, rows, cols], inside, radius, order)
    flat = images.reshape(*images.shape[:2], -1)
    basis = np.linalg.qr(flat.swapaxes(1, 2))[0].swapaxes(1, 2).reshape(images.shape)
    total = _autocorrelation(basis.reshape(-1, *inside.shape[1:]), reach)
    pairs = _autocorrelation(inside.astype(np.float64), reach)
    return total / np.maximum(pairs, 1e-9)


def _fitted_images(planes: Greys, inside: Bools, radius: int, order: int) -> Floats:
    """(S, M, H, W) images that gain, offset, light and motion can add to each subset."""
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1] / float(radius)
    terms = [np.ones_like(x), x, y, x * x, x * y, y * y][: (order + 1) * (order + 2) // 2]
    grey, along_x, along_y = planes.astype(np.float64)
    light = [np.broadcast_to(each, grey.shape) for each in (terms[0], x, y)]
    motion = [slope * term for slope in (along_x, along_y) for term in terms]
    return np.stack([*light, grey, *motion], axis=1) * inside[:, None]


def _autocorrelation(images: Floats, reach: int) -> Floats:
    """Sum over images (M, H, W) of image[i] image[i + lag], lag zero at the centre."""
    import cv2

    size = tuple(cv2.getOptimalDFTSize(each + reach) for each in images.shape[1:])
    power = (np.abs(np.fft.rfft2(images, size)) ** 2).sum(axis=0)
    lags = np.fft.irfft2(power, size)
    steps = np.arange(-reach, reach + 1)
    return np.asarray(lags[np.ix_(steps, steps)])
