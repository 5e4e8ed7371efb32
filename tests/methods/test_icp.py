import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.core.transform import RigidTransform
from shapemorph.methods.face_planes import face_planes, typical_edge
from shapemorph.methods.icp import fit_icp


def height_field(height, rows=50, cols=60):
    i, j = np.meshgrid(np.arange(rows), np.arange(cols), indexing="ij")
    corner = (i * cols + j)[:-1, :-1].ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + cols + 1], axis=1),
            np.stack([corner, corner + cols + 1, corner + cols], axis=1),
        ]
    )
    x, y = j.ravel() * 1.0, i.ravel() * 1.0
    return np.stack([x, y, height(x, y)], axis=1), faces


def waves(x, y):
    return 4 * np.sin(x / 8) * np.cos(y / 6 + 1)


TRUE = RigidTransform(Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix(), np.array([3.0, 5, -2]))
NEAR = RigidTransform(
    Rotation.from_rotvec([0.01, -0.02, 0.01]).as_matrix() @ TRUE.rotation,
    TRUE.translation + np.array([0.1, -0.3, 0.2]),
)


def test_wavy_surface_finds_its_place_though_a_patch_of_it_has_moved_away():
    vertices, faces = height_field(waves)
    centres, normals = face_planes(TRUE.apply(vertices), faces)
    source = centres[::3] @ TRUE.rotation - TRUE.translation @ TRUE.rotation
    lifted = np.hypot(source[:, 0] - 40, source[:, 1] - 30) < 10  # a tenth of it
    source = source + np.where(lifted, 1.0, 0)[:, None] * [0, 0, 1]
    found = fit_icp(source, centres, normals, NEAR, reach=3.0, iterations=60)
    assert found.free == 0
    np.testing.assert_allclose(
        found.transform.apply(source[~lifted]), centres[::3][~lifted], atol=1e-4
    )
    assert found.rms < 1e-4


def test_flat_surface_keeps_the_start_in_the_directions_it_can_slide():
    vertices, faces = height_field(lambda x, _: 0 * x)
    centres, normals = face_planes(vertices, faces)
    inner = centres[(np.abs(centres - [29.5, 24.5, 0]) < 15).all(axis=1)]
    start = RigidTransform(
        Rotation.from_rotvec([0.005, 0.004, 0.02]).as_matrix(), np.array([0.3, -0.2, 0.1])
    )
    found = fit_icp(inner, centres, normals, start, reach=2.0, iterations=60)
    assert found.free == 3
    carried = found.transform.apply(inner)
    np.testing.assert_allclose(carried[:, 2], 0, atol=1e-3)
    middle = inner.mean(axis=0)
    np.testing.assert_allclose(
        found.transform.apply(middle)[:2], start.apply(middle)[:2], atol=1e-2
    )


def test_surface_out_of_reach_keeps_the_start_and_carries_nothing():
    vertices, faces = height_field(waves)
    centres, normals = face_planes(vertices, faces)
    start = RigidTransform(np.eye(3), np.array([0, 0, 500.0]))
    found = fit_icp(centres, centres, normals, start, reach=1.0, iterations=10)
    assert found.carried == 0
    assert found.free == 6
    np.testing.assert_allclose(found.transform.translation, start.translation)


def test_faces_without_area_have_no_plane():
    vertices = np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 0], [4, 0, 0]])
    centres, normals = face_planes(vertices, np.array([[0, 1, 2], [0, 1, 3]]))
    np.testing.assert_allclose(centres, [[2 / 3, 1, 0]])
    np.testing.assert_allclose(normals, [[0, 0, 1]])


def test_typical_edge_is_the_median_over_the_sides_of_faces():
    vertices = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])
    assert typical_edge(vertices, np.array([[0, 1, 2]])) == 4
