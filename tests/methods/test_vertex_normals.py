import numpy as np

from shapemorph.core.image import SurfacePoints
from shapemorph.methods.vertex_normals import normals_at, vertex_normals


def sphere():
    """Octahedron-based sphere of radius 3, outward faces."""
    vertices = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    faces = np.array(
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    )
    return 3 * vertices, faces


def test_normals_of_a_sphere_point_outwards_with_and_without_smoothing():
    vertices, faces = sphere()
    for passes in (0, 2):
        found = vertex_normals(vertices, faces, passes=passes)
        np.testing.assert_allclose(found, vertices / 3, atol=1e-12)


def test_turned_faces_turn_the_normals():
    vertices, faces = sphere()
    np.testing.assert_allclose(
        vertex_normals(vertices, faces[:, ::-1], passes=1), -vertices / 3, atol=1e-12
    )


def test_vertex_without_a_face_has_no_normal():
    vertices, faces = sphere()
    found = vertex_normals(np.vstack([vertices, [9, 9, 9]]), faces, passes=2)
    assert np.isnan(found[-1]).all()
    assert np.isfinite(found[:-1]).all()


def test_interpolated_normal_is_a_unit_vector_and_missing_off_the_surface():
    vertices, faces = sphere()
    points = SurfacePoints(np.array([0, -1]), np.array([[0.2, 0.3, 0.5], [np.nan] * 3]))
    found = normals_at(vertex_normals(vertices, faces, passes=0), faces, points)
    np.testing.assert_allclose(found[0], np.array([0.2, 0.3, 0.5]) / np.sqrt(0.38), atol=1e-12)
    assert np.isnan(found[1]).all()
