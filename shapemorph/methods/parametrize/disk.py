"""Cut a mesh down to one piece that can lie flat, or say why it cannot."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.kernels.components import connect
from shapemorph.methods.gluing import face_areas, sides_by_edge


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A connected piece of a mesh whose vertices have one fan of faces each.

    Attributes
    ----------
    vertex_ids : (N,) int64
        Vertex of the mesh that each vertex of the piece is a copy of.
    faces : (M, 3) int64
        In vertices of the piece.
    face_ids : (M,) int64
        Face of the mesh that each one is.
    """

    vertex_ids: Ints
    faces: Ints
    face_ids: Ints


def pair_half_edges(faces: Ints, *, name: str) -> tuple[Ints, Ints]:
    """Find which half-edges share an edge and which have no partner.

    Half-edge ``3 f + c`` runs from corner c of face f to the next.

    Returns
    -------
    pairs : (P, 2)
        Half-edges of one edge.
    single : (B,)
        Half-edges on the boundary.

    Raises
    ------
    DataError
        If an edge has more than two faces, or two that run the same way along it.
    """
    start = faces.ravel()
    order, first, count = sides_by_edge(faces)
    if count.max() > 2:
        raise DataError(
            f"{name}: {int((count > 2).sum())} edges have more than two faces: "
            "remove the extra faces in a mesh editor"
        )
    twice = first[count == 2]
    pairs = np.stack([order[twice], order[twice + 1]], axis=1)
    clashes = int((start[pairs[:, 0]] == start[pairs[:, 1]]).sum())
    if clashes:
        raise DataError(
            f"{name}: faces on both sides of {clashes} edges face opposite ways: "
            "unify the face orientation in a mesh editor"
        )
    return pairs, np.sort(order[first[count == 1]])


def cut_piece(vertices: Floats, faces: Ints, *, name: str) -> Piece:
    """Take the piece with the largest area; see :func:`cut_pieces`."""
    return cut_pieces(vertices, faces, name=name)[0]


def cut_pieces(vertices: Floats, faces: Ints, *, name: str) -> list[Piece]:
    """Part a surface into connected pieces, also where only a vertex holds it together.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    name : str
        What errors call the mesh.

    Returns
    -------
    list of Piece
        The largest area first.
    """
    pairs, _ = pair_half_edges(faces, name=name)
    one, other = pairs[:, 0], pairs[:, 1]
    rows = np.concatenate([one, _next_corner(one)])
    cols = np.concatenate([_next_corner(other), other])
    fan = connect(rows, cols, faces.size)[1]
    return _pieces(vertices, faces, pairs, fan.reshape(-1, 3))


def _next_corner(corner: Ints) -> Ints:
    following: Ints = np.where(corner % 3 == 2, corner - 2, corner + 1)
    return following


def _pieces(vertices: Floats, faces: Ints, pairs: Ints, fans: Ints) -> list[Piece]:
    number, label = connect(pairs[:, 0] // 3, pairs[:, 1] // 3, len(faces))
    area = np.bincount(label, face_areas(vertices, faces), minlength=number)
    by_label = np.argsort(label, kind="stable")
    ends = np.cumsum(np.bincount(label, minlength=number))
    return [
        _piece(faces, fans, by_label[(ends[k - 1] if k else 0) : ends[k]])
        for k in np.argsort(-area, kind="stable")
    ]


def _piece(faces: Ints, fans: Ints, face_ids: Ints) -> Piece:
    corners = fans[face_ids]
    present = np.zeros(int(fans.max()) + 1, dtype=np.bool_)
    present[corners] = True
    vertex_ids = np.empty(len(present), dtype=np.int64)
    vertex_ids[corners] = faces[face_ids]
    renamed = np.cumsum(present) - 1
    return Piece(vertex_ids[present], renamed[corners], face_ids)


def boundary_loops(faces: Ints, *, name: str) -> list[Ints]:
    """List the boundary loops, each in the direction of its faces.

    Every vertex must have one fan of faces (see :func:`cut_piece`).
    """
    _, single = pair_half_edges(faces, name=name)
    start = faces.ravel()[single]
    following = dict(zip(start.tolist(), faces.ravel()[_next_corner(single)].tolist(), strict=True))
    loops = []
    while following:
        first = vertex = next(iter(following))
        loop = []
        while vertex in following:
            loop.append(vertex)
            vertex = following.pop(vertex)
        if vertex != first:
            raise DataError(f"{name}: the boundary touches itself at a vertex")
        loops.append(np.array(loop, dtype=np.int64))
    return loops


def require_disk(faces: Ints, loops: list[Ints], *, name: str) -> None:
    """Refuse what no plane can hold in one piece even with its holes filled.

    Parameters
    ----------
    faces : (F, 3)
        One connected piece, numbered without gaps.
    loops : list of (K,)
        Its boundary loops.
    name : str

    Raises
    ------
    DataError
        For closed surfaces and surfaces with handles.
    """
    if not loops:
        raise DataError(
            f"{name}: expected a surface with a border, got a closed one: remove the part that "
            "the pattern does not need (open it), or set flatten.method=orthographic to measure "
            "the side that one axis sees"
        )
    edges = (faces.size + sum(len(loop) for loop in loops)) // 2
    euler = int(faces.max()) + 1 - edges + len(faces)
    handles = (2 - euler - len(loops)) // 2
    if handles:
        raise DataError(
            f"{name}: expected a disk with holes, got {handles} handle(s): cut or fill the "
            "tunnels in a mesh editor, or set flatten.method=orthographic"
        )
