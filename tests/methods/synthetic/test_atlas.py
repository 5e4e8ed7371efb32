"""Atlases: islands that do not overlap, fill the square and hide the material."""

import numpy as np
import pytest

from shapemorph.kernels.painting import cover
from shapemorph.methods.synthetic.atlas import lay_out_atlas
from shapemorph.methods.synthetic.shapes import material_map
from shapemorph.methods.synthetic.triangulation import triangulate

GUTTER = 1 / 128


def _atlas(shape, seed=0):
    mapped = material_map(shape, size=70.0, offset=0.0, tilt=0.0)
    mesh = triangulate(mapped, mapped.deformed, faces=4000, rng=np.random.default_rng(1))
    rng = np.random.default_rng(seed)
    return mesh, lay_out_atlas(mesh.vertices, mesh.faces, gutter=GUTTER, rng=rng)


def _signed_areas(triangles):
    side, other = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return 0.5 * (side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0])


def _island_count(uv):
    """Connected sets of faces that share texture coordinates along an edge."""
    import trimesh

    keys = np.unique(np.round(uv.reshape(-1, 2), 9), axis=0, return_inverse=True)[1]
    faces = keys.reshape(-1, 3)
    pairs = trimesh.graph.face_adjacency(faces)
    return len(trimesh.graph.connected_components(pairs, nodes=np.arange(len(faces))))


@pytest.mark.parametrize("shape", ["bulge", "hole", "tube"])
def test_islands_lie_in_the_square_apart_and_face_up(shape):
    _, uv = _atlas(shape)
    areas = _signed_areas(uv)
    assert uv.min() >= GUTTER - 1e-9
    assert uv.max() <= 1 - GUTTER + 1e-9
    assert (areas > 0).all()
    width = 2000
    covered = np.mean(cover(uv * width - 0.5, width, width) >= 0)
    assert covered == pytest.approx(areas.sum(), rel=0.003)  # less where islands overlap
    assert 0.4 < covered < 0.8
    assert 8 <= _island_count(uv) < 60


def test_texels_are_about_equally_dense():
    mesh, uv = _atlas("bulge")
    corners = mesh.vertices[mesh.faces]
    space = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    density = np.sqrt(_signed_areas(uv) / space)
    assert np.percentile(density, 5) > 0.6 * np.percentile(density, 95)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("shape", ["rigid", "bulge"])
def test_islands_are_turned_every_way_and_break_the_material(shape, seed):
    mesh, uv = _atlas(shape, seed)
    material = mesh.material[mesh.faces]
    sides = [corners[:, 1] - corners[:, 0] for corners in (uv, material)]
    turn = [side[:, 0] + 1j * side[:, 1] for side in sides]
    turn = turn[0] / turn[1]
    assert abs(np.mean(turn / np.abs(turn))) < 0.7  # 1 if all were turned alike
    known = np.concatenate([material.reshape(-1, 2), np.ones((3 * len(uv), 1))], axis=1)
    flat = uv.reshape(-1, 2)
    _, residual, _, _ = np.linalg.lstsq(known, flat, rcond=None)
    # Both axes together, since how the square is turned is chance; 0 for material coordinates.
    assert residual.sum() / len(flat) > 0.5 * flat.var(axis=0).sum()
