"""Pictures that correlation works on, and those that remember where each pixel lies in space."""

from dataclasses import dataclass, field

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.core.errors import DataError


@dataclass(frozen=True, slots=True, weakref_slot=True, eq=False)
class GreyImage:
    """Grey levels with the region where they mean something.

    Attributes
    ----------
    grey : (H, W) float32
        In [0, 1]; any finite value outside the mask.
    mask : (H, W) bool
        Where the picture shows the specimen.
    """

    grey: Greys
    mask: Bools

    def __post_init__(self) -> None:
        if self.grey.ndim != 2 or self.grey.shape != self.mask.shape:
            raise DataError(
                f"grey and mask must be two (H, W) arrays of one shape, got {self.grey.shape} "
                f"and {self.mask.shape}"
            )

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""
        height, width = self.grey.shape
        return height, width


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """A piece of surface laid out in the plane.

    A chart has its own vertices: where the surface was cut to lie flat, one vertex of
    the mesh appears several times.

    Attributes
    ----------
    vertex_ids : (N,) int64
        Vertex of the mesh that each vertex of the chart is a copy of.
    faces : (M, 3) int64
        Triangles in vertices of the chart. The picture shows the outer side, unmirrored:
        faces that are counter-clockwise seen from outside are so on the screen, with
        negative signed area ``(x1-x0)(y2-y0) - (x2-x0)(y1-y0)`` in (x right, y down) px.
        Of a mesh without an outer side it shows the side that the other shape shows.
    face_ids : (M,) int64
        Face of the mesh that each triangle is; its corners are in the same order.
    vertex_px : (N, 2) float64
        Position (x, y) in px, pixel centres at integers.
    px_per_mm : float
        Nominal image scale.
    page_starts : (P,) int64
        A surface that no single piece of the plane can hold well lies on several pages,
        side by side: the first column of each, px.
    home : (M,) bool or None
        Where pages show the same face: whether this triangle is the one that counts.
        None: all do.
    """

    vertex_ids: Ints
    faces: Ints
    face_ids: Ints
    vertex_px: Floats
    px_per_mm: float
    page_starts: Ints = field(default_factory=lambda: np.zeros(1, dtype=np.int64))
    home: Bools | None = None

    def __post_init__(self) -> None:
        if len(self.vertex_ids) != len(self.vertex_px) or len(self.faces) != len(self.face_ids):
            raise DataError("a chart needs a position per vertex and a face id per triangle")

    @property
    def page_count(self) -> int:
        """Number of pages."""
        return len(self.page_starts)

    @property
    def corner_px(self) -> Floats:
        """(M, 3, 2) position of every corner of every triangle, px."""
        corners: Floats = self.vertex_px[self.faces]
        return corners


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedImage:
    """A flattened textured surface: every pixel keeps its place on the mesh.

    Attributes
    ----------
    image : GreyImage
        The pattern; the mask is where a face covers the pixel centre.
    chart : Chart
        How the surface was laid out.
    triangle : (H, W) int32
        Triangle *of the chart* under each pixel centre, -1 outside.
    barycentric : (H, W, 2) float64
        Weights of the second and third corner; the first has the rest. NaN outside.
    """

    image: GreyImage
    chart: Chart
    triangle: np.ndarray[tuple[int, int], np.dtype[np.int32]]
    barycentric: Floats

    def __post_init__(self) -> None:
        shape = self.image.shape
        if self.triangle.shape != shape or self.barycentric.shape != (*shape, 2):
            raise DataError(
                f"triangle and barycentric must match the image {shape}, got "
                f"{self.triangle.shape} and {self.barycentric.shape}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class SurfacePoints:
    """Points on a mesh, each in one of its faces.

    Attributes
    ----------
    face : (N,) int64
        Face *of the mesh*, -1 where the point is off the surface.
    barycentric : (N, 3) float64
        Weights of the three corners, summing to one; NaN where off the surface.
    """

    face: Ints
    barycentric: Floats
