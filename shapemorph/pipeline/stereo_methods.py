"""The methods that follow a grid through a stereo sequence; all end in one grid."""

from collections.abc import Iterator
from functools import partial

from shapemorph.config import RunConfig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.stereo_track import StereoGrids
from shapemorph.methods.threads import run_at_once
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.image_morphing import bridge_pictures
from shapemorph.pipeline.stereo_inputs import SIDES, StereoSequence
from shapemorph.pipeline.tracking import Tracker
from shapemorph.stages.reconstruct import refuse_contradiction


def follow_incrementally(
    sequence: StereoSequence, config: RunConfig, clock: Clock
) -> Iterator[tuple[int, StereoGrids]]:
    """Follow the grid of the first left picture with a reference that is updated.

    The path leads from the last left picture back to the first, across to the first right
    one, and on to the last right one. The grid lies on the first left picture, in the middle
    of that path, and is carried outwards both ways at once: every pair of neighbours is matched
    once, and half as many increments lie between the grid and any picture as from end to end.

    Parameters
    ----------
    sequence : StereoSequence
    config : RunConfig
        With subset size and spacing settled.
    clock : Clock

    Yields
    ------
    int
        State, from 1.
    StereoGrids

    Raises
    ------
    DataError
        If the rig contradicts the first pair of pictures.
    StageError
        If a picture shows nothing of the one before.
    """
    correlate = config.correlate.model_copy(update={"reference": "previous"})
    config = config.model_copy(update={"correlate": correlate})
    first = sequence.first()
    trackers = {side: Tracker(sequence.left[0].name, first, config) for side in SIDES}

    def step(side: str, state: int) -> CorrelationGrid:
        frame = (sequence.left if side == "left" else sequence.right)[state]
        picture = sequence.picture(side, state)
        return trackers[side].follow(f"{side} {frame.name}", picture).grid

    across = clock.run("across", lambda: step("right", 0))
    refuse_contradiction(sequence.rig, across)
    for state in range(1, sequence.states):
        at_once = partial(run_at_once, partial(step, state=state), SIDES)
        left, right = clock.run(f"state {sequence.left[state].name}", at_once)
        yield state, StereoGrids(across, left, right)


def follow_by_morphing(
    sequence: StereoSequence, config: RunConfig, clock: Clock, *, every_state: bool
) -> Iterator[tuple[int, StereoGrids]]:
    """Follow the grid of the first left picture over morph sequences, state by state.

    Left to left over time, and left to right in both states; see
    :func:`~shapemorph.pipeline.image_morphing.bridge_pictures`.

    Parameters
    ----------
    sequence, config, clock
        As in :func:`follow_incrementally`.
    every_state : bool
        Else only the last one.

    Yields
    ------
    int
        State.
    StereoGrids

    Raises
    ------
    DataError
        If the rig contradicts the first pair of pictures.
    StageError
        If a pair cannot be bridged.
    """
    from shapemorph.methods.increments import compose_grids

    def bridged(left: GreyImage, right: GreyImage, *, views: bool) -> CorrelationGrid:
        return bridge_pictures(left, right, config, clock, views=views).grid

    first = sequence.first()
    across = bridged(first, sequence.picture("right", 0), views=True)
    refuse_contradiction(sequence.rig, across)
    states = range(1, sequence.states) if every_state else [sequence.states - 1]
    for state in states:
        left, right = (sequence.picture(side, state) for side in ("left", "right"))
        over_time = bridged(first, left, views=False)
        over_views = bridged(_seen(left, first, over_time), right, views=True)
        yield (
            state,
            StereoGrids(across, over_time, compose_grids(over_time, over_views, shown=right.mask)),
        )


def _seen(picture: GreyImage, first: GreyImage, found: CorrelationGrid) -> GreyImage:
    """Limit a picture to where the measured part of the first one has gone."""
    from shapemorph.methods.carried_mask import limit_to_carried
    from shapemorph.methods.increments import warp_through
    from shapemorph.methods.laws.identity import identity_warp

    return limit_to_carried(picture, first, warp_through(found, identity_warp(first.shape)))
