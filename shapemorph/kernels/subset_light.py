"""What gain, offset and slope of the light do not explain of a match."""

from shapemorph.kernels.inner import inner
from shapemorph.kernels.small_linear import clear, factor, solve
from shapemorph.kernels.subset_rows import VECTOR_FLAGS
from shapemorph.kernels.vectors import LANES, fused, load, spread, total

MIDDLE = 0.5  # taken off the grey before it is summed


@inner(forceinline=True)
def _add_columns(ones, shared, xs, right, matrix):  # type: ignore[no-untyped-def]
    """Add the sums of a block of columns, times powers of x, to the normal equations."""
    n, ny, nyy, f, fy, ff = ones
    g, gy, fg = shared
    matrix[0, 0] += total(n)
    matrix[1, 0] += total(n * xs)
    matrix[1, 1] += total(n * xs * xs)
    matrix[2, 0] += total(ny)
    matrix[2, 1] += total(ny * xs)
    matrix[2, 2] += total(nyy)
    matrix[3, 0] += total(f)
    matrix[3, 1] += total(f * xs)
    matrix[3, 2] += total(fy)
    matrix[3, 3] += total(ff)
    right[0] += total(g)
    right[1] += total(g * xs)
    right[2] += total(gy)
    right[3] += total(fg)


@inner(fastmath=VECTOR_FLAGS)
def fit_light(  # type: ignore[no-untyped-def]
    reference, x, y, weights, grey, k, half, lane_x, box, system
) -> float:  # fmt: skip
    """Fit the reference grey of a subset by 1, x, y and the deformed grey.

    Parameters
    ----------
    reference : (3, H, W) float32
    x, y : int
        Centre of the subset, px.
    weights, grey : (N, R, L) float32
        See :func:`~shapemorph.kernels.subset_samples.sample_subsets`; subset `k` counts.
    half : int
        Only the middle 2 half + 1 rows are looked at.
    lane_x, box : (L,) float32
        Local x of the columns; 1 for those that are looked at, else 0.
    system : (10, 4)
        Room to work in; its last row is filled with the four factors, zero where the grey
        tells them not apart.

    Returns
    -------
    float
        Number of pixels that count; 0 where the factors are not told apart.
    """
    width, lanes = weights.shape[1], weights.shape[2]
    radius = (width - 1) // 2
    stride = reference.shape[2]
    matrix, lower, right, solution = system[0:4], system[4:8], system[8], system[9]
    for a in range(4):
        clear(matrix[a])
    clear(right)
    clear(solution)
    for first in range(0, width, LANES):
        xs, kept = load(lane_x, first), load(box, first)
        n = ny = nyy = f = fy = ff = g = gy = fg = spread(0.0)
        for j in range(radius - half, radius + half + 1):
            at = (k * width + j) * lanes + first
            ys = spread(float(j - radius))
            one = load(weights, at) * kept
            found = (load(grey, at) - spread(MIDDLE)) * one
            known = load(reference, (y - radius + j) * stride + x - radius + first) * one
            n, f, g = n + one, f + found, g + known
            ff, fg = fused(found, found, ff), fused(found, known, fg)
            fy, gy, one = fused(found, ys, fy), fused(known, ys, gy), one * ys
            ny, nyy = ny + one, fused(one, ys, nyy)
        _add_columns((n, ny, nyy, f, fy, ff), (g, gy, fg), xs, right, matrix)
    if not factor(matrix, len(right), 0.0, lower):
        return 0.0
    solve(lower, right, len(right), solution)
    return float(matrix[0, 0])


@inner(forceinline=True)
def residual(known, found, xs, ys, solution, weight):  # type: ignore[no-untyped-def]
    """Take off the reference grey what the factors of :func:`fit_light` explain."""
    explained = fused(spread(solution[3]), found - spread(MIDDLE), spread(solution[0]))
    explained = fused(spread(solution[1]), xs, explained)
    return (known - fused(spread(solution[2]), ys, explained)) * weight
