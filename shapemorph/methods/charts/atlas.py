"""Lay a surface flat in as few charts as its shape allows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import DataError, StageError
from shapemorph.core.mesh import TexturedMesh
from shapemorph.methods.charts.mosaic import Page
from shapemorph.methods.charts.splitting import Patch, split_surface
from shapemorph.methods.distortion import local_scale, singular_values, weighted_quantile
from shapemorph.methods.gluing import face_areas
from shapemorph.methods.parametrize.automatic import Flattening
from shapemorph.methods.parametrize.choice import place
from shapemorph.methods.parametrize.disk import Piece, cut_pieces

Lay = Callable[[Floats, Ints, Flattening | None], tuple[Flattening, str]]
"""Flattens a disk with holes, vertices (V, 3) and faces (F, 3), and says why so; the last
argument is its boundary-first map where that has been made already."""

Laid = tuple[Page, Flattening, str]
"""A page, its map, and why it is mapped so."""

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
    """One component in some number of pages; the good share is that of the trial maps."""

    pages: list[Page]
    flattenings: list[Flattening]
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
    trial : callable
        Makes the boundary-first map: the number of pages is chosen by it.
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
    methods = tuple(flat.method for each in tries for flat in each.flattenings)
    return Atlas(pages, methods, "; ".join(notes))


def cut_patch(mesh: TexturedMesh, patch: Patch) -> tuple[Piece, Bools]:
    """Take the largest connected piece of some faces of a mesh, and which of it is at home.

    Raises
    ------
    DataError
        If there are no faces.
    """
    if len(patch.faces) == 0:
        raise DataError(f"{mesh.name} has too few faces for so many charts: use a finer mesh")
    whole = cut_pieces(mesh.vertices, mesh.faces[patch.faces], name=mesh.name)[0]
    piece = Piece(whole.vertex_ids, whole.faces, patch.faces[whole.face_ids])
    return piece, patch.home[whole.face_ids]


def lay_piece(
    mesh: TexturedMesh,
    piece: Piece,
    home: Bools,
    lay: Lay,
    made: tuple[Page, Flattening] | None = None,
) -> Laid:
    """Flatten a piece of a mesh.

    Parameters
    ----------
    mesh : TexturedMesh
    piece : Piece
    home : (M,) bool
        Its triangles that no other page shows better.
    lay : callable
    made : (Page, Flattening), optional
        Its boundary-first map.

    Raises
    ------
    DataError, StageError
        If it cannot lie flat.
    """
    page, trial = made or (None, None)
    flattening, why = lay(mesh.vertices[piece.vertex_ids], piece.faces, trial)
    if page is not None and flattening is trial:
        return page, flattening, why
    return Page(piece, place(mesh.vertices, piece, flattening), home), flattening, why


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
            parts = _parts(mesh, piece, count, area)
            laid = [lay_piece(mesh, part, home, trial) for part, home in parts]
            found = _weigh(mesh, laid, area)
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
    trials = zip(chosen.pages, chosen.flattenings, strict=True)
    settled = [lay_piece(mesh, made[0].piece, made[0].home, lay, made) for made in trials]
    return _Try(*_columns(settled), chosen.good)


def _gains_nothing(tried: Sequence[_Try]) -> bool:
    """Whether the last few attempts were no better than what was there before."""
    if len(tried) <= PATIENCE:
        return False
    before = max(each.good for each in tried[:-PATIENCE])
    return max(each.good for each in tried[-PATIENCE:]) <= before + WORTH_IT


def _parts(mesh: TexturedMesh, piece: Piece, count: int, area: float) -> list[tuple[Piece, Bools]]:
    """Split a component into overlapping pieces."""
    if count == 1:
        return [(piece, np.ones(len(piece.face_ids), dtype=bool))]
    patches = split_surface(
        mesh.vertices[piece.vertex_ids], piece.faces, count=count, overlap=OVERLAP * area**0.5
    )
    return [cut_patch(mesh, Patch(piece.face_ids[patch.faces], patch.home)) for patch in patches]


def _weigh(mesh: TexturedMesh, laid: Sequence[Laid], area: float) -> _Try:
    good = sum(good_area(mesh, page) for page, _, _ in laid) / area
    return _Try(*_columns(laid), good)


def _columns(laid: Sequence[Laid]) -> tuple[list[Page], list[Flattening], list[str]]:
    pages, flattenings, notes = zip(*laid, strict=True)
    return list(pages), list(flattenings), list(notes)
