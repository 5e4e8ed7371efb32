import numpy as np
import pytest

from shapemorph.config import TargetConfig
from shapemorph.core.calibration import Target
from shapemorph.core.errors import DataError
from shapemorph.stages.calibrate import find_target, make_finder

BLANK = np.full((120, 160), 0.5, dtype=np.float32)


@pytest.mark.parametrize(
    ("kind", "points", "what"),
    [
        ("chessboard", 30, "no chessboard of 6 x 5 inner corners"),
        ("dots", 30, "no dots of 6 x 5 dots"),
        ("asymmetric_dots", 30, "no asymmetric dots of 6 x 5 dots"),
        ("charuco", 20, "no ChArUco board of 6 x 5 squares"),
    ],
)
def test_each_kind_has_its_points_and_says_what_was_not_found(kind, points, what):
    finder = make_finder(
        "t", TargetConfig(kind=kind, columns=6, rows=5, spacing=8.0, marker=6.0), None
    )
    assert len(finder.target.points) == points
    with pytest.raises(DataError, match=what):
        find_target(BLANK, finder, ())


def test_square_dots_count_as_discs_of_the_same_spread():
    config = TargetConfig(kind="points", points="t.csv", dot_diameter=3.0, dot_shape="square")
    finder = make_finder("t", config, Target("t", np.eye(4, 3)))
    # second moment about an axis: a^2 / 12 of a square, r^2 / 4 of a disc
    assert finder.target.dot_radius**2 / 4 == pytest.approx(3.0**2 / 12)


def test_an_anchor_must_name_a_point_of_the_target():
    lattice = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    config = TargetConfig(kind="points", points="t.csv")
    finder = make_finder("t", config, Target("t", np.eye(4, 3), lattice=lattice))
    with pytest.raises(DataError, match="no point in row 5, column 1"):
        find_target(BLANK, finder, [(5, 1, 10.0, 10.0)])
