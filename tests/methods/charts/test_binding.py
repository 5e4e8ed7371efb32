import numpy as np
import pytest

from shapemorph.core.errors import StageError
from shapemorph.core.image import CalibratedImage, Chart, GreyImage
from shapemorph.core.laws import Dots
from shapemorph.core.matching import Matches, UnmatchedError
from shapemorph.methods.charts.binding import match_by_page
from shapemorph.methods.charts.mosaic import page_image
from shapemorph.methods.warp_fit import fit_warp
from shapemorph.methods.warping import warp_points


def pictures(starts, shape):
    none = np.zeros((0, 3), dtype=np.int64)
    chart = Chart(np.arange(0), none, np.arange(0), np.zeros((0, 2)), 1.0, np.array(starts))
    return CalibratedImage(
        GreyImage(np.zeros(shape, np.float32), np.ones(shape, bool)),
        chart,
        np.full(shape, -1, dtype=np.int32),
        np.full((*shape, 2), np.nan),
    )


def maps(left, _right, _known=None, _found=None):
    """Each page has a map of its own, told by its width."""
    height, width = left.shape
    y, x = np.mgrid[5:height:10, 5:width:10].astype(float)
    source = np.stack([x.ravel(), y.ravel()], axis=-1)
    turn = 0.0005 * width
    matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    target = source @ matrix.T + 0.0004 * source**2 + [40, 10]
    low, high = np.zeros(2), np.array([width, height], dtype=float)

    def fit(one, other, end):
        return fit_warp(one, other, extent=(low - 60, end + 60), spacing=17.0, smoothing=1e-8)

    return Matches(
        source,
        target,
        fit(source, target, high),
        fit(target, source, target.max(axis=0)),
        {"matched": len(source)},
        0.01,
        0.1 * width,
        0.0,
    )


LEFT, RIGHT = pictures([0, 180], (140, 400)), pictures([0, 250], (200, 560))


def test_each_page_keeps_its_own_warp():
    found = match_by_page(maps, LEFT, RIGHT)
    on_second = found.reference_px[:, 0] >= 180
    assert found.counts["matched"] == len(found.reference_px)
    assert (found.deformed_px[on_second][:, 0] > 250).all()
    for start, end, far_start, far_end in ((0, 180, 0, 250), (180, 400, 250, 560)):
        page = maps(
            page_image(LEFT.image, (start, end)), page_image(RIGHT.image, (far_start, far_end))
        )
        # rim of 36 px: half the room that pages have between them
        for bound, alone, points, left, there in (
            (found.forward, page.forward, page.reference_px, start, far_start),
            (found.backward, page.backward, page.deformed_px, far_start, start),
        ):
            width = end - start if left == start else far_end - far_start
            inner = points[(points[:, 0] > 36) & (points[:, 0] < width - 36)]
            expected = warp_points(alone, inner)[0] + [there, 0]
            np.testing.assert_allclose(
                warp_points(bound, inner + np.array([left, 0]))[0], expected, atol=0.01
            )


def test_a_page_that_matches_nothing_loses_only_its_own_points():
    def fails_on_wide(left, right, *_):
        if left.shape[1] > 200:
            raise StageError("nothing")
        return maps(left, right)

    found = match_by_page(fails_on_wide, LEFT, RIGHT)
    assert (found.reference_px[:, 0] < 180).all()
    targets, _ = warp_points(found.forward, np.array([[50.0, 50.0], [300.0, 50.0]]))
    assert np.abs(targets[0]).max() < 200
    assert np.abs(targets[1]).max() > 1e5
    assert found.doubt == "chart 1 matches nothing: its points are lost"


def test_no_page_matching_shows_what_looked_alike_on_all_pages():
    def fails(left, *_):
        one = np.array([[3.0, 5.0]])
        raise UnmatchedError(f"nothing on {left.shape[1]}", one, one + 1)

    with pytest.raises(UnmatchedError, match="nothing on 180") as caught:
        match_by_page(fails, LEFT, RIGHT)
    assert caught.value.reference_px.tolist() == [[3, 5], [183, 5]]
    assert caught.value.deformed_px.tolist() == [[4, 6], [254, 6]]


def test_a_blank_page_is_no_error_of_the_others():
    def blank(left, right, *_):
        if left.shape[1] > 200:
            return maps(left, right)
        raise StageError("blank")

    assert (match_by_page(blank, LEFT, RIGHT).reference_px[:, 0] > 180).all()


@pytest.mark.parametrize("kind", ["known", "found"])
def test_pairs_go_to_their_pages(kind):
    seen = {}

    def keeps(left, right, known, found):
        seen[left.shape[1]] = known or found
        return maps(left, right)

    source = np.array([[10.0, 5.0], [200.0, 6.0], [20.0, 7.0], [np.nan, 8.0]])
    target = np.array([[30.0, 5.0], [300.0, 6.0], [260.0, 7.0], [30.0, 8.0]])
    match_by_page(keeps, LEFT, RIGHT, **{kind: Dots(source, target)})
    assert seen[180].reference_px.tolist() == [[10, 5]]
    assert seen[220].reference_px.tolist() == [[20, 6]]
    assert seen[220].deformed_px.tolist() == [[50, 6]]
