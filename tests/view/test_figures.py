import ctypes.util
import dataclasses
import sys

import numpy as np
import pytest
from PIL import Image

from shapemorph.core.image import GreyImage
from shapemorph.core.measurement import Measurement
from shapemorph.view.captions import CAPTIONS
from shapemorph.view.drawing_process import DrawingProcess
from shapemorph.view.figures import (
    correlation_figures,
    encoded,
    flattening_figures,
    histogram_figures,
    matching_figures,
    morph_figures,
    write_pictures,
)
from shapemorph.view.maps import grid_extent, surface_distortion_figure
from shapemorph.view.measures import MEASURES, measure_values
from shapemorph.view.plots import even_selection
from shapemorph.view.shapes import (
    deformed_figures,
    reference_figures,
    shape_figures,
    shapes_of,
    with_small_textures,
)

NO_GL = sys.platform.startswith("linux") and not all(
    ctypes.util.find_library(name) for name in ("EGL", "GL")
)


@pytest.fixture(scope="module")
def drawn(results, tmp_path_factory):
    if NO_GL:
        pytest.skip("libEGL or libGL is missing: `make setup` says how")
    folder = tmp_path_factory.mktemp("run") / "figures"
    write_pictures(_flat(results), folder)
    with DrawingProcess() as process:
        process.draw_in_scene(reference_figures, results.reference_mesh)
        process.draw_in_scene(deformed_figures, results.deformed_mesh)
        process.draw_in_scene(shape_figures, shapes_of(results))
        write_pictures(process.finish(), folder)
    return sorted(folder.iterdir())


@pytest.mark.render
def test_every_figure_has_a_caption_and_shows_something(drawn):
    assert {path.stem for path in drawn} == set(CAPTIONS)
    for path in drawn:
        with Image.open(path) as image:
            pixels = np.asarray(image.convert("L"))
        assert pixels.shape[1] >= 800, path.name
        assert (pixels[:, -4:] == 255).all(), f"{path.name}: something is cut off"
        assert np.count_nonzero(pixels < 200) > 5000, path.name


def _flat(results):
    yield from encoded(flattening_figures(results.pair))
    reference, deformed = (
        side.calibrated.image for side in (results.pair.reference, results.pair.deformed)
    )
    yield from encoded(matching_figures(reference, deformed, results.matches))
    yield from encoded(morph_figures(reference, results.morphed))
    yield from encoded(correlation_figures(reference, results.grid))
    yield from encoded(histogram_figures(results.measurement))


def test_flat_figures_need_no_cells(results):
    bare = dataclasses.replace(results, measurement=_bare(results))
    assert {name for name, _ in _flat(bare)} == {
        "histograms",
        "matches",
        "morph",
        "correlation",
        "flattening",
    }


def test_a_measurement_without_cells_has_no_shapes_to_draw(results):
    bare = dataclasses.replace(results, measurement=_bare(results))
    assert list(shape_figures(shapes_of(bare), scene=None)) == []


def _bare(results):
    whole = results.measurement
    return Measurement(whole.reference, np.zeros((0, 4), dtype=np.int64), whole.arrays)


def test_measures_are_the_columns_of_the_displacement_and_its_length(results):
    values = {m.key: measure_values(results.measurement, m) for m in MEASURES}
    d = results.measurement.arrays["displacement"]
    assert np.array_equal(values["displacement_w"], d[:, 2], equal_nan=True)
    squares = sum(values[f"displacement_{axis}"] ** 2 for axis in "uvw")
    np.testing.assert_allclose(values["displacement"], np.sqrt(squares), rtol=1e-12)


def test_cells_of_a_map_are_centred_on_their_points(results):
    left, right, bottom, top = grid_extent(results.grid)
    rows, columns = results.grid.status.shape
    assert (left, top) == (4.0, 4.0)  # first point at 8, spacing 8
    assert (right - left) / columns == (bottom - top) / rows == 8.0


def test_even_selection_takes_one_point_of_each_box():
    x, y = np.meshgrid(np.arange(30.0), np.arange(20.0))
    chosen = even_selection(np.stack([x.ravel(), y.ravel()], -1), 5)
    assert len(chosen) == 25
    assert len(np.unique(chosen)) == 25


def test_long_pictures_are_shown_below_each_other(results):
    def stretched(times):
        surface = results.pair.reference
        triangle = np.tile(surface.calibrated.triangle, (1, times))
        wide = dataclasses.replace(
            surface.calibrated,
            image=GreyImage(np.ones(triangle.shape, np.float32), triangle >= 0),
            triangle=triangle,
            barycentric=np.tile(surface.calibrated.barycentric, (1, times, 1)),
        )
        return surface_distortion_figure("plate", dataclasses.replace(surface, calibrated=wide))

    def corners(figure):
        maps = [axes.get_position() for axes in figure.axes if axes.get_images()]
        return [(box.x0, box.y0) for box in maps if box.width > 0.2]

    (left, top), (right, level) = corners(stretched(1))
    assert (right > left, level) == (True, pytest.approx(top))
    (left, top), (below, lower) = corners(stretched(4))
    assert (lower < top, below) == (True, pytest.approx(left))


def test_large_textures_shrink_before_they_are_passed_on(results):
    mesh = dataclasses.replace(
        results.reference_mesh, textures=(np.ones((5000, 4100), np.float32),)
    )
    (small,) = with_small_textures(mesh).textures
    assert small.shape == (1666, 1366)
    assert (small == 1).all()
    (same,) = with_small_textures(results.reference_mesh).textures
    np.testing.assert_array_equal(same, results.reference_mesh.textures[0])
