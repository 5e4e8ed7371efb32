"""Material maps of flat discs and plates that become surfaces of revolution.

A radial map sends the material radius r to the radius rho(r) and height z(r); the meridional
stretch is sqrt(rho'^2 + z'^2) and the hoop stretch rho / r.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.arrays import Floats
from shapemorph.methods.synthetic.material import Embedding, MaterialMap, circle, no_kink

Profile: TypeAlias = Callable[[Floats], tuple[Floats, Floats, Floats, Floats]]
"""(N,) material radius -> rho, z, d rho / dr, d z / dr, all (N,)."""

Meridian: TypeAlias = Callable[[Floats], tuple[Floats, Floats, Floats, Floats]]
"""(N,) arc length from the pole -> rho, z, d rho / ds, d z / ds, all (N,)."""


def flat(material: Floats) -> tuple[Floats, Floats]:
    """Lay the plane z = 0 in its own coordinates."""
    position = np.concatenate([material, np.zeros((len(material), 1))], axis=1)
    jacobian = np.zeros((len(material), 3, 2))
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
    return position, jacobian


def revolved(profile: Profile) -> Embedding:
    """Embedding of a plane whose points move along their own radius and upwards."""

    def embed(material: Floats) -> tuple[Floats, Floats]:
        radius = np.linalg.norm(material, axis=1)
        at_pole = radius < 1e-12
        safe = np.where(at_pole, 1.0, radius)
        rho, height, rho_slope, height_slope = profile(radius)
        along = np.where(at_pole[:, None], [1.0, 0.0], material / safe[:, None])
        hoop = np.where(at_pole, rho_slope, rho / safe)
        position = np.column_stack([hoop[:, None] * material, height])
        outer = along[:, :, None] * along[:, None, :]
        plane = hoop[:, None, None] * np.eye(2) + (rho_slope - hoop)[:, None, None] * outer
        rise = np.where(at_pole, 0.0, height_slope)[:, None] * along
        return position, np.concatenate([plane, rise[:, None, :]], axis=1)

    return embed


def disc_map(radius: float, deformed: Embedding) -> MaterialMap:
    """Make a flat disc about the origin and say what becomes of it."""
    return MaterialMap(
        lower=np.full(2, -radius),
        upper=np.full(2, radius),
        period=None,
        reference=flat,
        deformed=deformed,
        rim=lambda material: radius - np.linalg.norm(material, axis=1),
        loops=(circle(radius),),
        locate=lambda points: points[:, :2].copy(),
        flat=True,
        kink=no_kink,
        kink_loops=(),
        pole=np.zeros(2),
    )


def dome(size: float) -> MaterialMap:
    """Hemisphere with a vertical wall: meridional stretch 2 everywhere, so E1 = 1.5.

    Material radius r goes to meridian arc 2 r on a hemisphere of the radius of the disc,
    continued by a vertical wall.
    """
    radius = 0.5 * size
    meridian = hemisphere_and_wall(radius)
    return disc_map(
        radius, revolved(along_meridian(lambda r: (2.0 * r, np.full_like(r, 2.0)), meridian))
    )


def bulge(size: float) -> MaterialMap:
    """Disc blown into a die through a flange that stays: E1 = E2 = 1.898 at the pole.

    The meridional stretch falls from 2.19 at the pole to 1.36 at the edge of the die as
    1.15 + 1.04 / (1 + (2 r / a)^2), as in superplastic forming; there F jumps to the identity
    and the wall meets the flange at a right angle.
    """
    radius, die = 0.5 * size, size * 22.5 / 70.0

    def arc(r: Floats) -> tuple[Floats, Floats]:
        t = r / die
        return die * (1.15 * t + 0.52 * np.arctan(2 * t)), 1.15 + 1.04 / (1 + 4 * t**2)

    formed = along_meridian(arc, hemisphere_and_wall(die))
    height = float(-formed(np.array([die]))[1][0])

    def profile(r: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        rho, z, rho_slope, z_slope = formed(np.minimum(r, die))
        kept = r >= die
        return (
            np.where(kept, r, rho),
            np.where(kept, 0.0, z + height),
            np.where(kept, 1.0, rho_slope),
            np.where(kept, 0.0, z_slope),
        )

    return replace(
        disc_map(radius, revolved(profile)),
        kink=lambda material: np.abs(np.linalg.norm(material, axis=1) - die),
        kink_loops=(circle(die),),
    )


def indentation(size: float, *, offset: float, tilt: float) -> MaterialMap:
    """Membrane clamped at its rim and pushed by a round punch: E about 1.2 at the tip.

    Centred, it is a spherical cap of the radius of the punch that runs into a cone. The
    offset moves the tip through a conformal map of the disc onto itself (before and, undone,
    after the deformation, so that the rim stays where it is); the tilt shears the axis.

    Parameters
    ----------
    size : float
        Diameter, mm.
    offset : float
        Distance of the tip from the centre, mm, along +x.
    tilt : float
        Angle between the axis and the normal, radians, towards +y.
    """
    radius = 0.5 * size
    base, extra, width = 1.0113, 0.8327, 0.3  # stretch 1.84 under the tip, 1.08 at the clamp
    meridian = CapAndCone(radius, punch=13.5 / 76 * size, depth=32 / 76 * size)
    scale = meridian.length / (base + extra * width * np.arctan(1 / width))

    def arc(r: Floats) -> tuple[Floats, Floats]:
        t = r / radius
        s = scale * (base * t + extra * width * np.arctan(t / width))
        return s, scale / radius * (base + extra / (1 + (t / width) ** 2))

    centred = revolved(along_meridian(arc, meridian))
    pushed = _off_centre(centred, radius, offset / radius, np.tan(tilt))
    return replace(disc_map(radius, pushed), pole=np.array([offset, 0.0]))


def hole(size: float) -> MaterialMap:
    """Plate of size x 0.85 size whose round hole is opened into a funnel: E1 to about 0.85.

    rho = r + d h and z = H h with h = exp(-(r - a) / w): the lip is steep, the plate far
    away hardly moves.
    """
    edge, opening, height, width = 0.1 * size, 0.065 * size, 0.17 * size, 0.13 * size
    centre = np.array([0.06 * size, -0.03 * size])
    half = np.array([0.5 * size, 0.425 * size])

    def profile(r: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        fade = np.exp(-(r - edge) / width)
        return r + opening * fade, height * fade, 1 - opening / width * fade, -height / width * fade

    funnel = revolved(profile)

    def rim(material: Floats) -> Floats:
        to_hole = np.linalg.norm(material, axis=1) - edge
        to_plate = (half - np.abs(material + centre)).min(axis=1)
        nearest: Floats = np.minimum(to_hole, to_plate)
        return nearest

    return replace(
        disc_map(edge, funnel),
        lower=-half - centre,
        upper=half - centre,
        rim=rim,
        loops=(rectangle(-half - centre, half - centre), circle(edge)),
        pole=np.array([1.0, 0.0]) * edge * 1.5,
    )


def rectangle(lower: Floats, upper: Floats, count: int = 1024) -> Floats:
    """Place points (4 count, 2) around a rectangle, corners included, counter-clockwise."""
    t = np.arange(count)[:, None] / count
    corners = np.array([lower, [upper[0], lower[1]], upper, [lower[0], upper[1]]])
    sides = [(1 - t) * corners[k] + t * corners[(k + 1) % 4] for k in range(4)]
    return np.concatenate(sides)


def along_meridian(arc: Callable[[Floats], tuple[Floats, Floats]], meridian: Meridian) -> Profile:
    """Profile of a disc laid along a meridian: `arc` gives arc length and stretch at r."""

    def profile(r: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        s, stretch = arc(r)
        rho, z, rho_slope, z_slope = meridian(s)
        return rho, z, stretch * rho_slope, stretch * z_slope

    return profile


def hemisphere_and_wall(radius: float) -> Meridian:
    """Follow a quarter circle from the pole, then straight down; z = 0 at the pole."""

    def meridian(s: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        angle = np.minimum(s / radius, 0.5 * np.pi)
        wall = np.maximum(s - 0.5 * np.pi * radius, 0.0)
        rho = radius * np.sin(angle)
        return rho, radius * (np.cos(angle) - 1) - wall, np.cos(angle), -np.sin(angle)

    return meridian


@dataclass(frozen=True, slots=True)
class CapAndCone:
    """A spherical cap that runs into the cone tangent to it, down to z = 0 at the rim.

    Attributes
    ----------
    radius, punch, depth : float
        Radius of the rim, radius of the cap, height of the tip over the rim, mm.
    """

    radius: float
    punch: float
    depth: float

    @property
    def contact(self) -> float:
        """Angle between the axis and the normal where cap and cone meet, radians."""
        rise = self.depth - self.punch
        reach = np.hypot(self.radius, rise)
        return float(np.arctan2(rise, self.radius) + np.arcsin(self.punch / reach))

    @property
    def length(self) -> float:
        """Arc length from the tip to the rim, mm."""
        cone = (self.radius - self.punch * np.sin(self.contact)) / np.cos(self.contact)
        return float(self.punch * self.contact + cone)

    def __call__(self, s: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Position and direction at arc length s."""
        angle = np.minimum(s / self.punch, self.contact)
        beyond = np.maximum(s - self.punch * self.contact, 0.0)
        along, down = np.cos(angle), -np.sin(angle)
        rho = self.punch * np.sin(angle) + along * beyond
        height = self.depth - self.punch * (1 - np.cos(angle)) + down * beyond
        return rho, height, along, down


def _off_centre(centred: Embedding, radius: float, shift: float, lean: float) -> Embedding:
    """Move the tip by `shift` (of the radius) and lean the axis, leaving the rim in place.

    The Moebius map (w - c) / (1 - c w) of the unit disc carries c to the centre and the
    rim onto itself; undoing it after the deformation brings every point of the rim home.
    """

    def embed(material: Floats) -> tuple[Floats, Floats]:
        w = _complex(material) / radius
        moved = (w - shift) / (1 - shift * w)
        position, jacobian = centred(radius * np.column_stack([moved.real, moved.imag]))
        jacobian = jacobian @ _multiplication((1 - shift**2) / (1 - shift * w) ** 2)
        v = _complex(position) / radius
        home = (v + shift) / (1 + shift * v)
        turn = _multiplication((1 - shift**2) / (1 + shift * v) ** 2)
        position = np.column_stack([radius * home.real, radius * home.imag, position[:, 2]])
        jacobian = np.concatenate([turn @ jacobian[:, :2], jacobian[:, 2:]], axis=1)
        position[:, 1] += lean * position[:, 2]
        jacobian[:, 1] += lean * jacobian[:, 2]
        return position, jacobian

    return embed


def _complex(points: Floats) -> NDArray[np.complex128]:
    """Read the first two coordinates (N, ...) as complex numbers (N,)."""
    numbers: NDArray[np.complex128] = points[:, 0] + 1j * points[:, 1]
    return numbers


def _multiplication(z: NDArray[np.complex128]) -> Floats:
    """(N, 2, 2) matrices that multiply the plane by complex numbers (N,)."""
    rows = [np.stack([z.real, -z.imag], axis=-1), np.stack([z.imag, z.real], axis=-1)]
    return np.stack(rows, axis=-2)
