"""Follow the points of a first picture through the pictures after it."""

import logging
from dataclasses import dataclass

import numpy as np

from shapemorph.config import RunConfig
from shapemorph.core.errors import StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.laws import LawInputs
from shapemorph.core.matching import Warp
from shapemorph.core.status import PointStatus
from shapemorph.pipeline.picture_match import (
    ENOUGH,
    correlate_from,
    correlate_pictures,
    match_pictures,
    morph_by_law,
    picture_law_inputs,
    points_on,
)

CLEARLY = 1.02  # times the score: a later reference must be so much better
STRAINED = 95.0  # percentile of the points that the limit of strain is held against
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """What became of the points in one picture.

    Attributes
    ----------
    grid : CorrelationGrid
        First picture -> this one.
    reference : str
        Name of the picture that it was compared with.
    matched : bool
        Whether features had to be matched; otherwise the picture before gave the start.
    reason : str
        Why nothing was found; empty otherwise.
    """

    grid: CorrelationGrid
    reference: str
    matched: bool
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Drift:
    """Composed displacements of the last picture against those found in one step.

    Attributes
    ----------
    points : int
        With a value both ways.
    mean_u_px, mean_v_px, rms_px : float
        Composed - direct.
    """

    points: int
    mean_u_px: float
    mean_v_px: float
    rms_px: float


@dataclass(frozen=True, slots=True, eq=False)
class _Key:
    """A picture that others are compared with.

    Attributes
    ----------
    name : str
    picture : GreyImage
        Its mask is that of the first picture, moved along.
    since_first : CorrelationGrid or None
        First picture -> this one; None: it is the first.
    warp : Warp
        First picture -> this one.
    """

    name: str
    picture: GreyImage
    since_first: CorrelationGrid | None
    warp: Warp


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """A picture as seen from a key.

    Attributes
    ----------
    key : _Key
    increment : CorrelationGrid
        Key -> picture.
    total : CorrelationGrid
        First -> picture.
    matched : bool
    """

    key: _Key
    increment: CorrelationGrid
    total: CorrelationGrid
    matched: bool

    @property
    def score(self) -> float:
        """Share of points times their usual ZNCC."""
        zncc = self.total.zncc[self.total.status == PointStatus.OK]
        return float(np.median(zncc)) * zncc.size if zncc.size else 0.0


class Tracker:
    """Compares every picture with the first or a later reference, as configured.

    Parameters
    ----------
    name : str
        Of the first picture.
    first : GreyImage
        Its mask is what is measured.
    config : RunConfig
        With subset size and spacing settled.
    """

    def __init__(self, name: str, first: GreyImage, config: RunConfig) -> None:
        from shapemorph.methods.laws.identity import identity_warp

        self._config = config
        self._inputs: LawInputs = picture_law_inputs(config)
        self._first = _Key(name, first, None, identity_warp(first.shape))
        self._key = self._first
        self._last: _Key = self._first
        self._step: _Step | None = None
        self._drifts = False

    def follow(self, name: str, picture: GreyImage) -> Followed:
        """Find the points in the next picture.

        What is found is the start of the search in the picture after it; one in which
        nothing is found is passed over.

        Raises
        ------
        StageError
            If nothing was found.
        """
        mode = self._config.correlate.reference
        if mode == "previous":
            step = self._from(self._last, picture)
        else:
            step = self._from(self._key, picture)
            if mode == "auto" and self._key is not self._last and self._is_poor(step):
                step = self._better(step, picture)
        if step is None:
            raise StageError(
                f"{name}: expected the pattern of {self._key.name}, got none of its points"
            )
        self._key, self._step = step.key, step
        self._drifts |= step.key.since_first is not None
        self._last = self._as_key(name, picture, step.total)
        return Followed(step.total, step.key.name, step.matched)

    def nothing(self, reason: str) -> Followed:
        """Give the points of a picture in which none was found."""
        from shapemorph.methods.increments import lost_grid
        from shapemorph.methods.subset_choice import settled_sizes

        first, settings = self._first.picture, self._config.correlate
        size, spacing = settled_sizes(
            first, subset_size=settings.subset_size, spacing=settings.spacing
        )
        grid = lost_grid(
            first.mask,
            spacing=spacing,
            subset_size=size,
            status=PointStatus.NOT_SEEDED,
        )
        return Followed(grid, self._key.name, matched=True, reason=reason)

    def drift(self) -> Drift | None:
        """Compare the last picture with the first in one step; None if that adds nothing.

        Either all went straight from the first picture, or the last one cannot be matched
        with it any more.
        """
        if self._step is None or not self._drifts:
            return None
        direct = self._from(self._first, self._last.picture, self._last.warp)
        if direct is None:
            return None
        composed = self._step.total
        off = (composed.deformed_px - direct.total.deformed_px).reshape(-1, 2)
        off = off[np.isfinite(off).all(axis=1)]
        if len(off) == 0:
            return None
        u, v = off.mean(axis=0)
        return Drift(len(off), float(u), float(v), float(np.sqrt((off**2).mean())))

    def _is_poor(self, step: _Step | None) -> bool:
        if step is None or self._step is None:
            return True
        limits = self._config.correlate
        ok = step.increment.status == PointStatus.OK
        if np.median(step.increment.zncc[ok]) < limits.update_zncc:
            return True
        if step.total.ok_count < ENOUGH * self._step.total.ok_count:
            return True
        return _strain(step.increment) > limits.update_strain

    def _better(self, step: _Step | None, picture: GreyImage) -> _Step | None:
        """Take the step from the picture before, if it finds more."""
        other = self._from(self._last, picture)
        if step is None or other is None:
            return step or other
        return other if other.score > CLEARLY * step.score else step

    def _from(self, key: _Key, picture: GreyImage, start: Warp | None = None) -> _Step | None:
        """Follow the points of a key into a picture; None if none is found."""
        from shapemorph.methods.increments import compose_grids

        starts = [start] if start else self._starts(key)
        quick = correlate_from(key.picture, picture, starts, self._config)
        expected = self._expected(key)
        matched = quick is None or quick.ok_count < ENOUGH * expected
        found = self._matched(key, picture, quick) if matched else quick
        if found is None:
            return None
        total = found
        if key.since_first is not None:
            total = compose_grids(key.since_first, found, shown=picture.mask)
        return _Step(key, found, total, found is not quick) if total.ok_count else None

    def _starts(self, key: _Key) -> list[Warp]:
        """Warps from a key to the next picture: where the search may begin.

        Where the last picture lay; from the last picture itself also as it moved there.
        """
        from shapemorph.methods.increments import continued, warp_through
        from shapemorph.methods.laws.identity import identity_warp

        still, step = identity_warp(key.picture.shape), self._step
        if step is None:
            return [still]
        came = warp_through(step.increment, identity_warp(step.key.picture.shape))
        if step.key is key:
            return [came]
        if self._last is not key:
            return [still]
        return [still, continued(step.increment, came, key.picture.shape)]

    def _expected(self, key: _Key) -> int:
        """Points that a good start should find."""
        if self._step is not None and self._step.key is key:
            return self._step.increment.ok_count
        return points_on(key.picture, self._config.correlate.spacing or 1)

    def _matched(
        self, key: _Key, picture: GreyImage, quick: CorrelationGrid | None
    ) -> CorrelationGrid | None:
        """Match features, and keep what the start has found if that is more."""
        try:
            matches = match_pictures(key.picture, picture, LawInputs(), self._config)
            morphed = morph_by_law(key.picture, picture, matches, self._inputs, self._config)
            found = correlate_pictures(key.picture, picture, morphed, self._config)
        except StageError as error:
            log.info("no match of features: %s", error)
            return quick
        return found if quick is None or found.ok_count >= quick.ok_count else quick

    def _as_key(self, name: str, picture: GreyImage, total: CorrelationGrid) -> _Key:
        """Make a reference of a picture: the mask of the first one moves along."""
        from shapemorph.methods.carried_mask import limit_to_carried
        from shapemorph.methods.increments import warp_through

        first = self._first.picture
        warp = warp_through(total, self._first.warp)
        return _Key(name, limit_to_carried(picture, first, warp), total, warp)


def _strain(grid: CorrelationGrid) -> float:
    """Larger principal Green-Lagrange strain that few points exceed."""
    from shapemorph.methods.principal import principal

    gradient = grid.gradient[grid.status == PointStatus.OK]
    green = (np.swapaxes(gradient, -1, -2) @ gradient - np.eye(2)) / 2
    return float(np.percentile(principal(green)[0][:, 0], STRAINED))
