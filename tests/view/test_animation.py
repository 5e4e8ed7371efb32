import numpy as np
import pytest

from shapemorph.core.measurement import Measurement
from shapemorph.view.animation import COUNT, strain_film


@pytest.mark.render
def test_the_film_goes_from_the_reference_to_the_deformed_shape(results):
    film = strain_film(results.measurement)
    assert film.shape[0] == COUNT
    assert film.shape[1] % 2 == film.shape[2] % 2 == 0
    away = [np.mean(film[k] != film[0]) for k in range(COUNT)]
    assert away[-1] > 0.05
    assert away[-1] > away[COUNT // 2] > away[3] > 0
    assert (film[:, :90] == film[0, :90]).all()  # the heading stands still
    steps = [np.mean(film[k] != film[k + 1]) for k in range(COUNT - 1)]
    assert min(steps) > 0.001  # it moves all the time
    assert max(steps) < 0.2


def test_without_cells_there_is_no_film(results):
    none = np.zeros((0, 4), dtype=np.int64)
    bare = Measurement(results.measurement.reference, none, results.measurement.arrays)
    assert strain_film(bare) is None
