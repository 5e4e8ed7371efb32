"""The stage: two independent records of one material."""

import igl
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import map_coordinates

from shapemorph.config import DamageConfig, SynthesizeConfig
from shapemorph.core.errors import ConfigError
from shapemorph.methods.synthetic.truth import random_material, truth_at, truth_of_material
from shapemorph.stages.synthesize import damage_kinds, synthesize

SMALL = {"faces": 3000, "texture": 512, "speckle": 2.5}


def _pair(**options):
    return synthesize(SynthesizeConfig(**(SMALL | options)))


def _grey(mesh, points):
    """Grey at the points of a mesh nearest to points in space, by other code."""
    _, face, nearest = igl.point_mesh_squared_distance(points, mesh.vertices, mesh.faces)
    a, b, c = (mesh.vertices[mesh.faces[face, k]] for k in range(3))
    weights = igl.barycentric_coordinates(nearest, a, b, c)
    places = np.einsum("nk,nkd->nd", weights, mesh.wedge_uv[face])
    height, width = mesh.textures[0].shape
    rows, cols = (1 - places[:, 1]) * height - 0.5, places[:, 0] * width - 0.5
    return map_coordinates(mesh.textures[0], [rows, cols], order=1)


@pytest.mark.parametrize(
    "shape", ["dome", "bulge", "indentation", "freeform", "hole", "tube", "rigid", "balloon"]
)
def test_both_sides_show_the_same_pattern_at_the_same_material(shape):
    options = {"offset": 5.0, "tilt": 5.0} if shape == "indentation" else {}
    pair = _pair(shape=shape, grey_noise=0.0, vertex_noise=0.0, **options)
    exact = truth_of_material(pair.truth, random_material(pair.truth, 4000, inset=1.0, seed=0))
    away = exact.kink_distance > 1.5
    before, after = _grey(pair.reference, exact.reference), _grey(pair.deformed, exact.deformed)
    # 0.97 leaves room for light gradients, 0.1 mm texels and chords.
    assert np.corrcoef(before[away], after[away])[0, 1] > 0.97


@pytest.mark.parametrize("shape", ["rigid", "hole"])
def test_vertices_of_the_reference_are_on_the_truth_but_for_their_noise(shape):
    pair = _pair(shape=shape, vertex_noise=0.02)
    exact = truth_at(pair.truth, pair.reference.vertices)
    off = np.linalg.norm(pair.reference.vertices - exact.reference, axis=1)
    # Only the normal component is left after projection; its rms is the noise.
    assert np.sqrt(np.mean(off**2)) == pytest.approx(0.02, rel=0.05)


def test_nothing_is_shared_but_the_material():
    pair = _pair(shape="rigid")
    assert pair.reference.vertices.shape != pair.deformed.vertices.shape
    assert not np.allclose(pair.truth.reference_pose.rotation, pair.truth.deformed_pose.rotation)
    counts = [len(np.unique(mesh.wedge_uv.reshape(-1, 2), axis=0)) for mesh in (pair.reference,)]
    assert counts[0] > len(pair.reference.vertices)  # seams
    lights = [np.percentile(mesh.textures[0], [5, 95]) for mesh in (pair.reference, pair.deformed)]
    assert not np.allclose(*lights, atol=0.01)


def test_the_same_configuration_gives_the_same_bits_and_a_seed_changes_them():
    one, again, other = _pair(seed=3), _pair(seed=3), _pair(seed=4)
    for name in ("reference", "deformed"):
        a, b, c = (getattr(pair, name) for pair in (one, again, other))
        assert np.array_equal(a.vertices, b.vertices)
        assert np.array_equal(a.wedge_uv, b.wedge_uv)
        assert np.array_equal(a.textures[0], b.textures[0])
        assert not np.array_equal(a.textures[0], c.textures[0])


def test_noise_moves_vertices_after_the_texture_was_painted():
    clean, noisy = _pair(vertex_noise=0.0), _pair(vertex_noise=0.05)
    for name in ("reference", "deformed"):
        a, b = getattr(clean, name), getattr(noisy, name)
        assert np.array_equal(a.wedge_uv, b.wedge_uv)
        assert np.array_equal(a.textures[0], b.textures[0])
        assert np.std(b.vertices - a.vertices) == pytest.approx(0.05, rel=0.03)


def test_damage_spoils_the_deformed_side_alone():
    damaged = _pair(damage=DamageConfig(glare=True, lost_patch=True, print_at_pole=True))
    clean = _pair()
    assert np.array_equal(damaged.reference.textures[0], clean.reference.textures[0])
    changed = damaged.deformed.textures[0] != clean.deformed.textures[0]
    assert 0.005 < changed.mean() < 0.2
    assert {spot.kind for spot in damaged.truth.damage} == {"print", "glare", "lost_patch"}
    assert not damaged.truth.table.visible.all()


def test_kinds_of_damage_follow_the_configuration():
    assert damage_kinds(DamageConfig()) == ()
    assert damage_kinds(DamageConfig(glare=True, print_at_pole=True)) == ("print", "glare")


def test_ply_pairs_carry_their_grey_at_the_vertices():
    pair = _pair(format="ply", faces=2000)
    assert not pair.reference.has_texture
    assert pair.deformed.corner_grey.std() > 0.1


def test_sizes_scale_everything_but_the_noise():
    small = _pair(size=5.0, speckle=2.5 / 14, vertex_noise=0.0, grey_noise=0.0)
    normal = _pair(vertex_noise=0.0, grey_noise=0.0)
    assert_allclose(14 * small.reference.vertices, normal.reference.vertices, atol=1e-6)
    assert np.abs(small.reference.textures[0] - normal.reference.textures[0]).mean() < 1e-3


def test_an_impossible_punch_is_refused():
    with pytest.raises(ConfigError, match=r"lower synthesize\.offset"):
        _pair(shape="indentation", offset=40.0)


def test_the_direction_of_a_free_form_reaches_the_truth():
    pair = synthesize(SynthesizeConfig(shape="freeform", direction=17.0, faces=300, texture=64))
    assert pair.truth.shape == "freeform(17.0)"
    assert SynthesizeConfig(shape="freeform").direction == 0.0
