"""Painting: the same material carries the same pattern on both sides."""

import igl
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import map_coordinates

from shapemorph.kernels.painting import speckle_at
from shapemorph.methods.synthetic.atlas import lay_out_atlas
from shapemorph.methods.synthetic.painting import (
    BRIGHT,
    DARK,
    Light,
    Scene,
    paint_texture,
    paint_vertices,
    record_grey,
)
from shapemorph.methods.synthetic.shapes import material_map
from shapemorph.methods.synthetic.speckle import scatter_speckle
from shapemorph.methods.synthetic.triangulation import triangulate

EVEN = Light(gain=1.0, offset=0.0, gradient=np.zeros(2))


def _scene(shape, diameter=2.0, light=EVEN):
    mapped = material_map(shape, size=70.0, offset=0.0, tilt=0.0)
    speckle = scatter_speckle(mapped, diameter=diameter, rng=np.random.default_rng(0))
    return Scene(mapped, speckle, light, ())


def _pattern(scene, material):
    speckle = scene.speckle
    bright = speckle_at(material, speckle.blobs, speckle.origin, speckle.cell, speckle.edge)
    return DARK + (BRIGHT - DARK) * bright


@pytest.mark.parametrize("shape", ["bulge", "tube", "freeform"])
def test_a_texture_shows_the_material_under_each_point_of_the_deformed_surface(shape):
    """Exact deformed positions, looked up on the mesh and in its texture by other code."""
    scene = _scene(shape)
    mapped = scene.material_map
    mesh = triangulate(mapped, mapped.deformed, faces=6000, rng=np.random.default_rng(1))
    uv = lay_out_atlas(mesh.vertices, mesh.faces, gutter=0.01, rng=np.random.default_rng(2))
    texture = paint_texture(mesh, uv, scene, width=1024, gutter=10)
    trial = np.random.default_rng(3).uniform(mapped.lower, mapped.upper, (8000, 2))
    material = trial[mapped.rim(trial) > 0.5]
    positions = mapped.deformed(material)[0]
    _, face, nearest = igl.point_mesh_squared_distance(positions, mesh.vertices, mesh.faces)
    a, b, c = (mesh.vertices[mesh.faces[face, k]] for k in range(3))
    weights = igl.barycentric_coordinates(nearest, a, b, c)
    places = np.einsum("nk,nkd->nd", weights, uv[face])
    rows, cols = (1 - places[:, 1]) * 1024 - 0.5, places[:, 0] * 1024 - 0.5
    seen = map_coordinates(texture, [rows, cols], order=1)
    away = mapped.kink(material) > 1.0
    error = np.abs(seen - _pattern(scene, material))[away]
    # An edge of a blob climbs 0.73 in 0.5 mm: 0.02 is 0.014 mm.
    assert np.median(error) < 0.004
    assert np.percentile(error, 99) < 0.06


def test_half_of_the_material_is_dark():
    scene = _scene("dome", diameter=0.8)
    material = np.random.default_rng(5).uniform(-20, 20, (200_000, 2))
    dark = _pattern(scene, material) < 0.5 * (DARK + BRIGHT)
    assert dark.mean() == pytest.approx(0.5, abs=0.03)


def test_the_speckle_closes_around_a_tube():
    scene = _scene("tube")
    material = np.random.default_rng(6).uniform(0, 60, (1000, 2))
    round_once = material + np.array([scene.material_map.period, 0.0])
    assert_allclose(_pattern(scene, round_once), _pattern(scene, material), atol=1e-9)


def test_light_is_gain_offset_and_gradient():
    light = Light(gain=0.9, offset=0.05, gradient=np.array([0.2, -0.1]))
    scene = _scene("dome", light=light)
    material = np.array([[0.0, 0.0], [35.0, 0.0], [0.0, 17.5]])
    found = scene.grey(np.array([1.0, 1.0, 0.0]), material)
    expected = 0.05 + 0.9 * np.array([BRIGHT, 1.1 * BRIGHT, 0.975 * DARK])
    assert_allclose(found, expected, atol=1e-12)


def test_gutters_continue_the_island_and_the_rest_is_plain():
    scene = _scene("rigid")
    mapped = scene.material_map
    mesh = triangulate(mapped, mapped.reference, faces=2000, rng=np.random.default_rng(1))
    uv = lay_out_atlas(mesh.vertices, mesh.faces, gutter=0.02, rng=np.random.default_rng(2))
    near = paint_texture(mesh, uv, scene, width=256, gutter=0)
    wide = paint_texture(mesh, uv, scene, width=256, gutter=5)
    grown = wide != near
    assert grown.mean() > 0.05
    assert (near[grown] == 0.5).all()
    assert (wide == 0.5).any()


def test_vertices_take_the_mean_of_the_pattern_around_them():
    scene = _scene("rigid", diameter=4.0)
    mapped = scene.material_map
    mesh = triangulate(mapped, mapped.reference, faces=40_000, rng=np.random.default_rng(1))
    grey = paint_vertices(mesh, scene)
    assert np.abs(grey - _pattern(scene, mesh.material)).mean() < 0.03  # blobs of 8 edges


def test_a_record_is_in_whole_levels_with_the_noise_asked_for():
    grey = np.full((300, 200), 0.5, dtype=np.float32)
    found = record_grey(grey, noise=2.0, rng=np.random.default_rng(0)) * 255
    assert_allclose(found, np.rint(found), atol=1e-4)
    assert np.std(found) == pytest.approx(np.hypot(2.0, np.sqrt(1 / 12)), rel=0.02)
    bright = record_grey(grey + 0.8, noise=2.0, rng=np.random.default_rng(0))
    assert bright.max() == bright.min() == 1.0
