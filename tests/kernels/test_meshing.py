"""Loops of triangulation against what they promise."""

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from shapemorph.kernels.meshing import dither, flip_edges


def test_dithering_follows_the_density_and_spreads_evenly():
    density = np.tile(np.linspace(0.05, 0.25, 200), (150, 1))
    chosen = dither(density, np.full(density.shape, 0.5))
    for columns in (slice(0, 60), slice(140, 200)):
        wanted = density[:, columns].sum()
        assert abs(chosen[:, columns].sum() - wanted) < 0.03 * wanted + 10
    rows, cols = np.nonzero(chosen[:, 140:])
    points = np.stack([rows, cols], axis=1)
    nearest = cKDTree(points).query(points, k=2)[0][:, 1]
    random = np.random.default_rng(0).random((150, 60)) < density[:, 140:]
    places = np.argwhere(random)
    assert np.mean(nearest) > 1.3 * np.mean(cKDTree(places).query(places, k=2)[0][:, 1])


def test_no_point_falls_where_the_density_is_zero():
    density = np.full((40, 60), 0.2)
    density[10:30, 20:50] = 0.0
    assert not dither(density, np.full(density.shape, 0.5))[10:30, 20:50].any()


def _stretched():
    plane = np.random.default_rng(4).uniform(size=(300, 2))
    mesh = Delaunay(plane)
    space = np.concatenate([plane * [3.0, 1.0], np.zeros((300, 1))], axis=1)
    return plane, space, mesh


def test_flipping_in_a_stretched_plane_gives_its_delaunay_triangles():
    plane, space, mesh = _stretched()
    faces, flips = flip_edges(
        space,
        plane,
        mesh.simplices.astype(np.int64),
        mesh.neighbors.astype(np.int64),
        np.zeros(300, dtype=bool),
        100,
    )
    oracle = Delaunay(space[:, :2]).simplices
    assert flips == 0
    assert {frozenset(face) for face in faces.tolist()} == {
        frozenset(face) for face in oracle.tolist()
    }


def test_edges_between_locked_vertices_stay():
    plane, space, mesh = _stretched()
    faces, _ = flip_edges(
        space,
        plane,
        mesh.simplices.astype(np.int64),
        mesh.neighbors.astype(np.int64),
        np.ones(300, dtype=bool),
        100,
    )
    assert np.array_equal(faces, mesh.simplices)
