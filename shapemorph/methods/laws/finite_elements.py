"""Laws from finite element results: where the model sends points of the reference surface.

A model knows neither where its axis meets the reference nor how the deformed shape lies in
its file. Both follow from pairs of matched points: the in-plane centre by least squares,
the pose of the deformed shape by the rigid motion that fits best.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.laws import NodalField, RadialProfile
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.rigid import fit_rigid

Motion: TypeAlias = Callable[[Floats], Floats]
"""(N, 3) positions on the reference surface, mm -> (N, 3) on or near the deformed surface, mm."""

SAMPLE = 600  # pairs that lay a model over the shapes
LEAST_PAIRS = 6
NODES = 12  # around a point that its displacement follows from
FLAT = 1e-3  # of the extent of these nodes: thinner, they say nothing across
STEADY = 3.0  # times the usual misfit at which a pair loses most of its weight
ROUNDS = 3


def place_profile(profile: RadialProfile, reference: Floats, deformed: Floats) -> Motion:
    """Lay a radial law over two shapes.

    The axis is the normal of the plane through the reference points; where it meets that
    plane is fitted, and which side is up.

    Parameters
    ----------
    profile : RadialProfile
    reference, deformed : (N, 3)
        Pairs of matched points, mm, each in the frame of its file.

    Raises
    ------
    StageError
        If there are too few pairs.
    """
    from scipy.optimize import least_squares

    reference, deformed = _sample(reference, deformed)
    middle = reference.mean(axis=0)
    axes = np.linalg.svd(reference - middle, full_matrices=False)[2]
    axes[2] = np.cross(axes[0], axes[1])
    flat = (reference - middle) @ axes.T
    size = float(np.abs(flat[:, :2]).max())
    best: tuple[float, Floats, float] | None = None
    for up in (1.0, -1.0):

        def misfit(centre: Floats, up: float = up) -> Floats:
            model = _revolved(profile, flat[:, :2] - centre, up)
            motion = _steady_motion(model, deformed)
            return (motion.apply(model) - deformed).ravel()

        found = least_squares(misfit, np.zeros(2), loss="soft_l1", x_scale=0.1 * size)
        if best is None or found.cost < best[0]:
            best = (float(found.cost), np.asarray(found.x), up)
    assert best is not None
    _cost, centre, up = best
    motion = _steady_motion(_revolved(profile, flat[:, :2] - centre, up), deformed)

    def move(points: Floats) -> Floats:
        plane = (points - middle) @ axes.T
        return motion.apply(_revolved(profile, plane[:, :2] - centre, up))

    return move


def place_field(field: NodalField, reference: Floats, deformed: Floats) -> Motion:
    """Lay a displacement field without symmetry over the deformed shape.

    Parameters
    ----------
    field : NodalField
        In the frame of the reference file.
    reference, deformed : (N, 3)
        Pairs of matched points, mm, each in the frame of its file; with fewer than three,
        both files are taken to have one frame.
    """
    interpolate = interpolated(field)
    motion = RigidTransform.identity()
    if len(reference) >= LEAST_PAIRS:
        reference, deformed = _sample(reference, deformed)
        motion = _steady_motion(reference + interpolate(reference), deformed)

    def move(points: Floats) -> Floats:
        return motion.apply(points + interpolate(points))

    return move


def interpolated(field: NodalField) -> Motion:
    """Displacement (N, 3) at points (N, 3): an affine surface through the nearest nodes.

    Nodes of a shell or of one side of a solid lie in a surface; across it the field is
    taken as constant.
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(field.nodes)
    count = min(NODES, len(field.nodes))

    def displacement(points: Floats) -> Floats:
        distance, index = (
            np.asarray(part).reshape(len(points), -1) for part in tree.query(points, count)
        )
        reach = np.maximum(distance[:, -1:], 1e-300)
        root = np.sqrt(np.exp(-((2.0 * distance / reach) ** 2)))[..., None]
        offset = (field.nodes[index] - points[:, None]) / reach[..., None]
        design = np.concatenate([np.ones((*index.shape, 1)), offset], axis=-1) * root
        solved = np.linalg.pinv(design, rcond=FLAT) @ (field.displacement[index] * root)
        moved: Floats = solved[:, 0]
        return moved

    return displacement


@dataclass(frozen=True, slots=True, eq=False)
class _Curve:
    """A profile as two curves of the material radius, straight beyond its ends."""

    profile: RadialProfile

    def at(self, radius: Floats) -> tuple[Floats, Floats]:
        """(N,) radius and height after."""
        from scipy.interpolate import PchipInterpolator

        material = self.profile.material
        inner = np.clip(radius, material[0], material[-1])
        after = []
        for values in (self.profile.radius, self.profile.height):
            curve = PchipInterpolator(material, values)
            after.append(curve(inner) + curve.derivative()(inner) * (radius - inner))
        return after[0], after[1]


def _revolved(profile: RadialProfile, plane: Floats, up: float) -> Floats:
    """(N, 3) positions after, about the axis, of points (N, 2) of the plane about the centre."""
    radius = np.hypot(plane[:, 0], plane[:, 1])
    after, height = _Curve(profile).at(radius)
    direction = plane / np.maximum(radius, 1e-12)[:, None]
    return np.column_stack([after[:, None] * direction, up * height])


def _steady_motion(model: Floats, target: Floats) -> RigidTransform:
    """Rigid motion of the model onto the target; parts that do not fit count less."""
    weights = np.ones(len(model))
    for _ in range(ROUNDS):
        motion = fit_rigid(model, target, weights)
        misfit = np.linalg.norm(motion.apply(model) - target, axis=1)
        limit = STEADY * max(float(np.median(misfit)), 1e-12)
        weights = 1.0 / (1.0 + (misfit / limit) ** 2)
    return motion


def _sample(reference: Floats, deformed: Floats) -> tuple[Floats, Floats]:
    good = np.flatnonzero(np.isfinite(reference).all(axis=1) & np.isfinite(deformed).all(axis=1))
    if len(good) < LEAST_PAIRS:
        raise StageError(
            f"a finite element law needs at least {LEAST_PAIRS} matches to be laid over the "
            f"shapes, got {len(good)}"
        )
    chosen = good[np.linspace(0, len(good) - 1, min(SAMPLE, len(good))).astype(int)]
    return reference[chosen], deformed[chosen]
