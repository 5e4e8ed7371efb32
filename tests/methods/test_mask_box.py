import numpy as np

from shapemorph.methods.mask_box import ROOM, tight_map

SHEAR = np.array([[1.2, 0.7], [-0.1, 0.5]])


def oblique_strip():
    rows, cols = np.mgrid[:300, :420]
    return np.abs(rows - 0.6 * cols - 20) < 12


def test_mask_lies_inside_the_picture_with_room():
    mask = oblique_strip()
    matrix, (height, width) = tight_map(SHEAR, mask)
    rows, cols = np.nonzero(mask)
    x, y = matrix[:, :2] @ [cols, rows] + matrix[:, 2:]
    assert min(x.min(), y.min()) >= ROOM - 1e-9
    assert x.max() <= width - 1
    assert y.max() <= height - 1


def test_oblique_strip_is_turned_and_its_picture_small():
    mask = oblique_strip()
    matrix, (height, width) = tight_map(np.eye(2), mask)
    assert height * width < 3 * mask.sum()
    np.testing.assert_allclose(matrix[:, :2] @ matrix[:, :2].T, np.eye(2), atol=1e-12)
    assert np.linalg.det(matrix[:, :2]) > 0


def test_upright_picture_stays_as_it_is():
    mask = np.zeros((50, 90), bool)
    mask[10:40, 5:80] = True
    matrix, shape = tight_map(np.eye(2), mask)
    np.testing.assert_array_equal(matrix[:, :2], np.eye(2))
    assert shape == (30 + 2 * ROOM, 75 + 2 * ROOM)
