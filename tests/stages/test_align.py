import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.config import AlignConfig
from shapemorph.core.errors import ConfigError, DataError, StageError
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.mesh import coloured_mesh
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import TrackedSurface
from shapemorph.stages.align import align

TURN = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()
SHIFT = np.array([30.0, -12.0, 7.0])
NOISE = 0.004


def tracked_map(displacement, noise=NOISE):
    """Disc of radius 30 on a grid, displaced by (x, y) -> (N, 3), then posed elsewhere."""
    j, i = np.meshgrid(np.arange(61.0) - 30, np.arange(67.0) - 33)
    flat = np.stack([j, i], axis=-1)
    height = 0.01 * (j**2 - 0.5 * i**2) + 2 * np.sin(i / 9)
    reference = np.concatenate([flat, height[..., None]], axis=-1)
    moved = reference + displacement(j, i)
    rng = np.random.default_rng(20)
    deformed = (moved - SHIFT) @ TURN + rng.normal(0, noise, reference.shape)
    status = np.where(np.hypot(j, i) < 30, 0, 1).astype(np.uint8)
    status[30:33, 10:13] = PointStatus.LOW_ZNCC
    deformed[status != PointStatus.OK] = np.nan
    reference[status == PointStatus.OUTSIDE_MASK] = np.nan
    normals = np.where(np.isnan(reference), np.nan, [0.0, 0, 1])
    sigma = np.where(status == PointStatus.OK, noise, np.nan)
    deformed_normals = np.where(np.isnan(deformed), np.nan, [0.0, 0, 1])
    return TrackedSurface(
        reference, deformed, normals, deformed_normals, sigma, status, np.full(2, noise)
    )


def mesh_of(points):
    """Mesh over the known points of a grid (R, C, 3)."""
    known = np.isfinite(points).all(axis=-1)
    number = np.cumsum(known.ravel()).reshape(known.shape) - 1
    whole = known[:-1, :-1] & known[:-1, 1:] & known[1:, :-1] & known[1:, 1:]
    a, b = number[:-1, :-1][whole], number[:-1, 1:][whole]
    c, d = number[1:, 1:][whole], number[1:, :-1][whole]
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return coloured_mesh(points[known], faces, np.zeros((len(faces), 3)), name="disc")


def bulge(x, y):
    radius = np.hypot(x, y)
    height = np.where(radius < 22, 8 * (1 + np.cos(np.pi * radius / 22)), 0)
    return np.stack([0 * x, 0 * x, height], axis=-1)


def nowhere(x, _):
    return np.zeros((*x.shape, 3))


def run(tracked, landmarks=None, rigid=None, method="auto"):
    reference, deformed = mesh_of(tracked.reference), mesh_of(tracked.deformed)
    return align(tracked, reference, deformed, landmarks, rigid, AlignConfig(method=method))


def landmarks_of(reference):
    names = tuple(f"P{k}" for k in range(len(reference)))
    return Landmarks(names, reference, (reference - SHIFT) @ TURN)


CORNERS = np.array([[20.0, 0, 1], [-3, 25, 2], [-17, -19, 0], [2, 3, 9]])


def assert_true_pose(found, atol):
    np.testing.assert_allclose(found.rotation, TURN, atol=atol / 30)
    np.testing.assert_allclose(found.translation, SHIFT, atol=atol)


def test_without_landmarks_the_clamped_flange_carries_the_alignment():
    found = run(tracked_map(bulge))
    assert found.method == "points"
    assert_true_pose(found, 0.003)
    j, i = np.meshgrid(np.arange(61.0) - 30, np.arange(67.0) - 33)
    assert np.hypot(j, i).ravel()[found.carrying_points].min() > 20.5
    assert "ring around" in found.note
    assert found.carried_by == len(found.carrying_points)


def test_rigid_body_is_carried_by_all_its_points():
    found = run(tracked_map(nowhere))
    assert found.carried_share > 0.98
    assert found.rms == pytest.approx(NOISE * np.sqrt(3), rel=0.05)
    assert_true_pose(found, 0.001)


def test_where_nothing_moved_rigidly_everything_carries_and_the_note_says_so():
    found = run(tracked_map(lambda x, y: np.stack([0.3 * x, 0.2 * y + 0.01 * x * y, 0 * x], -1)))
    assert found.carried_share == 1
    assert "no part of 5% or more moved rigidly" in found.note


def test_given_region_is_the_only_one_that_counts():
    j, _ = np.meshgrid(np.arange(61.0) - 30, np.arange(67.0) - 33)
    shift_right_half = lambda x, _: np.where(x > -20, 1.0, 0)[..., None] * [0, 0, 1.0]  # noqa: E731
    tracked = tracked_map(shift_right_half)
    everywhere = run(tracked)
    region = run(tracked, rigid=j < -21)
    assert_true_pose(region, 0.02)
    assert abs(everywhere.translation[2] - SHIFT[2]) > 0.5  # the larger part has moved up


def test_exact_landmarks_are_found_to_rounding_and_preferred_by_auto():
    found = run(tracked_map(bulge), landmarks_of(CORNERS))
    assert found.method == "landmarks"
    assert_true_pose(found, 1e-10)
    assert found.residuals.shape == (4,)
    assert found.rms < 1e-12


def test_each_landmark_has_its_residual_and_the_note_names_the_worst():
    landmarks = landmarks_of(CORNERS)
    landmarks.deformed[2] += [0.5, 0, 0]
    found = run(tracked_map(bulge), landmarks)
    assert found.residuals.argmax() == 2
    assert "P2" in found.note


def test_mirrored_landmarks_are_refused():
    mirrored = Landmarks(("a", "b", "c", "d"), CORNERS, CORNERS * [1, 1, -1])
    with pytest.raises(DataError, match="mirrored"):
        run(tracked_map(bulge), mirrored)


def test_landmarks_on_a_line_or_missing_are_refused():
    line = np.arange(3.0)[:, None] * [1, 2, 3]
    with pytest.raises(DataError, match="not on one line"):
        run(tracked_map(bulge), Landmarks(("a", "b", "c"), line, line))
    with pytest.raises(ConfigError, match=r"inputs\.landmarks"):
        run(tracked_map(bulge), method="landmarks")


def test_icp_mends_rough_landmarks_on_the_rigid_part():
    rng = np.random.default_rng(21)
    rough = landmarks_of(CORNERS)
    rough = Landmarks(rough.names, rough.reference + rng.normal(0, 0.3, (4, 3)), rough.deformed)
    j, i = np.meshgrid(np.arange(61.0) - 30, np.arange(67.0) - 33)
    tracked = tracked_map(bulge)
    found = run(tracked, rough, rigid=np.hypot(j, i) > 22.5, method="landmarks+icp")
    assert found.method == "landmarks+icp"
    assert_true_pose(found, 0.02)


def test_icp_alone_starts_from_the_matched_points():
    found = run(tracked_map(bulge), method="icp")
    assert_true_pose(found, 0.05)  # the gentle curves of the flange hold it weakly in its plane
    assert found.method == "points+icp"


def test_too_few_points_are_an_error_that_says_what_to_do():
    tracked = tracked_map(bulge)
    rigid = np.zeros(tracked.status.shape, dtype=bool)
    rigid[5, 30] = True
    with pytest.raises(StageError, match=r"align\.rigid_region"):
        run(tracked, rigid=rigid)
