"""A round sheet of triangles."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints


def disc_mesh(radius: float, rings: int) -> tuple[Floats, Ints]:
    """Triangulate a disc by rings of 6, 12, 18, ... nodes around its centre.

    Parameters
    ----------
    radius : float
        mm.
    rings : int

    Returns
    -------
    points : (N, 2) float64
        The last 6 * rings of them lie on the rim.
    faces : (6 rings^2, 3) int64
        Counter-clockwise.
    """
    points, starts = [np.zeros((1, 2))], [0]
    for ring in range(1, rings + 1):
        angle = np.arange(6 * ring) * (2 * np.pi / (6 * ring))
        points.append(radius * ring / rings * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        starts.append(starts[-1] + max(1, 6 * (ring - 1)))
    faces = [_between_rings(ring, starts[ring - 1], starts[ring]) for ring in range(1, rings + 1)]
    return np.concatenate(points), np.concatenate(faces)


def _between_rings(ring: int, inner: int, outer: int) -> Ints:
    """Triangles between a ring and the one inside it, sixth by sixth."""
    faces = []
    many, few = 6 * ring, max(1, 6 * (ring - 1))
    for sixth in range(6):
        for k in range(ring):
            low = inner + (sixth * (ring - 1) + k) % few
            near, far = outer + sixth * ring + k, outer + (sixth * ring + k + 1) % many
            faces.append((low, near, far))
            if k < ring - 1:
                faces.append((low, far, inner + (sixth * (ring - 1) + k + 1) % few))
    return np.array(faces, dtype=np.int64)
