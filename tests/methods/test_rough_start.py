import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial import Delaunay

from shapemorph.config import MatchConfig
from shapemorph.core.image import CalibratedImage, Chart, GreyImage
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.laws import Dots, NodalField
from shapemorph.core.mesh import coloured_mesh
from shapemorph.methods.rough_start import dots_of_field, dots_of_landmarks, settled_dots
from shapemorph.methods.synthetic.planar import Exposure, take_picture
from shapemorph.methods.synthetic.planar_textures import printed_dots
from shapemorph.methods.warping import warp_points
from shapemorph.stages.match import match

MATRIX = np.array([[1.5, 0.3], [-0.2, 1.1]])
SHAPE = (310, 430)
MIDDLE = np.array(SHAPE[::-1]) / 2


def moved(points):
    return (points - 120) @ MATRIX.T + MIDDLE


@pytest.fixture(scope="module")
def equal_dots():
    """Dots that are all alike, 16 px apart: only marks can tell which is which."""
    pattern = printed_dots(pitch=16, other=None, share=0.0)
    inside = lambda p: np.linalg.norm(p - 120, axis=-1) < 115  # noqa: E731
    back = np.linalg.inv(MATRIX)
    return [
        take_picture(
            pattern,
            shape,
            Exposure(gain=gain, offset=0.0, slope=0.1, noise=2.0, seed=k),
            material_at=material_at,
            inside=inside,
        )
        for k, (shape, gain, material_at) in enumerate(
            [
                ((240, 240), 1.0, lambda p: p),
                (SHAPE, 0.8, lambda p: (p - MIDDLE) @ back.T + 120),
            ]
        )
    ]


def marks(seed=0, count=6):
    angle = 2 * np.pi * np.arange(count) / count
    source = 120 + 85 * np.stack([np.cos(angle), np.sin(angle)], -1)
    noise = np.random.default_rng(seed).normal(0, 1.5, source.shape)
    return Dots(source, moved(source) + noise)


def test_marks_tell_which_dot_is_which(equal_dots):
    found = match(*equal_dots, MatchConfig(), marks())
    error = np.linalg.norm(found.deformed_px - moved(found.reference_px), axis=1)
    assert len(error) > 300
    assert error.max() < 1.0
    assert found.manner == "marks or a model that were given"
    assert "repeats every 16 px" in found.doubt
    rows, cols = np.nonzero(equal_dots[0].mask[::8, ::8])
    points = 8.0 * np.column_stack([cols, rows])
    assert_allclose(warp_points(found.forward, points)[0], moved(points), atol=1.5)


def test_wrong_marks_lead_nowhere(equal_dots):
    known = marks()
    swapped = Dots(known.reference_px, known.deformed_px[::-1] * [1.0, -1.0] + [0.0, SHAPE[0]])
    assert settled_dots(*equal_dots, Dots(swapped.reference_px, swapped.deformed_px * 3)) is None


@pytest.mark.parametrize("source", ["few", "line", "lost"])
def test_marks_that_fix_no_warp_are_left_aside(equal_dots, source):
    known = marks()
    reference = known.reference_px.copy()
    if source == "few":
        known = Dots(known.reference_px[:2], known.deformed_px[:2])
    elif source == "line":
        reference[:, 1] = 2 * reference[:, 0]
        known = Dots(reference, known.deformed_px)
    else:
        reference[2:] = np.nan
        known = Dots(reference, known.deformed_px)
    assert settled_dots(*equal_dots, known) is None


def sheet(shape, place):
    """Mesh of a sheet that fills its picture; `place` carries px to space."""
    columns, rows = np.meshgrid(
        np.arange(-1.0, shape[1] + 9, 10), np.arange(-1.0, shape[0] + 9, 10)
    )
    flat = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    faces = Delaunay(flat).simplices.astype(np.int64)
    turned = np.linalg.det(flat[faces[:, 1:]] - flat[faces[:, :1]]) > 0
    faces[turned] = faces[turned][:, ::-1]
    chart = Chart(np.arange(len(flat)), faces, np.arange(len(faces)), flat, 2.0, np.zeros(1, int))
    blank = GreyImage(np.zeros(shape, "f4"), np.ones(shape, dtype=bool))
    nowhere = np.full(shape, -1, np.int32), np.full((*shape, 2), np.nan)
    mesh = coloured_mesh(place(flat), faces, np.full((len(faces), 3), 0.5), name="sheet")
    return mesh, CalibratedImage(blank, chart, *nowhere)


def flat_at(px):
    return np.column_stack([px / 2.0, np.zeros(len(px))])


def bowl_at(px):
    plane = (px - 80.0) / 2.0
    return np.column_stack([plane, 0.01 * (plane**2).sum(axis=1)])


def test_landmarks_are_found_in_both_pictures():
    px = np.array([[20.0, 30.0], [90.0, 40.0], [50.0, 100.0]])
    landmarks = Landmarks(("a", "b", "c"), flat_at(px), bowl_at(px + 12))
    found = dots_of_landmarks(landmarks, sheet((120, 130), flat_at), sheet((150, 160), bowl_at))
    assert_allclose(found.reference_px, px, atol=1e-6)
    assert_allclose(found.deformed_px, px + 12, atol=0.4)  # a bowl of flat triangles


def test_a_model_in_the_frame_of_the_files_says_where_points_go():
    nodes = np.stack(np.meshgrid(np.arange(0.0, 140, 6), np.arange(0.0, 130, 6)), -1).reshape(-1, 2)
    field = NodalField(flat_at(nodes), bowl_at(nodes + 12) - flat_at(nodes))
    reference, deformed = sheet((120, 130), flat_at), sheet((150, 160), bowl_at)
    found = dots_of_field(field, reference, deformed)
    assert len(found.reference_px) > 500
    assert_allclose(found.deformed_px, found.reference_px + 12, atol=0.5)
    elsewhere = NodalField(field.nodes, field.displacement + np.array([0.0, 0.0, 900.0]))
    assert len(dots_of_field(elsewhere, reference, deformed).reference_px) == 0
