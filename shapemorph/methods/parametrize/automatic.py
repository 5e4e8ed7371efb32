"""Choose a flattening that neither folds nor overlaps, and say why."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.methods.distortion import local_scale, singular_values, weighted_quantile
from shapemorph.methods.parametrize.boundary_first import parametrise_boundary_first
from shapemorph.methods.parametrize.conformal_lscm import parametrise_lscm
from shapemorph.methods.parametrize.harmonic_disk import parametrise_on_disk
from shapemorph.methods.parametrize.overlap import overlap_share
from shapemorph.methods.parametrize.slim import parametrise_slim
from shapemorph.methods.parametrize.untangle import flipped_faces, untangle

WORST = 0.01  # share of the area that the judgement of a map is about
MOST_SLIM_FACES = 300_000  # beyond, the locally injective map takes minutes
Maker = Callable[[Floats, Ints], Floats]


@dataclass(frozen=True, slots=True, eq=False)
class Flattening:
    """A surface in the plane and how well it lies.

    Attributes
    ----------
    plane : (V, 2) float64
        x right, y up, faces counter-clockwise.
    method : str
    flips, mended : int
        Triangles upside down in the end, and turned back.
    flipped_share, overlap_share : float
        Of the area on the surface, and of the area in the plane.
    anisotropy : float
        sigma_1 / sigma_2 that 99 % of the area stays below.
    reduced : float
        How many times smaller than the median the worst 1 % of the area is shown; or
        larger, if that is more, because it takes the pixels from the rest.
    """

    plane: Floats
    method: str
    flips: int
    mended: int
    flipped_share: float
    overlap_share: float
    anisotropy: float
    reduced: float

    @property
    def lost(self) -> float:
        """Share of the surface that the picture does not show, or shows twice."""
        return self.flipped_share + self.overlap_share

    def describe(self) -> str:
        """Say in half a sentence what it is and how well it lies."""
        mended = f" ({self.mended} mended)" if self.mended else ""
        return (
            f"{NAMES[self.method]}: {self.flips} flipped triangles{mended}, "
            f"{100 * self.overlap_share:.2g} % overlap, stretched by less than "
            f"{self.anisotropy:.2f} : 1 on 99 % of the area, its scale within a factor of "
            f"{self.reduced:.2f} of the median"
        )


NAMES = {
    "bff": "boundary-first map",
    "lscm": "least-squares conformal map",
    "arap": "as-rigid-as-possible map",
    "slim": "locally injective map",
    "harmonic": "map onto a disk",
    "orthographic": "parallel projection",
    "spherical": "spherical map",
    "cylindrical": "unrolled cylinder",
    "profile": "map by the meridian's length",
}


def mend_and_judge(vertices: Floats, faces: Ints, plane: Floats, method: str) -> Flattening:
    """Turn back what a flattening folds, as far as that goes, and judge the rest."""
    before = int(flipped_faces(vertices, faces, plane).sum())
    if before == 0:
        return judge(vertices, faces, plane, method)
    flattening = judge(vertices, faces, untangle(vertices, faces, plane), method)
    return replace(flattening, mended=before - flattening.flips)


def judge(vertices: Floats, faces: Ints, plane: Floats, method: str) -> Flattening:
    """Say how well a flattening lies."""
    distortion = singular_values(vertices, faces, plane)
    flipped = distortion.sigma_2 <= 0
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(flipped, np.nan, distortion.sigma_1 / distortion.sigma_2)
    scale = local_scale(distortion)
    return Flattening(
        plane=plane,
        method=method,
        flips=int(flipped.sum()),
        mended=0,
        flipped_share=float(distortion.area[flipped].sum() / distortion.area.sum()),
        overlap_share=overlap_share(plane, faces),
        anisotropy=weighted_quantile(ratio, distortion.area, 1 - WORST),
        reduced=_unevenness(scale, distortion.area),
    )


def _unevenness(scale: Floats, area: Floats) -> float:
    """Larger one of median over smallest and largest over median, without the worst 1 %."""
    low, median, high = (weighted_quantile(scale, area, q) for q in (WORST, 0.5, 1 - WORST))
    return max(median / low, high / median) if low > 0 else float("inf")


def flatten_automatically(
    vertices: Floats,
    faces: Ints,
    *,
    most_lost: float,
    most_anisotropy: float,
    most_reduced: float,
    made: Flattening | None = None,
) -> tuple[Flattening, str]:
    """Take the boundary-first map if it is sound, else the next best.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
        A disk with holes.
    most_lost : float
        Share of the area that may be flipped or overlap.
    most_anisotropy : float
        sigma_1 / sigma_2 that 99 % of the area must stay below.
    most_reduced : float
        How many times smaller or larger than the median the worst 1 % of the area may be
        shown. Of maps that are not sound that is taken which shows most area within the
        last two limits.
    made : Flattening, optional
        The boundary-first map, if it has been made already.

    Returns
    -------
    Flattening
    str
        Why this one, for people.
    """
    limits = (most_lost, most_anisotropy, most_reduced)
    refused: list[str] = []
    tried: list[Flattening] = []
    for method in ("bff", "lscm", "slim", "harmonic"):
        if method == "lscm" and tried and _only_reduces(tried[0], limits):
            continue  # as conformal as the first, and less even
        if method == "slim" and len(faces) > MOST_SLIM_FACES:
            refused.append(f"{NAMES[method]}: not tried on more than {MOST_SLIM_FACES} triangles")
            continue
        try:
            flattening = made if made and method == made.method else _make(vertices, faces, method)
        except StageError as error:
            refused.append(str(error))
            continue
        tried.append(flattening)
        if _badness(flattening, limits) <= 1:
            return flattening, _why(flattening, refused)
        refused.append(flattening.describe())
    if not tried:
        raise StageError("; ".join(refused))
    bad = [each.lost + _bad_share(vertices, faces, each, limits) for each in tried]
    order = [(each.lost > most_lost, share) for each, share in zip(tried, bad, strict=True)]
    least = order.index(min(order))
    least_bad = f"none is sound; in this one only {bad[least]:.2%} of the area lies badly"
    return tried[least], _why(tried[least], [*refused, least_bad])


def _make(vertices: Floats, faces: Ints, method: str) -> Flattening:
    makers: dict[str, Maker] = {
        "bff": parametrise_boundary_first,
        "lscm": parametrise_lscm,
        "slim": parametrise_slim,
        "harmonic": parametrise_on_disk,
    }
    return mend_and_judge(vertices, faces, makers[method](vertices, faces), method)


def _badness(flattening: Flattening, limits: tuple[float, float, float]) -> float:
    """How far beyond a limit a map lies; up to 1 it is sound."""
    reached = (flattening.lost, flattening.anisotropy, flattening.reduced)
    over = [value / limit for value, limit in zip(reached, limits, strict=True)]
    return float(np.nan_to_num(max(over), nan=np.inf))


def _bad_share(
    vertices: Floats, faces: Ints, flattening: Flattening, limits: tuple[float, float, float]
) -> float:
    """Share of the area whose shear or scale lies beyond the limits.

    Of maps that are not sound the one with least of it is best: a map that shears all of a
    surface mildly loses more than one that squeezes a corner of it to nothing.
    """
    _, most_anisotropy, most_reduced = limits
    values = singular_values(vertices, faces, flattening.plane)
    scale = local_scale(values)
    median = weighted_quantile(scale, values.area, 0.5)
    with np.errstate(invalid="ignore"):
        sound = np.maximum(scale / median, median / scale) <= most_reduced
        sound &= values.sigma_1 <= most_anisotropy * values.sigma_2
    unflipped = 1.0 - flattening.flipped_share
    return float(unflipped - values.area[sound].sum() / values.area.sum())


def _only_reduces(flattening: Flattening, limits: tuple[float, float, float]) -> bool:
    sound = flattening.lost <= limits[0] and flattening.anisotropy <= limits[1]
    return sound and flattening.reduced > limits[2]


def _why(flattening: Flattening, refused: list[str]) -> str:
    chosen = flattening.describe()
    return f"{chosen} (not taken: {'; '.join(refused)})" if refused else chosen
