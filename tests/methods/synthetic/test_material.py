"""Material maps against numerical differentiation and closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.errors import ConfigError
from shapemorph.methods.synthetic.material import (
    nearest_material,
    principal_strains,
    rim_distance,
)
from shapemorph.methods.synthetic.shapes import material_map

SHAPES = ("dome", "bulge", "indentation", "freeform", "hole", "tube", "rigid", "balloon")


def _map(shape, size=70.0):
    offset, tilt = (0.09 * size, 0.15) if shape == "indentation" else (0.0, 0.0)
    return material_map(shape, size=size, offset=offset, tilt=tilt)


def _inside(mapped, count=3000, seed=0, margin=0.0):
    trial = np.random.default_rng(seed).uniform(mapped.lower, mapped.upper, (3 * count, 2))
    return trial[mapped.rim(trial) > margin][:count]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("state", ["reference", "deformed"])
def test_derivatives_agree_with_differences_of_the_positions(shape, state):
    mapped = _map(shape)
    embed = getattr(mapped, state)
    material = _inside(mapped, margin=0.01)
    material = material[mapped.kink(material) > 0.01]
    step = 1e-4  # central differences: truncation 1e-9, rounding 1e-12 / 1e-4
    numeric = [
        (embed(material + step * axis)[0] - embed(material - step * axis)[0]) / (2 * step)
        for axis in np.eye(2)
    ]
    assert_allclose(embed(material)[1], np.stack(numeric, axis=-1), atol=2e-8)


@pytest.mark.parametrize("shape", SHAPES)
def test_strains_agree_with_lengths_of_small_material_crosses(shape):
    """Independent of the derivatives: squared lengths in 3 directions settle the tensor."""
    mapped = _map(shape)
    material = _inside(mapped, count=400, margin=0.1)
    material = material[mapped.kink(material) > 0.1]
    step = 1e-4
    squares = []
    for embed in (mapped.reference, mapped.deformed):
        arms = [
            (embed(material + step * np.array(d))[0] - embed(material - step * np.array(d))[0])
            / (2 * step)
            for d in ((1, 0), (0, 1), (1, 1))
        ]
        squares.append([np.sum(arm**2, axis=1) for arm in arms])
    (a, b, ab), (c, d, cd) = squares
    before = np.stack([a, (ab - a - b) / 2, (ab - a - b) / 2, b], axis=1).reshape(-1, 2, 2)
    after = np.stack([c, (cd - c - d) / 2, (cd - c - d) / 2, d], axis=1).reshape(-1, 2, 2)
    stretch = np.sort(np.linalg.eigvals(np.linalg.inv(before) @ after).real, axis=1)
    e1, e2 = principal_strains(mapped, material)
    # The square root of a discriminant near zero turns 1e-9 into 3e-5 where E1 = E2.
    assert_allclose(e1, (stretch[:, 1] - 1) / 2, atol=1e-4)
    assert_allclose(e2, (stretch[:, 0] - 1) / 2, atol=1e-4)


def test_dome_has_the_strains_of_the_paper():
    mapped = _map("dome", size=45.0)
    material = _inside(mapped)
    radius = np.linalg.norm(material, axis=1)
    on_cap = radius <= np.pi * 22.5 / 4
    hoop = np.where(on_cap, 22.5 / radius * np.sin(2 * radius / 22.5), 22.5 / radius)
    e1, e2 = principal_strains(mapped, material)
    assert_allclose(e1, 1.5, atol=1e-12)
    assert_allclose(e2, (hoop**2 - 1) / 2, atol=1e-12)
    wall_foot = mapped.deformed(np.array([[0.0, 22.5]]))[0][0]
    assert_allclose(wall_foot, [0, 22.5, -22.5 - 9.657], atol=1e-3)


def test_bulge_keeps_its_flange_and_reaches_1_9_at_the_pole():
    mapped = _map("bulge")
    e1, e2 = principal_strains(mapped, np.array([[1e-9, 0.0], [-20.0, 24.0], [22.4, 0.0]]))
    assert_allclose([e1[0], e2[0]], (2.19**2 - 1) / 2, atol=1e-6)
    assert_allclose([e1[1], e2[1]], 0, atol=1e-12)
    assert e1[2] > 0.4  # the other side of the kink
    assert_allclose(mapped.kink(np.array([[0.0, 20.5], [26.0, 0.0]])), [2.0, 3.5], atol=1e-12)


@pytest.mark.parametrize("shape", ["bulge", "indentation"])
def test_a_clamped_rim_stays_where_it_is(shape):
    mapped = _map(shape)
    loop = mapped.loops[0]
    assert_allclose(mapped.deformed(loop)[0], mapped.reference(loop)[0], atol=1e-11)


def test_positions_are_continuous_across_the_kink():
    mapped = _map("bulge")
    edge = mapped.kink_loops[0][::97]
    inner, outer = mapped.deformed(edge * (1 - 1e-9))[0], mapped.deformed(edge * (1 + 1e-9))[0]
    assert_allclose(inner, outer, atol=1e-6)


def test_the_tip_of_the_punch_lies_at_its_offset_and_leans():
    mapped = _map("indentation")
    tip = mapped.deformed(mapped.pole[None])[0][0]
    assert_allclose(tip, [6.3, np.tan(0.15) * tip[2], 32 / 76 * 70], atol=1e-9)
    e1, _ = principal_strains(mapped, mapped.pole[None])
    assert 1.15 < e1[0] < 1.35


@pytest.mark.parametrize("shape", SHAPES)
def test_strains_do_not_depend_on_the_size(shape):
    small, large = _map(shape, 5.0), _map(shape, 3000.0)
    material = _inside(small, count=200)
    for one, other in zip(
        principal_strains(small, material), principal_strains(large, 600 * material), strict=True
    ):
        assert_allclose(one, other, atol=1e-7)


def test_rigid_has_no_strain_and_freeform_no_symmetry():
    rigid, freeform = _map("rigid"), _map("freeform")
    material = _inside(rigid)
    assert_allclose(principal_strains(rigid, material), 0, atol=1e-7)
    material = _inside(freeform, count=500)
    e1, e2 = principal_strains(freeform, material)
    assert 1.9 < np.sqrt(1 + 2 * np.median(e1)) < 2.2
    assert 0.75 < np.sqrt(1 + 2 * np.median(e2)) < 0.9
    for mirror in ([-1, 1], [1, -1], [-1, -1]):
        assert np.abs(principal_strains(freeform, material * mirror)[0] - e1).max() > 0.1


@pytest.mark.parametrize("shape", SHAPES)
def test_the_nearest_material_of_a_lifted_point_is_its_foot(shape):
    mapped = _map(shape)
    material = _inside(mapped, count=500)
    position, jacobian = mapped.reference(material)
    normal = np.cross(jacobian[..., 0], jacobian[..., 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    lift = np.random.default_rng(1).normal(0, 0.1, (len(material), 1))
    assert_allclose(nearest_material(mapped, position + lift * normal), material, atol=1e-10)


def test_a_tube_closes_on_itself():
    mapped = _map("tube")
    material = _inside(mapped, count=100)
    once_round = material + np.array([mapped.period, 0.0])
    for embed in (mapped.reference, mapped.deformed):
        assert_allclose(embed(once_round)[0], embed(material)[0], atol=1e-10)


def test_rim_distance_is_that_of_the_nearest_rim():
    hole, rigid = _map("hole"), _map("rigid")
    assert_allclose(rim_distance(hole, np.array([[0.0, 8.0], [0.0, -6.0]])), [1, -1], atol=1e-12)
    assert_allclose(rim_distance(hole, np.array([[29.0, 0.0]])), [35 - 4.2 - 29], atol=1e-9)
    inner = np.array([[33.0, 0.0], [36.0, 0.0]])
    slope = np.linalg.norm(rigid.reference(np.array([[34.0, 0.0]]))[1][0, :, 0])
    assert_allclose(rim_distance(rigid, inner), [2 * slope, -slope], rtol=0.02)


def test_a_punch_beside_the_disc_is_refused():
    with pytest.raises(ConfigError, match="offset of 20 mm for 70 mm"):
        material_map("indentation", size=70.0, offset=20.0, tilt=0.0)
    with pytest.raises(ConfigError, match="got 'cone'"):
        material_map("cone", size=70.0, offset=0.0, tilt=0.0)
