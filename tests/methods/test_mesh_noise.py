from types import SimpleNamespace

import numpy as np
import pytest

from shapemorph.methods.mesh_noise import rough_vertex_noise, vertex_noise
from shapemorph.methods.vertex_normals import vertex_normals


def _noise(vertices, faces, samples):
    normals = vertex_normals(vertices, faces, passes=2)
    return vertex_noise(vertices, faces, normals, samples=samples)


def sheet(height, rows=60, cols=80):
    """Irregular triangulated height field (V, 3), (F, 3) with edges of about 1."""
    rng = np.random.default_rng(5)
    i, j = np.meshgrid(np.arange(rows), np.arange(cols), indexing="ij")
    flat = np.stack([j, i], axis=-1) + rng.uniform(-0.2, 0.2, (rows, cols, 2))
    corner = (i * cols + j)[:-1, :-1].ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + cols + 1], axis=1),
            np.stack([corner, corner + cols + 1, corner + cols], axis=1),
        ]
    )
    x, y = flat.reshape(-1, 2).T
    return np.stack([x, y, height(x, y)], axis=1), faces


SURFACES = {
    "plane": lambda x, y: 0.3 * x - 0.2 * y,
    "cylinder": lambda x, _: np.sqrt(100.0**2 - (x - 40) ** 2),
    "kink": lambda x, _: 0.8 * np.abs(x - 40),
    "waves": lambda x, y: 3 * np.sin(x / 12) * np.cos(y / 15),
}


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("noise", [0.02, 0.1])
def test_noise_is_told_from_curvature_and_kinks(name, noise):
    vertices, faces = sheet(SURFACES[name])
    vertices = vertices + np.random.default_rng(6).normal(0, noise, vertices.shape)
    found = _noise(vertices, faces, samples=1000)
    assert found == pytest.approx(noise, rel=0.06)  # 1000 overlapping samples: 2 to 3 %


def test_a_few_vertices_tell_the_noise_roughly():
    vertices, faces = sheet(SURFACES["waves"])
    vertices = vertices + np.random.default_rng(8).normal(0, 0.04, vertices.shape)
    mesh = SimpleNamespace(vertices=vertices, faces=faces)
    assert rough_vertex_noise(mesh) == pytest.approx(0.04, rel=0.15)


def test_noise_is_not_biased():
    vertices, faces = sheet(SURFACES["cylinder"])
    rng = np.random.default_rng(23)
    found = [
        _noise(vertices + rng.normal(0, 0.05, vertices.shape), faces, samples=1000)
        for _ in range(8)
    ]
    assert np.mean(found) == pytest.approx(0.05, rel=0.012)  # 2 to 3 % each


@pytest.mark.parametrize("name", ["plane", "kink"])
def test_surface_without_noise_has_none(name):
    vertices, faces = sheet(SURFACES[name])
    assert _noise(vertices, faces, samples=500) < 1e-9


def test_noise_scales_with_the_unit_and_ignores_the_pose():
    vertices, faces = sheet(SURFACES["waves"])
    vertices = vertices + np.random.default_rng(7).normal(0, 0.03, vertices.shape)
    turned = vertices @ np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]]) * 1000 + 5e4
    expected = 1000 * _noise(vertices, faces, samples=300)
    assert _noise(turned, faces, samples=300) == pytest.approx(expected, rel=1e-6)


def test_mesh_too_small_to_tell_claims_no_noise():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.1]])
    assert _noise(vertices, np.array([[0, 1, 2], [1, 3, 2]]), samples=100) == 0
