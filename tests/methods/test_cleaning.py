"""Triangle soups become one clean, oriented, connected surface, and everything is counted."""

import numpy as np
import pytest
import trimesh

from shapemorph.core.errors import DataError
from shapemorph.methods.cleaning import clean_surface, degenerate, repeated, weld

RULES = {"weld_tolerance": 1e-6, "flatness": 1e-9, "least_piece": 0.02}


def sheet(columns=7, rows=5):
    """An oblique, curved sheet of (rows - 1) x (columns - 1) x 2 triangles."""
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    height = 0.1 * x**2 + 0.05 * x * y
    vertices = np.stack([x + 0.3 * y, y, height], axis=-1).reshape(-1, 3).astype(float)
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (
        index[:-1, :-1].ravel(),
        index[:-1, 1:].ravel(),
        index[1:, 1:].ravel(),
        index[1:, :-1].ravel(),
    )
    faces = np.stack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)], axis=1).reshape(-1, 3)
    return vertices, faces


def band(turns, around=24, across=3):
    """A closed band of quads that is turned over `turns` times half a turn."""
    u = np.arange(around) * 2 * np.pi / around
    w = np.linspace(-0.3, 0.3, across)
    angle = turns * u / 2
    radius = 1 + w[None] * np.cos(angle)[:, None]
    vertices = np.stack(
        [radius * np.cos(u)[:, None], radius * np.sin(u)[:, None], w * np.sin(angle)[:, None]], -1
    ).reshape(-1, 3)
    faces = []
    for i in range(around):
        for j in range(across - 1):
            last = i == around - 1 and turns % 2 == 1
            here = [i * across + j, i * across + j + 1]
            there = [
                (i + 1) % around * across + (across - 1 - k if last else k) for k in (j, j + 1)
            ]
            faces += [[here[0], there[0], there[1]], [here[0], there[1], here[1]]]
    return vertices, np.array(faces)


def is_oriented(faces):
    """Whether no directed edge occurs twice."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    return len(np.unique(np.stack([start, end], 1), axis=0)) == len(start)


def edge_counts(faces):
    edges = np.sort(np.stack([faces.ravel(), np.roll(faces, -1, axis=1).ravel()], 1), axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1]


def test_a_clean_sheet_stays_as_it_is():
    vertices, faces = sheet()
    clean = clean_surface(vertices, faces, **RULES)
    np.testing.assert_array_equal(clean.vertices, vertices)
    np.testing.assert_array_equal(clean.faces, faces)
    np.testing.assert_array_equal(clean.corners.ravel(), np.arange(faces.size))
    counts = clean.counts
    assert (counts.components, counts.boundary_loops, counts.euler_characteristic) == (1, 1, 1)
    assert counts.welded_vertices == counts.degenerate_faces == counts.split_vertices == 0


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e5])
def test_a_soup_of_single_triangles_is_welded_whatever_the_scale(scale):
    vertices, faces = sheet()
    soup = scale * vertices[faces].reshape(-1, 3)
    clean = clean_surface(soup, np.arange(len(soup)).reshape(-1, 3), **RULES)
    assert len(clean.vertices) == len(vertices)
    assert clean.counts.welded_vertices == len(soup) - len(vertices)
    assert clean.counts.euler_characteristic == 1
    np.testing.assert_array_equal(clean.vertices[clean.faces], soup.reshape(-1, 3, 3))


def test_rounding_of_single_precision_does_not_part_the_faces():
    vertices, faces = sheet()
    soup = vertices[faces].reshape(-1, 3)
    soup += np.random.default_rng(6).uniform(-2e-7, 2e-7, soup.shape)
    clean = clean_surface(soup, np.arange(len(soup)).reshape(-1, 3), **RULES)
    assert len(clean.vertices) == len(vertices)
    assert clean.counts.boundary_loops == 1


def test_vertices_within_the_tolerance_are_one_and_the_first_stays():
    vertices = np.array([[0, 0, 0], [10, 0, 0], [10, 1e-7, 0], [10, 1e-3, 0], [-0.0, 0, 0]])
    kept, merged = weld(vertices, tolerance=1e-6)
    np.testing.assert_array_equal(kept, [0, 1, 3])
    np.testing.assert_array_equal(merged, [0, 1, 1, 2, 0])


def test_corners_remember_where_they_come_from_through_every_step():
    vertices, faces = sheet()
    label = np.arange(faces.size).reshape(faces.shape)
    turned = faces.copy()
    turned[::4] = turned[::4][:, [0, 2, 1]]
    label[::4] = label[::4][:, [0, 2, 1]]
    order = np.random.default_rng(2).permutation(len(faces))
    dirty = np.concatenate([turned[order], [[3, 3, 4]], turned[:1]])
    clean = clean_surface(vertices, dirty, **RULES)
    assert len(clean.faces) == len(faces)
    np.testing.assert_array_equal(
        vertices[dirty].reshape(-1, 3)[clean.corners], clean.vertices[clean.faces]
    )
    assert is_oriented(clean.faces)
    assert clean.counts.turned_faces == len(faces[::4])


def test_unreferenced_vertices_go_even_where_they_are_not_finite():
    vertices, faces = sheet()
    clean = clean_surface(np.concatenate([np.full((2, 3), np.nan), vertices]), faces + 2, **RULES)
    assert clean.counts.unreferenced_vertices == 2
    np.testing.assert_array_equal(clean.vertices, vertices)


def test_faces_without_height_are_degenerate_and_slender_ones_are_not():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1e-4, 0], [1, 1, 0]], dtype=float)
    faces = np.array([[0, 1, 2], [0, 1, 1], [0, 2, 3], [0, 2, 4]])
    np.testing.assert_array_equal(
        degenerate(vertices, faces, flatness=1e-9), [True, True, False, False]
    )


def test_the_same_face_in_either_sense_counts_once():
    faces = np.array([[0, 1, 2], [3, 4, 5], [1, 2, 0], [2, 1, 0], [3, 4, 6]])
    np.testing.assert_array_equal(repeated(faces), [False, False, True, True, False])


def test_a_fin_on_a_sheet_is_cut_off_and_the_sheet_keeps_its_edge():
    vertices, faces = sheet()
    tip = len(vertices)
    fin = np.array([[faces[20, 0], faces[20, 2], tip]])
    clean = clean_surface(
        np.concatenate([vertices, [[2.0, 2.0, 9.0]]]),
        np.concatenate([fin, faces]),
        **(RULES | {"least_piece": 0.5}),
    )
    np.testing.assert_array_equal(clean.vertices[clean.faces], vertices[faces])
    assert clean.counts.non_manifold_faces == 1
    assert clean.counts.components == 2
    assert clean.counts.dropped_faces == 1
    assert clean.counts.boundary_loops == 1


def test_of_three_equal_flaps_at_one_edge_the_flattest_pair_stays_together():
    vertices = np.array([[0, 0, 0], [0, 1, 0], [1, 0.5, 0.1], [-1, 0.5, 0.1], [0, 0.5, 1.00499]])
    rules = RULES | {"least_piece": 0.5}
    clean = clean_surface(vertices, np.array([[0, 1, 4], [1, 0, 2], [0, 1, 3]]), **rules)
    np.testing.assert_array_equal(clean.vertices, vertices[:4])
    assert clean.counts.non_manifold_faces == 1
    assert clean.counts.dropped_faces == 1


def test_a_vertex_where_two_fans_meet_is_cut_in_two():
    vertices, faces = sheet(7, 6)
    middle = 2 * 7 + 3
    corner_cells = [  # two cells that touch only in the middle vertex
        (faces == middle).any(axis=1) & (faces == middle - 8).any(axis=1),
        (faces == middle).any(axis=1) & (faces == middle + 8).any(axis=1),
    ]
    punched = faces[~(corner_cells[0] | corner_cells[1])]
    clean = clean_surface(vertices, punched, **RULES)
    assert clean.counts.split_vertices == 1
    assert clean.counts.components == 1
    assert len(clean.vertices) == len(vertices) + 1
    assert clean.counts.boundary_loops == 2
    assert clean.counts.euler_characteristic == 0


def test_most_of_the_area_keeps_its_sense():
    vertices, faces = sheet()
    turned = faces.copy()
    turned[:-5] = turned[:-5][:, ::-1]
    clean = clean_surface(vertices, turned, **RULES)
    normal = np.cross(*(np.diff(clean.vertices[clean.faces], axis=1).transpose(1, 0, 2)))
    assert (normal[:, 2] < 0).all()


def test_the_largest_piece_is_kept_by_area_not_by_count():
    vertices, faces = sheet()
    big = np.array([[0, 0, 50.0], [90, 0, 50], [0, 80, 50], [90, 80, 51]])
    joined = np.concatenate([vertices, big])
    clean = clean_surface(
        joined, np.concatenate([faces, len(vertices) + np.array([[0, 1, 2], [1, 3, 2]])]), **RULES
    )
    np.testing.assert_array_equal(clean.vertices, big)
    assert clean.counts.components == 2
    assert clean.counts.dropped_faces == len(faces)


def test_pieces_that_are_no_crumbs_are_all_kept():
    vertices, faces = sheet()
    second, crumb = (
        vertices + np.array([0, 0, 50.0]),
        np.array([[0, 0, 90.0], [0.1, 0, 90], [0, 0.1, 90]]),
    )
    count = len(vertices)
    joined = np.concatenate([faces, faces + count, [[2 * count, 2 * count + 1, 2 * count + 2]]])
    clean = clean_surface(np.concatenate([vertices, second, crumb]), joined, **RULES)
    np.testing.assert_array_equal(clean.vertices[clean.faces[len(faces) :]], second[faces])
    assert (clean.counts.components, clean.counts.kept_components) == (3, 2)
    assert clean.counts.dropped_faces == 1
    assert (clean.counts.boundary_loops, clean.counts.euler_characteristic) == (2, 2)


def test_a_one_sided_band_is_cut_across_and_a_two_sided_one_is_not():
    plain = clean_surface(*band(2), **RULES).counts
    assert (plain.one_sided_edges, plain.boundary_loops, plain.euler_characteristic) == (0, 2, 0)
    moebius = clean_surface(*band(1), **RULES)
    assert moebius.counts.one_sided_edges > 0
    assert moebius.counts.components == 1
    assert is_oriented(moebius.faces)
    assert len(moebius.faces) == len(band(1)[1])


@pytest.mark.parametrize(
    ("shape", "euler"),
    [(trimesh.creation.icosphere(subdivisions=2), 2), (trimesh.creation.torus(3, 1), 0)],
)
def test_closed_surfaces_have_no_loop_and_the_euler_number_of_their_genus(shape, euler):
    counts = clean_surface(np.array(shape.vertices), np.array(shape.faces), **RULES).counts
    assert counts.boundary_loops == 0
    assert counts.euler_characteristic == euler


@pytest.mark.parametrize("seed", range(25))
def test_random_soups_become_oriented_manifolds(seed):
    random = np.random.default_rng(seed)
    vertices = random.normal(size=(14, 3))
    faces = random.integers(0, 14, (60, 3))
    clean = clean_surface(vertices, faces, **RULES)
    assert edge_counts(clean.faces).max() <= 2
    assert is_oriented(clean.faces)
    again = clean_surface(clean.vertices, clean.faces, **RULES)
    oracle = trimesh.Trimesh(clean.vertices, clean.faces, process=False)
    assert clean.counts.euler_characteristic == oracle.euler_number
    assert again.counts.degenerate_faces == again.counts.duplicate_faces == 0


def test_cleaning_gives_the_same_bits_again():
    random = np.random.default_rng(5)
    vertices, faces = random.normal(size=(40, 3)), random.integers(0, 40, (200, 3))
    one, other = (clean_surface(vertices, faces, **RULES) for _ in range(2))
    np.testing.assert_array_equal(one.corners, other.corners)
    np.testing.assert_array_equal(one.faces, other.faces)


def test_nothing_with_an_area_is_an_error():
    vertices, faces = sheet()
    with pytest.raises(DataError, match="triangles with an area"):
        clean_surface(vertices * [1, 0, 0], faces, **RULES)
