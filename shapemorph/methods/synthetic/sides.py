"""One side of a pair: triangulated, painted, lit, posed and measured with noise."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.mesh import TexturedMesh, coloured_mesh, textured_mesh
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.synthetic.atlas import lay_out_atlas
from shapemorph.methods.synthetic.material import Embedding
from shapemorph.methods.synthetic.painting import (
    Scene,
    paint_texture,
    paint_vertices,
    record_grey,
)
from shapemorph.methods.synthetic.triangulation import MaterialMesh, triangulate

GUTTER = 1 / 128
"""Free texels around an island over the width of the texture."""


@dataclass(frozen=True, slots=True)
class Scanner:
    """How finely and how noisily a side is recorded.

    Attributes
    ----------
    faces : int
    texture : int or None
        Width of the square texture, texels; None: grey at the vertices only.
    grey_noise : float
        Standard deviation, grey levels of 255.
    vertex_noise : float
        Standard deviation of every coordinate, mm.
    """

    faces: int
    texture: int | None
    grey_noise: float
    vertex_noise: float


def record_side(
    scene: Scene,
    state: Embedding,
    pose: RigidTransform,
    scanner: Scanner,
    *,
    name: str,
    rng: np.random.Generator,
) -> TexturedMesh:
    """Record one state of the material as a textured mesh, mm, in the frame of its file.

    The noise of the vertices comes after painting: the texture sticks to its triangle.
    """
    mesh = triangulate(scene.material_map, state, faces=scanner.faces, rng=rng)
    noise = scanner.vertex_noise * rng.standard_normal(mesh.vertices.shape)
    noise = noise[_first_at_place(mesh.vertices)]
    vertices = pose.apply(mesh.vertices) + noise
    if scanner.texture is None:
        clean = paint_vertices(mesh, scene)
        grey = record_grey(clean, noise=scanner.grey_noise, rng=rng).astype(np.float64)
        return coloured_mesh(vertices, mesh.faces, grey[mesh.faces], name=name)
    return _textured(mesh, vertices, scene, scanner, name=name, rng=rng)


def _first_at_place(vertices: Floats) -> Ints:
    """(V,) first vertex at the place of each: they are one point where a rim shrinks to it."""
    size = float(np.ptp(vertices, axis=0).max())
    places = np.round(vertices / (1e-9 * size)).astype(np.int64)
    _, first, back = np.unique(places, axis=0, return_index=True, return_inverse=True)
    same: Ints = first[back.ravel()]
    return same


def _textured(
    mesh: MaterialMesh,
    vertices: Floats,
    scene: Scene,
    scanner: Scanner,
    *,
    name: str,
    rng: np.random.Generator,
) -> TexturedMesh:
    width = scanner.texture or 0
    gutter = max(4, round(GUTTER * width))
    uv = lay_out_atlas(mesh.vertices, mesh.faces, gutter=gutter / width, rng=rng)
    clean = paint_texture(mesh, uv, scene, width=width, gutter=gutter)
    grey = record_grey(clean, noise=scanner.grey_noise, rng=rng)
    texture = np.zeros(len(mesh.faces), dtype=np.int64)
    return textured_mesh(vertices, mesh.faces, uv, texture, (grey,), name=name)


def random_pose(size: float, rng: np.random.Generator) -> RigidTransform:
    """Any orientation, and a shift of the order of the size: file_from_body."""
    from scipy.spatial.transform import Rotation

    quaternion = rng.standard_normal(4)
    rotation = Rotation.from_quat(quaternion / np.linalg.norm(quaternion)).as_matrix()
    return RigidTransform(rotation, size * rng.uniform(-0.8, 0.8, 3))
