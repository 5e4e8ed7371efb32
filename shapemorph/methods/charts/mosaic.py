"""Pages: the charts of one surface side by side in one picture."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.image import CalibratedImage, Chart, GreyImage
from shapemorph.methods.charting import MARGIN, bounds
from shapemorph.methods.parametrize.disk import Piece

PAGE_GAP = 72.0  # px between two pages: no subset, window or node of a warp spans it


@dataclass(frozen=True, slots=True, eq=False)
class Page:
    """One chart of a surface before it gets its pixels.

    Attributes
    ----------
    piece : Piece
    plane : (N, 2) float64
        Positions of its vertices, mm at median scale 1, x right, y up.
    home : (M,) bool
        Its triangles that no other page shows better.
    """

    piece: Piece
    plane: Floats
    home: Bools


def bind(pages: Sequence[Page], *, gap: float) -> tuple[Piece, Floats, Floats]:
    """Lay pages side by side, from left to right, their upper edges in one line.

    Parameters
    ----------
    pages : sequence of Page
    gap : float
        Room between two pages, mm.

    Returns
    -------
    piece : Piece
        All of them as one.
    plane : (N, 2)
    lefts : (P,)
        x of the border before each page, mm from the leftmost point; zero for the first.
    """
    vertices, faces, planes = [], [], []
    lefts: list[float] = []
    left, count = 0.0, 0
    for page in pages:
        low, high = bounds(page.piece, page.plane)
        corner = np.array([low[0], high[1]])
        planes.append(page.plane - corner + np.array([left, 0.0]))
        vertices.append(page.piece.vertex_ids)
        faces.append(page.piece.faces + count)
        lefts.append(left - gap / 2 if lefts else 0.0)
        count += len(page.plane)
        left += float(high[0] - low[0]) + gap
    face_ids = np.concatenate([page.piece.face_ids for page in pages])
    piece = Piece(np.concatenate(vertices), np.concatenate(faces), face_ids)
    return piece, np.concatenate(planes), np.array(lefts)


def page_bounds(chart: Chart, width: int) -> list[tuple[int, int]]:
    """First column of each page and that after its last, px."""
    ends = [*chart.page_starts[1:].tolist(), width]
    return list(zip(chart.page_starts.tolist(), ends, strict=True))


def page_of(chart: Chart, points_px: Floats) -> Ints:
    """Page on which points (..., 2) of a picture lie."""
    x = np.nan_to_num(points_px[..., 0])
    return np.searchsorted(chart.page_starts[1:], x, side="right").astype(np.int64)


def page_of_triangles(chart: Chart) -> Ints:
    """Page on which each triangle of a chart lies, (M,)."""
    return page_of(chart, chart.vertex_px)[chart.faces[:, 0]]


def faces_of_pages(chart: Chart) -> list[Ints]:
    """Faces of the mesh that each page of a chart shows."""
    pages = page_of_triangles(chart)
    return [np.unique(chart.face_ids[pages == number]) for number in range(chart.page_count)]


def page_image(image: GreyImage, bounds: tuple[int, int]) -> GreyImage:
    """Take one page out of a picture."""
    columns = slice(*bounds)
    return GreyImage(
        np.ascontiguousarray(image.grey[:, columns]), np.ascontiguousarray(image.mask[:, columns])
    )


def take_page(image: CalibratedImage, number: int) -> CalibratedImage:
    """Take one page out of a calibrated image, as a calibrated image of its own."""
    chart = image.chart
    bounds = page_bounds(chart, image.image.shape[1])[number]
    faces = np.flatnonzero(page_of_triangles(chart) == number)
    used, corners = np.unique(chart.faces[faces], return_inverse=True)
    renumbered = np.full(len(chart.faces) + 1, -1, dtype=np.int32)
    renumbered[faces] = np.arange(len(faces))
    columns = slice(*bounds)
    return CalibratedImage(
        page_image(image.image, bounds),
        Chart(
            chart.vertex_ids[used],
            corners.reshape(-1, 3),
            chart.face_ids[faces],
            chart.vertex_px[used] - np.array([bounds[0], 0.0]),
            chart.px_per_mm,
        ),
        np.ascontiguousarray(renumbered[image.triangle[:, columns]]),
        np.ascontiguousarray(image.barycentric[:, columns]),
    )


def with_pages(chart: Chart, pages: Sequence[Page], lefts: Floats) -> Chart:
    """Note on a chart of several pages where each begins and which triangles are at home.

    Parameters
    ----------
    chart : Chart
        At its final scale.
    pages : sequence of Page
    lefts : (P,)
        What :func:`bind` says, mm.
    """
    starts = np.round(lefts * chart.px_per_mm).astype(np.int64)
    starts[1:] += MARGIN
    return replace(chart, page_starts=starts, home=np.concatenate([page.home for page in pages]))
