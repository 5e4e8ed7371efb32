"""A hot sheet that gas blows into a round die: sigma = K rate^m, and it sticks to the wall."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.errors import StageError
from shapemorph.methods.synthetic.membrane.disc import disc_mesh
from shapemorph.methods.synthetic.membrane.sheet import Membrane, Support, viscous_step

CONSISTENCY = 1.0  # MPa s^m: it scales pressure and time, not the shape
SHALLOW = 0.02  # of the radius: height of the cap that it begins with
STRAIN, MOST_STRAIN = 0.04, 0.09  # true strain of the fastest triangle in a step; most
WALL = 5.0  # MPa/mm: a node that has sunk so far into the wall sticks there
TOUCHING = 5e-3  # mm before the wall
MOST_STEPS, ATTEMPTS = 400, 10
FIRST_PRESSURE = 0.02  # MPa


@dataclass(frozen=True, slots=True)
class Blowing:
    """A round sheet over a cylindrical die.

    Attributes
    ----------
    radius : float
        Of the die, mm; the sheet is held there.
    thickness : float
        mm.
    exponent : float
        m, the sensitivity of the stress to the rate.
    """

    radius: float
    thickness: float
    exponent: float


@dataclass(frozen=True, slots=True, eq=False)
class Blown:
    """One state.

    Attributes
    ----------
    nodes : (N, 3) float64
        mm.
    thickness : (F,) float64
        mm.
    pressure : float
        MPa, for a consistency of one.
    """

    nodes: Floats
    thickness: Floats
    pressure: float

    @property
    def height(self) -> float:
        """Of the middle of the sheet, mm."""
        return float(self.nodes[0, 2])


def blow(case: Blowing, rings: int, height: float) -> Iterator[Blown]:
    """Blow the sheet, step by step, until its middle has risen to a height.

    In each step the sheet flows from the shape before it, with the thickness that it has
    got there; the pressure is steered so that the fastest triangle strains by as much as in
    the step before.

    Parameters
    ----------
    case : Blowing
    rings : int
        Of elements.
    height : float
        mm.

    Yields
    ------
    Blown
        State after each step; material points are those of :func:`disc_mesh`.

    Raises
    ------
    StageError
        If a step finds no equilibrium, or the height is not reached.
    """
    points, faces = disc_mesh(case.radius, rings)
    lift = SHALLOW * case.radius * (1.0 - (points**2).sum(axis=1) / case.radius**2)
    now = np.column_stack([points, lift])
    held: Bools = np.linalg.norm(points, axis=1) > (1 - 1e-9) * case.radius
    thickness = np.full(len(faces), case.thickness)
    pressure, move = FIRST_PRESSURE, np.zeros_like(now)
    for _ in range(MOST_STEPS):
        sheet = Membrane(now, faces, thickness, held)
        there, pressure = _one_step(case, sheet, now + move * ~held[:, None], pressure)
        stretch = sheet.stretches(there)
        strained = float(np.log(stretch).max())
        thickness = thickness / stretch.prod(axis=1)
        move, now = there - now, there
        held = held | (np.linalg.norm(now[:, :2], axis=1) > case.radius - TOUCHING)
        yield Blown(now, thickness, pressure)
        if now[0, 2] >= height:
            return
        ratio = float(np.clip((STRAIN / max(strained, 1e-9)) ** case.exponent, 0.6, 1.5))
        move, pressure = move * ratio ** (1 / case.exponent), pressure * ratio
    raise StageError(f"the sheet has not risen to {height:g} mm in {MOST_STEPS} steps")


def _one_step(
    case: Blowing, sheet: Membrane, start: Floats, pressure: float
) -> tuple[Floats, float]:
    """Let the sheet flow for a second; with less pressure where that is too far."""
    law = viscous_step(CONSISTENCY, case.exponent, 1.0)
    for _ in range(ATTEMPTS):
        try:
            found = sheet.equilibrium(start, law, pressure=pressure, support=_wall(case, sheet))
            if np.log(sheet.stretches(found)).max() < MOST_STRAIN:
                return found, pressure
        except StageError:
            pass
        pressure, start = pressure * 0.5**case.exponent, sheet.points
    raise StageError("the sheet found no equilibrium at any pressure: take more rings")


def _wall(case: Blowing, sheet: Membrane) -> Support:
    """Push nodes that lie beyond the wall back, like a spring."""
    weight = WALL * sheet.node_area * sheet.free.reshape(-1, 3)[:, 0]

    def support(x: Floats) -> tuple[float, Floats, Floats]:
        distance = np.linalg.norm(x[:, :2], axis=1)
        beyond = np.maximum(distance - case.radius, 0.0)
        normal = np.zeros_like(x)
        normal[:, :2] = x[:, :2] / np.maximum(distance, 1e-12)[:, None]
        push = weight * beyond
        outer = normal[:, :, None] * normal[:, None, :]
        stiff = (weight * (beyond > 0.0))[:, None, None] * outer
        return 0.5 * float(push @ beyond), push[:, None] * normal, stiff

    return support
