"""A surface of triangles with a grey pattern on it."""

from dataclasses import dataclass, field

import numpy as np

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.core.errors import DataError


@dataclass(frozen=True, slots=True, eq=False)
class TexturedMesh:
    """Triangles welded by position, with grey from textures or from their corners.

    Attributes
    ----------
    vertices : (V, 3) float64
        Positions in mm, in the frame of the file.
    faces : (F, 3) int64
        Vertex indices. Vertices are welded by position: a texture seam does not cut
        the surface.
    wedge_uv : (F, 3, 2) float64
        Texture coordinates of every corner, origin at the lower left of the picture,
        (0, 0) to (1, 1) across it. Zero size along the first axis where the grey comes
        from the corners.
    face_texture : (F,) int64
        Index into `textures` for every face; zero size likewise.
    textures : tuple of (H, W) float32
        Grey pictures in [0, 1], row 0 on top; empty where the grey comes from the corners.
    corner_grey : (F, 3) float64
        Grey of every corner in [0, 1] for meshes with vertex colours; zero size along
        the first axis for textured meshes.
    name : str
        What messages call this mesh (usually its file name).
    sided : bool
        Whether the order of the corners tells the outer side. It does not on a mesh through
        a cloud of points, whose two sides are alike.
    """

    vertices: Floats
    faces: Ints
    wedge_uv: Floats
    face_texture: Ints
    textures: tuple[Greys, ...]
    corner_grey: Floats
    name: str = field(default="mesh")
    sided: bool = True

    def __post_init__(self) -> None:
        count = len(self.faces)
        if self.vertices.ndim != 2 or self.vertices.shape[1] != 3:
            raise DataError(f"{self.name}: vertices must be (V, 3), got {self.vertices.shape}")
        if self.faces.ndim != 2 or self.faces.shape[1] != 3:
            raise DataError(f"{self.name}: faces must be (F, 3), got {self.faces.shape}")
        if self.has_texture:
            if self.wedge_uv.shape != (count, 3, 2) or self.face_texture.shape != (count,):
                raise DataError(
                    f"{self.name}: {count} faces need wedge_uv ({count}, 3, 2) and face_texture "
                    f"({count},), got {self.wedge_uv.shape} and {self.face_texture.shape}"
                )
        elif self.corner_grey.shape != (count, 3):
            raise DataError(
                f"{self.name}: without a texture, corner_grey must be ({count}, 3), got "
                f"{self.corner_grey.shape}"
            )

    @property
    def has_texture(self) -> bool:
        """Whether the grey comes from pictures rather than from the corners."""
        return len(self.textures) > 0

    @property
    def size(self) -> float:
        """Diagonal of the bounding box, mm."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))


def textured_mesh(
    vertices: Floats,
    faces: Ints,
    wedge_uv: Floats,
    face_texture: Ints,
    textures: tuple[Greys, ...],
    *,
    name: str,
) -> TexturedMesh:
    """Make a mesh whose grey comes from pictures."""
    return TexturedMesh(
        vertices, faces, wedge_uv, face_texture, textures, np.zeros((0, 3)), name=name
    )


def coloured_mesh(vertices: Floats, faces: Ints, corner_grey: Floats, *, name: str) -> TexturedMesh:
    """Make a mesh whose grey is interpolated between its corners."""
    no_texture = np.zeros(0, dtype=np.int64)
    return TexturedMesh(
        vertices, faces, np.zeros((0, 3, 2)), no_texture, (), corner_grey, name=name
    )
