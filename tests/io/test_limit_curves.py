import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.io.limit_curves import read_limit_curve


def written(tmp_path, text):
    path = tmp_path / "curve.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_curve_comes_with_the_conditions_that_it_states(tmp_path):
    text = "# material: DC04\n# Thickness: 0.8 mm\n\neps2,eps1\n-0.2, 0.5\n0,0.3\n# end\n0.3,0.45\n"
    curve = read_limit_curve(written(tmp_path, text))
    np.testing.assert_array_equal(curve.minor, [-0.2, 0, 0.3])
    np.testing.assert_array_equal(curve.major, [0.5, 0.3, 0.45])
    assert curve.conditions == {"material": "DC04", "thickness": "0.8 mm"}


def test_engineering_strains_become_true_strains(tmp_path):
    text = "# measure: engineering\neps2,eps1\n-0.2,0.5\n0.1,0.3\n"
    curve = read_limit_curve(written(tmp_path, text))
    np.testing.assert_allclose(curve.minor, np.log([0.8, 1.1]))
    np.testing.assert_allclose(curve.major, np.log([1.5, 1.3]))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n0,1\n1,2\n", "expected the header eps2,eps1"),
        ("\n", "got nothing"),
        ("eps2,eps1\n0,0.3\n0.1,x\n", "line 3: expected two numbers"),
        ("eps2,eps1\n0,0.3\n", "2 points or more, got 1"),
        ("eps2,eps1\n0.1,0.3\n0,0.3\n", "must rise"),
        ("# measure: Green\neps2,eps1\n0,0.3\n1,0.3\n", "expected measure hencky or engineering"),
        ("# measure: engineering\neps2,eps1\n-1.5,0.3\n1,0.3\n", "above -1"),
    ],
)
def test_what_is_no_curve_is_refused_with_its_name(tmp_path, text, message):
    with pytest.raises(DataError, match=message) as caught:
        read_limit_curve(written(tmp_path, text))
    assert "curve.csv" in str(caught.value)


def test_a_missing_file_is_an_error_of_data(tmp_path):
    with pytest.raises(DataError, match="limit curve"):
        read_limit_curve(tmp_path / "none.csv")
