"""Painting: the speckle of the material onto the texels of one side's atlas."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Greys
from shapemorph.core.synthetic import DamageSpot
from shapemorph.kernels.painting import cover, paint, speckle_at, spread
from shapemorph.methods.synthetic.damage import spoil
from shapemorph.methods.synthetic.material import MaterialMap
from shapemorph.methods.synthetic.speckle import Speckle
from shapemorph.methods.synthetic.triangulation import MaterialMesh

DARK, BRIGHT = 0.12, 0.85
"""Grey of a blob and of the ground between blobs in even light."""

SAMPLES = 3
"""Samples along each side of a texel."""

CONTINUED = 3
"""Texels that the pattern is continued beyond the edge of an island."""


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """How one side was lit: grey = offset + gain (1 + gradient . place) pattern.

    Attributes
    ----------
    gain, offset : float
    gradient : (2,) float64
        Change of the gain across the whole specimen, per axis of the material.
    """

    gain: float
    offset: float
    gradient: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Everything that decides the grey of a material point on one side."""

    material_map: MaterialMap
    speckle: Speckle
    light: Light
    damage: tuple[DamageSpot, ...]

    def grey(self, bright: Floats, material: Floats) -> Floats:
        """Grey (N,) of points with the speckle's brightness (N,) at coordinates (N, 2)."""
        span = self.material_map.upper - self.material_map.lower
        place = (material - 0.5 * (self.material_map.upper + self.material_map.lower)) / span
        gain = self.light.gain * (1 + place @ self.light.gradient)
        grey = self.light.offset + gain * (DARK + (BRIGHT - DARK) * bright)
        return spoil(grey, material, self.material_map, self.damage)


def random_light(rng: np.random.Generator) -> Light:
    """Light of one side: gain 0.82 to 0.98, offset to 0.06, gradient 0.2 in some direction."""
    angle = rng.uniform(0, 2 * np.pi)
    gradient = 0.2 * np.array([np.cos(angle), np.sin(angle)])
    return Light(float(rng.uniform(0.82, 0.98)), float(rng.uniform(0.0, 0.06)), gradient)


def paint_texture(
    mesh: MaterialMesh,
    uv: Floats,
    scene: Scene,
    *,
    width: int,
    gutter: int,
) -> Greys:
    """Paint a square texture, before any noise.

    Every texel shows the mean of the speckle over its own area. Around each island the
    pattern runs on for a few texels, then its colour, so that a filter that reaches over the
    edge finds nothing foreign.

    Parameters
    ----------
    mesh : MaterialMesh
    uv : (F, 3, 2)
        Texture coordinates of every corner, origin at the lower left.
    scene : Scene
    width, gutter : int
        Texels.

    Returns
    -------
    (width, width) float32
        Grey, above 1 where the camera saturates, row 0 on top.
    """
    corners = np.stack([uv[..., 0] * width - 0.5, (1 - uv[..., 1]) * width - 0.5], axis=-1)
    face = cover(corners, width, width)
    source = spread(face >= 0, CONTINUED)
    face = np.where(source >= 0, face.ravel()[source], -1)
    speckle = scene.speckle
    bright, material = paint(
        face,
        corners,
        mesh.nodes,
        speckle.blobs,
        speckle.origin,
        speckle.cell,
        speckle.edge,
        SAMPLES,
    )
    painted = face >= 0
    grey = np.full((width, width), 0.5, dtype=np.float32)
    grey[painted] = scene.grey(bright[painted].astype(np.float64), material[painted])
    source = spread(painted, gutter)
    spread_out: Greys = np.where(source >= 0, grey.ravel()[source], grey)
    return spread_out


def paint_vertices(mesh: MaterialMesh, scene: Scene) -> Greys:
    """Grey (V,) of every vertex: the mean of the speckle over the triangles around it."""
    corners, speckle = mesh.nodes[:, :3], scene.speckle
    total, count = np.zeros(len(mesh.vertices)), np.zeros(len(mesh.vertices))
    for k in range(3):
        near = (4 * corners[:, k] + corners[:, (k + 1) % 3] + corners[:, (k + 2) % 3]) / 6
        bright = speckle_at(near, speckle.blobs, speckle.origin, speckle.cell, speckle.edge)
        total += np.bincount(mesh.faces[:, k], weights=bright, minlength=len(total))
        count += np.bincount(mesh.faces[:, k], minlength=len(total))
    return scene.grey(total / count, mesh.material).astype(np.float32)


def record_grey(grey: Greys, *, noise: float, rng: np.random.Generator) -> Greys:
    """Record grey as a camera does: noise in levels of 255, clipped, whole levels over 255."""
    levels = 255 * grey + noise * rng.standard_normal(grey.shape, dtype=np.float32)
    whole: Greys = np.rint(np.clip(levels, 0, 255)).astype(np.float32) / np.float32(255)
    return whole
