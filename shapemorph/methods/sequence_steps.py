"""How far apart neighbours of a morph sequence are, and how many pictures it needs."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import ndimage

from shapemorph.core.arrays import Floats
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.methods.plane_maps import inverse_maps
from shapemorph.methods.sequence_turn import NO_TURN, Turn
from shapemorph.methods.warping import warp_points

PERCENTILE = 95.0  # of the points, for strain
GRID = 24  # points across a picture that are looked at


@dataclass(frozen=True, slots=True, eq=False)
class SequencePoints:
    """Material points followed through a morph sequence I_1 ... I_N.

    Attributes
    ----------
    positions : (N, P, 2) float64
        Where they are in every picture, px.
    strain : (N - 1,) float64
        From each picture to the next: largest singular value of the increment of the local
        map less the identity (stretch and turn), at the 95th percentile of the points.
    """

    positions: Floats
    strain: Floats


def follow_points(
    points: Floats, forward: Warp, backward: Warp, *, images: int, turn: Turn = NO_TURN
) -> SequencePoints:
    """Carry points of the reference through a sequence.

    Parameters
    ----------
    points : (P, 2)
        Positions in the reference, px; those that a warp does not reach are left out.
    forward, backward : Warp
        Reference -> deformed and deformed -> reference.
    images : int
        N - 2, even.
    turn : Turn
        From the reference to the deformed picture, taken along an arc.
    """
    there, gradient = warp_points(forward, points)
    known = np.isfinite(there).all(axis=1)
    points, there, gradient = points[known], there[known], gradient[known]
    back, inverse = warp_points(backward, there)
    known = np.isfinite(back).all(axis=1)
    points, there, back = points[known], there[known], back[known]
    early, late = _fractions(images)
    first = [_on_the_way(points, there, part, turn) for part in early]
    second = [_on_the_way(there, back, part, turn.back) for part in late]
    maps = [_part(gradient[known], part, turn) for part in early]
    others = [_part(inverse[known], part, turn.back) for part in late]
    steps = [_increment(a, b) for a, b in pairwise(maps)]
    # from the early half to the late one: back to the reference, then half of the way back
    joint = others[0] @ gradient[known] @ inverse_maps(maps[-1])
    steps.append(_size(joint))
    steps += [_increment(a, b) for a, b in pairwise(others)]
    return SequencePoints(np.array(first + second), np.array(steps))


def neighbour_zncc(
    pictures: Sequence[GreyImage], followed: SequencePoints, *, subset_size: int
) -> Floats:
    """(N - 1,) median likeness of what neighbours show around the same material points.

    Windows are only shifted with their point, as in a search without a shape function.

    Parameters
    ----------
    pictures : sequence of N GreyImage
    followed : SequencePoints
    subset_size : int
        Width of the windows, px.
    """
    reach = np.arange(subset_size) - subset_size // 2
    offsets = np.stack(np.meshgrid(reach, reach), axis=-1).reshape(-1, 2).astype(np.float64)
    windows = [
        _windows(picture, at, offsets)
        for picture, at in zip(pictures, followed.positions, strict=True)
    ]
    return np.array([_median_likeness(first, second) for first, second in pairwise(windows)])


def images_for_strain(
    points: Floats, warps: tuple[Warp, Warp], turn: Turn, *, most_strain: float, most_images: int
) -> int:
    """Fewest synthetic pictures (N - 2, even) with which no step strains more than a limit."""
    for images in range(2, most_images, 2):
        followed = follow_points(points, *warps, images=images, turn=turn)
        if followed.strain.max() <= most_strain:
            return images
    return most_images


def points_of(image: GreyImage) -> Floats:
    """(P, 2) points of a grid on the mask of a picture, px."""
    height, width = image.shape
    step = max(1, max(height, width) // GRID)
    rows, columns = np.mgrid[step // 2 : height : step, step // 2 : width : step]
    inside = image.mask[rows, columns]
    return np.stack([columns[inside], rows[inside]], axis=-1).astype(np.float64)


def _fractions(images: int) -> tuple[Floats, Floats]:
    """Part of its own warp that each picture of the early and of the late half is moved by."""
    if images == 0:
        return np.zeros(1), np.zeros(1)
    half = np.arange(images // 2 + 1) / images
    return half, half[::-1]


def _on_the_way(start: Floats, end: Floats, part: float, turn: Turn) -> Floats:
    return turn.carry(start + part * (turn.undo(end, 1.0) - start), part)


def _part(gradient: Floats, part: float, turn: Turn) -> Floats:
    straight = turn.rotation(-1.0) @ gradient
    moved: Floats = turn.rotation(part) @ ((1.0 - part) * np.eye(2) + part * straight)
    return moved


def _increment(before: Floats, after: Floats) -> float:
    return _size(after @ inverse_maps(before))


def _size(maps: Floats) -> float:
    """How far maps are from leaving everything in place; inf where one has collapsed."""
    sound = np.isfinite(maps).all(axis=(1, 2))
    sizes = np.full(len(maps), np.inf)
    sizes[sound] = np.linalg.norm(maps[sound] - np.eye(2), ord=2, axis=(1, 2))
    return float(np.percentile(sizes, PERCENTILE, method="higher")) if len(sizes) else np.nan


def _windows(picture: GreyImage, at: Floats, offsets: Floats) -> Floats:
    """(P, K) grey around points, bilinear; NaN rows where a window leaves the mask."""
    places = (at[:, None] + offsets).reshape(-1, 2).T[::-1]
    grey = ndimage.map_coordinates(picture.grey, places, order=1, mode="nearest")
    inside = ndimage.map_coordinates(
        picture.mask.astype(np.float32), places, order=1, mode="constant"
    )
    grey = np.where(inside > 0.999, grey.astype(np.float64), np.nan)
    return np.asarray(grey.reshape(len(at), len(offsets)))


def _median_likeness(first: Floats, second: Floats) -> float:
    whole = np.isfinite(first).all(axis=1) & np.isfinite(second).all(axis=1)
    if not whole.any():
        return float("nan")
    a, b = (part[whole] - part[whole].mean(axis=1, keepdims=True) for part in (first, second))
    norm = np.sqrt((a**2).sum(axis=1) * (b**2).sum(axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        likeness = (a * b).sum(axis=1) / norm
    likeness = likeness[np.isfinite(likeness)]
    return float(np.median(likeness)) if len(likeness) else float("nan")
