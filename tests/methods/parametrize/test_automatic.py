import numpy as np
import pytest

from shapemorph.methods.distortion import singular_values
from shapemorph.methods.parametrize import automatic
from shapemorph.methods.parametrize.overlap import overlap_share
from shapemorph.methods.parametrize.slim import parametrise_slim
from shapemorph.methods.parametrize.untangle import untangle


def sheet(rows=24, cols=30):
    number = np.arange(rows * cols).reshape(rows, cols)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    y, x = np.divmod(np.arange(rows * cols), cols)
    return np.stack([x, y, 0.02 * x * y], axis=1).astype(np.float64), faces


def choose(vertices, faces):
    return automatic.flatten_automatically(
        vertices, faces, most_lost=0.005, most_anisotropy=2.0, most_reduced=4.0
    )


def test_a_sound_sheet_gets_the_boundary_first_map():
    flattening, why = choose(*sheet())
    assert flattening.method == "bff"
    assert flattening.flips == 0
    assert flattening.overlap_share == 0
    assert "not taken" not in why


def test_flips_are_mended_and_counted():
    vertices, faces = sheet()
    plane = vertices[:, :2].copy()
    plane[[200, 201, 430]] += [[2.0, 0.3], [-1.5, 0.9], [0.0, 1.8]]
    assert singular_values(vertices, faces, plane).flips > 3
    flattening = automatic.mend_and_judge(vertices, faces, plane, "bff")
    assert flattening.flips == 0
    assert flattening.mended > 3
    assert "mended" in flattening.describe()


def test_mending_moves_only_what_lies_near_a_flip():
    vertices, faces = sheet()
    plane = vertices[:, :2].copy()
    plane[200] += [2.0, 0.3]
    moved = np.flatnonzero((untangle(vertices, faces, plane) != plane).any(axis=1))
    assert len(moved) > 0
    assert np.linalg.norm(plane[moved] - vertices[200, :2], axis=1).max() < 8


def test_a_map_that_overlaps_is_replaced_and_the_reason_says_so():
    """A ribbon that winds one and a half times around lies on itself when it keeps its rim."""
    angle, height = np.meshgrid(np.linspace(0, 3 * np.pi, 150), np.linspace(3, 5, 9))
    points = np.stack(
        [height * np.cos(angle), height * np.sin(angle), 0.3 * angle], axis=-1
    ).reshape(-1, 3)
    number = np.arange(9 * 150).reshape(9, 150)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    flattening, why = choose(points, faces[:, [0, 2, 1]])
    assert flattening.method == "harmonic"
    assert flattening.overlap_share < 0.005
    assert "not taken: boundary-first map" in why


def test_overlap_is_the_share_covered_twice():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    plane = np.concatenate([square, square * [0.5, 1.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    assert overlap_share(plane, faces) == pytest.approx(0.5, abs=0.01)
    assert overlap_share(plane[:4], faces[:2]) == 0.0


def plain_with_a_pole(height):
    """A disk of 20 mm radius with a closed pole of 1 mm radius in its middle."""
    radius = np.concatenate([np.geomspace(20, 1, 24), np.full(8 * height, 1.0), [0.5]])
    up = np.concatenate([np.zeros(24), np.linspace(0, height, 8 * height + 1)[1:], [height]])
    angle = np.arange(24) * (2 * np.pi / 24)
    rings = [
        np.stack([r * np.cos(angle), r * np.sin(angle), np.full(24, z)], axis=1)
        for r, z in zip(radius, up, strict=True)
    ]
    number = np.arange(24 * len(rings)).reshape(len(rings), 24)
    a, b = number[:-1].ravel(), np.roll(number[:-1], -1, axis=1).ravel()
    c, d = np.roll(number[1:], -1, axis=1).ravel(), number[1:].ravel()
    top = np.stack([number[-1], np.roll(number[-1], -1), np.full(24, number.size)], axis=1)
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1), top])
    return np.concatenate([*rings, [[0.0, 0.0, height]]]), faces


def test_a_squeezed_corner_is_better_than_shear_all_over():
    """No map shows a thin pole and the plain around it evenly without shear."""
    vertices, faces = plain_with_a_pole(height=6)
    slim = automatic.mend_and_judge(vertices, faces, parametrise_slim(vertices, faces), "slim")
    assert slim.anisotropy > 2.0
    flattening, why = choose(vertices, faces)
    assert flattening.method == "bff"
    assert flattening.reduced > 4.0
    assert flattening.anisotropy < 1.3
    assert "of the area lies badly" in why
