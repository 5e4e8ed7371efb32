"""First values of a camera without iterations: homographies, Zhang's method, DLT."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform

_LEAST = {"homography": 4, "dlt": 6}
_FLAT = 1e-3  # third over first spread of points below which DLT is not settled


def fit_homography(plane: Floats, pixels: Floats) -> Floats:
    """Find H (3, 3) with pixel ~ H (x, y, 1), least squares, points normalised.

    Parameters
    ----------
    plane : (N, 2)
        Points of the plane z = 0, mm.
    pixels : (N, 2)

    Raises
    ------
    DataError
        With fewer than 4 points.

    References
    ----------
    .. [1] Hartley, R.; Zisserman, A. Multiple View Geometry, 2nd ed. (2004), alg. 4.2.
    """
    return _projective(plane, pixels, "homography")


def fit_projection(points: Floats, pixels: Floats) -> Floats:
    """Find P (3, 4) with pixel ~ P (X, Y, Z, 1): the direct linear transform.

    Raises
    ------
    DataError
        With fewer than 6 points, or with points in one plane.
    """
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if len(points) >= _LEAST["dlt"] and spread[2] < _FLAT * spread[0]:
        raise DataError("expected points in space for a direct linear transform, got a plane")
    return _projective(points, pixels, "dlt")


def _projective(source: Floats, pixels: Floats, kind: str) -> Floats:
    if len(source) < _LEAST[kind]:
        raise DataError(f"expected at least {_LEAST[kind]} points, got {len(source)}")
    left, right = _normaliser(source), _normaliser(pixels)
    from_, to = _lifted(source) @ left.T, _lifted(pixels) @ right.T
    zero = np.zeros_like(from_)
    rows = np.concatenate(
        [
            np.concatenate([from_, zero, -to[:, :1] * from_], axis=1),
            np.concatenate([zero, from_, -to[:, 1:2] * from_], axis=1),
        ]
    )
    solution = np.linalg.svd(rows.T @ rows)[2][-1].reshape(3, -1)
    found: Floats = np.linalg.inv(right) @ solution @ left
    return found


def _lifted(points: Floats) -> Floats:
    return np.concatenate([points, np.ones((len(points), 1))], axis=1)


def _normaliser(points: Floats) -> Floats:
    """Matrix that centres points and scales them to a spread of sqrt(dimensions)."""
    size = points.shape[1]
    centre = points.mean(axis=0)
    scale = np.sqrt(size) / max(float(np.linalg.norm(points - centre, axis=1).mean()), 1e-12)
    matrix = np.eye(size + 1)
    matrix[:size, :size] *= scale
    matrix[:size, size] = -scale * centre
    return matrix


def zhang_matrix(homographies: list[Floats], size: tuple[int, int]) -> Floats:
    """Find K (3, 3) without skew from pictures of a plane.

    With three or more pictures the principal point is found too; with fewer, or where
    they do not settle it, it is taken to be the middle of the picture and the pixels square.

    Parameters
    ----------
    homographies : list of (3, 3)
    size : (int, int)
        Width and height of the pictures, px.

    References
    ----------
    .. [1] Zhang, Z. (2000). IEEE TPAMI 22, 1330-1334. :doi:`10.1109/34.888718`
    """
    if len(homographies) >= 3:
        matrix = _with_principal_point(homographies, size)
        if matrix is not None:
            return matrix
    return _with_middle(homographies, size)


def _with_principal_point(homographies: list[Floats], size: tuple[int, int]) -> Floats | None:
    width, height = size
    scale = np.array([[2.0 / width, 0, -1], [0, 2.0 / width, -height / width], [0, 0, 1]])
    rows = []
    for homography in homographies:
        one, two = _unit_columns(scale @ homography)
        rows.append(_conic_row(one, two))
        rows.append(_conic_row(one, one) - _conic_row(two, two))
    b11, b22, b13, b23, b33 = np.linalg.svd(np.array(rows))[2][-1]
    cx, cy = -b13 / b11, -b23 / b22
    rest = b33 - b13**2 / b11 - b23**2 / b22
    if not (rest / b11 > 0 and rest / b22 > 0):
        return None
    ideal = np.array([[np.sqrt(rest / b11), 0, cx], [0, np.sqrt(rest / b22), cy], [0, 0, 1]])
    matrix: Floats = np.linalg.inv(scale) @ ideal
    square = 0.5 < matrix[0, 0] / matrix[1, 1] < 2.0
    inside = 0 < matrix[0, 2] < width and 0 < matrix[1, 2] < height
    return matrix if square and inside else None


def _unit_columns(homography: Floats) -> tuple[Floats, Floats]:
    scaled = homography / np.linalg.norm(homography[:, 0])
    return scaled[:, 0], scaled[:, 1]


def _conic_row(one: Floats, two: Floats) -> Floats:
    return np.array(
        [
            one[0] * two[0],
            one[1] * two[1],
            one[2] * two[0] + one[0] * two[2],
            one[2] * two[1] + one[1] * two[2],
            one[2] * two[2],
        ]
    )


def _with_middle(homographies: list[Floats], size: tuple[int, int]) -> Floats:
    """K of square pixels about the middle, from the median over all pictures."""
    middle = (np.array(size) - 1) / 2
    shift = np.array([[1.0, 0, -middle[0]], [0, 1, -middle[1]], [0, 0, 1]])
    numerators, denominators = [], []
    for homography in homographies:
        one, two = _unit_columns(shift @ homography)
        numerators += [-(one[:2] @ two[:2]), -(one[:2] @ one[:2] - two[:2] @ two[:2])]
        denominators += [one[2] * two[2], one[2] ** 2 - two[2] ** 2]
    above, below = np.array(numerators), np.array(denominators)
    square = (above @ below) / max(below @ below, 1e-300)
    focal = np.sqrt(square) if square > 0 else 1.2 * max(size)
    focal = float(np.clip(focal, 0.3 * max(size), 50 * max(size)))
    return np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])


def pose_of_plane(homography: Floats, matrix: Floats) -> RigidTransform:
    """Find camera_from_plane, in front of the camera, from H = K (r1, r2, t)."""
    columns = np.linalg.inv(matrix) @ homography
    columns /= np.sqrt(np.linalg.norm(columns[:, 0]) * np.linalg.norm(columns[:, 1]))
    if columns[2, 2] < 0:
        columns = -columns
    first, second, shift = columns.T
    return RigidTransform(
        _nearest_rotation(np.stack([first, second, np.cross(first, second)], axis=1)), shift
    )


def decompose_projection(projection: Floats) -> tuple[Floats, RigidTransform]:
    """Split P (3, 4) into K (3, 3) and camera_from_world."""
    from scipy.linalg import rq

    matrix, rotation = rq(projection[:, :3])
    signs = np.diag(np.sign(np.diag(matrix)))
    matrix, rotation = matrix @ signs, signs @ rotation
    shift = np.linalg.solve(matrix, projection[:, 3])
    if np.linalg.det(rotation) < 0:
        rotation, shift = -rotation, -shift
    return matrix / matrix[2, 2], RigidTransform(
        _nearest_rotation(np.asarray(rotation, float)), shift
    )


def pose_of_points(points: Floats, flat: Floats) -> RigidTransform:
    """Find camera_from_points of points in space seen in known directions.

    Parameters
    ----------
    points : (N, 3)
        At least 6, not in one plane, mm.
    flat : (N, 2)
        Directions (x, y) with z = 1 in which they are seen.
    """
    projection = fit_projection(points, flat)
    if np.linalg.det(projection[:, :3]) < 0:
        projection = -projection
    left, scales, right = np.linalg.svd(projection[:, :3])
    return RigidTransform(left @ right, projection[:, 3] / scales.mean())


def _nearest_rotation(matrix: Floats) -> Floats:
    left, _, right = np.linalg.svd(matrix)
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    rotation: Floats = left @ right
    return rotation
