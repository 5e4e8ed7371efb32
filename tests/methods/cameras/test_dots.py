import numpy as np
import pytest

from shapemorph.core.calibration import Target
from shapemorph.core.camera import Camera
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.cameras.dot_bias import middle_of_dots
from shapemorph.methods.cameras.dot_names import Anchor, identify
from shapemorph.methods.cameras.dots import find_dots

RADIUS, SPACING, HEIGHT = 40.0, 9.0, 12
COLUMNS = np.arange(16)


def cylinder(left_out=()):
    """Dots on a part of a cylinder, in rows and columns."""
    rows, columns = np.meshgrid(np.arange(HEIGHT), COLUMNS, indexing="ij")
    lattice = np.stack([rows.ravel(), columns.ravel()], axis=1)
    kept = [tuple(place) not in set(left_out) for place in lattice.tolist()]
    lattice = lattice[kept]
    angle = lattice[:, 1] * SPACING / RADIUS
    normals = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    points = RADIUS * normals + np.outer(lattice[:, 0] * SPACING, [0, 0, 1])
    return Target("cylinder", points, normals=normals, dot_radius=2.0, lattice=lattice)


def camera_at(turn):
    """Look at the middle of the dots, from the given angle about the axis, radians."""
    direction = np.array([np.cos(turn), np.sin(turn), 0.1])
    eye = 400 * direction + np.array([0, 0, HEIGHT * SPACING / 2])
    ahead = -direction / np.linalg.norm(direction)
    down = np.array([0, 0, -1.0]) - ahead * -ahead[2]
    down /= np.linalg.norm(down)
    rotation = np.stack([np.cross(down, ahead), down, ahead])
    pose = RigidTransform(rotation, -rotation @ eye)
    return Camera((900, 900), np.array([2400.0, 2400.0]), np.array([450.0, 450.0]), pose=pose)


def photograph(target, camera, noise=0.01, fine=4):
    """Render dark dots that face the camera, exactly but for 4 x 4 samples a pixel."""
    width, height = camera.size
    shade = np.full((height, width), 0.8)
    own = camera.pose.apply(target.points)
    normals = camera.pose.rotate(target.normals)
    for centre, normal in zip(own, normals, strict=True):
        if centre @ normal > -0.1 * np.linalg.norm(centre):
            continue
        x, y = camera.pixels_of(centre[:2] / centre[2])
        cols = np.arange(int(x) - 20, int(x) + 21)
        rows = np.arange(int(y) - 20, int(y) + 21)
        inside = (cols >= 0) & (cols < width), (rows >= 0) & (rows < height)
        cols, rows = cols[inside[0]], rows[inside[1]]
        sub = (np.arange(fine) + 0.5) / fine - 0.5
        u = (cols[:, None] + sub).ravel()
        v = (rows[:, None] + sub).ravel()
        flat = (np.stack(np.meshgrid(u, v), axis=-1) - camera.centre) / camera.focal
        rays = np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1)
        hits = rays * ((centre @ normal) / (rays @ normal))[..., None]
        dark = np.linalg.norm(hits - centre, axis=-1) < target.dot_radius
        cover = dark.reshape(len(rows), fine, len(cols), fine).mean(axis=(1, 3))
        shade[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1] -= 0.6 * cover
    shade += np.random.default_rng(0).normal(0, noise, shade.shape)
    return shade.astype(np.float32)


@pytest.fixture(scope="module")
def coded():
    target = cylinder(left_out=((3, 4), (3, 7), (7, 6), (8, 9), (5, 11), (9, 2)))
    camera = camera_at(7.5 * SPACING / RADIUS)
    picture = photograph(target, camera)
    return target, camera, find_dots(picture, dark=True)


def test_centres_are_those_of_the_ellipses(coded):
    target, camera, spots = coded
    ids, pixels = identify(target, spots, [])
    own = camera.pose.apply(target.points[ids])
    normals = camera.pose.rotate(target.normals[ids])
    flat = middle_of_dots(own, normals, np.full(len(ids), target.dot_radius))
    error = pixels - camera.pixels_of(flat)
    assert np.sqrt((error**2).mean()) < 0.03
    assert np.abs(error).max() < 0.15


def test_dots_left_out_on_purpose_tell_where_one_is(coded):
    target, camera, spots = coded
    ids, pixels = identify(target, spots, [])
    assert len(ids) > 80
    seen = camera.project(target.points[ids])
    assert np.linalg.norm(seen - pixels, axis=1).max() < 1.0


def test_light_dots_on_a_dark_ground(coded):
    target, camera, dark = coded
    picture = photograph(target, camera)
    light = find_dots((1.0 - picture).astype(np.float32), dark=False)
    np.testing.assert_allclose(light.centres, dark.centres, atol=1e-3)


@pytest.fixture(scope="module")
def plain():
    """A full cylinder looks the same when it is turned by a column."""
    target = cylinder()
    camera = camera_at(6.0 * SPACING / RADIUS)
    return target, camera, find_dots(photograph(target, camera), dark=True)


def test_without_a_mark_a_cylinder_is_ambiguous(plain):
    target, _, spots = plain
    with pytest.raises(DataError, match="ways to number the dots"):
        identify(target, spots, [])


def test_two_named_dots_decide(plain):
    target, camera, spots = plain
    named = [3 * len(COLUMNS) + 5, 8 * len(COLUMNS) + 5]
    anchors = [Anchor(n, camera.project(target.points[n]) + 3.0) for n in named]
    ids, pixels = identify(target, spots, anchors)
    seen = camera.project(target.points[ids])
    assert len(ids) > 80
    assert np.linalg.norm(seen - pixels, axis=1).max() < 1.0


def test_an_anchor_beside_all_dots_is_refused(plain):
    target, _, spots = plain
    with pytest.raises(DataError, match="no dot of the lattice near the anchor"):
        identify(target, spots, [Anchor(0, np.array([5.0, 5.0]))])


def test_a_picture_without_dots_is_refused():
    blank = np.full((300, 300), 0.5, dtype=np.float32)
    with pytest.raises(DataError, match="expected rows and columns of dots"):
        identify(cylinder(), find_dots(blank, dark=True), [])
