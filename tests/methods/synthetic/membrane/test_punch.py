"""Finite elements against the equations of an axisymmetric membrane, integrated."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from shapemorph.methods.synthetic.membrane.disc import disc_mesh
from shapemorph.methods.synthetic.membrane.punch import (
    PRESTRETCH,
    SHEAR_MODULUS,
    Indentation,
    clamped_disc,
    indent,
)

RIM, PUNCH, THICKNESS = 38.0, 13.5, 1.0


def tensions(first, second):
    """Forces per length of the deformed sheet, N/mm, neo-Hookean."""
    rest = (first * second) ** -2
    scale = SHEAR_MODULUS * THICKNESS / (first * second)
    return scale * (first**2 - rest), scale * (second**2 - rest)


def slopes(radius, state, *, touching):
    """Follow the meridian over the unstretched radius: r, z, angle, stretch along it."""
    r, _, angle, first = state
    second = r / radius
    along, hoop = tensions(first, second)
    r_slope = first * np.cos(angle)
    second_slope = (r_slope - second) / radius
    step = 1e-6
    by_first = (tensions(first + step, second)[0] - tensions(first - step, second)[0]) / (2 * step)
    by_second = (tensions(first, second + step)[0] - tensions(first, second - step)[0]) / (2 * step)
    grown = (hoop - along) * np.cos(angle) / r * first
    bend = 1 / PUNCH if touching else -np.sin(angle) / r * hoop / along
    first_slope = (grown - by_second * second_slope) / by_first
    return [r_slope, -first * np.sin(angle), bend * first, first_slope]


def meridian(pole, contact, rim):
    """State at the rim and force, from the stretch at the pole and the radius of contact."""
    begin = 1e-3
    start = [pole * begin, 0.0, pole * begin / PUNCH, pole]
    how = {"rtol": 1e-9, "atol": 1e-10}
    first = solve_ivp(lambda r, s: slopes(r, s, touching=True), (begin, contact), start, **how)
    edge = first.y[:, -1]
    second = solve_ivp(lambda r, s: slopes(r, s, touching=False), (contact, rim), edge, **how)
    tension = tensions(edge[3], edge[0] / contact)[0]
    return second.y[:, -1], 2 * np.pi * edge[0] * tension * np.sin(edge[2])


def exact(depth):
    """Stretch of the pole and force, N, at which the rim is where it is held."""
    rim = RIM / PRESTRETCH

    def misses(unknown):
        end, _ = meridian(*unknown, rim)
        return [end[0] - RIM, end[1] + depth]

    pole, contact = fsolve(misses, [1.75, 6.5])
    return pole, meridian(pole, contact, rim)[1]


def test_a_centred_punch_agrees_with_the_equations_of_the_membrane():
    case = Indentation(RIM, THICKNESS, PUNCH, (0.0, 0.0), 0.0, 0.0)
    membrane = clamped_disc(case, 16)
    (state,) = indent(case, membrane, np.array([30.0]))
    pole, force = exact(30.0)
    assert state.force == pytest.approx(force, rel=0.02)
    assert membrane.stretches(state.nodes)[:6].mean() == pytest.approx(pole, rel=0.01)


def test_an_off_centre_punch_leaves_the_rim_and_sinks_in_hardly():
    case = Indentation(RIM, THICKNESS, PUNCH, (4.0, 0.0), np.deg2rad(5.0), 1.0)
    membrane = clamped_disc(case, 10)
    states = list(indent(case, membrane, np.array([0.5, 10.0])))
    points, _ = disc_mesh(RIM, 10)
    np.testing.assert_allclose(states[0].nodes[:, 2], 0.0, atol=1e-9)
    rim = membrane.free.reshape(-1, 3)[:, 0] == 0
    np.testing.assert_allclose(states[1].nodes[rim, :2], points[rim], atol=1e-12)
    reach = np.linalg.norm(states[1].nodes - case.tip(10.0), axis=1)
    assert reach.min() > PUNCH - 0.03
    highest = states[1].nodes[states[1].nodes[:, 2].argmax()]
    assert highest[0] > 2.0
