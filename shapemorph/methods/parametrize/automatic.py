"""Choose a flattening that neither folds nor overlaps, and say why."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.methods.distortion import singular_values, weighted_quantile
from shapemorph.methods.parametrize.boundary_first import parametrise_boundary_first
from shapemorph.methods.parametrize.conformal_lscm import parametrise_lscm
from shapemorph.methods.parametrize.harmonic_disk import parametrise_on_disk
from shapemorph.methods.parametrize.overlap import overlap_share
from shapemorph.methods.parametrize.untangle import flipped_faces, untangle


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
        sigma_1 / sigma_2 that 95 % of the area stays below.
    """

    plane: Floats
    method: str
    flips: int
    mended: int
    flipped_share: float
    overlap_share: float
    anisotropy: float

    def describe(self) -> str:
        """Say in half a sentence what it is and how well it lies."""
        mended = f" ({self.mended} mended)" if self.mended else ""
        return (
            f"{NAMES[self.method]}: {self.flips} flipped triangles{mended}, "
            f"{100 * self.overlap_share:.2g} % overlap, stretched by less than "
            f"{self.anisotropy:.3g} : 1 on 95 % of the area"
        )


NAMES = {
    "bff": "boundary-first map",
    "lscm": "least-squares conformal map",
    "disk": "map onto a disk",
    "orthographic": "parallel projection",
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
    return Flattening(
        plane=plane,
        method=method,
        flips=int(flipped.sum()),
        mended=0,
        flipped_share=float(distortion.area[flipped].sum() / distortion.area.sum()),
        overlap_share=overlap_share(plane, faces),
        anisotropy=weighted_quantile(ratio, distortion.area, 0.95),
    )


def flatten_automatically(
    vertices: Floats, faces: Ints, *, most_lost: float, most_anisotropy: float
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
        sigma_1 / sigma_2 that 95 % of the area must stay below.

    Returns
    -------
    Flattening
    str
        Why this one, for people.
    """
    makers: Sequence[tuple[str, Callable[[Floats, Ints], Floats]]] = (
        ("bff", parametrise_boundary_first),
        ("lscm", parametrise_lscm),
        ("disk", parametrise_on_disk),
    )
    refused = []
    tried = []
    for method, make in makers:
        try:
            flattening = mend_and_judge(vertices, faces, make(vertices, faces), method)
        except StageError as error:
            refused.append(str(error))
            continue
        tried.append(flattening)
        if _lost(flattening) <= most_lost and flattening.anisotropy <= most_anisotropy:
            return flattening, _why(flattening, refused)
        refused.append(flattening.describe())
    if not tried:
        raise StageError("; ".join(refused))
    best = min(tried, key=lambda each: (_lost(each) > most_lost, each.anisotropy))
    return best, _why(best, [*refused, "none is sound, this is the best of them"])


def _lost(flattening: Flattening) -> float:
    return flattening.flipped_share + flattening.overlap_share


def _why(flattening: Flattening, refused: list[str]) -> str:
    chosen = flattening.describe()
    return f"{chosen} (not taken: {'; '.join(refused)})" if refused else chosen
