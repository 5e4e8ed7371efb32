"""Distances between results of several laws, counted where both have a value."""

from dataclasses import replace

import numpy as np
import pytest

from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.matching import Warp
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import StrainField, TrackedSurface
from shapemorph.io.codec import put_together, take_apart
from shapemorph.stages.spread import FullResult, LawResult, differ, spread

SHAPE = (5, 7)


def _warp(shift):
    rows, columns = np.mgrid[-3:9, -3:9].astype(float)
    knots = np.stack([columns, rows], axis=-1) * 20.0
    return Warp(knots + shift, np.array([-60.0, -60.0]), 20.0)


def _result(law, *, offset, lost=(), said=(0.0, 0.0)):
    """Everything moved by 3 px to the right and 2 mm up, and `offset` mm more."""
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float) * 10.0
    place = np.stack([columns, rows], axis=-1)
    status = np.zeros(SHAPE, np.uint8)
    for at in lost:
        status[at] = PointStatus.LOW_ZNCC
    ok = (status == 0)[..., None]
    grid = CorrelationGrid(
        place, np.where(ok, place + np.array([3.0, 0.0]), np.nan), np.zeros((*SHAPE, 2, 2)),
        np.ones(SHAPE), np.ones(SHAPE, int), np.where(ok, place * 0 + 0.05, np.nan),
        status, 10, 21, 0.1,
    )  # fmt: skip
    space = np.concatenate([place, np.zeros((*SHAPE, 1))], axis=-1)
    deformed = np.where(ok, space + np.array([0.0, 0.0, 2.0]) + offset, np.nan)
    tracked = TrackedSurface(
        space, deformed, space, deformed, np.ones(SHAPE), status, np.array([0.0, 0.0])
    )
    return LawResult(law, _warp(np.array(said)), grid, tracked)


def test_one_law_has_no_spread():
    found = spread([], {})
    assert found.laws == ()
    assert len(found.rms) == 0


def test_distances_are_from_the_main_law_where_both_have_a_value():
    main = _result("warp", offset=0.0, lost=[(0, 0)], said=(3.0, 0.0))
    offset = np.zeros((*SHAPE, 3))
    offset[2, 3] = [0.03, 0.0, 0.04]
    offset[0, 0] = 99.0  # lost in the main result
    other = _result("identity", offset=offset, lost=[(4, 6)])
    found = spread([main, other], {"fe": "leads nowhere"})
    assert found.laws == ("warp", "identity")
    assert found.compared.tolist() == [34, 33]
    assert found.rms[0] == 0.0
    assert found.rms[1] == pytest.approx(0.05 / np.sqrt(33))
    assert found.off_px.tolist() == pytest.approx([0.0, 3.0])
    assert found.failures == {"fe": "leads nowhere"}


def test_a_law_without_a_common_point_has_no_number():
    everything = [(row, column) for row in range(SHAPE[0]) for column in range(SHAPE[1])]
    main = _result("warp", offset=0.0)
    lost = replace(_result("fe", offset=0.0, lost=everything[1:]))
    nothing = _result("identity", offset=0.0, lost=everything[:1])
    found = spread([lost, main, nothing], {})
    assert found.compared.tolist() == [1, 1, 0]
    assert np.isnan(found.rms[2])


def test_a_spread_is_stored_and_read_back():
    found = spread([_result("warp", offset=0.0), _result("fe", offset=np.array([0, 0, 0.1]))], {})
    again = put_together(*take_apart(found))
    assert again.laws == found.laws
    assert again.rms.tolist() == found.rms.tolist()
    assert again.warps[1].spacing == 20.0


def _full(offset, e1):
    """A result on a bowl of 9 x 11 points, moved by `offset` and strained by `e1`."""
    rows, columns = np.mgrid[:9, :11].astype(float)
    space = np.stack([columns, rows, 0.01 * columns**2], axis=-1)
    status = np.zeros((9, 11), np.uint8)
    up = np.broadcast_to([0.0, 0.0, 1.0], space.shape)
    tracked = TrackedSurface(
        space, 1.3 * space + offset, up, up, np.ones((9, 11)), status, np.zeros(2)
    )
    nothing = np.zeros((9, 11))
    field = StrainField(
        *[nothing] * 4, nothing + e1, nothing, *[nothing] * 7, 1.0, 5, 40.0, 4.0
    )  # fmt: skip
    return FullResult(tracked, field)


def test_another_way_differs_by_what_was_put_in():
    found = differ("flatten.method=lscm", _full(0.0, 0.2), _full([0.0, 0.03, 0.04], 0.203))
    assert found.name == "flatten.method=lscm"
    assert found.compared > 60
    assert found.rms == pytest.approx(0.05)
    assert found.p95 == pytest.approx(0.05)
    assert found.e1_rms == pytest.approx(0.003)
    assert found.e2_rms == pytest.approx(0.0, abs=1e-12)
    both = replace(spread([], {}), variants=(found,))
    assert put_together(*take_apart(both)).variants == (found,)
