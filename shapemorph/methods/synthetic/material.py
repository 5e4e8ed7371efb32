"""Material maps: where each material point lies before and after, and what that strains."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from shapemorph.core.arrays import Bools, Floats

Embedding: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]
"""(N, 2) material coordinates -> (N, 3) positions and (N, 3, 2) their derivatives."""

Scalar: TypeAlias = Callable[[Floats], Floats]
"""(N, 2) material coordinates -> (N,) values."""


@dataclass(frozen=True, slots=True, eq=False)
class MaterialMap:
    """A piece of material and its two states, in closed form.

    Attributes
    ----------
    lower, upper : (2,) float64
        Box around the material coordinates, mm.
    period : float or None
        Length after which the first coordinate closes on itself, mm; None where it
        does not.
    reference, deformed : callable
        Embeddings, mm in the frame of the body.
    rim : callable
        Distance to the rim in the plane of the coordinates, mm, negative outside.
    loops : tuple of (K, 2) float64
        The rims as dense closed polygons of material coordinates, last point not
        repeated.
    locate : callable
        (N, 3) points near the reference surface -> (N, 2) coordinates of a start for
        :func:`nearest_material`; already the answer where `flat`.
    flat : bool
        Whether the reference is a plane, or rolls onto one: distances between
        coordinates are distances on it.
    kink : callable
        Distance to the nearest line where F jumps, mm; inf without one.
    kink_loops : tuple of (K, 2) float64
        Those lines, like `loops`.
    pole : (2,) float64
        Where the deformation is centred, mm.
    """

    lower: Floats
    upper: Floats
    period: float | None
    reference: Embedding
    deformed: Embedding
    rim: Scalar
    loops: tuple[Floats, ...]
    locate: Callable[[Floats], Floats]
    flat: bool
    kink: Scalar
    kink_loops: tuple[Floats, ...]
    pole: Floats

    def inside(self, material: Floats) -> Bools:
        """Whether coordinates (N, 2) belong to the specimen."""
        within: Bools = self.rim(material) >= 0
        return within


def no_kink(material: Floats) -> Floats:
    """Distance to the nearest kink of a smooth map: inf everywhere."""
    return np.full(len(material), np.inf)


def circle(radius: float, count: int = 4096) -> Floats:
    """Points (count, 2) around a circle about the origin, mm."""
    angle = np.arange(count) * (2 * np.pi / count)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def area_element(jacobian: Floats) -> Floats:
    """Area of surface per area of coordinates (N,), from derivatives (N, 3, 2)."""
    element: Floats = np.linalg.norm(np.cross(jacobian[..., 0], jacobian[..., 1]), axis=-1)
    return element


def principal_strains(material_map: MaterialMap, material: Floats) -> tuple[Floats, Floats]:
    """Green-Lagrange strains E1 >= E2 (N,) at material coordinates (N, 2).

    With A and B the derivatives of both embeddings, C = F^T F has the eigenvalues of
    (A^T A)^-1 (B^T B): trace and determinant of that product give them without a basis of
    the tangent plane.
    """
    _, before = material_map.reference(material)
    _, after = material_map.deformed(material)
    metric_before = before.swapaxes(-1, -2) @ before
    metric_after = after.swapaxes(-1, -2) @ after
    stretch = np.linalg.solve(metric_before, metric_after)
    mean = 0.5 * np.trace(stretch, axis1=-2, axis2=-1)
    half_gap = np.sqrt(np.maximum(mean**2 - np.linalg.det(stretch), 0.0))
    return 0.5 * (mean + half_gap - 1.0), 0.5 * (mean - half_gap - 1.0)


def nearest_material(material_map: MaterialMap, points: Floats) -> Floats:
    """Coordinates (N, 2) of the points of the reference surface nearest to (N, 3), mm, body frame.

    Newton's method on the squared distance, from the start that the map offers. The
    curvature term is left out (Gauss-Newton): near the surface that costs a few more steps,
    not accuracy.
    """
    material = material_map.locate(points)
    if material_map.flat:
        return material
    for _ in range(40):
        step = _gauss_newton_step(material_map.reference, material, points)
        material = material + step
        if np.abs(step).max(initial=0.0) < 1e-13 * np.ptp(material_map.upper):
            break
    return material


def _gauss_newton_step(embedding: Embedding, material: Floats, points: Floats) -> Floats:
    position, jacobian = embedding(material)
    transposed = jacobian.swapaxes(-1, -2)
    gap = transposed @ (points - position)[..., None]
    return np.asarray(np.linalg.solve(transposed @ jacobian, gap)[..., 0], dtype=np.float64)


def nearest_on_state(
    embedding: Embedding, start: Floats, points: Floats, *, steps: int, limit: Floats
) -> Floats:
    """Coordinates (N, 2) nearest to points (N, 3) on any state, for points very near the start.

    Where the search wanders farther than `limit` (N,) from the start, or does not come
    nearer, the start is kept: next to a kink the surface has no nearest point worth a name.
    """
    material = start.copy()
    for _ in range(steps):
        material = material + _gauss_newton_step(embedding, material, points)
    before = np.linalg.norm(embedding(start)[0] - points, axis=1)
    after = np.linalg.norm(embedding(material)[0] - points, axis=1)
    moved = np.linalg.norm(material - start, axis=1)
    sound = (moved < limit) & (after <= before)
    return np.where(sound[:, None], material, start)


def rim_distance(material_map: MaterialMap, material: Floats) -> Floats:
    """Distance (N,) to the nearest rim, mm of the reference, negative outside.

    Exact where the reference is flat or rolls flat; elsewhere the straight distance to the
    rim in space, a little under the distance along the surface.
    """
    level = material_map.rim(material)
    if material_map.flat:
        return level
    from scipy.spatial import cKDTree

    rim = np.concatenate([material_map.reference(loop)[0] for loop in material_map.loops])
    distance, _ = cKDTree(rim).query(material_map.reference(material)[0])
    signed: Floats = np.where(level >= 0, distance, -distance)
    return signed
