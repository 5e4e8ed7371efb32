"""Faces under measured cells, on sheets where they can be counted."""

import numpy as np

from shapemorph.methods.covered_faces import covered_faces


def _grid(rows, columns, step, z=0.0):
    """Points of a regular grid in a plane and the quads between them."""
    y, x = np.mgrid[0:rows, 0:columns] * step
    points = np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], axis=1)
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    return points, np.stack([first, first + 1, first + columns + 1, first + columns], axis=1)


def _triangles(quads):
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def test_faces_under_the_field_are_covered_but_for_a_ring_at_its_rim():
    points, cells = _grid(21, 21, 1.0)
    vertices, quads = _grid(81, 81, 0.25)
    faces = _triangles(quads)
    covered = covered_faces(vertices, faces, points, cells)
    rim = np.minimum(vertices[faces], 20.0 - vertices[faces])[..., :2].min(axis=(1, 2))
    assert covered[rim > 1.5].all()
    assert not covered[rim < 1.0].any()


def test_around_what_is_lost_and_on_the_far_side_faces_stay():
    points, cells = _grid(21, 21, 1.0)
    lost = np.linalg.norm(points[cells].mean(axis=1) - [10.0, 10.0, 0.0], axis=1) < 1.0
    vertices, quads = _grid(81, 81, 0.25)
    faces = _triangles(quads)
    covered = covered_faces(vertices, faces, points, cells[~lost])
    near = np.linalg.norm(vertices[faces].mean(axis=1) - [10.0, 10.0, 0.0], axis=1)
    assert not covered[near < 2.0].any()
    assert covered[(near > 4.0) & (near < 8.0)].all()
    behind = vertices + np.array([0.0, 0.0, 1.5])
    assert not covered_faces(behind, faces, points, cells).any()


def test_a_sheared_and_drawn_grid_covers_nothing_beyond_itself():
    points, cells = _grid(21, 21, 1.0)
    drawn = points @ np.array([[3.0, 0, 0], [1.5, 0.6, 0], [0, 0, 1]])
    vertices, quads = _grid(161, 161, 0.5)
    faces = _triangles(quads)
    covered = covered_faces(vertices, faces, drawn, cells)
    back = vertices @ np.linalg.inv(np.array([[3.0, 0, 0], [1.5, 0.6, 0], [0, 0, 1]]))
    within = (back[:, :2] >= 0).all(axis=1) & (back[:, :2] <= 20).all(axis=1)
    assert covered.any()
    assert within[faces[covered]].all()


def test_a_strip_of_cells_covers_nothing():
    points, cells = _grid(2, 21, 1.0)
    assert not covered_faces(points, np.array([[0, 1, 22]]), points, cells).any()
