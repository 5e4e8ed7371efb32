"""Stage `spread`: how far results of several laws, flattenings, subsets lie apart."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.laws import LawSpread, Variant
from shapemorph.core.matching import Warp
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import StrainField, TrackedSurface
from shapemorph.methods.variant_differences import carried_over
from shapemorph.methods.warping import warp_points

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class LawResult:
    """What one law says and what was measured with it.

    Attributes
    ----------
    law : str
    warp : Warp
        Of the law by itself, reference -> deformed, px.
    grid : CorrelationGrid
    tracked : TrackedSurface
    """

    law: str
    warp: Warp
    grid: CorrelationGrid
    tracked: TrackedSurface


@dataclass(frozen=True, slots=True, eq=False)
class FullResult:
    """A measurement with its strain.

    Attributes
    ----------
    tracked : TrackedSurface
    field : StrainField
    """

    tracked: TrackedSurface
    field: StrainField


def spread(results: Sequence[LawResult], failures: dict[str, str]) -> LawSpread:
    """Compare the deformed positions that further laws lead to with those of the main law.

    Parameters
    ----------
    results : sequence of LawResult
        The main law first; on one grid. Empty or one: nothing to compare.
    failures : dict of str to str
        Laws that led to nothing, and why.
    """
    if len(results) + len(failures) < 2:
        nothing = np.zeros(0)
        return LawSpread((), (), nothing, np.zeros(0, np.int64), nothing, nothing, {})
    main = results[0].tracked
    apart = [_distances(main, each.tracked) for each in results]
    found = LawSpread(
        laws=tuple(each.law for each in results),
        warps=tuple(each.warp for each in results),
        off_px=np.array([_off(each) for each in results]),
        compared=np.array([len(distance) for distance in apart], np.int64),
        rms=np.array([_rms(distance) for distance in apart]),
        p95=np.array([_percentile(distance, 95.0) for distance in apart]),
        failures=dict(failures),
    )
    for law, rms in zip(found.laws[1:], found.rms[1:], strict=True):
        log.info("law %s: %.2g mm rms from law %s", law, rms, found.laws[0])
    return found


def differ(name: str, main: FullResult, other: FullResult) -> Variant:
    """Compare a measurement of the same pair on any grid with the main one.

    Parameters
    ----------
    name : str
        What was changed.
    main, other : FullResult
        The points of `main` are judged. Both are fitted about them in the same way: what a fit
        misses of the surface and of its noise is common to both and no difference.
    """
    ok = [np.isfinite(each.field.e1) & (each.tracked.status == PointStatus.OK)
          for each in (main, other)]  # fmt: skip
    places = main.tracked.reference[ok[0]], main.tracked.reference_normal[ok[0]]
    fits = [
        carried_over(*places, each.tracked.reference[good], _columns(each)[good])
        for each, good in zip((main, other), ok, strict=True)
    ]
    off = fits[1] - fits[0]
    off = off[np.isfinite(off).all(axis=1)]
    distance = np.linalg.norm(off[:, :3], axis=1)
    variant = Variant(
        name,
        len(off),
        _rms(distance),
        _percentile(distance, 95.0),
        _rms(off[:, 3]),
        _rms(off[:, 4]),
    )
    log.info("%s: %.2g mm rms from the main result", name, variant.rms)
    return variant


def _columns(result: FullResult) -> Floats:
    """Deformed position, E1 and E2, (R, C, 5)."""
    strains = np.stack([result.field.e1, result.field.e2], axis=-1)
    return np.concatenate([result.tracked.deformed, strains], axis=-1)


def _distances(main: TrackedSurface, other: TrackedSurface) -> Floats:
    """(K,) distance of positions of points that both have, mm."""
    both = (main.status == PointStatus.OK) & (other.status == PointStatus.OK)
    distance: Floats = np.linalg.norm(other.deformed[both] - main.deformed[both], axis=-1)
    return distance


def _off(result: LawResult) -> float:
    """Median distance between what a law says and what was found, px."""
    ok = result.grid.status == PointStatus.OK
    said, _gradient = warp_points(result.warp, result.grid.reference_px[ok])
    off = np.linalg.norm(said - result.grid.deformed_px[ok], axis=-1)
    return _percentile(off[np.isfinite(off)], 50.0)


def _rms(values: Floats) -> float:
    return float(np.sqrt((values**2).mean())) if len(values) else float("nan")


def _percentile(values: Floats, share: float) -> float:
    return float(np.percentile(values, share)) if len(values) else float("nan")
