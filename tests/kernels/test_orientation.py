from fractions import Fraction

import numpy as np

from shapemorph.kernels.orientation import owns, side


def _true_sign(a, b, p):
    (ax, ay), (bx, by), (px, py) = ([Fraction(float(x)) for x in point] for point in (a, b, p))
    area = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
    return (area > 0) - (area < 0)


def test_side_has_the_exact_sign_next_to_the_line():
    rng = np.random.default_rng(3)
    signs = []
    for _ in range(2000):
        a, b = rng.uniform(0, 1000, (2, 2))
        p = a + rng.uniform(-0.5, 1.5) * (b - a)
        p = p + rng.integers(-2, 3, 2) * np.spacing(p)  # a few units in the last place off
        assert np.sign(side(*a, *b, *p)) == _true_sign(a, b, p)
        signs.append(_true_sign(a, b, p))
    assert {-1, 1} <= set(signs)


def test_side_is_exact_on_coordinates_that_are_not_whole_numbers():
    rng = np.random.default_rng(4)
    zeros = 0
    for _ in range(2000):
        a, b, p = rng.integers(0, 12, (3, 2)) * 0.1
        assert np.sign(side(*a, *b, *p)) == _true_sign(a, b, p)
        zeros += _true_sign(a, b, p) == 0
    assert zeros > 20


def test_side_measures_twice_the_area():
    assert side(1.0, 1.0, 4.0, 1.0, 2.0, 3.0) == 6.0
    assert side(4.0, 1.0, 1.0, 1.0, 2.0, 3.0) == -6.0


def test_a_vertex_belongs_to_exactly_one_triangle_of_its_fan():
    rng = np.random.default_rng(5)
    for sign in (1.0, -1.0):
        for count in (3, 4, 8):
            angle = np.arange(count) * 2 * np.pi / count + rng.choice([0.0, 0.3])
            ring = np.round(np.stack([np.cos(angle), np.sin(angle)], axis=1) * 8) * sign**0
            centre = np.zeros(2)
            owners = 0
            for k in range(count):
                one, other = ring[k], ring[(k + 1) % count]
                if sign < 0:
                    one, other = other, one
                edges = ((centre, one), (one, other), (other, centre))
                owners += all(owns(sign, *a, *b, *centre) for a, b in edges)
            assert owners == 1
