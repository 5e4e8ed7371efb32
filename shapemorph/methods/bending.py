"""What bending adds to a gradient that was fitted by quadratics."""

import numpy as np

from shapemorph.core.arrays import Floats


def bending_cubics(reference_bend: Floats, gradient: Floats, deformed_bend: Floats) -> Floats:
    """Find the cubics that bending alone puts into a deformed position.

    A sheet that bends without any change of strain follows an arc, and the projection of
    an arc on its tangent is shortened by a cubic: a quadratic fit takes that for a smaller
    stretch, by about 0.6 (spacing / radius)^2 for five points. The cubic follows from the
    curvatures that the quadratic did find, if the metric of the deformed surface is
    asked to vary no more than that of the reference does.

    Parameters
    ----------
    reference_bend, deformed_bend : (N, 2, 2)
        Second derivatives of both states along their normals, by orthonormal coordinates
        of the reference tangent plane, 1/mm.
    gradient : (N, 2, 3)
        First derivatives of the deformed position by the same coordinates.

    Returns
    -------
    (N, 2, 4)
        Coefficients of x^3, x^2 y, x y^2, y^3 along the two rows of `gradient`, 1/mm^2. Zero
        for a rigid motion, for a uniform scaling, and for any map of a plane into a plane.

    Notes
    -----
    With the deformed metric g = x_,i . x_,j, its second derivatives hold the third
    derivatives D_jikl = x_,j . x_,ikl:  g_ij,kl = D_jikl + D_ijkl + b_ik b_jl + b_il b_jk
    (b: bend of the deformed surface). They are set to those of the reference surface
    stretched by U = sqrt(C): H_ik H_jl + H_il H_jk with H = U h (h: bend of the
    reference). The system has nine equations for eight unknowns (a metric cannot be
    chosen free of the Gaussian curvature) and is solved by least squares.
    """
    metric = gradient @ np.swapaxes(gradient, 1, 2)
    wanted = _pairs(_root(metric) @ reference_bend) - _pairs(deformed_bend)
    third = wanted.reshape(len(wanted), 16) @ _SOLVE.T
    along = np.linalg.solve(invertible(metric), third.reshape(-1, 2, 4))
    cubics: Floats = along * _MULTIPLICITY / 6
    return cubics


def bending_terms(cubics: Floats, gradient: Floats, slopes: Floats) -> Floats:
    """Find how much of a fitted deformation gradient is due to such cubics.

    Parameters
    ----------
    cubics : (N, 2, 4)
        From :func:`bending_cubics`.
    gradient : (N, 2, 3)
        First derivatives of the deformed position.
    slopes : (N, 2, 4)
        Gradient that the same fit gives to x^3, x^2 y, x y^2, y^3.

    Returns
    -------
    (N, 2, 3)
        To be subtracted from `gradient`.
    """
    shortfall: Floats = slopes @ np.swapaxes(cubics, 1, 2) @ gradient
    return shortfall


def normal_bend(terms: Floats) -> Floats:
    """Second derivatives along the normal of a fitted surface.

    Parameters
    ----------
    terms : (N, 6, 3)
        Coefficients of 1, x, y, x^2, xy, y^2 of the positions.

    Returns
    -------
    (N, 2, 2)
        NaN where the surface has no normal.
    """
    normal = np.cross(terms[:, 1], terms[:, 2])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal / np.where(length > 0, length, np.nan)
    xx, xy, yy = (np.sum(terms[:, k] * normal, axis=1) for k in (3, 4, 5))
    return np.stack([2 * xx, xy, xy, 2 * yy], axis=1).reshape(-1, 2, 2)


def _root(metric: Floats) -> Floats:
    """Square root of symmetric positive 2 x 2 matrices."""
    root = np.sqrt(_determinant(metric))
    trace = metric[:, 0, 0] + metric[:, 1, 1]
    scale = np.sqrt(trace + 2 * root)[:, None, None]
    result: Floats = (metric + root[:, None, None] * np.eye(2)) / scale
    return result


def invertible(metric: Floats) -> Floats:
    """Put the identity for 2 x 2 matrices of failed fits, so that all can be solved at once."""
    sound = _determinant(metric) > 0
    return np.where(sound[:, None, None], metric, np.eye(2))


def _determinant(metric: Floats) -> Floats:
    """Multiply out the determinant of 2 x 2 matrices, NaN where they are."""
    determinant: Floats = metric[:, 0, 0] * metric[:, 1, 1] - metric[:, 0, 1] * metric[:, 1, 0]
    return determinant


def _pairs(curvature: Floats) -> Floats:
    """Form b_ik b_jl + b_il b_jk, (N, i, j, k, l)."""
    first = np.einsum("nik,njl->nijkl", curvature, curvature)
    pairs: Floats = first + np.swapaxes(first, 3, 4)
    return pairs


def _solution() -> Floats:
    """Least-squares solution of D_j,ikl + D_i,jkl = given; D is symmetric in its last three."""
    system = np.zeros((2, 2, 2, 2, 2, 4))
    for i, j, k, m in np.ndindex(2, 2, 2, 2):
        system[i, j, k, m, j, i + k + m] += 1
        system[i, j, k, m, i, j + k + m] += 1
    return np.asarray(np.linalg.pinv(system.reshape(16, 8)), dtype=np.float64)


_SOLVE = _solution()
_MULTIPLICITY = np.array([1.0, 3.0, 3.0, 1.0])
