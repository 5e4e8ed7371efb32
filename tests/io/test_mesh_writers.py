"""Written meshes, read back by another library and by our own reader."""

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.mesh import coloured_mesh, textured_mesh
from shapemorph.io.mesh_writers import encode_grey_png, write_mesh
from shapemorph.io.meshes import read_mesh


def _mesh(textures=1):
    """A bent strip of 4 x 2 squares; each texture is a picture of its own, not square."""
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.arange(5.0), np.arange(3.0))
    vertices = np.column_stack([7 * x.ravel(), 5 * y.ravel(), 0.3 * x.ravel() ** 2])
    corner = np.arange(15).reshape(3, 5)
    a, b, c, d = (
        part.ravel()
        for part in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1])
    )
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    uv = np.round(rng.uniform(0.05, 0.95, (16, 3, 2)), 6)
    pictures = tuple(
        np.round(rng.random((20 + 10 * k, 30)), 2).astype(np.float32) for k in range(textures)
    )
    return textured_mesh(vertices, faces, uv, np.arange(16) % textures, pictures, name="strip")


def _coloured():
    mesh = _mesh()
    grey = np.round(np.random.default_rng(1).random((16, 3)) * 255) / 255
    return coloured_mesh(mesh.vertices, mesh.faces, grey, name="strip")


def _corners(mesh):
    """Corner positions with their texture coordinates, in an order of their own."""
    places = mesh.vertices[mesh.faces]
    rows = np.concatenate([places, mesh.wedge_uv], axis=2).reshape(len(places), -1)
    return rows[np.lexsort(np.round(rows, 4).T)]


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
@pytest.mark.parametrize("textures", [1, 2])
def test_a_textured_mesh_comes_back_as_it_was(tmp_path, suffix, textures):
    mesh = _mesh(textures)
    files = write_mesh(tmp_path / f"strip{suffix}", mesh)
    assert all(file.is_file() for file in files)
    found, _ = read_mesh(tmp_path / f"strip{suffix}", unit="mm")
    assert_allclose(_corners(found), _corners(mesh), atol=2e-6)  # single precision in GLB
    assert len(found.textures) == textures
    sizes = {picture.shape: picture for picture in mesh.textures}
    for picture in found.textures:
        assert_allclose(picture, sizes[picture.shape], atol=0.5 / 255 + 1e-6)


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_another_library_reads_the_same_positions_and_picture(tmp_path, suffix):
    mesh = _mesh()
    write_mesh(tmp_path / f"strip{suffix}", mesh)
    found = trimesh.load(tmp_path / f"strip{suffix}", process=False, force="mesh")
    order = np.lexsort(np.round(found.triangles_center, 5).T)
    expected = mesh.vertices[mesh.faces].mean(axis=1)
    assert_allclose(
        found.triangles_center[order],
        expected[np.lexsort(np.round(expected, 5).T)],
        atol=2e-6,
    )
    uv = found.visual.uv[found.faces]  # both libraries count v from below
    centre = {tuple(np.round(c, 4)): u for c, u in zip(expected, mesh.wedge_uv, strict=True)}
    for place, corners in zip(found.triangles_center, uv, strict=True):
        assert_allclose(corners, centre[tuple(np.round(place, 4))], atol=1e-6)
    material = found.visual.material
    image = material.image if suffix == ".obj" else material.baseColorTexture
    assert_allclose(np.asarray(image.convert("L")) / 255, mesh.textures[0], atol=0.5 / 255 + 1e-6)


def test_vertex_colours_come_back_at_every_corner(tmp_path):
    mesh = _coloured()
    write_mesh(tmp_path / "strip.ply", mesh)
    other = trimesh.load(tmp_path / "strip.ply", process=False)
    assert_allclose(other.visual.vertex_colors[other.faces, 0] / 255, mesh.corner_grey, atol=1e-6)
    assert_allclose(other.triangles, mesh.vertices[mesh.faces], atol=1e-6)
    found, report = read_mesh(tmp_path / "strip.ply", unit="mm")
    assert report.grey_source == "vertex colours"
    assert len(found.vertices) == 15


@pytest.mark.parametrize(
    ("unit", "factor"), [("um", 1000), ("cm", 0.1), ("m", 0.001), ("in", 1 / 25.4)]
)
@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_numbers_are_in_the_unit_that_is_asked_for(tmp_path, unit, factor, suffix):
    mesh = _mesh()
    write_mesh(tmp_path / f"strip{suffix}", mesh, unit=unit)
    raw = trimesh.load(tmp_path / f"strip{suffix}", process=False, force="mesh")
    assert_allclose(np.ptp(raw.vertices, axis=0), factor * np.ptp(mesh.vertices, axis=0), rtol=1e-6)
    found, _ = read_mesh(tmp_path / f"strip{suffix}", unit=unit)
    assert_allclose(_corners(found)[:, :3], _corners(mesh)[:, :3], atol=28 * 1e-6)


def test_small_objects_in_metres_keep_their_digits(tmp_path):
    mesh = _mesh()
    tiny = textured_mesh(
        mesh.vertices * 0.01, mesh.faces, mesh.wedge_uv, mesh.face_texture, mesh.textures, name="t"
    )
    write_mesh(tmp_path / "tiny.obj", tiny, unit="m")
    found, _ = read_mesh(tmp_path / "tiny.obj", unit="m")
    assert_allclose(_corners(found)[:, :3], _corners(tiny)[:, :3], atol=1e-7 * tiny.size)


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_the_same_mesh_gives_the_same_bytes(tmp_path, suffix):
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        write_mesh(tmp_path / folder / f"strip{suffix}", _mesh(2))
    for file in (tmp_path / "one").iterdir():
        assert file.read_bytes() == (tmp_path / "two" / file.name).read_bytes()


def test_a_png_is_read_by_another_library_with_its_levels():
    import cv2

    levels = np.random.default_rng(3).integers(0, 256, (37, 53)).astype(np.uint8)
    encoded = encode_grey_png((levels / np.float32(255)).astype(np.float32))
    decoded = cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(decoded, levels)


def test_what_a_format_cannot_hold_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"vertex colours only"):
        write_mesh(tmp_path / "strip.ply", _mesh())
    for suffix in (".obj", ".glb"):
        with pytest.raises(DataError, match=r"needs a texture"):
            write_mesh(tmp_path / f"strip{suffix}", _coloured())
    with pytest.raises(ConfigError, match=r"got strip\.stl"):
        write_mesh(tmp_path / "strip.stl", _mesh())
    with pytest.raises(ConfigError, match="got 'ft'"):
        write_mesh(tmp_path / "strip.obj", _mesh(), unit="ft")
