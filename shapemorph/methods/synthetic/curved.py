"""Material maps of curved references: a rigid shell, a free form, a tube."""

import re

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.methods.synthetic.material import (
    Embedding,
    MaterialMap,
    Scalar,
    circle,
    no_kink,
)
from shapemorph.methods.synthetic.revolution import flat

_TURNED = re.compile(r"freeform\(([-+.e\d]+)\)")


def rigid(size: float) -> MaterialMap:
    """Make a mildly curved shell that only changes its pose."""
    radius = 0.5 * size
    shell = _relief(_shell_height(size))
    return MaterialMap(
        lower=np.full(2, -radius),
        upper=np.full(2, radius),
        period=None,
        reference=shell,
        deformed=shell,
        rim=lambda material: radius - np.linalg.norm(material, axis=1),
        loops=(circle(radius),),
        locate=lambda points: points[:, :2].copy(),
        flat=False,
        kink=no_kink,
        kink_loops=(),
        pole=np.zeros(2),
    )


def freeform_name(direction: float) -> str:
    """Name of a free form that says how its stretch is turned, degrees."""
    return f"freeform({direction!r})" if direction else "freeform"


def freeform_of_name(name: str, size: float) -> MaterialMap | None:
    """Make the turned free form of a name; None if it is the name of something else."""
    found = _TURNED.fullmatch(name)
    return None if found is None else freeform(size, direction=float(found.group(1)))


def freeform(size: float, direction: float = 0.0) -> MaterialMap:
    """Make a curved shell of oblique outline, drawn 2 x 0.85, sheared, bent and dented.

    Nothing about it is symmetric: the outline, both reliefs and the plane map all differ.

    Parameters
    ----------
    size : float
        Of the outline, mm.
    direction : float
        By which all that happens to the material is turned in the plane of its
        coordinates, degrees; the reference stays as it is.
    """
    outline = _oblique_outline(size)
    angle: Floats = np.arange(4096.0) * (2 * np.pi / 4096)
    reach = outline(angle)
    loop = reach[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def rim(material: Floats) -> Floats:
        direction = np.arctan2(material[:, 1], material[:, 0])
        level: Floats = outline(direction) - np.linalg.norm(material, axis=1)
        return level

    return MaterialMap(
        lower=loop.min(axis=0),
        upper=loop.max(axis=0),
        period=None,
        reference=_relief(_shell_height(size)),
        deformed=_turned(_drawn(size), direction),
        rim=rim,
        loops=(loop,),
        locate=lambda points: points[:, :2].copy(),
        flat=False,
        kink=no_kink,
        kink_loops=(),
        pole=np.array([0.05, 0.04]) * size,
    )


def tube(size: float) -> MaterialMap:
    """Make an open tube of length `size`, blown up off the middle, stretched and twisted.

    The coordinates are arc length around and length along; the first closes on itself.
    """
    radius = 0.18 * size
    period = 2 * np.pi * radius
    around = np.arange(4096)[:, None] * (period / 4096) * np.array([1.0, 0.0])

    def locate(points: Floats) -> Floats:
        turn = np.arctan2(points[:, 1], points[:, 0]) % (2 * np.pi)
        return np.column_stack([radius * turn, points[:, 2]])

    return MaterialMap(
        lower=np.zeros(2),
        upper=np.array([period, size]),
        period=period,
        reference=_wound(radius, size, blow=0.0, twist=0.0, draw=1.0),
        deformed=_wound(radius, size, blow=0.55, twist=0.9, draw=1.2),
        rim=lambda material: np.minimum(material[:, 1], size - material[:, 1]),
        loops=(around, around + np.array([0.0, size])),
        locate=locate,
        flat=True,
        kink=no_kink,
        kink_loops=(),
        pole=np.array([0.3 * period, 0.45 * size]),
    )


def _oblique_outline(size: float) -> Scalar:
    """Radius of the outline of the free form against the angle, mm."""

    def outline(angle: Floats) -> Floats:
        waves = 0.86 + 0.09 * np.cos(2 * angle + 0.5) + 0.05 * np.cos(3 * angle - 0.7)
        return 0.5 * size * waves

    return outline


def _shell_height(size: float) -> Embedding:
    """Height of a shallow saddle with a swell on it; returns z (N,) and its gradient (N, 2)."""

    def height(material: Floats) -> tuple[Floats, Floats]:
        x, y = material.T / size
        swell = np.sin(4.2 * x + 1.0) * np.cos(3.1 * y - 0.4)
        z = -0.28 * x**2 - 0.42 * y**2 + 0.12 * x * y + 0.025 * swell
        slope_x = -0.56 * x + 0.12 * y + 0.105 * np.cos(4.2 * x + 1.0) * np.cos(3.1 * y - 0.4)
        slope_y = -0.84 * y + 0.12 * x - 0.0775 * np.sin(4.2 * x + 1.0) * np.sin(3.1 * y - 0.4)
        return size * z, np.stack([slope_x, slope_y], axis=-1)

    return height


def _relief(height: Embedding) -> Embedding:
    """Surface z = height(x, y) in the coordinates x, y."""

    def embed(material: Floats) -> tuple[Floats, Floats]:
        position, jacobian = flat(material)
        position[:, 2], jacobian[:, 2] = height(material)
        return position, jacobian

    return embed


def _drawn(size: float) -> Embedding:
    """Draw the free form: a plane map, dented, wound about a cylinder along y."""
    winding = 0.9 * size

    def embed(material: Floats) -> tuple[Floats, Floats]:
        plane, plane_jacobian = _stretched(material, size)
        dent, dent_slope = _dent(plane, size)
        angle, out = plane[:, 0] / winding, winding + dent
        sine, cosine = np.sin(angle), np.cos(angle)
        position = np.column_stack([out * sine, plane[:, 1], out * cosine - winding])
        wound = np.zeros((len(material), 3, 2))
        wound[:, 0] = dent_slope * sine[:, None]
        wound[:, 2] = dent_slope * cosine[:, None]
        wound[:, 0, 0] += out * cosine / winding
        wound[:, 2, 0] -= out * sine / winding
        wound[:, 1, 1] = 1.0
        return position, wound @ plane_jacobian

    return embed


def _turned(state: Embedding, degrees: float) -> Embedding:
    """Turn what happens to the material by an angle: the material turns back before it."""
    cosine, sine = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    back = np.array([[cosine, sine], [-sine, cosine]])

    def embed(material: Floats) -> tuple[Floats, Floats]:
        position, jacobian = state(material @ back.T)
        return position, jacobian @ back

    return embed


def _stretched(material: Floats, size: float) -> tuple[Floats, Floats]:
    """Plane map of the free form: stretch 1.95 x 0.85 with shear, not quite homogeneous."""
    x, y = material.T / size
    u = 1.95 * x + 0.30 * y + 0.035 * np.sin(3.0 * x + 2.0 * y)
    v = 0.85 * y + 0.10 * x + 0.030 * np.sin(3.5 * x - 1.0)
    wave, ripple = 0.035 * np.cos(3.0 * x + 2.0 * y), 0.105 * np.cos(3.5 * x - 1.0)
    along_x = np.stack([1.95 + 3.0 * wave, 0.10 + ripple], axis=-1)
    along_y = np.stack([0.30 + 2.0 * wave, np.full_like(x, 0.85)], axis=-1)
    return size * np.stack([u, v], axis=-1), np.stack([along_x, along_y], axis=-1)


def _dent(plane: Floats, size: float) -> tuple[Floats, Floats]:
    """Relief (N,) on the wound surface and its gradient (N, 2)."""
    u, v = plane.T / size
    relief = 0.05 * np.sin(2.5 * u + 0.5) * np.sin(3.0 * v + 1.0) - 0.20 * v**2
    along_u = 0.125 * np.cos(2.5 * u + 0.5) * np.sin(3.0 * v + 1.0)
    along_v = 0.15 * np.sin(2.5 * u + 0.5) * np.cos(3.0 * v + 1.0) - 0.40 * v
    return size * relief, np.stack([along_u, along_v], axis=-1)


def _wound(radius: float, length: float, *, blow: float, twist: float, draw: float) -> Embedding:
    """Wind a tube about z: blown up by `blow` radii, twisted (radians), drawn (factor)."""

    def embed(material: Floats) -> tuple[Floats, Floats]:
        along = material[:, 1] / length
        bell = np.exp(-(((along - 0.45) / 0.22) ** 2))
        bell_slope = -2 * (along - 0.45) / 0.22**2 * bell / length
        out, out_slope = radius * (1 + blow * bell), radius * blow * bell_slope
        angle = material[:, 0] / radius + twist * along
        sine, cosine = np.sin(angle), np.cos(angle)
        position = np.column_stack([out * cosine, out * sine, draw * material[:, 1]])
        jacobian = np.zeros((len(material), 3, 2))
        jacobian[:, 0, 0], jacobian[:, 1, 0] = -out * sine / radius, out * cosine / radius
        turn = twist / length
        jacobian[:, 0, 1] = out_slope * cosine - out * sine * turn
        jacobian[:, 1, 1] = out_slope * sine + out * cosine * turn
        jacobian[:, 2, 1] = draw
        return position, jacobian

    return embed
