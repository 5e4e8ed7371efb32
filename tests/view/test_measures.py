import pytest

from shapemorph.io.quantities import QUANTITIES
from shapemorph.view.measures import FURTHER_MEASURES, MEASURES, ON_REQUEST, measure_of

EVERY = (*MEASURES, *FURTHER_MEASURES, *ON_REQUEST)


def test_every_measure_is_an_array_of_the_result_with_the_same_unit():
    units = {quantity.name: quantity.unit for quantity in QUANTITIES}
    for measure in EVERY:
        array = "displacement" if measure.key.startswith("displacement_") else measure.key
        assert units[array] == measure.unit.replace("–", "1"), measure.key


def test_names_tell_measures_apart():
    assert len({measure.key for measure in EVERY}) == len(EVERY)
    assert len({measure.title for measure in EVERY}) == len(EVERY)


@pytest.mark.parametrize(
    ("array", "title"),
    [
        ("E1", "Larger principal Green–Lagrange strain E₁"),
        ("u", "Displacement u"),
        ("displacement", "Length of displacement |d|"),
        ("area_ratio", "Ratio of areas J"),
    ],
)
def test_a_measure_is_found_by_its_array(array, title):
    assert measure_of(array).title == title


def test_what_has_no_measure_has_none():
    assert measure_of("iterations") is None
