from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from shapemorph.view.tracked import fields_figure, write_tracked_figures


@pytest.fixture
def measurement(results):
    """The points whose status is not that of the surroundings, in the order of the grid."""
    rows = np.flatnonzero(results.grid.status.ravel() != 1)
    whole = results.measurement
    arrays = {name: values[rows] for name, values in whole.arrays.items()}
    return replace(
        whole,
        reference=whole.reference[rows],
        cells=whole.cells[:0],
        arrays=arrays,
        grid_index=rows,
    )


def test_the_figures_of_a_tracked_grid_need_no_opengl(results, measurement, tmp_path):
    first = results.pair.reference.calibrated.image
    write_tracked_figures(measurement, results.grid, first, tmp_path / "new")
    names = sorted(path.name for path in (tmp_path / "new").iterdir())
    assert names == ["correlation.png", "fields.png", "histograms.png"]
    for name in names:
        assert len(Image.open(tmp_path / "new" / name).convert("RGB").getcolors(1 << 20)) > 200


def test_every_value_stands_where_its_point_lies(results, measurement):
    figure = fields_figure(measurement, results.grid, results.pair.reference.calibrated.image)
    maps = [axes.images[1] for axes in figure.axes if len(axes.images) == 2]
    assert len(maps) == 6
    shown = np.ma.filled(maps[2].get_array(), np.nan)
    known = np.isfinite(measurement.arrays["displacement"][:, 2])
    row, column = np.unravel_index(measurement.grid_index[known], shown.shape)
    assert np.array_equal(shown[row, column], measurement.arrays["displacement"][known, 2])
    assert np.isfinite(shown).sum() == known.sum()
