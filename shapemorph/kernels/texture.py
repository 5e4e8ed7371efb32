"""Grey levels straight from textures: one cubic interpolation, averaged over each pixel.

A set of textures is one flat array of B-spline coefficients. Row ``t * levels + l`` of its
table gives offset, height and width of texture t reduced l times by boxes of 2 x 2 texels.
Texel centres are at integers; a texel (x, y) of the full texture is ``(x + 1/2) / 2^l - 1/2``
at level l.
"""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.kernels.locate import find, holds, weights
from shapemorph.kernels.texel_samples import (
    choose_level,
    interpolate,
    principal_turn,
    spread_samples,
)

SURELY_INSIDE = 1e-9  # weight of a corner that round-off cannot turn negative
EVEN_REACH = 2.0  # px from a pixel's centre to which its slope holds


@njit(cache=True, inline="always")
def _texels_along(gradient: Floats, x: float, y: float) -> tuple[float, float]:
    """Texels along u and v of a step of (x, y) px."""
    return gradient[0, 0] * x + gradient[0, 1] * y, gradient[1, 0] * x + gradient[1, 1] * y


@njit(cache=True, inline="always")
def _weight_slopes(px: Floats, faces: Ints, k: int, x: float, y: float) -> tuple[float, float]:
    """Change of the weights of the second and third corner along a step (x, y)."""
    ax, ay = px[faces[k, 0], 0], px[faces[k, 0], 1]
    bx, by = px[faces[k, 1], 0] - ax, px[faces[k, 1], 1] - ay
    cx, cy = px[faces[k, 2], 0] - ax, px[faces[k, 2], 1] - ay
    area = bx * cy - by * cx
    return (x * cy - y * cx) / area, (bx * y - by * x) / area


@njit(cache=True, inline="always")
def _corner_mean(values: Floats, k: int, second: float, third: float) -> tuple[float, float]:
    """Value of triangle k at given weights of its second and third corner."""
    u = values[k, 0, 0] + second * (values[k, 1, 0] - values[k, 0, 0])
    v = values[k, 0, 1] + second * (values[k, 1, 1] - values[k, 0, 1])
    u += third * (values[k, 2, 0] - values[k, 0, 0])
    v += third * (values[k, 2, 1] - values[k, 0, 1])
    return u, v


@njit(cache=True, inline="always")
def _reaches(slopes: Greys, x: float, y: float, frame: Floats) -> bool:
    """Whether the slope at the nearest pixel is known and leads all over a parallelogram."""
    row, col = int(np.rint(y)), int(np.rint(x))
    if not (0 <= row < slopes.shape[0] and 0 <= col < slopes.shape[1]):
        return False
    wide = np.abs(x - col) + 0.5 * (np.abs(frame[0, 0]) + np.abs(frame[0, 1]))
    high = np.abs(y - row) + 0.5 * (np.abs(frame[1, 0]) + np.abs(frame[1, 1]))
    return bool(max(wide, high) <= EVEN_REACH and np.isfinite(slopes[row, col, 0, 0]))


@njit(cache=True)
def _mean_grey(
    centre_x: float,
    centre_y: float,
    frame: Floats,
    centre: int,
    px: Floats,
    faces: Ints,
    sign: float,
    grid: Floats,
    cols: int,
    starts: Ints,
    items: Ints,
    corner_values: Floats,
    slope: Floats,
    even: bool,
    textures: Ints,
    texels: Greys,
    table: Ints,
    base: int,
    repeats: Ints,
) -> float:
    """Mean grey over one parallelogram whose centre lies in a known triangle.

    Where the texture is even the slope leads to all samples, and no other triangle is asked.
    """
    textured = len(texels) > 0
    levels = len(table) // max(len(repeats), 1)
    ux, vx = _texels_along(slope, frame[0, 0], frame[1, 0])
    uy, vy = _texels_along(slope, frame[0, 1], frame[1, 1])
    cos, sin = principal_turn(ux, uy, vx, vy)
    along_x = np.hypot(ux * cos + uy * sin, vx * cos + vy * sin)
    along_y = np.hypot(uy * cos - ux * sin, vy * cos - vx * sin)
    side_x = frame[0, 0] * cos + frame[0, 1] * sin, frame[1, 0] * cos + frame[1, 1] * sin
    side_y = frame[0, 1] * cos - frame[0, 0] * sin, frame[1, 1] * cos - frame[1, 0] * sin
    level = choose_level(along_x, along_y, base, levels) if textured else 0
    shrink = 2.0**-level
    across, step_x = spread_samples(along_x * shrink)
    down, step_y = spread_samples(along_y * shrink)
    second_0, third_0 = weights(px, faces, centre, centre_x, centre_y)
    second_s, third_s = _weight_slopes(px, faces, centre, side_x[0], side_x[1])
    second_t, third_t = _weight_slopes(px, faces, centre, side_y[0], side_y[1])
    u_0, v_0 = _corner_mean(corner_values, centre, second_0, third_0)
    u_s, v_s = _texels_along(slope, side_x[0], side_x[1])
    u_t, v_t = _texels_along(slope, side_y[0], side_y[1])
    total, count, last = 0.0, 0, -1
    for j in range(down):
        for i in range(across):
            s, t = (i - 0.5 * (across - 1)) * step_x, (j - 0.5 * (down - 1)) * step_y
            under, u, v = centre, u_0 + u_s * s + u_t * t, v_0 + v_s * s + v_t * t
            if not even:
                second = second_0 + second_s * s + second_t * t
                third = third_0 + third_s * s + third_t * t
                if min(second, third, 1.0 - second - third) < SURELY_INSIDE and across * down > 1:
                    x = centre_x + side_x[0] * s + side_y[0] * t
                    y = centre_y + side_x[1] * s + side_y[1] * t
                    if last < 0 or not holds(px, faces, sign, last, x, y):
                        last = find(px, faces, sign, grid, cols, starts, items, x, y)
                    under = last
                    if under < 0:
                        continue
                    second, third = weights(px, faces, under, x, y)
                u, v = _corner_mean(corner_values, under, second, third)
            count += 1
            if not textured:
                total += u
                continue
            entry = textures[under] * levels + level - base
            total += interpolate(
                texels,
                table[entry, 0],
                table[entry, 1],
                table[entry, 2],
                repeats[textures[under]],
                (u + 0.5) * shrink - 0.5,
                (v + 0.5) * shrink - 0.5,
            )
    return total / count if count > 0 else np.nan


@njit(cache=True, nogil=True, parallel=True)
def _shade_all(
    points: Floats,
    footprints: Floats,
    hints: Ints,
    px: Floats,
    faces: Ints,
    sign: float,
    grid: Floats,
    cols: int,
    starts: Ints,
    items: Ints,
    corner_values: Floats,
    gradients: Floats,
    slopes: Greys,
    textures: Ints,
    texels: Greys,
    table: Ints,
    base: int,
    repeats: Ints,
    grey: Greys,
    triangle: Ints,
) -> None:
    for n in prange(len(points)):
        x, y = points[n, 0], points[n, 1]
        k = hints[n] if len(hints) > 0 else -1
        if k < 0:
            k = find(px, faces, sign, grid, cols, starts, items, x, y)
        if k < 0:
            continue
        triangle[n] = k
        frame = footprints[min(np.int64(n), np.int64(len(footprints) - 1))]
        even = _reaches(slopes, x, y, frame)
        slope = gradients[k]
        if even:
            slope = slopes[int(np.rint(y)), int(np.rint(x))].astype(np.float64)
        mean = _mean_grey(
            x,
            y,
            frame,
            k,
            px,
            faces,
            sign,
            grid,
            cols,
            starts,
            items,
            corner_values,
            slope,
            even,
            textures,
            texels,
            table,
            base,
            repeats,
        )
        grey[n] = min(max(mean, 0.0), 1.0)


def shade(
    points: Floats,
    footprints: Floats,
    hints: Ints,
    px: Floats,
    faces: Ints,
    sign: float,
    grid: Floats,
    cols: int,
    starts: Ints,
    items: Ints,
    corner_values: Floats,
    gradients: Floats,
    slopes: Greys,
    textures: Ints,
    texels: Greys,
    table: Ints,
    base: int,
    repeats: Ints,
) -> tuple[Greys, Ints]:
    """Average the grey of a flattened surface over parallelograms of its chart.

    Parameters
    ----------
    points : (N, 2)
        Centres, px of the chart.
    footprints : (N, 2, 2) or (1, 2, 2)
        Sides of each parallelogram in its columns, px of the chart.
    hints : (N,) or (0,)
        Triangles to look into first; -1 where unknown.
    px, faces, sign, grid, cols, starts, items
        The chart and its buckets, as for :func:`shapemorph.kernels.locate.locate`.
    corner_values : (M, 3, 2)
        Position (x, y) of each corner in its full texture, texels; without textures the
        grey of the corner, twice.
    gradients : (M, 2, 2)
        d texel / d px of each triangle; without textures any measure of how fine the
        corners lie.
    slopes : (H, W, 2, 2)
        The same of each pixel of the chart where the texture is even all around it, NaN
        elsewhere; may be empty.
    textures : (M,)
        Texture of each triangle.
    texels : (T,)
        All coefficients; empty without textures.
    table : (textures * levels, 3)
        Offset, height and width.
    base : int
        Times that the first level is reduced already.
    repeats : (textures,)
        1 where a texture is continued periodically, 0 where by its border.

    Returns
    -------
    grey : (N,)
        NaN off the chart.
    triangle : (N,)
        Under each centre, -1 off the chart.
    """
    grey = np.full(len(points), np.nan, np.float32)
    triangle = np.full(len(points), -1, np.int64)
    _shade_all(
        points,
        footprints,
        hints,
        px,
        faces,
        sign,
        grid,
        cols,
        starts,
        items,
        corner_values,
        gradients,
        slopes,
        textures,
        texels,
        table,
        base,
        repeats,
        grey,
        triangle,
    )
    return grey, triangle


@njit(cache=True)
def _mean_of_picture(
    centre_x: float, centre_y: float, frame: Floats, texels: Greys, table: Ints
) -> float:
    """Mean grey of a picture over one parallelogram."""
    cos, sin = principal_turn(frame[0, 0], frame[0, 1], frame[1, 0], frame[1, 1])
    side_x = frame[0, 0] * cos + frame[0, 1] * sin, frame[1, 0] * cos + frame[1, 1] * sin
    side_y = frame[0, 1] * cos - frame[0, 0] * sin, frame[1, 1] * cos - frame[1, 0] * sin
    along_x, along_y = np.hypot(side_x[0], side_x[1]), np.hypot(side_y[0], side_y[1])
    level = choose_level(along_x, along_y, 0, len(table))
    shrink = 2.0**-level
    across, step_x = spread_samples(along_x * shrink)
    down, step_y = spread_samples(along_y * shrink)
    total = 0.0
    for j in range(down):
        for i in range(across):
            s, t = (i - 0.5 * (across - 1)) * step_x, (j - 0.5 * (down - 1)) * step_y
            x = centre_x + side_x[0] * s + side_y[0] * t
            y = centre_y + side_x[1] * s + side_y[1] * t
            total += interpolate(
                texels,
                table[level, 0],
                table[level, 1],
                table[level, 2],
                0,
                (x + 0.5) * shrink - 0.5,
                (y + 0.5) * shrink - 0.5,
            )
    return float(total / (across * down))


@njit(cache=True, nogil=True, parallel=True)
def _resample_all(
    points: Floats, footprints: Floats, texels: Greys, table: Ints, grey: Greys
) -> None:
    height, width = table[0, 1], table[0, 2]
    for n in prange(len(points)):
        x, y = points[n, 0], points[n, 1]
        if -0.5 <= x <= width - 0.5 and -0.5 <= y <= height - 0.5:
            mean = _mean_of_picture(x, y, footprints[n], texels, table)
            grey[n] = min(max(mean, 0.0), 1.0)


def resample(points: Floats, footprints: Floats, texels: Greys, table: Ints) -> Greys:
    """Average a picture over parallelograms.

    Parameters
    ----------
    points : (N, 2)
        Centres, px of the picture.
    footprints : (N, 2, 2)
        Sides of each parallelogram in its columns, px of the picture.
    texels : (T,)
        Coefficients of all levels.
    table : (levels, 3)
        Offset, height and width.

    Returns
    -------
    (N,)
        NaN where the centre lies beyond the picture's border.
    """
    grey = np.full(len(points), np.nan, np.float32)
    _resample_all(points, footprints, texels, table, grey)
    return grey
