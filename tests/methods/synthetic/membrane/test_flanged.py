import numpy as np
import pytest

from shapemorph.core.laws import RadialProfile
from shapemorph.methods.synthetic.membrane.disc import disc_mesh
from shapemorph.methods.synthetic.membrane.flanged import flanged_maps, radial_profile
from shapemorph.methods.synthetic.membrane.smooth import map_points

EDGE, DIE, ROUNDING = 30.0, 22.5, 2.0


@pytest.fixture(scope="module")
def cone():
    """A cone of 15 mm: straight, so that strain under it is known on paper."""
    reach = np.linspace(0.0, DIE, 20)
    return RadialProfile(reach, reach, 15.0 * (1 - reach / DIE))


def test_nodes_of_a_ring_are_averaged():
    points, _ = disc_mesh(10.0, 5)
    nodes = np.column_stack([1.5 * points, 3.0 + (points**2).sum(axis=1)])
    found = radial_profile(nodes, 10.0, 5)
    np.testing.assert_allclose(found.material, [0, 2, 4, 6, 8, 10])
    np.testing.assert_allclose(found.radius, 1.5 * found.material)
    np.testing.assert_allclose(found.height, 3.0 + found.material**2)


def test_the_sheet_follows_the_profile_up_to_the_bend_and_the_flange_lies_flat(cone):
    before, after = flanged_maps(cone, edge=EDGE, rounding=ROUNDING, bend=0.0)
    material = np.array([[5.0, 0.0], [0.0, -12.0], [12.0, 12.0], [26.0, 0.0], [-20.0, 18.0]])
    reach = np.linalg.norm(material, axis=1)
    flat, _ = map_points(before, material)
    np.testing.assert_allclose(flat, np.column_stack([material, np.zeros(5)]), atol=1e-9)
    placed, slope = map_points(after, material)
    np.testing.assert_allclose(placed[:, :2], material, atol=2e-3)
    expected = np.where(reach < DIE, 15.0 * (1 - reach / DIE), 0.0)
    np.testing.assert_allclose(placed[:, 2], expected, atol=2e-3)
    green = (np.swapaxes(slope, 1, 2) @ slope - np.eye(2)) / 2
    strain = np.linalg.eigvalsh(green)[:, ::-1]
    inner = np.tile([0.5 * (15.0 / DIE) ** 2, 0.0], (3, 1))
    np.testing.assert_allclose(strain[:3], inner, atol=2e-3)


def test_the_bent_flange_rises_unevenly_towards_its_edge(cone):
    _, after = flanged_maps(cone, edge=EDGE, rounding=ROUNDING, bend=0.8)
    angle = np.linspace(0, 2 * np.pi, 60)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inner, outer = (map_points(after, reach * around)[0][:, 2] for reach in (25.0, 29.9))
    assert np.abs(inner).max() < 0.05
    assert outer.max() == pytest.approx(0.8, abs=0.05)
    assert outer.min() < 0.05
