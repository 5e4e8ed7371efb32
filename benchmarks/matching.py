"""Print a table of matching on flat pictures whose map is known exactly.

    python -m benchmarks.matching                     all groups
    python -m benchmarks.matching blur --only 3.5     some of one group
    python -m benchmarks.matching blur --correlate    what correlation makes of it

Noise of 2 grey levels, contrast 0.85, light that changes by 20 % across the picture.
Right: off by less than 2 px of the deformed picture. Gap: farthest that a point seen in
both pictures lies from a right pair. Warp: error of the forward warp wherever both
pictures show the specimen. Pictures that must not be matched show the message.
"""

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from shapemorph.config import MatchConfig, RunConfig
from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Matches
from shapemorph.methods.synthetic.planar import (
    Exposure,
    Painted,
    inverse_at,
    planar_speckle,
    take_picture,
)
from shapemorph.methods.synthetic.planar_textures import (
    cloudy,
    dead_leaves,
    ground_metal,
    printed_dots,
    wood,
)
from shapemorph.methods.warping import warp_points
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import follow_pictures, picture_law_inputs
from shapemorph.stages.match import match

BEFORE = Exposure(gain=1.0, offset=0.0, slope=0.0, noise=2.0, seed=1)
AFTER = Exposure(gain=0.85, offset=0.02, slope=0.2, noise=2.0, seed=2)
Map = Callable[[np.ndarray], np.ndarray]


def rotation(degrees: float) -> np.ndarray:
    angle = np.deg2rad(degrees)
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def linear(matrix: np.ndarray, size: int, shape: tuple[int, int]) -> Map:
    """The middle of the specimen is seen in the middle of the picture."""
    back, middle = np.linalg.inv(matrix), np.array(shape[::-1]) / 2
    return lambda points: (points - middle) @ back.T + size / 2


def bulge(amount: float, size: int, shape: tuple[int, int]) -> Map:
    middle = np.array(shape[::-1]) / 2

    def material_at(points: np.ndarray) -> np.ndarray:
        offset = points - middle
        square = (offset**2).sum(-1, keepdims=True) / (size / 2) ** 2
        return size / 2 + offset / (1 + amount * np.exp(-2 * square))

    return material_at


def kink(inner: float, outer: float, size: int, shape: tuple[int, int]) -> Map:
    """Stretch `inner` inside half of the radius, `outer` beyond it."""
    middle, edge = np.array(shape[::-1]) / 2, size / 4

    def material_at(points: np.ndarray) -> np.ndarray:
        offset = points - middle
        radius = np.linalg.norm(offset, axis=-1, keepdims=True) + 1e-9
        near = np.minimum(radius / inner, edge)
        return size / 2 + offset / radius * (near + np.maximum(radius - edge * inner, 0) / outer)

    return material_at


def disc(size: int) -> Callable[[np.ndarray], np.ndarray]:
    return lambda points: np.linalg.norm(points - size / 2, axis=-1) < 0.48 * size


def neck(most: float, size: int, shape: tuple[int, int]) -> Map:
    """Drawn along x: stretch 1 at the ends, `most` in the middle, thinner there."""
    middle, width = np.array(shape[::-1]) / 2, shape[1] / 5
    table = np.linspace(-shape[1], shape[1], 20_001)
    stretch = 1 + (most - 1) * np.exp(-((table / width) ** 2))
    material = CubicSpline(table, 1 / stretch).antiderivative()
    start = material(0.0)

    def material_at(points: np.ndarray) -> np.ndarray:
        x, y = np.moveaxis(points - middle, -1, 0)
        drawn = 1 + (most - 1) * np.exp(-((x / width) ** 2))
        return size / 2 + np.stack([material(x) - start, y * np.sqrt(drawn)], axis=-1)

    return material_at


def bend(least: float, most: float, size: int, shape: tuple[int, int]) -> Map:
    """Bent in its own plane: stretch along the arc from `least` inside to `most` outside."""
    radius = size * least / (most - least)  # of the inner edge
    scale, middle = radius / least, np.array(shape[::-1]) / 2
    centre = middle + np.array([0.0, radius + size / 2])

    def material_at(points: np.ndarray) -> np.ndarray:
        x, y = np.moveaxis(points - centre, -1, 0)
        along = scale * np.arctan2(x, -y)
        return np.stack([along + size / 2, radius + size - np.hypot(x, y)], axis=-1)

    return material_at


def uniaxial(
    stretch: float, turn: float, size: int, *, along: float = 10.0, scale: float = 1.0
) -> tuple[Map, tuple[int, int]]:
    """Stretched `along` a direction of the material, then turned; the whole disc is seen."""
    drawn = np.diag([stretch, stretch**-0.5])
    matrix = scale * rotation(turn) @ rotation(along) @ drawn @ rotation(along).T
    reach = np.ceil(np.linalg.norm(matrix, axis=1) * size / 2).astype(int)
    shape = (int(2 * reach[1] + 20), int(2 * reach[0] + 20))
    return linear(matrix, size, shape), shape


@dataclass(frozen=True, kw_only=True)
class Case:
    """A pair of pictures: where the material lies, what is painted on it, how it is taken."""

    name: str
    material_at: Map
    shape: tuple[int, int]
    size: int = 500
    pattern: Painted | None = None
    diameter: float = 5.0
    before: Exposure = BEFORE
    after: Exposure = AFTER
    spoil: Callable[[GreyImage], GreyImage] = lambda image: image
    inside: Callable[[np.ndarray], np.ndarray] | None = None


def stretched(name: str, stretch: float, turn: float = 20.0, **options: Any) -> Case:
    size = options.get("size", 500)
    geometry = {key: options.pop(key) for key in ("along", "scale") if key in options}
    material_at, shape = uniaxial(stretch, turn, size, **geometry)
    return Case(name=name, material_at=material_at, shape=shape, **options)


def plain_cases() -> Iterator[Case]:
    for degrees in (0.0, 45.0, 163.0, 270.0):
        shape = (700, 720)
        yield Case(
            name=f"turned by {degrees:.0f}, 1.2 x",
            material_at=linear(1.2 * rotation(degrees), 500, shape),
            shape=shape,
        )
    for diameter in (2.5, 5.0, 8.0, 12.0, 20.0):
        yield Case(
            name=f"bulge 2 x, speckle {diameter:g}",
            material_at=bulge(1.0, 500, (620, 640)),
            shape=(620, 640),
            diameter=diameter,
        )
    for inner, outer in ((1.5, 1.0), (2.0, 1.2)):
        yield Case(
            name=f"kink {inner:g} to {outer:g}",
            material_at=kink(inner, outer, 500, (820, 840)),
            shape=(820, 840),
        )
    for scale in (0.3, 0.4, 3.0):
        shape = (int(520 * scale * 1.4), int(530 * scale * 1.4))
        yield Case(
            name=f"scale {scale:g}",
            material_at=linear(scale * rotation(30), 500, shape),
            shape=shape,
            diameter=5 * max(1, 1 / scale),
        )
    shape = (1000, 1000)
    yield Case(name="bulge, 1 Mpx", material_at=bulge(0.3, 1000, shape), shape=shape, size=1000)


def stretch_cases() -> Iterator[Case]:
    for stretch in (1.3, 2.0, 3.0, 3.5, 5.0):
        yield stretched(f"uniaxial {stretch:g}", stretch)
    for along, turn in ((0, 60), (20, 170), (45, 0), (90, 60)):
        name = f"uniaxial 3.5 along {along}, turned {turn}"
        yield stretched(name, 3.5, turn, along=along)
    for diameter in (3.0, 8.0, 14.0):
        yield stretched(f"uniaxial 3.5, speckle {diameter:g}", 3.5, diameter=diameter)
    for scale in (0.5, 2.0):
        name = f"uniaxial 2.5, scale {scale:g}"
        yield stretched(name, 2.5, scale=scale, diameter=5 * max(1, 1 / scale))
    yield stretched("uniaxial 3.5, 1 Mpx", 3.5, 0.0, along=0, size=700)
    for most in (2.5, 3.5):
        shape = (520, int(420 * (1 + most) / 2) + 200)
        yield Case(name=f"neck 1 to {most:g}", material_at=neck(most, 500, shape), shape=shape)
    for least, most in ((0.7, 2.2), (0.8, 3.0)):
        shape = (900, 1300)
        yield Case(
            name=f"bend {least:g} to {most:g}",
            material_at=bend(least, most, 500, shape),
            shape=shape,
        )


def blur_cases() -> Iterator[Case]:
    for side in ("deformed", "reference"):
        for blur in (1.0, 2.0):
            for stretch in (1.1, 2.0, 3.0, 3.5):
                soft = {"after": replace(AFTER, blur=blur)}
                if side == "reference":
                    soft = {"before": replace(BEFORE, blur=blur)}
                name = f"{side} soft {blur:g}, uniaxial {stretch:g}"
                yield stretched(name, stretch, diameter=4.5, **soft)


def light_cases() -> Iterator[Case]:
    for stretch in (1.3, 3.0):
        noisy = {"before": replace(BEFORE, noise=10.0), "after": replace(AFTER, noise=10.0)}
        yield stretched(f"noise 10, uniaxial {stretch:g}", stretch, **noisy)
        dim = replace(AFTER, gain=0.3, slope=0.5)
        yield stretched(f"gain 0.3, slope 0.5, uniaxial {stretch:g}", stretch, after=dim)


def texture_cases() -> Iterator[Case]:
    patterns = {
        "skin": cloudy(width=4, seed=1),
        "wood": wood(width=4, seed=1),
        "metal": ground_metal(width=4, seed=1),
        "dead leaves": dead_leaves(width=4, seed=1),
        "dots 16 and 30 % skin": printed_dots(pitch=16, other=cloudy(width=4, seed=1), share=0.3),
        "dots 16": printed_dots(pitch=16, other=None, share=0.0),
    }
    for name, pattern in patterns.items():
        for stretch in (1.3, 2.0, 3.5):
            yield stretched(f"{name}, uniaxial {stretch:g}", stretch, pattern=pattern)
        shape = (620, 640)
        yield Case(
            name=f"{name}, bulge 2 x",
            material_at=bulge(1.0, 500, shape),
            shape=shape,
            pattern=pattern,
        )


def damage_cases() -> Iterator[Case]:
    shape = (700, 720)
    for name, spoil in (("glare", glare), ("lost patches", lost_patches), ("print", printed)):
        yield Case(
            name=f"{name}, bulge 2 x",
            material_at=bulge(1.0, 500, shape),
            shape=shape,
            spoil=spoil,
        )
        yield stretched(f"{name}, uniaxial 3", 3.0, spoil=spoil)
    burst = replace_inside(shape)
    yield burst


def replace_inside(shape: tuple[int, int]) -> Case:
    """Most of the middle is gone on the deformed side."""

    def spoil(image: GreyImage) -> GreyImage:
        rows, cols = np.mgrid[: image.shape[0], : image.shape[1]]
        distance = np.hypot(rows - image.shape[0] / 2, cols - image.shape[1] / 2)
        ragged = distance < 110 + 30 * np.sin(5 * np.arctan2(rows - 350, cols - 360))
        return GreyImage(image.grey, image.mask & ~ragged)

    return Case(
        name="burst, bulge 2 x", material_at=bulge(1.0, 500, shape), shape=shape, spoil=spoil
    )


def glare(image: GreyImage) -> GreyImage:
    rows, cols = np.mgrid[: image.shape[0], : image.shape[1]]
    spot = 4.0 * np.exp(-((rows - 300.0) ** 2 + (cols - 400.0) ** 2) / 90.0**2)
    return GreyImage(np.clip(image.grey + spot, 0, 1).astype(np.float32), image.mask)


def lost_patches(image: GreyImage) -> GreyImage:
    grey = image.grey.copy()
    for row, col, radius in ((200, 300, 60), (420, 350, 40), (350, 520, 70)):
        rows, cols = np.ogrid[: grey.shape[0], : grey.shape[1]]
        grey[(rows - row) ** 2 + (cols - col) ** 2 < radius**2] = 0.8
    return GreyImage(grey, image.mask)


def printed(image: GreyImage) -> GreyImage:
    import cv2

    grey = image.grey.copy()
    marks = np.zeros(grey.shape, np.uint8)
    cv2.putText(marks, "BATCH 0471", (150, 380), cv2.FONT_HERSHEY_SIMPLEX, 2.2, 255, 10)
    grey[marks > 0] = 0.05
    return GreyImage(np.where(image.mask, grey, 0), image.mask)


def refused_cases() -> Iterator[Case]:
    for stretch in (1.3, 3.0):
        yield stretched(
            f"negative, uniaxial {stretch:g}", stretch, after=replace(AFTER, gain=-0.85)
        )
        case = stretched(f"mirrored, uniaxial {stretch:g}", stretch)
        flipped = case.material_at
        yield replace(case, material_at=lambda p, old=flipped: old(p) * [-1.0, 1.0] + [500.0, 0.0])
    case = stretched("unrelated", 1.3)
    flipped = case.material_at
    yield replace(case, material_at=lambda p: flipped(p) + 700.0, inside=lambda p: p[..., 0] > -1e9)


GROUPS = {
    "plain": plain_cases,
    "stretch": stretch_cases,
    "blur": blur_cases,
    "light": light_cases,
    "texture": texture_cases,
    "damage": damage_cases,
    "refused": refused_cases,
}


def judge(matches: Matches, material_at: Map, before: GreyImage, after: GreyImage) -> str:
    rows, cols = np.nonzero(before.mask[::5, ::5])
    points = 5.0 * np.column_stack([cols, rows])
    claimed = warp_points(matches.forward, points)[0]
    true = inverse_at(material_at, points, claimed)
    seen = ((true > 0) & (true < np.array(after.shape[::-1]) - 1)).all(axis=1)
    exact = inverse_at(material_at, matches.reference_px, matches.deformed_px)
    pairs = np.linalg.norm(exact - matches.deformed_px, axis=1)
    warp = np.linalg.norm(claimed - true, axis=1)[seen]
    gap = cKDTree(matches.reference_px[pairs < 2]).query(points[seen])[0].max()
    return (
        f"{(pairs < 2).sum():5d}/{len(pairs):<5d} {np.median(pairs):7.3f} {pairs.max():7.2f} "
        f"{np.median(warp):7.3f} {np.percentile(warp, 99):7.2f} {warp.max():7.2f} {gap:6.1f} "
        f"{matches.residual_px:7.3f} {matches.settled_px:8.3f} {matches.counts['matched']:8d} "
        f"{matches.counts['voted']:6d}"
    )


def pictures(case: Case) -> tuple[GreyImage, GreyImage]:
    pattern = case.pattern or planar_speckle(diameter=case.diameter, seed=3)
    size, inside = case.size, case.inside or disc(case.size)
    before = take_picture(
        pattern, (size, size), case.before, material_at=lambda p: p, inside=inside
    )
    after = take_picture(
        pattern, case.shape, case.after, material_at=case.material_at, inside=inside
    )
    return before, case.spoil(after)


def row(case: Case, repeats: int) -> str:
    before, after = pictures(case)
    matches, start, spent = None, 0.0, 0.0
    for _ in range(repeats):
        start, spent = time.perf_counter(), time.process_time()
        try:
            matches = match(before, after, MatchConfig())
        except StageError as error:
            seconds = time.perf_counter() - start
            return f"{error} {seconds:.2f} s"
    seconds, spent = time.perf_counter() - start, time.process_time() - spent
    assert matches is not None
    doubt = getattr(matches, "doubt", "")
    return f"{judge(matches, case.material_at, before, after)} {seconds:6.2f} {spent:6.2f} {doubt}"


def followed(case: Case) -> str:
    """Errors of all points of the reference that correlation has followed."""
    config = RunConfig()
    before, after = pictures(case)
    spent = time.process_time()
    try:
        found = follow_pictures(
            before, after, config, picture_law_inputs(config), Clock(lambda _event: None)
        )
    except StageError as error:
        return str(error)
    spent = time.process_time() - spent
    grid = found.grid
    ok, tried = grid.status == 0, np.count_nonzero(grid.status != 1)
    measured = grid.deformed_px[ok]
    exact = inverse_at(case.material_at, grid.reference_px[ok], measured)
    error = np.linalg.norm(measured - exact, axis=1)
    doubt = found.matches.doubt if found.matches else ""
    return (
        f"{ok.sum():5d}/{tried:<5d} {np.median(error):7.3f} {np.percentile(error, 95):7.3f} "
        f"{error.max():7.2f} {np.mean(error > 0.5):8.3%} "
        f"{np.percentile(grid.sigma_px[ok], 95):7.3f} {np.median(grid.zncc[ok]):6.3f} "
        f"{grid.subset_size:6d} {spent:6.2f} {doubt}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("groups", nargs="*", default=list(GROUPS), help=", ".join(GROUPS))
    parser.add_argument("--only", default="", help="part of the name of the cases to run")
    parser.add_argument("--repeats", type=int, default=1, help="the last one is timed")
    parser.add_argument("--correlate", action="store_true", help="correlate, too; errors in px")
    options = parser.parse_args()
    if options.correlate:
        print(f"{'case':36s} {'OK':>11s} {'median':>7s} {'p95':>7s} {'max':>7s} {'> 0.5 px':>8s} "
              f"{'sigma':>7s} {'ZNCC':>6s} {'subset':>6s} {'s CPU':>6s}")  # fmt: skip
    else:
        print_heading()
    for group in options.groups:
        for case in GROUPS[group]():
            if options.only in case.name:
                told = followed(case) if options.correlate else row(case, options.repeats)
                print(f"{case.name:36s} {told}", flush=True)


def print_heading() -> None:
    print(f"{'case':36s} {'right':>11s} {'pairs':>7s} {'max':>7s} {'warp':>7s} {'p99':>7s} "
          f"{'max':>7s} {'gap':>6s} {'own':>7s} {'settled':>8s} {'matched':>8s} {'voted':>6s} "
          f"{'s':>6s} {'s CPU':>6s}")  # fmt: skip


if __name__ == "__main__":
    main()
