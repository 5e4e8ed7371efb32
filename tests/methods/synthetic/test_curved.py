import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.methods.synthetic.curved import freeform_name
from shapemorph.methods.synthetic.material import principal_strains
from shapemorph.methods.synthetic.shapes import material_map


def freeform(direction):
    return material_map(freeform_name(direction), size=70.0, offset=0.0, tilt=0.0)


def on_disk(count=200, reach=25.0):
    draw = np.random.default_rng(0).uniform(-1, 1, (4 * count, 2))
    return reach * draw[np.linalg.norm(draw, axis=1) < 1][:count]


def rotation(degrees):
    angle = np.deg2rad(degrees)
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize("direction", [17.0, -80.0])
def test_a_turned_free_form_takes_turned_material_to_the_same_place(direction):
    plain, turned, points = freeform(0.0), freeform(direction), on_disk()
    there = turned.deformed(points @ rotation(direction).T)[0]
    assert_allclose(there, plain.deformed(points)[0], atol=1e-12)


def test_the_reference_of_a_turned_free_form_stays():
    plain, turned, points = freeform(0.0), freeform(45.0), on_disk()
    assert_allclose(turned.reference(points)[0], plain.reference(points)[0])
    assert_allclose(turned.loops[0], plain.loops[0])


def test_derivatives_of_a_turned_free_form_are_those_of_its_positions():
    turned, points, step = freeform(17.0), on_disk(), 1e-4
    numeric = [
        (turned.deformed(points + step * axis)[0] - turned.deformed(points - step * axis)[0])
        / (2 * step)
        for axis in np.eye(2)
    ]
    assert_allclose(turned.deformed(points)[1], np.stack(numeric, axis=-1), atol=2e-8)


def test_a_free_form_stays_about_as_stretched_however_it_is_turned():
    found = [principal_strains(freeform(d), on_disk())[0].mean() for d in (0.0, 45.0, 80.0)]
    assert_allclose(found, found[0], rtol=0.1)
