import numpy as np
import pytest

from shapemorph.core.spline_map import SplineMap
from shapemorph.methods.synthetic.membrane.disc import disc_mesh
from shapemorph.methods.synthetic.membrane.smooth import fit_map, map_points
from shapemorph.methods.synthetic.photograph import Sheet, Studio, material_at, take_picture
from shapemorph.methods.synthetic.revolution import disc_map, flat, indentation
from shapemorph.methods.synthetic.speckle import Speckle, scatter_speckle
from shapemorph.methods.synthetic.stereo_rig import stereo_rig

RADIUS = 38.0
STUDIO = Studio(
    lights=np.array([[0.0, 0.0, 1.0, 0.5]]),
    ambient=0.3,
    gloss=0.1,
    hardness=20.0,
    samples=2,
    blur_px=0.6,
    noise=0.0,
)


@pytest.fixture(scope="module")
def sheet():
    material, _ = disc_mesh(RADIUS, 40)
    bent, _ = indentation(76.0, offset=4.0, tilt=0.08).deformed(material)
    speckle = scatter_speckle(disc_map(RADIUS, flat), diameter=1.5, rng=np.random.default_rng(0))
    return Sheet(fit_map(material, bent, spacing=1.6), RADIUS, speckle)


@pytest.fixture(scope="module")
def rig():
    return stereo_rig(scale=0.15, target=np.array([0.0, 0.0, 12.0]))


def test_every_pixel_shows_the_material_that_lies_on_its_ray(sheet, rig):
    for camera in rig.cameras:
        _, material = take_picture(sheet, camera, STUDIO, np.random.default_rng(0))
        row, column = np.nonzero(np.isfinite(material[..., 0]))
        assert len(row) > 30_000
        points, _ = map_points(sheet.mapped, material[row, column])
        off = camera.project(points) - np.stack([column, row], axis=1)
        assert np.abs(off).max() < 1e-6


def test_material_is_found_at_pixels_between_centres(sheet, rig):
    camera = rig.cameras[1]
    pixels = camera.project(
        map_points(sheet.mapped, np.array([[3.0, -7.0], [-20.0, 11.0], [0.0, 37.0]]))[0]
    )
    beside = np.array([[1.0, 1.0], [np.nan, 2.0], [1e4, 0.0]])
    found = material_at(sheet, camera, np.concatenate([pixels, beside]))
    np.testing.assert_allclose(found[:3], [[3.0, -7.0], [-20.0, 11.0], [0.0, 37.0]], atol=1e-9)
    assert np.isnan(found[3:]).all()


def test_brightness_follows_the_light(rig):
    """A flat white sheet straight under the light: ambient and light, no blobs."""
    material, _ = disc_mesh(RADIUS, 20)
    level = fit_map(material, np.column_stack([material, np.zeros(len(material))]), spacing=4.0)
    white = Speckle(np.zeros((4, 4, 3)), np.zeros(2), np.full(2, 1.0), 1e-9)
    matt = Studio(STUDIO.lights, 0.3, 0.0, 1.0, 1, 0.0, 0.0)
    picture, seen = take_picture(
        Sheet(level, RADIUS, white), rig.cameras[0], matt, np.random.default_rng(0)
    )
    on = np.isfinite(seen[..., 0])
    assert np.unique(picture[on]).tolist() == pytest.approx([round(255 * 0.85 * 0.8) / 255])


def test_what_is_in_front_hides_what_is_behind(rig):
    """A sheet folded over itself: only the upper sheet is seen."""
    count = 41
    x, y = np.meshgrid(np.linspace(-40, 40, count), np.linspace(-40, 40, count))
    angle = 2.5 / (1 + np.exp(-x / 2.0))
    step = np.diff(x, axis=1, prepend=x[:, :1] - 2.0)
    across, up = np.cumsum(np.cos(angle) * step, axis=1), np.cumsum(np.sin(angle) * step, axis=1)
    folded = SplineMap(np.stack([across - 20.0, y, up], axis=-1), np.array([-40.0, -40.0]), 2.0)
    blank = Speckle(np.zeros((4, 4, 3)), np.zeros(2), np.full(2, 1.0), 1e-9)
    sheet = Sheet(folded, 30.0, blank)
    _, seen = take_picture(sheet, rig.cameras[0], STUDIO, np.random.default_rng(0))
    on = np.isfinite(seen[..., 0])
    points, slope = map_points(folded, seen[on])
    normal = np.cross(slope[..., 0], slope[..., 1])
    towards = rig.cameras[0].position - points
    assert ((normal * towards).sum(axis=1) > 0).all()
