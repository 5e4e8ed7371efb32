"""Least-squares conformal map by libigl.

References
----------
B. Levy et al., Least squares conformal maps, ACM Trans. Graph. 21 (2002),
doi 10.1145/566654.566590.
"""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.methods.parametrize.disk import boundary_loops
from shapemorph.methods.parametrize.holes import order_by_length


def parametrise_lscm(vertices: Floats, faces: Ints) -> Floats:
    """Flatten a surface with a border conformally, two far points of its rim pinned.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
        One piece with at least one boundary loop; holes stay free.

    Returns
    -------
    (V, 2)
        In the unit of the vertices, x right, y up, faces counter-clockwise.

    Raises
    ------
    StageError
        If libigl finds no solution.
    """
    import igl

    rim = order_by_length(vertices, boundary_loops(faces, name="the surface"))[0]
    pins = _far_pair(vertices, rim)
    distance = float(np.linalg.norm(vertices[pins[1]] - vertices[pins[0]]))
    try:
        placed, _ = igl.lscm(vertices, faces, pins, np.array([[0.0, 0.0], [distance, 0.0]]))
    except RuntimeError as error:
        raise StageError(f"least-squares conformal map: libigl says {error}") from error
    if not np.isfinite(placed).all():
        raise StageError("least-squares conformal map: no finite solution")
    result: Floats = np.ascontiguousarray(placed)
    return result


def _far_pair(vertices: Floats, rim: Ints) -> Ints:
    """Two vertices of the rim that lie far apart."""
    points = vertices[rim]
    first = np.linalg.norm(points - points.mean(axis=0), axis=1).argmax()
    second = np.linalg.norm(points - points[first], axis=1).argmax()
    pair: Ints = rim[np.array([first, second])]
    return pair
