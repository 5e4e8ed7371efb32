"""A rubber sheet, clamped on its rim, that a round punch is pushed into."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.methods.synthetic.membrane.disc import disc_mesh
from shapemorph.methods.synthetic.membrane.sheet import Membrane, Support, neo_hookean

SHEAR_MODULUS = 0.5  # MPa; a frictionless punch gives the same shape whatever it is
STIFFNESS = 20.0  # MPa/mm: the punch sinks in by some hundredths of a millimetre
PRESTRETCH = 1.003  # a flat membrane has no stiffness across its plane
LARGEST_STEP = 1.0  # mm of the punch from one equilibrium to the next


@dataclass(frozen=True, slots=True)
class Indentation:
    """Clamped disc and punch, mm and radians.

    Attributes
    ----------
    radius, thickness : float
        Of the free part of the sheet.
    punch : float
        Radius of the tip, a half ball on a rod.
    offset : (float, float)
        Where the axis of the punch meets the flat sheet.
    tilt : float
        Angle between the axis and the normal of the sheet, towards +y.
    gap : float
        Way that the punch goes before it touches.
    """

    radius: float
    thickness: float
    punch: float
    offset: tuple[float, float]
    tilt: float
    gap: float

    @property
    def direction(self) -> Floats:
        """Unit vector (3,) along which the punch moves."""
        return np.array([0.0, np.sin(self.tilt), np.cos(self.tilt)])

    def tip(self, travel: float) -> Floats:
        """Centre (3,) of the ball at the end of the punch, mm."""
        way = travel - self.gap
        return np.array([*self.offset, -self.punch]) + way * self.direction


@dataclass(frozen=True, slots=True, eq=False)
class Indented:
    """One equilibrium.

    Attributes
    ----------
    travel : float
        Of the punch, mm.
    nodes : (N, 3) float64
        mm.
    force : float
        Along the axis of the punch, N.
    """

    travel: float
    nodes: Floats
    force: float


def indent(case: Indentation, membrane: Membrane, travels: Floats) -> Iterator[Indented]:
    """Push the punch in, from equilibrium to equilibrium.

    Parameters
    ----------
    case : Indentation
    membrane : Membrane
        From :func:`clamped_disc`.
    travels : (K,)
        Ascending ways of the punch at which the sheet is wanted, mm.

    Yields
    ------
    Indented
        One for each of `travels`.

    Raises
    ------
    StageError
        If an equilibrium is not found.
    """
    law = neo_hookean(SHEAR_MODULUS)
    before = now = membrane.points * np.array([PRESTRETCH, PRESTRETCH, 1.0])
    last, width = case.gap, 0.0
    for travel in travels:
        count = max(1, int(np.ceil(max(travel - last, 0.0) / LARGEST_STEP)))
        for way in np.linspace(last, travel, count + 1)[1:] if travel > last else []:
            step = way - last
            ahead = now + (now - before) * (step / width) if width else now
            ahead = np.where(membrane.free.reshape(-1, 3), ahead, now)
            support = _against(case, membrane, float(way))
            before, now = now, membrane.equilibrium(ahead, law, support=support)
            last, width = float(way), float(step)
        force = -_against(case, membrane, float(travel))(now)[1].sum(axis=0) @ case.direction
        yield Indented(float(travel), now, float(force))


def clamped_disc(case: Indentation, rings: int) -> Membrane:
    """Make the sheet, a little tight so that it lies flat by itself."""
    points, faces = disc_mesh(case.radius, rings)
    held = np.linalg.norm(points, axis=1) > (1 - 1e-9) * case.radius
    flat = np.column_stack([points / PRESTRETCH, np.zeros(len(points))])
    return Membrane(flat, faces, np.full(len(faces), case.thickness), held)


def _against(case: Indentation, membrane: Membrane, travel: float) -> Support:
    """Push nodes that lie inside the punch out along its normal, like a spring."""
    centre, axis = case.tip(travel), case.direction
    weight = STIFFNESS * membrane.node_area

    def support(x: Floats) -> tuple[float, Floats, Floats]:
        away = x - centre
        along = np.minimum(away @ axis, 0.0)  # beside the rod, else above the ball
        away = away - along[:, None] * axis
        distance = np.linalg.norm(away, axis=1)
        normal = away / np.maximum(distance, 1e-12)[:, None]
        sunk = np.minimum(distance - case.punch, 0.0)
        push = weight * sunk
        outer = normal[:, :, None] * normal[:, None, :]
        stiff = (weight * (sunk < 0.0))[:, None, None] * outer
        return 0.5 * float(push @ sunk), push[:, None] * normal, stiff

    return support
