"""Lay a surface flat in as few charts as its shape allows."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError, StageError
from shapemorph.core.mesh import TexturedMesh
from shapemorph.methods.charts.mosaic import Page
from shapemorph.methods.charts.splitting import Patch, split_surface
from shapemorph.methods.distortion import local_scale, singular_values, weighted_quantile
from shapemorph.methods.parametrize.automatic import Flattening
from shapemorph.methods.parametrize.choice import place
from shapemorph.methods.parametrize.disk import Piece, cut_pieces

_log = logging.getLogger(__name__)

Lay = Callable[[Floats, Ints], tuple[Flattening, str]]

ENOUGH_GOOD = 0.97  # of the area, shown well by the page that is its home
MOST_SCALED = 2.5  # times smaller or larger than the median of the page
MOST_ANISOTROPY = 1.3
WORTH_IT = 0.005  # of the area; more pages must show so much more of it well
PATIENCE = 3  # numbers of pages to try beyond the best
OVERLAP = 0.08  # of the square root of the area
LEAST_COMPONENT = 0.02  # of the area of the mesh; smaller ones are left out


@dataclass(frozen=True, slots=True, eq=False)
class Atlas:
    """Pages that show a surface.

    Attributes
    ----------
    pages : list of Page
    methods : tuple of str
        How each was flattened.
    reason : str
        For people: why so many, how well they lie.
    """

    pages: list[Page]
    methods: tuple[str, ...]
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class _Try:
    """One component in some number of pages."""

    patches: Sequence[Patch]
    pages: list[Page]
    methods: list[str]
    notes: list[str]
    good: float


def chart_surface(mesh: TexturedMesh, lay: Lay, *, trial: Lay, least: int, most: int) -> Atlas:
    """Lay every large component of a mesh flat, in as few pages as show it well.

    Well means: within a factor of 2.5 of the page's median scale and stretched by less than
    1.3 : 1, for 97 % of the area.

    Parameters
    ----------
    mesh : TexturedMesh
    lay : callable
        Flattens a disk with holes, vertices (V, 3) and faces (F, 3), and says why so.
    trial : callable
        The same, quickly: the number of pages is chosen by it.
    least, most : int
        Pages of the largest component; of the others at most `most`.

    Raises
    ------
    StageError
        If no way is found.
    """
    pieces = cut_pieces(mesh.vertices, mesh.faces, name=mesh.name)
    areas = np.array([face_areas(mesh.vertices, mesh.faces[p.face_ids]).sum() for p in pieces])
    large = [
        p for p, area in zip(pieces, areas, strict=True) if area >= LEAST_COMPONENT * areas.sum()
    ]
    tries = [
        _chart_component(mesh, piece, lay, trial, range(least if k == 0 else 1, most + 1))
        for k, piece in enumerate(large)
    ]
    pages = [page for each in tries for page in each.pages]
    notes = [note for each in tries for note in each.notes]
    if len(large) < len(pieces):
        share = 1 - areas[: len(large)].sum() / areas.sum()
        notes.append(
            f"{len(pieces) - len(large)} small components left out ({share:.1%} of the area)"
        )
    if len(pages) > 1:
        notes.insert(0, f"{len(pages)} charts of {len(large)} component(s)")
    return Atlas(pages, tuple(m for each in tries for m in each.methods), "; ".join(notes))


def face_areas(vertices: Floats, faces: Ints) -> Floats:
    """(F,) area of each face."""
    one, other = (vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2))
    areas: Floats = 0.5 * np.linalg.norm(np.cross(one, other), axis=1)
    return areas


def lay_page(mesh: TexturedMesh, patch: Patch, lay: Lay) -> tuple[Page, Flattening, str]:
    """Flatten part of a mesh.

    Parameters
    ----------
    mesh : TexturedMesh
    patch : Patch
        Of faces of the mesh; only its largest connected piece is taken.
    lay : callable

    Raises
    ------
    DataError, StageError
        If it cannot lie flat.
    """
    if len(patch.faces) == 0:
        raise DataError(f"{mesh.name} has too few faces for so many charts: use a finer mesh")
    whole = cut_pieces(mesh.vertices, mesh.faces[patch.faces], name=mesh.name)[0]
    piece = Piece(whole.vertex_ids, whole.faces, patch.faces[whole.face_ids])
    flattening, why = lay(mesh.vertices[piece.vertex_ids], piece.faces)
    plane = place(mesh.vertices, piece, flattening)
    return Page(piece, plane, patch.home[whole.face_ids]), flattening, why


def good_area(mesh: TexturedMesh, page: Page) -> float:
    """Area at home on a page that it shows well, mm^2."""
    values = singular_values(mesh.vertices[page.piece.vertex_ids], page.piece.faces, page.plane)
    scale = local_scale(values)
    median = weighted_quantile(scale, values.area, 0.5)
    with np.errstate(invalid="ignore"):
        factor = np.maximum(scale / median, median / scale)
        good = (factor <= MOST_SCALED) & (values.sigma_1 < MOST_ANISOTROPY * values.sigma_2)
    return float(values.area[good & page.home].sum())


def _chart_component(mesh: TexturedMesh, piece: Piece, lay: Lay, trial: Lay, counts: range) -> _Try:
    """Try one page, then more, until they show enough or more of them show no more."""
    faces = mesh.faces[piece.face_ids]
    area = float(face_areas(mesh.vertices, faces).sum())
    tried: list[_Try] = []
    reasons: list[str] = []
    for count in counts:
        try:
            found = _pages(mesh, _patches(mesh, piece, count, area), trial, area)
        except (DataError, StageError) as error:
            reasons.append(str(error))
            continue
        tried.append(found)
        if found.good >= ENOUGH_GOOD or _gains_nothing(tried):
            break
    if not tried:
        raise DataError("; ".join(dict.fromkeys(reasons)))
    best = max(each.good for each in tried)
    chosen = next(each for each in tried if each.good >= min(best - WORTH_IT, ENOUGH_GOOD))
    return _pages(mesh, chosen.patches, lay, area)


def _gains_nothing(tried: Sequence[_Try]) -> bool:
    """Whether the last few attempts were no better than what was there before."""
    if len(tried) <= PATIENCE:
        return False
    before = max(each.good for each in tried[:-PATIENCE])
    return max(each.good for each in tried[-PATIENCE:]) <= before + WORTH_IT


def _patches(mesh: TexturedMesh, piece: Piece, count: int, area: float) -> list[Patch]:
    """Split a component; faces are those of the mesh."""
    if count == 1:
        return [Patch(piece.face_ids, np.ones(len(piece.face_ids), dtype=bool))]
    patches = split_surface(
        mesh.vertices[piece.vertex_ids], piece.faces, count=count, overlap=OVERLAP * area**0.5
    )
    return [Patch(piece.face_ids[patch.faces], patch.home) for patch in patches]


def _pages(mesh: TexturedMesh, patches: Sequence[Patch], lay: Lay, area: float) -> _Try:
    laid = [lay_page(mesh, patch, lay) for patch in patches]
    pages = [page for page, _, _ in laid]
    good = sum(good_area(mesh, page) for page in pages) / area
    return _Try(
        patches, pages, [flat.method for _, flat, _ in laid], [why for _, _, why in laid], good
    )
