"""Texture atlases: islands of faces, laid flat, turned and packed into a square."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.kernels.painting import cover, spread

RASTER = 256
"""Cells across the square when islands are packed."""


def lay_out_atlas(
    vertices: Floats, faces: Ints, *, gutter: float, rng: np.random.Generator
) -> Floats:
    """Texture coordinates (F, 3, 2) of every corner, in islands that fill the unit square.

    Each island holds faces that look about the same way and is projected along their mean
    normal, turned at random and packed; one scale for all, so that texels are about equally
    dense everywhere.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    gutter : float
        Free space around each island, as a share of the square.
    rng : numpy.random.Generator
    """
    corners = vertices[faces]
    normals = _unit_normals(corners)
    label = _islands(corners.mean(axis=1), normals, faces, rng)
    flat = np.zeros((len(faces), 3, 2))
    for island in range(label.max() + 1):
        mine = label == island
        laid = _laid_flat(corners[mine], normals[mine], rng)
        flat[mine] = laid - laid.min(axis=(0, 1))
    scale, places = _pack([flat[label == k] for k in range(label.max() + 1)], gutter)
    packed: Floats = flat * scale + places[label][:, None, :]
    return packed


def _unit_normals(corners: Floats) -> Floats:
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    unit: Floats = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return unit


def _islands(centres: Floats, normals: Floats, faces: Ints, rng: np.random.Generator) -> Ints:
    """Label the faces (F,) by island, none with a face steeper than 78 degrees on its own."""
    size = np.ptp(centres, axis=0).max()
    features = np.concatenate([centres / size, 0.25 * normals], axis=1)
    count = 10
    while True:
        label = _connected(_clusters(features, count, rng), faces)
        means = np.stack([np.bincount(label, weights=n) for n in normals.T], axis=1)
        means = means / np.linalg.norm(means, axis=1, keepdims=True)
        steepest = np.einsum("fk,fk->f", normals, means[label]).min()
        if steepest > 0.2 or count > 60:
            return label
        count = count * 3 // 2


def _clusters(features: Floats, count: int, rng: np.random.Generator) -> Ints:
    """Lloyd's clusters of features (F, D), from seeds each far from those before."""
    from scipy.spatial import cKDTree

    sample = features[:: max(1, len(features) // 5000)]
    seeds = [int(rng.integers(len(sample)))]
    distance = np.full(len(sample), np.inf)
    for _ in range(count - 1):
        distance = np.minimum(distance, ((sample - sample[seeds[-1]]) ** 2).sum(axis=1))
        seeds.append(int(np.argmax(distance)))
    centres = sample[seeds]
    for _ in range(6):
        _, label = cKDTree(centres).query(sample)
        total = np.bincount(label, minlength=count)
        sums = [np.bincount(label, weights=f, minlength=count) for f in sample.T]
        centres = np.stack(sums, axis=1) / np.maximum(total, 1)[:, None]
    return np.asarray(cKDTree(centres).query(features)[1], dtype=np.int64)


def _connected(label: Ints, faces: Ints) -> Ints:
    """Split clusters into connected pieces, join crumbs to a neighbour, number from 0."""
    first, second = _face_pairs(faces)
    for _ in range(8):
        pieces = _pieces(label, first, second)
        crumbs = np.bincount(pieces)[pieces] < max(8, len(faces) // 2000)
        if not crumbs.any():
            break
        for one, other in ((first, second), (second, first)):
            join = crumbs[one] & ~crumbs[other]
            pieces[one[join]] = pieces[other[join]]
        label = pieces
    numbered: Ints = np.unique(pieces, return_inverse=True)[1]
    return numbered


def _face_pairs(faces: Ints) -> tuple[Ints, Ints]:
    """Faces (E,) and (E,) that share an edge."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(faces)), 3)
    order = np.lexsort((owner, edges[:, 1], edges[:, 0]))
    edges, owner = edges[order], owner[order]
    shared = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    return owner[shared], owner[shared + 1]


def _pieces(label: Ints, first: Ints, second: Ints) -> Ints:
    """Give every connected piece of equal label a number of its own (F,)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    same = label[first] == label[second]
    links = coo_array(
        (np.ones(same.sum()), (first[same], second[same])), shape=(len(label), len(label))
    )
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def _laid_flat(corners: Floats, normals: Floats, rng: np.random.Generator) -> Floats:
    """Corners (N, 3, 2) seen along the mean normal, at the best of a few random turns."""
    up = normals.mean(axis=0)
    up /= np.linalg.norm(up)
    side = np.cross(up, rng.standard_normal(3))
    side /= np.linalg.norm(side)
    plane = corners @ np.stack([side, np.cross(up, side)], axis=1)
    turns = [_rotation(angle) for angle in rng.uniform(0, 2 * np.pi, 4)]
    boxes = [float(np.prod(np.ptp((plane @ turn).reshape(-1, 2), axis=0))) for turn in turns]
    laid: Floats = plane @ turns[int(np.argmin(boxes))]
    return laid


def _rotation(angle: float) -> Floats:
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def _pack(islands: list[Floats], gutter: float) -> tuple[float, Floats]:
    """Largest scale that is found, and places (K, 2), at which islands (N, 3, 2) fit the square."""
    area = sum(float(_areas(island).sum()) for island in islands)
    scale = np.sqrt(0.8 / area)
    while True:
        places = _places([island * scale for island in islands], gutter)
        if places is not None:
            return float(scale), places
        scale *= 0.97


def _areas(triangles: Floats) -> Floats:
    """Areas (N,) of plane triangles (N, 3, 2)."""
    side, other = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    area: Floats = 0.5 * np.abs(side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0])
    return area


def _places(islands: list[Floats], gutter: float) -> Floats | None:
    """Places (K, 2) of islands in the unit square, the largest first; None where one is left over.

    Each goes to the lowest free place of a raster of the square, then the leftmost.
    """
    from scipy.signal import fftconvolve

    margin = int(np.ceil(gutter * RASTER))
    taken = np.ones((RASTER, RASTER), dtype=bool)
    taken[margin : RASTER - margin, margin : RASTER - margin] = False
    footprints = [_footprint(island) for island in islands]
    places = np.zeros((len(islands), 2))
    order = sorted(range(len(islands)), key=lambda k: (-int(footprints[k].sum()), k))
    for k in order:
        mask = footprints[k]
        if max(mask.shape) > RASTER:
            return None
        overlap = fftconvolve(taken.astype(np.float64), mask[::-1, ::-1], mode="valid")
        row, col = np.unravel_index(int(np.argmax(overlap < 0.5)), overlap.shape)
        if overlap[row, col] >= 0.5:
            return None
        here = np.zeros_like(taken)
        here[row : row + mask.shape[0], col : col + mask.shape[1]] = mask
        taken |= spread(here, margin) >= 0
        places[k] = (np.array([col, row]) + 1.5) / RASTER
    return places


def _footprint(island: Floats) -> Bools:
    """Cells of the raster that an island (N, 3, 2) at the origin touches, one cell all round."""
    height, width = np.ceil(island.max(axis=(0, 1)) * RASTER).astype(np.int64)[::-1] + 3
    inside = cover(island * RASTER + 1.0, int(height), int(width)) >= 0
    touched: Bools = spread(inside, 1) >= 0
    return touched
