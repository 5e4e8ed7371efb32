"""Grey of a flattened surface, read from its textures once."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.core.image import CalibratedImage, Chart
from shapemorph.core.mesh import TexturedMesh
from shapemorph.kernels import texture as kernel
from shapemorph.kernels.facets import affine_maps
from shapemorph.kernels.pyramid import reduce_by_two
from shapemorph.kernels.raster import Triangles
from shapemorph.kernels.texel_samples import SAMPLES, SHARPEST
from shapemorph.methods.chart_index import ChartIndex, index_chart
from shapemorph.methods.distortion import weighted_quantile
from shapemorph.methods.even_places import NOWHERE, even_slopes
from shapemorph.methods.spline_coefficients import to_coefficients

LEVELS = 8
UNHINTED = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class TextureStack:
    """Textures as spline coefficients at several reductions, in one flat array.

    Attributes
    ----------
    texels : (T,) float32
    table : (textures * levels, 3) int64
        Offset, height, width.
    base : int
        Times that the first level is reduced already.
    repeats : (textures,) int64
        1 where the texture is continued periodically.
    """

    texels: Greys
    table: Ints
    base: int
    repeats: Ints


@dataclass(frozen=True, slots=True, eq=False)
class TextureMap:
    """Where the textures of a surface lie under its chart.

    Attributes
    ----------
    index : ChartIndex
    corner_values : (M, 3, 2) float64
    gradients : (M, 2, 2) float64
    slopes : (H, W, 2, 2) float32
    textures : (M,) int64
        See :func:`shapemorph.kernels.texture.shade`.
    """

    index: ChartIndex
    corner_values: Floats
    gradients: Floats
    slopes: Greys
    textures: Ints


@dataclass(frozen=True, slots=True, eq=False)
class Shader:
    """Everything that reading grey on a chart needs.

    Attributes
    ----------
    under : TextureMap
    stack : TextureStack
    """

    under: TextureMap
    stack: TextureStack

    def shade(
        self, points: Floats, footprints: Floats, hints: Ints = UNHINTED
    ) -> tuple[Greys, Ints]:
        """Average the grey over parallelograms around points of the chart.

        Parameters
        ----------
        points : (N, 2)
            px of the chart.
        footprints : (N, 2, 2) or (1, 2, 2)
            Sides of the parallelograms in their columns, px.
        hints : (N,) or (0,)
            Triangles under the points where known.

        Returns
        -------
        grey : (N,)
            NaN off the chart.
        triangle : (N,)
            -1 off the chart.
        """
        under, stack = self.under, self.stack
        return kernel.shade(
            points,
            footprints,
            hints,
            *under.index.arguments,
            under.corner_values,
            under.gradients,
            under.slopes,
            under.textures,
            stack.texels,
            stack.table,
            stack.base,
            stack.repeats,
        )


def map_textures(
    mesh: TexturedMesh, chart: Chart, pixels: tuple[Triangles, Floats] | None = None
) -> TextureMap:
    """Find where the textures of a surface lie under its chart.

    Parameters
    ----------
    mesh : TexturedMesh
    chart : Chart
        Of that mesh.
    pixels : (H, W) int32 and (H, W, 2), or None
        Triangle and weights under the pixels of the chart: a shortcut where the texture is
        even; None takes none.
    """
    values, gradients = texel_map(mesh, chart)
    if not mesh.has_texture:
        textures, pixels = np.zeros(len(chart.faces), dtype=np.int64), None
    else:
        textures = np.ascontiguousarray(mesh.face_texture[chart.face_ids])
    slopes = NOWHERE if pixels is None else even_slopes(*pixels, values, textures)
    return TextureMap(index_chart(chart), values, gradients, slopes, textures)


@lru_cache(maxsize=1)
def map_under_image(mesh: TexturedMesh, image: CalibratedImage) -> TextureMap:
    """Do so under a calibrated image; the last answer is kept, as surfaces are morphed twice."""
    return map_textures(mesh, image.chart, (image.triangle, image.barycentric))


def prepare_shader(
    mesh: TexturedMesh,
    chart: Chart,
    under: TextureMap,
    *,
    texels_per_px: float = SAMPLES,
    narrowest: float = 1.0,
) -> Shader:
    """Gather what reading grey on a chart needs.

    Memory is one copy of the textures as float32, reduced as far as the chart allows,
    and a third on top.

    Parameters
    ----------
    mesh : TexturedMesh
    chart : Chart
        Of that mesh.
    under : TextureMap
        Of both.
    texels_per_px : float
        Textures are reduced while 95 % of the chart keeps half as many as this.
    narrowest : float
        Width of the narrowest footprints that will be asked for, px.
    """
    if mesh.has_texture:
        wanted = max(texels_per_px, SHARPEST / narrowest)
        stack = stack_textures(mesh, _reductions(chart, under.gradients, wanted))
    else:
        none = np.zeros((0, 3), dtype=np.int64)
        stack = TextureStack(np.zeros(0, np.float32), none, 0, np.zeros(0, np.int64))
    return Shader(under, stack)


def texel_map(mesh: TexturedMesh, chart: Chart) -> tuple[Floats, Floats]:
    """Map the triangles of a chart into their textures.

    Returns
    -------
    corner_values : (M, 3, 2)
        Texel coordinates (x, y) of every corner, texel centres at integers; the grey
        of the corner, twice, for meshes without textures.
    gradients : (M, 2, 2)
        d texel / d px; for meshes without textures, one texel is the distance between
        corners. Zero where the triangle has no area.
    """
    if not mesh.has_texture:
        grey = mesh.corner_grey[chart.face_ids]
        spacing = np.sqrt(2.0 * np.abs(_areas(chart.corner_px)))
        with np.errstate(divide="ignore"):
            density = np.where(spacing > 0, 1.0 / spacing, 0.0)
        return np.stack([grey, grey], axis=2), density[:, None, None] * np.eye(2)
    sizes = np.array([picture.shape for picture in mesh.textures])[mesh.face_texture]
    height, width = (sizes[chart.face_ids][:, axis][:, None] for axis in (0, 1))
    uv = mesh.wedge_uv[chart.face_ids]
    texels = np.stack([uv[..., 0] * width - 0.5, (1.0 - uv[..., 1]) * height - 0.5], axis=2)
    px, faces = np.ascontiguousarray(chart.vertex_px), np.ascontiguousarray(chart.faces)
    return texels, affine_maps(px, faces, texels)


def _areas(corners: Floats) -> Floats:
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas: Floats = 0.5 * (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    return areas


def texel_density(gradients: Floats) -> Floats:
    """Density of a texture under each triangle: square root of texels per px^2, (M,)."""
    (ux, uy), (vx, vy) = np.moveaxis(gradients, 0, -1)
    density: Floats = np.sqrt(np.abs(ux * vy - uy * vx))
    return density


def _reductions(chart: Chart, gradients: Floats, wanted: float) -> int:
    """Find how often textures may be halved before 5 % of the picture would notice."""
    areas = np.abs(_areas(chart.corner_px))
    density = weighted_quantile(texel_density(gradients), areas, 0.05)
    return max(int(np.floor(np.log2(max(density, 1e-9) / wanted))) + 1, 0)


@lru_cache(maxsize=1)
def stack_textures(mesh: TexturedMesh, base: int) -> TextureStack:
    """Reduce all textures of a mesh and turn them into spline coefficients.

    The last stack is kept: the deformed mesh is flattened, morphed and morphed again.
    """
    repeats = [int(_leaves_the_picture(mesh, index)) for index in range(len(mesh.textures))]
    texels, table = stack_pictures(mesh.textures, repeats, base=base, levels=LEVELS)
    return TextureStack(texels, table, base, np.array(repeats, dtype=np.int64))


def stack_pictures(
    pictures: Sequence[Greys], repeats: Sequence[int], *, base: int, levels: int
) -> tuple[Greys, Ints]:
    """Halve pictures again and again and turn each level into spline coefficients.

    Parameters
    ----------
    pictures : sequence of (H, W)
    repeats : sequence of int
        1 for each picture that goes on periodically.
    base : int
        Halvings before the first level that is kept.
    levels : int
        Levels of each picture.

    Returns
    -------
    texels : (T,)
        All coefficients.
    table : (pictures * levels, 3)
        Offset, height and width, level after level, picture after picture.
    """
    shapes = np.array(
        [
            [-(-size // 2**level) for size in picture.shape]
            for picture in pictures
            for level in range(base, base + levels)
        ]
    )
    offsets = np.concatenate([[0], np.cumsum(shapes.prod(axis=1))])
    texels = np.empty(offsets[-1], np.float32)
    for index, picture in enumerate(pictures):
        reduced = np.asarray(picture, dtype=np.float32)
        for _ in range(base):
            reduced = reduce_by_two(reduced)
        for slot in range(index * levels, (index + 1) * levels):
            level = texels[offsets[slot] : offsets[slot + 1]].reshape(shapes[slot])
            level[:] = reduced
            to_coefficients(level, repeats[index])
            reduced = reduce_by_two(reduced)
    return texels, np.column_stack([offsets[:-1], shapes]).astype(np.int64)


def _leaves_the_picture(mesh: TexturedMesh, index: int) -> bool:
    """Whether some face asks for texture beyond the picture by more than a texel."""
    uv = mesh.wedge_uv[mesh.face_texture == index]
    if len(uv) == 0:
        return False
    height, width = mesh.textures[index].shape
    slack = np.array([1.0 / width, 1.0 / height])
    low, high = uv.min(axis=(0, 1)), uv.max(axis=(0, 1))
    return bool((low < -slack).any() or (high > 1 + slack).any())
