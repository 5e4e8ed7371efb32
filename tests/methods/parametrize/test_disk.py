import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.methods.parametrize.disk import boundary_loops, cut_piece, require_disk
from shapemorph.methods.parametrize.holes import fill_holes


def grid(rows, cols):
    number = np.arange(rows * cols).reshape(rows, cols)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    y, x = np.divmod(np.arange(rows * cols), cols)
    return np.stack([x, y, 0 * x], axis=1).astype(np.float64), faces


def torus(rows=12, cols=16):
    number = np.arange(rows * cols).reshape(rows, cols)
    right, down = np.roll(number, -1, axis=1), np.roll(number, -1, axis=0)
    both = np.roll(right, -1, axis=0)
    faces = np.concatenate(
        [np.stack([number, right, both], axis=-1), np.stack([number, both, down], axis=-1)]
    ).reshape(-1, 3)
    row, col = np.divmod(np.arange(rows * cols), cols)
    small, large = row * 2 * np.pi / rows, col * 2 * np.pi / cols
    wide = 3 + np.cos(small)
    points = np.stack([wide * np.cos(large), wide * np.sin(large), np.sin(small)], axis=1)
    return points, faces


TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def test_loops_run_along_their_faces():
    _, faces = grid(3, 4)
    (loop,) = boundary_loops(faces, name="sheet")
    assert len(loop) == 10
    directed = {(a, b) for face in faces for a, b in zip(face, np.roll(face, -1), strict=True)}
    assert all(edge in directed for edge in zip(loop, np.roll(loop, -1), strict=True))


def test_a_hole_is_a_loop_of_its_own_and_a_fan_closes_it():
    points, faces = grid(6, 7)
    holed = faces[~np.isin(np.arange(len(faces)), [14, 44])]
    loops = boundary_loops(holed, name="sheet")
    assert sorted(len(loop) for loop in loops)[-1] == 22
    require_disk(holed, loops, name="sheet")
    holes = [loop for loop in loops if len(loop) < 22]
    closed_points, closed = fill_holes(points, holed, holes)
    assert len(closed_points) == len(points) + len(holes)
    (rim,) = boundary_loops(closed, name="sheet")
    assert len(rim) == 22


def test_a_closed_surface_is_refused_with_advice():
    loops = boundary_loops(TETRAHEDRON, name="ball.obj")
    with pytest.raises(DataError, match=r"ball\.obj: expected a surface with a border.*open it"):
        require_disk(TETRAHEDRON, loops, name="ball.obj")


def test_a_handle_is_refused_with_advice():
    points, faces = torus()
    faces = faces[1:]
    piece = cut_piece(points, faces, name="ring.obj")
    loops = boundary_loops(piece.faces, name="ring.obj")
    with pytest.raises(DataError, match=r"ring\.obj: expected a disk with holes, got 1 handle"):
        require_disk(piece.faces, loops, name="ring.obj")


def test_pieces_that_meet_in_a_vertex_are_parted_and_the_larger_one_kept():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-3, 0, 0], [0, -3, 0]])
    faces = np.array([[0, 1, 2], [0, 3, 4]])
    piece = cut_piece(points, faces, name="bow tie")
    np.testing.assert_array_equal(piece.face_ids, [1])
    np.testing.assert_array_equal(piece.vertex_ids[piece.faces], faces[piece.face_ids])


def test_a_surface_that_touches_itself_in_a_vertex_gets_two_copies_of_it():
    points, faces = grid(5, 5)
    centre = points[faces].mean(axis=1)[:, :2]
    gone = (np.abs(centre - [1.5, 1.5]) < 0.5).all(axis=1)
    gone |= (np.abs(centre - [2.5, 2.5]) < 0.5).all(axis=1)
    piece = cut_piece(points, faces[~gone], name="sheet")
    assert np.bincount(piece.vertex_ids)[12] == 2
    assert len(piece.face_ids) == (~gone).sum()
    loops = boundary_loops(piece.faces, name="sheet")
    require_disk(piece.faces, loops, name="sheet")
    np.testing.assert_array_equal(piece.vertex_ids[piece.faces], faces[~gone])


def test_faces_that_disagree_about_the_outer_side_are_refused():
    points, faces = grid(3, 3)
    faces[0] = faces[0][::-1]
    with pytest.raises(DataError, match="opposite ways"):
        cut_piece(points, faces, name="sheet")


def test_three_faces_on_one_edge_are_refused():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
    faces = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    with pytest.raises(DataError, match="more than two faces"):
        cut_piece(points, faces, name="fin")


def test_an_annulus_is_a_disk_with_a_hole():
    points, faces = torus()
    tube = faces[np.isin(faces % 16, range(9)).all(axis=1)]  # half of the way round
    piece = cut_piece(points, tube, name="tube")
    loops = boundary_loops(piece.faces, name="tube")
    assert len(loops) == 2
    require_disk(piece.faces, loops, name="tube")
