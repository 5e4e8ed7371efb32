"""Where cameras stand to each other, from targets that two of them saw at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.calibration import Sighting, View
from shapemorph.core.camera import Camera
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.cameras.one_camera import place_target

_ALIKE = 0.03  # radians, or of the distance: poses of one pair of cameras that agree
_CLEARLY = 5.0  # times the median disagreement
_HALF = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class _Vote:
    """What one view says about a pair of cameras, for one numbering of its points."""

    view: int
    numbering: int
    second_from_first: RigidTransform
    distance: float


@dataclass(frozen=True, slots=True, eq=False)
class Tied:
    """Two cameras tied by common views.

    Attributes
    ----------
    second_from_first : RigidTransform
    renumbered : dict of int to Sighting
        Sightings of the second camera whose points had to be numbered otherwise, by view.
    contradicting : tuple of int
        Views that say something else.
    """

    second_from_first: RigidTransform
    renumbered: dict[int, Sighting]
    contradicting: tuple[int, ...]


def compose(outer: RigidTransform, inner: RigidTransform) -> RigidTransform:
    """Return the motion that does `inner`, then `outer`."""
    return RigidTransform(outer.rotation @ inner.rotation, outer.apply(inner.translation))


def tie(
    first: Sequence[Sighting],
    second: Sequence[Sighting],
    cameras: tuple[Camera, Camera],
    views: Sequence[View],
) -> Tied:
    """Find where the second camera stands by the views that both saw.

    Parameters
    ----------
    first, second : sequence of Sighting
        Of the two cameras; those of common views are used.
    cameras : (Camera, Camera)
        Each calibrated by itself.
    views : sequence of View

    Raises
    ------
    DataError
        If there is no common view, or more than half of them contradict each other.
    """
    partners = {seen.view: seen for seen in second}
    common = [seen for seen in first if seen.view in partners]
    if not common:
        raise DataError("no view is common")
    votes = [
        vote
        for seen in common
        for vote in _votes(seen, partners[seen.view], cameras, views[seen.view])
    ]
    gaps = np.array([[_disagreement(one, other) for other in votes] for one in votes])
    owners = np.array([vote.view for vote in votes])
    nearest = np.stack([gaps[:, owners == view].min(axis=1) for view in _order(owners)], axis=1)
    best = int(np.argmin(np.median(nearest, axis=1)))
    agreement = nearest[best]
    limit = max(_ALIKE, _CLEARLY * float(np.median(agreement)))
    agrees = agreement <= min(limit, 3 * _ALIKE)
    if agrees.sum() <= _HALF * len(common) and len(common) > 1:
        raise DataError(
            f"views contradict each other: of {len(common)} that both cameras saw, {agrees.sum()} "
            "agree on where the cameras stand: pictures of one view must show the target in one "
            "place (same moment, same order), or set `simultaneous: false`"
        )
    chosen = _chosen(votes, owners, gaps[best])
    renumbered = {
        view: _renumber(partners[view], views[view].target.symmetries[vote.numbering - 1])
        for view, vote in chosen.items()
        if vote.numbering
    }
    against = tuple(int(view) for view, ok in zip(_order(owners), agrees, strict=True) if not ok)
    return Tied(votes[best].second_from_first, renumbered, against)


def _order(owners: Ints) -> list[int]:
    return list(dict.fromkeys(owners.tolist()))


def _votes(
    one: Sighting, other: Sighting, cameras: tuple[Camera, Camera], view: View
) -> list[_Vote]:
    here = place_target(cameras[0], one, view)
    votes = []
    for number, symmetry in enumerate([None, *view.target.symmetries]):
        seen = other if symmetry is None else _renumber(other, symmetry)
        there = place_target(cameras[1], seen, view)
        distance = float(np.linalg.norm(there.translation))
        votes.append(_Vote(one.view, number, compose(there, here.inverse()), distance))
    return votes


def _renumber(seen: Sighting, symmetry: Ints) -> Sighting:
    return Sighting(seen.camera, seen.view, symmetry[seen.ids], seen.pixels)


def _disagreement(one: _Vote, other: _Vote) -> float:
    """Angle in radians, or shift as a share of the distance, whichever is more."""
    turn = other.second_from_first.rotation @ one.second_from_first.rotation.T
    angle = float(Rotation.from_matrix(turn).magnitude())
    shift = other.second_from_first.translation - one.second_from_first.translation
    return max(angle, float(np.linalg.norm(shift)) / max(one.distance, 1e-300))


def _chosen(votes: Sequence[_Vote], owners: Ints, gaps: Floats) -> dict[int, _Vote]:
    chosen = {}
    for view in _order(owners):
        mine: Bools = owners == view
        numbers = np.flatnonzero(mine)
        chosen[view] = votes[int(numbers[np.argmin(gaps[numbers])])]
    return chosen
