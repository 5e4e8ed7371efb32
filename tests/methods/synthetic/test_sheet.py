import numpy as np
from numpy.testing import assert_allclose

from shapemorph.methods.synthetic.material import principal_strains
from shapemorph.methods.synthetic.shapes import material_map
from shapemorph.methods.synthetic.sheet import sheet_name

NAME = sheet_name(stretch=3.0, direction=20.0, turn=-60.0)


def test_name_says_all_about_a_sheet():
    drawn = material_map(NAME, size=50.0, offset=0.0, tilt=0.0)
    points = np.random.default_rng(0).uniform(drawn.lower, drawn.upper, (40, 2))
    e1, e2 = principal_strains(drawn, points)
    assert_allclose(np.sqrt(1 + 2 * e1), 3.0)
    assert_allclose(np.sqrt(1 + 2 * e2), 3.0**-0.5)
    assert drawn.inside(points).all()
    assert_allclose(drawn.upper - drawn.lower, [50.0, 35.0])


def test_stretch_lies_along_its_direction_and_is_turned_after():
    drawn = material_map(NAME, size=50.0, offset=0.0, tilt=0.0)
    along = np.array([[np.cos(np.deg2rad(20)), np.sin(np.deg2rad(20))]])
    wanted = 3 * np.array([np.cos(np.deg2rad(-40)), np.sin(np.deg2rad(-40)), 0])
    assert_allclose(drawn.deformed(along)[0][0], wanted, atol=1e-12)
