"""Photographs of targets by cameras that are known exactly."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Greys
from shapemorph.core.calibration import Target
from shapemorph.core.camera import Camera
from shapemorph.core.transform import RigidTransform

LIGHT, DARK = 0.85, 0.12
"""Grey of the ground of a target, and of what is printed on it."""
_GOLDEN = 0.382
_FACING = 0.15  # cosine: dots more slanted than that are not drawn
Pattern = Callable[[Floats], Floats]


@dataclass(frozen=True, slots=True, eq=False)
class Exposure:
    """What happens between lens and file.

    Attributes
    ----------
    samples : int
        In each pixel, averaged.
    blur : float
        Standard deviation of the sensor's blur, px.
    noise : float
        Standard deviation of the grey noise, levels of 255.
    seed : int
    """

    samples: int
    blur: float
    noise: float
    seed: int


class Film:
    """Directions in which the pixels of a camera look, and how they turn within a pixel."""

    def __init__(self, camera: Camera) -> None:
        width, height = camera.size
        self.camera = camera
        rows, columns = np.mgrid[:height, :width]
        pixels = np.stack([columns, rows], axis=-1).astype(np.float64)
        self.flat = camera.normalised(pixels)
        self._across = self._step(pixels, np.array([0.5, 0.0]))
        self._down = self._step(pixels, np.array([0.0, 0.5]))

    def _step(self, pixels: Floats, half: Floats) -> Floats:
        ahead, behind = self.camera.normalised(pixels + half), self.camera.normalised(pixels - half)
        return ahead - behind

    def within(
        self,
        right: float,
        down: float,
        window: tuple[slice, slice] = (slice(None), slice(None)),
    ) -> Floats:
        """Give the directions (h, w, 2) of places beside the pixel centres of a window, px."""
        seen: Floats = self.flat[window] + right * self._across[window] + down * self._down[window]
        return seen


def photograph_plane(
    film: Film, pose: RigidTransform, pattern: Pattern, exposure: Exposure
) -> Greys:
    """Photograph a plane with a pattern.

    Parameters
    ----------
    film : Film
    pose : RigidTransform
        world_from_target; the pattern lies in the plane z = 0 of the target.
    pattern : callable
        Grey (...,) at points (..., 2) of the plane, mm.
    exposure : Exposure

    Returns
    -------
    (H, W) float32
        In [0, 1], rounded to 8 bits.
    """
    camera = film.camera.pose
    rotation = camera.rotation @ pose.rotation
    origin = camera.apply(pose.translation)
    shade = np.zeros(film.flat.shape[:2])
    for right, down in _within_pixel(exposure.samples):
        flat = film.within(right, down)
        rays = np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1)
        depth = (origin @ rotation[:, 2]) / (rays @ rotation[:, 2])
        places = (rays * depth[..., None] - origin) @ rotation[:, :2]
        shade += np.where(depth > 0, pattern(places), DARK)
    return exposed(shade / exposure.samples, exposure)


def photograph_dots(film: Film, pose: RigidTransform, target: Target, exposure: Exposure) -> Greys:
    """Photograph the dots of a target in space, each a disc in its tangent plane.

    Only dots that face the camera are drawn, on an even ground; see :func:`photograph_plane`.
    """
    return exposed(shade_dots(film, pose, target, exposure.samples), exposure)


def shade_dots(film: Film, pose: RigidTransform, target: Target, samples: int) -> Floats:
    """Draw what :func:`photograph_dots` photographs, (H, W), without blur and noise."""
    camera = film.camera
    own = camera.pose.apply(pose.apply(target.points))
    up = np.array([[0.0, 0.0, 1.0]]) if target.normals is None else target.normals
    normals = camera.pose.rotate(pose.rotate(up)) + np.zeros_like(own)
    shade = np.full(film.flat.shape[:2], LIGHT)
    for centre, normal in zip(own, normals, strict=True):
        if target.normals is None or -(centre @ normal) > _FACING * np.linalg.norm(centre):
            _draw_disc(shade, film, centre, normal, target.dot_radius, samples)
    return shade


def _draw_disc(
    shade: Floats, film: Film, centre: Floats, normal: Floats, radius: float, samples: int
) -> None:
    """Darken the pixels that a disc covers by the share that it covers."""
    camera = film.camera
    middle = camera.placed(RigidTransform.identity()).project(centre)
    if not np.isfinite(middle).all():
        return
    reach = 1.5 * radius * float(camera.focal.max()) / float(centre[2]) + 3
    height, width = shade.shape
    (x0, y0), (x1, y1) = np.floor(middle - reach).astype(int), np.ceil(middle + reach).astype(int)
    rows = slice(max(y0, 0), min(y1, height))
    columns = slice(max(x0, 0), min(x1, width))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        return
    cover = np.zeros((rows.stop - rows.start, columns.stop - columns.start))
    for right, down in _within_pixel(samples):
        flat = film.within(right, down, (rows, columns))
        rays = np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1)
        hits = rays * ((centre @ normal) / (rays @ normal))[..., None]
        cover += np.linalg.norm(hits - centre, axis=-1) < radius
    shade[rows, columns] -= (LIGHT - DARK) * cover / samples


def _within_pixel(samples: int) -> list[tuple[float, float]]:
    """Places in a pixel, no two in one row or column, so that straight edges are smooth."""
    step = max(round(samples * _GOLDEN), 1)
    while np.gcd(step, samples) > 1:
        step += 1
    along = np.arange(samples)
    places = (np.stack([along, along * step % samples], axis=-1) + 0.5) / samples - 0.5
    return [(float(right), float(down)) for right, down in places]


def exposed(shade: Floats, exposure: Exposure) -> Greys:
    """Blur, add noise, and round to 8 bits."""
    from scipy.ndimage import gaussian_filter

    if exposure.blur > 0:
        shade = gaussian_filter(shade, exposure.blur, mode="nearest")
    rng = np.random.default_rng(exposure.seed)
    levels = 255 * shade + rng.normal(0.0, exposure.noise, shade.shape)
    return (np.clip(np.round(levels), 0, 255) / 255).astype(np.float32)


def chessboard_pattern(columns: int, rows: int, spacing: float) -> Pattern:
    """Make a chessboard with inner corners at whole multiples of the spacing, from (0, 0).

    One white square lies around it.
    """

    def grey(places: Floats) -> Floats:
        x, y = places[..., 0] / spacing, places[..., 1] / spacing
        on = (x > -1) & (x < columns) & (y > -1) & (y < rows)
        black = on & ((np.floor(x) + np.floor(y)) % 2 == 0)
        return np.where(black, DARK, LIGHT)

    return grey


def picture_pattern(picture: Greys, px_per_mm: float) -> Pattern:
    """Make a pattern of a printed picture whose upper left corner is at (0, 0); linear."""
    from scipy.ndimage import map_coordinates

    def grey(places: Floats) -> Floats:
        at = places * px_per_mm - 0.5
        found: Floats = map_coordinates(
            picture.astype(np.float64), [at[..., 1], at[..., 0]], order=1, cval=LIGHT
        )
        return found

    return grey
