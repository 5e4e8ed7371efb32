"""The largest set of points that moved as one rigid body."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform
from shapemorph.kernels.rigid_cost import clipped_misfits
from shapemorph.methods.rigid import fit_rigid, fit_triples, residuals_of

_TIERS = (0.02, 0.05, 0.1, 0.2, 0.4, 1.0)  # shares of the points, stiffest first
_DRAWS = 120  # triples from each tier
_JUDGES = 2000  # points that judge a triple
_REFITS = 20
_CHI = 3.76  # 99.7 % of the lengths of a random vector with three components
_LOOSEST = 3.0  # times the expected noise that the noise of the set may turn out to be
_STRETCHED = 0.7  # an affine map that leaves less than this share has found a stretch


@dataclass(frozen=True, slots=True, eq=False)
class RigidSet:
    """Points that moved together.

    Attributes
    ----------
    transform : RigidTransform
        ``target_from_source``.
    members : (N,) bool
        Which of the offered points they are.
    """

    transform: RigidTransform
    members: Bools


def largest_rigid_set(
    source: Floats,
    target: Floats,
    softness: Floats,
    *,
    noise: float,
    smallest_share: float,
    seed: int,
) -> RigidSet | None:
    """Find the largest set of pairs that one rigid motion explains to within noise.

    Triples are drawn first among the points whose surroundings changed their lengths
    least: strain needs no alignment, so it says beforehand where to look.

    Parameters
    ----------
    source, target : (N, 3)
        Paired points, mm.
    softness : (N,)
        Size of the strain around each pair; NaN where unknown.
    noise : float
        Expected standard deviation of one component of target - source, mm.
    smallest_share : float
        Of the points; smaller sets say nothing.
    seed : int
        Of the draws.

    Returns
    -------
    RigidSet or None
        None if no set is large enough, or if what remains in it is a stretch and not
        noise (a small patch of any body looks rigid).
    """
    rng = np.random.default_rng(seed)
    start = _best_triple(source, target, _draws(softness, rng), _CHI * noise, rng)
    if start is None:
        return None
    found = _settled(source, target, start, noise)
    if found is None or found.members.mean() < smallest_share:
        return None
    if _is_stretched(source[found.members], target[found.members], found.transform):
        return None
    return found


def _draws(softness: Floats, rng: np.random.Generator) -> Ints:
    """Triples of different points from ever larger shares of the stiffest, (H, 3)."""
    stiffest = np.argsort(softness, kind="stable")
    triples = []
    for share in _TIERS:
        count = int(np.ceil(share * len(stiffest)))
        if count >= 3:
            picks = rng.integers(0, count, size=(_DRAWS, 3))
            triples.append(stiffest[picks])
    drawn = np.concatenate(triples) if triples else np.zeros((0, 3), dtype=np.int64)
    first, second, third = drawn.T
    different: Ints = drawn[(first != second) & (second != third) & (first != third)]
    return different


def _best_triple(
    source: Floats, target: Floats, triples: Ints, reach: float, rng: np.random.Generator
) -> RigidTransform | None:
    """Motion of the triple that leaves the least, every distance counting at most `reach`."""
    if len(triples) == 0:
        return None
    judges = rng.permutation(len(source))[:_JUDGES]
    rotations, translations = fit_triples(source[triples], target[triples])
    costs = clipped_misfits(source[judges], target[judges], rotations, translations, reach**2)
    best = int(np.argmin(costs))
    return RigidTransform(rotations[best], translations[best])


def _settled(
    source: Floats, target: Floats, start: RigidTransform, noise: float
) -> RigidSet | None:
    """Refit to the points within reach, whose own scatter sets the reach, until settled."""
    transform, members, scale = start, np.zeros(len(source), dtype=bool), noise
    for _ in range(_REFITS):
        distances = residuals_of(transform, source, target)
        now = distances <= _CHI * scale
        if now.sum() < 3 or np.array_equal(now, members):
            break
        members = now
        try:
            transform = fit_rigid(source[members], target[members], np.ones(members.sum()))
        except DataError:
            return None
        scatter = np.sqrt(
            np.mean(residuals_of(transform, source[members], target[members]) ** 2 / 3)
        )
        scale = float(np.clip(scatter, noise, _LOOSEST * noise))
    return RigidSet(transform, members) if members.any() else None


def _is_stretched(source: Floats, target: Floats, transform: RigidTransform) -> bool:
    """Whether an affine map explains what the rigid motion leaves."""
    centred = source - source.mean(axis=0)
    rest = target - transform.apply(source)
    affine, *_ = np.linalg.lstsq(centred, rest - rest.mean(axis=0), rcond=1e-3)
    left = rest - rest.mean(axis=0) - centred @ affine
    return bool((left**2).sum() < _STRETCHED**2 * (rest**2).sum())
