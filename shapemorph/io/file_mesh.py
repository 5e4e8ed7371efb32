"""A mesh as its file has it: triangles, before units, welding and cleaning."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.core.errors import DataError
from shapemorph.io.images import Picture
from shapemorph.methods.polygons import triangulate

Wrap = Literal["repeat", "mirror", "clamp"]

_FARTHEST = 1e30  # squares and products of lengths must stay finite
_SMALLEST = 1e-30


@dataclass(frozen=True, slots=True, eq=False)
class FileMesh:
    """What every reader hands over.

    Attributes
    ----------
    vertices : (V, 3) float64
        In the unit of the file.
    faces : (F, 3) int64
        Rows of `vertices`.
    wedge_uv : (F, 3, 2) float64
        Origin at the lower left, not yet brought into the picture; NaN where a corner has
        none. Zero size along the first axis where the grey comes from the corners.
    face_texture : (F,) int64
        Row of `textures`, -1 where the face has none; zero size likewise.
    textures : tuple of (H, W) float32
    corner_grey : (F, 3) float64
        Zero size along the first axis where the grey comes from textures.
    file_format, method, grey_source : str
        As in :class:`~shapemorph.core.meshreport.MeshReport`.
    polygons_split : int
    wrap : str
        How the picture goes on beyond its border.
    notes : tuple of str
    content : tuple of float
        Mean gradient content of the channels of its textures; empty where they, or one of
        them, are grey.
    """

    vertices: Floats
    faces: Ints
    wedge_uv: Floats
    face_texture: Ints
    textures: tuple[Greys, ...]
    corner_grey: Floats
    file_format: str
    method: str
    grey_source: str
    polygons_split: int
    wrap: Wrap
    notes: tuple[str, ...]
    content: tuple[float, ...] = ()

    def noted(self, *notes: str) -> "FileMesh":
        """Return the same mesh with more notes."""
        return replace(self, notes=(*self.notes, *notes))

    def textured(
        self, wedge_uv: Floats, face_texture: Ints, pictures: Sequence[Picture], wrap: Wrap
    ) -> "FileMesh":
        """Return the same triangles with textures on them, and what was noted about these."""
        contents = [picture.content for picture in pictures]
        known = bool(contents) and all(contents)
        return replace(
            self,
            wedge_uv=wedge_uv,
            face_texture=face_texture,
            textures=tuple(picture.grey for picture in pictures),
            wrap=wrap,
            grey_source="texture",
            notes=(*self.notes, *(note for picture in pictures for note in picture.notes)),
            content=tuple(float(v) for v in np.mean(contents, axis=0)) if known else (),
        )

    def coloured(self, corner_grey: Floats) -> "FileMesh":
        """Return the same triangles with grey at their corners."""
        return replace(self, corner_grey=corner_grey, grey_source="vertex colours")

    def only(self, rows: Ints) -> "FileMesh":
        """Return some of the faces."""
        return replace(
            self,
            faces=self.faces[rows],
            wedge_uv=self.wedge_uv[rows] if self.textures else self.wedge_uv,
            face_texture=self.face_texture[rows] if self.textures else self.face_texture,
            corner_grey=self.corner_grey if self.textures else self.corner_grey[rows],
        )


def check_positions(vertices: Floats, rows: Ints, *, name: str) -> None:
    """Refuse positions that no cleaning can mend, among those that faces refer to.

    Parameters
    ----------
    vertices : (V, 3)
    rows : (N,)
        Vertices of all corners.
    name : str
        What messages call the file.

    Raises
    ------
    DataError
        If a row does not exist, or a position is not finite, or all are one point.
    """
    if len(rows) == 0:
        raise DataError(f"{name}: expected faces of three or more corners, got none")
    low, high = int(rows.min()), int(rows.max())
    if low < 0 or high >= len(vertices):
        raise DataError(
            f"{name}: expected faces of vertices 0 to {len(vertices) - 1}, got "
            f"{low if low < 0 else high}: the file is damaged, export it again"
        )
    refers = np.zeros(len(vertices), dtype=np.bool_)
    refers[rows] = True
    used = vertices[refers]
    near = np.abs(used) < _FARTHEST
    if not near.all():
        numbers = np.flatnonzero(refers)[~near.all(axis=1)] + 1
        raise DataError(
            f"{name}: expected finite positions, got NaN, infinity or a huge number in "
            f"{len(numbers)} vertices (first: number {numbers[0]}): "
            "remove them before the export"
        )
    if not max(map(np.ptp, used.T)) > _SMALLEST:
        raise DataError(f"{name}: expected a surface with a size, got all vertices at one point")


def cut_polygons(vertices: Floats, rows: Ints, sizes: Ints, *, name: str) -> tuple[Ints, Ints]:
    """Cut polygons into triangles as :func:`~shapemorph.methods.polygons.triangulate` does.

    Parameters
    ----------
    vertices : (V, 3)
    rows : (N,)
        Vertices of all corners, polygon after polygon.
    sizes : (P,)
        Corners of each polygon.
    name : str
        What messages call the file.
    """
    if (sizes == 3).all():
        return np.arange(len(rows)).reshape(-1, 3), np.arange(len(sizes))
    try:
        return triangulate(vertices[rows], sizes)
    except DataError as error:
        raise DataError(f"{name}: {error}") from None


def bare_mesh(
    vertices: Floats, faces: Ints, *, file_format: str, polygons_split: int = 0
) -> FileMesh:
    """Make the triangles of a file, as yet without a pattern."""
    return FileMesh(
        vertices,
        faces,
        wedge_uv=np.zeros((0, 3, 2)),
        face_texture=np.zeros(0, dtype=np.int64),
        textures=(),
        corner_grey=np.zeros((0, 3)),
        file_format=file_format,
        method="faces of the file",
        grey_source="none",
        polygons_split=polygons_split,
        wrap="repeat",
        notes=(),
    )
