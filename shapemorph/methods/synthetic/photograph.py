"""Photographs of a speckled sheet: lens, perspective, light, blur and noise."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.interpolate import RectBivariateSpline

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.core.camera import Camera
from shapemorph.core.spline_map import SplineMap
from shapemorph.kernels.raster import rasterise
from shapemorph.kernels.scene import meet_rays, photograph
from shapemorph.methods.synthetic.membrane.smooth import map_points
from shapemorph.methods.synthetic.painting import BRIGHT, DARK, record_grey
from shapemorph.methods.synthetic.speckle import Speckle

BESIDE = 0.04  # grey of what is not the sheet
LENS_KNOTS = 16  # px: the lens bends rays by polynomials, which a spline through these repeats
NODES = 4  # per coefficient of the map, to find near where rays meet the sheet


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """A round sheet with its speckle, in one state.

    Attributes
    ----------
    mapped : SplineMap
    radius : float
        Around material (0, 0), mm.
    speckle : Speckle
    dark : (float, float)
        Radius around material (0, 0) over which the sheet is dark, mm, and the share of its
        light that is lost in the middle.
    """

    mapped: SplineMap
    radius: float
    speckle: Speckle
    dark: tuple[float, float] = (1.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Studio:
    """Light and sensor.

    Attributes
    ----------
    lights : (L, 4) float64
        Unit vector towards each light in the world, and its strength.
    ambient : float
    gloss, hardness : float
        Strength of highlights, and the power that makes them small.
    samples : int
        Along each side of a pixel.
    blur_px : float
        Standard deviation of the blur of lens and sensor, px.
    noise : float
        Standard deviation of the grey, levels of 255.
    """

    lights: Floats
    ambient: float
    gloss: float
    hardness: float
    samples: int
    blur_px: float
    noise: float


def take_picture(
    sheet: Sheet,
    camera: Camera,
    studio: Studio,
    rng: np.random.Generator,
    beside: Floats | None = None,
) -> tuple[Greys, Floats]:
    """Photograph a sheet.

    Every sample of a pixel looks along its own ray, which meets the exact surface, and sees
    the speckle of the material there; then come blur, noise and whole grey levels.

    Parameters
    ----------
    sheet : Sheet
    camera : Camera
    studio : Studio
    rng : numpy.random.Generator
        Of the noise.
    beside : (H, W) or None
        Grey of what stands behind the sheet; None: of one dark grey.

    Returns
    -------
    grey : (H, W) float32
        Whole levels of 255, in [0, 1].
    material : (H, W, 2) float64
        Material coordinates at pixel centres, mm; NaN beside the sheet.
    """
    width, height = camera.size
    own = seen_by(sheet.mapped, camera)
    lights = studio.lights.copy()
    lights[:, :3] = camera.pose.rotate(lights[:, :3])
    grey, material = photograph(
        own.coefficients,
        np.array([*own.origin, own.spacing]),
        _rays(camera),
        _guess(sheet, camera).reshape(height, width, 2),
        sheet.radius,
        sheet.speckle.blobs,
        sheet.speckle.origin,
        sheet.speckle.cell,
        sheet.speckle.edge,
        np.array([DARK, BRIGHT]),
        np.full((height, width), BESIDE) if beside is None else beside,
        lights,
        np.array([studio.ambient, studio.gloss, studio.hardness]),
        studio.samples,
    )
    _darken(grey, material, sheet.dark)
    soft = ndimage.gaussian_filter(grey.astype(np.float32), studio.blur_px, mode="nearest")
    return record_grey(soft, noise=studio.noise, rng=rng), material


def _darken(grey: Floats, material: Floats, dark: tuple[float, float]) -> None:
    """Take light from the middle of the sheet, in place."""
    radius, share = dark
    on = np.isfinite(material[..., 0])
    away = (material[on] ** 2).sum(axis=1) / radius**2
    grey[on] *= 1.0 - share * np.exp(-away)


def seen_by(mapped: SplineMap, camera: Camera) -> SplineMap:
    """Give the map into the frame of a camera: splines go with rigid motions."""
    return SplineMap(camera.pose.apply(mapped.coefficients), mapped.origin, mapped.spacing)


def material_at(sheet: Sheet, camera: Camera, pixels: Floats) -> Floats:
    """Material coordinates (N, 2) that a camera sees at pixels (N, 2), mm; NaN beside the sheet."""
    guess = _guess(sheet, camera).reshape(camera.size[1], camera.size[0], 2)
    known: Bools = np.asarray(np.isfinite(pixels).all(axis=1))
    place = np.rint(np.where(known[:, None], pixels, 0)).astype(np.int64)
    inside = known & ((place >= 0) & (place < camera.size)).all(axis=1)
    near = np.full(pixels.shape, np.nan)
    near[inside] = guess[place[inside, 1], place[inside, 0]]
    rays = camera.normalised(np.where(known[:, None], pixels, 0.0))
    own = seen_by(sheet.mapped, camera)
    found: Floats = own.origin + own.spacing * meet_rays(own.coefficients, rays, near)
    found[~(np.linalg.norm(found, axis=1) <= sheet.radius)] = np.nan
    return found


def _rays(camera: Camera) -> Floats:
    """(H + 2, W + 2, 2) directions of pixel centres and of those around the picture."""
    width, height = camera.size
    x, y = np.arange(-1.0, width + 1), np.arange(-1.0, height + 1)
    columns = np.linspace(x[0], x[-1], max(width // LENS_KNOTS, 4))
    rows = np.linspace(y[0], y[-1], max(height // LENS_KNOTS, 4))
    bent = camera.normalised(np.stack(np.meshgrid(columns, rows), axis=-1))
    return np.stack([RectBivariateSpline(rows, columns, bent[..., k])(y, x) for k in range(2)], -1)


def _guess(sheet: Sheet, camera: Camera) -> Floats:
    """(H W, 2) places on the map, in its units, near where pixels see the outer side; else NaN."""
    nodes, faces = _nodes(sheet)
    points, _ = map_points(sheet.mapped, nodes)
    pixels = camera.project(points)
    seen: Bools = np.asarray(np.isfinite(pixels[faces]).all(axis=(1, 2)))
    faces = faces[seen]
    depth = camera.pose.apply(points)[faces, 2].mean(axis=1)
    faces = faces[np.argsort(depth, kind="stable")]  # the nearer of two is in front
    width, height = camera.size
    triangle, weights, _ = rasterise(np.nan_to_num(pixels), faces, -1.0, height, width)
    corners = (nodes[faces] - sheet.mapped.origin) / sheet.mapped.spacing
    hit = triangle.ravel() >= 0
    guess = np.full((height * width, 2), np.nan)
    own, share = corners[triangle.ravel()[hit]], weights.reshape(-1, 2)[hit]
    guess[hit] = own[:, 0] + np.einsum("nk,nkd->nd", share, own[:, 1:] - own[:, :1])
    return guess


def _nodes(sheet: Sheet) -> tuple[Floats, Ints]:
    """Material points (N, 2) over the sheet and a little beyond, and faces between them."""
    pitch = sheet.mapped.spacing / NODES
    reach = sheet.radius + 2 * pitch
    count = 2 * int(np.ceil(reach / pitch)) + 1
    line = pitch * (np.arange(count) - count // 2)
    nodes = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    number = np.arange(count * count).reshape(count, count)
    low, right, up, far = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    faces = np.concatenate(
        [np.stack(part, axis=-1).reshape(-1, 3) for part in ((low, right, far), (low, far, up))]
    )
    near = np.linalg.norm(nodes, axis=1) <= reach
    return nodes, faces[near[faces].all(axis=1)]
