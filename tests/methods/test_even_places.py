"""Where a texture lies as one even sheet under the pixels of a flattened picture."""

import numpy as np
import pytest

from shapemorph.kernels.raster import rasterise
from shapemorph.methods.even_places import REACH, UNEVEN, even_slopes

SLOPE = np.array([[2.3, 0.4], [-0.3, 1.7]])  # texels per px
SIZE = 24


def sheet(turned=0.0):
    """Triangles of 1.5 px over a square, and the texel at each of their corners."""
    at = np.arange(0.0, SIZE + 1.5, 1.5)
    x, y = np.meshgrid(at, at)
    vertices = np.column_stack([x.ravel(), y.ravel()])
    first = (np.arange(len(at) - 1)[:, None] * len(at) + np.arange(len(at) - 1)).ravel()
    right, below = first + 1, first + len(at)
    faces = np.concatenate(
        [np.stack([first, right, below], 1), np.stack([right, below + 1, below], 1)]
    )
    texels = vertices @ SLOPE.T + [100.0, 50.0]
    texels[:, 0] += turned * vertices[:, 0] ** 2
    return vertices, faces, texels[faces]


def slopes(vertices, faces, corners, textures):
    triangle, barycentric, _ = rasterise(vertices, faces, 1.0, SIZE + 8, SIZE + 8)
    return triangle, even_slopes(triangle, barycentric, corners, textures)


def test_the_slope_of_an_even_sheet_is_found_up_to_its_rim():
    vertices, faces, corners = sheet()
    triangle, found = slopes(vertices, faces, corners, np.zeros(len(faces), dtype=np.int64))
    known = np.isfinite(found).all(axis=(-1, -2))
    whole = np.zeros_like(known)
    whole[REACH : SIZE + 1 - REACH, REACH : SIZE + 1 - REACH] = True
    np.testing.assert_array_equal(known, whole)
    np.testing.assert_allclose(found[known], np.broadcast_to(SLOPE, (known.sum(), 2, 2)), rtol=1e-5)
    assert (triangle[whole] >= 0).all()


@pytest.mark.parametrize("apart", ["in place", "in another texture"])
def test_no_slope_leads_over_a_seam(apart):
    vertices, faces, corners = sheet()
    beyond = vertices[faces].mean(axis=1)[:, 0] > 12.0
    textures = np.zeros(len(faces), dtype=np.int64)
    if apart == "in place":
        corners[beyond] += 3.0
    else:
        textures[beyond] = 1
    _triangle, found = slopes(vertices, faces, corners, textures)
    known = np.isfinite(found[..., 0, 0])[5:20]  # a pixel on the seam is of its right side
    assert not known[:, 12 - REACH : 12 + REACH].any()
    assert known[:, REACH : 12 - REACH].all()
    assert known[:, 12 + REACH : SIZE - REACH].all()


def test_a_sheet_that_bends_is_even_while_a_sample_strays_little():
    for bend, even in ((0.02, True), (0.5, False)):
        vertices, faces, corners = sheet(bend)
        _triangle, found = slopes(vertices, faces, corners, np.zeros(len(faces), dtype=np.int64))
        inside = np.isfinite(found[5:20, 5:20, 0, 0])
        # rms of bend * x^2 about its plane over 5 px is bend * sqrt(14/5)
        assert (bend * np.sqrt(2.8) < UNEVEN * np.sqrt(0.5 * (SLOPE**2).sum())) == even
        assert inside.all() if even else not inside.any()
