"""Which part of the deformed surface shows what a chart of the reference shows."""

import logging
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.core.image import CalibratedImage, SurfacePoints
from shapemorph.core.laws import Dots
from shapemorph.core.mesh import TexturedMesh
from shapemorph.methods.charts.graph import edge_graph, nearest_source
from shapemorph.methods.charts.mosaic import faces_of_pages, page_bounds, take_page
from shapemorph.methods.charts.splitting import Patch
from shapemorph.methods.features import Features
from shapemorph.methods.first_pairs import (
    Budget,
    Side,
    budgets,
    measure_side,
    pair_features,
    side_features,
)
from shapemorph.methods.gluing import face_areas
from shapemorph.methods.surface_lookup import locate, positions, project
from shapemorph.methods.threads import run_at_once

_log = logging.getLogger(__name__)

LEAST_GROUP = 12  # pairs between two pages that are not chance
REACHED = 98.0  # percentile of the reference page that lies within reach of a pair, ...
MOST_TIMES_MEDIAN = 4.0  # ... if pairs lie about evenly (then it is 2.4 times the median): what
# is farther away, such as a patch without pattern, goes to the page whose pairs are nearest
STRETCH = 90.0  # percentile of the local stretch that the reach allows for
NEIGHBOURS = 7  # with which the local stretch is measured
MARGIN = 1.3  # times the reach
LEAST_REACH, MOST_REACH = 0.04, 0.3  # of the square root of the area of the deformed page
ENCLOSED = 0.25  # of the region: larger gaps in it are not filled


@dataclass(frozen=True, slots=True, eq=False)
class _Leaf:
    """A page as a picture, and its pattern if it has one."""

    image: CalibratedImage
    side: Side | None


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """Pairs between two meshes."""

    reference: SurfacePoints
    deformed: SurfacePoints

    def __len__(self) -> int:
        return len(self.reference.face)

    def on(self, faces: Ints) -> "_Places":
        """Those on some faces of the reference."""
        chosen = np.isin(self.reference.face, faces)
        return _Places(*(_chosen(side, chosen) for side in (self.reference, self.deformed)))


class Counterparts:
    """The deformed surface, asked for its parts that show the pages of a reference.

    The pages of both states were made independently. Features of every page of the one
    are matched with those of every page of the other; what lies around the pairs of a
    page, on the deformed surface, is its counterpart.

    Parameters
    ----------
    mesh : TexturedMesh
        Deformed.
    image : CalibratedImage
        Its pages, side by side.
    ratio : float
        Of the best to the second best match, see ``match.ratio``.
    """

    def __init__(self, mesh: TexturedMesh, image: CalibratedImage, *, ratio: float) -> None:
        self.mesh = mesh
        self._ratio = ratio
        self._leaves = _leaves(image, "deformed")
        self._graph = edge_graph(mesh.vertices, mesh.faces)
        self._features: list[Features | None] = []
        self._places = _joined([])

    def learn(self, image: CalibratedImage) -> None:
        """Match features of every page of a reference with those of every deformed page.

        Parameters
        ----------
        image : CalibratedImage
            Its pages, side by side; pairs by other pages that were learnt before are kept.
        """
        ours = _leaves(image, "reference")
        one = next((leaf.side for leaf in ours if leaf.side), None)
        other = next((leaf.side for leaf in self._leaves if leaf.side), None)
        if not (one and other):
            return
        mine, their = budgets(one, other)
        self._features = self._features or _all_features(self._leaves, their)
        found = [self._places]
        for leaf, features in zip(ours, _all_features(ours, mine), strict=True):
            groups = _groups(leaf, features, self._leaves, self._features, self._ratio)
            found += [group for group in groups if len(group) >= LEAST_GROUP]
        self._places = _joined(found)

    def patches(self, reference: TexturedMesh, image: CalibratedImage) -> list[Patch]:
        """Find the counterpart of every page of the reference by the pairs that are known.

        Parameters
        ----------
        reference : TexturedMesh
        image : CalibratedImage
            Its pages, side by side; need not be those that the pairs were found by.

        Returns
        -------
        list of Patch
            Of faces of the deformed mesh, one for each page; a page without pairs gets the
            first page of the deformed mesh, where it will match nothing.
        """
        pages = faces_of_pages(image.chart)
        found = [self._places.on(page) for page in pages]
        distances = np.stack([_distance_from(self._graph, self.mesh, each) for each in found])
        nearest = distances.min(axis=0)
        patches = []
        for number, (page, places) in enumerate(zip(pages, found, strict=True)):
            if len(places) < LEAST_GROUP:
                _log.warning("chart %d of the reference matches nothing", number)
                faces = np.unique(self._leaves[0].image.chart.face_ids)
            else:
                reach, most = _reach(reference, page, self.mesh, places)
                far = distances[number]
                inside = (far <= reach) | ((far <= nearest) & (far <= most))
                whole = np.asarray(inside[self.mesh.faces].all(axis=1))
                faces = np.flatnonzero(_filled(self.mesh, whole))
            patches.append(Patch(faces, np.ones(len(faces), dtype=bool)))
        return patches

    def pairs(self, image: CalibratedImage, deformed: CalibratedImage) -> Dots:
        """Show the pairs that are known in pictures whose pages correspond one to one, px."""
        sides = [page_bounds(each.chart, each.image.shape[1]) for each in (image, deformed)]
        source, target = [np.empty((0, 2))], [np.empty((0, 2))]
        for number, (left, right) in enumerate(zip(*sides, strict=True)):
            ours = project(take_page(image, number), self._places.reference)
            theirs = project(take_page(deformed, number), self._places.deformed)
            both = np.isfinite(ours).all(axis=1) & np.isfinite(theirs).all(axis=1)
            source.append(ours[both] + [left[0], 0])
            target.append(theirs[both] + [right[0], 0])
        return Dots(np.concatenate(source), np.concatenate(target))


def _leaves(image: CalibratedImage, name: str) -> list[_Leaf]:
    """Take the pages apart and measure the speckle of each."""
    pages = [take_page(image, number) for number in range(image.chart.page_count)]
    names = [f"{name} (chart {k})" for k in range(len(pages))]
    sides = run_at_once(lambda k: _side(pages[k], names[k]), range(len(pages)))
    return [_Leaf(page, side) for page, side in zip(pages, sides, strict=True)]


def _side(page: CalibratedImage, name: str) -> Side | None:
    try:
        return measure_side(page.image, name)
    except StageError as error:
        _log.warning("%s", error)
        return None


def _all_features(leaves: Sequence[_Leaf], budget: Budget) -> list[Features | None]:
    return run_at_once(lambda leaf: side_features(leaf.side, budget) if leaf.side else None, leaves)


def _groups(
    leaf: _Leaf,
    features: Features | None,
    theirs: Sequence[_Leaf],
    their_features: Sequence[Features | None],
    ratio: float,
) -> Iterator[_Places]:
    """Pairs of one of our pages with each of theirs."""
    for other, found in zip(theirs, their_features, strict=True):
        if features and found and other.side:
            pairs = pair_features(features, found, std=other.side.std, ratio=ratio)
            yield _lifted(leaf.image, pairs.source, other.image, pairs.target)


def _chosen(points: SurfacePoints, chosen: Bools) -> SurfacePoints:
    return SurfacePoints(points.face[chosen], points.barycentric[chosen])


def _lifted(
    left: CalibratedImage, source: Floats, right: CalibratedImage, target: Floats
) -> _Places:
    one, other = locate(left, source), locate(right, target)
    both = (one.face >= 0) & (other.face >= 0)
    return _Places(_chosen(one, both), _chosen(other, both))


def _joined(groups: Sequence[_Places]) -> _Places:
    def all_of(sides: list[SurfacePoints]) -> SurfacePoints:
        face = np.concatenate([np.empty(0, np.int64), *(side.face for side in sides)])
        weights = np.concatenate([np.empty((0, 3)), *(side.barycentric for side in sides)])
        return SurfacePoints(face, weights)

    return _Places(all_of([g.reference for g in groups]), all_of([g.deformed for g in groups]))


def _distance_from(graph: Any, mesh: TexturedMesh, places: _Places) -> Floats:
    """Distance (V,) along a mesh from the pairs of a page; infinite without any."""
    if len(places) == 0:
        return np.full(len(mesh.vertices), np.inf)
    return nearest_source(graph, _nearest_vertices(mesh, places.deformed))[0]


def _reach(
    reference: TexturedMesh, page: Ints, deformed: TexturedMesh, places: _Places
) -> tuple[float, float]:
    """Distance from its pairs within which the deformed surface belongs to a page, mm.

    The second goes for what is nearer to these pairs than to those of any other page.
    """
    before = positions(reference, places.reference)
    stretch = _stretch(before, positions(deformed, places.deformed))
    reach = MARGIN * stretch * _gap(reference, page, places.reference)
    size = stretch * float(face_areas(reference.vertices, reference.faces[page]).sum()) ** 0.5
    return float(np.clip(reach, LEAST_REACH * size, MOST_REACH * size)), MOST_REACH * size


def _gap(mesh: TexturedMesh, page: Ints, places: SurfacePoints) -> float:
    """Distance from the pairs within which nearly all of a page lies, but for large gaps."""
    faces = mesh.faces[page]
    distance, _ = nearest_source(edge_graph(mesh.vertices, faces), _nearest_vertices(mesh, places))
    known = distance[np.unique(faces)]
    median, far = np.percentile(known[np.isfinite(known)], [50.0, REACHED])
    return float(min(far, MOST_TIMES_MEDIAN * median))


def _nearest_vertices(mesh: TexturedMesh, places: SurfacePoints) -> Ints:
    corner = places.barycentric.argmax(axis=1)
    nearest: Ints = np.unique(mesh.faces[places.face, corner])
    return nearest


def _stretch(before: Floats, after: Floats) -> float:
    """Large value of the local stretch between neighbouring pairs."""
    from scipy.spatial import cKDTree

    found = cKDTree(before).query(before, k=min(NEIGHBOURS, len(before)))
    distance, near = np.asarray(found[0]), np.asarray(found[1])
    apart = distance > 0
    ratio = np.linalg.norm(after[near] - after[:, None], axis=2)[apart] / distance[apart]
    return float(np.percentile(ratio, STRETCH)) if len(ratio) else 1.0


def _filled(mesh: TexturedMesh, inside: Bools) -> Bools:
    """Fill the gaps that a region encloses; what lies around it stays outside."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    outside = np.flatnonzero(~inside)
    if len(outside) == 0:
        return inside
    corners = mesh.faces[outside].ravel()
    owner = np.repeat(np.arange(len(outside)), 3)
    shape = (len(outside), len(mesh.vertices))
    touches = coo_array((np.ones(len(owner), np.int8), (owner, corners)), shape=shape).tocsr()
    joined = coo_array(touches.astype(np.int32) @ touches.astype(np.int32).T)
    _, label = connected_components(joined, directed=False)
    areas = np.bincount(label, face_areas(mesh.vertices, mesh.faces[outside]))
    region = float(face_areas(mesh.vertices, mesh.faces[inside]).sum())
    on_rim = _at_rim(mesh, outside, label.astype(np.int64), len(areas))
    enclosed = (areas < ENCLOSED * region) & (np.arange(len(areas)) != areas.argmax()) & ~on_rim
    filled = inside.copy()
    filled[outside[enclosed[label]]] = True
    return filled


def _at_rim(mesh: TexturedMesh, faces: Ints, label: Ints, count: int) -> Bools:
    """Which groups of faces touch the border of the mesh."""
    ends = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    low, high = ends.min(axis=1), ends.max(axis=1)
    _, back, number = np.unique(
        low * len(mesh.vertices) + high, return_inverse=True, return_counts=True
    )
    alone = (number[back] == 1).reshape(3, -1).any(axis=0)[faces]
    touched: Bools = np.bincount(label, alone, minlength=count) > 0
    return touched
