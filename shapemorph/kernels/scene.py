"""Rays of a camera against a smooth surface: where they meet it and what they see there.

A ray (x, y) of a camera meets the surface where two planes through it do:
X_c - x Z_c = 0 and Y_c - y Z_c = 0 with the point in the frame of the camera. Newton's
method on both finds the material coordinates.
"""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Floats
from shapemorph.kernels.bspline import cubic_slopes, cubic_weights
from shapemorph.kernels.painting import speckle_brightness

STEPS = 12
MET = 1e-6  # mm between a ray and the surface before the last step, which squares it


@njit(cache=True)
def _surface(spline: Floats, u: float, v: float, point: Floats) -> bool:
    """Position and derivatives (3, 3) of the spline, in its own units; False outside."""
    height, width = spline.shape[0], spline.shape[1]
    if not (1.0 <= u <= width - 2.0 and 1.0 <= v <= height - 2.0):
        return False
    col, row = min(int(u), width - 3), min(int(v), height - 3)
    wx, wy = cubic_weights(u - col), cubic_weights(v - row)
    sx, sy = cubic_slopes(u - col), cubic_slopes(v - row)
    point[:] = 0.0
    for j in range(4):
        for i in range(4):
            weight, along, down = wy[j] * wx[i], wy[j] * sx[i], sy[j] * wx[i]
            for k in range(3):
                c = spline[row - 1 + j, col - 1 + i, k]
                point[0, k] += weight * c
                point[1, k] += along * c
                point[2, k] += down * c
    return True


@njit(cache=True)
def _meet(
    spline: Floats, x: float, y: float, u: float, v: float, steps: int, point: Floats
) -> tuple[float, float]:
    """Where a ray meets the surface, from a guess near by; NaN where it does not."""
    for _ in range(steps):
        if not _surface(spline, u, v, point):
            return np.nan, np.nan
        a = point[0, 0] - x * point[0, 2]
        b = point[0, 1] - y * point[0, 2]
        au, av = point[1, 0] - x * point[1, 2], point[2, 0] - x * point[2, 2]
        bu, bv = point[1, 1] - y * point[1, 2], point[2, 1] - y * point[2, 2]
        det = au * bv - av * bu
        if det == 0.0:
            return np.nan, np.nan
        du, dv = (av * b - bv * a) / det, (bu * a - au * b) / det
        u, v = u + du, v + dv
        if abs(a) + abs(b) < MET:
            return u, v
    return np.nan, np.nan


@njit(cache=True, nogil=True, parallel=True)
def meet_rays(spline: Floats, rays: Floats, guess: Floats) -> Floats:
    """Find where rays meet the surface.

    Parameters
    ----------
    spline : (R, C, 3)
        Coefficients of the surface in the frame of the camera, mm.
    rays : (N, 2)
        Directions (x, y, 1).
    guess : (N, 2)
        Near by, in units of the spline; NaN: none.

    Returns
    -------
    (N, 2)
        In units of the spline; NaN where a ray misses.
    """
    found = np.full(guess.shape, np.nan)
    for k in prange(len(rays)):
        point = np.empty((3, 3))
        if not np.isnan(guess[k, 0]):
            found[k, 0], found[k, 1] = _meet(
                spline, rays[k, 0], rays[k, 1], guess[k, 0], guess[k, 1], STEPS, point
            )
    return found


@njit(cache=True)
def _light(
    point: Floats, lights: Floats, ambient: float, gloss: float, hardness: float
) -> tuple[float, float]:
    """Diffuse and mirrored light at a point, normal turned to the camera."""
    nx = point[1, 1] * point[2, 2] - point[1, 2] * point[2, 1]
    ny = point[1, 2] * point[2, 0] - point[1, 0] * point[2, 2]
    nz = point[1, 0] * point[2, 1] - point[1, 1] * point[2, 0]
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    back = -np.sqrt(point[0, 0] ** 2 + point[0, 1] ** 2 + point[0, 2] ** 2)
    ex, ey, ez = point[0, 0] / back, point[0, 1] / back, point[0, 2] / back
    if nx * ex + ny * ey + nz * ez < 0.0:
        length = -length
    nx, ny, nz = nx / length, ny / length, nz / length
    diffuse, mirrored = ambient, 0.0
    for k in range(len(lights)):
        lx, ly, lz, strength = lights[k, 0], lights[k, 1], lights[k, 2], lights[k, 3]
        diffuse += strength * max(0.0, nx * lx + ny * ly + nz * lz)
        hx, hy, hz = lx + ex, ly + ey, lz + ez
        half = np.sqrt(hx * hx + hy * hy + hz * hz)
        facing = (nx * hx + ny * hy + nz * hz) / max(half, 1e-12)
        if facing > 0.0:
            mirrored += strength * gloss * facing**hardness
    return diffuse, mirrored


@njit(cache=True, nogil=True, parallel=True)
def photograph(
    spline: Floats,
    plane: Floats,
    rays: Floats,
    guess: Floats,
    radius: float,
    blobs: Floats,
    origin: Floats,
    cell: Floats,
    edge: float,
    greys: Floats,
    beside: Floats,
    lights: Floats,
    surface: Floats,
    samples: int,
) -> tuple[Floats, Floats]:
    """Draw a speckled sheet as a camera without blur and noise sees it.

    Parameters
    ----------
    spline : (R, C, 3)
        Coefficients of the sheet in the frame of the camera, mm.
    plane : (3,)
        Material coordinates of coefficient [0, 0] and distance of coefficients, mm.
    rays : (H + 2, W + 2, 2)
        Direction (x, y, 1) of every pixel centre and of those around the picture.
    guess : (H, W, 2)
        Near where each pixel meets the sheet, in units of the spline; NaN: nowhere.
    radius : float
        Of the sheet around material (0, 0), mm.
    blobs, origin, cell, edge
        The speckle; see :func:`shapemorph.kernels.painting.paint`.
    greys : (2,)
        Of blobs and between blobs, 0 to 1.
    beside : (H, W)
        Grey of what is seen beside the sheet.
    lights : (L, 4)
        Unit vector towards each light in the frame of the camera, and its strength.
    surface : (3,)
        Ambient light, gloss and hardness of highlights.
    samples : int
        Along each side of a pixel.

    Returns
    -------
    grey : (H, W)
        Mean over the area of each pixel, above 1 where the sensor saturates.
    material : (H, W, 2)
        Material coordinates at pixel centres, mm; NaN beside the sheet.
    """
    height, width = guess.shape[0], guess.shape[1]
    grey = beside.copy()
    material = np.full((height, width, 2), np.nan)
    dark, span = greys[0], greys[1] - greys[0]
    for row in prange(height):
        point = np.empty((3, 3))
        for col in range(width):
            if np.isnan(guess[row, col, 0]):
                continue
            x, y = rays[row + 1, col + 1, 0], rays[row + 1, col + 1, 1]
            u, v = _meet(spline, x, y, guess[row, col, 0], guess[row, col, 1], STEPS, point)
            if np.isnan(u):
                continue
            diffuse, mirrored = _light(point, lights, surface[0], surface[1], surface[2])
            px, py = plane[0] + u * plane[2], plane[1] + v * plane[2]
            if px * px + py * py <= radius * radius:
                material[row, col, 0], material[row, col, 1] = px, py
            # the ray of a place in the pixel, and where it meets the plane that touches
            ax = 0.5 * (rays[row + 1, col + 2, 0] - rays[row + 1, col, 0])
            ay = 0.5 * (rays[row + 1, col + 2, 1] - rays[row + 1, col, 1])
            bx = 0.5 * (rays[row + 2, col + 1, 0] - rays[row, col + 1, 0])
            by = 0.5 * (rays[row + 2, col + 1, 1] - rays[row, col + 1, 1])
            au, av = point[1, 0] - x * point[1, 2], point[2, 0] - x * point[2, 2]
            bu, bv = point[1, 1] - y * point[1, 2], point[2, 1] - y * point[2, 2]
            det, depth = au * bv - av * bu, point[0, 2]
            total = 0.0
            for j in range(samples):
                down = (j + 0.5) / samples - 0.5
                for i in range(samples):
                    along = (i + 0.5) / samples - 0.5
                    dx, dy = ax * along + bx * down, ay * along + by * down
                    su = u + depth * (bv * dx - av * dy) / det
                    sv = v + depth * (au * dy - bu * dx) / det
                    if samples > 1:
                        su, sv = _meet(spline, x + dx, y + dy, su, sv, 4, point)
                    sx, sy = plane[0] + su * plane[2], plane[1] + sv * plane[2]
                    if sx * sx + sy * sy <= radius * radius:
                        bright = speckle_brightness(sx, sy, blobs, origin, cell, edge)
                        total += (dark + span * bright) * diffuse + mirrored
                    else:
                        total += beside[row, col]
            grey[row, col] = total / (samples * samples)
    return grey, material
