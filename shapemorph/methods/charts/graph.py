"""Distances along the edges of a mesh."""

from typing import Any

import numpy as np

from shapemorph.core.arrays import Floats, Ints


def edge_graph(vertices: Floats, faces: Ints) -> Any:
    """Make the graph of the edges of a mesh, with their lengths.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)

    Returns
    -------
    scipy.sparse.csr_array
        (V, V), each edge once, in one direction.
    """
    from scipy.sparse import csr_array

    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    low, high = ends.min(axis=1), ends.max(axis=1)
    _, first = np.unique(low * len(vertices) + high, return_index=True)
    low, high = low[first], high[first]
    length = np.linalg.norm(vertices[low] - vertices[high], axis=1)
    # an edge of no length would be no edge: a tiny one keeps its ends together
    length = np.maximum(length, 1e-12 * max(float(length.max(initial=0.0)), 1e-300))
    return csr_array((length, (low, high)), shape=(len(vertices), len(vertices)))


def rim_vertices(faces: Ints) -> Ints:
    """Vertices of edges that have one face only."""
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    key = ends.min(axis=1) * (int(faces.max()) + 1) + ends.max(axis=1)
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    alone: Ints = np.unique(ends[first[count == 1]])
    return alone


def nearest_source(graph: Any, sources: Ints) -> tuple[Floats, Ints]:
    """Find how far each vertex is from the nearest of some sources, and from which.

    Returns
    -------
    distance : (V,)
        Infinite where no source can be reached.
    source : (V,)
        Position in `sources` of the nearest; -1 where none can be reached.
    """
    from scipy.sparse.csgraph import dijkstra

    distance, _, nearest = dijkstra(
        graph, directed=False, indices=sources, min_only=True, return_predecessors=True
    )
    place = np.full(len(distance) + 1, -1, dtype=np.int64)
    place[sources] = np.arange(len(sources))
    return distance, place[np.where(np.isfinite(distance), nearest, len(distance))]
