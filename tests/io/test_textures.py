"""UVs are brought into their pictures, and pictures without a pattern are refused."""

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.io.file_mesh import bare_mesh
from shapemorph.io.images import Picture
from shapemorph.io.textures import check_not_blank, into_pictures

HEIGHT, WIDTH = 8, 12
PATTERN = np.random.default_rng(0).random((HEIGHT, WIDTH), dtype=np.float32)
OBLIQUE = np.array([[0.1, 0.2], [0.8, 0.3], [0.35, 0.9]])


def mesh_with(uv, *, wrap="repeat", textures=(PATTERN,), face_texture=None):
    uv = np.asarray(uv, dtype=float).reshape(-1, 3, 2)
    count = len(uv)
    faces = np.arange(3 * count).reshape(-1, 3)
    vertices = np.random.default_rng(1).random((3 * count, 3))
    rows = np.zeros(count, dtype=np.int64) if face_texture is None else np.array(face_texture)
    pictures = [Picture(grey, np.ones(grey.shape, bool), ()) for grey in textures]
    return bare_mesh(vertices, faces, file_format="OBJ").textured(uv, rows, pictures, wrap)


def moved_by(*offset):
    return np.add(OBLIQUE, offset)


def texel(texture, uv):
    """Nearest grey at UV inside the picture."""
    height, width = texture.shape
    column = np.clip((uv[..., 0] * width).astype(int), 0, width - 1)
    row = np.clip(((1 - uv[..., 1]) * height).astype(int), 0, height - 1)
    return texture[row, column]


def repeated(uv, wrap):
    """Nearest grey of the pattern that goes on for ever."""
    place = uv % 1.0 if wrap == "repeat" else 1 - np.abs(uv % 2.0 - 1)
    return texel(PATTERN, place)


def inner_points(uv, count=400):
    weights = np.random.default_rng(3).dirichlet([1, 1, 1], count)
    return np.einsum("sk,fkc->fsc", weights, uv)


def test_uv_inside_are_left_alone():
    mesh = mesh_with([OBLIQUE, 1 - OBLIQUE])
    inside = into_pictures(mesh, "m")
    np.testing.assert_array_equal(inside.wedge_uv, mesh.wedge_uv)
    assert inside.notes == ()


def test_less_than_half_a_texel_beyond_the_border_is_rounding():
    mesh = mesh_with([[[-0.03, 0.0], [1.0, 1.05], [0.0, 1.0]]])
    inside = into_pictures(mesh, "m")
    np.testing.assert_array_equal(inside.wedge_uv[0], [[0, 0], [1, 1], [0, 1]])
    assert inside.notes == ()


@pytest.mark.parametrize("wrap", ["repeat", "mirror"])
def test_faces_beyond_the_picture_show_what_the_endless_picture_shows(wrap):
    uv = np.stack([OBLIQUE, moved_by(3, -2), moved_by(0.6, 0.4), OBLIQUE * 2.3 - [1.7, 5.2]])
    moved = into_pictures(mesh_with(uv, wrap=wrap), "m")
    assert moved.wedge_uv.min() >= 0.0
    assert moved.wedge_uv.max() <= 1.0
    assert f"3 faces have UVs outside [0, 1]: the texture is taken to {wrap}" in moved.notes[0]
    expected = repeated(inner_points(uv), wrap)
    got = texel(moved.textures[0], inner_points(moved.wedge_uv))
    # Points on the border between two texels may fall on either side.
    assert np.mean(got == expected) > 0.995


def test_only_the_picture_that_needs_it_is_continued():
    uv = np.stack([OBLIQUE, moved_by(0.5, 0)])
    moved = into_pictures(mesh_with(uv, textures=(PATTERN, PATTERN), face_texture=[0, 1]), "m")
    assert moved.textures[0] is PATTERN
    assert moved.textures[1].shape == (HEIGHT, int(np.ceil(1.3 * WIDTH - 0.5)))
    np.testing.assert_array_equal(moved.wedge_uv[0], uv[0])


def test_a_clamped_picture_ends_at_its_border():
    moved = into_pictures(mesh_with([moved_by(0.5, 0)], wrap="clamp"), "m")
    np.testing.assert_allclose(moved.wedge_uv[0, :, 0], [0.6, 1.0, 0.85])


@pytest.mark.parametrize(
    ("uv", "message"),
    [
        (OBLIQUE * 1e6, "near \\[0, 1\\], got 9e\\+05"),
        (OBLIQUE * np.inf, "near \\[0, 1\\], got inf"),
        (OBLIQUE * 9000, "a few repeats of the texture"),
    ],
)
def test_uv_that_no_repeat_explains_are_refused(uv, message):
    large = np.tile(PATTERN, (20, 20))
    with pytest.raises(DataError, match=message):
        into_pictures(mesh_with([uv], textures=(large,)), "m")


def test_a_pattern_anywhere_on_the_surface_is_enough():
    half = np.full((400, 300), 0.5, dtype=np.float32)
    half[:, :20] = np.random.default_rng(0).random((400, 20))
    check_not_blank(mesh_with([[[0, 0], [1, 0], [0, 1]]], textures=(half,)), "m")


def test_a_picture_that_is_blank_where_the_surface_uses_it_is_refused():
    half = np.full((400, 300), 0.5, dtype=np.float32)
    half[:, :20] = np.random.default_rng(0).random((400, 20))
    mesh = mesh_with([[[0.2, 0], [1, 0], [0.2, 1]]], textures=(half,))
    with pytest.raises(DataError, match=r"m: expected a pattern .* blank texture"):
        check_not_blank(mesh, "m")


def test_uniform_vertex_colours_are_refused():
    mesh = bare_mesh(np.eye(3), np.array([[0, 1, 2]]), file_format="PLY")
    with pytest.raises(DataError, match="blank vertex colours"):
        check_not_blank(mesh.coloured(np.full((1, 3), 0.7)), "m")
