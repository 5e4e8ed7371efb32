import numpy as np
import pytest

from shapemorph.methods.charts.graph import edge_graph, nearest_source
from shapemorph.methods.charts.splitting import split_surface
from shapemorph.methods.parametrize.disk import boundary_loops
from tests.methods.charts.shapes import ball, tube


def test_shapes_are_outward():
    for vertices, faces in (ball(), tube()):
        a, b, c = vertices[faces[:, 0]], vertices[faces[:, 1]], vertices[faces[:, 2]]
        middle = (a + b + c) / 3 - [0, 0, vertices[:, 2].mean()]
        assert (np.sum(np.cross(b - a, c - a) * middle, axis=1) > 0).all()


def test_distance_along_a_tube_goes_round_it():
    vertices, faces = tube(steps=3, around=200)
    distance, source = nearest_source(edge_graph(vertices, faces), np.array([0]))
    assert distance[100] == pytest.approx(np.pi * 10, rel=1e-3)
    assert (source == 0).all()


def test_vertices_that_no_source_reaches_have_none():
    vertices, faces = tube(steps=3, around=8)
    both = np.concatenate([vertices, vertices + 100])
    graph = edge_graph(both, np.concatenate([faces, faces + len(vertices)]))
    distance, source = nearest_source(graph, np.array([0]))
    assert np.isinf(distance[len(vertices) :]).all()
    assert (source[len(vertices) :] == -1).all()


@pytest.mark.parametrize("shape", [ball, tube])
@pytest.mark.parametrize("count", [2, 3, 5])
def test_every_face_has_one_home_and_patches_overlap(shape, count):
    vertices, faces = shape()
    patches = split_surface(vertices, faces, count=count, overlap=3.0)
    assert len(patches) == count
    homes = np.zeros(len(faces), dtype=int)
    shown = np.zeros(len(faces), dtype=int)
    for patch in patches:
        homes[patch.faces[patch.home]] += 1
        shown[patch.faces] += 1
        assert not patch.home.all()
    assert (homes == 1).all()
    assert 0.02 < (shown > 1).mean() < 0.9


def test_patches_are_of_similar_size():
    vertices, faces = ball()
    corners = vertices[faces]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    patches = split_surface(vertices, faces, count=4, overlap=0.0)
    shares = [area[patch.faces[patch.home]].sum() / area.sum() for patch in patches]
    assert min(shares) > 0.15
    assert max(shares) < 0.35


def test_a_patch_reaches_as_far_over_its_seam_as_asked():
    vertices, faces = tube(steps=60, around=90, radius=10.0, length=60.0)
    for patch in split_surface(vertices, faces, count=2, overlap=6.0):
        ours = vertices[np.unique(faces[patch.faces[patch.home]])]
        beyond = np.unique(faces[patch.faces[~patch.home]])
        distance = np.linalg.norm(vertices[beyond][:, None] - ours, axis=2).min(axis=1)
        assert 5.0 < distance.max() <= 6.0  # an edge is 1 long


def test_a_tube_is_split_along_its_length():
    vertices, faces = tube(steps=41, around=120, radius=10.0, length=60.0)
    for patch in split_surface(vertices, faces, count=2, overlap=0.0):
        home = faces[patch.faces[patch.home]]
        assert np.ptp(vertices[home][..., 2]) == 60.0  # from rim to rim
        assert len(boundary_loops(home, name="half")) == 1
        assert len(home) == pytest.approx(len(faces) / 2, rel=0.1)
