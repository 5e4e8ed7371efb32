"""Stage `spread`: how far results of several morph laws lie apart."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.laws import LawSpread
from shapemorph.core.matching import Warp
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import TrackedSurface
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
