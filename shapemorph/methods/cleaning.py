"""From the triangles of a file to a clean, oriented surface of one piece or a few."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.kernels.facets import measure_triangles
from shapemorph.kernels.pair_order import order_pairs
from shapemorph.kernels.welding import weld_along
from shapemorph.methods.gluing import (
    boundary_loops,
    crowding,
    euler_characteristic,
    face_areas,
    glue,
    orient,
    pieces,
    separate,
)


@dataclass(frozen=True, slots=True)
class CleaningCounts:
    """What was found and mended.

    Attributes
    ----------
    welded_vertices, unreferenced_vertices, degenerate_faces, duplicate_faces : int
        Removed.
    non_manifold_faces : int
        Cut loose at an edge with more than two faces, or removed where that left a crowd.
    split_vertices : int
        Added where faces met at a vertex or a crowded edge without being neighbours.
    turned_faces : int
        Turned over to agree with their neighbours.
    one_sided_edges : int
        Cut because the surface has no two sides.
    components, kept_components, dropped_faces : int
        Connected pieces, those of them that are large, and faces of the others.
    boundary_loops, euler_characteristic : int
        Of what is kept.
    """

    welded_vertices: int
    unreferenced_vertices: int
    degenerate_faces: int
    duplicate_faces: int
    non_manifold_faces: int
    split_vertices: int
    turned_faces: int
    one_sided_edges: int
    components: int
    kept_components: int
    dropped_faces: int
    boundary_loops: int
    euler_characteristic: int


@dataclass(frozen=True, slots=True, eq=False)
class CleanSurface:
    """A surface whose faces know where they come from.

    Attributes
    ----------
    vertices : (V, 3) float64
    faces : (F, 3) int64
    corners : (F, 3) int64
        Corner ``3 f + k`` of the original faces that each corner is, to carry along what
        belongs to corners.
    counts : CleaningCounts
    """

    vertices: Floats
    faces: Ints
    corners: Ints
    counts: CleaningCounts


def clean_surface(
    vertices: Floats, faces: Ints, *, weld_tolerance: float, flatness: float, least_piece: float
) -> CleanSurface:
    """Weld, remove what is no surface, cut what is no manifold, orient, keep the large pieces.

    Parameters
    ----------
    vertices : (V, 3)
        Finite where faces use them.
    faces : (F, 3)
        Valid rows of `vertices`.
    weld_tolerance : float
        Vertices closer than this share of the bounding box's diagonal are one (and never
        farther apart than a hundredth of the median edge).
    flatness : float
        Faces whose height is below this share of their longest side are degenerate.
    least_piece : float
        Share of the area that a connected piece must have to be kept.

    Returns
    -------
    CleanSurface

    Raises
    ------
    DataError
        If no face has an area.
    """
    used, triangles = _only_used(len(vertices), faces)
    points = vertices[used]
    first, merged = weld(points, tolerance=_weld_distance(points, triangles, weld_tolerance))
    points, triangles = points[first], merged[triangles]

    sound = np.flatnonzero(~degenerate(points, triangles, flatness=flatness))
    if len(sound) == 0:
        raise DataError(
            f"expected triangles with an area, got {len(faces)} faces of which all are points or "
            "lines: check what was exported"
        )
    fresh = sound[~repeated(triangles[sound])]
    kept, piece = fresh, _large_pieces(points, triangles[fresh], least_piece)
    while len(piece.crowding):
        kept = np.delete(kept, piece.crowding)
        piece = _large_pieces(points, triangles[kept], least_piece)
    counts = CleaningCounts(
        welded_vertices=len(used) - len(first),
        unreferenced_vertices=len(vertices) - len(used),
        degenerate_faces=len(faces) - len(sound),
        duplicate_faces=len(sound) - len(fresh),
        non_manifold_faces=piece.loose_faces + len(fresh) - len(kept),
        split_vertices=len(piece.source) - int(np.count_nonzero(np.bincount(piece.source))),
        turned_faces=piece.turned_faces,
        one_sided_edges=piece.one_sided_edges,
        components=piece.components,
        kept_components=piece.kept_components,
        dropped_faces=len(kept) - len(piece.faces),
        boundary_loops=boundary_loops(piece.faces, piece.glued),
        euler_characteristic=euler_characteristic(piece.faces, piece.glued),
    )
    corners = 3 * kept[piece.corners // 3] + piece.corners % 3
    return CleanSurface(points[piece.source], piece.faces, corners, counts)


def weld(vertices: Floats, *, tolerance: float) -> tuple[Ints, Ints]:
    """Merge vertices at the same position.

    Parameters
    ----------
    vertices : (V, 3)
    tolerance : float
        Largest distance of two that are one; chains of such pairs are one too.

    Returns
    -------
    kept : (W,)
        The first of each group, in the order of the file.
    merged : (V,)
        Row of `kept` for every vertex.
    """
    place = _along_an_axis(vertices)
    order = np.argsort(place, kind="stable")
    count, merged = weld_along(vertices, place, order, tolerance)
    kept = np.empty(count, dtype=np.int64)
    kept[merged[::-1]] = np.arange(len(vertices))[::-1]
    return kept, merged


def degenerate(vertices: Floats, faces: Ints, *, flatness: float) -> Bools:
    """Faces with a repeated vertex, or lower than a share of their longest side."""
    areas, longest = measure_triangles(vertices, faces)
    flat: Bools = 2.0 * areas <= flatness * longest**2
    return flat


def repeated(faces: Ints) -> Bools:
    """Faces with the same three vertices as an earlier one, whatever their sense."""
    count = int(faces.max(initial=-1)) + 1
    one, two, three = faces.T
    low = np.minimum(np.minimum(one, two), three)
    high = np.maximum(np.maximum(one, two), three)
    rest = (one + two + three - low - high) * count + high
    order = order_pairs(low, rest, count)
    low, rest = low[order], rest[order]
    again = np.zeros(len(faces), dtype=np.bool_)
    again[order[1:]] = (low[1:] == low[:-1]) & (rest[1:] == rest[:-1])
    return again


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """The large connected pieces: their faces, where their vertices and corners come from.

    `glued` are their pairs of sides on one edge, `crowding` the faces (as given) that must go
    before they are manifolds.
    """

    faces: Ints
    source: Ints
    corners: Ints
    glued: Ints
    crowding: Ints
    loose_faces: int
    turned_faces: int
    one_sided_edges: int
    components: int
    kept_components: int


def _large_pieces(vertices: Floats, faces: Ints, least: float) -> _Pieces:
    areas = face_areas(vertices, faces)
    seams, loose = glue(vertices, faces)
    flip, agreed = orient(areas, faces, seams)
    label = pieces(len(faces), agreed)
    total = np.bincount(label, areas, minlength=1)
    large = total >= least * total.sum()
    large[np.argmax(total)] = True
    keep = large[label]

    slots = np.where(flip[keep, None], [0, 2, 1], [0, 1, 2])
    corners = 3 * np.flatnonzero(keep)[:, None] + slots
    rank = np.cumsum(keep) - 1
    inside = agreed[keep[agreed[:, 0] // 3]]
    side = np.where(flip[inside // 3], 2 - inside % 3, inside % 3)
    glued = 3 * rank[inside // 3] + side
    separated, source = separate(faces.ravel()[corners], glued)
    return _Pieces(
        separated,
        source,
        corners,
        glued,
        crowding=np.flatnonzero(keep)[crowding(separated, glued)],
        loose_faces=len(loose),
        turned_faces=int(flip[keep].sum()),
        one_sided_edges=len(seams) - len(agreed),
        components=len(total),
        kept_components=int(large.sum()),
    )


def _only_used(count: int, faces: Ints) -> tuple[Ints, Ints]:
    """Vertices that faces refer to, and the faces in their numbers."""
    refers = np.zeros(count, dtype=np.bool_)
    refers[faces.ravel()] = True
    return np.flatnonzero(refers), (np.cumsum(refers) - 1)[np.ascontiguousarray(faces)]


def _weld_distance(vertices: Floats, faces: Ints, share: float) -> float:
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    edges = np.linalg.norm(vertices[faces[:, 1]] - vertices[faces[:, 0]], axis=1)
    longer = edges[edges > 0]
    typical = float(np.median(longer)) if len(longer) else diagonal
    return min(share * diagonal, 0.01 * typical)


def _along_an_axis(vertices: Floats) -> Floats:
    """Positions along the oblique axis, of three, along which the vertices spread most.

    No face of a box and no row of a regular grid is square to any of them.
    """
    one = np.array([0.4613, 0.6217, 0.6330])
    other = np.cross(one, [0.0, 0.0, 1.0])
    x, y, z = (vertices - vertices.mean(axis=0)).T
    places = [a * x + b * y + c * z for a, b, c in map(_unit, (one, other, np.cross(one, other)))]
    return max(places, key=np.ptp)


def _unit(vector: Floats) -> Floats:
    unit: Floats = vector / np.linalg.norm(vector)
    return unit
