"""Choose how many pixels a millimetre gets: by the speckle, within what the texture holds."""

from dataclasses import dataclass, replace

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.core.image import Chart
from shapemorph.core.mesh import TexturedMesh
from shapemorph.kernels.raster import Triangles, rasterise
from shapemorph.methods.charting import chart_at_scale, picture_shape
from shapemorph.methods.distortion import (
    chart_distortion,
    chart_handedness,
    local_scale,
    weighted_quantile,
)
from shapemorph.methods.parametrize.disk import Piece
from shapemorph.methods.shading import map_textures, prepare_shader, texel_density, texel_map
from shapemorph.methods.speckle import TILE, choose_tiles, tile_widths

PROBES = 6
FIRST_PROBE = 3.0  # times coarser than the texture
PROBE_TEXELS = 1.5  # texels per pixel that suffice to see how wide a speckle is
SHARP, BLURRED = 3.5, 12.0  # px across a speckle between which a probe is trusted
LEAST_SPECKLE = 3.0  # px; 95 % of the tiles should show larger speckles
MOST_FINER = 1.5  # factor that the above may refine the picture by
LEAST_ACROSS = 300.0  # px, square root of the area of the picture


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """What the texture shows on the surface.

    Attributes
    ----------
    speckle_mm : (K,) float64
        Size of a speckle on the surface, tile by tile.
    chart_scale : (K,) float64
        Local scale of the flattening there, 1 at the median of the area.
    texels_per_mm : float
        Density of the texture in a flattening at scale 1, median by area.
    area : float
        Of the flattened surface in the plane at scale 1, mm^2.
    """

    speckle_mm: Floats
    chart_scale: Floats
    texels_per_mm: float
    area: float

    @property
    def typical_mm(self) -> float:
        """Size of a speckle, median over the surface."""
        return weighted_quantile(self.speckle_mm, self.chart_scale**-2.0, 0.5)

    @property
    def typical_chart_mm(self) -> float:
        """Size of a speckle in the plane at scale 1, median over the surface."""
        shown = self.speckle_mm * self.chart_scale
        return weighted_quantile(shown, self.chart_scale**-2.0, 0.5)


def measure_pattern(
    mesh: TexturedMesh, piece: Piece, plane: Floats, *, max_megapixels: float
) -> Pattern:
    """Measure the speckle of a mesh in tiles of trial pictures.

    Each trial changes the scale until a speckle is several pixels wide, or the texture
    has no more detail to give, or the picture grows too large.

    Parameters
    ----------
    mesh : TexturedMesh
    piece : Piece
    plane : (N, 2)
        mm, median scale 1.
    max_megapixels : float
        Of a trial picture.

    Raises
    ------
    DataError
        If the texture shows no pattern.
    """
    chart = chart_at_scale(piece, plane, px_per_mm=1.0)
    distortion = chart_distortion(mesh.vertices, chart)
    density = _texture_density(mesh, chart, distortion.area)
    finest = min(density, scale_of_size(plane, max_megapixels))
    coarsest = min(2.0 * TILE / max(float(np.ptp(plane, axis=0).min()), 1e-300), finest)
    px_per_mm, scale = max(finest / FIRST_PROBE, coarsest), local_scale(distortion)
    for _ in range(PROBES):
        trial = chart_at_scale(piece, plane, px_per_mm=px_per_mm)
        pattern = replace(_probe(mesh, trial, scale), texels_per_mm=density)
        shown = pattern.typical_chart_mm * px_per_mm
        if SHARP <= shown <= BLURRED:
            break
        change = np.clip(6.0 / shown, 0.25, 4.0) if np.isfinite(shown) else 0.0
        wanted = float(np.clip(px_per_mm * change, coarsest, finest))
        if wanted == px_per_mm:
            break
        px_per_mm = wanted
    if not np.isfinite(shown):
        raise DataError(
            f"{mesh.name}: expected a pattern, got a texture that is uniform where the mesh "
            "uses it: check that it is the right picture"
        )
    return pattern


def _texture_density(mesh: TexturedMesh, chart: Chart, area: Floats) -> float:
    """Texels per pixel of a chart, median by area on the surface."""
    _, gradients = texel_map(mesh, chart)
    density = weighted_quantile(texel_density(gradients), area, 0.5)
    if not density > 0:
        raise DataError(
            f"{mesh.name}: expected texture coordinates that span an area, got single points: "
            "export the mesh with its UV map"
        )
    return density


def _probe(mesh: TexturedMesh, chart: Chart, scale: Floats) -> Pattern:
    """Measure the speckle in tiles of one trial picture; only the tiles are read."""
    height, width = (max(size, TILE) for size in picture_shape(chart))
    px, faces = np.ascontiguousarray(chart.vertex_px), np.ascontiguousarray(chart.faces)
    triangle, barycentric, _ = rasterise(px, faces, chart_handedness(chart), height, width)
    mask = triangle >= 0
    tiles = choose_tiles(mask)
    wanted = np.zeros_like(mask)
    for row, col in tiles:
        wanted[row : row + TILE, col : col + TILE] = True
    rows, cols = np.nonzero(wanted & mask)
    points = np.stack([cols, rows], axis=1).astype(np.float64)
    hints = triangle[rows, cols].astype(np.int64)
    grey = np.zeros((height, width), np.float32)
    under = map_textures(mesh, chart, (triangle, barycentric))
    shader = prepare_shader(mesh, chart, under, texels_per_px=PROBE_TEXELS)
    grey[rows, cols], _ = shader.shade(points, np.eye(2)[None], hints)
    local = np.array([_scale_of_tile(scale, triangle, row, col) for row, col in tiles])
    widths = tile_widths(grey, mask, tiles) / chart.px_per_mm
    return Pattern(widths / local, local, np.nan, int(mask.sum()) / chart.px_per_mm**2)


def _scale_of_tile(scale: Floats, triangle: Triangles, row: int, col: int) -> float:
    """Median of the local scale over the pixels of a tile."""
    under = triangle[row : row + TILE, col : col + TILE]
    return float(np.nanmedian(scale[under[under >= 0]]))


def scale_of_size(plane: Floats, megapixels: float) -> float:
    """Scale, px per mm, at which a flattening in mm fills a picture of a given size."""
    return float(np.sqrt(1e6 * megapixels / max(np.ptp(plane, axis=0).prod(), 1e-300)))


def choose_scale(
    pattern: Pattern,
    plane: Floats,
    *,
    speckle_px: float,
    max_megapixels: float,
    px_per_mm: float | None,
) -> tuple[float, str]:
    """Choose the scale of a calibrated image.

    Parameters
    ----------
    pattern : Pattern
    plane : (N, 2)
        mm, median scale 1.
    speckle_px : float
        Wanted size of a speckle.
    max_megapixels : float
        Of the whole picture.
    px_per_mm : float or None
        A scale that somebody asked for; None chooses.

    Returns
    -------
    px_per_mm : float
    reason : str
        For people.
    """
    finest = scale_of_size(plane, max_megapixels)
    if px_per_mm is not None:
        if px_per_mm <= finest:
            return px_per_mm, f"{px_per_mm:.4g} px/mm as asked"
        return finest, (
            f"{finest:.4g} px/mm: the {px_per_mm:.4g} px/mm asked for would make more than "
            f"flatten.max_megapixels = {max_megapixels:g}"
        )
    scale, reason = _by_speckle(pattern, speckle_px)
    across = float(np.sqrt(pattern.area))
    if scale * across < LEAST_ACROSS:
        scale, reason = LEAST_ACROSS / across, f"about {LEAST_ACROSS:.0f} px across the surface"
    if scale > pattern.texels_per_mm:
        scale, reason = pattern.texels_per_mm, "one pixel per texel, the texture has no more"
    if scale > finest:
        scale, reason = finest, f"flatten.max_megapixels = {max_megapixels:g} allows no more"
    return scale, f"{scale:.4g} px/mm: {reason}"


def _by_speckle(pattern: Pattern, speckle_px: float) -> tuple[float, str]:
    known = np.isfinite(pattern.speckle_mm)
    shown = pattern.speckle_mm[known] * pattern.chart_scale[known]
    surface = pattern.chart_scale[known] ** -2.0
    small, median = (weighted_quantile(shown, surface, share) for share in (0.05, 0.5))
    scale = speckle_px / median
    if small * scale < LEAST_SPECKLE:
        finer = scale * min(LEAST_SPECKLE / (small * scale), MOST_FINER)
        return finer, (
            f"a speckle of {pattern.typical_mm:.3g} mm shows {median * finer:.2g} px wide, refined "
            f"so that it has {small * finer:.2g} px where the map shrinks the surface most"
        )
    return scale, f"a speckle of {pattern.typical_mm:.3g} mm shows {speckle_px:g} px wide"
