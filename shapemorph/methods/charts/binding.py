"""The matches of single pages as matches of the pictures that hold them all."""

import logging
from collections.abc import Callable, Sequence

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.core.image import CalibratedImage, GreyImage
from shapemorph.core.laws import Dots
from shapemorph.core.matching import Matches, UnmatchedError, Warp
from shapemorph.methods.charts.mosaic import PAGE_GAP, page_bounds, page_image
from shapemorph.methods.threads import run_at_once
from shapemorph.methods.warp_renewal import continue_warp, spline_through

NOWHERE = -1e6  # px; where the warp of a page without matches leads
MARGIN = 8  # nodes around; a spline forgets its border by 0.27 per node
NODES_PER_GAP = 6  # nodes of a warp between two pages: so neither feels the other
_log = logging.getLogger(__name__)


Matcher = Callable[[GreyImage, GreyImage, Dots | None, Dots | None], Matches]


def match_by_page(
    match: Matcher,
    reference: CalibratedImage,
    deformed: CalibratedImage,
    known: Dots | None = None,
    found: Dots | None = None,
) -> Matches:
    """Match each page of the reference with that of the same number of the deformed.

    Parameters
    ----------
    match : callable
        Matches two pictures, with what is known of them beforehand and what was found.
    reference, deformed : CalibratedImage
        With as many pages.
    known : Dots or None
        Pairs that are roughly right, px; those that stay on one page count.
    found : Dots or None
        Features that were matched before, px.

    Raises
    ------
    UnmatchedError
        If no page matches; where some do, the others lose their points.
    """
    if reference.chart.page_count == 1:
        return match(reference.image, deformed.image, known, found)
    sides = [page_bounds(image.chart, image.image.shape[1]) for image in (reference, deformed)]

    def match_page(number: int) -> Matches | UnmatchedError:
        left, right = (bounds[number] for bounds in sides)
        try:
            images = page_image(reference.image, left), page_image(deformed.image, right)
            return match(*images, _on_page(known, left, right), _on_page(found, left, right))
        except StageError as error:
            _log.warning("chart %d: %s", number, error)
            return _on_all_pages(error, left[0], right[0])

    results = run_at_once(match_page, range(reference.chart.page_count))
    matched = [each if isinstance(each, Matches) else None for each in results]
    failures = [each for each in results if isinstance(each, UnmatchedError)]
    if not any(matched):
        raise UnmatchedError(
            str(failures[0]),
            np.concatenate([each.reference_px for each in failures]),
            np.concatenate([each.deformed_px for each in failures]),
        )
    return bind_matches(matched, sides[0], sides[1], (reference.image.shape, deformed.image.shape))


def _on_page(known: Dots | None, left: tuple[int, int], right: tuple[int, int]) -> Dots | None:
    """Known pairs of one page, in its px."""
    if known is None:
        return None
    source, target = known.reference_px, known.deformed_px
    here = (source[:, 0] >= left[0]) & (source[:, 0] < left[1])
    here &= (target[:, 0] >= right[0]) & (target[:, 0] < right[1])
    return Dots(source[here] - [left[0], 0.0], target[here] - [right[0], 0.0])


def _on_all_pages(error: StageError, left: int, right: int) -> UnmatchedError:
    """Give the pairs of a failure in px of the whole pictures."""
    if not isinstance(error, UnmatchedError):
        return UnmatchedError(str(error), np.empty((0, 2)), np.empty((0, 2)))
    return UnmatchedError(
        str(error),
        error.reference_px + np.array([left, 0.0]),
        error.deformed_px + np.array([right, 0.0]),
    )


def bind_matches(
    found: Sequence[Matches | None],
    reference: Sequence[tuple[int, int]],
    deformed: Sequence[tuple[int, int]],
    shapes: tuple[tuple[int, int], tuple[int, int]],
) -> Matches:
    """Join matches that were found page by page.

    Parameters
    ----------
    found : sequence of Matches or None
        Of each page, in px of the page; None where there are none.
    reference, deformed : sequence of (int, int)
        First column of each page and that after its last, in the two pictures.
    shapes : two (int, int)
        Height and width of the two pictures.

    Returns
    -------
    Matches
        In px of the whole pictures; points of pages without matches lead nowhere.
    """
    known = [(k, each) for k, each in enumerate(found) if each]
    to_left = [np.array([reference[k][0], 0.0]) for k, _ in known]
    to_right = [np.array([deformed[k][0], 0.0]) for k, _ in known]
    ways = [None if each is None else each.forward for each in found]
    backs = [None if each is None else each.backward for each in found]
    doubts = [each.doubt for _, each in known if each.doubt]
    doubts += [
        f"chart {k} matches nothing: its points are lost"
        for k, each in enumerate(found)
        if not each
    ]
    weights = np.array([len(each.reference_px) for _, each in known])
    return Matches(
        reference_px=_moved([each.reference_px for _, each in known], to_left),
        deformed_px=_moved([each.deformed_px for _, each in known], to_right),
        forward=_bind_warps(ways, reference, deformed, shapes[0]),
        backward=_bind_warps(backs, deformed, reference, shapes[1]),
        counts=_summed([each.counts for _, each in known]),
        settled_px=max(each.settled_px for _, each in known),
        residual_px=float(np.average([each.residual_px for _, each in known], weights=weights)),
        doubt="; ".join(dict.fromkeys(doubts)),
        manner="; ".join(dict.fromkeys(each.manner for _, each in known if each.manner)),
        fold_share=float(np.average([each.fold_share for _, each in known], weights=weights)),
    )


def _moved(points: Sequence[Floats], offsets: Sequence[Floats]) -> Floats:
    return np.concatenate([p + offset for p, offset in zip(points, offsets, strict=True)])


def _summed(counts: Sequence[dict[str, int]]) -> dict[str, int]:
    names = dict.fromkeys(name for each in counts for name in each)
    return {name: sum(each.get(name, 0) for each in counts) for name in names}


def _bind_warps(
    warps: Sequence[Warp | None],
    sources: Sequence[tuple[int, int]],
    targets: Sequence[tuple[int, int]],
    shape: tuple[int, int],
) -> Warp:
    """Put the warps of pages into one, column band by column band.

    Its nodes lie so densely that the bands do not feel each other where there are pages.
    """
    spacing = min([warp.spacing for warp in warps if warp] + [PAGE_GAP / NODES_PER_GAP])
    x, y = (spacing * np.arange(-MARGIN, np.ceil(n / spacing) + MARGIN) for n in shape[::-1])
    coefficients = np.full((len(y), len(x), 2), NOWHERE)
    for number, warp in enumerate(warps):
        band = _band(x, sources, number)
        if warp is not None and len(band):
            wider = x[band[0]] + spacing * np.arange(-MARGIN, len(band) + MARGIN)
            nodes = np.stack(np.meshgrid(wider - sources[number][0], y), axis=-1)
            values = continue_warp(warp, nodes.reshape(-1, 2)).reshape(nodes.shape)
            found = spline_through(values)[:, MARGIN:-MARGIN]
            coefficients[:, band] = found + np.array([targets[number][0], 0.0])
    return Warp(coefficients, np.array([x[0], y[0]]), float(spacing))


def _band(x: Floats, sources: Sequence[tuple[int, int]], number: int) -> Ints:
    """Nodes of one page: from the middle of the gap before it to that of the gap behind."""
    start = -np.inf if number == 0 else sources[number][0]
    end = np.inf if number == len(sources) - 1 else sources[number][1]
    return np.flatnonzero((x >= start) & (x < end))
