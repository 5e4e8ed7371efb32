"""One door: what is asked for is made, what is unsound is replaced and said."""

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.methods.distortion import singular_values
from shapemorph.methods.parametrize import automatic
from shapemorph.methods.parametrize.choice import FREE, PROJECTIONS, lay_flat, place
from shapemorph.methods.parametrize.disk import cut_piece


def lay(points, faces, method, **given):
    options = {
        "axis": None,
        "centre": None,
        "projection": "equidistant",
        "meridian": None,
        "most_lost": 0.005,
        "most_anisotropy": 2.0,
        "most_reduced": 4.0,
    }
    return lay_flat(points, faces, name="part.obj", method=method, **(options | given))


@pytest.mark.parametrize("method", [*FREE, *PROJECTIONS, "auto"])
def test_every_method_lays_a_shallow_shell_flat_without_folds(pipe, anywhere, method):
    points, faces, _, _ = pipe(1.2, rows=15, cols=20)
    space = anywhere(points * [1.0, 1.0, 0.6], 12.0)
    flattening, why = lay(space, faces, method)
    assert flattening.method == ("bff" if method == "auto" else method)
    assert flattening.flips == 0
    assert why.endswith("as asked") == (method != "auto")
    piece = cut_piece(space, faces, name="part.obj")
    lot = lay(space[piece.vertex_ids], piece.faces, method)[0]
    stretch = singular_values(space[piece.vertex_ids], piece.faces, place(space, piece, lot))
    assert np.median(np.sqrt(stretch.sigma_1 * stretch.sigma_2)) == pytest.approx(1.0, abs=0.12)


def test_a_deep_pocket_that_a_conformal_map_shows_too_small_gets_the_even_map(ball_cap, anywhere):
    points, faces, _ = ball_cap(np.pi - 0.25, count=40)
    flattening, why = lay(anywhere(points, 9.0), faces, "auto", most_anisotropy=6.0)
    assert flattening.method == "slim"
    assert flattening.reduced < 4.0
    assert "not taken: boundary-first map" in why
    assert "least-squares" not in why  # as conformal, hence not tried


def test_large_meshes_are_not_given_to_the_slow_map(ball_cap, monkeypatch):
    points, faces, _ = ball_cap(np.pi - 0.25, count=20)
    monkeypatch.setattr(automatic, "MOST_SLIM_FACES", len(faces) - 1)
    flattening, why = lay(points, faces, "auto")
    assert flattening.method in ("bff", "harmonic")
    assert "not tried on more than" in why
    assert "none is sound" in why


def test_flips_of_an_asked_method_are_counted_in_the_reason(ball_cap):
    points, faces, _ = ball_cap(2.4, count=20)
    flattening, why = lay(points, faces, "orthographic", axis=np.array([0.0, 0.0, 1.0]))
    assert flattening.flips > 100
    assert f"{flattening.flips} flipped triangles" in why


def test_a_meridian_that_does_not_fit_is_replaced_and_the_reason_says_so(revolve, anywhere):
    points, faces, _, _ = revolve(lambda way: (way, 1.0 - 0.9 * way**2), 24)
    space = anywhere(points, 20.0)
    r = np.linspace(0, 20, 50)
    fitting = np.stack([r, 18 * (r / 20) ** 2], axis=1)
    assert "by the given meridian, as asked" in lay(space, faces, "profile", meridian=fitting)[1]
    spiral = np.stack([10 + 9 * np.cos(r), 9 * np.sin(r)], axis=1)
    flattening, why = lay(space, faces, "profile", meridian=spiral)
    assert "the given one does not fit it" in why
    assert flattening.flips == 0


@pytest.mark.parametrize("method", [*FREE, "auto", "spherical", "cylindrical", "profile"])
def test_a_closed_surface_is_refused_with_advice(method):
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    with pytest.raises(DataError, match=r"part\.obj: expected a surface with a border"):
        lay(corners, faces, method)


def test_the_meridian_of_the_deformed_shape_is_not_forced_on_a_flat_reference(revolve, anywhere):
    points, faces, _, _ = revolve(lambda way: (way, 0 * way), 24)
    polar = np.linspace(0, 1.5, 60)
    cap = np.stack([0.6 * np.sin(polar), 0.6 * np.cos(polar)], axis=1)
    flattening, why = lay(anywhere(points, 20.0), faces, "profile", meridian=20 * cap)
    assert "the given one does not fit it" in why
    assert flattening.anisotropy == pytest.approx(1.0, abs=1e-6)
