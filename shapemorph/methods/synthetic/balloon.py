"""Material map of a closed surface: a balloon blown up, more on one side."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.methods.synthetic.material import Embedding, MaterialMap, circle, no_kink
from shapemorph.methods.synthetic.revolution import Meridian, along_meridian, revolved

GROWTH = 1.8
BULGE, WIDTH = 0.35, 0.6  # of the radius, radians
TOWARDS = np.array([0.8, 0.36, -0.48])  # unit vector: away from the poles of the coordinates


def balloon(size: float) -> MaterialMap:
    """Make a closed sphere, blown to 1.8 times its size with a bulge on one side.

    The coordinates are those of a map of the earth about one pole, at equal distances; its
    rim is the other pole, one point.
    """
    radius = 0.5 * size
    reach = np.pi * radius
    sphere = revolved(along_meridian(lambda r: (r, np.ones_like(r)), _whole_circle(radius)))

    def locate(points: Floats) -> Floats:
        outward = np.linalg.norm(points[:, :2], axis=1)
        polar = radius * np.arctan2(outward, points[:, 2])
        along = points[:, :2] / np.where(outward > 0, outward, 1.0)[:, None]
        start: Floats = along * np.clip(polar, 0.0, reach)[:, None]
        return start

    return MaterialMap(
        lower=np.full(2, -reach),
        upper=np.full(2, reach),
        period=None,
        reference=sphere,
        deformed=_blown(sphere, radius),
        rim=lambda material: reach - np.linalg.norm(material, axis=1),
        loops=(circle(reach),),
        locate=locate,
        flat=False,
        kink=no_kink,
        kink_loops=(),
        pole=radius * np.arccos(TOWARDS[2]) * TOWARDS[:2] / np.linalg.norm(TOWARDS[:2]),
    )


def _whole_circle(radius: float) -> Meridian:
    """Follow a half circle from the upper pole to the lower, around the origin."""

    def meridian(s: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        angle = s / radius
        return radius * np.sin(angle), radius * np.cos(angle), np.cos(angle), -np.sin(angle)

    return meridian


def _blown(sphere: Embedding, radius: float) -> Embedding:
    """Push every point outwards: by a factor, and more towards one side.

    x = k r n (1 + b exp((n . t - 1) / w^2)) with the normal n of the sphere.
    """

    def embed(material: Floats) -> tuple[Floats, Floats]:
        position, jacobian = sphere(material)
        normal, slope = position / radius, jacobian / radius
        extra = BULGE * np.exp((normal @ TOWARDS - 1) / WIDTH**2)
        rise = extra[:, None] / WIDTH**2 * np.einsum("i,nij->nj", TOWARDS, slope)
        scale = GROWTH * radius
        moved = scale * (1 + extra)[:, None] * normal
        stretched = (1 + extra)[:, None, None] * slope + normal[:, :, None] * rise[:, None, :]
        return moved, scale * stretched

    return embed
