"""A picture seen from behind: other columns, the same places on the mesh."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.config import FlattenConfig, SynthesizeConfig
from shapemorph.methods.distortion import chart_handedness
from shapemorph.methods.mirroring import mirror_image
from shapemorph.methods.surface_lookup import grey_at, locate, pixel_positions, positions, project
from shapemorph.stages.flatten import flatten_mesh
from shapemorph.stages.synthesize import synthesize


@pytest.fixture(scope="module")
def dome():
    mesh = synthesize(SynthesizeConfig(shape="dome", faces=2000, texture=256, speckle=4)).deformed
    return mesh, flatten_mesh(mesh, FlattenConfig(method="lscm")).calibrated


def test_left_and_right_change_places_and_twice_is_nothing(dome):
    _, image = dome
    mirrored = mirror_image(image)
    assert chart_handedness(mirrored.chart) == -chart_handedness(image.chart)
    np.testing.assert_array_equal(mirrored.image.grey, image.image.grey[:, ::-1])
    again = mirror_image(mirrored)
    np.testing.assert_array_equal(again.triangle, image.triangle)
    assert_allclose(again.chart.vertex_px, image.chart.vertex_px, atol=1e-12)


def test_every_pixel_keeps_its_place_and_grey(dome):
    mesh, image = dome
    mirrored = mirror_image(image)
    assert_allclose(pixel_positions(mesh, mirrored), pixel_positions(mesh, image)[:, ::-1])
    rows, columns = np.nonzero(mirrored.image.mask)
    points = np.column_stack([columns, rows])[::7].astype(float)
    there = locate(mirrored, points)
    assert_allclose(project(mirrored, there), points, atol=1e-9)
    assert_allclose(
        positions(mesh, there),
        pixel_positions(mesh, mirrored)[rows[::7], columns[::7]],
        atol=1e-9 * mesh.size,
    )
    grey, inside = grey_at(mesh, mirrored, points)
    assert inside.all()
    assert_allclose(grey, mirrored.image.grey[rows[::7], columns[::7]], atol=1e-5)
