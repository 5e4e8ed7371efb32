"""A blown sheet: what holds for any such shape, and balances that are known."""

import numpy as np
import pytest

from shapemorph.methods.synthetic.membrane.blow import CONSISTENCY, Blowing, blow
from shapemorph.methods.synthetic.membrane.disc import disc_mesh
from shapemorph.methods.synthetic.membrane.sheet import Membrane

CASE = Blowing(radius=22.5, thickness=1.35, exponent=0.5)
RINGS = 12


@pytest.fixture(scope="module")
def states():
    return list(blow(CASE, RINGS, 1.1 * CASE.radius))


def stretches(state):
    points, faces = disc_mesh(CASE.radius, RINGS)
    flat = np.column_stack([points, np.zeros(len(points))])
    sheet = Membrane(flat, faces, state.thickness, np.zeros(len(points), bool))
    return sheet.stretches(state.nodes), sheet


def test_the_volume_is_kept_and_the_pole_is_thinnest(states):
    found, sheet = stretches(states[-1])
    volume = (states[-1].thickness * sheet.area * found.prod(axis=1)).sum()
    assert volume == pytest.approx(CASE.thickness * sheet.area.sum(), rel=2e-3)
    assert states[-1].thickness[:6].mean() < 1.02 * states[-1].thickness.min()
    green = (found[:6] ** 2 - 1) / 2
    assert green.min() > 1.5
    assert np.ptp(green) < 0.05 * green.mean()


def test_it_stays_in_the_die_and_on_its_rim(states):
    points, _ = disc_mesh(CASE.radius, RINGS)
    rim = np.linalg.norm(points, axis=1) > 0.999 * CASE.radius
    np.testing.assert_allclose(states[-1].nodes[rim, :2], points[rim], atol=1e-9)
    assert np.linalg.norm(states[-1].nodes[:, :2], axis=1).max() < CASE.radius + 0.05


def test_what_has_touched_the_wall_sticks(states):
    for before, after in zip(states[-4:-1], states[-3:], strict=True):
        stuck = np.linalg.norm(before.nodes[:, :2], axis=1) > CASE.radius - 5e-3
        np.testing.assert_array_equal(before.nodes[stuck], after.nodes[stuck])


def test_pressure_balances_the_tension_of_the_pole(states):
    """Thin ball: p = 2 sigma h / rho, with the flow stress of the last step."""
    before, after = states[-2], states[-1]
    step = np.log(before.thickness[:6].mean() / after.thickness[:6].mean())
    stress = CONSISTENCY * step**CASE.exponent  # equibiaxial: strain rate is that of thinning
    near = np.linalg.norm(after.nodes[:, :2], axis=1) < 9.0
    x, y, z = after.nodes[near].T
    design = np.column_stack([2 * x, 2 * y, 2 * z, np.ones(len(x))])
    (a, b, c, d), *_ = np.linalg.lstsq(design, x**2 + y**2 + z**2, rcond=None)
    radius = np.sqrt(d + a**2 + b**2 + c**2)
    expected = 2 * stress * after.thickness[:6].mean() / radius
    assert after.pressure == pytest.approx(expected, rel=0.05)
