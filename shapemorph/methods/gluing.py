"""Which faces of a triangle soup are neighbours: gluing, orientation, pieces, loops.

A side is one edge of one face: side ``3 f + k`` runs from corner k of face f to the next.
A seam is a pair of sides that are glued.
"""

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.kernels.components import connect
from shapemorph.kernels.facets import measure_triangles
from shapemorph.kernels.pair_order import order_sides

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_MANY = 12  # sides at one edge beyond which pairs are not compared one by one


def glue(vertices: Floats, faces: Ints) -> tuple[Ints, Ints]:
    """Pair the sides that lie on one edge; at crowded edges keep the best pair.

    Where more than two faces share an edge, the flattest pair is kept together, leaving aside
    faces of patches less than half as large as the second largest, and the others are cut
    loose there.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)

    Returns
    -------
    seams : (S, 2)
        Glued sides.
    loose : (K,)
        Faces that were cut loose at a crowded edge.
    """
    order, first, count = sides_by_edge(faces)
    pairs = first[count == 2]
    seams = np.stack([order[pairs], order[pairs + 1]], axis=1)
    crowded = np.flatnonzero(count > 2)
    if len(crowded) == 0:
        return seams, np.zeros(0, dtype=np.int64)
    patch_area = _patch_areas(vertices, faces, seams)
    extra, loose = [], []
    for edge in crowded:
        sides = order[first[edge] : first[edge] + count[edge]]
        pair = _best_pair(vertices, faces, sides, patch_area)
        extra.append(pair)
        loose.append(np.setdiff1d(sides, pair) // 3)
    return np.concatenate([seams, np.array(extra)]), np.unique(np.concatenate(loose))


def orient(areas: Floats, faces: Ints, seams: Ints) -> tuple[Bools, Ints]:
    """Find faces to turn over so that neighbours agree, and seams where they cannot.

    Parameters
    ----------
    areas : (F,)
        The sense of most of the area of each piece is kept.
    faces : (F, 3)
    seams : (S, 2)

    Returns
    -------
    flip : (F,)
        Faces to turn over.
    seams : (S', 2)
        Without those across which a one-sided surface (Moebius) has to be cut.
    """
    start = faces.ravel()
    clash = start[seams[:, 0]] == start[seams[:, 1]]
    if not clash.any():
        return np.zeros(len(faces), dtype=np.bool_), seams
    one, other = seams[:, 0] // 3, seams[:, 1] // 3
    piece = pieces(len(faces), seams)
    flip = _parity(one, other, clash, piece)
    share = np.bincount(piece, np.where(flip, areas, -areas))
    flip ^= share[piece] > 0
    return flip, seams[flip[one] ^ flip[other] == clash]


def pieces(face_count: int, seams: Ints) -> Ints:
    """Label (F,) the faces by connected piece."""
    label: Ints = connect(seams[:, 0] // 3, seams[:, 1] // 3, face_count)[1]
    return label


def separate(faces: Ints, seams: Ints) -> tuple[Ints, Ints]:
    """Give every fan of glued faces its own vertex.

    Cuts crowded edges and bow-ties: faces that are not neighbours share no vertex.

    Returns
    -------
    faces : (F, 3)
        In new vertex numbers.
    source : (V',)
        Old vertex of each new one, ascending: where nothing is cut the order is kept.
    """
    start = faces.ravel()
    here, there = seams[:, 0], seams[:, 1]
    here_end, there_end = _next(here), _next(there)
    agree = start[here] == start[there_end]
    fans, fan = connect(
        np.concatenate([here, here_end]),
        np.concatenate([np.where(agree, there_end, there), np.where(agree, there, there_end)]),
        len(start),
    )
    source = np.empty(fans, dtype=np.int64)
    source[fan] = start
    order = np.argsort(source, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return rank[fan].reshape(-1, 3), source[order]


def crowding(faces: Ints, seams: Ints) -> Ints:
    """Find faces that still share an edge with others than their glued neighbour.

    A cut that ends inside the surface does not part the vertices at its ends: the faces on
    one of its sides must go.

    Parameters
    ----------
    faces : (F, 3)
        In the vertices of :func:`separate`.
    seams : (S, 2)

    Returns
    -------
    (K,)
        Faces to remove: at each such edge all but the glued pair, or all but one.
    """
    order, first, count = sides_by_edge(faces)
    glued = np.zeros(faces.size, dtype=np.bool_)
    glued[seams.ravel()] = True
    joined = np.add.reduceat(glued[order], first)
    excess = []
    for edge in np.flatnonzero((count > 2) | ((count == 2) & (joined < 2))):
        sides = order[first[edge] : first[edge] + count[edge]]
        loose = sides[~glued[sides]] if joined[edge] else sides[1:]
        excess.append(loose // 3)
    return np.unique(np.concatenate(excess)) if excess else np.zeros(0, dtype=np.int64)


def boundary_loops(faces: Ints, seams: Ints) -> int:
    """Count closed chains of sides that are not glued, on a mesh that is a manifold."""
    free = np.ones(faces.size, dtype=np.bool_)
    free[seams.ravel()] = False
    rim = np.flatnonzero(free)
    if len(rim) == 0:
        return 0
    ends = np.stack([faces.ravel()[rim], faces.ravel()[_next(rim)]], axis=1)
    _, compact = np.unique(ends, return_inverse=True)
    here, there = np.ascontiguousarray(compact.reshape(-1, 2).T)
    return int(connect(here, there, int(compact.max()) + 1)[0])


def euler_characteristic(faces: Ints, seams: Ints) -> int:
    """Vertices minus edges plus faces, on a mesh that is a manifold and uses all vertices."""
    return int(faces.max()) + 1 - (faces.size - len(seams)) + len(faces)


def _next(side: Ints) -> Ints:
    """Corner at the end of a side (a side is numbered as the corner where it starts)."""
    following: Ints = np.where(side % 3 == 2, side - 2, side + 1)
    return following


def sides_by_edge(faces: Ints) -> tuple[Ints, Ints, Ints]:
    """Sides sorted by edge; start and length of each edge's run."""
    order, first = order_sides(np.ascontiguousarray(faces), int(faces.max(initial=-1)) + 1)
    return order, first, np.diff(first, append=len(order))


def _graph(one: Ints, other: Ints, weight: Floats, size: int) -> "csr_array[np.float64]":
    from scipy.sparse import coo_array

    return coo_array((weight, (one, other)), shape=(size, size)).tocsr()


def _patch_areas(vertices: Floats, faces: Ints, seams: Ints) -> Floats:
    """(F,) area of the patch that each face belongs to when crowded edges are left open."""
    patch = pieces(len(faces), seams)
    total: Floats = np.bincount(patch, face_areas(vertices, faces)).astype(np.float64)
    return total[patch]


def face_areas(vertices: Floats, faces: Ints) -> Floats:
    """(F,) area of every face."""
    points, corners = np.ascontiguousarray(vertices), np.ascontiguousarray(faces)
    areas: Floats = measure_triangles(points, corners)[0]
    return areas


def _best_pair(vertices: Floats, faces: Ints, sides: Ints, patch_area: Floats) -> Ints:
    """Pick two of the sides at a crowded edge: the flattest pair among those of large patches."""
    ranked = sides[np.argsort(-patch_area[sides // 3], kind="stable")][:_MANY]
    runner_up = patch_area[ranked[1] // 3]
    ranked = ranked[patch_area[ranked // 3] >= 0.5 * runner_up]
    pairs = np.array(list(combinations(ranked, 2)))
    wing = _wings(vertices, faces, pairs)
    bend = np.einsum("nc,nc->n", wing[:, 0], wing[:, 1])  # -1 where the pair is flat
    return np.asarray(pairs[np.argmin(bend)])


def _wings(vertices: Floats, faces: Ints, sides: Ints) -> Floats:
    """Return unit vectors (..., 3) in each side's face, away from its edge and square to it."""
    flat = faces.ravel()
    start, end = vertices[flat[sides]], vertices[flat[_next(sides)]]
    tip = vertices[flat[_next(_next(sides))]]
    along = (end - start) / np.linalg.norm(end - start, axis=-1, keepdims=True)
    wing = (tip - start) - np.sum((tip - start) * along, axis=-1, keepdims=True) * along
    unit: Floats = wing / np.maximum(np.linalg.norm(wing, axis=-1, keepdims=True), 1e-300)
    return unit


def _parity(one: Ints, other: Ints, clash: Bools, piece: Ints) -> Bools:
    """Turn each face so that it agrees with its parent in a spanning tree of its piece."""
    count = len(piece)
    parent, disagree = _spanning_tree(one, other, clash, piece)
    flip = disagree
    up = parent
    for _ in range(int(count).bit_length()):  # pointer doubling up the tree
        flip = flip ^ flip[up]
        up = up[up]
    return flip


def _spanning_tree(one: Ints, other: Ints, clash: Bools, piece: Ints) -> tuple[Ints, Bools]:
    """Parent of every face (roots are their own) and whether it disagrees with it."""
    count = len(piece)
    from scipy.sparse.csgraph import breadth_first_order

    _, root = np.unique(piece, return_index=True)
    # A hub above all roots makes one tree of the forest.
    links = _graph(
        np.concatenate([one, np.full(len(root), count)]),
        np.concatenate([other, root]),
        np.ones(len(one) + len(root)),
        count + 1,
    )
    _, above = breadth_first_order(links, count, directed=False)
    parent = above[:count].astype(np.int64)
    parent[root] = root
    disagree = np.zeros(count, dtype=np.bool_)
    disagree[one[(parent[one] == other) & clash]] = True
    disagree[other[(parent[other] == one) & clash]] = True
    return parent, disagree
